/* SPDX-License-Identifier: MIT
 *
 * A sweep on all ranks.
 */
#include "mpi/sweep/sweep_run.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/progress.h"
#include "mpi/sweep/sweep_answers.h"
#include "mpi/sweep/sweep_folder.h"
#include "mpi/trace/trace_held.h"
#include "mpi/trace/trace_session.h"

enum { ROW_NBYTES = 128, UNPAID_MAX = 3 }; /* about; tries, before it is given up */
struct group {
    struct rmap_sweep_run *run;
    struct rmap_context context; /* of its ranks; of all at first */
    MPI_Comm own;                /* MPI_COMM_NULL: none yet */
    int number, n_group;
    int isa_level;
    bool shares_files;
    struct rmap_accel *accel; /* of the variant before; NULL: none */
    struct rmap_map *last;    /* of the variant before, whose rays are taken over; NULL: none */
    struct rmap_bundle *last_bundle;
    char *last_path; /* of the map before; NULL: none */
    int n_unpaid;    /* maps in a row that had to trace all anew */
    int n_failed;    /* variants without answers, before the first that has */
    uint64_t n_done;
    struct rmap_sweep_journal journal; /* on its rank 0 */
};

/* Collective. Rows of before; all ranks are one group. */
static enum rmap_status begin(struct rmap_sweep_run *run, struct group *group,
                              struct rmap_error *err)
{
    const struct rmap_context *context = run->context;
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0)
        st = rmap_sweep_folder_prepare(run, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = rmap_sweep_folder_rows(run, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Bcast(run->table.is_known, (int)run->sweep->n_variant, MPI_C_BOOL, 0, context->comm)));
    group->context = *context;
    group->context.watchdog = NULL;
    group->context.quiet = true;
    group->context.json = false;
    RMAP_TRY(rmap_common_isa(context, &group->isa_level, err));
    group->shares_files = rmap_sweep_shares_files(run->sweep, run->bundle);
    if (context->rank == 0)
        st = rmap_sweep_journal_open(group->run, group->number, &group->journal, err);
    st = rmap_agree(context, st, err);
out:
    return st;
}

/* The options of the nominal scene with a variant's edits behind its own; its texts are borrowed.
 */
static enum rmap_status edit(const struct rmap_scene_options *nominal, char *simulation,
                             char *const *set, size_t n, struct rmap_scene_options *options,
                             struct rmap_error *err)
{
    *options = *nominal;
    options->simulation = simulation;
    options->set = rmap_alloc(nominal->n_set + n + 1, sizeof(char *));
    if (!options->set)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a variant");
    for (size_t i = 0; i < nominal->n_set; i++)
        options->set[i] = nominal->set[i];
    for (size_t i = 0; i < n; i++)
        options->set[nominal->n_set + i] = set[i];
    options->n_set = nominal->n_set + n;
    return RMAP_OK;
}

/* On rank 0 all mistakes of a variant that is no scene; err says the first. */
static void tell(const struct group *group, enum rmap_status st,
                 const struct rmap_diagnostics *found, struct rmap_error *err)
{
    if (st == RMAP_OK || group->context.rank != 0)
        return;
    rmap_diagnostics_print(found, stderr);
    for (size_t i = 0; st == RMAP_INPUT && i < found->n; i++)
        if (found->item[i].severity == RMAP_SEVERITY_ERROR) {
            (void)rmap_error_set(err, RMAP_INPUT, "%s", found->item[i].text);
            return;
        }
}

/* Collective in the group. The scene from its files, as `raymap trace --set` reads it. */
static enum rmap_status load(const struct group *group, const struct rmap_scene_options *with,
                             struct rmap_bundle **bundle, struct rmap_scene **scene,
                             struct rmap_error *err)
{
    struct rmap_scene_options own = {.allows_plugins = with->allows_plugins,
                                     .before = group->run->bundle,
                                     .read_map = with->read_map};
    struct rmap_diagnostics found;
    enum rmap_status st =
        rmap_agree(&group->context, rmap_scene_options_choose(&own, with, err), err);
    if (st != RMAP_OK) {
        rmap_scene_options_fini(&own);
        return st;
    }
    rmap_diagnostics_init(&found, group->run->scene_path);
    st = rmap_load_scene_told(&group->context, group->run->scene_path, &own, &found, bundle, scene,
                              err);
    tell(group, st, &found, err);
    rmap_diagnostics_fini(&found);
    return st;
}

