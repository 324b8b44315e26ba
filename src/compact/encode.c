/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "compact/few.h"
#include "compact/paths.h"
#include "compact/settle.h"

struct rmap_compact_encoder {
    const struct rmap_compact_model *model;
    struct rmap_lane lane[RMAP_LANE_COUNT];
    struct rmap_lane_store store;
    size_t n_ray;

    /* [n_ray] */
    size_t cap_path, cap_channel, cap_hash, cap_begin;
    uint32_t *path;
    uint8_t *channel;
    uint64_t *hash;
    size_t *begin; /* of the path's words */

    uint32_t *word;
    size_t cap_word;
    uint32_t *triangle;
    size_t n_triangle, cap_triangle;
    int16_t *medium; /* expected, [legs] */
    size_t cap_medium;
    struct rmap_path_rows own, entered;
    struct rmap_curve_columns curve; /* as they are */
    size_t n_curve, cap_ray, cap_segment, cap_position;
    struct rmap_wave wave;
    struct rmap_portion *predicted;
    struct rmap_few *few;
};

enum rmap_status rmap_compact_encoder_create(const struct rmap_compact_model *model,
                                             struct rmap_compact_encoder **encoder_ret,
                                             struct rmap_error *err)
{
    struct rmap_compact_encoder *encoder = rmap_alloc(1, sizeof *encoder);
    if (!encoder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
    encoder->model = model;
    rmap_lanes_init(encoder->lane);
    enum rmap_status st = rmap_portion_create(1, model->n_channel, &encoder->predicted, err);
    encoder->few = rmap_alloc(1, sizeof *encoder->few);
    if (st == RMAP_OK && !encoder->few)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
    if (st == RMAP_OK)
        *encoder_ret = encoder;
    else
        rmap_compact_encoder_destroy(encoder);
    return st;
}

void rmap_compact_encoder_destroy(struct rmap_compact_encoder *encoder)
{
    if (!encoder)
        return;
    rmap_lanes_fini(encoder->lane);
    rmap_lane_store_fini(&encoder->store);
    rmap_wave_fini(&encoder->wave);
    rmap_portion_destroy(encoder->predicted);
    rmap_few_destroy(encoder->few);
    rmap_path_rows_fini(&encoder->own);
    rmap_path_rows_fini(&encoder->entered);
    rmap_free(encoder->path);
    rmap_free(encoder->channel);
    rmap_free(encoder->hash);
    rmap_free(encoder->begin);
    rmap_free(encoder->word);
    rmap_free(encoder->triangle);
    rmap_free(encoder->medium);
    rmap_free(encoder->curve.ray);
    rmap_free(encoder->curve.segment);
    rmap_free(encoder->curve.position);
    rmap_free(encoder);
}

static enum rmap_status check(const struct rmap_compact_encoder *encoder,
                              const struct rmap_portion *portion, struct rmap_error *err)
{
    size_t n_segment = 0, n_registration = 0;
    if (portion->n_channel != encoder->model->n_channel)
        return rmap_error_set(err, RMAP_INTERNAL, "a portion of %d channels in a scene of %d",
                              portion->n_channel, encoder->model->n_channel);
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        n_segment += portion->ray.segment_count[i];
        n_registration += portion->ray.registration_count[i];
    }
    if (n_segment != portion->n_row[RMAP_TABLE_SEGMENT] ||
        n_registration != portion->n_row[RMAP_TABLE_REGISTRATION])
        return rmap_error_set(err, RMAP_INTERNAL,
                              "the rays of a portion have other rows than it holds");
    return RMAP_OK;
}

static enum rmap_status make_room(struct rmap_compact_encoder *encoder,
                                  const struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = portion->n_row[RMAP_TABLE_RAY], s = portion->n_row[RMAP_TABLE_SEGMENT];
    size_t words = RMAP_WORD_HEAD * n + 2 * s + 3 * portion->n_row[RMAP_TABLE_REGISTRATION];
#define ROOM(field, n)                                                                             \
    RMAP_TRY(rmap_reserve((void **)&encoder->field, &encoder->cap_##field, n,                      \
                          sizeof *encoder->field, err))
    ROOM(path, n);
    ROOM(channel, n);
    ROOM(hash, n);
    ROOM(begin, n);
    ROOM(word, words);
    ROOM(triangle, s);
    ROOM(medium, s);
#undef ROOM
out:
    return st;
}

/* Points of curved legs follow from nothing but the media's fields, which a reader need not have.
 */
