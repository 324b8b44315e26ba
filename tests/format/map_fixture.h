/* SPDX-License-Identifier: MIT
 *
 * A small scene and made-up histories in it, for the tests of the map's files. A history is a
 * pure function of its ray id, so any test can make it again and compare.
 */
#ifndef RMAP_MAP_FIXTURE_H
#define RMAP_MAP_FIXTURE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "io/map/map_reader.h"
#include "io/map/map_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "map_fixture_scene.h"
#include "portion/portion_recorder.h"

struct fixture {
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_tally *tally;
    struct rmap_run run;
    char directory[64]; /* of the test */
    char map[80];
};

/* How many of a test's steps a quick run takes, and one under the label slow. */
static inline int fixture_steps(int quick, int all)
{
    const char *scale = getenv("RAYMAP_TEST_SCALE");
    return scale && atoi(scale) > 1 ? all : quick;
}

static inline uint64_t fixture_hash(uint64_t ray, uint64_t k)
{
    uint64_t x = (ray + 1) * UINT64_C(0x9E3779B97F4A7C15) + k * UINT64_C(0xD1B54A32D192ED03);
    x ^= x >> 31;
    x *= UINT64_C(0xBF58476D1CE4E5B9);
    return x ^ x >> 29;
}

static inline double fixture_unit(uint64_t ray, uint64_t k)
{
    return (double)(fixture_hash(ray, k) >> 11) / 9007199254740992.0;
}

/* A curved segment with 0 to 6 points between its ends. */
static inline void fixture_curve(struct rmap_recorder *out, uint64_t ray, struct rmap_step *step,
                                 uint32_t segment)
{
    step->events |= RMAP_EVENT_GRADIENT;
    for (uint64_t j = 0; j < fixture_hash(ray, 1000 + segment) % 7; j++) {
        struct rmap_curve_point point = {
            .segment = segment,
            .position = {30 * fixture_unit(ray, 2000 + 10 * segment + j), (double)j,
                         -(double)segment}};
        out->curve(out, &point);
    }
}

/* One ray: 1 to 20 segments over the scene's objects, a registration now and then. */
static inline void fixture_ray(struct rmap_recorder *out, const struct rmap_scene *scene,
                               uint64_t ray)
{
    double white[RMAP_CHANNEL_MAX], one[RMAP_CHANNEL_MAX] = {[1] = 1.0};
    for (int i = 0; i < scene->channels.n; i++)
        white[i] = 1.0 / scene->channels.n;
    int n_segment = 1 + (int)(fixture_hash(ray, 0) % 20);
    struct rmap_emission emission = {.ray = ray,
                                     .source = (int32_t)(ray % scene->n_source),
                                     .object = -1,
                                     .primitive = -1,
                                     .position = {fixture_unit(ray, 1), fixture_unit(ray, 2), -9},
                                     .direction = {0, 0, 1},
                                     .colour = white};
    out->emit(out, &emission);
    for (int k = 0; k < n_segment; k++) {
        uint64_t h = 100 + 10 * (uint64_t)k;
        bool last = k == n_segment - 1;
        struct rmap_step step = {
            .object = last ? -1 : (int32_t)(fixture_hash(ray, h) % scene->n_object),
            .primitive = last ? -1 : (int32_t)(fixture_hash(ray, h + 1) % 12),
            .events = last                           ? RMAP_EVENT_LEFT
                      : fixture_hash(ray, h + 2) % 3 ? RMAP_EVENT_TRANSMIT_SPECULAR
                                                     : RMAP_EVENT_REFLECT_SPECULAR,
            .medium = (int32_t)(fixture_hash(ray, h + 3) % scene->n_medium),
            .position = {50 * fixture_unit(ray, h + 4) - 25, 50 * fixture_unit(ray, h + 5) - 25,
                         90 * fixture_unit(ray, h + 6)},
            .normal = {0, last ? 0 : 0.6, last ? 0 : -0.8},
            .length = 1,
            .colour = k < 3 ? white : one};
        if (step.medium == 1 && scene->medium[1].field)
            fixture_curve(out, ray, &step, (uint32_t)k);
        out->step(out, &step);
        if (fixture_hash(ray, h + 7) % 5)
            continue;
        const uint32_t *cells = scene->detector[0].cells;
        struct rmap_registration hit = {
            .detector = 0,
            .segment = (uint32_t)k,
            .cell = {(uint32_t)fixture_hash(ray, h + 8) % cells[0],
                     (uint32_t)fixture_hash(ray, h + 9) % cells[1]},
            .relative = {fixture_unit(ray, h + 8), fixture_unit(ray, h + 9)},
            .registered = fixture_hash(ray, h + 9) % 2 == 0,
            .direction = {0, 0, 1},
            .optical_path = k};
        out->registration(out, &hit);
    }
    struct rmap_ending ending = {.stop = RMAP_STOP_LEFT,
                                 .weight = 1,
                                 .wavelength_nm = n_segment > 3 ? 587.56 : (double)NAN,
                                 .path_length = fixture_unit(ray, 3),
                                 .optical_path = fixture_unit(ray, 4),
                                 .direction = {0, 0, 1}};
    out->end(out, &ending);
}

