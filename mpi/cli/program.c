/* SPDX-License-Identifier: MIT
 *
 * MPI_COMM_WORLD and MPI_Finalize stand here alone.
 */
#define _DEFAULT_SOURCE /* madvise */
#include "mpi/cli/program.h"

#include <mpi.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/mman.h>
#endif

#include "io/export/json_memory.h"
#include "io/file/diagnostics.h"
#include "io/hdf5/h5_process.h"
#include "mpi/cli/manual.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/load.h"
#include "mpi/command/version_text.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/terminal.h"
#include "mpi/parallel/threads.h"
#include "mpi/parallel/watchdog.h"
#include "mpi/session/session_words.h"

enum { COMMANDS_MAX = 32 };

/* What the program can do. */
struct commands {
    const struct rmap_command *const *list;
    size_t n;
};

static void print_overview(const struct commands *known, FILE *out)
{
    fputs("usage: raymap COMMAND [options] ...      alone, or under mpirun -np N\n\n"
          "Traces light through a scene, keeps every ray's whole history in a ray map, and\n"
          "answers questions about those histories.\n\ncommands:\n",
          out);
    for (size_t i = 0; i < known->n; i++)
        fprintf(out, "  %-10s %s\n", known->list[i]->name, known->list[i]->summary);
    fputs("\nraymap COMMAND --help says more; raymap --version names the libraries.\n", out);
}

static enum rmap_status find_command(const struct commands *known, const char *name,
                                     const struct rmap_command **found, struct rmap_error *err)
{
    const char *word[COMMANDS_MAX] = {NULL};
    size_t n = known->n < COMMANDS_MAX ? known->n : COMMANDS_MAX;
    for (size_t i = 0; i < n; i++) {
        word[i] = known->list[i]->name;
        if (strcmp(word[i], name) == 0) {
            *found = known->list[i];
            return RMAP_OK;
        }
    }
    const char *nearest = rmap_nearest_word(name, word, n);
    if (nearest)
        return rmap_error_set(err, RMAP_USAGE, "no command '%s' (did you mean '%s'?)", name,
                              nearest);
    return rmap_error_set(err, RMAP_USAGE, "no command '%s'; see: raymap --help", name);
}

/* Collective. Reads the common options, then hands over to the command. */
static enum rmap_status run_command(struct rmap_context *context, const struct rmap_command *chosen,
                                    int argc, char **argv, struct rmap_error *err)
{
    struct rmap_arguments given = {0};
    enum rmap_status st = rmap_arguments_parse(chosen, argc, argv, &given, err);
    uint64_t n_thread = (uint64_t)rmap_threads_share(context->comm);
    if (st == RMAP_OK)
        st = rmap_argument_count(&given, "threads", &n_thread, err);
    if (st == RMAP_OK && (n_thread < 1 || n_thread > 4096))
        st = rmap_error_set(err, RMAP_USAGE, "--threads must lie between 1 and 4096");
    RMAP_TRY(rmap_agree(context, st, err));
    context->n_thread = (int)n_thread;
    context->json = rmap_argument(&given, "json") != NULL;
    context->quiet = rmap_argument(&given, "quiet") != NULL;
    context->cache = rmap_argument(&given, "cache");
    if (!context->cache)
        context->cache = getenv("RAYMAP_CACHE");
    if (context->cache && !context->cache[0])
        context->cache = NULL;
    if (!rmap_argument(&given, "help"))
        st = chosen->run(context, &given, err);
    else if (context->rank == 0)
        rmap_arguments_help(chosen, stdout);
out:
    rmap_arguments_fini(&given);
    return st;
}

/* `raymap help --man [COMMAND]` and `help --completion` are what the build installs. */
static void print_help(const struct commands *known, const char *form, const char *name, FILE *out)
{
    for (size_t i = 0; name && strcmp(form, "--man") == 0 && i < known->n; i++)
        if (strcmp(known->list[i]->name, name) == 0) {
            rmap_manual_print_command(known->list[i], out);
            return;
        }
    if (strcmp(form, "--man") == 0)
        rmap_manual_print(known->list, known->n, out);
    else if (strcmp(form, "--completion") == 0)
        rmap_completion_print(known->list, known->n, out);
    else
        print_overview(known, out);
}

