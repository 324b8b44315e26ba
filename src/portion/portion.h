/* SPDX-License-Identifier: MIT
 *
 * The histories of a block of consecutive ray ids as columns in memory: what a traced block
 * fills, what a shard stores and what a query decodes. A portion that a reader filled may lack
 * columns (NULL) that were not asked for.
 */
#ifndef RMAP_PORTION_H
#define RMAP_PORTION_H

#include <stdint.h>

#include "base/status.h"
#include "portion/columns.h"

/* Rays per block. A constant, so that sums per block, and with them every answer, do not
 * depend on ranks, threads or the number of rays asked for. */
#define RMAP_BLOCK_RAYS 4096

/* Rays of a block that are recorded and encoded in one go where a block may come in parts: so few
 * that their columns stay in a core's cache. */
#define RMAP_PART_RAYS 256

/* Rays that src/compact may not predict from their paths, in ascending order: all others of the
 * portion it does, bit by bit, with this seed. Whoever traced the rays knows. */
#define RMAP_UNPREDICTED_MAX 1024
struct rmap_unpredicted {
    uint64_t seed;
    size_t n; /* beyond RMAP_UNPREDICTED_MAX: they are not listed */
    uint32_t ray[RMAP_UNPREDICTED_MAX];
};

#define RMAP_FIELD(field, path, type, element, width, unit, text) type *field;
struct rmap_ray_columns {
    RMAP_RAY_COLUMNS(RMAP_FIELD)
    RMAP_RAY_TIME_COLUMNS(RMAP_FIELD)
};
struct rmap_segment_columns {
    RMAP_SEGMENT_COLUMNS(RMAP_FIELD)
};
struct rmap_registration_columns {
    RMAP_REGISTRATION_COLUMNS(RMAP_FIELD)
    RMAP_REGISTRATION_TIME_COLUMNS(RMAP_FIELD)
};
struct rmap_curve_columns {
    RMAP_CURVE_COLUMNS(RMAP_FIELD)
};
#undef RMAP_FIELD

struct rmap_portion {
    uint64_t first_ray;                  /* smallest ray id */
    size_t n_row[RMAP_TABLE_COUNT];      /* rows in use per table */
    size_t cap[RMAP_TABLE_COUNT];        /* rows allocated per table */
    struct rmap_ray_columns ray;         /* [n_row[RMAP_TABLE_RAY]][width] */
    struct rmap_segment_columns segment; /* [n_row[RMAP_TABLE_SEGMENT]][width] */
    struct rmap_registration_columns registration;
    struct rmap_curve_columns curve; /* see rmap_portion_curve_of */
    bool timed; /* has RMAP_COLUMNS_TIME; the rest without them are all its columns */
    int n_channel;
    uint16_t *colour; /* [n_row[RMAP_TABLE_SEGMENT]][n_channel], sum of a row = 65535; colour on
                         the segment's arrival */
    const struct rmap_unpredicted
        *unpredicted;  /* of the rows as they are, borrowed; NULL: not known */
    bool knows_angles; /* about, as a compact piece says them beside places: */
    uint16_t *angle;   /* [n_row[RMAP_TABLE_REGISTRATION]] as src/compact/angles.h */
    size_t angle_cap;
};

/* What a portion's index row says of it, so that a query can skip it. */
struct rmap_portion_summary {
    uint32_t events;     /* bits of all segments */
    uint32_t stops;      /* bit (1 << stop) of all rays */
    uint64_t sources;    /* bit (source mod 64) */
    uint64_t detectors;  /* bit (detector mod 64) of all registrations */
    uint64_t objects[4]; /* bit (object mod 256) */
    float box_min[3];    /* of all points */
    float box_max[3];
};