static enum rmap_status copy_curve(struct rmap_compact_encoder *encoder,
                                   const struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = encoder->n_curve = portion->n_row[RMAP_TABLE_CURVE];
    if (n == 0)
        return RMAP_OK;
#define COPY(field, path, type, element, width, unit, text)                                        \
    RMAP_TRY(rmap_reserve((void **)&encoder->curve.field, &encoder->cap_##field, n *(width),       \
                          sizeof(type), err));                                                     \
    memcpy(encoder->curve.field, portion->curve.field, n *(width) * sizeof(type));
    RMAP_CURVE_COLUMNS(COPY)
#undef COPY
out:
    return st;
}

/* The words of ray i, whose rows begin at s and r, and the media of its legs. */
static uint32_t *spell(const struct rmap_compact_model *model, const struct rmap_portion *portion,
                       size_t i, size_t s, size_t r, uint32_t *word, int16_t *expected_medium)
{
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

static void spell_all(struct rmap_compact_encoder *encoder, const struct rmap_portion *portion)
{
    size_t s = 0, r = 0;
    uint32_t *word = encoder->word;
    for (size_t i = 0; i < encoder->n_ray; i++) {
        uint32_t *end = spell(encoder->model, portion, i, s, r, word, encoder->medium + s);
        uint64_t hash = XXH3_64bits(word, (size_t)(end - word) * sizeof *word);
        encoder->hash[i] = hash ? hash : 1;
        encoder->begin[i] = (size_t)(word - encoder->word);
        word = end;
        s += portion->ray.segment_count[i];
        r += portion->ray.registration_count[i];
    }
}

/* Bits of primitives that are not what they are without meshes: 0 on an object, -1 on none. */
static uint32_t odd_primitives(const struct rmap_portion *portion)
{
    uint32_t wrong = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++)
        wrong |= (uint32_t)portion->segment.primitive[i] ^
                 ((uint32_t)0 - ((uint32_t)portion->segment.object[i] >> 31));
    return wrong;
}

/* The same of legs that do not end on meshes, and the triangles of those that do, without branches:
 * what a leg meets is anybody's guess. */
static uint32_t note_triangles(struct rmap_compact_encoder *encoder,
                               const struct rmap_portion *portion)
{
    const struct rmap_compact_model *model = encoder->model;
    size_t n_listed = 0;
    uint32_t wrong = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t object = (uint32_t)portion->segment.object[i];
        uint32_t primitive = (uint32_t)portion->segment.primitive[i];
        bool mesh = model->body[object < model->n_object ? object : model->n_object].mesh;
        encoder->triangle[n_listed] = primitive;
        n_listed += mesh;
        wrong |= mesh ? 0 : primitive ^ ((uint32_t)0 - (object >> 31));
    }
    encoder->n_triangle = n_listed;
    return wrong;
}

/* Triangles of the legs that end on meshes, unless too many of the others have numbers that do not
 * follow: then the whole lane is kept as it is. */
static void list_triangles(struct rmap_compact_encoder *encoder, const struct rmap_portion *portion)
{
    struct rmap_lane *lane = &encoder->lane[RMAP_LANE_SEGMENT_primitive];
    const struct rmap_compact_model *model = encoder->model;
    size_t n = portion->n_row[RMAP_TABLE_SEGMENT];
    encoder->n_triangle = 0;
    uint32_t wrong = model->meshes ? note_triangles(encoder, portion) : odd_primitives(portion);
    if (wrong == 0)
        return;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive = portion->segment.primitive[i];
        enum rmap_primitive_kind kind = rmap_primitive_kind(model, portion->segment.object[i]);
        if (kind != RMAP_PRIMITIVE_LISTED)
            primitive = rmap_primitive_plain(kind);
        (void)rmap_lane_offer(lane, i, 1, sizeof primitive, &primitive);
    }
    if (lane->n_patch * 64 <= n)
        return;
    lane->n_patch = lane->last = encoder->n_triangle = 0;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive =
            rmap_primitive_plain(rmap_primitive_kind(model, portion->segment.object[i]));
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

/* Lanes that need no leg. */
static void offer_simple(struct rmap_compact_encoder *encoder, const struct rmap_portion *portion)
{
    struct rmap_lane *lane = encoder->lane;
    const struct rmap_ray_columns *ray = &portion->ray;
    uint64_t id = portion->first_ray;
    for (size_t i = 0; i < encoder->n_ray; i++) {
        double weight = 1.0;
        int32_t primitive = -1;
        encoder->channel[i] =
            isnan(ray->wavelength[i]) ? 0 : channel_of(encoder->model, ray->wavelength[i]);
        double wavelength = rmap_wavelength_of(encoder->model, encoder->channel[i]);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_id], i, 1, sizeof id, &id);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_weight], i, 1, sizeof weight, &weight);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_wavelength], i, 1, sizeof wavelength,
                              &wavelength);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_start_primitive], i, 1, sizeof primitive,
                              &primitive);
        id++;
    }
    (void)rmap_lane_offer(&lane[RMAP_LANE_SEGMENT_medium], 0, portion->n_row[RMAP_TABLE_SEGMENT],
                          sizeof *encoder->medium, encoder->medium);
}

