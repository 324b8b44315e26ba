/* SPDX-License-Identifier: MIT
 *
 * Fields of CSV (RFC 4180): texts stand in quotes where they must, with a comma, a quote or a
 * line's end in them; NULL is an empty text.
 */
#ifndef RMAP_CSV_FIELD_H
#define RMAP_CSV_FIELD_H

#include <stdbool.h>
#include <stdio.h>

/* Behind a comma; and without, as the first of a line. */
void rmap_csv_put_text(const char *text, FILE *out);
void rmap_csv_put_first(const char *text, FILE *out);

/* For a field of several texts: must this one stand in quotes, and what it is between them. */
bool rmap_csv_needs_quotes(const char *text);
void rmap_csv_put_inside(const char *text, FILE *out);

/* Behind a comma: 17 digits; empty for what is no number. */
void rmap_csv_put_number(double value, FILE *out);

/* A value with 10 digits and its standard error with 7, two fields: what is rounded off is far
 * below any error. */
void rmap_csv_put_estimate(double value, double standard_error, FILE *out);

#endif
