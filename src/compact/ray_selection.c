/* SPDX-License-Identifier: MIT
 *
 * Some rays of a portion as the rows of a portion of those alone.
 */
#include "compact/ray_selection.h"

#include "base/alloc.h"
#include "base/wide.h"
#include "compact/angles.h"
#include "compact/compact.h"
#include "compact/damaged.h"
#include "compact/decode_paths.h"
#include "compact/lane.h"
#include "compact/paths.h"
#include "compact/primitives.h"
#include "compact/streams.h"

/* Rows of a table that belong to one ray. */
struct span {
    size_t first, n;
};

struct rmap_compact_selection {
    const struct rmap_compact_model *model;
    struct rmap_lane lane[RMAP_LANE_COUNT]; /* of the whole portion */
    struct rmap_portion *ids;               /* of the whole portion: its ids, and counts of rows */
    struct span *span[RMAP_TABLE_HISTORY_COUNT]; /* [rays that are selected] */
    size_t span_cap[RMAP_TABLE_HISTORY_COUNT];
    struct rmap_rows rows; /* data: the selection's, [cap] bytes each */
    size_t n[RMAP_STREAM_MAX], cap[RMAP_STREAM_MAX], row_nbytes[RMAP_STREAM_MAX];
    size_t width[RMAP_LANE_COUNT]; /* numbers per row */
    int32_t *object;               /* of a path of its own */
    size_t object_cap;
    struct rmap_step_buffer steps; /* of the whole portion's own paths */
    uint16_t *angle, *some_angles; /* of the whole portion's registrations; of the rays' */
    size_t angle_cap, some_angles_cap;
};

enum rmap_status rmap_compact_selection_create(const struct rmap_compact_model *model,
                                               struct rmap_compact_selection **selection_ret,
                                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compact_selection *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoder");
    self->model = model;
    self->rows.layout = &rmap_compact_layout;
    self->rows.n_channel = model->n_channel;
    self->rows.add_up = true; /* as those do that rays are selected of */
    rmap_lanes_init(self->lane);
    RMAP_TRY(rmap_portion_create(0, model->n_channel, &self->ids, err));
    self->ids->timed = model->scene->timed;
    for (int s = 0; s < RMAP_COMPACT_STREAM_COUNT; s++)
        self->row_nbytes[s] =
            rmap_stream_row_nbytes(&self->rows.layout->stream[s], model->n_channel);
    for (int i = 0; i < RMAP_LANE_COUNT; i++)
        self->width[i] =
            rmap_portion_row_nbytes(self->ids, self->lane[i].column) / self->lane[i].element_nbytes;
    *selection_ret = self;
    self = NULL;
out:
    rmap_compact_selection_destroy(self);
    return st;
}

void rmap_compact_selection_destroy(struct rmap_compact_selection *self)
{
    if (!self)
        return;
    rmap_portion_destroy(self->ids);
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        rmap_free(self->span[t]);
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_free(self->rows.data[s]);
    rmap_free(self->object);
    rmap_free(self->steps.class);
    rmap_free(self->angle);
    rmap_free(self->some_angles);
    rmap_free(self);
}

/* Columns whose lanes are taken: all where rays are traced again. */
static rmap_column_set used_columns(rmap_column_set columns, bool placed)
{
    const rmap_column_set needs = rmap_compact_needs(columns, placed);
    return needs & rmap_compact_traced(placed) ? RMAP_COLUMNS_ALL : needs;
}

uint64_t rmap_compact_selection_streams(rmap_column_set columns,
                                        const struct rmap_compact_summary *header)
{
    return rmap_compact_streams(columns & ~RMAP_COLUMNS_CURVE, header);
}

/* Room for n more rows of a stream. */
static inline enum rmap_status make_room(struct rmap_compact_selection *self, int stream, size_t n,
                                         struct rmap_error *err)
{
    const size_t nbytes = (self->n[stream] + n) * self->row_nbytes[stream];
    return nbytes < self->cap[stream]
               ? RMAP_OK
               : rmap_reserve(&self->rows.data[stream], &self->cap[stream], nbytes + 1, 1, err);
}

/* Rows [first, first + n) of `from`, which is a stream's. */
static inline enum rmap_status append(struct rmap_compact_selection *self, int stream,
                                      const void *from, size_t first, size_t n,
                                      struct rmap_error *err)
{
    const size_t nbytes = self->row_nbytes[stream], at = self->n[stream] * nbytes;
    const enum rmap_status st = make_room(self, stream, n, err);
    if (st == RMAP_OK && n > 0)
        memcpy((uint8_t *)self->rows.data[stream] + at, (const uint8_t *)from + first * nbytes,
               n * nbytes);
    self->n[stream] += n;
    return st;
}

