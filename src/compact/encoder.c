/* SPDX-License-Identifier: MIT
 *
 * A portion being encoded, for the files that do it.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "compact/angles.h"
#include "compact/arrivals.h"
#include "compact/detect.h"
#include "compact/encoder.h"
#include "compact/own_lengths.h"

/* What a part is encoded to without a look at where its segments go. */

/* Bits of primitives that are not what they are without meshes: 0 on an object, -1 on none. */
static uint32_t odd_primitives(const struct rmap_portion *part)
{
    uint32_t wrong = 0;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_SEGMENT]; i++)
        wrong |= (uint32_t)part->segment.primitive[i] ^
                 ((uint32_t)0 - ((uint32_t)part->segment.object[i] >> 31));
    return wrong;
}

/* The same of segments that do not end on meshes, and the triangles of those that do, without
 * branches: what a segment meets is anybody's guess. */
static uint32_t note_triangles(struct rmap_compact_encoder *encoder,
                               const struct rmap_portion *part)
{
    const struct rmap_compact_model *model = encoder->model;
    size_t n_listed = encoder->n_triangle;
    uint32_t wrong = 0;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t object = (uint32_t)part->segment.object[i];
        uint32_t primitive = (uint32_t)part->segment.primitive[i];
        bool mesh = model->body[object < model->n_object ? object : model->n_object].mesh;
        encoder->triangle[n_listed] = primitive;
        n_listed += mesh;
        wrong |= mesh ? 0 : primitive ^ ((uint32_t)0 - (object >> 31));
    }
    encoder->n_triangle = n_listed;
    return wrong;
}

/* Triangles of the segments that end on meshes, unless too many of the others have numbers that do
 * not follow: then the whole lane is kept as it is, where all of it is there. */
static void list_triangles(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                           bool all)
{
    struct rmap_lane *lane = &encoder->lane[RMAP_LANE_SEGMENT_primitive];
    const struct rmap_compact_model *model = encoder->model;
    size_t n = part->n_row[RMAP_TABLE_SEGMENT];
    uint32_t wrong = model->meshes ? note_triangles(encoder, part) : odd_primitives(part);
    if (wrong == 0)
        return;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive = part->segment.primitive[i];
        enum rmap_primitive_kind kind = rmap_primitive_kind(model, part->segment.object[i]);
        if (kind != RMAP_PRIMITIVE_LISTED)
            primitive = rmap_primitive_plain(kind);
        (void)rmap_lane_offer(lane, i, 1, sizeof primitive, &primitive);
    }
    if (!all || lane->n_patch * 64 <= n)
        return;
    lane->n_patch = lane->last = encoder->n_triangle = 0;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive =
            rmap_primitive_plain(rmap_primitive_kind(model, part->segment.object[i]));
        (void)rmap_lane_offer(lane, i, 1, sizeof primitive, &primitive);
    }
}

/* Channel of a wavelength; 0: none of the scene's. */
static uint8_t channel_of(const struct rmap_compact_model *model, double wavelength_nm)
{
    for (int i = 0; i < model->n_channel; i++)
        if (model->scene->channels.wavelength_nm[i] == wavelength_nm)
            return (uint8_t)(i + 1);
    return 0;
}

/* Lanes that need no segment. */
static void offer_simple(struct rmap_compact_encoder *encoder, const struct rmap_portion *part)
{
    struct rmap_lane *lane = encoder->lane;
    const struct rmap_ray_columns *ray = &part->ray;
    uint64_t id = encoder->first_ray + encoder->n_ray;
    uint8_t *channel = encoder->channel + encoder->n_ray;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_RAY]; i++) {
        double weight = 1.0;
        int32_t primitive = -1;
        channel[i] = isnan(ray->wavelength[i]) ? 0 : channel_of(encoder->model, ray->wavelength[i]);
        double wavelength = rmap_wavelength_of(encoder->model, channel[i]);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_id], i, 1, sizeof id, &id);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_weight], i, 1, sizeof weight, &weight);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_wavelength], i, 1, sizeof wavelength,
                              &wavelength);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_start_primitive], i, 1, sizeof primitive,
                              &primitive);
        id++;
    }
    (void)rmap_lane_offer(&lane[RMAP_LANE_SEGMENT_medium], 0, part->n_row[RMAP_TABLE_SEGMENT],
                          sizeof *encoder->medium, encoder->medium);
}

