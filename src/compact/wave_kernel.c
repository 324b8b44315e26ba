/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace_surface.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#include "compact/wave_lanes.h"

/* Surfaces of the rays, as in rmap_compact_object. */
struct quadrics {
    double alpha[W], gamma[W], delta[W], epsilon[W];
    double inner2[W], outer2[W], sheet[W], low[W];
    double high[W], middle[W], sign[W], rigid[W];
};

static inline void gather_quadrics(const struct rmap_wave_pack *p, struct quadrics *q)
{
    for (int i = 0; i < W; i += 4) {
        const double *a = p->object[i]->quadric, *b = p->object[i + 1]->quadric;
        const double *c = p->object[i + 2]->quadric, *d = p->object[i + 3]->quadric;
        across(a, b, c, d, q->alpha + i, q->gamma + i, q->delta + i, q->epsilon + i);
        across(a + 4, b + 4, c + 4, d + 4, q->inner2 + i, q->outer2 + i, q->sheet + i, q->low + i);
        across(a + 8, b + 8, c + 8, d + 8, q->high + i, q->middle + i, q->sign + i, q->rigid + i);
    }
}

static inline void cross_quadric(const struct quadrics *q, struct local *l,
                                 struct rmap_wave_pack *p)
{
    EACH
    {
        double alpha = q->alpha[i], gamma = q->gamma[i], delta = q->delta[i];
        double dx = l->dx[i], dy = l->dy[i], dz = l->dz[i];
        double a = alpha * (dx * dx + dy * dy) + gamma * dz * dz;
        double gx = alpha * l->ox[i], gy = alpha * l->oy[i], gz = gamma * l->oz[i] + delta;
        double t = -2 * (gx * dx + gy * dy + gz * dz) / a;
        p->t[i] = t;
        l->x[i] = l->ox[i] + t * dx;
        l->y[i] = l->oy[i] + t * dy;
        l->z[i] = l->oz[i] + t * dz;
    }
}

static inline void meet_quadric(const struct quadrics *q, double behind, struct local *l,
                                struct rmap_wave_pack *p)
{
    double shift[W], cx[W], cy[W], cz[W], t0[W], t1[W];
    EACH
    {
        double dx = l->dx[i], dy = l->dy[i], dz = l->dz[i];
        double ox = l->ox[i], oy = l->oy[i], oz = l->oz[i];
        shift[i] = -(ox * dx + oy * dy + (oz - q->middle[i]) * dz) / (dx * dx + dy * dy + dz * dz);
        cx[i] = ox + shift[i] * dx;
        cy[i] = oy + shift[i] * dy;
        cz[i] = oz + shift[i] * dz;
    }
    EACH
    {
        double alpha = q->alpha[i], gamma = q->gamma[i], delta = q->delta[i];
        double dx = l->dx[i], dy = l->dy[i], dz = l->dz[i], x = cx[i], y = cy[i], z = cz[i];
        double a = alpha * (dx * dx + dy * dy) + gamma * dz * dz;
        double b = alpha * x * dx + alpha * y * dy + (gamma * z + delta) * dz;
        double c = alpha * (x * x + y * y) + (gamma * z + 2 * delta) * z + q->epsilon[i];
        double discriminant = b * b - a * c;
        double root = sqrt(discriminant), sum = b < 0 ? root - b : -(b + root);
        double near = c / sum, far = sum / a;
        far = far - far == 0.0 ? far : near;
        t0[i] = near < far ? near : far;
        t1[i] = near < far ? far : near;
        p->odd[i] = p->odd[i] + (sum != 0.0 && discriminant >= 0.0 ? 0.0 : 1.0);
    }
    EACH
    {
        double x = cx[i] + t0[i] * l->dx[i], y = cy[i] + t0[i] * l->dy[i];
        double z = cz[i] + t0[i] * l->dz[i], s = x * x + y * y;
        double outside = shift[i] + t0[i] > behind ? 0.0 : 1.0;
        outside = s <= q->outer2[i] ? outside : 1.0;
        outside = s >= q->inner2[i] ? outside : 1.0;
        outside = 1 - q->sheet[i] * z >= -0x1p-50 ? outside : 1.0;
        outside = z >= q->low[i] ? outside : 1.0;
        outside = z <= q->high[i] ? outside : 1.0;
        double t = outside > 0.0 ? t1[i] : t0[i];
        p->t[i] = shift[i] + t;
        l->x[i] = cx[i] + t * l->dx[i];
        l->y[i] = cy[i] + t * l->dy[i];
        l->z[i] = cz[i] + t * l->dz[i];
    }
}

static inline void quadric_normal(const struct quadrics *q, struct local *l,
                                  struct rmap_wave_pack *p)
{
    EACH
    {
        double alpha = q->alpha[i], gamma = q->gamma[i], delta = q->delta[i], sign = q->sign[i];
        double x = sign * (alpha * l->x[i]), y = sign * (alpha * l->y[i]);
        double z = sign * (gamma * l->z[i] + delta);
        double length = sqrt(x * x + y * y + z * z), s = 1 / length;
        l->nx[i] = x * s;
        l->ny[i] = y * s;
        l->nz[i] = z * s;
        p->odd[i] = p->odd[i] + (length > 0.0 ? 0.0 : 1.0);
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
    quadric_normal(&q, &l, p);
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
