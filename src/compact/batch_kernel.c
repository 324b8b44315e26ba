/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#include <string.h>

#include "base/rng.h"
#include "base/wide.h"
#include "compact/batch_kernel.h"
#include "compact/batch_lanes.h"
#include "compact/batch_random.h"
#include "compact/retrace.h"
#include "formula/emit.h"
#include "formula/triangle.h"
#include "trace/source.h"

/* Surfaces of the rays, in the order of struct rmap_bounded_quadric. */
struct quadrics {
    double alpha[W], gamma[W], delta[W], epsilon[W];
    double middle[W], inner2[W], outer2[W], sheet[W];
    double low[W], high[W], sign[W], rigid[W];
};

static inline void gather_quadrics(const struct rmap_batch_pack *p, struct quadrics *q)
{
    for (int i = 0; i < W; i += 4) {
        const double *a = (const double *)&p->object[i]->quadric;
        const double *b = (const double *)&p->object[i + 1]->quadric;
        const double *c = (const double *)&p->object[i + 2]->quadric;
        const double *d = (const double *)&p->object[i + 3]->quadric;
        across(a, b, c, d, q->alpha + i, q->gamma + i, q->delta + i, q->epsilon + i);
        across(a + 4, b + 4, c + 4, d + 4, q->middle + i, q->inner2 + i, q->outer2 + i,
               q->sheet + i);
        across(a + 8, b + 8, c + 8, d + 8, q->low + i, q->high + i, q->sign + i, q->rigid + i);
    }
}

RMAP_COPIED struct rmap_bounded_quadric quadric_of(const struct quadrics *q, int i)
{
    return (struct rmap_bounded_quadric){
        {q->alpha[i], q->gamma[i], q->delta[i], q->epsilon[i], q->middle[i]},
        q->inner2[i],
        q->outer2[i],
        q->sheet[i],
        q->low[i],
        q->high[i],
        q->sign[i],
        q->rigid[i]};
}

RMAP_COPIED void cross_quadric(const struct quadrics *q, struct local *l, struct rmap_batch_pack *p)
{
    EACH
    {
        const struct rmap_bounded_quadric one = quadric_of(q, i);
        struct rmap_vec3 from = lane_of(l->ox, l->oy, l->oz, i);
        struct rmap_vec3 d = lane_of(l->dx, l->dy, l->dz, i);
        p->t[i] = rmap_quadric_other(&one.form, from, d);
        set_lane(rmap_axpy(p->t[i], d, from), i, l->x, l->y, l->z);
    }
}

RMAP_COPIED void meet_quadric(const struct quadrics *q, double behind, struct local *l,
                              struct rmap_batch_pack *p)
{
    double shift[W], t0[W], t1[W], x[W], y[W], z[W];
    EACH
    {
        const struct rmap_bounded_quadric one = quadric_of(q, i);
        const struct rmap_quadric_roots roots = rmap_quadric_meet(
            &one.form, lane_of(l->ox, l->oy, l->oz, i), lane_of(l->dx, l->dy, l->dz, i));
        shift[i] = roots.shift;
        t0[i] = roots.t0;
        t1[i] = roots.t1;
        set_lane(roots.near, i, x, y, z);
        p->odd[i] = p->odd[i] + roots.missed;
    }
    EACH
    {
        const struct rmap_bounded_quadric one = quadric_of(q, i);
        const struct rmap_quadric_roots roots = {shift[i], t0[i], t1[i], lane_of(x, y, z, i), 0.0};
        struct rmap_vec3 point;
        p->t[i] =
            rmap_quadric_choose(&one, behind, &roots, lane_of(l->dx, l->dy, l->dz, i), &point);
        set_lane(point, i, l->x, l->y, l->z);
    }
}

RMAP_COPIED void quadric_normal(const struct quadrics *q, struct local *l)
{
    EACH
    {
        const struct rmap_bounded_quadric one = quadric_of(q, i);
        set_lane(rmap_quadric_unit_normal(&one, lane_of(l->x, l->y, l->z, i)), i, l->nx, l->ny,
                 l->nz);
    }
}

