/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace_surface.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#include "base/wide.h"
#include "compact/wave_lanes.h"
#include "formula/triangle.h"

/* Surfaces of the rays, in the order of struct rmap_bounded_quadric. */
struct quadrics {
    double alpha[W], gamma[W], delta[W], epsilon[W];
    double middle[W], inner2[W], outer2[W], sheet[W];
    double low[W], high[W], sign[W], rigid[W];
};

static inline void gather_quadrics(const struct rmap_wave_pack *p, struct quadrics *q)
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

RMAP_COPIED void cross_quadric(const struct quadrics *q, struct local *l, struct rmap_wave_pack *p)
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
                              struct rmap_wave_pack *p)
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
static inline void normalise_some(const double rigid[W], struct rmap_wave_pack *p)
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

WIDE void rmap_wave_meet_quadrics(bool own, double behind, struct rmap_wave_pack *p)
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
WIDE void rmap_wave_meet_nothing(const struct rmap_scene *scene, struct rmap_wave_pack *p)
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
WIDE void rmap_wave_meet_flats(struct rmap_wave_pack *p)
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
static inline void get_corners(const struct rmap_wave_pack *p, int k, double x[W], double y[W],
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

WIDE void rmap_wave_meet_meshes(struct rmap_wave_pack *p)
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
