/* SPDX-License-Identifier: MIT
 *
 * Objects, events and media of a path from what is stored of it.
 */
#include <string.h>

#include "compact/paths.h"

void rmap_path_unfold(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
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
    rmap_path_end(path, out);
}
