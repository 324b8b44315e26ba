/* SPDX-License-Identifier: MIT
 *
 * Measurement of questions put to a map: each class of criteria against the same question put to
 * the reference's file, and several criteria in one scan against the slowest of them.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "bench.h"
#include "bench_search.h"
#include "bench_seed.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/scan.h"

enum { QUESTION_MAX = 8 };

static enum rmap_status prepare(struct rmap_bench_search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench *bench = search->bench;
    const struct rmap_bench_scene *scene = search->scene;
    uint64_t n_ray = bench->quick ? 200000 : 1000000;
    struct rmap_seed_result seed;
    double seconds, n_segment;
    search->n_question = rmap_bench_questions(scene->name, &search->question);
    for (size_t k = 0; k < RMAP_BENCH_ENCODINGS; k++) {
        (void)snprintf(search->map[k], sizeof search->map[k], "%s/query-%s-%zu.raymap",
                       bench->folder, scene->name, k);
        const struct rmap_bench_store store = {.path = search->map[k],
                                               .encoding = rmap_bench_encoding[k].encoding};
        RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene, n_ray, &store,
                                  &seconds, &n_segment, err));
    }
    (void)snprintf(search->seed, sizeof search->seed, "%s/query-%s.seed", bench->folder,
                   scene->name);
    RMAP_TRY(rmap_seed_record(scene->scene, scene->accel, n_ray, bench->alone.n_thread,
                              search->seed, &seed, err));
    search->n_segment = 1e-6 * (double)seed.n_segment;
out:
    return st;
}

/* Puts questions to an open map, all in one scan, which alone is timed. */
static enum rmap_status ask(const struct rmap_bench_search *search, struct rmap_map *map,
                            const struct rmap_bench_question *question, size_t n_question,
                            struct rmap_bench_answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion *criterion[QUESTION_MAX] = {NULL};
    struct rmap_count count[QUESTION_MAX] = {{0}};
    if (n_question > QUESTION_MAX)
        return rmap_error_set(err, RMAP_INTERNAL, "too many questions in one scan");
    for (size_t q = 0; q < n_question; q++) {
        RMAP_TRY(rmap_criterion_compile(question[q].text, rmap_map_scene(map), &criterion[q], err));
        RMAP_TRY(rmap_count_init(&count[q], rmap_map_scene(map)->n_source, err));
    }
    double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    RMAP_TRY(rmap_scan_map(&search->bench->alone, map, criterion, n_question, RMAP_DEAL_SHARES,
                           count, err));
    *answer = (struct rmap_bench_answer){.seconds = rmap_clock_seconds() - begun,
                                         .cpu = rmap_bench_cpu() - cpu,
                                         .n_ray = count[0].rays};
out:
    for (size_t q = 0; q < n_question; q++) {
        rmap_count_fini(&count[q]);
        rmap_criterion_destroy(criterion[q]);
    }
    return st;
}

/* To a map opened for them. */
static enum rmap_status ask_map(const struct rmap_bench_search *search, size_t encoding,
                                const struct rmap_bench_question *question, size_t n_question,
                                struct rmap_bench_answer *answer, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = rmap_map_open(search->map[encoding], &map, err);
    if (st == RMAP_OK)
        st = ask(search, map, question, n_question, answer, err);
    rmap_map_close(map);
    return st;
}

void rmap_bench_search_report(const struct rmap_bench_search *search, size_t encoding,
                              const char *name, const struct rmap_bench_series *series,
                              const char *unit, json_t *extra)
{
    (void)json_object_set_new(extra, "encoding", json_string(rmap_bench_encoding[encoding].name));
    rmap_bench_report(search->bench, name, search->scene, series, unit, extra);
}

/* Both must find the same rays, or as nearly as the reference's numbers tell: else there is nothing
 * to compare. */
