/* SPDX-License-Identifier: MIT
 *
 * Names of sets of rays: those that a map keeps (io/map/named_rays.h), for criteria that are
 * compiled against the map's scene.
 */
#ifndef RMAP_RAY_NAMES_H
#define RMAP_RAY_NAMES_H

#include "base/id_set.h"

struct rmap_ray_names {
    void *context;
    /* The rays of a name, borrowed from the map; *set_ret NULL: nothing has it. RMAP_INPUT: they
     * were of other rays than the map's now; RMAP_FORMAT: they are damaged. Thread-safe. */
    enum rmap_status (*find)(void *context, const char *name, const struct rmap_id_set **set_ret,
                             struct rmap_error *err);
    /* The criterion that they matched, borrowed; NULL where find has not found the name. */
    const char *(*words)(void *context, const char *name);
    /* The nearest name that the map keeps, rmap_free; NULL: none is near. */
    char *(*near)(void *context, const char *name);
};

#endif
