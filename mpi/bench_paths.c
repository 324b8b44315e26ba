/* SPDX-License-Identifier: MIT
 *
 * Measurement of tables of paths against the questions that feed them: the rays of one criterion
 * counted, and told apart by their paths.
 */
#include "mpi/bench.h"
#include "mpi/bench_questions.h"
#include "mpi/path_run.h"
#include "mpi/progress.h"
#include "mpi/scan.h"

/* All rays, each of whose steps is looked at. */
static const char every[] = "path(\"([TRIDdSFOAXKE]|V)*\")";

static enum rmap_status time_query(struct rmap_bench *bench, struct rmap_map *map,
                                   struct rmap_criterion *criterion, struct rmap_bench_cost *cost,
                                   struct rmap_error *err)
{
    struct rmap_count found = {0};
    enum rmap_status st = rmap_count_init(&found, rmap_map_scene(map)->n_source, err);
    const double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    if (st == RMAP_OK)
        st = rmap_scan_map(&bench->alone, map, &criterion, 1, RMAP_DEAL_SHARES, &found, err);
    *cost = (struct rmap_bench_cost){rmap_clock_seconds() - begun, rmap_bench_cpu() - cpu};
    rmap_count_fini(&found);
    return st;
}

static enum rmap_status time_paths(struct rmap_bench *bench, struct rmap_map *map,
                                   struct rmap_criterion *criterion, struct rmap_bench_cost *cost,
                                   struct rmap_error *err)
{
    struct rmap_path_request request = {.map = map,
                                        .criterion = criterion,
                                        .top = 20,
                                        .view.detector = -1,
                                        .most_classes = RMAP_PATH_CLASSES_MOST};
    struct rmap_path_keys *keys = NULL;
    struct rmap_path_report *report = NULL;
    enum rmap_status st = rmap_path_keys_create(rmap_map_scene(map), &request.view, &keys, err);
    const double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
    request.keys = keys;
    if (st == RMAP_OK)
        st = rmap_path_run(&bench->alone, &request, &report, err);
    *cost = (struct rmap_bench_cost){rmap_clock_seconds() - begun, rmap_bench_cpu() - cpu};
    rmap_path_report_destroy(report);
    rmap_path_keys_destroy(keys);
    return st;
}

static enum rmap_status measure(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                struct rmap_map *map, const char *text, double n_segment,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    struct rmap_criterion *criterion = NULL;
    RMAP_TRY(rmap_criterion_compile(text, rmap_map_scene(map), &criterion, err));
    for (int i = -1; i < bench->n_repeat; i++) { /* -1: brings the map into the page cache */
        struct rmap_bench_cost ours, reference;
        RMAP_TRY(time_paths(bench, map, criterion, &ours, err));
        RMAP_TRY(time_query(bench, map, criterion, &reference, err));
        if (i >= 0)
            rmap_bench_add_speeds(&series, n_segment, ours, reference);
    }
    rmap_bench_report(bench, "paths_vs_query", scene, &series, "million segments/s",
                      json_pack("{s:s}", "criterion", text));
out:
    rmap_criterion_destroy(criterion);
    return st;
}

enum rmap_status rmap_bench_paths(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *map = NULL;
    char path[600];
    const struct rmap_bench_question *question = NULL;
    const size_t n_question = rmap_bench_questions(scene->name, &question);
    double seconds, n_segment;
    (void)snprintf(path, sizeof path, "%s/paths-%s.raymap", bench->folder, scene->name);
    const struct rmap_bench_store store = {.path = path, .encoding = RMAP_ENCODING_PLAIN};
    RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene,
                              bench->quick ? 200000 : 1000000, &store, &seconds, &n_segment, err));
    RMAP_TRY(rmap_map_open(path, &map, err));
    RMAP_TRY(measure(bench, scene, map, every, n_segment, err));
    for (size_t q = 0; q < n_question; q++)
        if (question[q].class)
            RMAP_TRY(measure(bench, scene, map, question[q].text, n_segment, err));
out:
    rmap_map_close(map);
    return st;
}
