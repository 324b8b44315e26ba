/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace_surface.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#include "compact/wave_lanes.h"

/* In the object's frame. */
struct local {
    double ox[W], oy[W], oz[W], dx[W], dy[W], dz[W];
    double x[W], y[W], z[W], nx[W], ny[W], nz[W];
};

static inline void to_local(const struct rmap_affine *a, const struct rmap_wave_pack *p,
                            struct local *l)
{
    EACH
    {
        double x = p->px[i], y = p->py[i], z = p->pz[i];
        l->ox[i] = (a->m[0][0] * x + a->m[0][1] * y + a->m[0][2] * z) + a->t.x;
        l->oy[i] = (a->m[1][0] * x + a->m[1][1] * y + a->m[1][2] * z) + a->t.y;
        l->oz[i] = (a->m[2][0] * x + a->m[2][1] * y + a->m[2][2] * z) + a->t.z;
    }
    EACH
    {
        double x = p->dx[i], y = p->dy[i], z = p->dz[i];
        l->dx[i] = a->m[0][0] * x + a->m[0][1] * y + a->m[0][2] * z;
        l->dy[i] = a->m[1][0] * x + a->m[1][1] * y + a->m[1][2] * z;
        l->dz[i] = a->m[2][0] * x + a->m[2][1] * y + a->m[2][2] * z;
    }
}

static inline void to_world(const struct rmap_compact_object *o, const struct local *l,
                            struct rmap_wave_pack *p)
{
    const struct rmap_affine *a = &o->to_world, *b = &o->to_local;
    EACH
    {
        double x = l->x[i], y = l->y[i], z = l->z[i];
        p->px[i] = (a->m[0][0] * x + a->m[0][1] * y + a->m[0][2] * z) + a->t.x;
        p->py[i] = (a->m[1][0] * x + a->m[1][1] * y + a->m[1][2] * z) + a->t.y;
        p->pz[i] = (a->m[2][0] * x + a->m[2][1] * y + a->m[2][2] * z) + a->t.z;
    }
    EACH
    {
        double x = l->nx[i], y = l->ny[i], z = l->nz[i];
        p->nx[i] = b->m[0][0] * x + b->m[1][0] * y + b->m[2][0] * z;
        p->ny[i] = b->m[0][1] * x + b->m[1][1] * y + b->m[2][1] * z;
        p->nz[i] = b->m[0][2] * x + b->m[1][2] * y + b->m[2][2] * z;
    }
}

static inline void flat(struct local *l, struct rmap_wave_pack *p)
{
    EACH
    {
        double t = -l->oz[i] / l->dz[i];
        p->t[i] = t;
        l->x[i] = l->ox[i] + t * l->dx[i];
        l->y[i] = l->oy[i] + t * l->dy[i];
        l->z[i] = 0.0;
        l->nx[i] = 0.0;
        l->ny[i] = 0.0;
        l->nz[i] = 1.0;
    }
}