/* Rows of the portion before a ray: all, those of rays with paths of their own, and triangles. */
struct place {
    size_t segment, registration, own, own_segment, own_registration, triangle;
};

/* What a selection is of. */
struct origin {
    const struct rmap_path_table *table;
    struct rmap_own_paths own;
    bool listed; /* triangles are wanted, and the portion lists some */
};

/* Triangles that are listed of n segments. */
static size_t count_listed(const struct rmap_path_table *table, const uint32_t *class, size_t n)
{
    const uint8_t *listed = table->listed;
    const size_t n_class = table->classes.n;
    size_t sum = 0;
    RMAP_UNROLL
    for (size_t i = 0; i < n; i++)
        sum += listed[class[i] < n_class ? class[i] : n_class];
    return sum;
}

/* The same of own paths [k, end), whose segments begin at row `from`, by their objects. */
static enum rmap_status add_unclassed(struct rmap_compact_selection *self,
                                      const struct rmap_own_paths *own, size_t k, size_t end,
                                      size_t from, size_t *sum, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (; k < end; from += own->segment_count[k++]) {
        const size_t n = own->segment_count[k];
        RMAP_TRY(RMAP_RESERVE(self->object, self->object_cap, n + 1, err));
        rmap_own_path_unfold(own, k, from, &(struct rmap_path_columns){.object = self->object});
        *sum += rmap_primitives_listed(own->model, self->object, n);
    }
out:
    return st;
}

/* On behind n more own paths. */
static enum rmap_status pass_own(struct rmap_compact_selection *self, const struct origin *of,
                                 size_t n, struct place *at, struct rmap_error *err)
{
    const struct rmap_own_paths *own = &of->own;
    const size_t k = at->own, from = at->own_segment;
    size_t n_segment = 0, n_registration = 0;
    for (size_t j = k; j < k + n; j++) {
        n_segment += own->segment_count[j];
        n_registration += own->registration_count[j];
    }
    at->own += n;
    at->own_segment += n_segment;
    at->own_registration += n_registration;
    at->segment += n_segment;
    at->registration += n_registration;
    if (of->listed && own->classed)
        at->triangle += count_listed(of->table, own->object + from, n_segment);
    return of->listed && !own->classed
               ? add_unclassed(self, own, k, k + n, from, &at->triangle, err)
               : RMAP_OK;
}

/* On behind the rays of these paths, those of the table. Returns how many are of their own. */
static inline size_t pass(const struct origin *of, const uint32_t *path, size_t n, struct place *at)
{
    const uint32_t *n_listed = of->table->n_listed;
    const struct rmap_path_count *count = of->table->count;
    size_t n_own = 0;
    for (size_t i = 0; i < n; i++) { /* path 0 has no rows there */
        at->segment += count[path[i]].n_segment;
        at->registration += count[path[i]].n_registration;
        n_own += path[i] == 0;
    }
    for (size_t i = 0; of->listed && i < n; i++)
        at->triangle += n_listed[path[i]];
    return n_own;
}

/* Streams of what rays with paths of their own have, as far as they are there. */
struct own_stream {
    const uint8_t *from;
    size_t nbytes; /* of a row */
    int stream, kind;
};
/* Kinds are their tables, in this order: of paths, segments, registrations. */
enum { OWN_KINDS = 3 };
_Static_assert(RMAP_COMPACT_OWN_SEGMENT == RMAP_COMPACT_OWN + 1 &&
                   RMAP_COMPACT_OWN_REGISTRATION == RMAP_COMPACT_OWN + 2,
               "kinds are tables");
struct own_streams {
    struct own_stream of[RMAP_STREAM_OWN_registered - RMAP_STREAM_OWN_source + 1];
    size_t n;
};

/* With room for all rows. */
static enum rmap_status open_own(struct rmap_compact_selection *self, const struct rmap_rows *rows,
                                 struct own_streams *streams, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    streams->n = 0;
    for (int s = RMAP_STREAM_OWN_source; s <= RMAP_STREAM_OWN_registered; s++) {
        const int table = rows->layout->stream[s].table;
        if (!rows->data[s])
            continue;
        RMAP_TRY(make_room(self, s, rows->n_row[table], err));
        streams->of[streams->n++] =
            (struct own_stream){rows->data[s], self->row_nbytes[s], s, table - RMAP_COMPACT_OWN};
    }
out:
    return st;
}

