/* SPDX-License-Identifier: MIT
 *
 * The paths that carried most light, as a page lists them: counted over a whole map, or estimated
 * from some of its rays.
 */
#ifndef RMAP_REPORT_PATHS_H
#define RMAP_REPORT_PATHS_H

#include "analysis/paths/path_report.h"

/* Texts are owned. */
struct rmap_report_path {
    char *text;      /* "lamp: T@lens.1 R@lens.3" */
    char *criterion; /* that selects it; NULL: none does */
    double rays, flux, flux_error, share;
    uint64_t first_ray;
};

struct rmap_report_paths {
    size_t n, n_class; /* listed; found in all */
    struct rmap_report_path *path;
    double rest_flux, rest_share; /* of those not listed */
    char note[512];               /* which rays these are of, and what is not exact; or "" */
};

/* As `raymap paths` counted them. */
enum rmap_status rmap_report_paths_of(const struct rmap_path_report *report,
                                      struct rmap_report_paths **paths_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Of the first rays of a map alone [portion: all columns]: source s carries its whole flux, spread
 * over those of its rays that are there. At most `top` are listed. */
enum rmap_status rmap_report_paths_sampled(const struct rmap_map *map,
                                           const struct rmap_portion *rays, size_t top,
                                           struct rmap_report_paths **paths_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_report_paths_destroy(struct rmap_report_paths *paths); /* NULL is fine */

#endif
