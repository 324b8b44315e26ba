/* SPDX-License-Identifier: MIT
 *
 * Flat objects and triangles of retrace_surface.c, four rays of a pack at a time, in registers.
 * Compiled once for each set of instructions: vectors that are wider than those of the file that
 * a function stands in are taken apart before it becomes part of another.
 */
#ifndef RMAP_COMPACT_WAVE_QUADS_H
#define RMAP_COMPACT_WAVE_QUADS_H

#include <stddef.h>

#include "base/wide.h"
#include "compact/wave_lanes.h"

/* Vectors by pointer: passed by value, those wider than the registers change the ABI. */
struct three {
    quad x, y, z;
};

static inline void get(const double from[4], quad *to)
{
    memcpy(to, from, sizeof *to);
}

static inline void put(const quad *from, double to[4])
{
    memcpy(to, from, sizeof *from);
}

/* Rays [at, at + 4) of x, y, z; and back. */
static inline void get_three(const double x[W], const double y[W], const double z[W], int at,
                             struct three *to)
{
    get(x + at, &to->x);
    get(y + at, &to->y);
    get(z + at, &to->z);
}

static inline void put_three(const struct three *from, int at, double x[W], double y[W],
                             double z[W])
{
    put(&from->x, x + at);
    put(&from->y, y + at);
    put(&from->z, z + at);
}

/* x where the mask is all ones, y where it is 0. */
static inline void choose(const quad_order *mask, const quad *x, const quad *y, quad *to)
{
    *to = (quad)(((quad_order)*x & *mask) | ((quad_order)*y & ~*mask));
}

/* An affine map for each of the rays: rows of the matrix, then the shift. */
struct quad_maps {
    quad m[12];
};

static inline void get_maps(const struct rmap_affine *const map[4], struct quad_maps *to)
{
    RMAP_UNROLL for (int k = 0; k < 12; k += 4)
    {
        quad row[4];
        RMAP_UNROLL for (int j = 0; j < 4; j++) get((const double *)map[j] + k, &row[j]);
        turn_rows(row, to->m + k);
    }
}

static inline void map_point(const struct quad_maps *a, const struct three *v, struct three *to)
{
    const quad *m = a->m;
    to->x = (m[0] * v->x + m[1] * v->y + m[2] * v->z) + m[9];
    to->y = (m[3] * v->x + m[4] * v->y + m[5] * v->z) + m[10];
    to->z = (m[6] * v->x + m[7] * v->y + m[8] * v->z) + m[11];
}

static inline void map_vector(const struct quad_maps *a, const struct three *v, struct three *to)
{
    const quad *m = a->m;
    to->x = m[0] * v->x + m[1] * v->y + m[2] * v->z;
    to->y = m[3] * v->x + m[4] * v->y + m[5] * v->z;
    to->z = m[6] * v->x + m[7] * v->y + m[8] * v->z;
}

static inline void map_normal(const struct quad_maps *a, const struct three *v, struct three *to)
{
    const quad *m = a->m;
    to->x = m[0] * v->x + m[3] * v->y + m[6] * v->z;
    to->y = m[1] * v->x + m[4] * v->y + m[7] * v->z;
    to->z = m[2] * v->x + m[5] * v->y + m[8] * v->z;
}

static inline void dot(const struct three *a, const struct three *b, quad *to)
{
    *to = a->x * b->x + a->y * b->y + a->z * b->z;
}

/* A loop: there are no square roots of vectors. */
static inline void normalise_three(struct three *v)
{
    double root[4];
    quad s;
    dot(v, v, &s);
    put(&s, root);
    RMAP_UNROLL for (int j = 0; j < 4; j++) root[j] = sqrt(root[j]);
    get(root, &s);
    s = 1.0 / s;
    v->x = v->x * s;
    v->y = v->y * s;
    v->z = v->z * s;
}