/* Collective in the group. From the bundle that is there: its meshes are read once for all
 * variants. */
static enum rmap_status read_again(const struct group *group,
                                   const struct rmap_scene_options *options,
                                   struct rmap_scene **scene, struct rmap_error *err)
{
    struct rmap_diagnostics diagnostics;
    struct rmap_bundle with = *group->run->bundle; /* complete: nothing is added to it */
    with.options = *options;
    rmap_diagnostics_init(&diagnostics, with.path);
    const enum rmap_status st = rmap_scene_read(&with, scene, &diagnostics, err);
    tell(group, st, &diagnostics, err);
    rmap_diagnostics_fini(&diagnostics);
    return rmap_agree(&group->context, st, err);
}

static void drop_last(struct group *group)
{
    rmap_map_close(group->last);
    rmap_bundle_destroy(group->last_bundle);
    rmap_free(group->last_path);
    group->last = NULL;
    group->last_bundle = NULL;
    group->last_path = NULL;
}

/* Collective. */
static enum rmap_status split(struct group *group, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = group->run->context;
    const uint64_t n = group->run->sweep->n_variant, size = (uint64_t)context->size;
    MPI_Comm comm = MPI_COMM_NULL;
    if (context->size > 1)
        drop_last(group); /* its rays are dealt to all ranks */
    group->n_group = (int)(n < size ? n : size);
    group->number = (int)((uint64_t)context->rank * (uint64_t)group->n_group / size);
    RMAP_TRY(RMAP_MPI(MPI_Comm_split(context->comm, group->number, context->rank, &comm)));
    group->context.comm = group->own = comm;
    (void)MPI_Comm_rank(comm, &group->context.rank);
    (void)MPI_Comm_size(comm, &group->context.size);
    if (group->context.rank == 0 && group->number > 0)
        st = rmap_sweep_journal_open(group->run, group->number, &group->journal, err);
    st = rmap_agree(context, st, err);
out:
    return st;
}

