/* SPDX-License-Identifier: MIT
 *
 * What a line of a session asks, answered.
 */
#include "mpi/session/session_answer.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_json.h"
#include "io/map/map_keep.h"
#include "mpi/answer/query_count_out.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/session/session_define.h"
#include "mpi/session/session_refresh.h"
#include "mpi/session/session_status.h"
#include "mpi/session/session_words.h"

static const char help[] =
    "CRITERION                 how many rays, segments and how much flux match\n"
    "list N CRITERION          the N matching rays with the smallest ids\n"
    "let NAME = CRITERION      a name for later lines: @NAME\n"
    "names                     what the scene's objects, sources ... are called\n"
    "refresh                   the map as it is by now: what a running trace has flushed\n"
    "status                    how much of the map is kept in memory\n"
    "help, quit\n";

/* Past a word and the blanks behind it; NULL when the line does not begin with the word. */
static const char *after_word(const char *line, const char *word)
{
    size_t len = strlen(word);
    if (strncmp(line, word, len) != 0 || (line[len] && !isspace((unsigned char)line[len])))
        return NULL;
    return line + len + strspn(line + len, " \t\r");
}

/* Collective. What questions decode stays for the next ones; where the machine has no memory, less
 * is kept. */
static enum rmap_status prepare(struct rmap_session *session, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = session->context;
    struct rmap_error why = {0};
    if (session->warm)
        return RMAP_OK;
    session->warm = true;
    st = rmap_map_keep(session->map, (size_t)session->memory, &why);
    if (st != RMAP_OK && st != RMAP_SYSTEM)
        *err = why;
    st = st == RMAP_SYSTEM ? RMAP_OK : st;
    return rmap_agree(context, st, err);
}

