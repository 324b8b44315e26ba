/* SPDX-License-Identifier: MIT
 *
 * Sums made from a portion's columns are those made while tracing; nothing in a portion is
 * believed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "accel/accel.h"
#include "io/scene/scene_reader.h"
#include "portion/portion_recorder.h"
#include "trace/tally.h"
#include "trace/tracer.h"

enum { BLOCKS = 3 };

struct traced {
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_accel *accel;
    struct rmap_tally *tally;
    struct rmap_portion *portion[BLOCKS];
};

static void trace_example(struct traced *traced, const char *path)
{
    struct rmap_error err = {0};
    struct rmap_diagnostics diagnostics;
    struct rmap_scene_options options = {0};
    memset(traced, 0, sizeof *traced);
    rmap_diagnostics_init(&diagnostics, path);
    if (rmap_bundle_open(path, &options, &traced->bundle, &err) != RMAP_OK ||
        rmap_scene_read(traced->bundle, &traced->scene, &diagnostics, &err) != RMAP_OK ||
        rmap_accel_create(traced->scene, 1, &traced->accel, &err) != RMAP_OK ||
        rmap_tally_create(traced->scene, &traced->tally, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    rmap_diagnostics_fini(&diagnostics);
    struct rmap_tracer tracer = {traced->scene, traced->accel, 7};
    for (uint64_t block = 0; block < BLOCKS; block++) {
        struct rmap_portion_recorder recorder;
        struct rmap_tally_recorder summing;
        struct rmap_portion **portion = &traced->portion[block];
        assert_int_equal(
            rmap_portion_create(RMAP_BLOCK_RAYS, traced->scene->channels.n, portion, &err),
            RMAP_OK);
        rmap_portion_recorder_init(&recorder, *portion);
        rmap_tally_recorder_init(&summing, traced->tally, &recorder.base);
        for (uint64_t ray = 0; ray < RMAP_BLOCK_RAYS; ray++)
            rmap_trace_ray(&tracer, block * RMAP_BLOCK_RAYS + ray, &summing.base);
        assert_int_equal(recorder.status, RMAP_OK);
    }
}

static void release(struct traced *traced)
{
    for (int block = 0; block < BLOCKS; block++)
        rmap_portion_destroy(traced->portion[block]);
    rmap_tally_destroy(traced->tally);
    rmap_accel_destroy(traced->accel);
    rmap_scene_destroy(traced->scene);
    rmap_bundle_destroy(traced->bundle);
}

/* Leaves a view of the portion that has the columns of a set and no others. */
static struct rmap_portion restrict_to(const struct rmap_portion *portion, rmap_column_set columns)
{
    struct rmap_portion view = *portion;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (!(columns & RMAP_COLUMN_BIT(c)))
            *rmap_portion_column_address(&view, (enum rmap_column)c) = NULL;
    return view;
}

static void check_example(const char *path)
{
    struct traced traced;
    struct rmap_tally *sum = NULL;
    struct rmap_error err = {0};
    trace_example(&traced, path);
    assert_int_equal(rmap_tally_create(traced.scene, &sum, &err), RMAP_OK);
    for (int block = BLOCKS - 1; block >= 0; block--) {
        struct rmap_portion view = restrict_to(traced.portion[block], RMAP_TALLY_COLUMNS);
        assert_int_equal(rmap_tally_add_portion(sum, &view, &err), RMAP_OK);
    }
    assert_int_equal(sum->n_value, traced.tally->n_value);
    assert_memory_equal(sum->value, traced.tally->value, sum->n_value * sizeof *sum->value);
    assert_true(sum->first_error_ray == traced.tally->first_error_ray);
    assert_true(sum->segments[0] > BLOCKS * RMAP_BLOCK_RAYS);
    rmap_tally_destroy(sum);
    release(&traced);
}

