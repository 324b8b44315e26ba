/* SPDX-License-Identifier: MIT
 *
 * A sweep on all ranks.
 */
#include "mpi/sweep/sweep_run.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/text_file.h"
#include "io/file/whole_file.h"
#include "io/map/map_directory.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/progress.h"
#include "mpi/sweep/sweep_answers.h"
#include "mpi/trace/trace_held.h"
#include "mpi/trace/trace_session.h"

static const struct rmap_text_kind sweep_copy = {"the sweep that a folder holds", NULL, "",
                                                 (size_t)1 << 26};
enum { ROW_NBYTES = 128, UNPAID_MAX = 3 }; /* about; tries, before it is given up */
static const double sync_s =
    5.0; /* what a crash of the machine loses; a killed program loses none */

struct group {
    struct rmap_sweep_run *run;
    struct rmap_context context; /* of its ranks; of all at first */
    MPI_Comm own;                /* MPI_COMM_NULL: none yet */
    int number, n_group;
    int isa_level;
    bool shares_files;
    struct rmap_map *last; /* of the variant before, whose rays are taken over; NULL: none */
    struct rmap_bundle *last_bundle;
    char *last_path; /* of the map before; NULL: none */
    int n_unpaid;    /* maps in a row that had to trace all anew */
    int journal;     /* descriptor, on its rank 0; -1 */
    double synced;
};

/* The first line in which two texts differ. */
static enum rmap_status check_same(const char *folder, const char *before, const char *now,
                                   struct rmap_error *err)
{
    for (int line = 1; *before || *now; line++) {
        const size_t a = strcspn(before, "\n"), b = strcspn(now, "\n");
        if (a != b || memcmp(before, now, a) != 0)
            return rmap_error_set(err, RMAP_INPUT,
                                  "%s holds another sweep: line %d was '%.*s' and is '%.*s'; give "
                                  "another -o, or bring the line back",
                                  folder, line, (int)(a < 80 ? a : 80), before,
                                  (int)(b < 80 ? b : 80), now);
        before += a + (before[a] == '\n');
        now += b + (now[b] == '\n');
    }
    return RMAP_OK;
}

/* What must be the same for rows to be of one sweep: its file, and the scene. */
static char *state_of(const struct rmap_sweep_run *run)
{
    const struct rmap_bundle *bundle = run->bundle;
    size_t n = strlen(run->sweep->text) + bundle->text_nbytes + 64;
    for (size_t i = 0; i < bundle->options.n_set; i++)
        n += strlen(bundle->options.set[i]) + 8;
    char *text = rmap_alloc(n, 1);
    size_t used = 0;
    if (!text)
        return NULL;
    for (size_t i = 0; i < bundle->options.n_set; i++)
        used += (size_t)snprintf(text + used, n - used, "--set %s\n", bundle->options.set[i]);
    (void)snprintf(text + used, n - used, "%s\n--- scene\n%s", run->sweep->text, bundle->text);
    return text;
}

struct cleared {
    const char *folder;
};

/* What a sweep wrote there, and nothing else. */
static enum rmap_status remove_result(void *context, int directory, const char *name,
                                      struct rmap_error *err)
{
    const char *folder = ((const struct cleared *)context)->folder;
    static const char *const file[] = {"sweep.txt", "table.csv", "table.h5", "plot.svg"};
    enum rmap_status st = RMAP_OK;
    bool goes = rmap_directory_number(name, "rows-", ".jsonl") >= 0;
    for (size_t i = 0; i < sizeof file / sizeof *file; i++)
        goes = goes || strcmp(name, file[i]) == 0;
    if (goes && unlinkat(directory, name, 0) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s/%s cannot be removed: %s", folder, name,
                              strerror(errno));
    const size_t len = strlen(name);
    if (strncmp(name, "variant-", 8) == 0 && len > 7 && strcmp(name + len - 7, ".raymap") == 0) {
        char *path = rmap_path_format("%s/%s", folder, name);
        st = path ? rmap_map_remove(path, err)
                  : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path");
        rmap_free(path);
    }
    return st;
}

static enum rmap_status clear(const char *folder, struct rmap_error *err)
{
    struct stat info;
    struct cleared cleared = {folder};
    const enum rmap_status st = rmap_path_look(folder, &info, err);
    if (st != RMAP_OK || info.st_mode == 0)
        return st;
    return rmap_directory_visit(folder, remove_result, &cleared, err);
}

