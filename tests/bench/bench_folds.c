/* SPDX-License-Identifier: MIT
 *
 * Measurement of what `raymap stats`, `raymap paths` and `raymap report --energy` make of the rays
 * of a criterion, against two queries that feed them: "count", which decides which rays match and
 * counts them; and "columns", which also reads, of the portions with such rays, the columns that
 * the statistic is made of. In a map of each encoding.
 */
#include <string.h>

#include "analysis/energy/energy_sums.h"
#include "base/alloc.h"
#include "bench.h"
#include "bench_questions.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/energy_run.h"
#include "mpi/scan/fold_run.h"
#include "mpi/scan/path_run.h"
#include "mpi/scan/scan.h"
#include "mpi/scan/stats_run.h"

struct task {
    struct rmap_bench *bench;
    struct rmap_map *map;
    struct rmap_criterion *criterion;
    rmap_column_set columns; /* that the statistic is made of */
};

static struct rmap_bench_cost begin(void)
{
    return (struct rmap_bench_cost){rmap_clock_seconds(), rmap_bench_cpu()};
}

static struct rmap_bench_cost since(struct rmap_bench_cost begun)
{
    const struct rmap_bench_cost now = begin();
    return (struct rmap_bench_cost){now.wall_s - begun.wall_s, now.cpu_s - begun.cpu_s};
}

/* ---- the queries ---- */

static enum rmap_status count(struct task *task, struct rmap_bench_cost *cost,
                              struct rmap_error *err)
{
    struct rmap_count found = {0};
    enum rmap_status st = rmap_count_init(&found, rmap_map_scene(task->map)->n_source, err);
    if (st != RMAP_OK)
        return st;
    const struct rmap_bench_cost begun = begin();
    st = rmap_scan_map(&task->bench->alone, task->map, &task->criterion, 1, RMAP_DEAL_SHARES,
                       &found, err);
    *cost = since(begun);
    rmap_count_fini(&found);
    return st;
}

/* A fold that is handed the columns and counts the rays. */
static enum rmap_status create_number(const void *context, void **state_ret, struct rmap_error *err)
{
    (void)context;
    *state_ret = rmap_alloc(1, sizeof(uint64_t));
    return *state_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
}

static enum rmap_status add_rays(void *state, const struct rmap_matched *rays,
                                 struct rmap_error *err)
{
    (void)err;
    *(uint64_t *)state += rays->n_match;
    return RMAP_OK;
}

static enum rmap_status merge_numbers(void *into, void *from, struct rmap_error *err)
{
    (void)err;
    *(uint64_t *)into += *(const uint64_t *)from;
    return RMAP_OK;
}

/* Between threads alone: this rank is by itself. */
static const struct rmap_fold_kind delivery = {
    .create = create_number, .destroy = rmap_free, .add = add_rays, .merge = merge_numbers};

static enum rmap_status deliver(struct task *task, struct rmap_bench_cost *cost,
                                struct rmap_error *err)
{
    const struct rmap_fold fold = {.kind = &delivery,
                                   .map = task->map,
                                   .criterion = task->criterion,
                                   .columns = task->columns};
    void *number = NULL;
    const struct rmap_bench_cost begun = begin();
    enum rmap_status st = rmap_fold_run(&task->bench->alone, &fold, &number, err);
    *cost = since(begun);
    rmap_free(number);
    return st;
}

/* ---- the statistics ---- */

/* Moments, exact quantiles and a histogram. */
static enum rmap_status stats(struct task *task, struct rmap_bench_cost *cost,
                              struct rmap_error *err)
{
    static const double share[] = {0.05, 0.25, 0.5, 0.75, 0.95};
    static const char *const of = "path_length";
    enum rmap_status st = RMAP_OK;
    struct rmap_quantities *quantities = NULL;
    struct rmap_stats_setup setup;
    struct rmap_stats_answer answer = {0};
    RMAP_TRY(rmap_quantities_create(task->map, &of, 1, NULL, &quantities, err));
    rmap_stats_setup_init(&setup, quantities, RMAP_STATS_TOGETHER, (size_t)1 << 30);
    const struct rmap_stats_request request = {.setup = &setup,
                                               .criterion = task->criterion,
                                               .p = share,
                                               .n_quantile = sizeof share / sizeof *share};
    const struct rmap_bench_cost begun = begin();
    st = rmap_stats_run(&task->bench->alone, &request, &answer, err);
    *cost = since(begun);
    task->columns = quantities->columns;
out:
    rmap_stats_answer_fini(&answer);
    rmap_quantities_destroy(quantities);
    return st;
}

/* The 20 largest classes with their texts; no cells. */
static enum rmap_status paths(struct task *task, struct rmap_bench_cost *cost,
                              struct rmap_error *err)
{
    struct rmap_path_request request = {.map = task->map,
                                        .criterion = task->criterion,
                                        .top = 20,
                                        .view.detector = -1,
                                        .most_classes = RMAP_PATH_CLASSES_MOST};
    struct rmap_path_keys *keys = NULL;
    struct rmap_path_report *report = NULL;
    enum rmap_status st =
        rmap_path_keys_create(rmap_map_scene(task->map), &request.view, &keys, err);
    if (st != RMAP_OK)
        return st;
    const struct rmap_path_counting counting = {.map = task->map, .keys = keys};
    task->columns = rmap_path_count_columns(&counting);
    request.keys = keys;
    const struct rmap_bench_cost begun = begin();
    st = rmap_path_run(&task->bench->alone, &request, &report, err);
    *cost = since(begun);
    rmap_path_report_destroy(report);
    rmap_path_keys_destroy(keys);
    return st;
}