/* An empty portion with every column allocated for the rows given (they grow as needed). */
enum rmap_status rmap_portion_create(size_t n_ray, int n_channel, struct rmap_portion **portion_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_portion_destroy(struct rmap_portion *portion);

/* An empty portion of a timed run from now on. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_portion_set_timed(struct rmap_portion *portion, bool timed,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Empties the portion and keeps its memory. */
void rmap_portion_clear(struct rmap_portion *portion);

/* Room for n more rows of a table in every column of it that `columns` names and the portion may
 * have (colour goes with the segment table). RMAP_SYSTEM when memory is short; the portion is
 * unchanged then. */
enum rmap_status rmap_portion_reserve(struct rmap_portion *portion, enum rmap_table table,
                                      size_t n_more, rmap_column_set columns,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Start of a column's memory, or NULL when it is not there. Address of its pointer. */
void *rmap_portion_column(const struct rmap_portion *portion, enum rmap_column column);
void **rmap_portion_column_address(struct rmap_portion *portion, enum rmap_column column);

/* Bytes per row of a column in this portion (colour included). */
size_t rmap_portion_row_nbytes(const struct rmap_portion *portion, enum rmap_column column);

/* The channel that has most of the light in a row of /segment; 0 where colours were not read. */
int rmap_portion_channel(const struct rmap_portion *portion, size_t segment);

/* Rows of /curve that belong to the ray with that id, the first of them in *first_ret; they go from
 * segment to segment. 0: none of its segments has points between its ends. For portions whose ids
 * ascend. */
size_t rmap_portion_curve_of(const struct rmap_portion *portion, uint64_t ray, size_t *first_ret);

/* Of rows that are copied behind `to` others: the rays [first, end) of those that `known` tells of
 * (NULL: nothing is known of them), with the list's seed. */
void rmap_unpredicted_take(struct rmap_unpredicted *list, const struct rmap_unpredicted *known,
                           size_t first, size_t end, size_t to);

/* Appends ray number `ray` of src (a row of /ray with its rows of the other tables, which begin
 * at rows first_segment and first_registration) to dst. Both must have all columns and the same
 * channels; an empty dst becomes timed as src is. RMAP_SYSTEM when memory is short; dst is
 * unchanged then. */
enum rmap_status rmap_portion_append_ray(struct rmap_portion *dst, const struct rmap_portion *src,
                                         size_t ray, size_t first_segment,
                                         size_t first_registration,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* The same for n_ray rays from that one on, whose ids ascend. */
enum rmap_status rmap_portion_append_rays(struct rmap_portion *dst, const struct rmap_portion *src,
                                          size_t ray, size_t n_ray, size_t first_segment,
                                          size_t first_registration,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The same for so many rows of each table, from first on: those of one or more rays. */
enum rmap_status rmap_portion_append_rows(struct rmap_portion *dst, const struct rmap_portion *src,
                                          const size_t first[RMAP_TABLE_COUNT],
                                          const size_t n[RMAP_TABLE_COUNT],
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Summary of a portion that has all columns. */
void rmap_portion_summarise(const struct rmap_portion *portion,
                            struct rmap_portion_summary *summary);

/* Summary of the rays of both. */
void rmap_portion_summary_add(struct rmap_portion_summary *sum,
                              const struct rmap_portion_summary *more);

/* 128-bit logical digest: the sum modulo 2^128 over rays of XXH3-128 of the ray's rows, column
 * by column in the order of columns.h (the ray id comes first, points of curved segments and what
 * timed runs have come last, so that rays without them have the digest that they have always had).
 * Floats are stored with -0 as 0 and one NaN, so the bytes in memory are the canonical ones. */
struct rmap_digest {
    uint64_t low, high;
};

void rmap_digest_add(struct rmap_digest *sum, struct rmap_digest term);

/* Digest of a portion that has all columns. */
struct rmap_digest rmap_portion_digest(const struct rmap_portion *portion);

/* 32 lower-case hex digits and a final 0. */
void rmap_digest_text(struct rmap_digest digest, char text[33]);

#endif
