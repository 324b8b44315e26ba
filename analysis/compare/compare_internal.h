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

/* Registrations of the rays that both samples hold (NULL: they hold none) count in both, though
 * they are not tested. */
void rmap_compare_count_both(const struct rmap_compare_sums *sums, size_t detector,
                             struct rmap_chi_square *result);

#endif
