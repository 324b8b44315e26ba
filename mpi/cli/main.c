/* SPDX-License-Identifier: MIT
 *
 * The program: which command, on which ranks, and how it ends. MPI_COMM_WORLD and MPI_Finalize
 * stand here alone.
 */
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "base/alloc.h"
#include "io/export/json_memory.h"
#include "io/file/diagnostics.h"
#include "mpi/cli/manual.h"
#include "mpi/command/command.h"
#include "mpi/command/version_text.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/terminal.h"
#include "mpi/parallel/threads.h"
#include "mpi/parallel/watchdog.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const struct rmap_command *const command[] = {
    &rmap_command_check,   &rmap_command_trace,    &rmap_command_info,   &rmap_command_query,
    &rmap_command_report,  &rmap_command_detector, &rmap_command_stats,  &rmap_command_compare,
    &rmap_command_paths,   &rmap_command_draw,     &rmap_command_render, &rmap_command_verify,
    &rmap_command_repair,  &rmap_command_convert,  &rmap_command_merge,  &rmap_command_index,
    &rmap_command_session, &rmap_command_bench,
};

static void print_overview(FILE *out)
{
    fputs("usage: raymap COMMAND [options] ...      alone, or under mpirun -np N\n\n"
          "Traces light through a scene, keeps every ray's whole history in a ray map, and\n"
          "answers questions about those histories.\n\ncommands:\n",
          out);
    for (size_t i = 0; i < COUNT(command); i++)
        fprintf(out, "  %-10s %s\n", command[i]->name, command[i]->summary);
    fputs("\nraymap COMMAND --help says more; raymap --version names the libraries.\n", out);
}

static enum rmap_status find_command(const char *name, const struct rmap_command **found,
                                     struct rmap_error *err)
{
    const char *known[COUNT(command)] = {NULL};
    for (size_t i = 0; i < COUNT(command); i++) {
        known[i] = command[i]->name;
        if (strcmp(known[i], name) == 0) {
            *found = command[i];
            return RMAP_OK;
        }
    }
    const char *nearest = rmap_nearest_word(name, known, COUNT(known));
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
    if (!rmap_argument(&given, "help"))
        st = chosen->run(context, &given, err);
    else if (context->rank == 0)
        rmap_arguments_help(chosen, stdout);
out:
    rmap_arguments_fini(&given);
    return st;
}

/* `raymap help --man` and `help --completion` are what the build installs. */
static void print_help(const char *form, FILE *out)
{
    if (strcmp(form, "--man") == 0)
        rmap_manual_print(command, COUNT(command), out);
    else if (strcmp(form, "--completion") == 0)
        rmap_completion_print(command, COUNT(command), out);
    else
        print_overview(out);
}

/* Collective. */
static enum rmap_status dispatch(struct rmap_context *context, int argc, char **argv,
                                 struct rmap_error *err)
{
    const char *word = argc > 1 ? argv[1] : "";
    const struct rmap_command *chosen = NULL;
    if (strcmp(word, "help") == 0 && argc > 2 && argv[2][0] != '-') {
        enum rmap_status st = find_command(argv[2], &chosen, err);
        if (st == RMAP_OK && context->rank == 0)
            rmap_arguments_help(chosen, stdout);
        return st;
    }
    bool help = strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0;
    if (help || strcmp(word, "--version") == 0) {
        if (context->rank == 0 && help)
            print_help(argc > 2 ? argv[2] : "", stdout);
        else if (context->rank == 0)
            rmap_version_print(stdout);
        return RMAP_OK;
    }
    if (!*word) {
        if (context->rank == 0)
            print_overview(stderr);
        return rmap_error_set(err, RMAP_USAGE, "no command given");
    }
    enum rmap_status st = find_command(word, &chosen, err);
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
static void watch_signals(const char *word)
{
    for (size_t i = 0; i < COUNT(command); i++)
        if (command[i]->stops_in_order && strcmp(word, command[i]->name) == 0)
            rmap_interrupt_watch();
}

static bool is_alone(void)
{
    return !getenv("OMPI_COMM_WORLD_SIZE") && !getenv("PMIX_RANK") && !getenv("PMI_RANK");
}

/* Started without mpirun. Open MPI would start a daemon beside the one process, for half a second
 * and for nothing, and make a folder in /tmp/ompi.HOST.UID that another process may be removing at
 * that moment: of 160 starts, 4 at a time, 2 died so in MPI_Init. It would also load the drivers of
 * all network cards, some of which measure a clock for 0.2 s. Only `bench` needs these, to start a
 * second rank, and TCP between the two. */
static void prepare_alone(const char *word)
{
    if (strcmp(word, rmap_command_bench.name) == 0) {
        (void)unsetenv("OMPI_MCA_btl");
        return;
    }
    (void)setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    (void)setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
    (void)setenv("OMPI_MCA_pml", "ob1", 0);
}

#if defined(__GLIBC__)
/* What the heap begins with will stand on huge pages once it is used: they are told of beforehand,
 * as memory that tracing has taken in small pages stays on these, whoever uses it then. */
static void prefer_huge_heap(void)
{
    enum { BLOCKS = 2, BLOCK_NBYTES = 28 << 20 }; /* below the threshold, and all of them */
    void *block[BLOCKS];
    for (int i = 0; i < BLOCKS; i++)
        block[i] = rmap_alloc_unset(BLOCK_NBYTES, 1);
    for (int i = 0; i < BLOCKS; i++)
        rmap_free(block[i]);
}

/* Pages are dear: a fault with its clearing takes as long as a thousand instructions and more. What
 * a scan, a question of a session or a block of rays gives back is wanted again soon. By default
 * the C library would return blocks from 128 KiB on, and what is free at the end of a heap; and
 * threads would have heaps of their own, of which it returns what a scan has freed in any case. */
static void keep_pages(void)
{
    (void)mallopt(M_MMAP_THRESHOLD, 32 << 20); /* the most there may be */
    (void)mallopt(M_TRIM_THRESHOLD, 64 << 20);
    (void)mallopt(M_ARENA_MAX, 1);
    prefer_huge_heap();
}
#else
#define keep_pages() ((void)0)
#endif

int main(int argc, char **argv)
{
    struct rmap_context context = {.comm = MPI_COMM_NULL, .size = 1, .n_thread = 1};
    struct rmap_error error = {0}, *err = &error;
    enum rmap_status st = RMAP_OK;
    int provided = MPI_THREAD_SINGLE, wanted = MPI_THREAD_FUNNELED;
    rmap_terminal_guard();
    watch_signals(argc > 1 ? argv[1] : "");
    keep_pages();
    /* Open MPI's handlers of SIGABRT and the like allocate: after a broken heap they wait for ever
     * for its lock, and a crash does not end. */
    (void)setenv("OMPI_MCA_opal_signal", "", 0);
    if (is_alone())
        prepare_alone(argc > 1 ? argv[1] : "");
    else
        wanted = MPI_THREAD_MULTIPLE; /* of the watchdog */
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
        st = dispatch(&context, argc, argv, err);
    st = flush_output(&context, st, err);
out:
    if (st != RMAP_OK && context.rank == 0 && error.text[0])
        fprintf(stderr, "raymap: %s\n", error.text);
    rmap_watchdog_end(context.watchdog);
    if (context.comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&context.comm);
    (void)MPI_Finalize();
    return (int)st;
}
