/* SPDX-License-Identifier: MIT
 *
 * The departures of retrace_emit.c for a pack of rays: the same operations in the same order.
 */
#include "base/rng.h"
#include "compact/wave_random.h"

/* Rays of one source. */
struct start {
    double px[W], py[W], pz[W], dx[W], dy[W], dz[W];
};

static inline void draw_two(uint64_t seed, const uint64_t id[W], enum rmap_rng_slot slot,
                            double u[W], double v[W])
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

/* In the source's frame, where z is 0. */
static inline void local_points(const struct rmap_source *source, const double u[W],
                                const double v[W], double x[W], double y[W])
{
    double cosine[W], sine[W], size0 = source->shape_size[0], size1 = source->shape_size[1];
    if (source->shape == RMAP_EMITTER_DISC) {
        azimuth(v, cosine, sine);
        EACH
        {
            double r = size0 * sqrt(u[i]);
            x[i] = r * cosine[i];
            y[i] = r * sine[i];
        }
    } else if (source->shape == RMAP_EMITTER_RECTANGLE) {
        EACH
        {
            x[i] = (u[i] - 0.5) * size0;
            y[i] = (v[i] - 0.5) * size1;
        }
    } else {
        EACH
        {
            x[i] = y[i] = 0.0;
        }
    }
}

static inline void place(const struct rmap_affine *a, const double x[W], const double y[W],
                         struct start *s)
{
    EACH
    {
        s->px[i] = (a->m[0][0] * x[i] + a->m[0][1] * y[i] + a->m[0][2] * 0.0) + a->t.x;
        s->py[i] = (a->m[1][0] * x[i] + a->m[1][1] * y[i] + a->m[1][2] * 0.0) + a->t.y;
        s->pz[i] = (a->m[2][0] * x[i] + a->m[2][1] * y[i] + a->m[2][2] * 0.0) + a->t.z;
    }
}

/* about_z: m is 1 - cosine. */
static inline void about_z(const double m[W], const double turns[W], double x[W], double y[W],
                           double z[W])
{
    double cosine[W], sine[W];
    azimuth(turns, cosine, sine);
    EACH
    {
        double s = sqrt(m[i] * (2.0 - m[i]));
        x[i] = s * cosine[i];
        y[i] = s * sine[i];
        z[i] = 1.0 - m[i];
    }
}

static inline void from_point(const struct rmap_source *source,
                              const struct rmap_compact_source *own, const double u[W],
                              const double v[W], struct start *s)
{
    double m[W], x[W], y[W], z[W];
    double scale = source->distribution == RMAP_DISTRIBUTION_CONE ? own->cone : 2.0;
    const struct rmap_affine *a = &source->frame;
    EACH
    {
        m[i] = u[i] * scale;
    }
    about_z(m, v, x, y, z);
    EACH
    {
        s->dx[i] = a->m[0][0] * x[i] + a->m[0][1] * y[i] + a->m[0][2] * z[i];
        s->dy[i] = a->m[1][0] * x[i] + a->m[1][1] * y[i] + a->m[1][2] * z[i];
        s->dz[i] = a->m[2][0] * x[i] + a->m[2][1] * y[i] + a->m[2][2] * z[i];
    }
    normalise(s->dx, s->dy, s->dz);
}

static inline void from_area(const struct rmap_compact_source *own, const double u[W],
                             const double v[W], struct start *s)
{
    double m[W], x[W], y[W], z[W];
    const struct rmap_vec3 n = own->axis, e = own->tangent[0], f = own->tangent[1];
    EACH
    {
        m[i] = 1.0 - sqrt(u[i]);
    }
    about_z(m, v, x, y, z);
    EACH
    {
        s->dx[i] = (n.x * z[i] + y[i] * f.x) + x[i] * e.x;
        s->dy[i] = (n.y * z[i] + y[i] * f.y) + x[i] * e.y;
        s->dz[i] = (n.z * z[i] + y[i] * f.z) + x[i] * e.z;
    }
    normalise(s->dx, s->dy, s->dz);
}

WIDE static void depart(const struct rmap_source *source, const struct rmap_compact_source *own,
                        uint64_t seed, const uint64_t id[W], struct start *s)
{
    double u[W], v[W], x[W], y[W];
    if (source->shape != RMAP_EMITTER_POINT)
        draw_two(seed, id, RMAP_RNG_EMIT_POINT, u, v);
    local_points(source, u, v, x, y);
    place(&source->frame, x, y, s);
    EACH
    {
        s->dx[i] = own->axis.x;
        s->dy[i] = own->axis.y;
        s->dz[i] = own->axis.z;
    }
    if (source->type == RMAP_SOURCE_COLLIMATED)
        return;
    draw_two(seed, id, RMAP_RNG_EMIT_DIRECTION, u, v);
    if (source->type == RMAP_SOURCE_POINT)
        from_point(source, own, u, v, s);
    else
        from_area(own, u, v, s);
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
