/* SPDX-License-Identifier: MIT
 *
 * raymap bench: the measurements of `raymap bench`: speed against references, as ratios in one run.
 */
#define _XOPEN_SOURCE 700 /* nftw */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "bench.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "version.h"

static const char *const measurement[] = {"trace_vs_roofline",
                                          "record_vs_trace",
                                          "record_vs_seed",
                                          "bytes_per_segment",
                                          "durable_vs_not",
                                          "checksums_vs_trace",
                                          "durability_vs_trace",
                                          "resume_vs_anew",
                                          "decode_vs_seed",
                                          "verify_vs_decode",
                                          "query_vs_seed",
                                          "query_several_vs_slowest",
                                          "session_second_vs_first",
                                          "stats_vs_query",
                                          "paths_vs_query",
                                          "energy_vs_query",
                                          "ranks_vs_threads",
                                          "gradient_evaluations_vs_seed",
                                          "uniform_vs_gradient_code",
                                          "render_preview",
                                          "render_overhead",
                                          "scatter_vs_roofline",
                                          "tm25_write_vs_plain",
                                          "tm25_read_vs_plain",
                                          "timed_vs_plain",
                                          "move_vs_build",
                                          "moved_trace_vs_fresh",
                                          "cache_vs_none"};

static const struct rmap_bench_scene known_scene[] = {
    {.name = "room", .folder = "room"},
    {.name = "double-gauss", .folder = "double-gauss"},
    {.name = "double-gauss-31",
     .folder = "double-gauss",
     .set = "spectrum.wavelengths={from: 400, to: 700, step: 10}",
     .sizes_only = true},
    {.name = "gradient-sphere", .folder = "gradient-sphere", .pictures = true},
    {.name = "gradient-noise",
     .folder = "gradient-sphere",
     .set = "objects.front.inside=noise",
     .pictures = true},
    {.name = "scintillator",
     .folder = "scintillator",
     .set = "spectrum.wavelengths=[425]",
     .timed = true},
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* Beside the program when installed, in the source tree when built there, or here. */
static bool find_scene(const char *folder, const char *name, char *path, size_t path_nbytes)
{
    static const char *const place[] = {"../share/raymap/examples", "../../examples"};
    char program[400];
    ssize_t len = readlink("/proc/self/exe", program, sizeof program - 1);
    (void)snprintf(path, path_nbytes, "%s/%s/scene.yaml", folder ? folder : "examples", name);
    if (folder || access(path, R_OK) == 0)
        return true;
    program[len > 0 ? len : 0] = 0;
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = 0;
    for (size_t i = 0; slash && i < COUNT(place); i++) {
        (void)snprintf(path, path_nbytes, "%s/%s/%s/scene.yaml", program, place[i], name);
        if (access(path, R_OK) == 0)
            return true;
    }
    return false;
}

static enum rmap_status unknown_name(struct rmap_error *err, const char *name)
{
    char list[1024] = "";
    for (size_t i = 0, at = 0; i < COUNT(measurement); i++)
        at += (size_t)snprintf(list + at, sizeof list - at, " %s", measurement[i]);
    return rmap_error_set(err, RMAP_USAGE, "no measurement '%s'; there are:%s", name, list);
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct rmap_bench *bench,
                                     struct rmap_error *err)
{
    bench->quick = rmap_argument(given, "quick") != NULL;
    bench->only = rmap_argument(given, "only");
    uint64_t n_repeat = bench->quick ? 3 : 7;
    enum rmap_status st = rmap_argument_count(given, "repeats", &n_repeat, err);
    if (st != RMAP_OK)
        return st;
    if (n_repeat < 1 || n_repeat > RMAP_BENCH_REPEAT_MAX)
        return rmap_error_set(err, RMAP_USAGE, "--repeats must lie between 1 and %d",
                              (int)RMAP_BENCH_REPEAT_MAX);
    bench->n_repeat = (int)n_repeat;
    bool known = !bench->only;
    for (size_t i = 0; i < COUNT(measurement); i++)
        known = known || strcmp(bench->only, measurement[i]) == 0;
    if (!known)
        return unknown_name(err, bench->only);
    const char *scene = rmap_argument(given, "scene");
    for (size_t i = 0; i < COUNT(known_scene); i++)
        if (!scene || strcmp(scene, known_scene[i].name) == 0)
            return RMAP_OK;
    char list[256] = "";
    for (size_t i = 0, at = 0; i < COUNT(known_scene); i++)
        at += (size_t)snprintf(list + at, sizeof list - at, " %s", known_scene[i].name);
    return rmap_error_set(err, RMAP_USAGE, "no example scene '%s'; there are:%s", scene, list);
}

static int remove_entry(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status;
    (void)kind;
    (void)place;
    return remove(path);
}

/* Collective: rank 0's name for it is everyone's. */
static enum rmap_status make_folder(struct rmap_bench *bench, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = bench->context;
    const char *parent = getenv("TMPDIR");
    (void)snprintf(bench->folder, sizeof bench->folder, "%s/raymap-bench-XXXXXX",
                   parent && *parent ? parent : "/tmp");
    if (context->rank == 0 && !mkdtemp(bench->folder)) {
        bench->folder[0] = 0;
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot make a folder in %s",
                            parent && *parent ? parent : "/tmp");
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(bench->folder, sizeof bench->folder, MPI_CHAR, 0, context->comm)));
out:
    return st;
}

