/* SPDX-License-Identifier: MIT
 *
 * Answers that a session has given: a map that stays open does not change, so that the same
 * question has the same answer. The same on every rank.
 */
#ifndef RMAP_SESSION_MEMO_H
#define RMAP_SESSION_MEMO_H

#include "mpi/scan/registered.h"
#include "mpi/scan/scan.h"

enum { RMAP_SESSION_ANSWERS = 256 };

/* All zero at first. */
struct rmap_session_memo {
    struct rmap_session_answered {
        char *text; /* of the criterion; NULL: free */
        struct rmap_count count;
        struct rmap_registered_list registered;
    } answer[RMAP_SESSION_ANSWERS];
    size_t n; /* ever kept */
};

/* Forgets all: names in later criteria may mean something else. */
void rmap_session_memo_clear(struct rmap_session_memo *memo);

/* Collective. As rmap_scan_map of one criterion, all portions in shares; an answer that is still
 * known is given again. *registered_ret, the memo's: what rmap_registered_run finds, on rank 0. */
enum rmap_status rmap_session_count(const struct rmap_context *context,
                                    struct rmap_session_memo *memo, const struct rmap_map *map,
                                    struct rmap_criterion *criterion, struct rmap_count *count,
                                    const struct rmap_registered_list **registered_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