/* Cells, from the places recorded, which stand as they are; and about the angles. */
static void offer_registrations(struct rmap_compact_encoder *encoder,
                                const struct rmap_portion *part)
{
    const struct rmap_registration_columns *hit = &part->registration;
    uint16_t *angle = encoder->angle + encoder->n_registration;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        uint16_t cell[2];
        const size_t d = (size_t)hit->detector[i];
        angle[i] =
            d < encoder->model->n_detector
                ? rmap_angle_quarter(&encoder->model->scene->detector[d], hit->direction + 3 * i)
                : RMAP_ANGLE_NONE;
        rmap_detect_cell(encoder->model, hit->detector[i], hit->relative + 2 * i, cell);
        (void)rmap_lane_offer(&encoder->lane[RMAP_LANE_REGISTRATION_cell], 2 * i, 2, sizeof *cell,
                              cell);
    }
}

void rmap_encode_lanes(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                       bool all)
{
    list_triangles(encoder, part, all);
    offer_simple(encoder, part);
    offer_registrations(encoder, part);
}

/* Paths of rays on their way into a piece: spelled as words, looked up, entered. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "compact/encoder.h"

/* The words of ray i, whose rows begin at s and r, and the media of its segments. */
static uint32_t *spell(struct rmap_compact_encoder *encoder, const struct rmap_portion *portion,
                       size_t i, size_t s, size_t r, uint32_t *word)
{
    const struct rmap_compact_model *model = encoder->model;
    int16_t *expected_medium = encoder->medium + s;
    uint32_t *class = encoder->step + encoder->n_segment + s;
    const struct rmap_segment_columns *segment = &portion->segment;
    const struct rmap_registration_columns *registration = &portion->registration;
    uint32_t n = portion->ray.segment_count[i], m = portion->ray.registration_count[i];
    uint8_t stop = portion->ray.stop[i];
    word[RMAP_WORD_SOURCE] = (uint32_t)portion->ray.source[i];
    word[RMAP_WORD_STOP] = stop;
    word[RMAP_WORD_START_OBJECT] = (uint32_t)portion->ray.start_object[i] + 1;
    word[RMAP_WORD_SEGMENTS] = n;
    word[RMAP_WORD_REGISTRATIONS] = m;
    word += RMAP_WORD_HEAD;
    int32_t medium = rmap_first_medium(model, portion->ray.source[i]);
    const struct rmap_compact_body *nothing = &model->body[model->n_object], *from = nothing;
    uint32_t stored_from = 0;
    for (uint32_t k = 0; k < n; k++) {
        uint32_t object = (uint32_t)segment->object[s + k], event = segment->event[s + k];
        uint32_t stored = object + 1;
        word[k] = rmap_swap_expected(stored, from->inside == medium ? stored_from : 0);
        from = object < model->n_object ? &model->body[object] : nothing;
        stored_from = stored;
        word[n + k] = event ^ from->expected;
        expected_medium[k] = (int16_t)medium;
        const struct rmap_step_class step = {(int32_t)object, event, (int16_t)medium};
        class[k] = rmap_step_class_find(&encoder->steps, &step);
        if (class[k] == RMAP_NO_STEP_CLASS && encoder->status == RMAP_OK)
            encoder->status = rmap_step_class_enter(&encoder->steps, &step, &class[k], NULL);
        medium = rmap_medium_after(from, medium, event);
    }
    if (n > 0)
        word[2 * n - 1] = segment->event[s + n - 1] ^ rmap_event_at_end(stop);
    word += 2 * (size_t)n;
    for (uint32_t k = 0; k < m; k++) {
        word[k] = registration->segment[r + k];
        word[m + k] = (uint32_t)registration->detector[r + k];
        word[2 * m + k] = registration->registered[r + k];
    }
    return word + 3 * (size_t)m;
}