/* Normals of maps that do not keep lengths. */
static inline void normalise_some(const double rigid[W], struct rmap_batch_pack *p)
{
    double nx[W], ny[W], nz[W], all = 1.0;
    EACH
    {
        all = rigid[i] < all ? rigid[i] : all;
        nx[i] = p->nx[i];
        ny[i] = p->ny[i];
        nz[i] = p->nz[i];
    }
    if (all > 0.0)
        return;
    normalise(nx, ny, nz);
    EACH
    {
        p->nx[i] = rigid[i] > 0.0 ? p->nx[i] : nx[i];
        p->ny[i] = rigid[i] > 0.0 ? p->ny[i] : ny[i];
        p->nz[i] = rigid[i] > 0.0 ? p->nz[i] : nz[i];
    }
}

WIDE void rmap_batch_meet_quadrics(bool own, double behind, struct rmap_batch_pack *p)
{
    struct local l;
    struct maps local, world;
    struct quadrics q;
    gather_quadrics(p, &q);
    gather_maps(p, &local, &world);
    to_local(&local, p, &l);
    fill(p->odd, 0.0);
    if (own)
        cross_quadric(&q, &l, p);
    else
        meet_quadric(&q, behind, &l, p);
    quadric_normal(&q, &l);
    to_world(&local, &world, &l, p);
    normalise_some(q.rigid, p);
    conclude(p);
}

/* As rmap_step_distance_out. */
WIDE void rmap_batch_meet_nothing(const struct rmap_scene *scene, struct rmap_batch_pack *p)
{
    double radius2 = scene->radius * scene->radius;
    EACH
    {
        double x = p->px[i] - scene->centre.x, y = p->py[i] - scene->centre.y;
        double z = p->pz[i] - scene->centre.z;
        double along = x * p->dx[i] + y * p->dy[i] + z * p->dz[i];
        double gap = radius2 - (x * x + y * y + z * z);
        double root = sqrt(along * along + gap);
        double out = along > 0.0 ? gap / (root + along) : root - along;
        p->t[i] = gap > 0.0 ? out : 0.0;
        p->px[i] = p->px[i] + p->t[i] * p->dx[i];
        p->py[i] = p->py[i] + p->t[i] * p->dy[i];
        p->pz[i] = p->pz[i] + p->t[i] * p->dz[i];
    }
    fill(p->nx, 0.0);
    fill(p->ny, 0.0);
    fill(p->nz, 0.0);
    fill(p->cosine, (double)NAN);
    fill(p->odd, 0.0);
    record_end(p);
}

/* z = 0; normals in the world are known beforehand, and recorded. */
WIDE void rmap_batch_meet_flats(struct rmap_batch_pack *p)
{
    struct local l;
    struct maps local, world;
    gather_maps(p, &local, &world);
    to_local(&local, p, &l);
    EACH
    {
        p->t[i] = -l.oz[i] / l.dz[i];
        l.x[i] = l.ox[i] + p->t[i] * l.dx[i];
        l.y[i] = l.oy[i] + p->t[i] * l.dy[i];
        l.z[i] = 0.0;
    }
    points_to_world(&world, &l, p);
    EACH
    {
        const double *flat = p->object[i]->flat;
        uint64_t recorded;
        memcpy(&recorded, &flat[3], sizeof recorded);
        p->nx[i] = flat[0];
        p->ny[i] = flat[1];
        p->nz[i] = flat[2];
        p->normal_xy[i] = (uint32_t)recorded;
        p->normal_z[i] = (int32_t)(recorded >> 32);
    }
    fill(p->odd, 0.0);
    arrive(p);
    record_position(p);
}

/* Corner k of the triangles. */
static inline void get_corners(const struct rmap_batch_pack *p, int k, double x[W], double y[W],
                               double z[W])
{
    EACH
    {
        const float *corner = p->corner[i] + 4 * k;
        x[i] = (double)corner[0];
        y[i] = (double)corner[1];
        z[i] = (double)corner[2];
    }
}