/* As rmap_step_float: what was no number is none as a float, either. */
static inline void record_quad(const quad *x, float to[4])
{
    const floats nan = {NAN, NAN, NAN, NAN};
    floats f = __builtin_convertvector(*x, floats) + 0.0f;
    ints number = f == f;
    f = (floats)(((ints)f & number) | ((ints)nan & ~number));
    memcpy(to, &f, sizeof f);
}

static inline void record_end_of(const struct three *v, int at, struct rmap_wave_pack *p)
{
    record_quad(&v->x, p->position[0] + at);
    record_quad(&v->y, p->position[1] + at);
    record_quad(&v->z, p->position[2] + at);
}

/* As rmap_step_cosine. */
static inline void cosine_of(const quad *x, ints *to)
{
    const quad least = {-1.0, -1.0, -1.0, -1.0}, most = -least, half = 0.5 * most;
    quad low, bounded, up;
    quad_order above = *x > least;
    choose(&above, x, &least, &low);
    quad_order below = low < most;
    choose(&below, &low, &most, &bounded);
    quad scaled = 32767.0 * bounded, zero = half - half, down = -half;
    quad_order negative = scaled < zero;
    choose(&negative, &down, &half, &up);
    *to = __builtin_convertvector(scaled + up, ints);
}

static inline void record_normal(const struct three *n, int at, struct rmap_wave_pack *p)
{
    ints x, y, z;
    cosine_of(&n->x, &x);
    cosine_of(&n->y, &y);
    cosine_of(&n->z, &z);
    words xy = ((words)x & 0xffff) | (words)y << 16;
    memcpy(p->normal_xy + at, &xy, sizeof xy);
    memcpy(p->normal_z + at, &z, sizeof z);
}

/* The length of a leg that goes this way, and its end. */
static inline void arrive_at(const quad *t, const struct three *end, const struct three *way,
                             const struct three *normal, int at, struct rmap_wave_pack *p)
{
    const quad zero = {0.0, 0.0, 0.0, 0.0};
    quad length, cosine;
    quad_order ahead = *t > zero;
    choose(&ahead, t, &zero, &length);
    dot(way, normal, &cosine);
    put(&length, p->t + at);
    put(&cosine, p->cosine + at);
    put(&zero, p->odd + at);
    put_three(end, at, p->px, p->py, p->pz);
    put_three(normal, at, p->nx, p->ny, p->nz);
    record_end_of(end, at, p);
}

/* A loop: of vectors that change their element, compilers make two halves here. */
static inline void widen(const float *from, quad *to)
{
    double four[4];
    RMAP_UNROLL for (int k = 0; k < 4; k++) four[k] = (double)from[k];
    memcpy(to, four, sizeof four);
}

/* Corner k of four triangles. */
static inline void get_corner(const float *const triangle[4], int k, struct three *to)
{
    quad row[4], column[4];
    RMAP_UNROLL for (int j = 0; j < 4; j++) widen(triangle[j] + 4 * k, &row[j]);
    turn_rows(row, column);
    *to = (struct three){column[0], column[1], column[2]};
}

/* All ones where this axis is to be the last; neither: y is. */
struct last {
    quad_order x, z;
};

static inline void find_last(const struct three *way, struct last *last)
{
    const quad_order size = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX}; /* without the sign */
    quad x = (quad)((quad_order)way->x & size), y = (quad)((quad_order)way->y & size);
    quad z = (quad)((quad_order)way->z & size), larger;
    quad_order x_first = x > y;
    choose(&x_first, &x, &y, &larger);
    last->z = z > larger;
    last->x = x_first & ~last->z;
}

/* The axes in order, with the last one at the end. */
static inline void turn_axes(const struct last *last, const struct three *v, struct three *turned)
{
    quad x, y, z;
    choose(&last->x, &v->y, &v->z, &x);
    choose(&last->x, &v->z, &v->x, &y);
    choose(&last->x, &v->x, &v->y, &z);
    choose(&last->z, &v->x, &x, &turned->x);
    choose(&last->z, &v->y, &y, &turned->y);
    choose(&last->z, &v->z, &z, &turned->z);
}

