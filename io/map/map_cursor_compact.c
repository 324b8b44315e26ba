/* SPDX-License-Identifier: MIT
 *
 * What a cursor has of portions of compact pieces.
 */
#include <string.h>

#include "base/alloc.h"
#include "compact/own_lengths.h"
#include "compact/paths.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor_internal.h"
#include "io/map/map_keep.h"
#include "io/map/map_paths.h"
#include "io/map/piece_columns.h"

static enum rmap_status read_stream(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                    int stream, size_t n, size_t row_nbytes, struct rmap_error *err)
{
    const int table = rmap_map_piece_layout(self->map, (size_t)info->piece)->stream[stream].table;
    void *rows = self->buffer[stream].data;
    const enum rmap_status st = rmap_chunk_reader_rows(self->reader, (size_t)info->piece, stream,
                                                       info->stored_first[table], n, rows, err);
    if (st == RMAP_OK)
        rmap_map_keep_stream(self->map, self->in_hand, stream, rows, n * row_nbytes);
    return st;
}

/* Rows of the streams that are wanted, kept ones or into the cursor's own buffers. */
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
        void *kept = rmap_map_borrow_stream(self->map, self->in_hand, s);
        if (st == RMAP_OK && !kept && !(self->streams & (UINT64_C(1) << s)))
            st = read_stream(self, info, s, rows->n_row[stream->table], row, err);
        rows->data[s] = kept ? kept : buffer->data;
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
    const uint64_t nbytes =
        rmap_map_paths_stored_nbytes(self->map, piece, rmap_compact_needs_rows(self->columns));
    const uint64_t first = info->stored_first[ray], last = first + info->stored_rows[ray];
    const uint64_t share = n > 0 ? nbytes * last / n - nbytes * first / n : 0;
    rmap_chunk_reader_set_nbytes_of_rows(self->reader,
                                         rmap_chunk_reader_nbytes_of_rows(self->reader) + share);
}

/* Heads of paths may be in hand where all is needed; who has them may go on to use them. */
static enum rmap_status take_paths(struct rmap_cursor *self, size_t piece, struct rmap_error *err)
{
    const struct rmap_path_table *before = self->paths;
    if (before && (before->is_whole || !self->whole_paths))
        return RMAP_OK;
    const enum rmap_status st =
        rmap_map_paths(self->map, piece, self->whole_paths, self->reader, &self->paths, err);
    rmap_map_paths_give_back(self->map, piece, before);
    self->paths_piece = piece;
    return st;
}

/* Streams with a row for every ray, which a narrowed portion leaves unread; and those that
 * narrowing reads. */
static const uint64_t rays_streams =
    UINT64_C(1) << RMAP_STREAM_ray_path | UINT64_C(1) << RMAP_STREAM_ray_channel;
static const uint64_t narrow_streams = UINT64_C(1) << RMAP_STREAM_pool16 |
                                       UINT64_C(1) << RMAP_STREAM_pool64 |
                                       UINT64_C(1) << RMAP_STREAM_OWN_segment_count |
                                       UINT64_C(1) << RMAP_STREAM_OWN_registration_count;

enum rmap_status rmap_cursor_enter_rows(struct rmap_cursor *self,
                                        const struct rmap_portion_info *info, uint64_t streams,
                                        struct rmap_cursor_rows *in_hand, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t piece = (size_t)info->piece;
    if (self->is_narrow)
        streams &= ~rays_streams;
    in_hand->rows = (struct rmap_rows){.layout = rmap_map_piece_layout(self->map, piece),
                                       .n_channel = self->portion->n_channel,
                                       .add_up = self->add_up};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        in_hand->n_row[t] = (size_t)info->n_row[t];
    RMAP_TRY(rmap_map_model(self->map, (size_t)info->space, false, &in_hand->model, err));
    RMAP_TRY(take_paths(self, piece, err));
    if (!self->streams && !rmap_map_borrow_stream(self->map, self->in_hand, RMAP_STREAM_pool64))
        count_paths(self, info);
    RMAP_TRY(read_rows(self, info, streams, &in_hand->rows, err));
    if (self->is_narrow)
        rmap_arrivals_narrow(&self->arrivals, &in_hand->rows, in_hand->n_row);
out:
    return st;
}

void rmap_cursor_say_where(const struct rmap_cursor *self, const struct rmap_portion_info *info,
                           struct rmap_error *err)
{
    rmap_error_context(err, "%s: block from ray %llu on",
                       self->map->content.piece[info->piece].name,
                       (unsigned long long)info->first_ray);
}

