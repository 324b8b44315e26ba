/* SPDX-License-Identifier: MIT
 *
 * Answers that a session has given: a map that stays open does not change, so that the same
 * question has the same answer.
 */
#include "mpi/session/session_memo.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

static void forget(struct rmap_session_answered *answer)
{
    rmap_free(answer->text);
    rmap_count_fini(&answer->count);
    rmap_registered_fini(&answer->registered);
    *answer = (struct rmap_session_answered){0};
}

void rmap_session_memo_clear(struct rmap_session_memo *memo)
{
    for (size_t i = 0; i < RMAP_SESSION_ANSWERS; i++)
        forget(&memo->answer[i]);
    memo->n = 0;
}

static const struct rmap_session_answered *find(const struct rmap_session_memo *memo,
                                                const char *text)
{
    for (size_t i = 0; i < RMAP_SESSION_ANSWERS && i < memo->n; i++)
        if (strcmp(memo->answer[i].text, text) == 0)
            return &memo->answer[i];
    return NULL;
}

/* In place of the oldest. Takes what `fresh` holds over. */
static enum rmap_status keep(struct rmap_session_memo *memo, const char *text,
                             const struct rmap_count *count, size_t n_source,
                             struct rmap_session_answered *fresh, struct rmap_error *err)
{
    fresh->text = rmap_strdup(text);
    enum rmap_status st = fresh->text ? rmap_count_init(&fresh->count, n_source, err)
                                      : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (st != RMAP_OK)
        return st;
    rmap_count_add(&fresh->count, count, n_source);
    fresh->count.portions_read = fresh->count.nbytes_read = 0; /* nor will they be */
    forget(&memo->answer[memo->n % RMAP_SESSION_ANSWERS]);
    memo->answer[memo->n++ % RMAP_SESSION_ANSWERS] = *fresh;
    *fresh = (struct rmap_session_answered){0};
    return RMAP_OK;
}

enum rmap_status rmap_session_count(const struct rmap_context *context,
                                    struct rmap_session_memo *memo, const struct rmap_map *map,
                                    struct rmap_criterion *criterion, struct rmap_count *count,
                                    const struct rmap_registered_list **registered_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *text = rmap_criterion_text(criterion);
    size_t n_source = rmap_map_scene(map)->n_source;
    const struct rmap_session_answered *known = find(memo, text);
    struct rmap_session_answered fresh = {.text = NULL};
    if (known) {
        rmap_count_add(count, &known->count, n_source);
        *registered_ret = &known->registered;
        return RMAP_OK;
    }
    RMAP_TRY(rmap_registered_run(context, map, NULL, criterion, context->json, count,
                                 &fresh.registered, err));
    if (!fresh.registered.is_counted)
        RMAP_TRY(rmap_scan_map(context, map, &criterion, 1, RMAP_DEAL_SHARES, count, err));
    st = rmap_agree(context, keep(memo, text, count, n_source, &fresh, err), err);
    RMAP_TRY(st);
    *registered_ret = &find(memo, text)->registered;
out:
    forget(&fresh);
    return st;
}
