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

/* The slot where it is looked for first. Objects differ most; odd constants spread them over the
 * top bits. */
static inline size_t rmap_step_class_home(const struct rmap_step_classes *classes,
                                          const struct rmap_step_class *step)
{
    const uint64_t hash = (uint64_t)(uint32_t)step->object * UINT64_C(0x9e3779b97f4a7c15) ^
                          (uint64_t)step->event * UINT64_C(0xc2b2ae3d27d4eb4f) ^
                          (uint64_t)(uint32_t)step->medium * UINT64_C(0x165667b19e3779f9);
    return (size_t)(hash >> 32) & (classes->n_slot - 1);
}

/* Its number, or RMAP_NO_STEP_CLASS. */
static inline uint32_t rmap_step_class_find(const struct rmap_step_classes *classes,
                                            const struct rmap_step_class *step)
{
    if (classes->n == 0)
        return RMAP_NO_STEP_CLASS;
    for (size_t s = rmap_step_class_home(classes, step); classes->slot[s] > 0;
         s = (s + 1) & (classes->n_slot - 1)) {
        const struct rmap_step_class *known = &classes->of[classes->slot[s] - 1];
        if (known->object == step->object && known->event == step->event &&
            known->medium == step->medium)
            return classes->slot[s] - 1;
    }
    return RMAP_NO_STEP_CLASS;
}

/* Its number; a new one is added. RMAP_SYSTEM. */
enum rmap_status rmap_step_class_enter(struct rmap_step_classes *classes,
                                       const struct rmap_step_class *step, uint32_t *number_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_step_classes_fini(struct rmap_step_classes *classes);

#endif
