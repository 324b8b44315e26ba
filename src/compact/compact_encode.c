/* SPDX-License-Identifier: MIT
 *
 * The compact encoding: portions into rows of compact streams.
 */
#include "compact/compact.h"

#include <string.h>

#include "base/alloc.h"
#include "compact/encoder.h"

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
    if (st == RMAP_OK)
        st = rmap_portion_set_timed(encoder->predicted, model->scene->timed, err);
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
    rmap_batch_fini(&encoder->batch);
    rmap_portion_destroy(encoder->predicted);
    rmap_few_destroy(encoder->few);
    rmap_path_rows_fini(&encoder->own);
    rmap_path_rows_fini(&encoder->entered);
    rmap_free(encoder->path);
    rmap_free(encoder->channel);
    rmap_free(encoder->hash);
    rmap_free(encoder->length);
    rmap_free(encoder->begin);
    rmap_free(encoder->word);
    rmap_step_classes_fini(&encoder->steps);
    rmap_free(encoder->step);
    rmap_free(encoder->class_of);
    rmap_free(encoder->own_class);
    rmap_free(encoder->own_length);
    rmap_free(encoder->angle);
    rmap_step_coder_fini(&encoder->coder);
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
                                  const struct rmap_portion *part, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = part->n_row[RMAP_TABLE_RAY], s = part->n_row[RMAP_TABLE_SEGMENT];
    size_t words = RMAP_WORD_HEAD * n + 2 * s + 3 * part->n_row[RMAP_TABLE_REGISTRATION];
#define ROOM(field, n) RMAP_TRY(RMAP_RESERVE(encoder->field, encoder->cap_##field, n, err))
    ROOM(path, encoder->n_ray + n);
    ROOM(channel, encoder->n_ray + n);
    ROOM(hash, encoder->n_ray + n);
    ROOM(begin, encoder->n_ray + n);
    ROOM(length, encoder->n_ray + n);
    ROOM(word, encoder->n_word + words);
    ROOM(step, encoder->n_segment + s);
    ROOM(triangle, encoder->n_triangle + s);
    ROOM(angle, encoder->n_registration + part->n_row[RMAP_TABLE_REGISTRATION] + 1);
    ROOM(medium, s);
#undef ROOM
out:
    return st;
}

/* Points of curved segments follow from nothing but the media's fields, which a reader need not
 * have.
 */
