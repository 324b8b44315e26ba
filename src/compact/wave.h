/* SPDX-License-Identifier: MIT
 *
 * All rays of a portion traced again side by side, those together whose next legs take the same
 * steps. The numbers are bit for bit those of rmap_retrace, as long as nothing was mispredicted on
 * the way; rays that this cannot answer for are marked.
 */
#ifndef RMAP_COMPACT_WAVE_H
#define RMAP_COMPACT_WAVE_H

#include "compact/model.h"
#include "compact/retrace.h"

/* The kernel is compiled for AVX2, too. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#define RMAP_WAVE_AVX2 1
#else
#define RMAP_WAVE_AVX2 0
#endif

#define RMAP_WAVE_WIDTH 8
#define RMAP_WAVE_RAYS  128 /* under way at a time: their numbers stay in the processor's cache */

#define RMAP_WAVE_AHEAD 64 /* rays that are looked at together before they set out */

/* Legs of rays that are looked at together lie on a shelf, which is used again when all of them
 * have arrived: so few stay in the cache. Whatever is under way, one is free. */
#define RMAP_WAVE_SHELVES (RMAP_WAVE_RAYS + 1)

/* What a leg comes to. */
enum rmap_wave_kind {
    RMAP_WAVE_ALONE,   /* one by one */
    RMAP_WAVE_NOTHING, /* out of the scene */
    RMAP_WAVE_FLAT,
    RMAP_WAVE_QUADRIC,
    RMAP_WAVE_OWN_QUADRIC, /* the one that it starts on */
    RMAP_WAVE_MESH,
    RMAP_WAVE_KINDS
};

struct rmap_wave_leg;

/* A ray under way, in two cache lines. */
struct rmap_wave_ray {
    double state[8];               /* position, direction; the rest is room for whole vectors */
    struct rmap_wave_leg *leg;     /* in hand */
    size_t row, end;               /* its row, and that after the ray's last */
    size_t crossing, crossing_end; /* registrations */
    uint64_t id;
    uint32_t index;  /* of the ray in the portion */
    uint32_t step;   /* number of the leg, from 0 */
    int16_t channel; /* that refracts */
    int16_t departs; /* channel that the ray starts with; -1: the source's colour */
    uint16_t shelf;  /* that its legs lie on */
    uint16_t number; /* of the ray among those under way */
};

/* Rays whose legs are of one kind: in the world, before and after. */
struct rmap_wave_pack {
    const struct rmap_wave_ray *ray[RMAP_WAVE_WIDTH];
    const struct rmap_compact_object *object[RMAP_WAVE_WIDTH];            /* NOTHING: none */
    const float *corner[RMAP_WAVE_WIDTH];                                 /* MESH: as of the leg */
    double px[RMAP_WAVE_WIDTH], py[RMAP_WAVE_WIDTH], pz[RMAP_WAVE_WIDTH]; /* leg from; then to */
    double dx[RMAP_WAVE_WIDTH], dy[RMAP_WAVE_WIDTH], dz[RMAP_WAVE_WIDTH]; /* of it; then on */
    double nx[RMAP_WAVE_WIDTH], ny[RMAP_WAVE_WIDTH], nz[RMAP_WAVE_WIDTH]; /* surface normal */
    double t[RMAP_WAVE_WIDTH];                                            /* length of the leg */
    double cosine[RMAP_WAVE_WIDTH];                                       /* direction . normal */
    double odd[RMAP_WAVE_WIDTH]; /* not 0: a case that only rmap_retrace decides */
    /* The end as it is recorded. */
    float position[3][RMAP_WAVE_WIDTH];
    uint32_t normal_xy[RMAP_WAVE_WIDTH]; /* 16 bits each */
    int32_t normal_z[RMAP_WAVE_WIDTH];
    double n1[RMAP_WAVE_WIDTH], n2[RMAP_WAVE_WIDTH]; /* REFRACT */
    uint32_t random[4][RMAP_WAVE_WIDTH];             /* DIFFUSE: counter; numbers */
    double through[RMAP_WAVE_WIDTH];                 /* DIFFUSE: 1 transmitted, else 0 */
};

/* Flags of a leg: it is not part of the ray's length; what happens at its end leaves any colour
 * alone, if it comes from the back or from the front; a registration may lie on it; its medium may
 * change colours. */
