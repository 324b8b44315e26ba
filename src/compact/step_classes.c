/* SPDX-License-Identifier: MIT
 *
 * Classes of steps: what can happen at the end of a segment.
 */
#include "compact/step_classes.h"

#include "base/alloc.h"

enum { FIRST_SLOTS = 256 };

static void place(struct rmap_step_classes *classes, uint32_t number)
{
    size_t s = rmap_step_class_home(classes, &classes->of[number]);
    while (classes->slot[s] > 0)
        s = (s + 1) & (classes->n_slot - 1);
    classes->slot[s] = number + 1;
}

static enum rmap_status widen(struct rmap_step_classes *classes, struct rmap_error *err)
{
    const size_t n_slot = classes->n_slot > 0 ? 2 * classes->n_slot : FIRST_SLOTS;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu classes of steps", n_slot);
    rmap_free(classes->slot);
    classes->slot = slot;
    classes->n_slot = n_slot;
    for (size_t i = 0; i < classes->n; i++)
        place(classes, (uint32_t)i);
    return RMAP_OK;
}

enum rmap_status rmap_step_class_enter(struct rmap_step_classes *classes,
                                       const struct rmap_step_class *step, uint32_t *number_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *number_ret = rmap_step_class_find(classes, step);
    if (*number_ret != RMAP_NO_STEP_CLASS)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(classes->of, classes->cap, classes->n + 1, err));
    if (2 * (classes->n + 1) > classes->n_slot)
        RMAP_TRY(widen(classes, err));
    classes->of[classes->n] = *step;
    *number_ret = (uint32_t)classes->n++;
    place(classes, *number_ret);
out:
    return st;
}

void rmap_step_classes_fini(struct rmap_step_classes *classes)
{
    rmap_free(classes->of);
    rmap_free(classes->slot);
    *classes = (struct rmap_step_classes){0};
}
