/* SPDX-License-Identifier: MIT
 *
 * Portions of compact pieces.
 */
#include "base/alloc.h"
#include "io/map_cursor_internal.h"
#include "io/map_paths.h"

/* Rows of the streams that the columns take, into the cursor's own buffers. */
static enum rmap_status read_rows(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                  rmap_column_set columns, struct rmap_rows *rows,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t wanted = rmap_compact_streams(columns);
    for (int t = 0; t < rows->layout->n_table; t++)
        rows->n_row[t] = (size_t)info->stored_rows[t];
    for (int s = 0; st == RMAP_OK && s < rows->layout->n_stream; s++) {
        const struct rmap_stream_info *stream = &rows->layout->stream[s];
        struct rmap_row_buffer *buffer = &self->buffer[s];
        if (!(wanted & (UINT64_C(1) << s)))
            continue;
        size_t row = rmap_stream_row_nbytes(stream, rows->n_channel);
        if (rows->n_row[stream->table] > SIZE_MAX / 2 / row)
            return rmap_error_set(err, RMAP_FORMAT, "%s: a portion has too many rows",
                                  self->map->path);
        st =
            rmap_reserve(&buffer->data, &buffer->cap, rows->n_row[stream->table] * row + 1, 1, err);
        if (st == RMAP_OK && !(self->streams & (UINT64_C(1) << s)))
            st = rmap_chunk_reader_rows(self->reader, (size_t)info->piece, s,
                                        info->stored_first[stream->table],
                                        rows->n_row[stream->table], buffer->data, err);
        rows->data[s] = buffer->data;
    }
    if (st == RMAP_OK)
        self->streams |= wanted;
    return st;
}

enum rmap_status rmap_cursor_read_compact(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    const struct rmap_compact_model *model;
    const struct rmap_path_table *paths = NULL;
    size_t n_row[RMAP_TABLE_COUNT];
    struct rmap_rows rows = {.layout = rmap_map_piece_layout(self->map, (size_t)info->piece),
                             .n_channel = self->portion->n_channel};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        n_row[t] = (size_t)info->n_row[t];
    RMAP_TRY(rmap_map_model(self->map, (size_t)info->space, &model, err));
    RMAP_TRY(rmap_map_paths(self->map, (size_t)info->piece, self->reader, &paths, err));
    if (!space->decoder)
        RMAP_TRY(rmap_compact_decoder_create(model, &space->decoder, err));
    RMAP_TRY(read_rows(self, info, columns, &rows, err));
    st = rmap_compact_decode(space->decoder, paths, &rows, n_row, columns, self->portion, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s: block from ray %llu on",
                           self->map->content.piece[info->piece].name,
                           (unsigned long long)info->first_ray);
out:
    rmap_map_paths_give_back(self->map, (size_t)info->piece, paths);
    return st;
}
