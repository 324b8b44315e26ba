/* SPDX-License-Identifier: MIT
 *
 * Decoded portions of the pieces of a map, one after the other.
 */
#include <string.h>

#include "base/alloc.h"
#include "compact/decode_paths.h"
#include "compact/own_lengths.h"
#include "compact/paths.h"
#include "compact/ray_selection.h"
#include "compact/streams.h"
#include "io/map/chunk_reader.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_internal.h"
#include "io/map/map_keep.h"
#include "io/map/map_paths.h"
#include "io/map/piece_columns.h"
#include "io/scene/scene_limits.h"

/* What a colour space takes; made when first needed. */
struct rmap_cursor_space {
    struct rmap_portion *portion, *selected;
    struct rmap_compact_decoder *decoder;
    struct rmap_compact_selection *selection;
};

/* A stream's rows of the portion in hand, for the decoder. */
struct rmap_row_buffer {
    void *data;
    size_t cap; /* bytes */
};

struct rmap_cursor {
    const struct rmap_map *map;
    rmap_column_set columns;
    struct rmap_chunk_reader *reader;
    struct rmap_cursor_space *space; /* [n_space] */
    size_t in_hand;                  /* portion of the map */
    rmap_column_set present;         /* columns of it that have been read */
    rmap_column_set kept;            /* and those that the map's store has */
    uint64_t streams;                /* of a compact one, in `buffer` */
    bool knows_header;               /* of a compact one: */
    struct rmap_compact_summary header;
    struct rmap_portion *portion;  /* of the space in hand; borrowed from there */
    struct rmap_portion shown;     /* that, without columns that only decoding needed */
    struct rmap_portion selected;  /* the same of rays that were selected */
    struct rmap_row_buffer beside; /* rows that are compared with decoded ones */
    uint32_t *some;                /* [n_ray] their rows */
    size_t some_cap;
    struct rmap_row_buffer buffer[RMAP_STREAM_MAX];
    const struct rmap_path_table *paths; /* of a compact piece; NULL: none in hand */
    size_t paths_piece;                  /* whose they are */
    struct rmap_portion *own;            /* rays with paths of their own, of the portion in hand, */
    rmap_column_set own_columns;         /* with these columns, */
    bool own_has_ids;                    /* and ids */
    struct rmap_step_buffer steps;       /* classes of their segments */
    struct rmap_path_sum *own_sum;       /* their bounds */
    size_t own_sum_cap;
};

