/* SPDX-License-Identifier: MIT
 *
 * Values of stored columns that index tables of the scene: whatever a file says, they must lie in
 * them.
 */
#include "io/scene/scene_limits.h"

#include "base/wide.h"
#include "portion/event.h"

/* Values that index the scene's tables must lie in them: [low, high). False: any value will do. */
static bool column_limits(const struct rmap_scene *scene, enum rmap_column column, int64_t *low,
                          int64_t *high)
{
    *low = -1;
    switch (column) {
    case RMAP_RAY_source:
        *low = 0;
        *high = (int64_t)scene->n_source;
        return true;
    case RMAP_RAY_stop:
        *low = 0;
        *high = RMAP_STOP_COUNT;
        return true;
    case RMAP_RAY_start_object:
    case RMAP_SEGMENT_object:
        *high = (int64_t)scene->n_object;
        return true;
    case RMAP_SEGMENT_medium:
        *high = (int64_t)scene->n_medium;
        return true;
    case RMAP_REGISTRATION_detector:
        *low = 0;
        *high = (int64_t)scene->n_detector;
        return true;
    default:
        return false;
    }
}

RMAP_WIDE static bool bytes_within(const uint8_t *value, size_t n, int32_t end)
{
    int32_t outside = 0;
    for (size_t i = 0; i < n; i++)
        outside |= value[i] >= end;
    return !outside;
}

RMAP_WIDE static bool shorts_within(const int16_t *value, size_t n, int32_t low, int32_t end)
{
    int16_t least = INT16_MAX, most = INT16_MIN;
    for (size_t i = 0; i < n; i++) {
        least = value[i] < least ? value[i] : least;
        most = value[i] > most ? value[i] : most;
    }
    return n == 0 || (least >= low && most < end);
}

RMAP_WIDE static bool longs_within(const int32_t *value, size_t n, int32_t low, int32_t end)
{
    int32_t least = INT32_MAX, most = INT32_MIN;
    for (size_t i = 0; i < n; i++) {
        least = value[i] < least ? value[i] : least;
        most = value[i] > most ? value[i] : most;
    }
    return n == 0 || (least >= low && most < end);
}

/* All of [low, high). */
static bool all_within(enum rmap_element element, const void *data, size_t n, int64_t low,
                       int64_t high)
{
    const int32_t least = (int32_t)low, end = (int32_t)high;
    return element == RMAP_U8    ? bytes_within(data, n, end)
           : element == RMAP_I16 ? shorts_within(data, n, least, end)
                                 : longs_within(data, n, least, end);
}

bool rmap_portion_within(const struct rmap_scene *scene, const struct rmap_portion *portion,
                         enum rmap_column column)
{
    int64_t low, high;
    const struct rmap_column_info *what = rmap_column_info(column);
    return !column_limits(scene, column, &low, &high) ||
           all_within(what->element, rmap_portion_column(portion, column),
                      portion->n_row[what->table], low, high);
}
