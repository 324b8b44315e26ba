/* SPDX-License-Identifier: MIT */
#include "history/history_parts.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "an index is little-endian in memory");
_Static_assert(sizeof(struct rmap_history_head) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_place) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_shape) == 40, "no padding");
_Static_assert(sizeof(struct rmap_history_class) == 12, "no padding");
_Static_assert(sizeof(struct rmap_history_hit) == 8, "no padding");
_Static_assert(sizeof(struct rmap_history_made) == 16, "no padding");
_Static_assert((int)RMAP_HEAD_PARTS <= (int)RMAP_PART_COUNT_OF, "one layout serves both");
_Static_assert((int)RMAP_MADE_PARTS <= (int)RMAP_PART_COUNT_OF, "and a third");

/* Numbers are below 2^32 and sizes below 64: sums stay below 2^64. */
static void stack(uint64_t start, const uint64_t (*array)[2], size_t n,
                  struct rmap_history_layout *layout)
{
    layout->at[0] = start;
    for (size_t i = 0; i < n; i++)
        layout->at[i + 1] = layout->at[i] + (array[i][0] * array[i][1] + 7) / 8 * 8;
}

void rmap_history_arrange(const struct rmap_history_place *place,
                          const struct rmap_history_shape *shape,
                          struct rmap_history_layout *layout)
{
    bool rows = place->form == RMAP_HISTORY_ROWS;
    uint64_t n_ray = place->n_row[RMAP_TABLE_RAY];
    uint64_t n_segment = rows ? place->n_row[RMAP_TABLE_SEGMENT] : 0;
    uint64_t n_registration = place->n_row[RMAP_TABLE_REGISTRATION];
    uint64_t n_hit = rows ? n_registration : 0;
    const uint64_t array[RMAP_PART_COUNT_OF][2] = {
        [RMAP_PART_PATH_ROW] = {shape->n_path, 4},
        [RMAP_PART_PATH_RAYS] = {shape->n_path, 2},
        [RMAP_PART_PATH] = {rows ? 0 : n_ray, 2},
        [RMAP_PART_KIND_SOURCE] = {shape->n_kind, 4},
        [RMAP_PART_KIND_STOP] = {shape->n_kind, 1},
        [RMAP_PART_KIND] = {rows ? n_ray : 0, shape->kind_nbytes},
        [RMAP_PART_LOCAL_CLASS] = {shape->n_local, 2},
        [RMAP_PART_LOCAL_ROWS] = {shape->n_local, 1},
        [RMAP_PART_FREQUENT] = {shape->n_frequent, 4},
        [RMAP_PART_CODE] = {n_segment, 1},
        [RMAP_PART_RARE] = {shape->n_rare, 1},
        [RMAP_PART_COUNT] = {rows ? n_ray : 0, 1},
        [RMAP_PART_LONG] = {shape->n_long, 4},
        [RMAP_PART_HITS] = {n_hit > 0 ? (n_ray + 1) / 2 : 0, 1},
        [RMAP_PART_MANY] = {shape->n_many, 4},
        [RMAP_PART_HIT] = {shape->hit_nbytes ? n_hit : 1,
                           shape->hit_nbytes ? shape->hit_nbytes : 2},
        [RMAP_PART_LEG] = {n_hit, 1},
        [RMAP_PART_FAR] = {shape->n_far, 4},
        [RMAP_PART_RELATIVE] = {place->has_relative ? n_registration : 0, 4},
    };
    stack(sizeof *shape, array, RMAP_PART_COUNT_OF, layout);
}

void rmap_history_arrange_made(const struct rmap_history_place *place,
                               const struct rmap_history_shape *shape, uint64_t nbytes_read,
                               struct rmap_history_layout *layout)
{
    const bool rows = place->form == RMAP_HISTORY_ROWS;
    const uint64_t n_ray = rows ? place->n_row[RMAP_TABLE_RAY] : 0;
    const uint64_t n_segment = place->n_row[RMAP_TABLE_SEGMENT];
    const uint64_t n_hit = place->n_row[RMAP_TABLE_REGISTRATION];
    const uint64_t n_local = rows ? shape->n_local : 0;
    const bool has_rare = shape->n_rare > 0 || shape->n_local > shape->n_common;
    const uint64_t n_word = rows && has_rare ? n_segment / 64 + 2 : 0;
    const uint64_t array[RMAP_MADE_PARTS][2] = {
        [RMAP_MADE_BYTES] = {nbytes_read, 1},
        [RMAP_MADE_SEGMENT_COUNT] = {n_ray, 4},
        [RMAP_MADE_REGISTRATION_COUNT] = {n_hit > 0 ? n_ray : 0, 4},
        [RMAP_MADE_KIND] = {shape->kind_nbytes > 0 ? n_ray : 0, 2},
        [RMAP_MADE_LOCAL_ROWS] = {n_local, 4},
        [RMAP_MADE_RARE_MARK] = {n_word, 8},
        [RMAP_MADE_RANK] = {n_word, 4},
        [RMAP_MADE_LEGS] = {rows ? rmap_bit_groups_words(n_ray, n_segment) : 0, 8},
        [RMAP_MADE_HITS] = {rows && n_hit > 0 ? rmap_bit_groups_words(n_ray, n_hit) : 0, 8},
    };
    stack(sizeof(struct rmap_history_made), array, RMAP_MADE_PARTS, layout);
}

void rmap_history_arrange_head(const struct rmap_history_head *head,
                               struct rmap_history_layout *layout)
{
    const uint64_t array[RMAP_HEAD_PARTS][2] = {
        [RMAP_HEAD_CLASS] = {head->n_class, sizeof(struct rmap_history_class)},
        [RMAP_HEAD_HIT] = {head->n_hit, sizeof(struct rmap_history_hit)},
        [RMAP_HEAD_SOURCE] = {head->n_path, 4},
        [RMAP_HEAD_STOP] = {head->n_path, 1},
        [RMAP_HEAD_SEGMENT_COUNT] = {head->n_path, 4},
        [RMAP_HEAD_REGISTRATION_COUNT] = {head->n_path, 4},
        [RMAP_HEAD_PATH_CLASS] = {head->n_path_segment, 2},
        [RMAP_HEAD_PATH_LEG] = {head->n_path_registration, 4},
        [RMAP_HEAD_PATH_HIT] = {head->n_path_registration, 2},
        [RMAP_HEAD_PORTION] = {head->n_portion, sizeof(struct rmap_history_place)},
    };
    stack(sizeof *head, array, RMAP_HEAD_PARTS, layout);
}