/* What was recorded against what is predicted: of all rays, or of those that need it. */
static enum rmap_status retrace(struct rmap_compact_encoder *encoder, uint64_t seed,
                                const struct rmap_portion *portion, bool *one_by_one_ret,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *predicted = encoder->predicted;
    const struct rmap_retrace r =
        rmap_retrace_of(encoder->model, seed, portion, encoder->channel, encoder->lane);
    const struct rmap_portion *rows = portion;
    bool few = rmap_few_choose(encoder->few, encoder->model, seed, portion);
    if (few) {
        RMAP_TRY(rmap_few_gather(encoder->few, portion, encoder->channel, err));
        rows = encoder->few->rows;
    }
    rmap_portion_clear(predicted);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(predicted, (enum rmap_table)t, rows->n_row[t],
                                      RMAP_COLUMNS_ALL, err));
    memcpy(predicted->n_row, rows->n_row, sizeof predicted->n_row);
    if (few) {
        const struct rmap_retrace of_few =
            rmap_retrace_of(encoder->model, seed, rows, encoder->few->channel, encoder->lane);
        RMAP_TRY(rmap_settle_encode_few(&encoder->wave, &r, &of_few, encoder->few, predicted,
                                        one_by_one_ret, err));
    } else {
        RMAP_TRY(rmap_settle_encode(&encoder->wave, &r, predicted, one_by_one_ret, err));
    }
out:
    return st;
}

enum rmap_status rmap_compact_encode(struct rmap_compact_encoder *encoder, uint64_t seed,
                                     const struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool one_by_one = false;
    encoder->n_ray = 0;
    RMAP_TRY(check(encoder, portion, err));
    RMAP_TRY(make_room(encoder, portion, err));
    RMAP_TRY(copy_curve(encoder, portion, err));
    encoder->n_ray = portion->n_row[RMAP_TABLE_RAY];
    rmap_lanes_begin(encoder->lane, portion);
    spell_all(encoder, portion);
    list_triangles(encoder, portion);
    offer_simple(encoder, portion);
    RMAP_TRY(retrace(encoder, seed, portion, &one_by_one, err));
    const uint64_t start[RMAP_HEADER_COUNT] = {[RMAP_HEADER_MODES] =
                                                   one_by_one ? RMAP_HEADER_ONE_BY_ONE : 0,
                                               [RMAP_HEADER_SEED] = seed,
                                               [RMAP_HEADER_FIRST] = portion->first_ray};
    RMAP_TRY(rmap_lanes_store(encoder->lane, start, &encoder->store, err));
out:
    return st;
}

static enum rmap_status add_path(struct rmap_path_rows *rows, const uint32_t *word,
                                 struct rmap_error *err)
{
    enum rmap_status st = rmap_path_rows_reserve(rows, 1, word[RMAP_WORD_SEGMENTS],
                                                 word[RMAP_WORD_REGISTRATIONS], err);
    if (st == RMAP_OK)
        rmap_path_rows_add(rows, word);
    return st;
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

enum rmap_status rmap_compact_resolve(struct rmap_compact_encoder *encoder,
                                      struct rmap_path_book *book, struct rmap_rows *rows,
                                      struct rmap_error *err)
{
    const size_t ahead = 8;
    enum rmap_status st = RMAP_OK;
    encoder->own.n = encoder->own.n_segment = encoder->own.n_registration = 0;
    encoder->entered.n = encoder->entered.n_segment = encoder->entered.n_registration = 0;
    for (size_t i = 0; i < encoder->n_ray; i++) {
        const uint32_t *word = encoder->word + encoder->begin[i];
        bool added;
        if (i + ahead < encoder->n_ray)
            rmap_path_book_expect(book, encoder->hash[i + ahead]);
        RMAP_TRY(rmap_path_book_find(book, word, encoder->hash[i], &encoder->path[i], &added, err));
        if (encoder->path[i] == 0)
            RMAP_TRY(add_path(&encoder->own, word, err));
        else if (added)
            RMAP_TRY(add_path(&encoder->entered, word, err));
    }
    *rows =
        (struct rmap_rows){.layout = &rmap_compact_layout, .n_channel = encoder->model->n_channel};
    hand_out_paths(&encoder->own, RMAP_COMPACT_OWN, RMAP_STREAM_OWN_source, rows);
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
out:
    return st;
}
