/* SPDX-License-Identifier: MIT
 *
 * Objects, events and media of a path from what is stored of it. Leg by leg that waits for branches
 * that nobody can predict, so where the machine can, eight legs go at once: taken for granted that
 * 0 always stands for the object before and that light comes to surfaces in one of their media. A
 * path where it was otherwise is gone through once more.
 */
#include <string.h>

#include "base/wide.h"
#include "compact/path_wide.h"

RMAP_WIDE
static uint32_t most_of(const uint32_t *object, size_t n)
{
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = object[i] > most ? object[i] : most;
    return most;
}

bool rmap_path_guided(const struct rmap_compact_model *model, const uint32_t *object, size_t n)
{
    return model->signs && most_of(object, n) <= model->n_object;
}

static void unfold(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                   const struct rmap_path_columns *out)
{
    const struct rmap_compact_body *nobody = &model->body[model->n_object], *body = nobody;
    int32_t medium = rmap_first_medium(model, path->source);
    uint32_t before = 0; /* 1 + object */
    for (size_t k = 0; k < path->n; k++) {
        uint32_t now = path->object[k];
        /* a branch that is predicted: the next legs need not wait for this one */
        if ((now == 0 || now == before) && body->inside == medium)
            now = before - now;
        body = now > 0 && now <= model->n_object ? &model->body[now - 1] : nobody;
        uint32_t happened = path->event[k] ^ body->expected;
        if (out->object)
            out->object[k] = (int32_t)(now - 1);
        if (out->event)
            out->event[k] = happened;
        if (out->medium)
            out->medium[k] = (int16_t)medium;
        medium = rmap_medium_after(body, medium, happened);
        before = now;
    }
}

#ifdef RMAP_PATHS_AVX2
RMAP_PATHS_AVX2 static bool unfold_8(const struct rmap_compact_model *model,
                                     const struct rmap_folded_path *path,
                                     const struct rmap_path_columns *out)
{
    return out->object && out->event && rmap_path_unfold_8(model, path, out);
}

static bool unfold_fast(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                        const struct rmap_path_columns *out)
{
    return path->guided && __builtin_cpu_supports("avx2") && unfold_8(model, path, out);
}
#else
static bool unfold_fast(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                        const struct rmap_path_columns *out)
{
    (void)model;
    (void)path;
    (void)out;
    return false;
}
#endif

void rmap_path_unfold(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                      const struct rmap_path_columns *out)
{
    if (!unfold_fast(model, path, out))
        unfold(model, path, out);
    rmap_path_end(path, out);
}
