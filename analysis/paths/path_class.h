/* SPDX-License-Identifier: MIT
 *
 * Classes of the rays of a portion in memory: those of one source with one path (path_key.h). For
 * pictures and pages of some thousand rays; a whole map goes through path_count.h.
 */
#ifndef RMAP_PATH_CLASS_H
#define RMAP_PATH_CLASS_H

#include "analysis/paths/path_key.h"

struct rmap_path_class {
    int32_t source;
    uint64_t rays, segments;
    uint64_t first_ray; /* smallest id */
    size_t first_row;   /* of that ray in /ray of the portion */
    double flux;
    size_t first_symbol, n_symbol; /* of the classes' */
};

#define RMAP_PATH_NO_CLASS UINT32_MAX

struct rmap_path_classes {
    struct rmap_path_keys *keys;
    size_t n;
    struct rmap_path_class *path; /* [n] most flux first, then smallest id */
    uint32_t *of_ray;             /* [n_ray] index of the ray's class, or RMAP_PATH_NO_CLASS */
    rmap_path_step *symbol;
};

/* Of all rays of a portion that has rmap_path_keys_columns and weights. flux_per_weight:
 * [n_source]; the scene is borrowed. */
enum rmap_status rmap_path_classes_create(const struct rmap_scene *scene,
                                          const struct rmap_path_view *view,
                                          const struct rmap_portion *portion,
                                          const double *flux_per_weight,
                                          struct rmap_path_classes **classes_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_classes_destroy(struct rmap_path_classes *classes);

/* "lamp: T@lens.1 R@lens.3 ... V@sensor", at most about most_nbytes (0: no matter); rmap_free. */
enum rmap_status rmap_path_class_label(const struct rmap_path_classes *classes, size_t index,
                                       size_t most_nbytes, char **text_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* The criterion of exactly this class among a map's rays, as rmap_path_key_criterion has it; of a
 * path too long for that `ray == ID` where it is of one ray, else NULL. rmap_free. */
enum rmap_status rmap_path_class_criterion(const struct rmap_path_classes *classes, size_t index,
                                           char **text_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