void rmap_encode_spell(struct rmap_compact_encoder *encoder, const struct rmap_portion *part)
{
    size_t s = 0, r = 0, n_before = encoder->n_ray;
    uint32_t *word = encoder->word + encoder->n_word;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_RAY]; i++) {
        uint32_t *end = spell(encoder, part, i, s, r, word);
        uint64_t hash = XXH3_64bits(word, (size_t)(end - word) * sizeof *word);
        encoder->hash[n_before + i] = hash ? hash : 1;
        encoder->begin[n_before + i] = (size_t)(word - encoder->word);
        encoder->length[n_before + i][0] = part->ray.path_length[i];
        encoder->length[n_before + i][1] = part->ray.optical_path[i];
        word = end;
        s += part->ray.segment_count[i];
        r += part->ray.registration_count[i];
    }
    encoder->n_word = (size_t)(word - encoder->word);
}

/* No rows, and room for those of all rays. */
static enum rmap_status empty(struct rmap_path_rows *rows,
                              const struct rmap_compact_encoder *encoder, struct rmap_error *err)
{
    rows->n = rows->n_segment = rows->n_registration = 0;
    return rmap_path_rows_reserve(rows, encoder->n_ray, encoder->n_segment, encoder->n_registration,
                                  err);
}

static void hand_out_paths(const struct rmap_path_rows *from, enum rmap_compact_table table,
                           int first_stream, struct rmap_rows *rows)
{
    void *const column[] = {from->source,
                            from->stop,
                            from->start_object,
                            from->segment_count,
                            from->registration_count,
                            from->object,
                            from->event,
                            from->segment,
                            from->detector,
                            from->registered};
    for (int i = 0; i < 10; i++)
        rows->data[first_stream + i] = column[i];
    rows->n_row[table] = from->n;
    rows->n_row[table + 1] = from->n_segment;
    rows->n_row[table + 2] = from->n_registration;
}

/* A path was entered: its classes are known from now on. class: of its n segments. */
static enum rmap_status add_classes(struct rmap_compact_encoder *encoder,
                                    struct rmap_path_book *book, const uint32_t *class, size_t n,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < n; k++)
        RMAP_TRY(rmap_step_class_enter(rmap_path_book_classes(book), &encoder->steps.of[class[k]],
                                       &encoder->class_of[class[k]], err));
out:
    return st;
}

/* Numbers of the piece for classes of n segments of an own path; false: it has not got all. */
static bool number_classes(struct rmap_compact_encoder *encoder, struct rmap_path_book *book,
                           const uint32_t *class, size_t n, uint32_t *number)
{
    bool all = true;
    for (size_t k = 0; k < n; k++) {
        uint32_t *known = &encoder->class_of[class[k]];
        if (*known == RMAP_NO_STEP_CLASS)
            *known =
                rmap_step_class_find(rmap_path_book_classes(book), &encoder->steps.of[class[k]]);
        number[k] = *known;
        all &= *known != RMAP_NO_STEP_CLASS;
    }
    return all;
}

/* Looks the path of ray i up, whose segments are of these classes; one with a step that no path of
 * the dictionary has is entered for it. *classed: becomes false where there is no room for that. */
