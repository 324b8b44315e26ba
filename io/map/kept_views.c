/* SPDX-License-Identifier: MIT
 *
 * What opening the portions of history indexes made, in memory for later questions, as much as
 * fits in a budget: what was asked for first.
 */
#include "io/map/kept_views.h"

#include <stdatomic.h>

#include "base/alloc.h"
#include "history/history_view.h"

struct rmap_kept_views {
    _Atomic(struct rmap_history_made *) *kept; /* [n_portion]; NULL: none, or borrowed */
    size_t n_portion;
    struct rmap_arena *arena;
    _Atomic size_t nbytes;
};

enum rmap_status rmap_kept_views_create(size_t n_portion, struct rmap_arena *arena,
                                        struct rmap_kept_views **views_ret, struct rmap_error *err)
{
    struct rmap_kept_views *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->n_portion = n_portion;
        self->arena = arena;
        self->kept = rmap_alloc(n_portion, sizeof *self->kept);
    }
    if (!self || !self->kept) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for views of %zu portions",
                              n_portion);
    }
    for (size_t i = 0; i < n_portion; i++)
        atomic_init(&self->kept[i], NULL);
    *views_ret = self;
    return RMAP_OK;
}

void rmap_kept_views_destroy(struct rmap_kept_views *self)
{
    if (!self)
        return;
    rmap_free(self->kept);
    rmap_free(self);
}

struct rmap_history_made *rmap_kept_views_borrow(struct rmap_kept_views *self, size_t portion)
{
    return atomic_exchange(&self->kept[portion], NULL);
}

void rmap_kept_views_give_back(struct rmap_kept_views *self, size_t portion,
                               struct rmap_history_made *made)
{
    struct rmap_history_made *none = NULL; /* else another user, who had none, was faster */
    (void)atomic_compare_exchange_strong(&self->kept[portion], &none, made);
}

void rmap_kept_views_offer(struct rmap_kept_views *self, size_t portion,
                           const struct rmap_history_view *view)
{
    const size_t nbytes = rmap_history_made_nbytes(view);
    struct rmap_history_made *made = rmap_arena_room(self->arena, nbytes);
    if (!made)
        return; /* it is opened again, then */
    rmap_history_made_copy(view, made);
    atomic_fetch_add(&self->nbytes, nbytes);
    rmap_kept_views_give_back(self, portion, made);
}

size_t rmap_kept_views_nbytes(const struct rmap_kept_views *self)
{
    return atomic_load(&self->nbytes);
}