enum rmap_status rmap_cursor_know_header(struct rmap_cursor *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct rmap_cursor_rows in_hand;
    if (self->knows_header ||
        self->map->content.piece[info->piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(rmap_cursor_enter_rows(self, info, rmap_compact_header_streams(), &in_hand, err));
    st = rmap_compact_summarise_header(&in_hand.rows, &self->header, err);
    if (st != RMAP_OK)
        rmap_cursor_say_where(self, info, err);
    self->knows_header = st == RMAP_OK;
out:
    return st;
}

enum rmap_status rmap_cursor_traced(struct rmap_cursor *self, rmap_column_set *traced_ret,
                                    struct rmap_error *err)
{
    const enum rmap_status st = rmap_cursor_know_header(self, err);
    const size_t piece = (size_t)self->map->content.portion[self->in_hand].piece;
    *traced_ret = self->knows_header ? rmap_compact_traced(self->header.placed) &
                                           ~rmap_map_columns_beside(self->map, piece)
                                     : 0;
    return st;
}

rmap_column_set rmap_cursor_tells_of(const struct rmap_cursor *self, rmap_column_set columns)
{
    const bool known = self->knows_header && self->header.angled && self->header.placed;
    return known && (columns & RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction))
               ? RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) | RMAP_COLUMNS_ANGLES
               : 0;
}

enum rmap_status rmap_cursor_narrow(struct rmap_cursor *self, bool *is_narrow_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct rmap_cursor_rows in_hand;
    struct rmap_map_kept kept;
    rmap_map_kept(self->map, &kept);
    *is_narrow_ret = false;
    if (kept.budget > 0 || self->map->held || self->present || self->kept)
        return RMAP_OK;
    RMAP_TRY(rmap_cursor_know_header(self, err));
    if (!self->knows_header || !self->header.arrives)
        return RMAP_OK;
    RMAP_TRY(rmap_cursor_enter_rows(self, info, narrow_streams, &in_hand, err));
    st = rmap_arrivals_find(&self->arrivals, self->paths, self->portion->timed, &in_hand.rows,
                            &self->header, in_hand.n_row, is_narrow_ret, err);
    if (st == RMAP_OK && *is_narrow_ret) {
        rmap_arrivals_narrow(&self->arrivals, &in_hand.rows, in_hand.n_row);
        st = rmap_compact_summarise(in_hand.model, self->paths, &in_hand.rows, in_hand.n_row,
                                    &self->header, err);
        memcpy(self->shown.n_row, in_hand.n_row, sizeof in_hand.n_row);
    }
    if (st != RMAP_OK)
        rmap_cursor_say_where(self, info, err);
    self->is_narrow = self->add_up = st == RMAP_OK && *is_narrow_ret;
out:
    return st;
}

enum rmap_status rmap_cursor_arrivals(struct rmap_cursor *self, const uint32_t **path_ret,
                                      size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct rmap_cursor_rows in_hand;
    struct rmap_arrivals *own = &self->arrivals;
    *path_ret = NULL;
    *n_ret = self->header.n_arrival;
    if (!self->header.arrives)
        return RMAP_OK;
    RMAP_TRY(rmap_cursor_enter_rows(self, info, narrow_streams, &in_hand, err));
    RMAP_TRY(RMAP_RESERVE(own->path, own->cap, *n_ret + 1, err));
    RMAP_TRY(rmap_arrivals_read(&in_hand.rows, &self->header, self->paths, own->path, err));
    *path_ret = own->path;
out:
    return st;
}

enum rmap_status rmap_cursor_weigh(struct rmap_cursor *self, bool *are_one_ret,
                                   struct rmap_error *err)
{
    const enum rmap_status st = rmap_cursor_know_header(self, err);
    *are_one_ret = self->knows_header && self->header.weigh_one;
    return st;
}

enum rmap_status rmap_cursor_make_decoder(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err)
{
    struct rmap_cursor_space *space = &self->space[info->space];
    const struct rmap_compact_model *model;
    if (space->decoder)
        return RMAP_OK;
    const enum rmap_status st = rmap_map_model(self->map, (size_t)info->space, true, &model, err);
    return st == RMAP_OK ? rmap_compact_decoder_create(model, &space->decoder, err) : st;
}

enum rmap_status rmap_cursor_read_compact(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    struct rmap_cursor_rows in_hand;
    self->whole_paths = true;
    RMAP_TRY(rmap_cursor_enter_rows(self, info, rmap_compact_streams(columns, &self->header),
                                    &in_hand, err));
    RMAP_TRY(rmap_cursor_make_decoder(self, info, err));
    rmap_compact_decoder_pass_over(space->decoder, self->passed_over);
    st = rmap_compact_decode(space->decoder, self->paths, &in_hand.rows, in_hand.n_row, columns,
                             self->present, self->portion, err);
    if (st != RMAP_OK)
        rmap_cursor_say_where(self, info, err);
    self->add_up |= st == RMAP_OK;
out:
    return st;
}