static enum rmap_status cursor_check_limits(const struct rmap_cursor *cursor,
                                            const struct rmap_portion *rows,
                                            enum rmap_column column,
                                            const struct rmap_portion_info *info,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Portions of compact pieces. */

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

/* Gives the paths in hand back, unless they are those of that piece. */
static void cursor_leave_paths(struct rmap_cursor *self, size_t piece)
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
    RMAP_TRY(rmap_map_model(self->map, (size_t)info->space, false, &in_hand->model, err));
    if (!self->paths)
        RMAP_TRY(rmap_map_paths(self->map, piece, self->reader, &self->paths, err));
    self->paths_piece = piece;
    if (!self->streams && !rmap_map_borrow_stream(self->map, self->in_hand, RMAP_STREAM_pool64))
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

/* Reads the header of the portion in hand, if it has one. */
static enum rmap_status know_header(struct rmap_cursor *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    struct compact_rows in_hand;
    if (self->knows_header ||
        self->map->content.piece[info->piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(enter_rows(self, info, rmap_compact_header_streams(), &in_hand, err));
    st = rmap_compact_summarise_header(&in_hand.rows, &self->header, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
    self->knows_header = st == RMAP_OK;
out:
    return st;
}

enum rmap_status rmap_cursor_traced(struct rmap_cursor *self, rmap_column_set *traced_ret,
                                    struct rmap_error *err)
{
    const enum rmap_status st = know_header(self, err);
    const size_t piece = (size_t)self->map->content.portion[self->in_hand].piece;
    *traced_ret = self->knows_header ? rmap_compact_traced(self->header.placed) &
                                           ~rmap_map_columns_beside(self->map, piece)
                                     : 0;
    return st;
}

enum rmap_status rmap_cursor_weigh(struct rmap_cursor *self, bool *are_one_ret,
                                   struct rmap_error *err)
{
    const enum rmap_status st = know_header(self, err);
    *are_one_ret = self->knows_header && self->header.weigh_one;
    return st;
}

static enum rmap_status make_decoder(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                     struct rmap_error *err)
{
    struct rmap_cursor_space *space = &self->space[info->space];
    const struct rmap_compact_model *model;
    if (space->decoder)
        return RMAP_OK;
    const enum rmap_status st = rmap_map_model(self->map, (size_t)info->space, true, &model, err);
    return st == RMAP_OK ? rmap_compact_decoder_create(model, &space->decoder, err) : st;
}

/* Decodes columns of a portion of a compact piece into cursor->portion, where those that are
 * present stay. */
static enum rmap_status cursor_read_compact(struct rmap_cursor *self,
                                            const struct rmap_portion_info *info,
                                            rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    struct compact_rows in_hand;
    RMAP_TRY(enter_rows(self, info, rmap_compact_streams(columns, &self->header), &in_hand, err));
    RMAP_TRY(make_decoder(self, info, err));
    st = rmap_compact_decode(space->decoder, self->paths, &in_hand.rows, in_hand.n_row, columns,
                             self->present, self->portion, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
out:
    return st;
}

enum rmap_status rmap_cursor_path_summary(struct rmap_cursor *self, bool own_alone,
                                          struct rmap_path_summary *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const size_t piece = (size_t)info->piece;
    struct compact_rows in_hand;
    struct rmap_compact_summary summary;
    *paths = (struct rmap_path_summary){.paths = NULL};
    if (self->map->content.piece[piece].encoding != RMAP_ENCODING_COMPACT)
        return RMAP_OK;
    RMAP_TRY(enter_rows(self, info, rmap_compact_summary_streams(own_alone), &in_hand, err));
    st = rmap_compact_summarise(in_hand.model, self->paths, &in_hand.rows, in_hand.n_row, &summary,
                                err);
    if (st != RMAP_OK) {
        say_where(self, info, err);
        return st;
    }
    if (summary.weigh_one && summary.ids_run && summary.media_known &&
        summary.first_ray == info->first_ray && rmap_map_paths_fit(self->map, piece))
        *paths = (struct rmap_path_summary){
            .paths = rmap_path_table_rays(self->paths),
            .first_segment = rmap_path_table_first_segments(self->paths),
            .first_registration = rmap_path_table_first_registrations(self->paths),
            .path = summary.path,
            .n_own = summary.n_own,
            .classes = summary.classed ? rmap_path_table_classes(self->paths) : NULL,
            .n_own_segment = summary.n_own_segment};
out:
    return st;
}

enum rmap_status rmap_cursor_path_sums(struct rmap_cursor *self,
                                       const struct rmap_path_sum **sum_ret, struct rmap_error *err)
{
    return rmap_map_path_sums(self->map, self->paths_piece, sum_ret, err);
}

/* Weights of rays with path 0, and, where the paths of all rays are there, ids. */
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
    struct compact_rows in_hand;
    const uint64_t path = UINT64_C(1) << RMAP_STREAM_ray_path;
    const bool has_paths = self->streams & path;
    columns = self->own_columns | ((columns | RMAP_HEAD_COLUMNS) & RMAP_COLUMNS_DISCRETE);
    if (columns == self->own_columns && has_paths == self->own_has_ids)
        goto out;
    if (!self->own && !(self->own = rmap_alloc(1, sizeof *self->own)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    RMAP_TRY(know_header(self, err));
    RMAP_TRY(enter_rows(self, info,
                        rmap_compact_streams(columns, &self->header) & ~(has_paths ? 0 : path),
                        &in_hand, err));
    RMAP_TRY(rmap_compact_decode_own(in_hand.model, self->paths, &in_hand.rows, columns,
                                     &self->steps, self->own, err));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            RMAP_TRY(cursor_check_limits(self, self->own, (enum rmap_column)c, info, err));
    fill_own_rays(in_hand.rows.data[RMAP_STREAM_ray_path], in_hand.n_row[RMAP_TABLE_RAY],
                  info->first_ray, self->own);
    self->own_columns = columns;
    self->own_has_ids = has_paths;
out:
    *own_ret = self->own;
    return st;
}

enum rmap_status rmap_cursor_own_steps(struct rmap_cursor *self, struct rmap_own_steps *steps,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct compact_rows in_hand;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    RMAP_TRY(know_header(self, err));
    RMAP_TRY(enter_rows(self, info, rmap_compact_class_streams(), &in_hand, err));
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
    struct compact_rows in_hand;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    *sum_ret = NULL;
    RMAP_TRY(know_header(self, err));
    if (!self->header.measured)
        goto out;
    RMAP_TRY(enter_rows(self, info, UINT64_C(1) << RMAP_STREAM_pool16, &in_hand, err));
    RMAP_TRY(RMAP_RESERVE(self->own_sum, self->own_sum_cap,
                          in_hand.rows.n_row[RMAP_COMPACT_OWN] + 1, err));
    st = rmap_own_lengths_read(&in_hand.rows, self->own_sum, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
    else
        *sum_ret = self->own_sum;
out:
    return st;
}

enum rmap_status rmap_cursor_create(const struct rmap_map *map, rmap_column_set columns,
                                    struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    self->map = map;
    self->columns = columns & rmap_columns_of_run(map->scene[0]->timed);
    self->space = rmap_alloc(map->spaces.n, sizeof *self->space);
    if (!self->space) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
        goto out;
    }
    RMAP_TRY(rmap_chunk_reader_create(map, &self->reader, err));
    *cursor_ret = self;
    self = NULL;
out:
    rmap_cursor_destroy(self);
    return st;
}

void rmap_cursor_destroy(struct rmap_cursor *self)
{
    if (!self)
        return;
    for (size_t i = 0; self->space && i < self->map->spaces.n; i++) {
        rmap_portion_destroy(self->space[i].portion);
        rmap_portion_destroy(self->space[i].selected);
        rmap_compact_selection_destroy(self->space[i].selection);
        rmap_compact_decoder_destroy(self->space[i].decoder);
    }
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_free(self->buffer[s].data);
    cursor_leave_paths(self, SIZE_MAX);
    rmap_portion_destroy(self->own);
    rmap_free(self->steps.class);
    rmap_chunk_reader_destroy(self->reader);
    rmap_free(self->space);
    rmap_free(self->beside.data);
    rmap_free(self->some);
    rmap_free(self->own_sum);
    rmap_free(self);
}

uint64_t rmap_cursor_nbytes(const struct rmap_cursor *self)
{
    return rmap_chunk_reader_nbytes(self->reader);
}

uint64_t rmap_cursor_nbytes_of_rows(const struct rmap_cursor *self)
{
    return rmap_chunk_reader_nbytes_of_rows(self->reader);
}

/* Values of a column of rows of that portion must name something of the scene. */
static enum rmap_status cursor_check_limits(const struct rmap_cursor *self,
                                            const struct rmap_portion *rows,
                                            enum rmap_column column,
                                            const struct rmap_portion_info *info,
                                            struct rmap_error *err)
{
    if (rmap_portion_within(self->map->scene[0], rows, column))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: %s: a value of the block from ray %llu on names "
                          "nothing in the map's scene",
                          self->map->content.piece[info->piece].name,
                          rmap_column_info(column)->path, (unsigned long long)info->first_ray);
}

/* Takes the portion of a colour space in hand, empty. */
static enum rmap_status enter_space(struct rmap_cursor *self, size_t space, struct rmap_error *err)
{
    struct rmap_portion **portion = &self->space[space].portion;
    if (!*portion) {
        *portion = rmap_alloc(1, sizeof **portion);
        if (!*portion)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
        (*portion)->n_channel = self->map->spaces.space[space].n_channel;
        (*portion)->timed = self->map->scene[space]->timed;
    }
    self->portion = *portion;
    rmap_portion_clear(self->portion);
    return RMAP_OK;
}

/* Columns that stand as they are: the streams of a plain piece, or beside a compact one. */
static enum rmap_status read_plain(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                   bool is_beside, rmap_column_set columns, struct rmap_error *err)
{
    const uint64_t *first = is_beside ? rmap_map_first_rows(self->map, self->in_hand) : NULL;
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *rows = self->portion;
    bool has[RMAP_TABLE_COUNT] = {false};
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        has[rmap_column_info((enum rmap_column)c)->table] |= (columns & RMAP_COLUMN_BIT(c)) != 0;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        rows->n_row[t] = 0;
        if (has[t])
            RMAP_TRY(rmap_portion_reserve(rows, (enum rmap_table)t, (size_t)info->n_row[t],
                                          columns | self->present, err));
    }
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rows->n_row[t] = (size_t)info->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        enum rmap_table table = rmap_column_info((enum rmap_column)c)->table;
        if (!(columns & RMAP_COLUMN_BIT(c)))
            continue;
        void *to = rmap_portion_column(self->portion, (enum rmap_column)c);
        const int stored =
            rmap_map_piece_layout(self->map, (size_t)info->piece)->stream[is_beside ? 0 : c].table;
        if (is_beside)
            RMAP_TRY(rmap_chunk_reader_kept(self->reader, (size_t)info->piece, c, first[table],
                                            rows->n_row[table], to, err));
        else
            RMAP_TRY(rmap_chunk_reader_rows(self->reader, (size_t)info->piece, c,
                                            info->stored_first[stored], rows->n_row[table], to,
                                            err));
    }
out:
    return st;
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

/* Cells index images. */
static enum rmap_status check_cells(const struct rmap_cursor *self, const struct rmap_portion *rows,
                                    struct rmap_error *err)
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

#define CELL_COLUMNS                                                                               \
    (RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector))

#define CURVE_COLUMNS                                                                              \
    (RMAP_COLUMN_BIT(RMAP_CURVE_ray) | RMAP_COLUMN_BIT(RMAP_CURVE_segment) |                       \
     RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count))

/* Every point lies on a segment of a ray of the portion, in their order. */
static enum rmap_status check_curve(const struct rmap_cursor *self, struct rmap_error *err)
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

enum rmap_status rmap_cursor_enter(struct rmap_cursor *self, size_t portion,
                                   const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[portion];
    const struct rmap_piece_chunks *chunks;
    self->present = 0;
    self->kept = 0;
    self->streams = 0;
    self->in_hand = portion;
    self->own_columns = 0;
    self->knows_header = false;
    self->header = (struct rmap_compact_summary){.placed = false};
    cursor_leave_paths(self, (size_t)info->piece);
    RMAP_TRY(enter_space(self, (size_t)info->space, err));
    /* The piece's chunks vouch for its rows before memory is taken for them. */
    RMAP_TRY(rmap_map_piece_chunks(self->map, (size_t)info->piece, &chunks, err));
    self->portion->first_ray = info->first_ray;
    self->shown = *self->portion;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        self->shown.n_row[t] = (size_t)info->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        *rmap_portion_column_address(&self->shown, (enum rmap_column)c) = NULL;
    *portion_ret = &self->shown;
out:
    return st;
}

/* What the columns `fresh`, just read, say of the rows. */
static enum rmap_status check_columns(const struct rmap_cursor *self,
                                      const struct rmap_portion_info *info, rmap_column_set fresh,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (fresh & RMAP_COLUMN_BIT(c))
            RMAP_TRY(cursor_check_limits(self, &self->shown, (enum rmap_column)c, info, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_segment_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_segment_count, RMAP_TABLE_SEGMENT, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_registration_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_registration_count, RMAP_TABLE_REGISTRATION, err));
out:
    return st;
}

static void show_columns(const struct rmap_portion *rows, rmap_column_set columns,
                         struct rmap_portion *shown)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(shown, (enum rmap_column)c) =
                rmap_portion_column(rows, (enum rmap_column)c);
}

/* What is decoded when columns are asked for: rays are gone through once for all that their paths
 * say, and traced again once. */
static rmap_column_set compact_columns(const struct rmap_cursor *self, rmap_column_set columns)
{
    if (columns & rmap_compact_traced(self->header.placed))
        columns |= self->columns;
    if (columns & RMAP_COLUMNS_DISCRETE)
        columns |= self->columns & RMAP_COLUMNS_DISCRETE;
    return columns & ~self->present;
}

/* Of these columns of a compact portion, those that are read from beside its piece: where others
 * have its rays traced again, they come with them. */
static enum rmap_status choose_beside(struct rmap_cursor *self,
                                      const struct rmap_portion_info *info, rmap_column_set columns,
                                      rmap_column_set *beside_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_columns *kept;
    const rmap_column_set traced =
        rmap_compact_traced(self->header.placed) & rmap_columns_of_run(self->shown.timed);
    *beside_ret = 0;
    /* Who wants none of them does not look for the file, and who wants all has them from the piece.
     */
    if ((columns & traced) == 0 || (traced & ~self->columns) == 0)
        return RMAP_OK;
    RMAP_TRY(rmap_map_piece_columns(self->map, (size_t)info->piece, &kept, err));
    *beside_ret = kept ? columns & kept->columns : 0;
    if (columns & traced & ~*beside_ret)
        *beside_ret = 0;
out:
    return st;
}

static enum rmap_status read_columns(struct rmap_cursor *self, rmap_column_set columns,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    rmap_column_set fresh = columns, beside;
    if (self->map->content.piece[info->piece].encoding == RMAP_ENCODING_PLAIN) {
        RMAP_TRY(read_plain(self, info, false, fresh, err));
    } else {
        RMAP_TRY(know_header(self, err));
        RMAP_TRY(choose_beside(self, info, columns, &beside, err));
        if (beside) {
            RMAP_TRY(read_plain(self, info, true, beside, err));
            self->present |= beside;
        }
        fresh = compact_columns(self, columns & ~beside);
        if (fresh)
            RMAP_TRY(cursor_read_compact(self, info, fresh, err));
        fresh |= beside;
    }
    self->portion->first_ray = info->first_ray;
    self->present |= fresh;
    show_columns(self->portion, self->present, &self->shown);
    RMAP_TRY(check_columns(self, info, fresh, err));
    rmap_map_keep_columns(self->map, self->in_hand, fresh, &self->shown);
out:
    return st;
}

enum rmap_status rmap_cursor_fetch(struct rmap_cursor *self, rmap_column_set columns,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set cells = CELL_COLUMNS;
    columns &= rmap_columns_of_run(self->shown.timed);
    rmap_column_set before = self->present | self->kept;
    self->kept |=
        rmap_map_borrow_columns(self->map, self->in_hand, columns & ~before, &self->shown);
    rmap_column_set fresh = columns & ~(self->present | self->kept);
    if (fresh)
        RMAP_TRY(read_columns(self, fresh, err));
    rmap_column_set now = self->present | self->kept;
    if ((now & cells) == cells && (before & cells) != cells)
        RMAP_TRY(check_cells(self, &self->shown, err));
    if ((now & CURVE_COLUMNS) == CURVE_COLUMNS && (before & CURVE_COLUMNS) != CURVE_COLUMNS)
        RMAP_TRY(check_curve(self, err));
out:
    return st;
}

enum rmap_status rmap_cursor_read(struct rmap_cursor *self, size_t portion,
                                  const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = rmap_cursor_enter(self, portion, portion_ret, err);
    return st == RMAP_OK ? rmap_cursor_fetch(self, self->columns, err) : st;
}

/* Where rays are selected, at most one of so many: selecting one costs as much as some that are
 * traced again with all others; and as much as reading many where the columns stand beside. */
enum { SELECTED_SHARE = 2, BESIDE_SHARE = 16 };

bool rmap_map_selects(const struct rmap_map *map, size_t portion, rmap_column_set columns)
{
    const struct rmap_portion_info *info = &map->content.portion[portion];
    struct rmap_map_kept kept;
    rmap_map_kept(map, &kept);
    return map->content.piece[info->piece].encoding == RMAP_ENCODING_COMPACT &&
           (columns & rmap_compact_traced(false)) && kept.budget == 0 &&
           !((columns & RMAP_COLUMNS_CURVE) && info->n_row[RMAP_TABLE_CURVE] > 0);
}

enum rmap_status rmap_cursor_compare_beside(struct rmap_cursor *self, enum rmap_column *differs_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const rmap_column_set columns = rmap_map_columns_beside(self->map, (size_t)info->piece);
    *differs_ret = RMAP_COLUMN_COUNT;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const enum rmap_table table = rmap_column_info((enum rmap_column)c)->table;
        const size_t n = self->shown.n_row[table];
        const size_t nbytes = n * rmap_portion_row_nbytes(&self->shown, (enum rmap_column)c);
        if (!(columns & RMAP_COLUMN_BIT(c)) || nbytes == 0)
            continue;
        RMAP_TRY(rmap_reserve(&self->beside.data, &self->beside.cap, nbytes, 1, err));
        RMAP_TRY(rmap_chunk_reader_kept(self->reader, (size_t)info->piece, c,
                                        rmap_map_first_rows(self->map, self->in_hand)[table], n,
                                        self->beside.data, err));
        if (memcmp(self->beside.data, rmap_portion_column(&self->shown, (enum rmap_column)c),
                   nbytes) != 0)
            *differs_ret = (enum rmap_column)c;
    }
out:
    return st;
}