/* Collective. `raymap help --names detectors MAP`, of which the completion is made. */
static enum rmap_status print_names(const struct rmap_context *context, const char *kind,
                                    const char *path, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    const enum rmap_status st = rmap_load_map(context, path, &map, err);
    if (st == RMAP_OK && context->rank == 0)
        rmap_session_names_list(rmap_map_scene(map), kind, stdout);
    rmap_map_close(map);
    return st;
}

/* Collective. */
static enum rmap_status dispatch(struct rmap_context *context, const struct commands *known,
                                 int argc, char **argv, struct rmap_error *err)
{
    const char *word = argc > 1 ? argv[1] : "";
    const struct rmap_command *chosen = NULL;
    if (strcmp(word, "help") == 0 && argc > 2 && argv[2][0] != '-') {
        enum rmap_status st = find_command(known, argv[2], &chosen, err);
        if (st == RMAP_OK && context->rank == 0)
            rmap_arguments_help(chosen, stdout);
        return st;
    }
    if (strcmp(word, "help") == 0 && argc == 5 && strcmp(argv[2], "--names") == 0)
        return print_names(context, argv[3], argv[4], err);
    bool help = strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0;
    if (help || strcmp(word, "--version") == 0) {
        if (context->rank == 0 && help)
            print_help(known, argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : NULL, stdout);
        else if (context->rank == 0)
            rmap_version_print(stdout);
        return RMAP_OK;
    }
    if (!*word) {
        if (context->rank == 0)
            print_overview(known, stderr);
        return rmap_error_set(err, RMAP_USAGE, "no command given");
    }
    enum rmap_status st = find_command(known, word, &chosen, err);
    return st == RMAP_OK ? run_command(context, chosen, argc - 1, argv + 1, err) : st;
}