static enum rmap_status resolve_ray(struct rmap_compact_encoder *encoder,
                                    struct rmap_path_book *book, size_t i, const uint32_t *class,
                                    bool *classed, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t *word = encoder->word + encoder->begin[i];
    const size_t n = word[RMAP_WORD_SEGMENTS];
    uint32_t *path = &encoder->path[i];
    bool added;
    RMAP_TRY(rmap_path_book_find(book, word, encoder->hash[i], path, &added, err));
    if (*path == 0 && *classed &&
        !number_classes(encoder, book, class, n, encoder->own_class + encoder->own.n_segment)) {
        RMAP_TRY(rmap_path_book_enter(book, word, encoder->hash[i], path, err));
        added = *path > 0;
        *classed = added;
    }
    if (added)
        RMAP_TRY(add_classes(encoder, book, class, n, err));
    if (*path == 0)
        rmap_path_rows_add(&encoder->own, word);
    else if (added)
        rmap_path_rows_add(&encoder->entered, word);
out:
    return st;
}

/* Room for classes by numbers of the piece, of which none is known yet. */
static enum rmap_status begin_classes(struct rmap_compact_encoder *encoder, struct rmap_error *err)
{
    enum rmap_status st = encoder->status;
    const size_t n = encoder->steps.n;
    if (st != RMAP_OK)
        return rmap_error_set(err, st, "out of memory for classes of steps");
    RMAP_TRY(RMAP_RESERVE(encoder->class_of, encoder->cap_class_of, n + 1, err));
    RMAP_TRY(RMAP_RESERVE(encoder->own_class, encoder->cap_own_class, encoder->n_segment + 1, err));
    memset(encoder->class_of, 0xff, n * sizeof *encoder->class_of);
out:
    return st;
}

/* Segments of own paths become their classes, in codes where these are shorter. */
static enum rmap_status store_classes(struct rmap_compact_encoder *encoder, size_t n_class,
                                      struct rmap_rows *rows, struct rmap_error *err)
{
    const size_t n = encoder->own.n_segment;
    size_t n_word = n, n_code = 0;
    const enum rmap_status st = rmap_step_codes_make(&encoder->coder, encoder->own_class, n,
                                                     n_class, &n_word, &n_code, err);
    if (st != RMAP_OK)
        return st;
    rows->data[RMAP_STREAM_OWN_object] = n_code > 0 ? encoder->coder.word : encoder->own_class;
    rows->n_row[RMAP_COMPACT_OWN_SEGMENT] = n_code > 0 ? n_word : n; /* no more than before */
    if (n > 0)
        memset(encoder->own.event, 0, n * sizeof *encoder->own.event);
    rmap_lane_header_set_classed(encoder->store.pool64, n_code);
    return RMAP_OK;
}

/* Behind the lanes, references of the rays that arrive, unless too many do, or nobody could use
 * them. */
static enum rmap_status store_arrivals(struct rmap_compact_encoder *encoder, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lane_store *store = &encoder->store;
    const size_t most = encoder->n_ray / RMAP_ARRIVALS_SHARE;
    struct rmap_lane_header header;
    size_t n = 0, n_used;
    RMAP_TRY(rmap_lane_header_read(store->pool64, store->n64, &header, &n_used, err));
    if (!rmap_arrivals_suffice(&header))
        goto out;
    RMAP_TRY(RMAP_RESERVE(store->pool16, store->cap16, store->n16 + most + 1, err));
    for (size_t i = 0; i < encoder->n_ray; i++) {
        const uint32_t path = encoder->path[i];
        if (!rmap_arrives(path, encoder->word[encoder->begin[i] + RMAP_WORD_REGISTRATIONS]))
            continue;
        if (n == most || n == UINT16_MAX || path > UINT16_MAX)
            goto out;
        store->pool16[store->n16 + n++] = (uint16_t)path;
    }
    store->n16 += n;
    rmap_lane_header_set_arrivals(store->pool64, (uint16_t)n);
out:
    return st;
}

