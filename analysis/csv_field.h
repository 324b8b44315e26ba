/* SPDX-License-Identifier: MIT
 *
 * Fields of CSV (RFC 4180), each behind a comma.
 */
#ifndef RMAP_CSV_FIELD_H
#define RMAP_CSV_FIELD_H

#include <stdio.h>

/* In quotes; NULL is "". */
void rmap_csv_put_text(const char *text, FILE *out);

/* 17 digits; empty for what is no number. */
void rmap_csv_put_number(double value, FILE *out);

#endif
