/* SPDX-License-Identifier: MIT
 *
 * Scenes from text, portions traced or made up in them, and one way through the compact encoding
 * and back. For its tests.
 */
#ifndef COMPACT_RIG_H
#define COMPACT_RIG_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "accel/accel.h"
#include "base/alloc.h"
#include "compact/compact.h"
#include "compact/encoder.h"
#include "compact/model.h"
#include "compact/paths.h"
#include "compact/ray_selection.h"
#include "compact/streams.h"
#include "io/codec/codec.h"
#include "io/mesh/bundle.h"
#include "portion/portion_recorder.h"
#include "trace/tracer.h"

#define RIG_SEED 77

struct rig {
    struct rmap_bundle *bundle;
    struct rmap_diagnostics diagnostics;
    struct rmap_scene *scene;
    struct rmap_compact_model *model;
    struct rmap_compact_encoder *encoder;
    struct rmap_compact_decoder *decoder;
    struct rmap_path_book *book;
    struct rmap_portion *decoded;
    struct rmap_rows whole; /* dictionary so far; owned */
};

static inline void rig_ok(enum rmap_status st, const struct rmap_error *err)
{
    if (st != RMAP_OK)
        fail_msg("%s", err->text);
}

static inline void rig_open(struct rig *rig, const char *path)
{
    struct rmap_error err = {0};
    struct rmap_scene_options options = {0};
    memset(rig, 0, sizeof *rig);
    rmap_diagnostics_init(&rig->diagnostics, path);
    rig_ok(rmap_bundle_open(path, &options, &rig->bundle, &err), &err);
    rig_ok(rmap_scene_read(rig->bundle, &rig->scene, &rig->diagnostics, &err), &err);
    rig_ok(rmap_compact_model_create(rig->scene, &rig->model, &err), &err);
    rig_ok(rmap_compact_encoder_create(rig->model, &rig->encoder, &err), &err);
    rig_ok(rmap_compact_decoder_create(rig->model, &rig->decoder, &err), &err);
    rig_ok(rmap_path_book_create(&rig->book, &err), &err);
    rig_ok(rmap_portion_create(1, rig->scene->channels.n, &rig->decoded, &err), &err);
    rig->whole.layout = &rmap_compact_layout;
    rig->whole.n_channel = rig->scene->channels.n;
}

static inline void rig_open_text(struct rig *rig, const char *text)
{
    char path[] = "/tmp/compact-scene-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
    close(fd);
    rig_open(rig, path);
    unlink(path);
}

static inline void rows_free(struct rmap_rows *rows)
{
    for (int s = 0; s < rmap_compact_layout.n_stream; s++)
        rmap_free(rows->data[s]);
    memset(rows, 0, sizeof *rows);
}

static inline void rig_close(struct rig *rig)
{
    rows_free(&rig->whole);
    rmap_portion_destroy(rig->decoded);
    rmap_path_book_destroy(rig->book);
    rmap_compact_decoder_destroy(rig->decoder);
    rmap_compact_encoder_destroy(rig->encoder);
    rmap_compact_model_destroy(rig->model);
    rmap_scene_destroy(rig->scene);
    rmap_bundle_destroy(rig->bundle);
    rmap_diagnostics_fini(&rig->diagnostics);
}

/* unpredicted: those of the rays that the tracer does not promise anything about. */
static inline struct rmap_portion *rig_trace_told(const struct rig *rig, uint64_t first, size_t n,
                                                  struct rmap_unpredicted *unpredicted)
{
    struct rmap_error err = {0};
    struct rmap_accel *accel = NULL;
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    rig_ok(rmap_accel_create(rig->scene, 1, &accel, &err), &err);
    rig_ok(rmap_portion_create(n, rig->scene->channels.n, &portion, &err), &err);
    rig_ok(rmap_portion_set_timed(portion, rig->scene->timed, &err), &err);
    rmap_portion_recorder_init(&recorder, portion);
    const struct rmap_tracer tracer = {rig->scene, accel, RIG_SEED};
    for (uint64_t ray = first; ray < first + n; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    assert_int_equal(recorder.status, RMAP_OK);
    rmap_accel_destroy(accel);
    *unpredicted = recorder.unpredicted;
    unpredicted->seed = RIG_SEED;
    return portion;
}

static inline struct rmap_portion *rig_trace(const struct rig *rig, uint64_t first, size_t n)
{
    struct rmap_unpredicted unpredicted;
    return rig_trace_told(rig, first, n, &unpredicted);
}

static inline size_t stream_nbytes(const struct rmap_rows *rows, int s)
{
    const struct rmap_stream_info *info = &rmap_compact_layout.stream[s];
    return rows->n_row[info->table] * rmap_stream_row_nbytes(info, rows->n_channel);
}

static inline bool is_whole(int s)
{
    return rmap_compact_layout.whole_tables >> rmap_compact_layout.stream[s].table & 1;
}

/* A copy with every stream in a block of its own of exactly its length. whole: of those tables. */
static inline void rows_copy(const struct rmap_rows *from, bool whole, struct rmap_rows *to)
{
    *to = (struct rmap_rows){.layout = from->layout, .n_channel = from->n_channel};
    for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
        size_t nbytes = stream_nbytes(from, s);
        if (is_whole(s) != whole)
            continue;
        to->n_row[rmap_compact_layout.stream[s].table] =
            from->n_row[rmap_compact_layout.stream[s].table];
        to->data[s] = rmap_alloc(nbytes, 1);
        if (nbytes > 0)
            memcpy(to->data[s], from->data[s], nbytes);
    }
}

