/* SPDX-License-Identifier: MIT
 *
 * All rays of a portion traced again side by side: leg by leg, those that meet the same object
 * together. The numbers are bit for bit those of rmap_retrace, as long as nothing was mispredicted
 * on the way; rays that this cannot answer for are marked.
 */
#ifndef RMAP_COMPACT_WAVE_H
#define RMAP_COMPACT_WAVE_H

#include "compact/model.h"

#define RMAP_WAVE_WIDTH 8

/* kind of a leg: 1 + object, turn, and the rest; 0: a leg that goes alone. */
enum { RMAP_WAVE_OWN = 1, RMAP_WAVE_TURN = 1, RMAP_WAVE_OBJECT = 3 };
#define RMAP_WAVE_END     UINT32_MAX
#define RMAP_WAVE_MESH    (UINT32_C(0x10000000) << RMAP_WAVE_OBJECT) /* of any mesh */
#define RMAP_WAVE_OBJECTS ((1u << 28) - 1)

/* Rays that meet one object at the same time: in the world, before and after. */
struct rmap_wave_pack {
    double px[RMAP_WAVE_WIDTH], py[RMAP_WAVE_WIDTH], pz[RMAP_WAVE_WIDTH]; /* leg from; then to */
    double dx[RMAP_WAVE_WIDTH], dy[RMAP_WAVE_WIDTH], dz[RMAP_WAVE_WIDTH]; /* of it; then on */
    double nx[RMAP_WAVE_WIDTH], ny[RMAP_WAVE_WIDTH], nz[RMAP_WAVE_WIDTH]; /* surface normal */
    double t[RMAP_WAVE_WIDTH];                                            /* length of the leg */
    double cosine[RMAP_WAVE_WIDTH];                                       /* direction . normal */
    double odd[RMAP_WAVE_WIDTH];        /* not 0: a case that only rmap_retrace decides */
    float position[3][RMAP_WAVE_WIDTH]; /* as it is recorded */
    int16_t normal[3][RMAP_WAVE_WIDTH];
    const float *corner[RMAP_WAVE_WIDTH];                      /* meshes: as of the leg */
    const struct rmap_compact_object *object[RMAP_WAVE_WIDTH]; /* meshes alone */
    double n1[RMAP_WAVE_WIDTH], n2[RMAP_WAVE_WIDTH];           /* REFRACT */
    uint32_t random[4][RMAP_WAVE_WIDTH];                       /* DIFFUSE: counter; numbers */
    double through[RMAP_WAVE_WIDTH];                           /* DIFFUSE: 1 transmitted, else 0 */
};

/* wave_kernel.c: to the end of the legs. All of one analytic object (own: on which they start,
 * too); or each of a mesh of its own, whose triangle exists. */
void rmap_wave_meet_shape(const struct rmap_compact_object *object, bool own, double behind,
                          struct rmap_wave_pack *pack);
void rmap_wave_meet_meshes(struct rmap_wave_pack *pack);

void rmap_wave_turn(enum rmap_turn turn, uint64_t seed, struct rmap_wave_pack *pack);

struct rmap_wave_leg;

/* wave.c */
struct rmap_wave_ray {
    struct rmap_vec3 position, direction;
    struct rmap_wave_leg *leg; /* in hand */
    size_t first, row, end;    /* legs */
    size_t crossing, crossing_end;
    int32_t object; /* the leg starts on, or -1 */
    int channel;    /* that refracts */
    int departs;    /* channel that it starts with; -1: the source's colour */
};

/* Rays [first, end) and their rows. */
struct rmap_wave_range {
    size_t first, end, row, crossing;
};

/* A leg, all in one place: where it goes by the path, and where it went. */
struct rmap_wave_leg {
    double length, cosine;
    const float *corner; /* mesh: of its triangle, [3][4] */
    float position[3];   /* as recorded */
    uint32_t kind;       /* equal for legs that may go together */
    int32_t object;
    uint32_t event;
    int16_t normal[3];
    int16_t medium;
};

struct rmap_wave {
    struct rmap_wave_ray *ray;
    uint32_t *alive, *sorted;
    uint32_t *now;             /* [rays]: kind of the leg in hand; all ones: no more */
    struct rmap_wave_leg *leg; /* [legs of the range in hand] */
    uint8_t *careful;          /* [rays]: only rmap_retrace can tell */
    size_t cap_ray, cap_alive, cap_sorted, cap_now, cap_leg, cap_careful;
};
void rmap_wave_fini(struct rmap_wave *wave);

/* Predictions for all rays of r, into the columns that `predicted` has (rows are there). Lanes are
 * not touched. */
enum rmap_status rmap_wave_run(struct rmap_wave *wave, const struct rmap_retrace *r,
                               struct rmap_portion *predicted,
                               struct rmap_error *err) RMAP_MUST_USE;

/* wave_sum.c: what follows from the legs of these rays; *range moves to the rows after them. */
void rmap_wave_sum(struct rmap_wave *wave, const struct rmap_retrace *r,
                   struct rmap_wave_range *range, struct rmap_portion *out);

#endif