static inline void subtract(const struct three *a, const struct three *b, struct three *to)
{
    *to = (struct three){a->x - b->x, a->y - b->y, a->z - b->z};
}

/* Along a way of which the last axis is the longest: weights of corners 1 and 2, and the length. */
static inline void weigh(const struct three corner[3], const struct three *from,
                         const struct three *way, quad *w1, quad *w2, quad *t)
{
    struct last last;
    struct three turned, s[3];
    find_last(way, &last);
    turn_axes(&last, way, &turned);
    quad scale = 1 / turned.z, shear_x = turned.x * scale, shear_y = turned.y * scale;
    RMAP_UNROLL for (int k = 0; k < 3; k++)
    {
        struct three off;
        subtract(&corner[k], from, &off);
        turn_axes(&last, &off, &s[k]);
        s[k].x = s[k].x - shear_x * s[k].z;
        s[k].y = s[k].y - shear_y * s[k].z;
    }
    quad a0 = s[1].x * s[2].y - s[1].y * s[2].x;
    quad a1 = s[2].x * s[0].y - s[2].y * s[0].x;
    quad a2 = s[0].x * s[1].y - s[0].y * s[1].x;
    quad sum = a0 + a1 + a2, w0 = a0 / sum;
    *w1 = a1 / sum;
    *w2 = a2 / sum;
    *t = (w0 * s[0].z + *w1 * s[1].z + *w2 * s[2].z) * scale;
}

/* Point and normal where a leg meets a triangle, and how far that is. */
static inline void meet(const struct three corner[3], const struct three *from,
                        const struct three *way, struct three *point, struct three *normal, quad *t)
{
    quad w1, w2;
    struct three a, b;
    weigh(corner, from, way, &w1, &w2, t);
    subtract(&corner[1], &corner[0], &a);
    subtract(&corner[2], &corner[0], &b);
    point->x = (corner[0].x + w1 * a.x) + w2 * b.x;
    point->y = (corner[0].y + w1 * a.y) + w2 * b.y;
    point->z = (corner[0].z + w1 * a.z) + w2 * b.z;
    normal->x = a.y * b.z - a.z * b.y;
    normal->y = a.z * b.x - a.x * b.z;
    normal->z = a.x * b.y - a.y * b.x;
}

/* The maps of the objects that rays from `at` on meet. */
static inline void get_local(const struct rmap_wave_pack *p, int at, struct quad_maps *to)
{
    const struct rmap_affine *map[4];
    RMAP_UNROLL for (int j = 0; j < 4; j++) map[j] = &p->object[at + j]->to_local;
    get_maps(map, to);
}

static inline void get_world(const struct rmap_wave_pack *p, int at, struct quad_maps *to)
{
    const struct rmap_affine *map[4];
    RMAP_UNROLL for (int j = 0; j < 4; j++) map[j] = &p->object[at + j]->to_world;
    get_maps(map, to);
}

static inline void meet_four(struct rmap_wave_pack *p, int at)
{
    struct quad_maps local, world;
    struct three corner[3], origin, way, from, along, met, end, steep, normal;
    quad t;
    get_local(p, at, &local);
    get_three(p->px, p->py, p->pz, at, &origin);
    get_three(p->dx, p->dy, p->dz, at, &way);
    map_point(&local, &origin, &from);
    map_vector(&local, &way, &along);
    RMAP_UNROLL for (int k = 0; k < 3; k++) get_corner(p->corner + at, k, &corner[k]);
    meet(corner, &from, &along, &met, &steep, &t);
    map_normal(&local, &steep, &normal);
    normalise_three(&normal);
    get_world(p, at, &world);
    map_point(&world, &met, &end);
    arrive_at(&t, &end, &way, &normal, at, p);
    record_normal(&normal, at, p);
}