/* Rows of the portion; the dictionary grows by what it entered. */
static inline void rig_encode(struct rig *rig, uint64_t seed, const struct rmap_portion *portion,
                              struct rmap_rows *own)
{
    struct rmap_error err = {0};
    struct rmap_rows rows;
    rig_ok(rmap_compact_encode(rig->encoder, seed, portion, &err), &err);
    rig_ok(rmap_compact_resolve(rig->encoder, rig->book, &rows, &err), &err);
    assert_ptr_equal(rows.layout, &rmap_compact_layout);
    rows_copy(&rows, false, own);
    for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
        if (!is_whole(s))
            continue;
        size_t old = stream_nbytes(&rig->whole, s), more = stream_nbytes(&rows, s);
        rig->whole.data[s] = rmap_realloc(rig->whole.data[s], old + more + 1, 1);
        if (more > 0)
            memcpy((char *)rig->whole.data[s] + old, rows.data[s], more);
    }
    for (int t = 0; t < rmap_compact_layout.n_table; t++)
        if (rmap_compact_layout.whole_tables >> t & 1)
            rig->whole.n_row[t] += rows.n_row[t];
}

static inline void rig_decode(struct rig *rig, const struct rmap_rows *own,
                              const struct rmap_portion *like, rmap_column_set columns)
{
    struct rmap_error err = {0};
    struct rmap_path_table *table = NULL;
    rig_ok(rmap_path_table_create(rig->model, &rig->whole, &table, &err), &err);
    rig_ok(
        rmap_compact_decode(rig->decoder, table, own, like->n_row, columns, 0, rig->decoded, &err),
        &err);
    rmap_path_table_destroy(table);
}

static inline void assert_columns_equal(const struct rmap_portion *a, const struct rmap_portion *b,
                                        rmap_column_set columns)
{
    columns &= rmap_columns_of_run(a->timed);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        enum rmap_column column = (enum rmap_column)c;
        size_t nbytes =
            rmap_portion_row_nbytes(a, column) * a->n_row[rmap_column_info(column)->table];
        if ((columns >> c & 1) && nbytes > 0 &&
            memcmp(rmap_portion_column(a, column), rmap_portion_column(b, column), nbytes) != 0)
            fail_msg("%s is not what it was", rmap_column_info(column)->path);
    }
}

/* Columns that are there stay as they are when others are decoded beside them. */
static inline void rig_keep(struct rig *rig, const struct rmap_rows *own,
                            const struct rmap_portion *portion)
{
    const rmap_column_set kept =
        RMAP_COLUMN_BIT(RMAP_RAY_path_length) | RMAP_COLUMN_BIT(RMAP_RAY_end_direction);
    const rmap_column_set more = RMAP_COLUMN_BIT(RMAP_SEGMENT_position) |
                                 RMAP_COLUMN_BIT(RMAP_RAY_optical_path) |
                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction);
    struct rmap_error err = {0};
    struct rmap_path_table *table = NULL;
    rig_decode(rig, own, portion, kept);
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        rig->decoded->ray.path_length[i] = -1.0;
        rig->decoded->ray.end_direction[3 * i] = 2.0f;
    }
    rig_ok(rmap_path_table_create(rig->model, &rig->whole, &table, &err), &err);
    rig_ok(rmap_compact_decode(rig->decoder, table, own, portion->n_row, more, kept, rig->decoded,
                               &err),
           &err);
    rmap_path_table_destroy(table);
    assert_columns_equal(portion, rig->decoded, more);
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++)
        assert_true(rig->decoded->ray.path_length[i] == -1.0 &&
                    rig->decoded->ray.end_direction[3 * i] == 2.0f);
}