static enum rmap_status check_answer(const struct rmap_bench_question *question,
                                     const struct rmap_bench_answer *answer, uint64_t n_seed,
                                     struct rmap_error *err)
{
    double apart = fabs((double)answer->n_ray - (double)n_seed);
    if (apart <= question->tolerance * (double)n_seed)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INTERNAL, "the map finds %llu rays, the reference %llu: %s",
                          (unsigned long long)answer->n_ray, (unsigned long long)n_seed,
                          question->text);
}

/* One question: the reference and the maps in turns. */
static enum rmap_status measure_class(const struct rmap_bench_search *search,
                                      const struct rmap_bench_question *question,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench *bench = search->bench;
    struct rmap_seed_question asked;
    struct rmap_bench_series series[RMAP_BENCH_ENCODINGS] = {{0}};
    struct rmap_bench_answer answer = {0};
    bool *in_set = NULL;
    RMAP_TRY(rmap_bench_question_pose(question, search->scene->scene, &asked, &in_set, err));
    for (int i = -1; i < bench->n_repeat; i++) { /* -1: brings all into the page cache */
        uint64_t n_seed = 0;
        double seed_s, cpu = rmap_bench_cpu();
        RMAP_TRY(
            rmap_seed_query(search->seed, &asked, bench->alone.n_thread, &n_seed, &seed_s, err));
        cpu = rmap_bench_cpu() - cpu;
        for (size_t k = 0; k < RMAP_BENCH_ENCODINGS; k++) {
            RMAP_TRY(ask_map(search, k, question, 1, &answer, err));
            RMAP_TRY(check_answer(question, &answer, n_seed, err));
            if (i < 0)
                continue;
            rmap_bench_add(&series[k], search->n_segment / answer.seconds,
                           search->n_segment / seed_s);
            rmap_bench_add_cpu(&series[k], answer.cpu, cpu);
        }
    }
    for (size_t k = 0; k < RMAP_BENCH_ENCODINGS; k++)
        rmap_bench_search_report(search, k, "query_vs_seed", &series[k], "million segments/s",
                                 json_pack("{s:s, s:s, s:I}", "class", question->class, "criterion",
                                           question->text, "matched", (json_int_t)answer.n_ray));
out:
    rmap_free(in_set);
    return st;
}

/* All questions in one scan against the slowest of them alone. */
static enum rmap_status measure_several(const struct rmap_bench_search *search, size_t encoding,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    for (int i = 0; i < search->bench->n_repeat; i++) {
        struct rmap_bench_answer together = {0}, alone = {0}, slowest = {0};
        RMAP_TRY(ask_map(search, encoding, search->question, search->n_question, &together, err));
        for (size_t q = 0; q < search->n_question; q++) {
            RMAP_TRY(ask_map(search, encoding, &search->question[q], 1, &alone, err));
            if (alone.seconds > slowest.seconds)
                slowest = alone;
        }
        rmap_bench_add(&series, 1e3 * together.seconds, 1e3 * slowest.seconds);
        rmap_bench_add_cpu(&series, slowest.cpu, together.cpu); /* as the times: together / alone */
    }
    rmap_bench_search_report(search, encoding, "query_several_vs_slowest", &series, "ms",
                             json_pack("{s:I}", "criteria", (json_int_t)search->n_question));
out:
    return st;
}

enum rmap_status rmap_bench_query(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_search search = {.bench = bench, .scene = scene};
    RMAP_TRY(prepare(&search, err));
    for (size_t q = 0; q < search.n_question && rmap_bench_wanted(bench, "query_vs_seed"); q++)
        if (search.question[q].class)
            RMAP_TRY(measure_class(&search, &search.question[q], err));
    if (rmap_bench_wanted(bench, "query_several_vs_slowest"))
        for (size_t k = 0; k < RMAP_BENCH_ENCODINGS; k++)
            RMAP_TRY(measure_several(&search, k, err));
    for (size_t q = 0; q < search.n_question; q++)
        for (size_t k = 0;
             k < RMAP_BENCH_ENCODINGS && rmap_bench_wanted(bench, "session_second_vs_first"); k++)
            if (search.question[q].class)
                RMAP_TRY(rmap_bench_session(&search, k, &search.question[q], err));
out:
    return st;
}
