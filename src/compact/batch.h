/* SPDX-License-Identifier: MIT
 *
 * All rays of a portion traced again side by side, those together whose next segments take the same
 * steps. The numbers are bit for bit those of rmap_retrace, as long as nothing was mispredicted on
 * the way; rays that this cannot answer for are marked.
 */
#ifndef RMAP_COMPACT_BATCH_H
#define RMAP_COMPACT_BATCH_H

#include "compact/model.h"
#include "compact/retrace.h"

/* The kernel is compiled for AVX2, too. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#define RMAP_BATCH_AVX2 1
#else
#define RMAP_BATCH_AVX2 0
#endif

#define RMAP_BATCH_WIDTH 8
#define RMAP_BATCH_RAYS  128 /* under way at a time: their numbers stay in the processor's cache */

#define RMAP_BATCH_AHEAD 64 /* rays that are looked at together before they set out */

/* Segments of rays that are looked at together lie on a slab, which is used again when all of them
 * have arrived: so few stay in the cache. Whatever is under way, one is free. */
#define RMAP_BATCH_SLABS (RMAP_BATCH_RAYS + 1)

/* What a segment comes to. */
enum rmap_batch_kind {
    RMAP_BATCH_ALONE,   /* one by one */
    RMAP_BATCH_NOTHING, /* out of the scene */
    RMAP_BATCH_FLAT,
    RMAP_BATCH_QUADRIC,
    RMAP_BATCH_OWN_QUADRIC, /* the one that it starts on */
    RMAP_BATCH_MESH,
    RMAP_BATCH_KINDS
};

struct rmap_batch_segment;

/* A ray under way, in two cache lines. */
struct rmap_batch_ray {
    double state[8]; /* position, direction; the rest is room for whole vectors */
    struct rmap_batch_segment *segment; /* in hand */
    size_t row, end;                    /* its row, and that after the ray's last */
    size_t crossing, crossing_end;      /* registrations */
    uint64_t id;
    uint32_t index;  /* of the ray in the portion */
    uint32_t step;   /* number of the segment, from 0 */
    int16_t channel; /* that refracts */
    int16_t departs; /* channel that the ray starts with; -1: the source's colour */
    uint16_t slab;   /* that its segments lie on */
    uint16_t number; /* of the ray among those under way */
};

/* Rays whose segments are of one kind: in the world, before and after. */
struct rmap_batch_pack {
    const struct rmap_batch_ray *ray[RMAP_BATCH_WIDTH];
    const struct rmap_compact_object *object[RMAP_BATCH_WIDTH]; /* NOTHING: none */
    const float *corner[RMAP_BATCH_WIDTH];                      /* MESH: as of the segment */
    double px[RMAP_BATCH_WIDTH], py[RMAP_BATCH_WIDTH],
        pz[RMAP_BATCH_WIDTH]; /* segment from; then to */
    double dx[RMAP_BATCH_WIDTH], dy[RMAP_BATCH_WIDTH], dz[RMAP_BATCH_WIDTH]; /* of it; then on */
    double nx[RMAP_BATCH_WIDTH], ny[RMAP_BATCH_WIDTH], nz[RMAP_BATCH_WIDTH]; /* surface normal */
    double t[RMAP_BATCH_WIDTH];      /* length of the segment */
    double cosine[RMAP_BATCH_WIDTH]; /* direction . normal */
    double odd[RMAP_BATCH_WIDTH];    /* not 0: a case that only rmap_retrace decides */
    /* The end as it is recorded. */
    float position[3][RMAP_BATCH_WIDTH];
    uint32_t normal_xy[RMAP_BATCH_WIDTH]; /* 16 bits each */
    int32_t normal_z[RMAP_BATCH_WIDTH];
    double n1[RMAP_BATCH_WIDTH], n2[RMAP_BATCH_WIDTH]; /* REFRACT */
    uint32_t random[4][RMAP_BATCH_WIDTH];              /* DIFFUSE: counter; numbers */
    double through[RMAP_BATCH_WIDTH];                  /* DIFFUSE: 1 transmitted, else 0 */
};

