/* SPDX-License-Identifier: MIT
 *
 * Classes of steps: what can happen at the end of a segment. A piece's are those of the paths of
 * its dictionary, numbered in the order in which they first appear there.
 */
#ifndef RMAP_COMPACT_STEP_CLASSES_H
#define RMAP_COMPACT_STEP_CLASSES_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_step_class {
    int32_t object; /* -1: none */
    uint32_t event; /* bits */
    int32_t medium; /* as the path says */
};

/* Zero it at first. */
struct rmap_step_classes {
    struct rmap_step_class *of; /* [n] */
    size_t n, cap;
    uint32_t *slot; /* [n_slot], 1 + class; 0: free */
    size_t n_slot;
};

#define RMAP_NO_STEP_CLASS UINT32_MAX

/* Its number, or RMAP_NO_STEP_CLASS. */
uint32_t rmap_step_class_find(const struct rmap_step_classes *classes,
                              const struct rmap_step_class *step);

/* Its number; a new one is added. RMAP_SYSTEM. */
enum rmap_status rmap_step_class_enter(struct rmap_step_classes *classes,
                                       const struct rmap_step_class *step, uint32_t *number_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_step_classes_fini(struct rmap_step_classes *classes);

#endif
