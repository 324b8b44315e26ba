/* SPDX-License-Identifier: MIT
 *
 * Measurement of sessions: what a second question takes against the first.
 */
#include "base/alloc.h"
#include "bench_search.h"
#include "io/map/map_keep.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/progress.h"
#include "mpi/session/session_memo.h"

enum { SESSION_NBYTES = 1 << 30 };

/* A session: its map and answers. */
struct session {
    const struct rmap_bench_search *search;
    struct rmap_map *map;
    struct rmap_session_memo *memo;
    struct rmap_bench_answer opening; /* the map, before the first question */
};

static void stop(const struct rmap_bench_answer *begun, struct rmap_bench_answer *took)
{
    took->seconds = rmap_clock_seconds() - begun->seconds;
    took->cpu = rmap_bench_cpu() - begun->cpu;
}

static struct rmap_bench_answer start(void)
{
    return (struct rmap_bench_answer){.seconds = rmap_clock_seconds(), .cpu = rmap_bench_cpu()};
}

static void end(struct session *session)
{
    if (session->memo)
        rmap_session_memo_clear(session->memo);
    rmap_free(session->memo);
    rmap_map_close(session->map);
    *session = (struct session){0};
}

static enum rmap_status begin(const struct rmap_bench_search *search, size_t encoding,
                              struct session *session, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_bench_answer begun = start();
    *session = (struct session){.search = search, .memo = rmap_alloc(1, sizeof *session->memo)};
    if (!session->memo)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a session");
    RMAP_TRY(rmap_map_open(search->map[encoding], &session->map, err));
    stop(&begun, &session->opening);
out:
    return st;
}

/* From the text of the criterion to the count. The first prepares the session as well. */
static enum rmap_status ask(struct session *session, const char *text,
                            struct rmap_bench_answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *alone = &session->search->bench->alone;
    const struct rmap_scene *scene = rmap_map_scene(session->map);
    const struct rmap_bench_answer begun = start();
    struct rmap_map_kept kept;
    struct rmap_criterion *criterion = NULL;
    struct rmap_count count = {0};
    const struct rmap_registered_list *registered;
    rmap_map_kept(session->map, &kept);
    RMAP_TRY(rmap_criterion_compile(text, scene, &criterion, err));
    RMAP_TRY(rmap_count_init(&count, scene->n_source, err));
    if (kept.budget == 0)
        RMAP_TRY(rmap_map_keep(session->map, SESSION_NBYTES, err));
    RMAP_TRY(rmap_session_count(alone, session->memo, session->map, criterion, &count, &registered,
                                err));
    stop(&begun, answer);
    answer->n_ray = count.rays;
out:
    rmap_count_fini(&count);
    rmap_criterion_destroy(criterion);
    return st;
}

/* A session that is asked `first` and then `second`. */
static enum rmap_status ask_twice(const struct rmap_bench_search *search, size_t encoding,
                                  const char *first, const char *second,
                                  struct rmap_bench_answer answer[2],
                                  struct rmap_bench_answer *opening, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct session session = {0};
    RMAP_TRY(begin(search, encoding, &session, err));
    RMAP_TRY(ask(&session, first, &answer[0], err));
    RMAP_TRY(ask(&session, second, &answer[1], err));
    *opening = session.opening;
out:
    end(&session);
    return st;
}

/* What is asked before the question. */
struct before {
    const char *name, *text;
    struct rmap_bench_series series;
    double unopened[RMAP_BENCH_REPEAT_MAX]; /* ratios with the first question alone */
};

enum rmap_status rmap_bench_session(const struct rmap_bench_search *search, size_t encoding,
                                    const struct rmap_bench_question *question,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t next = (size_t)(question - search->question + 1) % search->n_question;
    struct before before[] = {{.name = "the same", .text = question->text},
                              {.name = "its like", .text = question->like},
                              {.name = "another", .text = search->question[next].text}};
    enum { N = sizeof before / sizeof *before };
    for (int i = 0; i < search->bench->n_repeat; i++) {
        struct rmap_bench_answer first = {0}, alone = {0};
        for (size_t k = 0; k < N; k++) {
            struct rmap_bench_answer answer[2] = {{0}}, opening = {0};
            RMAP_TRY(
                ask_twice(search, encoding, before[k].text, question->text, answer, &opening, err));
            if (k == 0) { /* the question asked first */
                alone = answer[0];
                first.seconds = opening.seconds + alone.seconds;
                first.cpu = opening.cpu + alone.cpu;
            }
            if (answer[1].n_ray != alone.n_ray)
                RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "two answers to %s", question->text));
            before[k].unopened[i] = alone.seconds / answer[1].seconds;
            rmap_bench_add(&before[k].series, search->n_segment / answer[1].seconds,
                           search->n_segment / first.seconds);
            rmap_bench_add_cpu(&before[k].series, answer[1].cpu, first.cpu);
        }
    }
    for (size_t k = 0; k < N; k++)
        rmap_bench_search_report(
            search, encoding, "session_second_vs_first", &before[k].series, "million segments/s",
            json_pack("{s:s, s:s, s:s, s:f}", "class", question->class, "criterion", question->text,
                      "after", before[k].name, "without_opening",
                      rmap_bench_median(before[k].unopened, search->bench->n_repeat)));
out:
    return st;
}
