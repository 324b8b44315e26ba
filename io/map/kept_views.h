/* SPDX-License-Identifier: MIT
 *
 * What opening the portions of history indexes made, in memory for later questions, as much as fits
 * in a budget: what was asked for first. A block is borrowed to one user at a time, who may add to
 * it.
 */
#ifndef RMAP_KEPT_VIEWS_H
#define RMAP_KEPT_VIEWS_H

#include "history/history_index.h"
#include "io/map/arena.h"

struct rmap_kept_views;

/* The arena must outlive them. */
enum rmap_status rmap_kept_views_create(size_t n_portion, struct rmap_arena *arena,
                                        struct rmap_kept_views **views_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_kept_views_destroy(struct rmap_kept_views *views);

/* What is kept of a portion, to be given back; NULL: nothing, or it is borrowed. Thread-safe, as is
 * all that follows. */
struct rmap_history_made *rmap_kept_views_borrow(struct rmap_kept_views *views, size_t portion);
void rmap_kept_views_give_back(struct rmap_kept_views *views, size_t portion,
                               struct rmap_history_made *made);

/* Keeps a copy of what an open view made, if there is room. */
void rmap_kept_views_offer(struct rmap_kept_views *views, size_t portion,
                           const struct rmap_history_view *view);

size_t rmap_kept_views_nbytes(const struct rmap_kept_views *views);

#endif