static bool wants_record(const struct rmap_bench *bench)
{
    return rmap_bench_wanted(bench, "record_vs_trace") ||
           rmap_bench_wanted(bench, "record_vs_seed") ||
           rmap_bench_wanted(bench, "bytes_per_segment");
}

static bool wants_pictures(const struct rmap_bench *bench)
{
    return rmap_bench_wanted(bench, "render_preview") ||
           rmap_bench_wanted(bench, "render_overhead");
}

/* By the measurements that it is for. */
static bool wants_scene(const struct rmap_bench *bench, const struct rmap_bench_scene *scene)
{
    const bool times = rmap_bench_wanted(bench, "timed_vs_plain");
    if (scene->sizes_only)
        return rmap_bench_wanted(bench, "bytes_per_segment");
    if (scene->pictures)
        return wants_pictures(bench);
    if (scene->timed)
        return times;
    return !bench->only || !(times || wants_pictures(bench));
}

/* Rank 0 alone. */
static enum rmap_status measure_alone(struct rmap_bench *bench, const char *path,
                                      const struct rmap_bench_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (rmap_bench_wanted(bench, "trace_vs_roofline"))
        RMAP_TRY(rmap_bench_roofline(bench, scene, err));
    if (rmap_bench_wanted(bench, "scatter_vs_roofline"))
        RMAP_TRY(rmap_bench_scatter(bench, scene, err));
    if (wants_record(bench))
        RMAP_TRY(rmap_bench_record(bench, scene, err));
    if (rmap_bench_wanted(bench, "durable_vs_not") ||
        rmap_bench_wanted(bench, "checksums_vs_trace") ||
        rmap_bench_wanted(bench, "durability_vs_trace"))
        RMAP_TRY(rmap_bench_durability(bench, scene, err));
    if (rmap_bench_wanted(bench, "resume_vs_anew"))
        RMAP_TRY(rmap_bench_resume(bench, scene, path, err));
    if (rmap_bench_wanted(bench, "decode_vs_seed"))
        RMAP_TRY(rmap_bench_decode(bench, scene, err));
    if (rmap_bench_wanted(bench, "verify_vs_decode"))
        RMAP_TRY(rmap_bench_verify(bench, scene, err));
    if (rmap_bench_wanted(bench, "query_vs_seed") ||
        rmap_bench_wanted(bench, "query_several_vs_slowest") ||
        rmap_bench_wanted(bench, "session_second_vs_first"))
        RMAP_TRY(rmap_bench_query(bench, scene, err));
    if (rmap_bench_wants_folds(bench))
        RMAP_TRY(rmap_bench_folds(bench, scene, err));
    if (rmap_bench_wanted(bench, "uniform_vs_gradient_code"))
        RMAP_TRY(rmap_bench_uniform(bench, scene, path, err));
out:
    return st;
}

enum rmap_status rmap_bench_load(struct rmap_bench *bench, const char *path, const char *const *set,
                                 size_t n_set, struct rmap_bench_scene *scene,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options light = {.set = rmap_alloc(n_set + 1, sizeof *light.set)};
    for (size_t i = 0; light.set && i < n_set; i++) {
        light.set[i] = rmap_strdup(set[i]);
        light.n_set = light.set[i] ? i + 1 : light.n_set;
    }
    if (light.n_set < n_set)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory"));
    RMAP_TRY(rmap_load_scene(&bench->alone, path, &light, &scene->bundle, &scene->scene, err));
    RMAP_TRY(rmap_accel_create(scene->scene, bench->alone.n_thread, &scene->accel, err));
out:
    rmap_scene_options_fini(&light);
    return st;
}

/* Rank 0 alone. */
static enum rmap_status measure_scene(struct rmap_bench *bench, const char *path,
                                      struct rmap_bench_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_bench_load(bench, path, &scene->set, scene->set ? 1 : 0, scene, err));
    if (scene->sizes_only)
        RMAP_TRY(rmap_bench_record(bench, scene, err));
    else if (scene->pictures)
        RMAP_TRY(rmap_bench_render(bench, scene, err));
    else if (scene->timed)
        RMAP_TRY(rmap_bench_timed(bench, scene, path, err));
    else
        RMAP_TRY(measure_alone(bench, path, scene, err));
out:
    rmap_bench_scene_fini(scene);
    return st;
}

static json_t *machine_json(int n_thread)
{
    char model[200] = "unknown", line[300];
    FILE *cpu = fopen("/proc/cpuinfo", "r");
    while (cpu && fgets(line, sizeof line, cpu))
        if (strncmp(line, "model name", 10) == 0 && strchr(line, ':')) {
            (void)snprintf(model, sizeof model, "%.199s", strchr(line, ':') + 2);
            model[strcspn(model, "\n")] = 0;
            break;
        }
    if (cpu)
        (void)fclose(cpu);
    return json_pack("{s:s, s:I, s:i, s:s, s:s, s:s}", "processor", model, "cores",
                     (json_int_t)sysconf(_SC_NPROCESSORS_ONLN), "threads", n_thread, "compiler",
                     RMAP_COMPILER, "version", RMAP_VERSION, "git", RMAP_GIT_REVISION);
}