/* Collective in the group. A map on disk, as `raymap trace` makes it. */
static enum rmap_status trace_map(struct group *group, uint64_t variant,
                                  const struct rmap_scene_options *options, struct rmap_map **map,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_sweep_run *run = group->run;
    char *path =
        rmap_path_format("%s/variant-%06llu.raymap", run->folder, (unsigned long long)variant);
    const char *from_path = group->n_unpaid < UNPAID_MAX ? group->last_path : NULL;
    struct rmap_trace_session session = {.context = &group->context,
                                         .begun = rmap_clock_seconds(),
                                         .request = {.map_path = path,
                                                     .from_path = from_path,
                                                     .mode = RMAP_TRACE_NEW,
                                                     .n_ray = run->sweep->n_ray,
                                                     .has_n_ray = true,
                                                     .force = true,
                                                     .seed = run->sweep->seed,
                                                     .has_seed = true,
                                                     .piece_nbytes = UINT64_C(64) << 30,
                                                     .encoding = RMAP_ENCODING_COMPACT}};
    if (!path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a map");
    RMAP_TRY(rmap_agree(&group->context, st, err));
    RMAP_TRY(load(group, options, &session.bundle, &session.scene, err));
    RMAP_TRY(rmap_trace_from_open(&group->context, &session.request, &session.from, err));
    const double begun = rmap_clock_seconds();
    run->times.scenes += begun - session.begun;
    RMAP_TRY(rmap_trace_session_begin(&session, err));
    RMAP_TRY(rmap_trace_session_run(&session, err));
    RMAP_TRY(rmap_trace_session_conclude(&session, err));
    run->times.tracing += rmap_clock_seconds() - begun;
    if (group->context.rank == 0)
        run->n_reused += session.outcome.n_reused;
    if (from_path)
        group->n_unpaid = session.from.in_use ? 0 : group->n_unpaid + 1;
    st = rmap_load_map(&group->context, path, map, err);
    rmap_free(group->last_path);
    group->last_path = path;
    path = NULL;
out:
    rmap_trace_session_fini(&session);
    rmap_free(path);
    return st;
}

/* The time since then is spent. */
static void pass(double *since, double *spent)
{
    const double now = rmap_clock_seconds();
    *spent += now - *since;
    *since = now;
}

/* The rays of a variant, for the next one, unless two of them may be too many. */
static void keep_last(struct group *group, struct rmap_map **map, struct rmap_bundle **bundle)
{
    const uint64_t *n_row = rmap_map_contents(*map)->n_row;
    double nbytes = 0.0;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        nbytes += (double)ROW_NBYTES * (double)n_row[t] / (double)group->context.size;
    if (group->run->sweep->keeps_maps || nbytes > 0.5 * (double)RMAP_HELD_NBYTES_MAX)
        return;
    drop_last(group);
    group->last = *map;
    group->last_bundle = *bundle;
    *map = NULL;
    *bundle = NULL;
}

/* Collective in the group. */
static enum rmap_status run_variant(struct group *group, uint64_t variant, struct rmap_error *err)
{
    struct rmap_sweep_run *run = group->run;
    struct rmap_scene_options options = {.set = NULL};
    struct rmap_trace_held held = {.seed = run->sweep->seed,
                                   .n_ray = run->sweep->n_ray,
                                   .isa_level = group->isa_level,
                                   .from = group->last,
                                   .accel = &group->accel};
    struct rmap_bundle *own = NULL;
    struct rmap_map *map = NULL;
    char **set = NULL;
    size_t n_set = 0;
    char *simulation = rmap_strdup(rmap_sweep_simulation(run->sweep, variant));
    double *part = rmap_alloc(run->sweep->n_answer * RMAP_SWEEP_PARTS, sizeof *part);
    double begun = rmap_clock_seconds();
    enum rmap_status st = part ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (st == RMAP_OK)
        st = rmap_sweep_settings(run->sweep, variant, &set, &n_set, err);
    if (st == RMAP_OK)
        st = edit(&run->bundle->options, simulation, set, n_set, &options, err);
    RMAP_TRY(rmap_agree(&group->context, st, err));
    if (run->sweep->keeps_maps) {
        RMAP_TRY(trace_map(group, variant, &options, &map, err));
    } else {
        RMAP_TRY(group->shares_files ? read_again(group, &options, &held.scene, err)
                                     : load(group, &options, &own, &held.scene, err));
        pass(&begun, &run->times.scenes);
        RMAP_TRY(rmap_trace_held(&group->context, &held, &map, err));
        pass(&begun, &run->times.trees);
        run->times.tracing += held.seconds;
        run->times.trees -= held.seconds;
        run->n_reused += held.n_reused;
    }
    begun = rmap_clock_seconds();
    RMAP_TRY(rmap_sweep_ask(&group->context, run->sweep, map,
                            run->table.result + variant * run->sweep->n_answer, part, err));
    if (group->context.rank == 0) {
        rmap_sweep_row_differ(&run->table, variant, part);
        st = rmap_sweep_journal_commit(run, &group->journal, variant, err);
    }
    pass(&begun, &run->times.answers);
    keep_last(group, &map, &own);
    st = rmap_agree(&group->context, st, err);
out:
    if (st != RMAP_OK && n_set > 0 && strncmp(err->text, "--set ", 6) != 0)
        rmap_error_context(err, "--set %s", set[0]);
    if (st != RMAP_OK)
        rmap_error_context(err, "variant %llu", (unsigned long long)variant);
    rmap_map_close(map);
    rmap_scene_destroy(held.scene);
    rmap_bundle_destroy(own);
    rmap_free(part);
    rmap_free(simulation);
    rmap_free(options.set);
    rmap_sweep_settings_free(set, n_set);
    return st;
}

/* Collective in the group. A variant that is no scene has a row that says so. */
static enum rmap_status run_or_fail(struct group *group, uint64_t variant, struct rmap_error *err)
{
    struct rmap_sweep_run *run = group->run;
    enum rmap_status st = run_variant(group, variant, err);
    if (st != RMAP_INPUT)
        return st;
    st = RMAP_OK;
    if (group->context.rank == 0) {
        fprintf(stderr, "raymap: %s; its row has no answers\n", err->text);
        st = rmap_sweep_row_fail(&run->table, variant, err->text, err);
        if (st == RMAP_OK)
            st = rmap_sweep_journal_commit(run, &group->journal, variant, err);
    }
    return rmap_agree(&group->context, st, err);
}

/* Collective. By all ranks, who then know what the differences of the others are to. */
static enum rmap_status run_nominal(struct group *group, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_sweep_table *table = &group->run->table;
    const size_t n = group->run->sweep->n_answer;
    if (!table->is_known[0])
        RMAP_TRY(run_variant(group, 0, err));
    table->is_known[0] = true;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(table->nominal_part, (int)(n * RMAP_SWEEP_PARTS), MPI_DOUBLE, 0,
                                group->context.comm)));