/* Rays that are decoded alone are those of the portion: one in `stride`, from the last on. */
static inline void rig_select(struct rig *rig, const struct rmap_rows *own,
                              const struct rmap_portion *portion, size_t stride)
{
    struct rmap_error err = {0};
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    const rmap_column_set columns = RMAP_COLUMNS_ALL & ~RMAP_COLUMNS_CURVE;
    uint32_t *ray = rmap_alloc(n_ray + 1, sizeof *ray);
    size_t n = 0, segment = 0, registration = 0, n_row[RMAP_TABLE_COUNT];
    struct rmap_portion *some = NULL;
    struct rmap_path_table *table = NULL;
    struct rmap_compact_selection *selection = NULL;
    const struct rmap_rows *rows;
    rig_ok(rmap_portion_create(1, portion->n_channel, &some, &err), &err);
    for (size_t i = 0; i < n_ray; i++) {
        if ((n_ray - 1 - i) % stride == 0) {
            ray[n++] = (uint32_t)i;
            rig_ok(rmap_portion_append_ray(some, portion, i, segment, registration, &err), &err);
        }
        segment += portion->ray.segment_count[i];
        registration += portion->ray.registration_count[i];
    }
    rig_ok(rmap_path_table_create(rig->model, &rig->whole, &table, &err), &err);
    rig_ok(rmap_compact_selection_create(rig->model, &selection, &err), &err);
    rig_ok(rmap_compact_select(selection, table, own, portion->n_row, columns, ray, n, &rows, n_row,
                               &err),
           &err);
    rig_ok(rmap_compact_decode(rig->decoder, table, rows, n_row, columns, 0, rig->decoded, &err),
           &err);
    assert_memory_equal(rig->decoded->n_row, some->n_row, RMAP_TABLE_HISTORY_COUNT * sizeof *n_row);
    assert_columns_equal(some, rig->decoded, columns);
    rmap_compact_selection_destroy(selection);
    rmap_path_table_destroy(table);
    rmap_portion_destroy(some);
    rmap_free(ray);
}

/* Those streams alone. */
static inline struct rmap_rows rig_streams(const struct rmap_rows *rows, uint64_t streams)
{
    struct rmap_rows some = *rows;
    for (int s = 0; s < rmap_compact_layout.n_stream; s++)
        if (!(streams >> s & 1))
            some.data[s] = NULL;
    return some;
}

/* Rays with paths of their own, from no more streams than some columns of theirs take, beside heads
 * of paths where these are enough. */
static inline void rig_own(struct rig *rig, const struct rmap_rows *own,
                           const struct rmap_portion *portion)
{
    const rmap_column_set some[] = {
        RMAP_COLUMN_BIT(RMAP_RAY_source),
        RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count),
        RMAP_COLUMN_BIT(RMAP_SEGMENT_object),
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector),
        RMAP_COLUMNS_DISCRETE & ~RMAP_COLUMN_BIT(RMAP_SEGMENT_medium),
    };
    const uint32_t *path = own->data[RMAP_STREAM_ray_path];
    struct rmap_error err = {0};
    struct rmap_portion *want = NULL, *got = NULL;
    struct rmap_step_buffer steps = {0};
    rig_ok(rmap_portion_create(1, portion->n_channel, &want, &err), &err);
    rig_ok(rmap_portion_create(1, portion->n_channel, &got, &err), &err);
    for (size_t i = 0, segment = 0, registration = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        if (path[i] == 0)
            rig_ok(rmap_portion_append_ray(want, portion, i, segment, registration, &err), &err);
        segment += portion->ray.segment_count[i];
        registration += portion->ray.registration_count[i];
    }
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        struct rmap_path_table *table = NULL;
        struct rmap_compact_summary summary;
        uint64_t known = UINT64_MAX;
        for (int s = RMAP_STREAM_PATH_object; s <= RMAP_STREAM_PATH_registered; s++)
            known &= ~((uint64_t)!rmap_compact_needs_rows(some[i]) << s);
        const struct rmap_rows paths = rig_streams(&rig->whole, known);
        rig_ok(rmap_path_table_create(rig->model, &paths, &table, &err), &err);
        struct rmap_rows rows = rig_streams(own, rmap_compact_summary_streams(true));
        rig_ok(rmap_compact_summarise(rig->model, table, &rows, portion->n_row, &summary, &err),
               &err);
        assert_int_equal(summary.n_own, want->n_row[RMAP_TABLE_RAY]);
        assert_int_equal(summary.n_own_segment, want->n_row[RMAP_TABLE_SEGMENT]);
        rows = rig_streams(own, rmap_compact_own_streams(some[i], &summary));
        rig_ok(
            rmap_compact_decode_own(rig->model, table, &rows, &summary, some[i], &steps, got, &err),
            &err);
        assert_memory_equal(got->n_row, want->n_row, RMAP_TABLE_HISTORY_COUNT * sizeof *got->n_row);
        assert_columns_equal(want, got, some[i] | RMAP_COLUMN_BIT(RMAP_RAY_segment_count));
        rmap_path_table_destroy(table);
    }
    rmap_free(steps.class);
    rmap_portion_destroy(got);
    rmap_portion_destroy(want);
}

