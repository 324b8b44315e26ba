/* SPDX-License-Identifier: MIT
 *
 * Triangles of retrace_surface.c for a pack of rays, as wave_kernel.c has the other surfaces.
 */
#include "compact/wave_lanes.h"

/* Corners of the triangles: as they are, and with the axes turned so that the leg's is the last. */
struct corners {
    double at[3][3][W], turned[3][3][W]; /* [corner][axis]; from where the leg starts */
    double way[3][W];
};

/* A loop: of vectors that change their element, compilers make two halves here. */
static inline void widen(const float *from, quad *to)
{
    double four[4];
    for (int k = 0; k < 4; k++)
        four[k] = (double)from[k];
    memcpy(to, four, sizeof four);
}

static inline void gather_corners(const struct rmap_wave_pack *p, struct corners *c)
{
    double spare[4];
    for (int i = 0; i < W; i += 4)
        for (int k = 0; k < 3; k++) {
            quad row[4];
            for (int j = 0; j < 4; j++)
                widen(p->corner[i + j] + 4 * k, &row[j]);
            turn_quads(row, c->at[k][0] + i, c->at[k][1] + i, c->at[k][2] + i, spare);
        }
}

/* All ones for the axis that is to be the last; written out, as some of these loops came out with
 * branches that nobody can predict. */
struct last {
    quad_order x, y, z;
};

static inline void get(const double from[4], quad *to)
{
    memcpy(to, from, sizeof *to);
}

static inline void choose(const struct last *m, const quad *x, const quad *y, const quad *z,
                          double to[4])
{
    quad_order chosen = (m->x & (quad_order)*x) | (m->y & (quad_order)*y) | (m->z & (quad_order)*z);
    memcpy(to, &chosen, sizeof chosen);
}

/* Numbers [at, at + 4) of x, y, z with the last axis at the end. */
static inline void turn_axes(const struct last *last, int at, const double x[W], const double y[W],
                             const double z[W], double (*turned)[W])
{
    quad vx, vy, vz;
    get(x + at, &vx);
    get(y + at, &vy);
    get(z + at, &vz);
    choose(last, &vy, &vz, &vx, turned[0] + at);
    choose(last, &vz, &vx, &vy, turned[1] + at);
    choose(last, &vx, &vy, &vz, turned[2] + at);
}

static inline void find_last(const struct local *l, int at, struct last *last)
{
    const quad_order size = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX}; /* without the sign */
    quad x, y, z;
    get(l->dx + at, &x);
    get(l->dy + at, &y);
    get(l->dz + at, &z);
    quad d0 = (quad)((quad_order)x & size), d1 = (quad)((quad_order)y & size);
    quad d2 = (quad)((quad_order)z & size);
    quad_order x_first = d0 > d1;
    quad larger = (quad)(((quad_order)d0 & x_first) | ((quad_order)d1 & ~x_first));
    last->z = d2 > larger;
    last->x = x_first & ~last->z;
    last->y = ~x_first & ~last->z;
}

static inline void turn_corners(const struct local *l, struct corners *c)
{
    double off[3][3][W];
    for (int k = 0; k < 3; k++)
        EACH
        {
            off[k][0][i] = c->at[k][0][i] - l->ox[i];
            off[k][1][i] = c->at[k][1][i] - l->oy[i];
            off[k][2][i] = c->at[k][2][i] - l->oz[i];
        }
    for (int i = 0; i < W; i += 4) {
        struct last last;
        find_last(l, i, &last);
        turn_axes(&last, i, l->dx, l->dy, l->dz, c->way);
        for (int k = 0; k < 3; k++)
            turn_axes(&last, i, off[k][0], off[k][1], off[k][2], c->turned[k]);
    }
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
            double along = c->turned[k][2][i];
            s[k][2][i] = along;
            s[k][0][i] = c->turned[k][0][i] - shear_x * along;
            s[k][1][i] = c->turned[k][1][i] - shear_y * along;
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

WIDE void rmap_wave_meet_meshes(struct rmap_wave_pack *p)
{
    struct local l;
    struct corners c;
    struct maps local, world;
    gather_maps(p, &local, &world);
    to_local(&local, p, &l);
    gather_corners(p, &c);
    turn_corners(&l, &c);
    meet_triangles(&c, &l, p);
    to_world(&local, &world, &l, p);
    normalise(p->nx, p->ny, p->nz);
    fill(p->odd, 0.0);
    conclude(p);
}