/* Behind the lanes, lengths of the rays with paths of their own. */
static enum rmap_status store_lengths(struct rmap_compact_encoder *encoder, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lane_store *store = &encoder->store;
    const size_t n_own = encoder->own.n, n_row = rmap_own_length_rows(n_own);
    size_t n = 0;
    RMAP_TRY(RMAP_RESERVE(encoder->own_length, encoder->cap_own_length, n_own + 1, err));
    RMAP_TRY(RMAP_RESERVE(store->pool16, store->cap16, store->n16 + n_row, err));
    for (size_t i = 0; i < encoder->n_ray; i++)
        if (encoder->path[i] == 0)
            encoder->own_length[n++] = encoder->length[i][0];
    if (!rmap_own_lengths_make(encoder->own_length, n, store->pool16 + store->n16))
        goto out;
    store->n16 += n_row;
    rmap_lane_header_set_measured(store->pool64);
out:
    return st;
}

enum rmap_status rmap_compact_resolve(struct rmap_compact_encoder *encoder,
                                      struct rmap_path_book *book, struct rmap_rows *rows,
                                      struct rmap_error *err)
{
    const size_t ahead = 8;
    enum rmap_status st = RMAP_OK;
    const uint32_t *class = encoder->step;
    bool classed = true;
    RMAP_TRY(empty(&encoder->own, encoder, err));
    RMAP_TRY(empty(&encoder->entered, encoder, err));
    RMAP_TRY(begin_classes(encoder, err));
    for (size_t i = 0; i < encoder->n_ray; i++) {
        if (i + ahead < encoder->n_ray)
            rmap_path_book_expect(book, encoder->hash[i + ahead]);
        RMAP_TRY(resolve_ray(encoder, book, i, class, &classed, err));
        class += encoder->word[encoder->begin[i] + RMAP_WORD_SEGMENTS];
    }
    *rows =
        (struct rmap_rows){.layout = &rmap_compact_layout, .n_channel = encoder->model->n_channel};
    hand_out_paths(&encoder->own, RMAP_COMPACT_OWN, RMAP_STREAM_OWN_source, rows);
    if (classed)
        RMAP_TRY(store_classes(encoder, rmap_path_book_classes(book)->n, rows, err));
    RMAP_TRY(store_arrivals(encoder, err));
    RMAP_TRY(store_lengths(encoder, err));
    hand_out_paths(&encoder->entered, RMAP_COMPACT_PATH, RMAP_STREAM_PATH_source, rows);
    rows->n_row[RMAP_COMPACT_RAY] = encoder->n_ray;
    rows->data[RMAP_STREAM_ray_path] = encoder->path;
    rows->data[RMAP_STREAM_ray_channel] = encoder->channel;
    rows->n_row[RMAP_COMPACT_TRIANGLE] = encoder->n_triangle;
    rows->data[RMAP_STREAM_triangle] = encoder->triangle;
    rows->n_row[RMAP_COMPACT_PATCH] = encoder->store.n_patch;
    rows->data[RMAP_STREAM_patch_skip] = encoder->store.skip;
    rows->data[RMAP_STREAM_patch_value] = encoder->store.value;
    rows->n_row[RMAP_COMPACT_POOL16] = encoder->store.n16;
    rows->data[RMAP_STREAM_pool16] = encoder->store.pool16;
    rows->n_row[RMAP_COMPACT_POOL32] = encoder->store.n32;
    rows->data[RMAP_STREAM_pool32] = encoder->store.pool32;
    rows->n_row[RMAP_COMPACT_POOL64] = encoder->store.n64;
    rows->data[RMAP_STREAM_pool64] = encoder->store.pool64;
    rows->n_row[RMAP_COMPACT_CURVE] = encoder->n_curve;
    rows->data[RMAP_STREAM_curve_ray] = encoder->curve.ray;
    rows->data[RMAP_STREAM_curve_segment] = encoder->curve.segment;
    rows->data[RMAP_STREAM_curve_position] = encoder->curve.position;
    struct rmap_compact_summary summary;
    RMAP_TRY(rmap_compact_summarise_header(rows, &summary, err));
    rmap_path_book_add(book, encoder->path, (const double(*)[2])encoder->length, encoder->n_ray,
                       summary.weigh_one && summary.ids_run && summary.media_known);
out:
    return st;
}