enum {
    RMAP_WAVE_LEFT = 1,
    RMAP_WAVE_GREY_BACK = 2,
    RMAP_WAVE_GREY_FRONT = 4,
    RMAP_WAVE_CROSSES = 8,
    RMAP_WAVE_TINTS = 16
};

/* A leg: where it goes by the path, and how it went. */
struct rmap_wave_leg {
    union {
        const float *corner; /* MESH: of its triangle, [3][4]; of others, what is read first */
        double length;       /* of a leg done */
    } way;
    double cosine;   /* of a leg done: direction . normal, NaN where nothing was met */
    uint32_t object; /* at most n_object, which is none */
    uint16_t medium; /* at most n_medium, which is none */
    union {
        struct {
            uint8_t queue; /* RMAP_WAVE_TURNS x kind + turn */
            uint8_t flags;
        };
        uint16_t step; /* both: flags << 8 | queue */
    };
};

/* What is known of a flat object, of any object's legs, and of those that meet none
 * beforehand. */
void rmap_wave_set_flat(struct rmap_compact_object *object);
void rmap_wave_guide(const struct rmap_scene *scene, const struct rmap_compact_object *object,
                     struct rmap_compact_guide *guide);
void rmap_wave_guide_out(const struct rmap_compact_model *model, struct rmap_compact_guide *guide);

/* Queue and flags, as rmap_compact_guide has them, of a leg of this kind. */
uint32_t rmap_wave_step(const struct rmap_compact_guide *guide, uint32_t kind, uint32_t event);

/* Where a leg starts, of the ray that is summed up. */
struct rmap_wave_start {
    double optical_path, index; /* up to there; on the leg */
};

#define RMAP_WAVE_TURNS  4
#define RMAP_WAVE_QUEUES (RMAP_WAVE_KINDS * RMAP_WAVE_TURNS)

/* Rays that wait for a leg of one kind, those that came as number `first` up to `end`, in rings;
 * and after them those that have arrived. */
struct rmap_wave_queues {
    uint32_t first[RMAP_WAVE_QUEUES + 1], end[RMAP_WAVE_QUEUES + 1];
    uint16_t ray[RMAP_WAVE_QUEUES + 1][RMAP_WAVE_RAYS];
};

struct rmap_wave {
    uint8_t *careful;                   /* [rays]: only rmap_retrace can tell */
    struct rmap_wave_leg *leg;          /* [shelves][shelf_legs], or [legs] */
    size_t shelf_legs;                  /* 0: rays' legs are too uneven: one shelf of all of them */
    size_t on_shelf[RMAP_WAVE_SHELVES]; /* rays that have not arrived */
    uint16_t idle[RMAP_WAVE_SHELVES];   /* [n_idle] shelves */
    size_t n_idle;
    void *room;                /* of `ray` */
    struct rmap_wave_ray *ray; /* [RMAP_WAVE_RAYS + 1]: the last is nobody's; on a cache line */
    struct rmap_wave_queues *queue;
    struct rmap_wave_leg nobodys;  /* leg in hand */
    struct rmap_wave_start *start; /* [legs of the longest ray] */
    size_t cap_careful, cap_leg, cap_room, cap_queue, cap_start;
};
void rmap_wave_fini(struct rmap_wave *wave);

/* Predictions for all rays of r, into the columns that `predicted` has (rows are there). Lanes are
 * not touched. */
enum rmap_status rmap_wave_run(struct rmap_wave *wave, const struct rmap_retrace *r,
                               struct rmap_portion *predicted,
                               struct rmap_error *err) RMAP_MUST_USE;

/* What the steps of a run share. */
struct rmap_wave_run {
    struct rmap_wave *wave;
    const struct rmap_retrace *r;
    struct rmap_portion *out;
    size_t ray, row, crossing; /* the next that sets out */
    struct rmap_wave_leg *leg; /* its first */
    uint16_t shelf;
    size_t ready, ready_row, ready_crossing;          /* legs of rays before that one are there */
    struct rmap_departure departure[RMAP_WAVE_AHEAD]; /* of the rays before `ready` */
    struct rmap_compact_light light;                  /* of the ray that is summed up */
};

#endif
