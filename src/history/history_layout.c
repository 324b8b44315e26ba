/* SPDX-License-Identifier: MIT */
#include "history/history_parts.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "an index is little-endian in memory");
_Static_assert(sizeof(struct rmap_history_head) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_place) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_shape) == 40, "no padding");
_Static_assert(sizeof(struct rmap_history_class) == 12, "no padding");
_Static_assert(sizeof(struct rmap_history_hit) == 8, "no padding");
_Static_assert((int)RMAP_HEAD_PARTS <= (int)RMAP_PART_COUNT_OF, "one layout serves both");

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
