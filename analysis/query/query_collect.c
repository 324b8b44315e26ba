/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a scan, whole: read by a cursor of its own, and only from portions in which
 * some matched.
 */
#include "analysis/query/query_collect.h"

#include "base/alloc.h"
#include "io/map/map_cursor.h"

void rmap_collector_fini(struct rmap_collector *self)
{
    rmap_cursor_destroy(self->whole);
    rmap_free(self->wide);
    self->whole = NULL;
    self->wide = NULL;
}

/* The portion with as many channels as the collected rays have, those it lacks being 0. */
static enum rmap_status widen(struct rmap_collector *self, struct rmap_portion *portion,
                              struct rmap_error *err)
{
    size_t n = portion->n_row[RMAP_TABLE_SEGMENT], few = (size_t)portion->n_channel;
    size_t many = (size_t)self->rays->n_channel;
    if (few == many)
        return RMAP_OK;
    enum rmap_status st = RMAP_RESERVE(self->wide, self->wide_cap, n * many + 1, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < many; c++)
            self->wide[i * many + c] = c < few ? portion->colour[i * few + c] : 0;
    portion->colour = self->wide;
    portion->n_channel = self->rays->n_channel;
    return RMAP_OK;
}

enum rmap_status rmap_collector_add(struct rmap_collector *self, size_t index, const uint8_t *match,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *read = NULL;
    size_t segment = 0, registration = 0;
    if (!self->whole)
        RMAP_TRY(rmap_cursor_create(self->map, RMAP_COLUMNS_ALL, &self->whole, err));
    RMAP_TRY(rmap_cursor_read(self->whole, index, &read, err));
    struct rmap_portion portion = *read; /* its columns stay the cursor's */
    RMAP_TRY(widen(self, &portion, err));
    for (size_t i = 0; i < portion.n_row[RMAP_TABLE_RAY] && self->n_left > 0; i++) {
        if (match[i]) {
            RMAP_TRY(rmap_portion_append_ray(self->rays, &portion, i, segment, registration, err));
            self->n_left--;
        }
        segment += portion.ray.segment_count[i];
        registration += portion.ray.registration_count[i];
    }
out:
    return st;
}