/* What rank 0 could not write, to a full disk or a closed pipe, nobody has read. */
static enum rmap_status flush_output(const struct rmap_context *context, enum rmap_status st,
                                     struct rmap_error *err)
{
    if (context->rank == 0 && (fflush(stdout) != 0 || ferror(stdout)) && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot write to standard output");
    return rmap_agree(context, st, err);
}

/* From the start: a batch system's signal may come while ranks still find each other, read a scene,
 * or take in what a killed run left. */
static void watch_signals(const struct commands *known, const char *word)
{
    for (size_t i = 0; i < known->n; i++)
        if (known->list[i]->stops_in_order && strcmp(word, known->list[i]->name) == 0)
            rmap_interrupt_watch();
}

/* What no rank uses takes a tenth of its start: windows of memory, collectives that are off unless
 * somebody asks for them, hwloc's plugins, which call at X servers. */
static void leave_out_unused(void)
{
    (void)setenv("OMPI_MCA_osc", "^monitoring,sm,rdma,pt2pt,ucx", 0);
    (void)setenv("OMPI_MCA_coll", "^monitoring,sync,sm", 0);
    (void)setenv("HWLOC_PLUGINS_PATH", "/nonexistent", 0);
}

static bool is_alone(void)
{
    return !getenv("OMPI_COMM_WORLD_SIZE") && !getenv("PMIX_RANK") && !getenv("PMI_RANK");
}

/* Started without mpirun. Open MPI would start a daemon beside the one process, for half a second
 * and for nothing, and make a folder in /tmp/ompi.HOST.UID that another process may be removing at
 * that moment: of 160 starts, 4 at a time, 2 died so in MPI_Init. It would load the drivers of all
 * network cards, some of which measure a clock for 0.2 s, and what only ranks beside each other
 * can use; hwloc would read the whole machine, which nobody places ranks on. All this is a third of
 * a short command's time.
 * Only `bench` needs these, to start a second rank, and TCP between the two: false of it. */
static bool prepare_alone(const char *word)
{
    static const char *const setting[][2] = {
        {"OMPI_MCA_ess_singleton_isolated", "1"},
        {"OMPI_MCA_orte_create_session_dirs", "0"},
        {"OMPI_MCA_pml", "ob1"},
        {"OMPI_MCA_btl", "self"},
        {"OMPI_MCA_coll", "self,basic,libnbc"},
        {"OMPI_MCA_errmgr", "default_app"},
        {"OMPI_MCA_state", "app"},
        {"OMPI_MCA_shmem", "mmap"},
        {"OMPI_MCA_reachable", "weighted"},
        {"HWLOC_COMPONENTS", "no_os,stop"},
    };
    if (strcmp(word, "bench") == 0) {
        (void)unsetenv("OMPI_MCA_btl");
        return false;
    }
    for (size_t i = 0; i < sizeof setting / sizeof *setting; i++)
        (void)setenv(setting[i][0], setting[i][1], strcmp(setting[i][0], "OMPI_MCA_btl") == 0);
    return true;
}

#if defined(__GLIBC__)
/* Pages are dear: a fault with its clearing takes as long as a thousand instructions and more. What
 * a scan, a question of a session or a block of rays gives back is wanted again soon. By default
 * the C library would return blocks from 128 KiB on, and what is free at the end of a heap; and
 * threads would have heaps of their own, of which it returns what a scan has freed in any case.
 * Where the kernel gives large pages to who asks for them, the heap begins with a room of such. */
static void keep_pages(void)
{
    const size_t large_page = (size_t)2 << 20, room = (size_t)256 << 20;
    (void)mallopt(M_MMAP_THRESHOLD, 32 << 20); /* the most there may be */
    (void)mallopt(M_TRIM_THRESHOLD, 2 * (int)room);
    (void)mallopt(M_ARENA_MAX, 1);
    (void)mallopt(M_TOP_PAD, (int)room);
    void *block = NULL;
    if (posix_memalign(&block, large_page, large_page) == 0)
        (void)madvise(block, room, MADV_HUGEPAGE);
    free(block);
    (void)mallopt(M_TOP_PAD, 1 << 20);
}
#else
#define keep_pages() ((void)0)
#endif

int rmap_program(const struct rmap_command *const *command, size_t n_command, int argc, char **argv)
{
    const struct commands known = {command, n_command};
    struct rmap_context context = {.comm = MPI_COMM_NULL, .size = 1, .n_thread = 1};
    struct rmap_error error = {0}, *err = &error;
    enum rmap_status st = RMAP_OK;
    int provided = MPI_THREAD_SINGLE, wanted = MPI_THREAD_FUNNELED;
    const char *word = argc > 1 ? argv[1] : "";
    bool stays_alone = false;
    (void)signal(SIGXFSZ, SIG_IGN); /* writing past a limit of size fails with its reason */
    rmap_terminal_guard();
    rmap_h5_own_process();
    watch_signals(&known, word);
    keep_pages();
    /* Open MPI's handlers of SIGABRT and the like allocate: after a broken heap they wait for ever
     * for its lock, and a crash does not end. */
    (void)setenv("OMPI_MCA_opal_signal", "", 0);
    if (is_alone())
        stays_alone = prepare_alone(word);
    else
        wanted = MPI_THREAD_MULTIPLE; /* of the watchdog */
    leave_out_unused();
    /* Who waits in a collective would use up its time on a core that the others may need. */
    (void)setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
    rmap_json_memory_watch();
    if (MPI_Init_thread(&argc, &argv, wanted, &provided) != MPI_SUCCESS) {
        fputs("raymap: MPI cannot be started\n", stderr);
        return RMAP_SYSTEM;
    }
    RMAP_TRY(RMAP_MPI(MPI_Comm_dup(MPI_COMM_WORLD, &context.comm)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_set_errhandler(context.comm, MPI_ERRORS_RETURN)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_rank(context.comm, &context.rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(context.comm, &context.size)));
    if (context.size > 1 && provided == MPI_THREAD_MULTIPLE)
        RMAP_TRY(rmap_watchdog_start(&context, &context.watchdog, err));
    if (provided < MPI_THREAD_FUNNELED)
        st = rmap_error_set(err, RMAP_SYSTEM, "this MPI does not allow threads beside it");
    else
        st = dispatch(&context, &known, argc, argv, err);
    st = flush_output(&context, st, err);
out:
    if (st != RMAP_OK && context.rank == 0 && error.text[0])
        fprintf(stderr, "raymap: %s\n", error.text);
    rmap_watchdog_end(context.watchdog);
    if (context.comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&context.comm);
    /* It would tell Open MPI's thread of events to end and wait for it. A thread that has begun but
     * not come to its first wait by then never hears that. */
    if (!stays_alone)
        (void)MPI_Finalize();
    return (int)st;
}
