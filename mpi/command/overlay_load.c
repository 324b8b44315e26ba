/* SPDX-License-Identifier: MIT
 *
 * --receivers FILE of a command that asks a map.
 */
#include "mpi/command/overlay_load.h"

#include <stdio.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

enum rmap_status rmap_overlay_load(const struct rmap_context *context,
                                   const struct rmap_arguments *given, const struct rmap_map *map,
                                   struct rmap_overlay **overlay_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics diagnostics;
    struct rmap_receivers receivers = {.path = rmap_argument(given, "receivers"),
                                       .diagnostics = &diagnostics};
    char *text = NULL;
    uint8_t *blob = NULL;
    *overlay_ret = NULL;
    if (!receivers.path)
        return RMAP_OK;
    rmap_diagnostics_init(&diagnostics, receivers.path);
    if (context->rank == 0)
        st = rmap_receivers_open(receivers.path, &text, &receivers.nbytes, err);
    RMAP_TRY(rmap_agree(context, st, err));
    blob = (uint8_t *)text;
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &receivers.nbytes, err));
    receivers.text = (const char *)blob;
    st = rmap_overlay_create(map, &receivers, overlay_ret, err);
    if (context->rank == 0 && (st != RMAP_OK || !context->quiet))
        rmap_diagnostics_print(&diagnostics, stderr);
    st = rmap_agree(context, st, err);
    if (st != RMAP_OK) {
        rmap_overlay_destroy(*overlay_ret);
        *overlay_ret = NULL;
    }
out:
    rmap_free(blob);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}
