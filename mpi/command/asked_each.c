/* SPDX-License-Identifier: MIT
 *
 * All criteria that a command is given, and the one that they make together.
 */
#include "mpi/command/asked_each.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

static enum rmap_status join(const struct rmap_asked *asked, const struct rmap_scene *scene,
                             struct rmap_asked_each *each, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t size = sizeof "all", at = 0;
    for (size_t i = 0; i < each->n; i++)
        size += strlen(rmap_criterion_text(each->of[i])) + sizeof "() or ";
    char *text = rmap_alloc(size, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", each->n);
    for (size_t i = 0; i < each->n; i++)
        at += (size_t)snprintf(text + at, size - at, each->n > 1 ? "%s(%s)" : "%s%s",
                               i ? " or " : "", rmap_criterion_text(each->of[i]));
    RMAP_TRY(rmap_criterion_compile_with(each->n > 0 ? text : "all", asked->criteria, scene,
                                         &each->any, err));
    if (each->n > 0)
        each->text = rmap_criterion_text(each->any);
out:
    rmap_free(text);
    return st;
}

enum rmap_status rmap_asked_each_compile(const struct rmap_context *context,
                                         struct rmap_asked *asked, const struct rmap_scene *scene,
                                         struct rmap_asked_each *each, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *each = (struct rmap_asked_each){.of = rmap_alloc(asked->n + 1, sizeof(void *))};
    if (!each->of)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for criteria");
    for (; each->n < asked->n; each->n++)
        RMAP_TRY(rmap_asked_compile(context, asked, each->n, scene, &each->of[each->n], err));
    st = join(asked, scene, each, err);
out:
    return st;
}

void rmap_asked_each_fini(struct rmap_asked_each *each)
{
    for (size_t i = 0; i < each->n; i++)
        rmap_criterion_destroy(each->of[i]);
    rmap_free(each->of);
    rmap_criterion_destroy(each->any);
    *each = (struct rmap_asked_each){0};
}
