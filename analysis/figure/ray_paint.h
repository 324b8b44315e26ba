/* SPDX-License-Identifier: MIT
 *
 * Which ink each ray of a picture has: that of its light, or that of a group of rays (a path, a
 * criterion, an order), with what a legend says of the groups.
 */
#ifndef RMAP_RAY_PAINT_H
#define RMAP_RAY_PAINT_H

#include "analysis/criterion/criterion.h"
#include "analysis/paths/path_key.h"
#include "portion/portion.h"
#include "scene/scene.h"

enum rmap_paint_kind {
    RMAP_PAINT_NATURAL,   /* no groups */
    RMAP_PAINT_PATH,      /* classes of paths, those with most flux, and the others */
    RMAP_PAINT_CRITERION, /* the first of some criteria that the ray matches */
    RMAP_PAINT_ORDER,     /* ghost order of rays that were never scattered; scattered ones */
    RMAP_PAINT_KIND_COUNT
};

/* "natural", "path", "criterion", "order". */
const char *rmap_paint_word(enum rmap_paint_kind kind);

struct rmap_paint_group {
    char ink[8];
    const char *dash; /* of a stroke; NULL: solid */
    char *label;
    bool asked;        /* a criterion: it stands in the legend also with no ray */
    uint64_t rays;     /* that are drawn */
    uint64_t matching; /* set by who knows: the criterion's in the whole map */
    double flux;
};

struct rmap_ray_paint {
    enum rmap_paint_kind kind;
    size_t n_group;
    struct rmap_paint_group *group; /* [n_group] */
    uint32_t *of_ray;               /* [n_ray] group of each; NULL without groups */
    double *strength;               /* [n_ray] flux over the greatest of any, 0 to 1 */
    double flux;                    /* of all of them */
    const char *note;               /* how paths are told apart, where coarsely; or NULL */
    bool dealt; /* groups share the rays between them: their fluxes say nothing of the map's */
};

/* What paints the rays of a portion that has all columns. flux_per_weight: [n_source]. criterion:
 * [n_criterion], for that kind alone. */
struct rmap_paint_request {
    enum rmap_paint_kind kind;
    const enum rmap_path_level *level; /* of PATH; NULL: as fine as leaves several rays in most */
    const struct rmap_scene *scene;
    const struct rmap_portion *rays;
    const double *flux_per_weight;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion;
};
enum rmap_status rmap_ray_paint_create(const struct rmap_paint_request *request,
                                       struct rmap_ray_paint **paint_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_paint_destroy(struct rmap_ray_paint *paint); /* NULL is fine */

#endif