/* The rows of the marked rays, into `some`. */
static enum rmap_status list_marked(struct rmap_cursor *self, const uint8_t *mark, uint8_t wanted,
                                    size_t *n_ret, struct rmap_error *err)
{
    const size_t n_ray = self->shown.n_row[RMAP_TABLE_RAY];
    const enum rmap_status st = RMAP_RESERVE(self->some, self->some_cap, n_ray + 1, err);
    size_t n = 0;
    for (size_t i = 0; st == RMAP_OK && i < n_ray; i++) { /* one more than counts is written */
        self->some[n] = (uint32_t)i;
        n += mark[i] == wanted;
    }
    *n_ret = n;
    return st;
}

/* Decodes n rays of `some` into what the space has for them. */
static enum rmap_status decode_selected(struct rmap_cursor *self,
                                        const struct rmap_portion_info *info, size_t n,
                                        rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    struct compact_rows in_hand;
    const struct rmap_rows *rows = NULL;
    size_t n_row[RMAP_TABLE_COUNT];
    RMAP_TRY(enter_rows(self, info, rmap_compact_selection_streams(columns, &self->header),
                        &in_hand, err));
    RMAP_TRY(make_decoder(self, info, err));
    if (!space->selection)
        RMAP_TRY(rmap_compact_selection_create(in_hand.model, &space->selection, err));
    if (!space->selected)
        RMAP_TRY(rmap_portion_create(0, self->portion->n_channel, &space->selected, err));
    st = rmap_compact_select(space->selection, self->paths, &in_hand.rows, in_hand.n_row, columns,
                             self->some, n, &rows, n_row, err);
    if (st == RMAP_OK)
        st = rmap_compact_decode(space->decoder, self->paths, rows, n_row, columns, 0,
                                 space->selected, err);
    if (st != RMAP_OK)
        say_where(self, info, err);
out:
    return st;
}

