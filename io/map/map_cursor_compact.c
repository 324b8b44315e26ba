/* SPDX-License-Identifier: MIT
 *
 * Portions of compact pieces.
 */
#include "base/alloc.h"
#include "compact/streams.h"
#include "io/map/map_cursor_internal.h"
#include "io/map/map_paths.h"

/* Rows of the streams that are wanted, into the cursor's own buffers. */
static enum rmap_status read_rows(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                  uint64_t wanted, struct rmap_rows *rows, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
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

void rmap_cursor_leave_paths(struct rmap_cursor *self, size_t piece)
{
    if (!self->paths || self->paths_piece == piece)
        return;
    rmap_map_paths_give_back(self->map, self->paths_piece, self->paths);
    self->paths = NULL;
}

/* The stored bytes of a piece's paths are shared out over its rays. */
static void count_paths(struct rmap_cursor *self, const struct rmap_portion_info *info)
{
    const size_t piece = (size_t)info->piece;
    const int ray = rmap_map_piece_layout(self->map, piece)->stream[RMAP_STREAM_ray_path].table;
    const uint64_t n = self->map->content.piece[piece].stored_rows[ray];
    const uint64_t nbytes = rmap_map_paths_stored_nbytes(self->map, piece);
    const uint64_t first = info->stored_first[ray], last = first + info->stored_rows[ray];
    const uint64_t share = n > 0 ? nbytes * last / n - nbytes * first / n : 0;
    rmap_chunk_reader_set_nbytes_of_rows(self->reader,
                                         rmap_chunk_reader_nbytes_of_rows(self->reader) + share);
}

/* What any use of the portion's rows takes. */
struct compact_rows {
    const struct rmap_compact_model *model;
    struct rmap_rows rows;
    size_t n_row[RMAP_TABLE_COUNT]; /* of the columns */
};

static enum rmap_status enter_rows(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                   uint64_t streams, struct compact_rows *in_hand,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t piece = (size_t)info->piece;
    in_hand->rows = (struct rmap_rows){.layout = rmap_map_piece_layout(self->map, piece),
                                       .n_channel = self->portion->n_channel};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        in_hand->n_row[t] = (size_t)info->n_row[t];
    RMAP_TRY(rmap_map_model(self->map, (size_t)info->space, &in_hand->model, err));
    if (!self->paths)
        RMAP_TRY(rmap_map_paths(self->map, piece, self->reader, &self->paths, err));
    self->paths_piece = piece;
    if (!self->streams)
        count_paths(self, info);
    st = read_rows(self, info, streams, &in_hand->rows, err);
out:
    return st;
}

static void say_where(const struct rmap_cursor *self, const struct rmap_portion_info *info,
                      struct rmap_error *err)
{
    rmap_error_context(err, "%s: block from ray %llu on",
                       self->map->content.piece[info->piece].name,
                       (unsigned long long)info->first_ray);
}

enum rmap_status rmap_cursor_read_compact(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    struct compact_rows in_hand;
    RMAP_TRY(enter_rows(self, info, rmap_compact_streams(columns), &in_hand, err));
    if (!space->decoder)
        RMAP_TRY(rmap_compact_decoder_create(in_hand.model, &space->decoder, err));
    st = rmap_compact_decode(space->decoder, self->paths, &in_hand.rows, in_hand.n_row, columns,
                             self->present, self->portion, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
out:
    return st;
}

enum rmap_status rmap_cursor_weigh(struct rmap_cursor *self, bool *are_one_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct compact_rows in_hand;
    struct rmap_compact_told told = {.weigh_one = false};
    *are_one_ret = false;
    if (self->map->content.piece[info->piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(enter_rows(self, info, rmap_compact_header_streams(), &in_hand, err));
    st = rmap_compact_tell_header(&in_hand.rows, &told, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
    *are_one_ret = told.weigh_one;
out:
    return st;
}

enum rmap_status rmap_cursor_tell_paths(struct rmap_cursor *self, struct rmap_told_paths *paths,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const size_t piece = (size_t)info->piece;
    struct compact_rows in_hand;
    struct rmap_compact_told told;
    *paths = (struct rmap_told_paths){.known = NULL};
    if (self->map->content.piece[piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(enter_rows(self, info, rmap_compact_told_streams(), &in_hand, err));
    st = rmap_compact_tell(in_hand.model, self->paths, &in_hand.rows, in_hand.n_row, &told, err);
    if (st != RMAP_OK) {
        say_where(self, info, err);
        return st;
    }
    if (told.weigh_one && told.ids_run && told.media_told && told.first_ray == info->first_ray &&
        rmap_map_paths_fit(self->map, piece))
        *paths = (struct rmap_told_paths){
            .known = rmap_path_table_rays(self->paths),
            .first_segment = rmap_path_table_first_segments(self->paths),
            .first_registration = rmap_path_table_first_registrations(self->paths),
            .path = told.path,
            .n_own = told.n_own};
out:
    return st;
}

/* Ids and weights of rays with path 0. */
static void fill_own_rays(const uint32_t *path, size_t n_ray, uint64_t first_ray,
                          struct rmap_portion *own)
{
    const size_t n_own = own->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0, k = 0; i < n_ray && k < n_own; i++) {
        own->ray.id[k] = first_ray + i;
        k += path[i] == 0;
    }
    for (size_t k = 0; k < n_own; k++)
        own->ray.weight[k] = 1.0;
    own->first_ray = n_own > 0 ? own->ray.id[0] : first_ray;
}

enum rmap_status rmap_cursor_own_paths(struct rmap_cursor *self,
                                       const struct rmap_portion **own_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct compact_rows in_hand;
    if (self->has_own)
        goto out;
    if (!self->own && !(self->own = rmap_alloc(1, sizeof *self->own)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    RMAP_TRY(enter_rows(self, info, rmap_compact_told_streams(), &in_hand, err));
    RMAP_TRY(rmap_compact_decode_own(in_hand.model, &in_hand.rows, self->own, err));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c))
            RMAP_TRY(rmap_cursor_check_limits(self, self->own, (enum rmap_column)c, info, err));
    fill_own_rays(in_hand.rows.data[RMAP_STREAM_ray_path], in_hand.n_row[RMAP_TABLE_RAY],
                  info->first_ray, self->own);
    self->has_own = true;
out:
    *own_ret = self->own;
    return st;
}
