/* SPDX-License-Identifier: MIT
 *
 * What the loops over the rays of a pack share. They have no branches, so that the compiler turns
 * them into vector instructions; for the files of the kernel alone.
 */
#ifndef RMAP_COMPACT_BATCH_LANES_H
#define RMAP_COMPACT_BATCH_LANES_H

#include <string.h>

#include "compact/batch.h"

#define W    RMAP_BATCH_WIDTH
#define EACH for (int i = 0; i < W; i++)

/* A wider instruction set where the machine has one. Results are the same: none of them contracts
 * multiplications and additions. */
#ifndef WIDE
#if RMAP_BATCH_AVX2
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif
#endif

typedef double pair __attribute__((vector_size(16)));
typedef double quad __attribute__((vector_size(32)));
typedef uint32_t words __attribute__((vector_size(16)));
typedef int32_t ints __attribute__((vector_size(16)));
typedef float floats __attribute__((vector_size(16)));
typedef int64_t pair_order __attribute__((vector_size(16)));
typedef int64_t quad_order __attribute__((vector_size(32)));
#if defined(__clang__)
#define MIX4(a, b, ...)  __builtin_shufflevector(a, b, __VA_ARGS__)
#define QUAD4(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#define PAIR(a, b, ...)  __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define MIX4(a, b, ...)  __builtin_shuffle(a, b, (words){__VA_ARGS__})
#define QUAD4(a, b, ...) __builtin_shuffle(a, b, (quad_order){__VA_ARGS__})
#define PAIR(a, b, ...)  __builtin_shuffle(a, b, (pair_order){__VA_ARGS__})
#endif

/* One ray's vector. */
static inline struct rmap_vec3 lane_of(const double x[W], const double y[W], const double z[W],
                                       int i)
{
    return rmap_vec3(x[i], y[i], z[i]);
}

static inline void set_lane(struct rmap_vec3 v, int i, double x[W], double y[W], double z[W])
{
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
}

/* Four rows of four numbers become columns. */
static inline void turn_rows(const quad row[4], quad column[4])
{
    quad even0 = QUAD4(row[0], row[1], 0, 4, 2, 6), odd0 = QUAD4(row[0], row[1], 1, 5, 3, 7);
    quad even1 = QUAD4(row[2], row[3], 0, 4, 2, 6), odd1 = QUAD4(row[2], row[3], 1, 5, 3, 7);
    column[0] = QUAD4(even0, even1, 0, 1, 4, 5);
    column[1] = QUAD4(odd0, odd1, 0, 1, 4, 5);
    column[2] = QUAD4(even0, even1, 2, 3, 6, 7);
    column[3] = QUAD4(odd0, odd1, 2, 3, 6, 7);
}

static inline void across(const double *a, const double *b, const double *c, const double *d,
                          double *o0, double *o1, double *o2, double *o3)
{
    quad row[4], column[4];
    memcpy(&row[0], a, sizeof *row);
    memcpy(&row[1], b, sizeof *row);
    memcpy(&row[2], c, sizeof *row);
    memcpy(&row[3], d, sizeof *row);
    turn_rows(row, column);
    memcpy(o0, &column[0], sizeof *column);
    memcpy(o1, &column[1], sizeof *column);
    memcpy(o2, &column[2], sizeof *column);
    memcpy(o3, &column[3], sizeof *column);
}

/* As vectors: of a loop over zeros compilers make a string instruction, which is slow for so few.
 */
static inline void fill(double to[W], double x)
{
    const quad all = {x, x, x, x};
    for (int i = 0; i < W; i += 4)
        memcpy(to + i, &all, sizeof all);
}

static inline void normalise(double x[W], double y[W], double z[W])
{
    EACH
    {
        double s = 1.0 / sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        x[i] = x[i] * s;
        y[i] = y[i] * s;
        z[i] = z[i] * s;
    }
}

/* An affine map for each ray: rows of the matrix, then the shift. */
struct maps {
    double m[12][W];
};

/* The object that each ray meets. */
static inline void gather_map(const struct rmap_affine *const map[W], struct maps *out)
{
    for (int i = 0; i < W; i += 4)
        for (int k = 0; k < 12; k += 4)
            across((const double *)map[i] + k, (const double *)map[i + 1] + k,
                   (const double *)map[i + 2] + k, (const double *)map[i + 3] + k, out->m[k] + i,
                   out->m[k + 1] + i, out->m[k + 2] + i, out->m[k + 3] + i);
}

