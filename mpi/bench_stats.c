/* SPDX-License-Identifier: MIT
 *
 * Measurement of statistics against the questions that feed them: the same rays of the same map,
 * counted, and with all that `raymap stats` says of a number of theirs.
 */
#include <string.h>

#include "mpi/bench.h"
#include "mpi/bench_questions.h"
#include "mpi/progress.h"
#include "mpi/scan.h"
#include "mpi/stats_run.h"

/* All rays: the most that statistics can have to do. */
static const char every[] = "path_length >= 0";

struct task {
    struct rmap_bench *bench;
    struct rmap_map *map;
    struct rmap_criterion *criterion;
};

static enum rmap_status count(const struct task *task, struct rmap_bench_cost *cost,
                              struct rmap_error *err)
{
    struct rmap_count found = {0};
    enum rmap_status st = rmap_count_init(&found, rmap_map_scene(task->map)->n_source, err);
    if (st != RMAP_OK)
        return st;
    double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    st = rmap_scan_map(&task->bench->alone, task->map, &task->criterion, 1, RMAP_DEAL_SHARES,
                       &found, err);
    *cost = (struct rmap_bench_cost){rmap_clock_seconds() - begun, rmap_bench_cpu() - cpu};
    rmap_count_fini(&found);
    return st;
}

static enum rmap_status sum_up(const struct task *task, struct rmap_bench_cost *cost,
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
    double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    st = rmap_stats_run(&task->bench->alone, &request, &answer, err);
    *cost = (struct rmap_bench_cost){rmap_clock_seconds() - begun, rmap_bench_cpu() - cpu};
out:
    rmap_stats_answer_fini(&answer);
    rmap_quantities_destroy(quantities);
    return st;
}

/* One criterion, both in turns. */
static enum rmap_status measure(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                struct rmap_map *map, const char *class, const char *text,
                                double n_segment, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    struct task task = {.bench = bench, .map = map};
    RMAP_TRY(rmap_criterion_compile(text, rmap_map_scene(map), &task.criterion, err));
    for (int i = -1; i < bench->n_repeat; i++) { /* -1: brings the map into the page cache */
        struct rmap_bench_cost ours, reference;
        RMAP_TRY(sum_up(&task, &ours, err));
        RMAP_TRY(count(&task, &reference, err));
        if (i >= 0)
            rmap_bench_add_speeds(&series, n_segment, ours, reference);
    }
    rmap_bench_report(bench, "stats_vs_query", scene, &series, "million segments/s",
                      json_pack("{s:s, s:s}", "class", class, "criterion", text));
out:
    rmap_criterion_destroy(task.criterion);
    return st;
}

enum rmap_status rmap_bench_stats(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *map = NULL;
    char path[600];
    const struct rmap_bench_question *question = NULL;
    const size_t n_question = rmap_bench_questions(scene->name, &question);
    double seconds, n_segment;
    (void)snprintf(path, sizeof path, "%s/stats-%s.raymap", bench->folder, scene->name);
    const struct rmap_bench_store store = {.path = path, .encoding = RMAP_ENCODING_PLAIN};
    RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene,
                              bench->quick ? 200000 : 1000000, &store, &seconds, &n_segment, err));
    RMAP_TRY(rmap_map_open(path, &map, err));
    RMAP_TRY(measure(bench, scene, map, "every ray", every, n_segment, err));
    for (size_t q = 0; q < n_question; q++)
        if (question[q].class)
            RMAP_TRY(
                measure(bench, scene, map, question[q].class, question[q].text, n_segment, err));
out:
    rmap_map_close(map);
    return st;
}