static enum rmap_status copy_curve(struct rmap_compact_encoder *encoder,
                                   const struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = encoder->n_curve = portion->n_row[RMAP_TABLE_CURVE];
    if (n == 0)
        return RMAP_OK;
#define COPY(field, path, type, element, width, unit, text)                                        \
    RMAP_TRY(RMAP_RESERVE(encoder->curve.field, encoder->cap_##field, n *(width), err));           \
    memcpy(encoder->curve.field, portion->curve.field, n *(width) * sizeof(type));
    RMAP_CURVE_COLUMNS(COPY)
#undef COPY
out:
    return st;
}

static struct rmap_lane_header header_of(const struct rmap_compact_encoder *encoder)
{
    return (struct rmap_lane_header){.seed = encoder->seed,
                                     .first_ray = encoder->first_ray,
                                     .placed = true,
                                     .n_lane = rmap_lane_count(encoder->model->scene->timed),
                                     .predicted = encoder->model->predicted};
}

/* What was recorded against what is predicted: of all rays, or of those that need it.
 * *one_by_one_ret: the reader must follow every ray of the portion by itself. */
static enum rmap_status retrace(struct rmap_compact_encoder *encoder,
                                const struct rmap_portion *part, bool few, bool *one_by_one_ret,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *predicted = encoder->predicted;
    const uint8_t *channel = encoder->channel + encoder->n_ray;
    const struct rmap_lane_header header = header_of(encoder);
    const struct rmap_retrace r =
        rmap_retrace_of(encoder->model, &header, part, channel, encoder->lane);
    const struct rmap_portion *rows = part;
    if (few) {
        RMAP_TRY(rmap_few_gather(encoder->few, part, channel, err));
        rows = encoder->few->rows;
    }
    rmap_portion_clear(predicted);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(predicted, (enum rmap_table)t, rows->n_row[t],
                                      RMAP_COLUMNS_ALL, err));
    memcpy(predicted->n_row, rows->n_row, sizeof predicted->n_row);
    if (few) {
        const struct rmap_retrace of_few =
            rmap_retrace_of(encoder->model, &header, rows, encoder->few->channel, encoder->lane);
        RMAP_TRY(rmap_settle_encode_few(&encoder->batch, &r, &of_few, encoder->few, predicted,
                                        one_by_one_ret, err));
    } else {
        RMAP_TRY(rmap_settle_encode(&encoder->batch, &r, predicted, one_by_one_ret, err));
    }
out:
    return st;
}

static enum rmap_status store(struct rmap_compact_encoder *encoder, bool one_by_one,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lane_header header = header_of(encoder);
    struct rmap_lane_store *its = &encoder->store;
    const size_t n = encoder->n_registration;
    header.one_by_one = one_by_one;
    RMAP_TRY(rmap_lanes_store(encoder->lane, &header, its, err));
    const size_t n16 = its->n16 + rmap_angle_part_rows(n);
    const size_t n32 = its->n32 + rmap_angle_degree_rows(n);
    RMAP_TRY(RMAP_RESERVE(its->pool16, its->cap16, n16 + 1, err));
    RMAP_TRY(RMAP_RESERVE(its->pool32, its->cap32, n32 + 1, err));
    rmap_angles_pack(encoder->angle, n, its->pool32 + its->n32, its->pool16 + its->n16);
    its->n16 = n16;
    its->n32 = n32;
    rmap_lane_header_set_angled(its->pool64);
out:
    return st;
}

/* all: the part is the portion. *one_by_one_ret as in retrace; *whole_ret, where not all: its rays
 * need the others of the portion. */
static enum rmap_status take(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                             bool all, bool *one_by_one_ret, bool *whole_ret,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check(encoder, part, err));
    bool few = rmap_few_choose(encoder->few, encoder->model, encoder->seed, part);
    *whole_ret = !few || part->n_row[RMAP_TABLE_CURVE] > 0;
    if (*whole_ret && !all)
        return RMAP_OK;
    RMAP_TRY(make_room(encoder, part, err));
    rmap_lanes_continue(encoder->lane, part);
    rmap_encode_spell(encoder, part);
    rmap_encode_lanes(encoder, part, all);
    if (!few || encoder->few->n > 0)
        RMAP_TRY(retrace(encoder, part, few, one_by_one_ret, err));
    encoder->n_ray += part->n_row[RMAP_TABLE_RAY];
    encoder->n_segment += part->n_row[RMAP_TABLE_SEGMENT];
    encoder->n_registration += part->n_row[RMAP_TABLE_REGISTRATION];
out:
    return st;
}

bool rmap_compact_in_parts(const struct rmap_compact_model *model)
{
    /* Curves are kept whole, and who gave parts up would trace their rays twice: seconds each. */
    return model->predicts && !rmap_scene_is_curved(model->scene);
}

void rmap_compact_encode_begin(struct rmap_compact_encoder *encoder, uint64_t seed,
                               uint64_t first_ray)
{
    encoder->seed = seed;
    encoder->first_ray = first_ray;
    encoder->n_ray = encoder->n_segment = encoder->n_registration = 0;
    encoder->n_word = encoder->n_triangle = encoder->n_curve = 0;
    encoder->status = RMAP_OK;
    rmap_lanes_begin(encoder->lane);
}

enum rmap_status rmap_compact_encode_part(struct rmap_compact_encoder *encoder,
                                          const struct rmap_portion *part, bool *whole_ret,
                                          struct rmap_error *err)
{
    bool one_by_one = false, whole = false;
    enum rmap_status st = take(encoder, part, false, &one_by_one, &whole, err);
    *whole_ret = one_by_one || whole;
    return st;
}

enum rmap_status rmap_compact_encode_end(struct rmap_compact_encoder *encoder, bool *whole_ret,
                                         struct rmap_error *err)
{
    *whole_ret = !rmap_lanes_sparse(encoder->lane);
    return *whole_ret ? RMAP_OK : store(encoder, false, err);
}

enum rmap_status rmap_compact_encode(struct rmap_compact_encoder *encoder, uint64_t seed,
                                     const struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool one_by_one = false, whole;
    rmap_compact_encode_begin(encoder, seed, portion->first_ray);
    RMAP_TRY(copy_curve(encoder, portion, err));
    RMAP_TRY(take(encoder, portion, true, &one_by_one, &whole, err));
    RMAP_TRY(store(encoder, one_by_one, err));
out:
    return st;
}