static inline void meet_meshes(struct rmap_wave_pack *p)
{
    for (int i = 0; i < W; i += 4)
        meet_four(p, i);
}

/* Normals of flat objects are known beforehand, and recorded. */
static inline void get_normals(int at, struct rmap_wave_pack *p, struct three *normal)
{
    quad row[4], column[4];
    RMAP_UNROLL for (int j = 0; j < 4; j++) get(p->object[at + j]->flat, &row[j]);
    turn_rows(row, column);
    *normal = (struct three){column[0], column[1], column[2]};
    RMAP_UNROLL for (int j = 0; j < 4; j++)
    {
        uint64_t recorded;
        memcpy(&recorded, &p->object[at + j]->flat[3], sizeof recorded);
        p->normal_xy[at + j] = (uint32_t)recorded;
        p->normal_z[at + j] = (int32_t)(recorded >> 32);
    }
}

static inline void meet_four_flats(struct rmap_wave_pack *p, int at)
{
    const quad zero = {0.0, 0.0, 0.0, 0.0};
    struct quad_maps local, world;
    struct three origin, way, from, along, met, end, normal;
    get_local(p, at, &local);
    get_three(p->px, p->py, p->pz, at, &origin);
    get_three(p->dx, p->dy, p->dz, at, &way);
    map_point(&local, &origin, &from);
    map_vector(&local, &way, &along);
    quad t = -from.z / along.z;
    met = (struct three){from.x + t * along.x, from.y + t * along.y, zero};
    get_world(p, at, &world);
    map_point(&world, &met, &end);
    get_normals(at, p, &normal);
    arrive_at(&t, &end, &way, &normal, at, p);
}

static inline void meet_flats(struct rmap_wave_pack *p)
{
    for (int i = 0; i < W; i += 4)
        meet_four_flats(p, i);
}

static inline void load(struct rmap_wave_pack *p)
{
    for (int i = 0; i < W; i += 4) {
        quad row[4], column[4];
        RMAP_UNROLL for (int j = 0; j < 4; j++) get(p->ray[i + j]->state, &row[j]);
        turn_rows(row, column);
        put(&column[0], p->px + i);
        put(&column[1], p->py + i);
        put(&column[2], p->pz + i);
        put(&column[3], p->dx + i);
        RMAP_UNROLL for (int j = 0; j < 4; j++) get(p->ray[i + j]->state + 4, &row[j]);
        turn_rows(row, column);
        put(&column[0], p->dy + i);
        put(&column[1], p->dz + i);
    }
}

/* Two rows of two numbers become columns. */
static inline void turn_pairs(const double a[2], const double b[2], void *column0, void *column1)
{
    pair x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    pair low = PAIR(x, y, 0, 2), high = PAIR(x, y, 1, 3);
    memcpy(column0, &low, sizeof low);
    memcpy(column1, &high, sizeof high);
}

_Static_assert(offsetof(struct rmap_wave_leg, cosine) == sizeof(double), "behind the length");

static inline void store(const struct rmap_wave_pack *p, struct rmap_wave_ray *const to[W])
{
    for (int i = 0; i < W; i += 4) {
        quad row[4], column[4];
        get(p->px + i, &column[0]);
        get(p->py + i, &column[1]);
        get(p->pz + i, &column[2]);
        get(p->dx + i, &column[3]);
        turn_rows(column, row);
        RMAP_UNROLL for (int j = 0; j < 4; j++) put(&row[j], to[i + j]->state);
    }
    RMAP_UNROLL for (int i = 0; i < W; i += 2)
    {
        struct rmap_wave_ray *a = to[i], *b = to[i + 1];
        struct rmap_wave_leg *done_a = a->leg, *done_b = b->leg;
        turn_pairs(p->dy + i, p->dz + i, a->state + 4, b->state + 4);
        turn_pairs(p->t + i, p->cosine + i, done_a, done_b); /* length and cosine */
    }
}

#endif
