/* SPDX-License-Identifier: MIT
 *
 * The departures of retrace_emit.c for a pack of rays.
 */
#include "base/rng.h"
#include "base/wide.h"
#include "compact/wave_random.h"
#include "formula/emit.h"

/* Rays of one source. */
struct start {
    double px[W], py[W], pz[W], dx[W], dy[W], dz[W];
};

RMAP_COPIED void draw_two(uint64_t seed, const uint64_t id[W], enum rmap_rng_slot slot, double u[W],
                          double v[W])
{
    uint32_t counter[4][W];
    EACH
    {
        counter[0][i] = (uint32_t)id[i];
        counter[1][i] = (uint32_t)(id[i] >> 32);
        counter[2][i] = 0;
        counter[3][i] = (uint32_t)slot;
    }
    rmap_wave_draw(seed, counter);
    uniform(counter[0], u);
    uniform(counter[1], v);
}

/* Points of an emitter that is no mesh. */
RMAP_COPIED void place(const struct rmap_source *source, const double u[W], const double v[W],
                       struct start *s)
{
    const struct rmap_affine frame = source->frame;
    const double size[2] = {source->shape_size[0], source->shape_size[1]};
    if (source->shape == RMAP_EMITTER_DISC)
        EACH
        {
            set_lane(rmap_affine_point(&frame, rmap_disc_point(size[0], u[i], v[i])), i, s->px,
                     s->py, s->pz);
        }
    else if (source->shape == RMAP_EMITTER_RECTANGLE)
        EACH
        {
            set_lane(rmap_affine_point(&frame, rmap_rectangle_point(size, u[i], v[i])), i, s->px,
                     s->py, s->pz);
        }
    else
        EACH
        {
            set_lane(rmap_affine_point(&frame, rmap_vec3(0.0, 0.0, 0.0)), i, s->px, s->py, s->pz);
        }
}

WIDE static void depart(const struct rmap_source *source, const struct rmap_compact_source *own,
                        uint64_t seed, const uint64_t id[W], struct start *s)
{
    double u[W], v[W];
    const struct rmap_affine frame = source->frame;
    const struct rmap_vec3 axis = own->axis, x = own->tangent[0], y = own->tangent[1];
    const double scale = source->distribution == RMAP_DISTRIBUTION_CONE ? own->cone : 2.0;
    if (source->shape != RMAP_EMITTER_POINT)
        draw_two(seed, id, RMAP_RNG_EMIT_POINT, u, v);
    place(source, u, v, s);
    EACH
    {
        set_lane(axis, i, s->dx, s->dy, s->dz);
    }
    if (source->type == RMAP_SOURCE_COLLIMATED)
        return;
    draw_two(seed, id, RMAP_RNG_EMIT_DIRECTION, u, v);
    if (source->type == RMAP_SOURCE_POINT)
        EACH
        {
            struct rmap_vec3 local = rmap_about_z(u[i] * scale, v[i]);
            set_lane(rmap_normalize(rmap_affine_vector(&frame, local)), i, s->dx, s->dy, s->dz);
        }
    else
        EACH
        {
            set_lane(rmap_lambertian(axis, x, y, u[i], v[i]), i, s->dx, s->dy, s->dz);
        }
}

/* Are its rays as above? */
static bool plain(const struct rmap_compact_model *model, int32_t source)
{
    if (source < 0 || (size_t)source >= model->n_source)
        return false;
    const struct rmap_source *s = &model->scene->source[source];
    return s->type != RMAP_SOURCE_RAYS && s->shape != RMAP_EMITTER_MESH &&
           (s->type != RMAP_SOURCE_POINT || s->distribution != RMAP_DISTRIBUTION_COSINE);
}

static void depart_some(const struct rmap_retrace *r, const size_t *ray, size_t n,
                        struct rmap_departure *const *to)
{
    int32_t source = r->source[ray[0]];
    const struct rmap_source *from = &r->model->scene->source[source];
    struct start start;
    uint64_t id[W];
    EACH
    {
        id[i] = r->id[ray[(size_t)i < n ? i : 0]];
    }
    depart(from, &r->model->source[source], r->seed, id, &start);
    for (size_t i = 0; i < n; i++)
        *to[i] = (struct rmap_departure){
            .position = rmap_vec3(start.px[i], start.py[i], start.pz[i]),
            .direction = rmap_vec3(start.dx[i], start.dy[i], start.dz[i]),
            .normal = from->type == RMAP_SOURCE_AREA ? r->model->source[source].axis
                                                     : rmap_vec3(0.0, 0.0, 0.0),
            .medium = from->medium,
            .channel = -1};
}

void rmap_wave_depart(const struct rmap_retrace *r, size_t first, size_t end,
                      struct rmap_departure *departure)
{
    struct rmap_departure *to[W + 1]; /* one more than go */
    size_t ray[W + 1], n, left = end - first, waits[RMAP_WAVE_AHEAD];
    for (size_t i = 0; i < left; i++)
        waits[i] = first + i;
    while (left > 0) {
        size_t kept = n = 0;
        int32_t source = r->source[waits[0]];
        size_t most = plain(r->model, source) ? W : 1;
        for (size_t i = 0; i < left; i++) {
            bool goes = n < most && r->source[waits[i]] == source;
            ray[n] = waits[i];
            to[n] = &departure[waits[i] - first];
            waits[kept] = waits[i];
            n += goes;
            kept += !goes;
        }
        left = kept;
        if (most > 1)
            depart_some(r, ray, n, to);
        else
            rmap_departure_find(r->model, r->seed, r->id[ray[0]], source, to[0]);
    }
}