/* Rays [first, first + n) in a portion; the tally, unless NULL, takes them as well. */
static inline struct rmap_portion *fixture_portion(const struct fixture *f, uint64_t first,
                                                   uint64_t n, struct rmap_tally *tally)
{
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    struct rmap_tally_recorder counting;
    assert_int_equal(rmap_portion_create(n, f->scene->channels.n, &portion, NULL), RMAP_OK);
    rmap_portion_recorder_init(&recorder, portion);
    if (tally)
        rmap_tally_recorder_init(&counting, tally, &recorder.base);
    for (uint64_t ray = first; ray < first + n; ray++)
        fixture_ray(tally ? &counting.base : &recorder.base, f->scene, ray);
    assert_int_equal(recorder.status, RMAP_OK);
    return portion;
}

static inline void fixture_init(struct fixture *f)
{
    struct rmap_error err = {0};
    *f = (struct fixture){.directory = "map-test-XXXXXX"};
    assert_non_null(mkdtemp(f->directory));
    (void)snprintf(f->map, sizeof f->map, "%s/t.raymap", f->directory);
    fixture_scene(f->directory, &f->bundle, &f->scene);
    if (rmap_tally_create(f->scene, &f->tally, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    f->run = (struct rmap_run){
        .bundle = f->bundle, .scene = f->scene, .seed = 42, .n_rank = 1, .isa = "test"};
}

static inline void fixture_fini(struct fixture *f)
{
    char command[128];
    rmap_tally_destroy(f->tally);
    rmap_scene_destroy(f->scene);
    rmap_bundle_destroy(f->bundle);
    (void)snprintf(command, sizeof command, "rm -rf %s", f->directory);
    assert_int_equal(system(command), 0);
}

/* Blocks [first, last) into one shard, by this thread alone, as make gives them. */
static inline enum rmap_status
fixture_write_blocks(struct fixture *f, int shard, uint64_t first, uint64_t last,
                     size_t piece_nbytes,
                     struct rmap_portion *(*make)(struct fixture *f, uint64_t block, uint64_t rays),
                     uint64_t rays, struct rmap_error *err)
{
    const struct rmap_shard_options options = {.piece_nbytes = piece_nbytes};
    struct rmap_shard_writer *writer = NULL;
    bool did;
    enum rmap_status st = rmap_shard_writer_create(f->map, shard, &f->run, &options, &writer, err);
    for (uint64_t block = first; st == RMAP_OK && block < last; block++) {
        struct rmap_portion *portion = make(f, block, rays);
        st = rmap_shard_writer_append(writer, portion, err);
        rmap_portion_destroy(portion);
        did = true;
        while (st == RMAP_OK && did)
            st = rmap_shard_writer_encode(writer, &did, err);
        if (st == RMAP_OK)
            st = rmap_shard_writer_store(writer, err);
    }
    if (st == RMAP_OK)
        st = rmap_shard_writer_finish(writer, err);
    rmap_shard_writer_destroy(writer);
    return st;
}

static inline struct rmap_portion *fixture_block(struct fixture *f, uint64_t block, uint64_t rays)
{
    return fixture_portion(f, block * rays, rays, f->tally);
}

/* The same of `rays` rays each. */
static inline enum rmap_status fixture_write_shard(struct fixture *f, int shard, uint64_t first,
                                                   uint64_t last, uint64_t rays,
                                                   size_t piece_nbytes, struct rmap_error *err)
{
    return fixture_write_blocks(f, shard, first, last, piece_nbytes, fixture_block, rays, err);
}

static inline void fixture_must(enum rmap_status st, const struct rmap_error *err)
{
    if (st != RMAP_OK)
        fail_msg("status %d: %s", (int)st, err->text);
}

/* All columns of portion `a` (which may lack some) equal those of `b`. */
static inline void fixture_compare(const struct rmap_portion *a, const struct rmap_portion *b)
{
    assert_memory_equal(a->n_row, b->n_row, sizeof a->n_row);
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column c = (enum rmap_column)i;
        size_t nbytes = a->n_row[rmap_column_info(c)->table] * rmap_portion_row_nbytes(a, c);
        if (rmap_portion_column(a, c) && nbytes > 0)
            assert_memory_equal(rmap_portion_column(a, c), rmap_portion_column(b, c), nbytes);
    }
}

#endif