/* Rank 0: every scene asked for, by itself or (pair not NULL) on the pair. */
static enum rmap_status measure_all(struct rmap_bench *bench, const struct rmap_arguments *given,
                                    const struct rmap_context *pair, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *only = rmap_argument(given, "scene"), *folder = rmap_argument(given, "examples");
    bool more = true;
    char path[600];
    for (size_t i = 0; i < COUNT(known_scene) && st == RMAP_OK; i++) {
        struct rmap_bench_scene scene = known_scene[i];
        if (only && strcmp(only, scene.name) != 0)
            continue;
        if (!wants_scene(bench, &scene) ||
            (pair && (scene.sizes_only || scene.pictures || scene.timed)))
            continue;
        if (!find_scene(folder, scene.folder, path, sizeof path))
            st = rmap_error_set(err, RMAP_INPUT,
                                "the example scenes are not found; say where with --examples "
                                "FOLDER");
        else if (pair)
            st = rmap_bench_pair_round(bench, pair, &scene, path, &more, err);
        else
            st = measure_scene(bench, path, &scene, err);
    }
    return st;
}

/* Collective. */
static enum rmap_status measure_pair(struct rmap_bench *bench, const struct rmap_arguments *given,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK, over;
    struct rmap_context pair = {.comm = MPI_COMM_NULL};
    struct rmap_bench_scene none = {.name = ""};
    bool partner = rmap_argument(given, "partner") != NULL, more = true;
    RMAP_TRY(rmap_bench_pair_open(bench, partner, &pair, err));
    if (pair.comm == MPI_COMM_NULL)
        goto out;
    while (pair.rank == 1 && more && st == RMAP_OK)
        st = rmap_bench_pair_round(bench, &pair, &none, "", &more, err);
    if (pair.rank == 0) {
        struct rmap_error ignored = {0};
        st = measure_all(bench, given, &pair, err);
        more = false;
        over =
            rmap_bench_pair_round(bench, &pair, &none, "", &more, st == RMAP_OK ? err : &ignored);
        st = st == RMAP_OK ? over : st;
    }
out:
    rmap_bench_pair_close(&pair);
    return st;
}

/* Collective. */
static enum rmap_status measure(struct rmap_bench *bench, const struct rmap_arguments *given,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool partner = rmap_argument(given, "partner") != NULL;
    const bool alone = bench->context->rank == 0 && !partner;
    bool sceneless =
        bench->only && (strcmp(bench->only, "ranks_vs_threads") == 0 ||
                        strcmp(bench->only, "gradient_evaluations_vs_seed") == 0 ||
                        rmap_bench_wants_ray_file(bench) || rmap_bench_wants_live(bench));
    RMAP_TRY(make_folder(bench, err));
    if (alone && !sceneless)
        st = measure_all(bench, given, NULL, err);
    if (st == RMAP_OK && alone && !rmap_argument(given, "scene") &&
        rmap_bench_wanted(bench, "gradient_evaluations_vs_seed"))
        st = rmap_bench_gradient(bench, err);
    if (st == RMAP_OK && alone && !rmap_argument(given, "scene") &&
        rmap_bench_wants_ray_file(bench))
        st = rmap_bench_ray_file(bench, err);
    if (st == RMAP_OK && alone && !rmap_argument(given, "scene") && rmap_bench_wants_live(bench))
        st = rmap_bench_live(bench, err);
    RMAP_TRY(rmap_agree_patiently(bench->context, st, err));
    if (partner || rmap_bench_wanted(bench, "ranks_vs_threads"))
        st = measure_pair(bench, given, err);
    RMAP_TRY(rmap_agree_patiently(bench->context, st, err));
out:
    return st;
}

enum rmap_status rmap_bench_run(const struct rmap_context *context,
                                const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_context quiet = *context;
    quiet.quiet = true;
    struct rmap_bench bench = {.context = &quiet, .alone = quiet, .results = json_array()};
    bench.alone.json = false; /* what it calls says nothing: the document is the bench's own */
    bench.alone.comm = MPI_COMM_NULL;
    bench.alone.rank = 0;
    bench.alone.size = 1;
    if (context->size > 1) /* as one rank would have had */
        bench.alone.n_thread = rmap_workers_available();
    enum rmap_status st = read_request(given, &bench, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Comm_split(context->comm, context->rank, 0, &bench.alone.comm)));
    RMAP_TRY(measure(&bench, given, err));
    if (context->rank == 0 && context->json)
        st = rmap_json_print(json_pack("{s:o, s:O}", "machine", machine_json(bench.alone.n_thread),
                                       "results", bench.results),
                             stdout, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    if (context->rank == 0 && bench.folder[0])
        (void)nftw(bench.folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    if (bench.alone.comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&bench.alone.comm);
    json_decref(bench.results);
    return st;
}
