/* SPDX-License-Identifier: MIT
 *
 * Which rays of a decoded portion have numbers that their paths did not predict.
 */
#include "compact/unpredicted.h"

#include <string.h>

/* The list stays in order. False: it is full. */
static bool enter(struct rmap_unpredicted *list, uint32_t ray)
{
    size_t at = list->n;
    while (at > 0 && list->ray[at - 1] > ray)
        at--;
    if (at > 0 && list->ray[at - 1] == ray)
        return true;
    if (list->n == RMAP_UNPREDICTED_MAX)
        return false;
    memmove(list->ray + at + 1, list->ray + at, (list->n - at) * sizeof *list->ray);
    list->ray[at] = ray;
    list->n++;
    return true;
}

/* Rows of a ray in the lane's table. */
static size_t rows_of(const struct rmap_portion *portion, enum rmap_table table, size_t ray)
{
    return table == RMAP_TABLE_RAY       ? 1
           : table == RMAP_TABLE_SEGMENT ? portion->ray.segment_count[ray]
                                         : portion->ray.registration_count[ray];
}

/* Patches come in the order of rows, and so of rays. */
static bool enter_patched(const struct rmap_lane *lane, const struct rmap_portion *portion,
                          struct rmap_unpredicted *list)
{
    const enum rmap_table table = rmap_column_info(lane->column)->table;
    const size_t width = rmap_portion_row_nbytes(portion, lane->column) / lane->element_nbytes;
    size_t number = 0, ray = 0, end = 0; /* behind the ray's last row */
    for (size_t k = 0; k < lane->patches_left; k++, number++) {
        number += lane->patch_skip[k];
        while (end * width <= number && ray < portion->n_row[RMAP_TABLE_RAY])
            end += rows_of(portion, table, ray++);
        if (ray == 0 || !enter(list, (uint32_t)(ray - 1)))
            return false;
    }
    return true;
}

bool rmap_unpredicted_list(const struct rmap_compact_model *model, const struct rmap_lane *lane,
                           const struct rmap_lane_header *header,
                           const struct rmap_portion *portion, struct rmap_unpredicted *list)
{
    bool known = header->placed && !header->one_by_one &&
                 memcmp(&header->predicted, &model->predicted, sizeof model->predicted) == 0;
    list->seed = header->seed;
    list->n = 0;
    for (int i = 0; known && i < header->n_lane; i++) {
        if (lane[i].role != RMAP_LANE_LEADS && lane[i].role != RMAP_LANE_FOLLOWS)
            continue;
        known = lane[i].mode == RMAP_LANE_PREDICTED ||
                (lane[i].mode == RMAP_LANE_PATCHED && enter_patched(&lane[i], portion, list));
    }
    return known;
}