/* There and back: all columns, some sets of them, and some rays. */
static inline void rig_roundtrip(struct rig *rig, uint64_t seed, const struct rmap_portion *portion)
{
    const rmap_column_set some[] = {
        RMAP_COLUMNS_ALL,
        RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
            RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_stop),
        RMAP_COLUMN_BIT(RMAP_SEGMENT_position),
        RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) | RMAP_COLUMN_BIT(RMAP_RAY_id),
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path) | RMAP_COLUMN_BIT(RMAP_RAY_wavelength),
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) | RMAP_COLUMN_BIT(RMAP_RAY_id),
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) |
            RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) |
            RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay),
        RMAP_COLUMN_BIT(RMAP_SEGMENT_colour) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment),
        RMAP_COLUMN_BIT(RMAP_SEGMENT_normal) | RMAP_COLUMN_BIT(RMAP_RAY_path_length),
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative),
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) | RMAP_COLUMN_BIT(RMAP_RAY_weight),
        RMAP_COLUMNS_CURVE,
        RMAP_COLUMN_BIT(RMAP_CURVE_position) | RMAP_COLUMN_BIT(RMAP_RAY_id),
    };
    struct rmap_rows own;
    struct rmap_compact_summary header;
    struct rmap_error err = {0};
    rig_encode(rig, seed, portion, &own);
    rig_ok(rmap_compact_summarise_header(&own, &header, &err), &err);
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        const struct rmap_rows needed = rig_streams(&own, rmap_compact_streams(some[i], &header));
        rig_decode(rig, &needed, portion, some[i]);
        assert_columns_equal(portion, rig->decoded, some[i]);
    }
    rig_decode(rig, &own, portion, RMAP_COLUMNS_ALL);
    struct rmap_digest a = rmap_portion_digest(portion), b = rmap_portion_digest(rig->decoded);
    assert_true(a.low == b.low && a.high == b.high);
    rig_keep(rig, &own, portion);
    rig_own(rig, &own, portion);
    for (size_t stride = 1; stride <= 64 && portion->n_row[RMAP_TABLE_RAY] > 0; stride *= 8)
        rig_select(rig, &own, portion, stride);
    rows_free(&own);
}

/* Bytes that the codec leaves of n elements, in chunks as a shard has them. */
static inline double stored_nbytes(struct rmap_encoder *codec, const void *data, size_t n,
                                   size_t element_nbytes)
{
    struct rmap_error err = {0};
    double sum = 0.0;
    uint8_t *out = rmap_alloc(rmap_codec_bound(65536, 8), 1);
    for (size_t i = 0; i < n; i += 65536) {
        size_t nbytes, rows = n - i < 65536 ? n - i : 65536;
        rig_ok(rmap_encoder_encode(codec, (const char *)data + i * element_nbytes, rows, rows,
                                   element_nbytes, out, &nbytes, &err),
               &err);
        sum += (double)nbytes;
    }
    rmap_free(out);
    return sum;
}

static inline double plain_nbytes(struct rmap_encoder *codec, const struct rmap_portion *portion)
{
    double sum = 0.0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        enum rmap_column column = (enum rmap_column)c;
        if (!(rmap_columns_of_run(portion->timed) >> c & 1))
            continue;
        size_t element = rmap_element_nbytes(rmap_column_info(column)->element);
        size_t n = portion->n_row[rmap_column_info(column)->table] *
                   (rmap_portion_row_nbytes(portion, column) / element);
        sum += stored_nbytes(codec, rmap_portion_column(portion, column), n, element);
    }
    return sum;
}

static inline double compact_nbytes(struct rmap_encoder *codec, const struct rmap_rows *rows)
{
    double sum = 0.0;
    for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
        const struct rmap_stream_info *info = &rmap_compact_layout.stream[s];
        if (rows->data[s])
            sum +=
                stored_nbytes(codec, rows->data[s],
                              rows->n_row[info->table] * rmap_stream_width(info, rows->n_channel),
                              rmap_element_nbytes(info->element));
    }
    return sum;
}

#endif
