/* SPDX-License-Identifier: MIT
 *
 * Classes of paths as a table for people, as JSON and as CSV.
 */
#ifndef RMAP_PATH_REPORT_OUT_H
#define RMAP_PATH_REPORT_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/paths/path_report.h"

/* For people; width: columns of the terminal, 0: no matter. */
enum rmap_status rmap_path_report_print(const struct rmap_path_report *report, size_t width,
                                        FILE *out, struct rmap_error *err) RMAP_MUST_USE;
/* New reference; NULL when memory is short. */
json_t *rmap_path_report_json(const struct rmap_path_report *report);
void rmap_path_report_csv(const struct rmap_path_report *report, FILE *out);

#endif