/* Collective. */
static enum rmap_status count_rays(struct rmap_session *session, struct rmap_criterion *criterion,
                                   struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    struct rmap_count count = {0};
    const struct rmap_registered_list *registered = NULL;
    const struct rmap_ray_groups together = {.n = 0};
    double begun = rmap_clock_seconds();
    enum rmap_status st = rmap_count_init(&count, rmap_map_scene(session->map)->n_source, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(prepare(session, err));
    RMAP_TRY(rmap_session_count(context, &session->memo, session->map, criterion, &count,
                                &registered, err));
    double seconds = rmap_clock_seconds() - begun;
    if (context->rank == 0 && context->json) {
        rmap_tell_hint(context, session->map, &(struct rmap_choice){criterion, NULL}, count.rays);
        st = rmap_json_line(
            rmap_query_count_json(session->map, criterion, &count, registered, seconds), stdout,
            err);
    } else if (context->rank == 0) {
        st = rmap_query_count_print(context, session->map, &criterion, &count, registered,
                                    &together, 1, false, NULL, seconds, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_count_fini(&count);
    return st;
}

struct list {
    const struct rmap_map *map;
    json_t *rays;
};

static enum rmap_status take_json(void *context, const struct rmap_streamed_ray *ray,
                                  struct rmap_error *err)
{
    struct list *list = context;
    struct rmap_ray_report *report = NULL;
    enum rmap_status st = rmap_ray_report_row(list->map, ray->space, ray->portion, ray->row,
                                              ray->segment, ray->registration, &report, err);
    if (st == RMAP_OK && json_array_append_new(list->rays, rmap_ray_report_json(report)) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the JSON of a ray");
    rmap_ray_report_destroy(report);
    return st;
}

/* Collective. */
static enum rmap_status list_rays(const struct rmap_session *session,
                                  const struct rmap_criterion *criterion, uint64_t limit,
                                  struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    const struct rmap_pick pick = {.criterion = criterion};
    enum rmap_status st = RMAP_OK;
    struct rmap_rays_out *out = NULL;
    struct list list = {session->map, NULL};
    struct rmap_ray_sink sink = {&list, take_json};
    uint64_t n = 0;
    if (context->rank == 0 && context->json) {
        list.rays = json_array();
    } else if (context->rank == 0) {
        st = rmap_rays_out_begin(context, session->map, &(struct rmap_table_request){0}, &out, err);
        sink = (struct rmap_ray_sink){out, rmap_rays_out_take};
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_ray_stream(context, session->map, &pick, RMAP_DEAL_TURNS, limit, &sink, &n, err));
    if (out)
        st = rmap_rays_out_finish(out, err);
    else if (context->rank == 0)
        st = rmap_json_line(
            rmap_json_of_map(json_pack("{s:s, s:O}", "criterion", rmap_criterion_text(criterion),
                                       "rays", list.rays),
                             session->map),
            stdout, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    json_decref(list.rays);
    rmap_rays_out_destroy(out);
    return st;
}

/* "list N CRITERION", behind the word. */
static enum rmap_status read_list(const char *rest, uint64_t *limit_ret, const char **text_ret,
                                  struct rmap_error *err)
{
    char number[32];
    size_t len = strcspn(rest, " \t");
    if (len == 0 || len >= sizeof number)
        return rmap_error_set(err, RMAP_INPUT, "it is `list N CRITERION`: the %s",
                              "N matching rays with the smallest ids");
    memcpy(number, rest, len);
    number[len] = '\0';
    *text_ret = rest + len + strspn(rest + len, " \t");
    enum rmap_status st = rmap_parse_count(number, "list", limit_ret, err);
    if (st == RMAP_OK && *limit_ret == 0)
        st = rmap_error_set(err, RMAP_INPUT, "list 0: at least one ray");
    return st == RMAP_OK || st == RMAP_SYSTEM ? st : RMAP_INPUT;
}

/* A damaged selection is no end of the session. */
static enum rmap_status of_line(enum rmap_status st, struct rmap_error *err)
{
    return st == RMAP_FORMAT ? (err->status = RMAP_INPUT) : st;
}

/* Collective. */
static enum rmap_status answer_criterion(struct rmap_session *session, const char *text,
                                         uint64_t limit, struct rmap_error *err)
{
    struct rmap_criterion *criterion = NULL;
    enum rmap_status st = rmap_criterion_compile_with(
        text, session->criteria, rmap_map_scene(session->map), &criterion, err);
    RMAP_TRY(rmap_agree(session->context, of_line(st, err), err));
    st = limit == 0 ? count_rays(session, criterion, err)
                    : list_rays(session, criterion, limit, err);
out:
    rmap_criterion_destroy(criterion);
    return st;
}

/* Collective. */
static enum rmap_status define(struct rmap_session *session, const char *line,
                               struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    enum rmap_status st =
        rmap_session_define(&session->criteria, line, rmap_map_scene(session->map), err);
    RMAP_TRY(rmap_agree(context, of_line(st, err), err));
    rmap_session_memo_clear(&session->memo);
    if (context->rank == 0 && context->json)
        st = rmap_json_line(json_pack("{s:s}", "defined", line), stdout, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Collective. */
static enum rmap_status show_names(const struct rmap_session *session, struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    const struct rmap_scene *scene = rmap_map_scene(session->map);
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0 && context->json)
        st = rmap_json_line(
            rmap_json_of_map(json_pack("{s:o}", "names", rmap_session_names_json(scene)),
                             session->map),
            stdout, err);
    else if (context->rank == 0)
        rmap_session_names_print(scene, stderr);
    return rmap_agree(context, st, err);
}

/* Collective. */
static enum rmap_status show_help(const struct rmap_session *session, struct rmap_error *err)
{
    const struct rmap_context *context = session->context;
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0 && context->json)
        st = rmap_json_line(json_pack("{s:s}", "help", help), stdout, err);
    else if (context->rank == 0)
        fputs(help, stderr);
    return rmap_agree(context, st, err);
}

enum rmap_status rmap_session_answer(struct rmap_session *session, const char *line,
                                     struct rmap_error *err)
{
    const char *rest;
    uint64_t limit = 0;
    line += strspn(line, " \t\r");
    if (*line == '\0' || *line == '#')
        return RMAP_OK;
    if ((rest = after_word(line, "quit")) || (rest = after_word(line, "exit"))) {
        session->quit = *rest == '\0';
        return session->quit ? RMAP_OK
                             : rmap_error_set(err, RMAP_INPUT, "nothing stands behind `quit`");
    }
    if (after_word(line, "help"))
        return show_help(session, err);
    if (after_word(line, "names"))
        return show_names(session, err);
    if ((rest = after_word(line, "status")) && *rest == '\0')
        return rmap_session_status(session->context, session->map, session->memory, err);
    if ((rest = after_word(line, "refresh")) && *rest == '\0')
        return rmap_session_refresh(session, err);
    if (after_word(line, "let"))
        return define(session, line, err);
    if ((rest = after_word(line, "list"))) {
        enum rmap_status st = read_list(rest, &limit, &line, err);
        if (st != RMAP_OK)
            return st;
    }
    return answer_criterion(session, line, limit, err);
}