/* The rows of a ray that has its path for itself, from `at` up to `next`. */
static void append_own_path(struct rmap_compact_selection *self, const struct own_streams *streams,
                            const struct place *at, const struct place *next)
{
    const size_t first[OWN_KINDS] = {at->own, at->own_segment, at->own_registration},
                 count[OWN_KINDS] = {1, next->own_segment - at->own_segment,
                                     next->own_registration - at->own_registration};
    for (size_t k = 0; k < streams->n; k++) {
        const struct own_stream *its = &streams->of[k];
        const size_t nbytes = count[its->kind] * its->nbytes;
        uint8_t *to = (uint8_t *)self->rows.data[its->stream] + self->n[its->stream] * its->nbytes;
        if (nbytes > 0)
            memcpy(to, its->from + first[its->kind] * its->nbytes, nbytes);
        self->n[its->stream] += count[its->kind];
    }
    self->rows.n_row[RMAP_COMPACT_OWN_SEGMENT] += count[1];
    self->rows.n_row[RMAP_COMPACT_OWN_REGISTRATION] += count[2];
}

/* The numbers of paths and channels. */
static enum rmap_status select_numbers(struct rmap_compact_selection *self,
                                       const struct rmap_rows *rows, rmap_column_set used,
                                       const uint32_t *ray, size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t *path = rows->data[RMAP_STREAM_ray_path];
    const uint8_t *channel = rows->data[RMAP_STREAM_ray_channel];
    const size_t n_channel = used & RMAP_COLUMN_BIT(RMAP_RAY_wavelength) ? n : 0;
    RMAP_TRY(make_room(self, RMAP_STREAM_ray_path, n, err));
    RMAP_TRY(make_room(self, RMAP_STREAM_ray_channel, n_channel, err));
    uint32_t *to = self->rows.data[RMAP_STREAM_ray_path];
    uint8_t *to_channel = self->rows.data[RMAP_STREAM_ray_channel];
    for (size_t k = 0; k < n; k++)
        to[k] = path[ray[k]];
    for (size_t k = 0; k < n_channel; k++)
        to_channel[k] = channel[ray[k]];
    self->n[RMAP_STREAM_ray_path] = n;
    self->n[RMAP_STREAM_ray_channel] = n_channel;
out:
    return st;
}

/* n of the triangles, from `at` on. */
static enum rmap_status append_triangles(struct rmap_compact_selection *self,
                                         const struct rmap_rows *rows, size_t at, size_t n,
                                         struct rmap_error *err)
{
    const size_t all = rows->n_row[RMAP_COMPACT_TRIANGLE];
    if (at > all || n > all - at)
        return rmap_portion_damaged("it has too few triangles", err);
    return append(self, RMAP_STREAM_triangle, rows->data[RMAP_STREAM_triangle], at, n, err);
}

