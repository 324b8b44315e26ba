/* SPDX-License-Identifier: MIT */
#ifndef RMAP_COMPARE_INTERNAL_H
#define RMAP_COMPARE_INTERNAL_H

#include "analysis/compare/compare.h"

/* Names of one kind of things in a scene. */
struct rmap_names {
    const struct rmap_scene *scene;
    const char *what; /* "source" */
    size_t n;
    const char *(*name)(const struct rmap_scene *scene, size_t i);
};
struct rmap_names rmap_names_of_sources(const struct rmap_scene *scene);
struct rmap_names rmap_names_of_detectors(const struct rmap_scene *scene);
struct rmap_names rmap_names_of_objects(const struct rmap_scene *scene);
struct rmap_names rmap_names_of_media(const struct rmap_scene *scene);

/* (*pair_ret)[i]: index of name i among those of `other`, or -1. rmap_free. RMAP_SYSTEM. */
enum rmap_status rmap_names_pair(const struct rmap_names *own, const struct rmap_names *other,
                                 int32_t **pair_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Appends an empty test, valid until the next one. */
enum rmap_status rmap_comparison_test(struct rmap_comparison *self, enum rmap_compare_kind kind,
                                      const char *name, struct rmap_compare_test **test_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Registrations of the rays that both samples hold (NULL: they hold none) count in both, though
 * they are not tested. */
void rmap_compare_count_both(const struct rmap_compare_sums *sums, size_t detector,
                             struct rmap_chi_square *result);

#endif
