/* SPDX-License-Identifier: MIT
 *
 * What a cursor has read must fit together and name something of the scene.
 */
#include "io/map/map_cursor_internal.h"
#include "io/scene/scene_limits.h"

enum rmap_status rmap_cursor_check_limits(const struct rmap_cursor *self,
                                          const struct rmap_portion *rows, rmap_column_set columns,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if ((columns & RMAP_COLUMN_BIT(c)) &&
            !rmap_portion_within(self->map->scene[0], rows, (enum rmap_column)c))
            return rmap_error_set(
                err, RMAP_FORMAT,
                "%s: %s: a value of the block from ray %llu on names nothing in the map's scene",
                self->map->content.piece[info->piece].name,
                rmap_column_info((enum rmap_column)c)->path, (unsigned long long)info->first_ray);
    return RMAP_OK;
}

/* Counts must add up, or whoever walks the tables walks past their ends. */
static enum rmap_status check_counts(const struct rmap_cursor *self, enum rmap_column column,
                                     enum rmap_table table, struct rmap_error *err)
{
    static const char *const table_name[] = {"/ray", "/segment", "/registration"};
    uint64_t sum = 0;
    const struct rmap_portion *rows = &self->shown;
    const uint32_t *count = rmap_portion_column(rows, column);
    for (size_t i = 0; i < rows->n_row[RMAP_TABLE_RAY]; i++)
        sum += count[i];
    if (sum == rows->n_row[table])
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: the counts of portion %zu do not add up to its %s",
                          self->map->path, self->in_hand, table_name[table]);
}

enum rmap_status rmap_cursor_check_cells(const struct rmap_cursor *self,
                                         const struct rmap_portion *rows, struct rmap_error *err)
{
    const struct rmap_registration_columns *hit = &rows->registration;
    const struct rmap_detector *detector = self->map->scene[0]->detector;
    bool outside = false;
    for (size_t i = 0; i < rows->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        const uint32_t *cells = detector[hit->detector[i]].cells;
        outside |= hit->cell[2 * i] >= cells[0] || hit->cell[2 * i + 1] >= cells[1];
    }
    if (!outside)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: a cell in portion %zu lies outside its detector",
                          self->map->path, self->in_hand);
}

enum rmap_status rmap_cursor_check_curve(const struct rmap_cursor *self, struct rmap_error *err)
{
    const struct rmap_portion *rows = &self->shown;
    const size_t n = rows->n_row[RMAP_TABLE_CURVE];
    size_t k = 0;
    for (size_t i = 0; k < n && i < rows->n_row[RMAP_TABLE_RAY]; i++)
        for (uint32_t segment = 0; k < n && rows->curve.ray[k] == rows->ray.id[i]; k++) {
            if (rows->curve.segment[k] < segment ||
                rows->curve.segment[k] >= rows->ray.segment_count[i])
                return rmap_error_set(
                    err, RMAP_FORMAT,
                    "%s: the points of /curve of ray %llu lie on no segment of it", self->map->path,
                    (unsigned long long)rows->ray.id[i]);
            segment = rows->curve.segment[k];
        }
    if (k == n)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: points of /curve in portion %zu are of no ray",
                          self->map->path, self->in_hand);
}

enum rmap_status rmap_cursor_check_columns(const struct rmap_cursor *self,
                                           const struct rmap_portion_info *info,
                                           rmap_column_set fresh, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_cursor_check_limits(self, &self->shown, fresh, info, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_segment_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_segment_count, RMAP_TABLE_SEGMENT, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_registration_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_registration_count, RMAP_TABLE_REGISTRATION, err));
out:
    return st;
}
