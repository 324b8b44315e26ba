/* SPDX-License-Identifier: MIT */
#include "mpi/find_detector.h"

#include <string.h>

#include "base/alloc.h"
#include "io/diagnostics.h"

enum rmap_status rmap_find_detector(const struct rmap_scene *scene, const char *name,
                                    int32_t *detector_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_INPUT;
    const char **known = rmap_alloc(scene->n_detector + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the detectors' names");
    for (size_t d = 0; d < scene->n_detector; d++) {
        known[d] = scene->detector[d].name;
        if (strcmp(known[d], name) == 0) {
            *detector_ret = (int32_t)d;
            st = RMAP_OK;
        }
    }
    const char *nearest = rmap_nearest_word(name, known, scene->n_detector);
    if (st != RMAP_OK && nearest)
        (void)rmap_error_set(err, st, "no detector named '%s' in this map (did you mean '%s'?)",
                             name, nearest);
    else if (st != RMAP_OK)
        (void)rmap_error_set(err, st, "no detector named '%s' in this map; it has %zu", name,
                             scene->n_detector);
    rmap_free(known);
    return st;
}