enum rmap_status rmap_cursor_select(struct rmap_cursor *self, const uint8_t *mark, uint8_t wanted,
                                    rmap_column_set columns,
                                    const struct rmap_portion **selected_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    size_t n = 0;
    *selected_ret = NULL;
    columns &= rmap_columns_of_run(self->shown.timed);
    if (!rmap_map_selects(self->map, self->in_hand, columns) ||
        !(columns & ~self->present & rmap_compact_traced(false)))
        return RMAP_OK;
    rmap_column_set beside;
    RMAP_TRY(know_header(self, err));
    RMAP_TRY(choose_beside(self, info, columns & ~self->present, &beside, err));
    RMAP_TRY(list_marked(self, mark, wanted, &n, err));
    if (n == 0 || n * (beside ? BESIDE_SHARE : SELECTED_SHARE) > info->n_row[RMAP_TABLE_RAY])
        goto out;
    RMAP_TRY(decode_selected(self, info, n, columns, err));
    const struct rmap_portion *rows = self->space[info->space].selected;
    self->selected = (struct rmap_portion){
        .n_channel = rows->n_channel, .timed = rows->timed, .first_ray = rows->first_ray};
    memcpy(self->selected.n_row, rows->n_row, sizeof rows->n_row);
    show_columns(rows, columns, &self->selected);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            RMAP_TRY(cursor_check_limits(self, &self->selected, (enum rmap_column)c, info, err));
    if ((columns & CELL_COLUMNS) == CELL_COLUMNS)
        RMAP_TRY(check_cells(self, &self->selected, err));
    *selected_ret = &self->selected;
out:
    return st;
}