/* Where the light ended, by objects, media and detectors. */
static enum rmap_status energy(struct task *task, struct rmap_bench_cost *cost,
                               struct rmap_error *err)
{
    struct rmap_energy_scope scope;
    struct rmap_energy_sums *sums = NULL;
    const struct rmap_bench_cost begun = begin();
    enum rmap_status st =
        rmap_energy_run(&task->bench->alone, task->map,
                        &(struct rmap_choice){.criterion = task->criterion}, &scope, &sums, err);
    *cost = since(begun);
    if (st == RMAP_OK)
        task->columns = rmap_energy_columns(&scope);
    rmap_energy_sums_destroy(sums);
    return st;
}

static const struct statistic {
    const char *name;  /* of the measurement */
    const char *every; /* a criterion of all rays */
    enum rmap_status (*run)(struct task *task, struct rmap_bench_cost *cost,
                            struct rmap_error *err);
} statistics[] = {{"stats_vs_query", "path_length >= 0", stats},
                  /* each of whose steps is looked at */
                  {"paths_vs_query", "path(\"([TRIDdSFOAXKE]|V)*\")", paths},
                  {"energy_vs_query", "all", energy}};
enum { N_STATISTIC = sizeof statistics / sizeof *statistics };

bool rmap_bench_wants_folds(const struct rmap_bench *bench)
{
    bool any = false;
    for (size_t i = 0; i < N_STATISTIC; i++)
        any = any || rmap_bench_wanted(bench, statistics[i].name);
    return any;
}

/* A map of the scene's rays. */
struct stored {
    struct rmap_bench *bench;
    const struct rmap_bench_scene *scene;
    const struct rmap_bench_encoding *encoding;
    struct rmap_map *map;
    double n_segment;
};

static void report(const struct stored *stored, const char *name,
                   const struct rmap_bench_series *series, const char *against, const char *class,
                   const char *text)
{
    rmap_bench_report(stored->bench, name, stored->scene, series, "million segments/s",
                      json_pack("{s:s, s:s, s:s, s:s}", "encoding", stored->encoding->name,
                                "against", against, "class", class, "criterion", text));
}

/* One criterion, the statistic and both queries in turns. */
static enum rmap_status measure(const struct stored *stored, const struct statistic *statistic,
                                const char *class, const char *text, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series counted = {0}, delivered = {0};
    struct task task = {.bench = stored->bench, .map = stored->map};
    RMAP_TRY(rmap_criterion_compile(text, rmap_map_scene(task.map), &task.criterion, err));
    for (int i = -1; i < task.bench->n_repeat; i++) { /* -1: brings the map into the page cache */
        struct rmap_bench_cost ours, counting, delivering;
        RMAP_TRY(statistic->run(&task, &ours, err));
        RMAP_TRY(count(&task, &counting, err));
        RMAP_TRY(deliver(&task, &delivering, err));
        if (i < 0)
            continue;
        rmap_bench_add_speeds(&counted, stored->n_segment, ours, counting);
        rmap_bench_add_speeds(&delivered, stored->n_segment, ours, delivering);
    }
    report(stored, statistic->name, &counted, "count", class, text);
    report(stored, statistic->name, &delivered, "columns", class, text);
out:
    rmap_criterion_destroy(task.criterion);
    return st;
}

/* Of every ray, and of the scene's questions. */
static enum rmap_status measure_all(const struct stored *stored, const struct statistic *statistic,
                                    struct rmap_error *err)
{
    const struct rmap_bench_question *question = NULL;
    const size_t n_question = rmap_bench_questions(stored->scene->name, &question);
    enum rmap_status st = measure(stored, statistic, "every ray", statistic->every, err);
    for (size_t q = 0; st == RMAP_OK && q < n_question; q++)
        if (question[q].class)
            st = measure(stored, statistic, question[q].class, question[q].text, err);
    return st;
}

static enum rmap_status measure_encoding(struct rmap_bench *bench,
                                         const struct rmap_bench_scene *scene,
                                         const struct rmap_bench_encoding *encoding,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stored stored = {.bench = bench, .scene = scene, .encoding = encoding};
    char path[600];
    double seconds;
    (void)snprintf(path, sizeof path, "%s/folds-%s-%s.raymap", bench->folder, scene->name,
                   encoding->name);
    const struct rmap_bench_store store = {.path = path, .encoding = encoding->encoding};
    RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene,
                              bench->quick ? 200000 : 1000000, &store, &seconds, &stored.n_segment,
                              err));
    RMAP_TRY(rmap_map_open(path, &stored.map, err));
    for (size_t i = 0; i < N_STATISTIC; i++)
        if (rmap_bench_wanted(bench, statistics[i].name))
            RMAP_TRY(measure_all(&stored, &statistics[i], err));
out:
    rmap_map_close(stored.map);
    return st;
}

enum rmap_status rmap_bench_folds(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t e = 0; e < RMAP_BENCH_ENCODINGS && st == RMAP_OK; e++)
        st = measure_encoding(bench, scene, &rmap_bench_encoding[e], err);
    return st;
}
