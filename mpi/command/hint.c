/* SPDX-License-Identifier: MIT
 *
 * An answer of nothing comes with a word on why.
 */
#include "mpi/command/hint.h"

#include <stdio.h>

#include "analysis/criterion/criterion_hint.h"

void rmap_tell_hint(const struct rmap_context *context, const struct rmap_map *map,
                    const struct rmap_choice *choice, uint64_t n)
{
    char hint[RMAP_CRITERION_HINT_NBYTES] = "";
    if (n > 0 || context->quiet)
        return;
    if (choice->criterion)
        rmap_criterion_hint(choice->criterion, map, hint);
    if (!hint[0] && choice->which && choice->which->own)
        rmap_criterion_hint(choice->which->own, map, hint);
    if (hint[0])
        fprintf(stderr, "raymap: no ray matches: %s\n", hint);
}