WIDE void rmap_batch_meet_meshes(struct rmap_batch_pack *p)
{
    struct local l;
    struct maps local, world;
    double x[3][W], y[3][W], z[3][W];
    gather_maps(p, &local, &world);
    to_local(&local, p, &l);
    for (int k = 0; k < 3; k++)
        get_corners(p, k, x[k], y[k], z[k]);
    EACH
    {
        struct rmap_vec3 point, normal;
        p->t[i] = rmap_triangle_meet(lane_of(x[0], y[0], z[0], i), lane_of(x[1], y[1], z[1], i),
                                     lane_of(x[2], y[2], z[2], i), lane_of(l.ox, l.oy, l.oz, i),
                                     lane_of(l.dx, l.dy, l.dz, i), &point, &normal);
        set_lane(point, i, l.x, l.y, l.z);
        set_lane(normal, i, l.nx, l.ny, l.nz);
    }
    to_world(&local, &world, &l, p);
    normalise(p->nx, p->ny, p->nz);
    fill(p->odd, 0.0);
    conclude(p);
}

/* The turns of step.h for a pack of rays. */

/* sx, sy, sz: normals towards the light. */
RMAP_COPIED void reflect(const double sx[W], const double sy[W], const double sz[W],
                         struct rmap_batch_pack *p)
{
    EACH
    {
        set_lane(rmap_reflected(lane_of(p->dx, p->dy, p->dz, i), lane_of(sx, sy, sz, i)), i, p->dx,
                 p->dy, p->dz);
    }
}

RMAP_COPIED void refract(const double sx[W], const double sy[W], const double sz[W],
                         struct rmap_batch_pack *p)
{
    EACH
    {
        double total;
        set_lane(rmap_refracted(lane_of(p->dx, p->dy, p->dz, i), lane_of(sx, sy, sz, i), p->n1[i],
                                p->n2[i], &total),
                 i, p->dx, p->dy, p->dz);
        p->odd[i] = p->odd[i] + total;
    }
}

RMAP_COPIED void diffuse(const double sx[W], const double sy[W], const double sz[W], uint64_t seed,
                         struct rmap_batch_pack *p)
{
    double u[W], v[W];
    rmap_batch_draw(seed, p->random);
    uniform(p->random[2], u);
    uniform(p->random[3], v);
    EACH
    {
        double turn = p->through[i] > 0.0 ? -1.0 : 1.0;
        set_lane(rmap_diffused(rmap_scale(lane_of(sx, sy, sz, i), turn), u[i], v[i]), i, p->dx,
                 p->dy, p->dz);
    }
}

WIDE void rmap_batch_turn(enum rmap_turn turn, uint64_t seed, struct rmap_batch_pack *pack)
{
    double sx[W], sy[W], sz[W];
    EACH
    {
        double side = pack->cosine[i] < 0.0 ? 1.0 : -1.0;
        sx[i] = pack->nx[i] * side;
        sy[i] = pack->ny[i] * side;
        sz[i] = pack->nz[i] * side;
    }
    if (turn == RMAP_TURN_REFLECT)
        reflect(sx, sy, sz, pack);
    else if (turn == RMAP_TURN_REFRACT)
        refract(sx, sy, sz, pack);
    else
        diffuse(sx, sy, sz, seed, pack);
}

/* Rays into packs and back: four numbers of four rays at a time change rows for columns. */

/* x, y, z and normal_xy of four rays. */
static inline void turn_ends(const struct rmap_batch_pack *p, size_t at, words row[4])
{
    words x, y, z, n;
    memcpy(&x, p->position[0] + at, sizeof x);
    memcpy(&y, p->position[1] + at, sizeof y);
    memcpy(&z, p->position[2] + at, sizeof z);
    memcpy(&n, p->normal_xy + at, sizeof n);
    words low0 = MIX4(x, y, 0, 4, 1, 5), high0 = MIX4(x, y, 2, 6, 3, 7);
    words low1 = MIX4(z, n, 0, 4, 1, 5), high1 = MIX4(z, n, 2, 6, 3, 7);
    row[0] = MIX4(low0, low1, 0, 1, 4, 5);
    row[1] = MIX4(low0, low1, 2, 3, 6, 7);
    row[2] = MIX4(high0, high1, 0, 1, 4, 5);
    row[3] = MIX4(high0, high1, 2, 3, 6, 7);
}

