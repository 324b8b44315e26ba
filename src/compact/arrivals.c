/* SPDX-License-Identifier: MIT
 *
 * The paths of the rays that may arrive at a detector.
 */
#include "compact/arrivals.h"

#include <string.h>

#include "base/alloc.h"
#include "compact/compact.h"
#include "compact/damaged.h"
#include "compact/own_lengths.h"

void rmap_arrivals_fini(struct rmap_arrivals *self)
{
    rmap_free(self->path);
}

enum rmap_status rmap_arrivals_read(const struct rmap_rows *rows,
                                    const struct rmap_compact_summary *header,
                                    const struct rmap_path_table *table, uint32_t *path,
                                    struct rmap_error *err)
{
    const size_t n = header->n_arrival, n16 = rows->n_row[RMAP_COMPACT_POOL16];
    const size_t behind =
        header->measured ? rmap_own_length_rows(rows->n_row[RMAP_COMPACT_OWN]) : 0;
    uint32_t greatest = 0;
    if (n16 < behind || n16 - behind < n)
        return rmap_portion_damaged("it has fewer rays that arrive than its header says", err);
    const uint16_t *row = (const uint16_t *)rows->data[RMAP_STREAM_pool16] + (n16 - behind - n);
    for (size_t i = 0; i < n; i++) {
        path[i] = row[i];
        greatest = path[i] > greatest ? path[i] : greatest;
    }
    return greatest > table->n
               ? rmap_portion_damaged("a ray that arrives refers to a path that is not there", err)
               : RMAP_OK;
}

bool rmap_arrivals_suffice(const struct rmap_lane_header *header)
{
    return header->placed && header->mode[RMAP_LANE_REGISTRATION_cell] == RMAP_LANE_PREDICTED &&
           header->mode[RMAP_LANE_RAY_weight] == RMAP_LANE_PREDICTED &&
           header->mode[RMAP_LANE_RAY_id] == RMAP_LANE_PREDICTED &&
           header->mode[RMAP_LANE_SEGMENT_medium] == RMAP_LANE_PREDICTED;
}

/* Their header: lanes other than places have rows of all rays, and are left out. */
static void make_header(struct rmap_arrivals *self, struct rmap_lane_header *header)
{
    memset(header->n_patch, 0, sizeof header->n_patch);
    for (int i = 0; i < header->n_lane; i++)
        header->mode[i] =
            i == RMAP_LANE_REGISTRATION_relative ? RMAP_LANE_VERBATIM : RMAP_LANE_PREDICTED;
    rmap_lane_header_write(header, self->header);
    self->n_header = rmap_lane_header_rows(header->n_lane);
}

enum rmap_status rmap_arrivals_find(struct rmap_arrivals *self, const struct rmap_path_table *table,
                                    bool timed, const struct rmap_rows *rows,
                                    const struct rmap_compact_summary *summary,
                                    const size_t n_row[RMAP_TABLE_COUNT], bool *told_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_lane_store store = rmap_lane_store_of(rows);
    struct rmap_portion all = {.n_channel = rows->n_channel, .timed = timed};
    struct rmap_lane lane[RMAP_LANE_COUNT];
    struct rmap_lane_header header;
    const uint32_t *own = rows->data[RMAP_STREAM_OWN_segment_count];
    uint64_t n_segment = 0;
    *told_ret = false;
    memcpy(all.n_row, n_row, sizeof all.n_row);
    rmap_lanes_init(lane);
    RMAP_TRY(rmap_lanes_load(lane, &store, 0, RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative), &all,
                             &header, err));
    if (!header.arrives || !rmap_arrivals_suffice(&header))
        goto out;
    self->n = header.n_arrival;
    if (self->n > n_row[RMAP_TABLE_RAY])
        RMAP_TRY(rmap_portion_damaged("more rays arrive than there are", err));
    RMAP_TRY(RMAP_RESERVE(self->path, self->cap, self->n + 1, err));
    RMAP_TRY(rmap_arrivals_read(rows, summary, table, self->path, err));
    for (size_t i = 0; i < self->n; i++)
        n_segment += table->count[self->path[i]].n_segment;
    for (size_t k = 0; k < rows->n_row[RMAP_COMPACT_OWN]; k++)
        n_segment += own[k];
    if (n_segment > n_row[RMAP_TABLE_SEGMENT])
        RMAP_TRY(rmap_portion_damaged("rays that arrive have more segments than all", err));
    const struct rmap_lane *place = &lane[RMAP_LANE_REGISTRATION_relative];
    self->n_segment = (size_t)n_segment;
    /* The lane's rows, without its const. */
    self->place = store.pool16 + ((const uint16_t *)place->dense - store.pool16);
    self->n_place = place->n;
    make_header(self, &header);
    *told_ret = true;
out:
    return st;
}

void rmap_arrivals_narrow(struct rmap_arrivals *self, struct rmap_rows *rows,
                          size_t n_row[RMAP_TABLE_COUNT])
{
    n_row[RMAP_TABLE_RAY] = rows->n_row[RMAP_COMPACT_RAY] = self->n;
    n_row[RMAP_TABLE_SEGMENT] = self->n_segment;
    n_row[RMAP_TABLE_CURVE] = rows->n_row[RMAP_COMPACT_CURVE] = 0;
    rows->data[RMAP_STREAM_ray_path] = self->path;
    rows->data[RMAP_STREAM_ray_channel] = NULL;
    rows->data[RMAP_STREAM_pool16] = self->place;
    rows->data[RMAP_STREAM_pool64] = self->header;
    rows->n_row[RMAP_COMPACT_POOL16] = self->n_place;
    rows->n_row[RMAP_COMPACT_POOL32] = 0;
    rows->n_row[RMAP_COMPACT_POOL64] = self->n_header;
    rows->n_row[RMAP_COMPACT_PATCH] = rows->n_row[RMAP_COMPACT_TRIANGLE] = 0;
}