enum rmap_status rmap_cursor_path_summary(struct rmap_cursor *self, bool own_alone,
                                          struct rmap_path_summary *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const size_t piece = (size_t)info->piece;
    struct rmap_cursor_rows in_hand;
    struct rmap_compact_summary summary;
    *paths = (struct rmap_path_summary){.paths = NULL};
    if (self->map->content.piece[piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(
        rmap_cursor_enter_rows(self, info, rmap_compact_summary_streams(own_alone), &in_hand, err));
    st = rmap_compact_summarise(in_hand.model, self->paths, &in_hand.rows, in_hand.n_row, &summary,
                                err);
    if (st != RMAP_OK) {
        rmap_cursor_say_where(self, info, err);
        return st;
    }
    self->header = summary;
    self->knows_header = true;
    self->add_up |= !own_alone;
    if (summary.weigh_one && summary.ids_run && summary.media_known &&
        summary.first_ray == info->first_ray && rmap_map_paths_fit(self->map, piece))
        *paths = (struct rmap_path_summary){
            .paths = rmap_path_table_rays(self->paths),
            .first_segment = rmap_path_table_first_segments(self->paths),
            .first_registration = rmap_path_table_first_registrations(self->paths),
            .path = summary.path,
            .n_own = summary.n_own,
            .classes = summary.classed && self->paths->is_whole
                           ? rmap_path_table_classes(self->paths)
                           : NULL,
            .n_own_segment = summary.n_own_segment};
out:
    return st;
}

enum rmap_status rmap_cursor_path_sums(struct rmap_cursor *self,
                                       const struct rmap_path_sum **sum_ret, struct rmap_error *err)
{
    return rmap_map_path_sums(self->map, self->paths_piece, true, sum_ret, err);
}

/* Weights of rays with path 0, and ids, where the paths of all rays are given. */
static void fill_own_rays(const uint32_t *path, size_t n_ray, uint64_t first_ray,
                          struct rmap_portion *own)
{
    const size_t n_own = own->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0, k = 0; path && i < n_ray && k < n_own; i++) {
        own->ray.id[k] = first_ray + i;
        k += path[i] == 0;
    }
    for (size_t k = 0; k < n_own; k++)
        own->ray.weight[k] = 1.0;
    own->first_ray = path && n_own > 0 ? own->ray.id[0] : first_ray;
}

enum rmap_status rmap_cursor_own_paths(struct rmap_cursor *self, rmap_column_set columns,
                                       const struct rmap_portion **own_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct rmap_cursor_rows in_hand;
    const rmap_column_set id = RMAP_COLUMN_BIT(RMAP_RAY_id);
    columns = self->own_columns | (columns & (RMAP_COLUMNS_DISCRETE | id)) |
              RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    if (columns == self->own_columns)
        goto out;
    if (!self->own && !(self->own = rmap_alloc(1, sizeof *self->own)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    RMAP_TRY(rmap_cursor_know_header(self, err));
    self->whole_paths |= rmap_compact_needs_rows(columns);
    RMAP_TRY(rmap_cursor_enter_rows(self, info, rmap_compact_own_streams(columns, &self->header),
                                    &in_hand, err));
    RMAP_TRY(rmap_compact_decode_own(in_hand.model, self->paths, &in_hand.rows, &self->header,
                                     columns, &self->steps, self->own, err));
    RMAP_TRY(rmap_cursor_check_limits(self, self->own, columns, info, err));
    fill_own_rays(columns & id ? in_hand.rows.data[RMAP_STREAM_ray_path] : NULL,
                  in_hand.n_row[RMAP_TABLE_RAY], info->first_ray, self->own);
    self->own_columns = columns;
out:
    *own_ret = self->own;
    return st;
}

enum rmap_status rmap_cursor_own_steps(struct rmap_cursor *self, struct rmap_own_steps *steps,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_rows in_hand;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    RMAP_TRY(rmap_cursor_know_header(self, err));
    RMAP_TRY(rmap_cursor_enter_rows(self, info, rmap_compact_class_streams(), &in_hand, err));
    RMAP_TRY(rmap_step_codes_open(&in_hand.rows, self->header.n_code, &steps->codes, err));
    steps->class = in_hand.rows.data[RMAP_STREAM_OWN_object];
out:
    return st;
}

enum rmap_status rmap_cursor_own_lengths(struct rmap_cursor *self,
                                         const struct rmap_path_sum **sum_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_rows in_hand;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    *sum_ret = NULL;
    RMAP_TRY(rmap_cursor_know_header(self, err));
    if (!self->header.measured)
        goto out;
    RMAP_TRY(rmap_cursor_enter_rows(self, info, UINT64_C(1) << RMAP_STREAM_pool16, &in_hand, err));
    RMAP_TRY(RMAP_RESERVE(self->own_sum, self->own_sum_cap,
                          in_hand.rows.n_row[RMAP_COMPACT_OWN] + 1, err));
    st = rmap_own_lengths_read(&in_hand.rows, self->own_sum, err);
    if (st != RMAP_OK)
        rmap_cursor_say_where(self, info, err);
    else
        *sum_ret = self->own_sum;
out:
    return st;
}