static inline void note(const struct rmap_batch_pack *p, const words end[W], const size_t row[W],
                        size_t n, float *position, int16_t *normal)
{
    for (size_t i = 0; position && i < n; i++)
        memcpy(position + 3 * row[i], &end[i], 3 * sizeof *position);
    for (size_t i = 0; normal && i < n; i++) {
        uint32_t xy = end[i][3];
        memcpy(normal + 3 * row[i], &xy, sizeof xy);
        normal[3 * row[i] + 2] = (int16_t)p->normal_z[i];
    }
}

void rmap_batch_note(const struct rmap_batch_pack *p, const size_t row[W], size_t n,
                     float *position, int16_t *normal)
{
    words end[W];
    for (size_t i = 0; i < W; i += 4)
        turn_ends(p, i, end + i);
    if (n == W) /* most: its loops have no branches */
        note(p, end, row, W, position, normal);
    else
        note(p, end, row, n, position, normal);
}

/* The store of a row reaches into the next one. */
void rmap_batch_note_on(const struct rmap_batch_pack *p, const size_t row[W], float *position,
                        int16_t *normal)
{
    words end[W];
    uint64_t three[W];
    for (size_t i = 0; i < W; i += 4) {
        words xy, z;
        turn_ends(p, i, end + i);
        memcpy(&xy, p->normal_xy + i, sizeof xy);
        memcpy(&z, p->normal_z + i, sizeof z);
        words low = MIX4(xy, z, 0, 4, 1, 5), high = MIX4(xy, z, 2, 6, 3, 7);
        memcpy(three + i, &low, sizeof low);
        memcpy(three + i + 2, &high, sizeof high);
    }
    for (size_t i = 0; position && i < W; i++)
        memcpy(position + 3 * row[i], &end[i], sizeof end[i]);
    for (size_t i = 0; normal && i < W; i++)
        memcpy(normal + 3 * row[i], &three[i], sizeof three[i]);
}

WIDE void rmap_batch_load(struct rmap_batch_pack *p)
{
    double unused[2][4];
    for (int i = 0; i < W; i += 4) {
        const double *a = p->ray[i]->state, *b = p->ray[i + 1]->state;
        const double *c = p->ray[i + 2]->state, *d = p->ray[i + 3]->state;
        across(a, b, c, d, p->px + i, p->py + i, p->pz + i, p->dx + i);
        across(a + 4, b + 4, c + 4, d + 4, p->dy + i, p->dz + i, unused[0], unused[1]);
    }
}

WIDE void rmap_batch_store(const struct rmap_batch_pack *p,
                           struct rmap_batch_ray *const to[RMAP_BATCH_WIDTH])
{
    EACH
    {
        const double state[6] = {p->px[i], p->py[i], p->pz[i], p->dx[i], p->dy[i], p->dz[i]};
        memcpy(to[i]->state, state, sizeof state);
        to[i]->segment->way.length = p->t[i];
        to[i]->segment->cosine = p->cosine[i];
    }
}

/* The departures of retrace.c for a pack of rays. */

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
    rmap_batch_draw(seed, counter);
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
    if (rmap_source_is_parallel(source))
        return;
    draw_two(seed, id, RMAP_RNG_EMIT_DIRECTION, u, v);
    if (source->type != RMAP_SOURCE_AREA)
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
    return rmap_source_is_simple(&model->scene->source[source]);
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
            .channel = rmap_source_channel(r->model->scene, from, r->seed, id[i], -1)};
}

void rmap_batch_depart(const struct rmap_retrace *r, size_t first, size_t end,
                       struct rmap_departure *departure)
{
    struct rmap_departure *to[W + 1]; /* one more than go */
    size_t ray[W + 1], n, left = end - first, waits[RMAP_BATCH_AHEAD];
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
