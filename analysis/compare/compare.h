/* SPDX-License-Identifier: MIT
 *
 * A comparison of two samples of rays: tests of everything that can be named in both, corrected for
 * their number, and the outcome.
 */
#ifndef RMAP_COMPARE_H
#define RMAP_COMPARE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/compare/compare_overlap.h"
#include "analysis/compare/compare_sums.h"
#include "analysis/compare/difference.h"
#include "analysis/table/significance.h"

enum rmap_compare_kind {
    RMAP_COMPARE_FLUX,     /* of the matching rays: all, and per source */
    RMAP_COMPARE_DETECTOR, /* flux registered on each */
    RMAP_COMPARE_OBJECT,   /* flux absorbed by each */
    RMAP_COMPARE_MEDIUM,
    RMAP_COMPARE_STOP,
    RMAP_COMPARE_IMAGE, /* of each detector */
    RMAP_COMPARE_PATHS,
    RMAP_COMPARE_NUMBER, /* --of */
    RMAP_COMPARE_KIND_COUNT
};
extern const char *const rmap_compare_word[RMAP_COMPARE_KIND_COUNT + 1]; /* ends with NULL */

struct rmap_compare_test {
    enum rmap_compare_kind kind;
    char *name;   /* of what is compared; "" for the whole selection. Owned */
    bool is_bins; /* bins below; else scalar */
    struct rmap_difference scalar;
    struct rmap_chi_square bins;
    double p, adjusted; /* NaN: not tested */
    bool same;
    const char *note; /* why it was not tested; or NULL */
};

/* An image in which rays count several times: it needs a second look at the rays. */
struct rmap_compare_again {
    size_t detector[2]; /* in each map */
    int32_t *group;     /* [cells] merged bin or -1; owned */
    size_t n_group;
};

struct rmap_comparison {
    const struct rmap_map *map[2]; /* borrowed; the same one where two criteria are compared */
    const struct rmap_overlay *overlay[2]; /* borrowed; NULL: no receivers */
    const char *path[2];                   /* borrowed, for output; [1] may be NULL */
    const char *criterion[2];              /* borrowed; NULL: all rays */
    const struct rmap_which *which[2];     /* registrations that count, borrowed; NULL: all */
    struct rmap_strata strata;
    struct rmap_overlap overlap;
    struct rmap_compare_test *test; /* [n] in the order of kinds, then of names in the first map */
    size_t n, cap;
    struct rmap_compare_again *again; /* [n_again] */
    size_t n_again, cap_again;
    size_t n_empty; /* that neither sample has anything of: no tests */
    char **only[2]; /* names in one map alone: "object lens". Owned */
    size_t n_only[2], cap_only[2];
    double significance;
    enum rmap_correction correction;
    bool same;
    bool too_equal; /* distributions agree better than chance would have them agree */
};

/* The scene of map k, with receivers. */
static inline const struct rmap_scene *rmap_comparison_scene(const struct rmap_comparison *self,
                                                             int k)
{
    return rmap_scene_with(self->map[k], self->overlay[k]);
}

/* paths, criteria, overlays: as above. Two maps: their units of flux and at least one source's name
 * must agree, and neither may hold rays picked out of the same trace: RMAP_INPUT. One map: map[1]
 * is map[0]. */
enum rmap_status rmap_comparison_create(const struct rmap_map *const map[2],
                                        const struct rmap_overlay *const overlay[2],
                                        const char *const path[2], const char *const criterion[2],
                                        struct rmap_comparison **comparison_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_comparison_destroy(struct rmap_comparison *comparison); /* NULL is fine */

/* Tests of scalars and images. sums: of the first sample, of the second, of the rays in both
 * (NULL where two maps are compared; the others are then those of each alone). kinds: bit per
 * enum rmap_compare_kind; detector: the only one looked at; NULL: all. An image that rays count in
 * several times goes to `again`; rmap_comparison_add_products tests it. */
enum rmap_status rmap_comparison_add_sums(struct rmap_comparison *comparison,
                                          const struct rmap_compare_sums *const sums[3],
                                          unsigned kinds, const char *detector,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* both: sums of the rays that both samples hold, or NULL; products [2]: of the first two samples
 * above, for the images in `again`. */
struct rmap_compare_products;

/* Whether the cells of a detector in one scene are those of one in the other. */
bool rmap_compare_same_grid(const struct rmap_scene *const scene[2], const size_t detector[2]);

/* One more test. name is copied. */
enum rmap_status rmap_comparison_add_bins(struct rmap_comparison *comparison,
                                          enum rmap_compare_kind kind, const char *name,
                                          const struct rmap_chi_square *result, const char *note,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Corrects the p-values and decides. */
enum rmap_status rmap_comparison_conclude(struct rmap_comparison *comparison, double significance,
                                          enum rmap_correction correction,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