static inline void gather_maps(const struct rmap_batch_pack *p, struct maps *local,
                               struct maps *world)
{
    const struct rmap_affine *a[W], *b[W];
    EACH
    {
        a[i] = &p->object[i]->to_local;
        b[i] = &p->object[i]->to_world;
    }
    gather_map(a, local);
    gather_map(b, world);
}

/* Row k of the maps applied to points, to vectors, and column k to normals. */
static inline void apply_point(const struct maps *a, int k, const double x[W], const double y[W],
                               const double z[W], double out[W])
{
    EACH
    {
        out[i] = (a->m[3 * k][i] * x[i] + a->m[3 * k + 1][i] * y[i] + a->m[3 * k + 2][i] * z[i]) +
                 a->m[9 + k][i];
    }
}

static inline void apply_vector(const struct maps *a, int k, const double x[W], const double y[W],
                                const double z[W], double out[W])
{
    EACH
    {
        out[i] = a->m[3 * k][i] * x[i] + a->m[3 * k + 1][i] * y[i] + a->m[3 * k + 2][i] * z[i];
    }
}

static inline void apply_transposed(const struct maps *a, int k, const double x[W],
                                    const double y[W], const double z[W], double out[W])
{
    EACH
    {
        out[i] = a->m[k][i] * x[i] + a->m[3 + k][i] * y[i] + a->m[6 + k][i] * z[i];
    }
}

/* In the objects' frames. */
struct local {
    double ox[W], oy[W], oz[W], dx[W], dy[W], dz[W];
    double x[W], y[W], z[W], nx[W], ny[W], nz[W];
};

static inline void to_local(const struct maps *local, const struct rmap_batch_pack *p,
                            struct local *l)
{
    apply_point(local, 0, p->px, p->py, p->pz, l->ox);
    apply_point(local, 1, p->px, p->py, p->pz, l->oy);
    apply_point(local, 2, p->px, p->py, p->pz, l->oz);
    apply_vector(local, 0, p->dx, p->dy, p->dz, l->dx);
    apply_vector(local, 1, p->dx, p->dy, p->dz, l->dy);
    apply_vector(local, 2, p->dx, p->dy, p->dz, l->dz);
}

static inline void points_to_world(const struct maps *world, const struct local *l,
                                   struct rmap_batch_pack *p)
{
    apply_point(world, 0, l->x, l->y, l->z, p->px);
    apply_point(world, 1, l->x, l->y, l->z, p->py);
    apply_point(world, 2, l->x, l->y, l->z, p->pz);
}

static inline void to_world(const struct maps *local, const struct maps *world,
                            const struct local *l, struct rmap_batch_pack *p)
{
    points_to_world(world, l, p);
    apply_transposed(local, 0, l->nx, l->ny, l->nz, p->nx);
    apply_transposed(local, 1, l->nx, l->ny, l->nz, p->ny);
    apply_transposed(local, 2, l->nx, l->ny, l->nz, p->nz);
}

/* As rmap_step_float3 and rmap_step_normal. */
static inline void record(const double x[W], float out[W])
{
    EACH
    {
        out[i] = x[i] == x[i] ? (float)x[i] + 0.0f : (float)NAN;
    }
}

static inline void record_cosine(const double x[W], int32_t out[W])
{
    EACH
    {
        double low = x[i] > -1.0 ? x[i] : -1.0, bounded = low < 1.0 ? low : 1.0;
        double scaled = 32767.0 * bounded;
        out[i] = (int32_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
    }
}

static inline void record_position(struct rmap_batch_pack *pack)
{
    record(pack->px, pack->position[0]);
    record(pack->py, pack->position[1]);
    record(pack->pz, pack->position[2]);
}

static inline void record_end(struct rmap_batch_pack *pack)
{
    int32_t nx[W], ny[W];
    record_position(pack);
    record_cosine(pack->nx, nx);
    record_cosine(pack->ny, ny);
    record_cosine(pack->nz, pack->normal_z);
    EACH
    {
        pack->normal_xy[i] = ((uint32_t)nx[i] & 0xffff) | (uint32_t)ny[i] << 16;
    }
}

static inline void arrive(struct rmap_batch_pack *pack)
{
    EACH
    {
        pack->t[i] = pack->t[i] > 0 ? pack->t[i] : 0;
        pack->cosine[i] =
            pack->dx[i] * pack->nx[i] + pack->dy[i] * pack->ny[i] + pack->dz[i] * pack->nz[i];
    }
}

static inline void conclude(struct rmap_batch_pack *pack)
{
    arrive(pack);
    record_end(pack);
}

#endif
