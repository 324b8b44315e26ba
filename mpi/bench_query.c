/* SPDX-License-Identifier: MIT
 *
 * Measurement of a question put to a map against the same question put to the reference's file.
 */
#include <fnmatch.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/agree.h"
#include "mpi/bench.h"
#include "mpi/bench_seed.h"
#include "mpi/progress.h"
#include "mpi/scan.h"
#include "trace/event.h"

/* The scene's criterion in the reference's terms. */
static enum rmap_status pose(const struct rmap_bench_scene *scene, bool *in_set,
                             struct rmap_seed_question *question, struct rmap_error *err)
{
    const struct rmap_scene *light = scene->scene;
    const struct rmap_bench_question *asked = &scene->question;
    *question = (struct rmap_seed_question){.source = -1,
                                            .in_set = in_set,
                                            .n_object = light->n_object,
                                            .events = RMAP_EVENT_REFLECT_SPECULAR,
                                            .at_least = asked->at_least,
                                            .detector = -1};
    for (size_t s = 0; s < light->n_source; s++)
        if (strcmp(light->source[s].name, asked->source) == 0)
            question->source = (int32_t)s;
    for (size_t o = 0; o < light->n_object; o++)
        in_set[o] = fnmatch(asked->objects, light->object[o].name, 0) == 0;
    for (size_t d = 0; d < light->n_detector; d++) {
        if (strcmp(light->detector[d].name, asked->detector) != 0)
            continue;
        question->detector = (int32_t)d;
        for (int k = 0; k < 2; k++) {
            double half = asked->half_size[k] / light->detector[d].size[k];
            question->from[k] = 0.5 - half;
            question->to[k] = 0.5 + half;
        }
    }
    if (question->source < 0 || question->detector < 0)
        return rmap_error_set(err, RMAP_INPUT, "%s: source '%s' or detector '%s' is missing",
                              scene->name, asked->source, asked->detector);
    return RMAP_OK;
}

struct search {
    struct rmap_map *map;
    struct rmap_criterion *criterion;
    struct rmap_count count;
    char text[256];
    enum rmap_encoding encoding;
    bool *in_set;
    struct rmap_seed_question question;
    char map_path[600], seed_path[600];
    uint64_t n_segment;
};

static void release(struct search *search)
{
    rmap_free(search->in_set);
    rmap_count_fini(&search->count);
    rmap_criterion_destroy(search->criterion);
    rmap_map_close(search->map);
}

/* The same rays in both stores, and the same question to both. */
static enum rmap_status prepare(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_bench_question *asked = &scene->question;
    uint64_t n_ray = bench->quick ? 200000 : 1000000;
    struct rmap_seed_result seed;
    double seconds, n_segment;
    (void)snprintf(search->map_path, sizeof search->map_path, "%s/query-%s.raymap", bench->folder,
                   scene->name);
    (void)snprintf(search->seed_path, sizeof search->seed_path, "%s/query-%s.seed", bench->folder,
                   scene->name);
    (void)snprintf(search->text, sizeof search->text,
                   "source(%s) and hit('%s', reflect_specular) >= %d and registered(%s, "
                   "rect(%g, %g, %g, %g))",
                   asked->source, asked->objects, asked->at_least, asked->detector,
                   -asked->half_size[0], -asked->half_size[1], asked->half_size[0],
                   asked->half_size[1]);
    search->in_set = rmap_alloc(scene->scene->n_object, sizeof *search->in_set);
    if (!search->in_set)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory"));
    RMAP_TRY(pose(scene, search->in_set, &search->question, err));
    const struct rmap_bench_store store = {.path = search->map_path, .encoding = search->encoding};
    RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene, n_ray, &store, &seconds,
                              &n_segment, err));
    RMAP_TRY(rmap_seed_record(scene->scene, scene->accel, n_ray, bench->alone.n_thread,
                              search->seed_path, &seed, err));
    search->n_segment = seed.n_segment;
    RMAP_TRY(rmap_map_open(search->map_path, &search->map, err));
    RMAP_TRY(
        rmap_criterion_compile(search->text, rmap_map_scene(search->map), &search->criterion, err));
out:
    return st;
}

/* Both must find the same rays: else there is nothing to compare. */
static enum rmap_status ask_both(struct rmap_bench *bench, struct search *search,
                                 struct rmap_bench_series *series, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n_seed = 0;
    double seed_s, n_segment = 1e-6 * (double)search->n_segment;
    rmap_count_fini(&search->count);
    RMAP_TRY(rmap_count_init(&search->count, rmap_map_scene(search->map)->n_source, err));
    double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    RMAP_TRY(rmap_scan_map(&bench->alone, search->map, &search->criterion, 1, &search->count, NULL,
                           UINT64_MAX, err));
    double map_s = rmap_clock_seconds() - begun, map_cpu = rmap_bench_cpu() - cpu;
    RMAP_TRY(rmap_seed_query(search->seed_path, &search->question, bench->alone.n_thread, &n_seed,
                             &seed_s, err));
    rmap_bench_add(series, n_segment / map_s, n_segment / seed_s);
    rmap_bench_add_cpu(series, map_cpu, rmap_bench_cpu() - cpu - map_cpu);
    if (n_seed != search->count.rays)
        RMAP_TRY(rmap_error_set(
            err, RMAP_INTERNAL, "the map finds %llu rays, the reference %llu: %s",
            (unsigned long long)search->count.rays, (unsigned long long)n_seed, search->text));
out:
    return st;
}

static enum rmap_status query_encoding(struct rmap_bench *bench,
                                       const struct rmap_bench_scene *scene, size_t encoding,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct search search = {.encoding = rmap_bench_encoding[encoding].encoding};
    struct rmap_bench_series series = {0};
    struct rmap_bench_series warming = {0}; /* brings both into the page cache */
    RMAP_TRY(prepare(bench, scene, &search, err));
    RMAP_TRY(ask_both(bench, &search, &warming, err));
    for (int i = 0; i < bench->n_repeat; i++)
        RMAP_TRY(ask_both(bench, &search, &series, err));
    rmap_bench_report(bench, "query_vs_seed", scene, &series, "million segments/s",
                      json_pack("{s:s, s:s, s:I}", "encoding", rmap_bench_encoding[encoding].name,
                                "criterion", search.text, "matched",
                                (json_int_t)search.count.rays));
out:
    release(&search);
    return st;
}

enum rmap_status rmap_bench_query(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t e = 0; st == RMAP_OK && e < RMAP_BENCH_ENCODINGS; e++)
        st = query_encoding(bench, scene, e, err);
    return st;
}
