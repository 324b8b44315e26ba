/* SPDX-License-Identifier: MIT
 *
 * Primitives of segments: triangles of meshes are listed, all others follow from the object.
 */
#include "compact/primitives.h"

static inline uint32_t listed_of(const struct rmap_compact_model *model, int32_t object)
{
    const size_t its = (uint32_t)object;
    return model->listed[its < model->n_object ? its : model->n_object];
}

size_t rmap_primitives_listed(const struct rmap_compact_model *model, const int32_t *object,
                              size_t n)
{
    size_t n_listed = 0;
    for (size_t i = 0; i < n; i++)
        n_listed += listed_of(model, object[i]) & 1;
    return n_listed;
}

size_t rmap_primitives_place(const struct rmap_compact_model *model, const int32_t *object,
                             size_t n, const uint32_t *triangle, size_t n_triangle,
                             int32_t *primitive)
{
    size_t k = 0; /* next triangle */
    for (size_t i = 0; i < n && n_triangle == 0; i++)
        primitive[i] = object[i] < 0 ? -1 : 0;
    for (size_t i = 0; i < n && n_triangle > 0; i++) {
        /* no branch: whether it is a mesh is anybody's guess */
        uint32_t listed = listed_of(model, object[i]);
        uint32_t plain = object[i] < 0 ? UINT32_MAX : 0;
        uint32_t next = triangle[k < n_triangle ? k : 0];
        primitive[i] = (int32_t)(plain ^ ((plain ^ next) & listed));
        k += listed & 1;
    }
    return k;
}
