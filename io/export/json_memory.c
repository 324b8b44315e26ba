/* SPDX-License-Identifier: MIT
 *
 * Memory of JSON documents.
 */
#include "io/export/json_memory.h"

#include <jansson.h>
#include <stdatomic.h>
#include <stddef.h>

#include "base/alloc.h"

/* jansson's functions for memory take no context: they can tell nobody but a static. */
static atomic_bool failed;

static void *ask(size_t nbytes)
{
    void *block = rmap_alloc(nbytes, 1);
    if (!block)
        atomic_store(&failed, true);
    return block;
}

void rmap_json_memory_watch(void)
{
    json_set_alloc_funcs(ask, rmap_free);
}

bool rmap_json_memory_failed(void)
{
    return atomic_load(&failed);
}