/* Paths, channels and triangles of the rays, and where their rows lie. */
static enum rmap_status select_paths(struct rmap_compact_selection *self, const struct origin *of,
                                     const struct rmap_rows *rows, rmap_column_set used,
                                     const uint32_t *ray, size_t n,
                                     size_t selected_row[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct place at = {0};
    struct own_streams streams;
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(RMAP_RESERVE(self->span[t], self->span_cap[t], n + 1, err));
    RMAP_TRY(open_own(self, rows, &streams, err));
    RMAP_TRY(select_numbers(self, rows, used, ray, n, err));
    memset(selected_row, 0, RMAP_TABLE_COUNT * sizeof *selected_row);
    selected_row[RMAP_TABLE_RAY] = n;
    for (size_t k = 0, i = 0; k < n; i = (size_t)ray[k++] + 1) {
        const size_t n_own = pass(of, of->own.path + i, ray[k] - i, &at);
        if (n_own > 0)
            RMAP_TRY(pass_own(self, of, n_own, &at, err));
        struct place next = at;
        if (pass(of, of->own.path + ray[k], 1, &next) > 0)
            RMAP_TRY(pass_own(self, of, 1, &next, err));
        const struct span its[RMAP_TABLE_HISTORY_COUNT] = {
            [RMAP_TABLE_RAY] = {ray[k], 1},
            [RMAP_TABLE_SEGMENT] = {at.segment, next.segment - at.segment},
            [RMAP_TABLE_REGISTRATION] = {at.registration, next.registration - at.registration}};
        for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
            self->span[t][k] = its[t];
        selected_row[RMAP_TABLE_SEGMENT] += its[RMAP_TABLE_SEGMENT].n;
        selected_row[RMAP_TABLE_REGISTRATION] += its[RMAP_TABLE_REGISTRATION].n;
        if (next.own > at.own)
            append_own_path(self, &streams, &at, &next);
        if (of->listed)
            RMAP_TRY(append_triangles(self, rows, at.triangle, next.triangle - at.triangle, err));
        at = next;
    }
out:
    return st;
}

/* Numbers of a lane that belong to the k-th of the rays. */
static struct span numbers_of(const struct rmap_compact_selection *self,
                              const struct rmap_lane *lane, size_t k)
{
    const struct span *rows = &self->span[rmap_column_info(lane->column)->table][k];
    const size_t width = self->width[lane - self->lane];
    return (struct span){rows->first * width, rows->n * width};
}

/* Patches of a lane that lie on numbers of the n rays; *n_ret: how many. */
static enum rmap_status select_patches(struct rmap_compact_selection *self,
                                       const struct rmap_lane *lane, size_t n, uint64_t *n_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t at = 0, to = 0, after_last = 0, k = 0;
    struct span its = numbers_of(self, lane, 0);
    *n_ret = 0;
    for (size_t p = 0; p < lane->patches_left; p++, at++) {
        at += lane->patch_skip[p];
        while (at >= its.first + its.n) {
            to += its.n;
            if (++k == n)
                return RMAP_OK;
            its = numbers_of(self, lane, k);
        }
        if (at < its.first)
            continue;
        const size_t now = to + (at - its.first);
        const uint32_t skip = (uint32_t)(now - after_last);
        RMAP_TRY(append(self, RMAP_STREAM_patch_skip, &skip, 0, 1, err));
        RMAP_TRY(append(self, RMAP_STREAM_patch_value, &lane->patch_value[p], 0, 1, err));
        after_last = now + 1;
        ++*n_ret;
    }
out:
    return st;
}

/* Numbers of a lane that is stored whole. */
static enum rmap_status select_dense(struct rmap_compact_selection *self,
                                     const struct rmap_lane *lane, size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int pool = lane->element_nbytes == 2   ? RMAP_STREAM_pool16
                     : lane->element_nbytes == 4 ? RMAP_STREAM_pool32
                                                 : RMAP_STREAM_pool64;
    const struct span *rows = self->span[rmap_column_info(lane->column)->table];
    const size_t width = self->width[lane - self->lane], nbytes = width * lane->element_nbytes;
    size_t n_row = 0;
    for (size_t k = 0; k < n; k++)
        n_row += rows[k].n;
    RMAP_TRY(make_room(self, pool, n_row * width, err));
    uint8_t *to = (uint8_t *)self->rows.data[pool] + self->n[pool] * lane->element_nbytes;
    for (size_t k = 0; k < n; to += rows[k++].n * nbytes) {
        const uint8_t *from = lane->dense + rows[k].first * nbytes;
        if (rows[k].n * nbytes == 4) /* one place: most are */
            memcpy(to, from, 4);
        else if (rows[k].n > 0)
            memcpy(to, from, rows[k].n * nbytes);
    }
    self->n[pool] += n_row * width;
out:
    return st;
}

/* Behind the lanes, the angles of n rays. */
static enum rmap_status select_angles(struct rmap_compact_selection *self,
                                      const struct rmap_lane_header *header, size_t n,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct span *its = self->span[RMAP_TABLE_REGISTRATION];
    const size_t n_all = self->ids->n_row[RMAP_TABLE_REGISTRATION];
    size_t n_some = 0;
    RMAP_TRY(RMAP_RESERVE(self->angle, self->angle_cap, n_all, err));
    RMAP_TRY(RMAP_RESERVE(self->some_angles, self->some_angles_cap, n_all, err));
    rmap_angles_unpack(&header->angles, n_all, self->angle);
    for (size_t k = 0; k < n; n_some += its[k++].n)
        if (its[k].n > 0)
            memcpy(self->some_angles + n_some, self->angle + its[k].first,
                   its[k].n * sizeof *self->angle);
    const size_t n16 = rmap_angle_part_rows(n_some), n32 = rmap_angle_degree_rows(n_some);
    RMAP_TRY(make_room(self, RMAP_STREAM_pool16, n16, err));
    RMAP_TRY(make_room(self, RMAP_STREAM_pool32, n32, err));
    uint16_t *parts = self->rows.data[RMAP_STREAM_pool16];
    uint32_t *degrees = self->rows.data[RMAP_STREAM_pool32];
    rmap_angles_pack(self->some_angles, n_some, degrees + self->n[RMAP_STREAM_pool32],
                     parts + self->n[RMAP_STREAM_pool16]);
    self->n[RMAP_STREAM_pool16] += n16;
    self->n[RMAP_STREAM_pool32] += n32;
    rmap_lane_header_set_angled(self->rows.data[RMAP_STREAM_pool64]);
out:
    return st;
}

/* Each ray's id follows from that before it: they are stored whole. */
static void show_ids(struct rmap_compact_selection *self, uint64_t first)
{
    struct rmap_lane *lane = &self->lane[RMAP_LANE_RAY_id];
    rmap_lane_fill_ids(lane, first, lane->n, self->ids->ray.id);
    lane->mode = RMAP_LANE_VERBATIM;
    lane->dense = (const uint8_t *)self->ids->ray.id;
}

/* Header and lanes; those of columns outside `used` become predicted ones. */
static enum rmap_status select_lanes(struct rmap_compact_selection *self,
                                     const struct rmap_rows *rows, rmap_column_set used, size_t n,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_lane_store store = rmap_lane_store_of(rows);
    struct rmap_lane_header header;
    uint64_t row[RMAP_LANE_HEADER_ROWS];
    RMAP_TRY(rmap_lanes_load(self->lane, &store, RMAP_COLUMN_BIT(RMAP_RAY_id), used, self->ids,
                             &header, err));
    if (used & RMAP_COLUMN_BIT(RMAP_RAY_id))
        show_ids(self, header.first_ray);
    for (int i = 0; i < header.n_lane; i++) {
        struct rmap_lane *lane = &self->lane[i];
        header.n_patch[i] = 0;
        if (!(used & RMAP_COLUMN_BIT(lane->column)))
            lane->mode = RMAP_LANE_PREDICTED;
        if (lane->mode == RMAP_LANE_PATCHED) {
            RMAP_TRY(select_patches(self, lane, n, &header.n_patch[i], err));
            lane->mode = header.n_patch[i] > 0 ? RMAP_LANE_PATCHED : RMAP_LANE_PREDICTED;
        }
        header.mode[i] = (uint8_t)lane->mode;
    }
    header.n_code = 0;
    header.placed &= self->lane[RMAP_LANE_REGISTRATION_relative].mode == RMAP_LANE_VERBATIM;
    rmap_lane_header_write(&header, row);
    RMAP_TRY(append(self, RMAP_STREAM_pool64, row, 0, rmap_lane_header_rows(header.n_lane), err));
    for (int i = 0; i < header.n_lane; i++)
        if (self->lane[i].mode == RMAP_LANE_RESIDUAL || self->lane[i].mode == RMAP_LANE_VERBATIM)
            RMAP_TRY(select_dense(self, &self->lane[i], n, err));
    if (header.angles.degrees && (used & RMAP_COLUMNS_ANGLES))
        RMAP_TRY(select_angles(self, &header, n, err));
out:
    return st;
}

enum rmap_status rmap_compact_select(struct rmap_compact_selection *self,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *stored,
                                     const size_t n_row[RMAP_TABLE_COUNT], rmap_column_set columns,
                                     const uint32_t *ray, size_t n,
                                     const struct rmap_rows **selected_ret,
                                     size_t selected_row[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compact_summary summary;
    struct rmap_rows unpacked, *const rows = &unpacked;
    RMAP_TRY(rmap_compact_summarise(self->model, table, stored, n_row, &summary, err));
    RMAP_TRY(rmap_step_codes_unpack(stored, summary.n_code, &self->steps, &unpacked, err));
    const rmap_column_set used = used_columns(columns, summary.placed);
    memset(self->n, 0, sizeof self->n);
    memset(self->rows.n_row, 0, sizeof self->rows.n_row);
    self->ids->n_row[RMAP_TABLE_RAY] = 0;
    RMAP_TRY(rmap_portion_reserve(self->ids, RMAP_TABLE_RAY, n_row[RMAP_TABLE_RAY],
                                  RMAP_COLUMN_BIT(RMAP_RAY_id), err));
    memcpy(self->ids->n_row, n_row, sizeof self->ids->n_row);
    const struct origin of = {.table = table,
                              .own = rmap_own_paths(self->model, table, rows, summary.classed),
                              .listed = used & RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive) &&
                                        rows->n_row[RMAP_COMPACT_TRIANGLE] > 0};
    RMAP_TRY(select_paths(self, &of, rows, used, ray, n, selected_row, err));
    RMAP_TRY(select_lanes(self, rows, used, n, err));
    for (int s = 0; s < RMAP_COMPACT_STREAM_COUNT; s++) { /* streams that are not used have none */
        size_t *rows_of = &self->rows.n_row[self->rows.layout->stream[s].table];
        *rows_of = self->n[s] > *rows_of ? self->n[s] : *rows_of;
    }
    *selected_ret = &self->rows;
out:
    return st;
}