/* Flags of a segment: it is not part of the ray's length; what happens at its end leaves any colour
 * alone, if it comes from the back or from the front; a registration may lie on it; its medium may
 * change colours. */
enum {
    RMAP_BATCH_LEFT = 1,
    RMAP_BATCH_GREY_BACK = 2,
    RMAP_BATCH_GREY_FRONT = 4,
    RMAP_BATCH_CROSSES = 8,
    RMAP_BATCH_TINTS = 16
};

/* A segment: where it goes by the path, and how it went. */
struct rmap_batch_segment {
    union {
        const float *corner; /* MESH: of its triangle, [3][4]; of others, what is read first */
        double length;       /* of a segment done */
    } way;
    double cosine;   /* of a segment done: direction . normal, NaN where nothing was met */
    uint32_t object; /* at most n_object, which is none */
    uint16_t medium; /* at most n_medium, which is none */
    union {
        struct {
            uint8_t queue; /* RMAP_BATCH_TURNS x kind + turn */
            uint8_t flags;
        };
        uint16_t step; /* both: flags << 8 | queue */
    };
};

/* Where a segment starts, of the ray that is summed up. */
struct rmap_batch_start {
    double optical_path, index; /* up to there; on the segment */
};

#define RMAP_BATCH_TURNS  8
#define RMAP_BATCH_QUEUES (RMAP_BATCH_KINDS * RMAP_BATCH_TURNS)

/* Rays that wait for a segment of one kind, those that came as number `first` up to `end`, in
 * rings; and after them those that have arrived. */
struct rmap_batch_queues {
    uint32_t first[RMAP_BATCH_QUEUES + 1], end[RMAP_BATCH_QUEUES + 1];
    uint16_t ray[RMAP_BATCH_QUEUES + 1][RMAP_BATCH_RAYS];
};

struct rmap_batch {
    uint8_t *careful;                   /* [rays]: only rmap_retrace can tell */
    struct rmap_batch_segment *segment; /* [slabs][slab_segments], or [segments] */
    size_t slab_segments; /* 0: rays' segments are too uneven: one slab of all of them */
    size_t on_slab[RMAP_BATCH_SLABS]; /* rays that have not arrived */
    uint16_t idle[RMAP_BATCH_SLABS];  /* [n_idle] slabs */
    size_t n_idle;
    void *room;                 /* of `ray` */
    struct rmap_batch_ray *ray; /* [RMAP_BATCH_RAYS + 1]: the last is nobody's; on a cache line */
    struct rmap_batch_queues *queue;
    struct rmap_batch_segment nobodys; /* segment in hand */
    struct rmap_batch_start *start;    /* [segments of the longest ray] */
    size_t cap_careful, cap_segment, cap_room, cap_queue, cap_start;
};
void rmap_batch_fini(struct rmap_batch *batch);

/* Predictions for all rays of r, into the columns that `predicted` has (rows are there). Lanes are
 * not touched. */
enum rmap_status rmap_batch_run(struct rmap_batch *batch, const struct rmap_retrace *r,
                                struct rmap_portion *predicted,
                                struct rmap_error *err) RMAP_MUST_USE;

/* What the steps of a run share. */
struct rmap_batch_run {
    struct rmap_batch *batch;
    const struct rmap_retrace *r;
    struct rmap_portion *out;
    size_t ray, row, crossing;          /* the next that sets out */
    struct rmap_batch_segment *segment; /* its first */
    uint16_t slab;
    size_t ready, ready_row, ready_crossing; /* segments of rays before that one are there */
    struct rmap_departure departure[RMAP_BATCH_AHEAD]; /* of the rays before `ready` */
    struct rmap_compact_light light;                   /* of the ray that is summed up */
};

#endif