out:
    return st;
}

/* Collective in the group: its variants, every n_group-th of those that are missing. */
static enum rmap_status run_group(struct group *group, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_sweep_run *run = group->run;
    struct rmap_progress progress;
    uint64_t missing = 0, seen = 0, done = 0;
    for (uint64_t v = 0; v < run->sweep->n_variant; v++)
        missing += !run->table.is_known[v];
    rmap_progress_init(&progress, run->context, "variants", missing);
    for (uint64_t v = 0; v < run->sweep->n_variant && st == RMAP_OK; v++) {
        if (run->table.is_known[v] || seen++ % (uint64_t)group->n_group != (uint64_t)group->number)
            continue;
        int stops = rmap_interrupt_caught() != 0;
        RMAP_TRY(RMAP_MPI(
            MPI_Allreduce(MPI_IN_PLACE, &stops, 1, MPI_INT, MPI_MAX, group->context.comm)));
        if (stops)
            st = rmap_error_set(err, RMAP_STOPPED,
                                "stopped; --resume goes on with the variants that are missing");
        else
            st = run_or_fail(group, v, err);
        done += (uint64_t)group->n_group;
        rmap_progress_show(&progress, done < missing ? done : missing);
    }
out:
    rmap_progress_fini(&progress);
    return st;
}

enum rmap_status rmap_sweep_run(struct rmap_sweep_run *run, struct rmap_error *err)
{
    struct group group = {.run = run, .journal = {.file = -1}, .own = MPI_COMM_NULL};
    const double begun = rmap_clock_seconds();
    enum rmap_status st = rmap_sweep_table_init(&run->table, run->sweep, err);
    RMAP_TRY(rmap_agree(run->context, st, err));
    RMAP_TRY(begin(run, &group, err));
    RMAP_TRY(run_nominal(&group, err));
    RMAP_TRY(split(&group, err));
    st = run_group(&group, err);
    if (st == RMAP_OK)
        st = rmap_sweep_journal_close(run, &group.journal, err);
    run->times.all = rmap_clock_seconds() - begun;
    RMAP_TRY(rmap_agree_patiently(run->context, st, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &run->n_reused, 1, MPI_UINT64_T, MPI_SUM, run->context->comm)));
    if (run->context->rank == 0) {
        st = rmap_sweep_folder_rows(run, err);
        if (st == RMAP_OK && run->sweep->n_variant > 1 &&
            rmap_sweep_n_failed(&run->table) == run->sweep->n_variant - 1)
            st = rmap_error_set(err, RMAP_INPUT, "no variant has answers; the first: %.400s",
                                run->table.mistake[1]);
    }
    st = rmap_agree(run->context, st, err);
out:
    rmap_accel_destroy(group.accel);
    drop_last(&group);
    struct rmap_error second;
    (void)!rmap_sweep_journal_close(run, &group.journal, &second);
    if (group.own != MPI_COMM_NULL)
        (void)MPI_Comm_free(&group.own);
    return st;
}
