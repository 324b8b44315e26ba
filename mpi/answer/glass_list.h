/* SPDX-License-Identifier: MIT
 *
 * Materials of the catalogue that are asked for: by patterns of their names, by nearness of nd and
 * vd, with numbers at wavelengths.
 */
#ifndef RMAP_GLASS_LIST_H
#define RMAP_GLASS_LIST_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"
#include "optics/catalogue.h"

enum { RMAP_GLASS_AT_MAX = 32 };

struct rmap_glass_request {
    char *const *pattern; /* [n_pattern]; none: every material */
    size_t n_pattern;
    size_t n_at; /* 0: 400 and 550 */
    double at_nm[RMAP_GLASS_AT_MAX];
    bool is_near; /* nearest first, `most` of them */
    double near_nd, near_vd;
    size_t most;
};

struct rmap_glass_list {
    size_t n;
    struct rmap_catalogue *place; /* [n] */
    double *distance;             /* [n], of nd and vd; NULL: not asked for */
};

/* How far nd and vd are from others, in what melts of one glass differ by: 0.001, and 1 %. */
double rmap_glass_distance(double nd, double vd, double other_nd, double other_vd);

/* RMAP_INPUT for a name, as opposed to a pattern, that no material has. */
enum rmap_status rmap_glass_list_make(const struct rmap_glass_request *request,
                                      struct rmap_glass_list *list,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_glass_list_fini(struct rmap_glass_list *list);

/* A line each; of a single one without `at`, its source and a table over wavelength. */
void rmap_glass_list_print(const struct rmap_glass_request *request,
                           const struct rmap_glass_list *list, FILE *out);
json_t *rmap_glass_list_json(const struct rmap_glass_request *request,
                             const struct rmap_glass_list *list);

#endif