/* Rank 0. */
static enum rmap_status prepare_folder(const struct rmap_sweep_run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *state = state_of(run), *path = rmap_path_format("%s/sweep.txt", run->folder);
    char *before = NULL;
    size_t nbytes = 0;
    struct stat info;
    if (!state || !path)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sweep"));
    if (run->is_forced)
        RMAP_TRY(clear(run->folder, err));
    RMAP_TRY(rmap_path_look(path, &info, err));
    if (info.st_mode != 0 && !run->is_resumed)
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s holds a sweep already: --resume goes on with it, --force "
                                "begins anew, or give another -o",
                                run->folder));
    if (info.st_mode != 0) {
        RMAP_TRY(rmap_text_file_read(path, &sweep_copy, &before, &nbytes, err));
        RMAP_TRY(check_same(run->folder, before, state, err));
        goto out;
    }
    if (mkdir(run->folder, 0777) != 0 && errno != EEXIST)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "%s cannot be made: %s", run->folder,
                                strerror(errno)));
    st = rmap_whole_file_put_bytes(path, state, strlen(state), err);
out:
    rmap_free(before);
    rmap_free(state);
    rmap_free(path);
    return st;
}

struct journals {
    struct rmap_sweep_run *run;
};

/* A line that was cut off, the last one, is no JSON and counts for nothing. */
static enum rmap_status read_journal(void *context, int directory, const char *name,
                                     struct rmap_error *err)
{
    struct journals *self = context;
    char *text = NULL, *path = NULL;
    size_t nbytes = 0;
    struct stat info;
    enum rmap_status st = RMAP_OK;
    if (rmap_directory_number(name, "rows-", ".jsonl") < 0 ||
        fstatat(directory, name, &info, 0) != 0 || info.st_size == 0)
        return RMAP_OK;
    path = rmap_path_format("%s/%s", self->run->folder, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a journal");
    RMAP_TRY(rmap_text_file_read(path, &sweep_copy, &text, &nbytes, err));
    for (const char *line = text; *line;) {
        const size_t n = strcspn(line, "\n");
        if (line[n] == '\n')
            rmap_sweep_row_take(&self->run->table, line, n);
        line += n + (line[n] == '\n');
    }
out:
    rmap_free(text);
    rmap_free(path);
    return st;
}

/* On the first rank of a group. */
static enum rmap_status open_journal(struct group *group, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *folder = group->run->folder;
    char *path = rmap_path_format("%s/rows-%05d.jsonl", folder, group->number);
    group->journal = path ? open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666) : -1;
    if (group->journal < 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s cannot be written to: %s", folder,
                            strerror(errno));
    else if (lseek(group->journal, 0, SEEK_END) > 0) /* behind a line that was cut off */
        (void)!write(group->journal, "\n", 1);
    rmap_free(path);
    return st;
}

/* Collective. Rows of before; all ranks are one group. */
static enum rmap_status begin(struct rmap_sweep_run *run, struct group *group,
                              struct rmap_error *err)
{
    const struct rmap_context *context = run->context;
    struct journals journals = {run};
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0)
        st = prepare_folder(run, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = rmap_directory_visit(run->folder, read_journal, &journals, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Bcast(run->table.is_known, (int)run->sweep->n_variant, MPI_C_BOOL, 0, context->comm)));
    group->context = *context;
    group->context.watchdog = NULL;
    group->context.quiet = true;
    group->context.json = false;
    RMAP_TRY(rmap_common_isa(context, &group->isa_level, err));
    group->shares_files = rmap_sweep_shares_files(run->sweep, run->bundle);
    if (context->rank == 0)
        st = open_journal(group, err);
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

/* Copies of a list of texts. */
static enum rmap_status copy_list(char *const *from, size_t n, char ***to, size_t *n_to,
                                  struct rmap_error *err)
{
    *to = rmap_alloc(n + 1, sizeof(char *));
    for (size_t i = 0; *to && i < n; i++, *n_to = i)
        if (!((*to)[i] = rmap_strdup(from[i])))
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a variant");
    return *to ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a variant");
}

