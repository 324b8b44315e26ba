/* SPDX-License-Identifier: MIT
 *
 * raymap session: a map stays open and answers criteria line by line. Rank 0 reads the lines and
 * hands each to all ranks; what they decode to answer it stays in memory for the next.
 */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/asked.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/session/session_answer.h"
#include "mpi/session/session_input.h"
#include "mpi/session/session_words.h"

static const struct rmap_option options[] = {
    {"criteria", 0, "FILE", "named criteria: let NAME = CRITERION ..., used as @NAME"},
    {"memory", 0, "BYTES", "keep so much of the map per rank (default: 1/2 of the rank's share)"},
    {NULL}};

/* Half of the node's memory, shared by its ranks. */
static enum rmap_status default_memory(const struct rmap_context *context, uint64_t *nbytes_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Comm node = MPI_COMM_NULL;
    int n_rank = 1;
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    uint64_t all = pages > 0 && page > 0 ? (uint64_t)pages * (uint64_t)page : UINT64_C(1) << 30;
    RMAP_TRY(RMAP_MPI(MPI_Comm_split_type(context->comm, MPI_COMM_TYPE_SHARED, context->rank,
                                          MPI_INFO_NULL, &node)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(node, &n_rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_free(&node)));
    *nbytes_ret = all / 2 / (uint64_t)n_rank;
out:
    return st;
}

/* Collective. Rank 0's next line on every rank; *line_ret: rmap_free. NULL at the end. The others
 * wait asleep. */
static enum rmap_status next_line(const struct rmap_context *context,
                                  struct rmap_session_input *input, char **line_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *read = NULL;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    *line_ret = NULL;
    if (context->rank == 0)
        st = rmap_session_input_next(input, &read, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    if (read) {
        nbytes = strlen(read) + 1;
        blob = rmap_alloc(nbytes, 1);
        if (!blob)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a line");
        else
            memcpy(blob, read, nbytes);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    if (nbytes > 0) {
        *line_ret = (char *)blob;
        blob = NULL;
    }
out:
    rmap_free(blob);
    return st;
}

/* Rank 0. A wrong line is reported where its answer would stand. */
static enum rmap_status tell_mistake(const struct rmap_context *context, uint64_t line,
                                     const struct rmap_error *mistake, struct rmap_error *err)
{
    if (!context->json) {
        fprintf(stderr, "%s\n", mistake->text);
        return RMAP_OK;
    }
    json_t *told = json_pack("{s:I, s:s}", "line", (json_int_t)line, "error", mistake->text);
    return rmap_json_line(told, stdout, err);
}

/* Collective. Lines until there are no more; *n_wrong_ret: how many were no question. */
static enum rmap_status converse(struct rmap_session *session, struct rmap_session_input *input,
                                 uint64_t *n_wrong_ret, struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    enum rmap_status st = RMAP_OK;
    for (uint64_t n = 1; st == RMAP_OK && !session->quit; n++) {
        struct rmap_error mistake = {0};
        char *line = NULL;
        rmap_interrupt_forget();
        st = next_line(context, input, &line, &mistake);
        const bool is_asked = line, at_end = st == RMAP_OK && !line;
        if (line)
            st = rmap_session_answer(session, line, &mistake);
        rmap_free(line);
        if (st == RMAP_INPUT) {
            (*n_wrong_ret)++;
            st = context->rank == 0 ? tell_mistake(context, n, &mistake, err) : RMAP_OK;
            st = rmap_agree(context, st, err);
        } else if (st != RMAP_OK) {
            *err = mistake;
            if (is_asked && context->rank == 0 && context->json) /* the last line, for its reader */
                (void)tell_mistake(context, n, &mistake, &mistake);
        }
        if (context->rank == 0)
            fflush(stdout);
        if (at_end)
            break;
    }
    return st;
}

/* Rank 0. */
static enum rmap_status open_input(const struct rmap_session *session, bool terminal,
                                   struct rmap_session_input **input_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char **word = NULL;
    size_t n_word = 0;
    if (terminal)
        RMAP_TRY(rmap_session_words(rmap_map_scene(session->map), &word, &n_word, err));
    st = rmap_session_input_create(stdin, word, n_word, input_ret, err);
out:
    rmap_free(word);
    return st;
}

/* Collective. What the options ask for. */
static enum rmap_status read_options(struct rmap_session *session,
                                     const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_asked asked = {0};
    RMAP_TRY(default_memory(session->context, &session->memory, err));
    RMAP_TRY(rmap_agree(session->context,
                        rmap_argument_count(given, "memory", &session->memory, err), err));
    RMAP_TRY(rmap_asked_load(session->context, given, NULL, 0, &asked, err));
    session->criteria = asked.criteria;
    asked.criteria = NULL;
out:
    rmap_asked_fini(&asked);
    return st;
}

static enum rmap_status run_session(const struct rmap_context *context,
                                    const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool terminal = isatty(STDIN_FILENO) == 1;
    struct rmap_context inner = *context;
    struct rmap_session session = {.context = &inner, .path = given->operand[0]};
    struct rmap_session_input *input = NULL;
    uint64_t n_wrong = 0;
    int is_terminal = terminal;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&is_terminal, 1, MPI_INT, 0, context->comm)));
    inner.json = context->json || !is_terminal;
    RMAP_TRY(rmap_load_map(context, given->operand[0], &session.map, err));
    RMAP_TRY(read_options(&session, given, err));
    if (context->rank == 0)
        st = open_input(&session, is_terminal, &input, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(converse(&session, input, &n_wrong, err));
    if (n_wrong > 0 && !is_terminal)
        st = rmap_error_set(err, RMAP_INPUT, "%llu of the lines could not be answered",
                            (unsigned long long)n_wrong);
out:
    rmap_session_input_destroy(input);
    rmap_session_memo_clear(&session.memo);
    rmap_criteria_destroy(session.criteria);
    rmap_map_close(session.map);
    return st;
}

const struct rmap_command rmap_command_session = {
    .name = "session",
    .summary = "keep a ray map open and answer criteria line by line",
    .operands = "MAP",
    .help =
        "Each line is a criterion, answered as `raymap query --count` does; `list N CRITERION`,\n"
        "`let NAME = CRITERION`, `names`, `status`, `refresh`, `help` and `quit` are understood\n"
        "as well. What answering took is kept in memory, up to --memory, so that the next "
        "questions read and\n"
        "decode nothing again; `status` says how much that is. On a terminal\n"
        "lines can be edited, called back and completed with the tabulator; from a pipe every\n"
        "line is answered by one line of JSON, a wrong one by {\"line\", \"error\"}, and the exit\n"
        "status is 3 when there was one.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_session,
};
