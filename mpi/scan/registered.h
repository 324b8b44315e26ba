/* SPDX-License-Identifier: MIT
 *
 * What detectors registered of the rays that match, beside how many these are: the registrations
 * that the criterion itself chooses (analysis/query/which.h).
 */
#ifndef RMAP_REGISTERED_H
#define RMAP_REGISTERED_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/overlay/overlay.h"
#include "analysis/query/query.h"
#include "analysis/query/which.h"
#include "mpi/command/command.h"

/* On one detector. */
struct rmap_registered {
    const char *detector; /* borrowed from the scene */
    struct rmap_which *which;
    double registrations; /* sum of weights */
    double flux, standard_error;
};

struct rmap_registered_list {
    size_t n;
    bool is_counted; /* the rays, too */
    struct rmap_registered *item;
    const char *unit; /* of flux */
};

/* Collective. On rank 0 the detectors that conjuncts registered(...) of the criterion name: with a
 * region or a condition, or (bare) also without. None: nothing is read. overlay: receivers, or
 * NULL. count: NULL, or zero, and rank 0's of the rays that match, where registrations are chosen
 * among theirs: what tells which match is found once then. list: rmap_registered_fini whatever
 * happened. */
enum rmap_status rmap_registered_run(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_overlay *overlay,
                                     const struct rmap_criterion *criterion, bool bare,
                                     struct rmap_count *count, struct rmap_registered_list *list,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_registered_fini(struct rmap_registered_list *list);

/* An array of objects; new reference. */
json_t *rmap_registered_json(const struct rmap_registered_list *list);
void rmap_registered_print(const struct rmap_registered_list *list, FILE *out);

#endif