/* Collective in the group. The scene from its files, as `raymap trace --set` reads it. */
static enum rmap_status load(const struct group *group, const struct rmap_scene_options *with,
                             struct rmap_bundle **bundle, struct rmap_scene **scene,
                             struct rmap_error *err)
{
    struct rmap_scene_options own = {.simulation = rmap_strdup(with->simulation),
                                     .color = rmap_strdup(with->color),
                                     .allows_plugins = with->allows_plugins,
                                     .read_map = with->read_map};
    enum rmap_status st = copy_list(with->set, with->n_set, &own.set, &own.n_set, err);
    if (st == RMAP_OK)
        st = copy_list(with->only, with->n_only, &own.only, &own.n_only, err);
    if (st == RMAP_OK)
        st = copy_list(with->without, with->n_without, &own.without, &own.n_without, err);
    st = rmap_agree(&group->context, st, err);
    if (st != RMAP_OK) {
        rmap_scene_options_fini(&own);
        return st;
    }
    return rmap_load_scene(&group->context, group->run->scene_path, &own, bundle, scene, err);
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
    if (st != RMAP_OK && group->context.rank == 0)
        rmap_diagnostics_print(&diagnostics, stderr);
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
        st = open_journal(group, err);
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

/* A row is written in one go: what a killed program leaves is whole rows and at most a part of one.
 */
static enum rmap_status commit(struct group *group, uint64_t variant, struct rmap_error *err)
{
    char *row = rmap_sweep_row_line(&group->run->table, variant);
    char *line = row ? rmap_path_format("%s\n", row) : NULL;
    enum rmap_status st = RMAP_OK;
    if (!line)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a row");
    else if (write(group->journal, line, strlen(line)) != (ssize_t)strlen(line))
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: a row cannot be written: %s", group->run->folder,
                            strerror(errno));
    if (st == RMAP_OK && rmap_clock_seconds() - group->synced > sync_s) {
        (void)fdatasync(group->journal);
        group->synced = rmap_clock_seconds();
    }
    rmap_free(line);
    rmap_free(row);
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
    struct rmap_scene *scene = NULL;
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
        RMAP_TRY(group->shares_files ? read_again(group, &options, &scene, err)
                                     : load(group, &options, &own, &scene, err));
        pass(&begun, &run->times.scenes);
        const double before = run->times.tracing;
        RMAP_TRY(rmap_trace_held(&group->context, group->last, &scene, run->sweep->seed,
                                 run->sweep->n_ray, group->isa_level, &map, &run->times.tracing,
                                 &run->n_reused, err));
        pass(&begun, &run->times.trees);
        run->times.trees -= run->times.tracing - before;
    }
    begun = rmap_clock_seconds();
    RMAP_TRY(rmap_sweep_ask(&group->context, run->sweep, map,
                            run->table.result + variant * run->sweep->n_answer, part, err));
    if (group->context.rank == 0) {
        rmap_sweep_row_differ(&run->table, variant, part);
        st = commit(group, variant, err);
    }
    pass(&begun, &run->times.answers);
    keep_last(group, &map, &own);
    st = rmap_agree(&group->context, st, err);
out:
    if (st != RMAP_OK)
        rmap_error_context(err, "variant %llu%s%s", (unsigned long long)variant,
                           n_set ? ", --set " : "", n_set ? set[0] : "");
    rmap_map_close(map);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(own);
    rmap_free(part);
    rmap_free(simulation);
    rmap_free(options.set);
    rmap_sweep_settings_free(set, n_set);
    return st;
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
            st = run_variant(group, v, err);
        done += (uint64_t)group->n_group;
        rmap_progress_show(&progress, done < missing ? done : missing);
    }
out:
    rmap_progress_fini(&progress);
    return st;
}

enum rmap_status rmap_sweep_run(struct rmap_sweep_run *run, struct rmap_error *err)
{
    struct group group = {.run = run, .journal = -1, .own = MPI_COMM_NULL};
    struct journals journals = {run};
    const double begun = rmap_clock_seconds();
    enum rmap_status st = rmap_sweep_table_init(&run->table, run->sweep, err);
    RMAP_TRY(rmap_agree(run->context, st, err));
    RMAP_TRY(begin(run, &group, err));
    RMAP_TRY(run_nominal(&group, err));
    RMAP_TRY(split(&group, err));
    st = run_group(&group, err);
    if (group.journal >= 0 && (fdatasync(group.journal) | close(group.journal)) != 0 &&
        st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: rows cannot be written: %s", run->folder,
                            strerror(errno));
    group.journal = -1;
    run->times.all = rmap_clock_seconds() - begun;
    RMAP_TRY(rmap_agree_patiently(run->context, st, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &run->n_reused, 1, MPI_UINT64_T, MPI_SUM, run->context->comm)));
    if (run->context->rank == 0)
        st = rmap_directory_visit(run->folder, read_journal, &journals, err);
    st = rmap_agree(run->context, st, err);
out:
    drop_last(&group);
    if (group.journal >= 0)
        (void)close(group.journal);
    if (group.own != MPI_COMM_NULL)
        (void)MPI_Comm_free(&group.own);
    return st;
}