static void examples_sum_up(void **state)
{
    (void)state;
    check_example(RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    check_example(RAYMAP_SOURCE_DIR "/examples/room/scene.yaml");
}

static void must_refuse(struct rmap_tally *tally, const struct rmap_portion *portion,
                        const char *words)
{
    struct rmap_error err = {0};
    assert_int_equal(rmap_tally_add_portion(tally, portion, &err), RMAP_FORMAT);
    if (!strstr(err.text, words))
        fail_msg("'%s' is not said: %s", words, err.text);
    for (size_t i = 0; i < tally->n_value; i++)
        assert_true(tally->value[i] == 0.0);
}

/* One wrong value at a time, put right again afterwards. */
#define WRONG(field, bad, words)                                                                   \
    do {                                                                                           \
        __typeof__(field) *place = &(field), kept = *place;                                        \
        *place = (bad);                                                                            \
        must_refuse(sum, portion, words);                                                          \
        *place = kept;                                                                             \
    } while (0)

static void nothing_is_believed(void **state)
{
    (void)state;
    struct traced traced;
    struct rmap_tally *sum = NULL;
    struct rmap_error err = {0};
    trace_example(&traced, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    assert_int_equal(rmap_tally_create(traced.scene, &sum, &err), RMAP_OK);
    struct rmap_portion *portion = traced.portion[1];
    size_t last = portion->n_row[RMAP_TABLE_RAY] - 1, hit = 0;
    size_t segment = portion->n_row[RMAP_TABLE_SEGMENT] - 1;
    while (!portion->registration.registered[hit])
        hit++;
    WRONG(portion->ray.source[last], (int32_t)traced.scene->n_source, "source");
    WRONG(portion->ray.source[0], -1, "source");
    WRONG(portion->ray.stop[last], RMAP_STOP_COUNT, "ended");
    WRONG(portion->segment.object[segment], (int32_t)traced.scene->n_object, "object");
    WRONG(portion->segment.object[segment], -2, "object");
    WRONG(portion->segment.medium[segment], -1, "medium");
    WRONG(portion->registration.detector[hit], (int32_t)traced.scene->n_detector, "detector");
    WRONG(portion->registration.cell[2 * hit], 65535, "cell");
    WRONG(portion->registration.cell[2 * hit + 1], 65535, "cell");
    WRONG(portion->ray.segment_count[last], UINT32_MAX, "more segments");
    WRONG(portion->ray.segment_count[0], 0, "");
    WRONG(portion->ray.registration_count[last], UINT32_MAX, "more segments");
    WRONG(portion->n_row[RMAP_TABLE_SEGMENT], segment + 2, "no ray");
    assert_int_equal(rmap_tally_add_portion(sum, portion, &err), RMAP_OK);
    rmap_tally_destroy(sum);
    release(&traced);
}

/* Rays that ended with an error: counted, and the least id kept. */
static void errors_are_named(void **state)
{
    (void)state;
    struct traced traced;
    struct rmap_tally *sum = NULL;
    struct rmap_error err = {0};
    trace_example(&traced, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    assert_int_equal(rmap_tally_create(traced.scene, &sum, &err), RMAP_OK);
    traced.portion[1]->ray.stop[17] = RMAP_STOP_ERROR;
    traced.portion[0]->ray.stop[4000] = RMAP_STOP_ERROR;
    for (int block = BLOCKS - 1; block >= 0; block--)
        assert_int_equal(rmap_tally_add_portion(sum, traced.portion[block], &err), RMAP_OK);
    double errors = 0.0;
    for (size_t s = 0; s < traced.scene->n_source; s++)
        errors += sum->error[s];
    assert_true(errors == 2.0);
    assert_true(sum->first_error_ray == 4000);
    rmap_tally_destroy(sum);
    release(&traced);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(examples_sum_up),
        cmocka_unit_test(nothing_is_believed),
        cmocka_unit_test(errors_are_named),
    };
    return cmocka_run_group_tests_name("tally_portion", test, NULL, NULL);
}
