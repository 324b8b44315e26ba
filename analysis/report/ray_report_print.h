/* SPDX-License-Identifier: MIT
 *
 * A ray as a table for people, and as JSON.
 */
#ifndef RMAP_RAY_REPORT_PRINT_H
#define RMAP_RAY_REPORT_PRINT_H

#include "analysis/report/ray_report.h"

/* The text: who the ray was, what happened, and where. */
enum rmap_status rmap_ray_report_print(const struct rmap_ray_report *report, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* The same as a JSON object (new reference); NULL when memory is short. */
json_t *rmap_ray_report_json(const struct rmap_ray_report *report);

#endif