static inline void cross_quadric(const struct rmap_compact_object *o, struct local *l,
                                 struct rmap_wave_pack *p)
{
    double alpha = o->alpha, gamma = o->gamma, delta = o->delta;
    EACH
    {
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

/* The bounds of all kinds of quadric as one: infinite where a kind has none. */
struct bounds {
    double inner2, outer2, sheet, low, high;
};

static struct bounds bounds_of(const struct rmap_compact_object *o)
{
    struct bounds b = {-1.0, INFINITY, 0.0, -INFINITY, INFINITY};
    if (o->tube) {
        b.low = 0.0;
        b.high = o->length;
    } else if (o->bounded) {
        b.inner2 = o->inner2;
        b.outer2 = o->outer2;
        b.sheet = o->sheet;
    }
    return b;
}

static inline void meet_quadric(const struct rmap_compact_object *o, double behind, struct local *l,
                                struct rmap_wave_pack *p)
{
    const struct bounds bound = bounds_of(o);
    double alpha = o->alpha, gamma = o->gamma, delta = o->delta, epsilon = o->epsilon;
    double middle = o->middle;
    double shift[W], cx[W], cy[W], cz[W], t0[W], t1[W];
    EACH
    {
        double dx = l->dx[i], dy = l->dy[i], dz = l->dz[i];
        double ox = l->ox[i], oy = l->oy[i], oz = l->oz[i];
        shift[i] = -(ox * dx + oy * dy + (oz - middle) * dz) / (dx * dx + dy * dy + dz * dz);
        cx[i] = ox + shift[i] * dx;
        cy[i] = oy + shift[i] * dy;
        cz[i] = oz + shift[i] * dz;
    }
    EACH
    {
        double dx = l->dx[i], dy = l->dy[i], dz = l->dz[i], x = cx[i], y = cy[i], z = cz[i];
        double a = alpha * (dx * dx + dy * dy) + gamma * dz * dz;
        double b = alpha * x * dx + alpha * y * dy + (gamma * z + delta) * dz;
        double c = alpha * (x * x + y * y) + (gamma * z + 2 * delta) * z + epsilon;
        double discriminant = b * b - a * c;
        double root = sqrt(discriminant), q = b < 0 ? root - b : -(b + root);
        double near = c / q, far = q / a;
        far = far - far == 0.0 ? far : near;
        t0[i] = near < far ? near : far;
        t1[i] = near < far ? far : near;
        p->odd[i] = p->odd[i] + (q != 0.0 && discriminant >= 0.0 ? 0.0 : 1.0);
    }
    EACH
    {
        double x = cx[i] + t0[i] * l->dx[i], y = cy[i] + t0[i] * l->dy[i];
        double z = cz[i] + t0[i] * l->dz[i], s = x * x + y * y;
        double outside = shift[i] + t0[i] > behind ? 0.0 : 1.0;
        outside = s <= bound.outer2 ? outside : 1.0;
        outside = s >= bound.inner2 ? outside : 1.0;
        outside = 1 - bound.sheet * z >= -0x1p-50 ? outside : 1.0;
        outside = z >= bound.low ? outside : 1.0;
        outside = z <= bound.high ? outside : 1.0;
        double t = outside > 0.0 ? t1[i] : t0[i];
        p->t[i] = shift[i] + t;
        l->x[i] = cx[i] + t * l->dx[i];
        l->y[i] = cy[i] + t * l->dy[i];
        l->z[i] = cz[i] + t * l->dz[i];
    }
}

static inline void quadric_normal(const struct rmap_compact_object *o, struct local *l,
                                  struct rmap_wave_pack *p)
{
    double alpha = o->alpha, gamma = o->gamma, delta = o->delta, sign = o->conic ? -1.0 : 1.0;
    EACH
    {
        double x = sign * (alpha * l->x[i]), y = sign * (alpha * l->y[i]);
        double z = sign * (gamma * l->z[i] + delta);
        double length = sqrt(x * x + y * y + z * z), s = 1 / length;
        l->nx[i] = x * s;
        l->ny[i] = y * s;
        l->nz[i] = z * s;
        p->odd[i] = p->odd[i] + (length > 0.0 ? 0.0 : 1.0);
    }
}

/* Corners of the triangles: as they are, and with the axes turned so that the leg's is the last. */
struct corners {
    double at[3][3][W], turned[3][3][W]; /* [corner][axis] */
    double from[3][W], way[3][W];
};

static void gather_corners(const struct rmap_wave_pack *p, struct corners *c)
{
    EACH
    {
        const float *v = p->corner[i];
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 3; j++)
                c->at[k][j][i] = (double)v[4 * k + j];
    }
}

/* x, y, z with the axis `last` as the last one. */
static inline void turn_axes(const double last[W], const double x[W], const double y[W],
                             const double z[W], double (*turned)[W])
{
    EACH
    {
        turned[0][i] = last[i] == 0.0 ? y[i] : last[i] == 1.0 ? z[i] : x[i];
        turned[1][i] = last[i] == 0.0 ? z[i] : last[i] == 1.0 ? x[i] : y[i];
        turned[2][i] = last[i] == 0.0 ? x[i] : last[i] == 1.0 ? y[i] : z[i];
    }
}

static inline void turn_corners(const struct local *l, struct corners *c)
{
    double last[W];
    EACH
    {
        double d0 = fabs(l->dx[i]), d1 = fabs(l->dy[i]), d2 = fabs(l->dz[i]);
        double larger = d0 > d1 ? d0 : d1, of_two = d0 > d1 ? 0.0 : 1.0;
        last[i] = d2 > larger ? 2.0 : of_two;
    }
    turn_axes(last, l->ox, l->oy, l->oz, c->from);
    turn_axes(last, l->dx, l->dy, l->dz, c->way);
    for (int k = 0; k < 3; k++)
        turn_axes(last, c->at[k][0], c->at[k][1], c->at[k][2], c->turned[k]);
}

static inline void meet_triangles(const struct corners *c, struct local *l,
                                  struct rmap_wave_pack *p)
{
    double s[3][3][W];
    for (int k = 0; k < 3; k++)
        EACH
        {
            double scale = 1 / c->way[2][i];
            double shear_x = c->way[0][i] * scale, shear_y = c->way[1][i] * scale;
            double along = c->turned[k][2][i] - c->from[2][i];
            s[k][2][i] = along;
            s[k][0][i] = (c->turned[k][0][i] - c->from[0][i]) - shear_x * along;
            s[k][1][i] = (c->turned[k][1][i] - c->from[1][i]) - shear_y * along;
        }
    EACH
    {
        double a0 = s[1][0][i] * s[2][1][i] - s[1][1][i] * s[2][0][i];
        double a1 = s[2][0][i] * s[0][1][i] - s[2][1][i] * s[0][0][i];
        double a2 = s[0][0][i] * s[1][1][i] - s[0][1][i] * s[1][0][i];
        double sum = a0 + a1 + a2, w0 = a0 / sum, w1 = a1 / sum, w2 = a2 / sum;
        p->t[i] = (w0 * s[0][2][i] + w1 * s[1][2][i] + w2 * s[2][2][i]) * (1 / c->way[2][i]);
        double x1 = c->at[1][0][i] - c->at[0][0][i], x2 = c->at[2][0][i] - c->at[0][0][i];
        double y1 = c->at[1][1][i] - c->at[0][1][i], y2 = c->at[2][1][i] - c->at[0][1][i];
        double z1 = c->at[1][2][i] - c->at[0][2][i], z2 = c->at[2][2][i] - c->at[0][2][i];
        l->x[i] = (c->at[0][0][i] + w1 * x1) + w2 * x2;
        l->y[i] = (c->at[0][1][i] + w1 * y1) + w2 * y2;
        l->z[i] = (c->at[0][2][i] + w1 * z1) + w2 * z2;
        l->nx[i] = y1 * z2 - z1 * y2;
        l->ny[i] = z1 * x2 - x1 * z2;
        l->nz[i] = x1 * y2 - y1 * x2;
    }
}

/* As rmap_step_float3 and rmap_step_normal. */
static inline void record(const double x[W], float out[W])
{
    EACH
    {
        out[i] = x[i] == x[i] ? (float)x[i] + 0.0f : (float)NAN;
    }
}

static inline void record_cosine(const double x[W], int16_t out[W])
{
    int32_t rounded[W];
    EACH
    {
        double low = x[i] > -1.0 ? x[i] : -1.0, bounded = low < 1.0 ? low : 1.0;
        double scaled = 32767.0 * bounded;
        rounded[i] = (int32_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
    }
    EACH
    {
        out[i] = (int16_t)rounded[i];
    }
}

static inline void conclude(struct rmap_wave_pack *pack)
{
    EACH
    {
        pack->t[i] = pack->t[i] > 0 ? pack->t[i] : 0;
        pack->cosine[i] =
            pack->dx[i] * pack->nx[i] + pack->dy[i] * pack->ny[i] + pack->dz[i] * pack->nz[i];
    }
    record(pack->px, pack->position[0]);
    record(pack->py, pack->position[1]);
    record(pack->pz, pack->position[2]);
    record_cosine(pack->nx, pack->normal[0]);
    record_cosine(pack->ny, pack->normal[1]);
    record_cosine(pack->nz, pack->normal[2]);
}

WIDE void rmap_wave_meet_shape(const struct rmap_compact_object *object, bool own, double behind,
                               struct rmap_wave_pack *pack)
{
    struct local l;
    to_local(&object->to_local, pack, &l);
    EACH
    {
        pack->odd[i] = 0.0;
    }
    if (object->kind == RMAP_FACING_FLAT) {
        flat(&l, pack);
    } else {
        if (own)
            cross_quadric(object, &l, pack);
        else
            meet_quadric(object, behind, &l, pack);
        quadric_normal(object, &l, pack);
    }
    to_world(object, &l, pack);
    if (!object->rigid)
        normalise(pack->nx, pack->ny, pack->nz);
    conclude(pack);
}

/* An affine map for each ray: rows of the matrix, then the shift. */
struct maps {
    double m[3][3][W], t[3][W];
};

static void gather_maps(const struct rmap_wave_pack *p, struct maps *local, struct maps *world)
{
    EACH
    {
        const struct rmap_affine *a = &p->object[i]->to_local, *b = &p->object[i]->to_world;
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) {
                local->m[j][k][i] = a->m[j][k];
                world->m[j][k][i] = b->m[j][k];
            }
        local->t[0][i] = a->t.x;
        local->t[1][i] = a->t.y;
        local->t[2][i] = a->t.z;
        world->t[0][i] = b->t.x;
        world->t[1][i] = b->t.y;
        world->t[2][i] = b->t.z;
    }
}

/* One row of the maps applied to vectors. */
static inline void apply_row(double (*const m)[W], const double x[W], const double y[W],
                             const double z[W], double out[W])
{
    EACH
    {
        out[i] = m[0][i] * x[i] + m[1][i] * y[i] + m[2][i] * z[i];
    }
}

static inline void shift(const double t[W], double x[W])
{
    EACH
    {
        x[i] = x[i] + t[i];
    }
}

static inline void apply_transposed(const struct maps *a, int k, const struct local *l,
                                    double out[W])
{
    EACH
    {
        out[i] = a->m[0][k][i] * l->nx[i] + a->m[1][k][i] * l->ny[i] + a->m[2][k][i] * l->nz[i];
    }
}

WIDE void rmap_wave_meet_meshes(struct rmap_wave_pack *p)
{
    struct local l;
    struct corners c;
    struct maps local, world;
    gather_maps(p, &local, &world);
    double *const from[3] = {l.ox, l.oy, l.oz}, *const way[3] = {l.dx, l.dy, l.dz};
    double *const to[3] = {p->px, p->py, p->pz}, *const normal[3] = {p->nx, p->ny, p->nz};
    for (int k = 0; k < 3; k++) {
        apply_row(local.m[k], p->px, p->py, p->pz, from[k]);
        shift(local.t[k], from[k]);
        apply_row(local.m[k], p->dx, p->dy, p->dz, way[k]);
    }
    gather_corners(p, &c);
    turn_corners(&l, &c);
    meet_triangles(&c, &l, p);
    for (int k = 0; k < 3; k++) {
        apply_row(world.m[k], l.x, l.y, l.z, to[k]);
        shift(world.t[k], to[k]);
        apply_transposed(&local, k, &l, normal[k]);
    }
    normalise(p->nx, p->ny, p->nz);
    EACH
    {
        p->odd[i] = 0.0;
    }
    conclude(p);
}
