/* SPDX-License-Identifier: MIT
 *
 * The tally of an incomplete map: that of its index, and of what stands beside it.
 */
#include <stdatomic.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "io/map/map_cursor.h"
#include "io/map/map_internal.h"
#include "io/map/map_reader.h"
#include "trace/tally.h"

/* Portions that a thread takes at a time: neighbours share chunks. */
enum { STEP = 32 };

/* Adding the added portions to the tally. bad[i] says of one that it cannot be read: it is left
 * out, as if its writer had died a little earlier. */
struct tallying {
    struct rmap_map *map;
    bool *bad;             /* [n_portion] */
    struct worker *worker; /* [n_thread] */
    int n_thread;
    _Atomic size_t next;
    pthread_mutex_t lock; /* of the map's troubles, and: */
    bool *told;           /* [n_piece] */
};

struct worker {
    struct rmap_tally *tally;
    struct rmap_cursor *cursor;
    struct rmap_error error;
};

static enum rmap_status note_trouble(struct tallying *all, struct worker *self, size_t portion,
                                     const char *text)
{
    bool *told = &all->told[all->map->content.portion[portion].piece];
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(&all->lock);
    if (!*told)
        st = rmap_map_note_trouble(all->map, text, &self->error);
    *told = true;
    (void)pthread_mutex_unlock(&all->lock);
    return st;
}

static enum rmap_status tally_portion(struct tallying *all, struct worker *self, size_t portion)
{
    const struct rmap_portion *rows = NULL;
    struct rmap_error why = {0};
    if (!all->map->content.portion[portion].is_added)
        return RMAP_OK;
    enum rmap_status st = rmap_cursor_read(self->cursor, portion, &rows, &why);
    if (st == RMAP_OK)
        st = rmap_tally_add_portion(self->tally, rows, &why);
    all->bad[portion] = st != RMAP_OK;
    if (st == RMAP_SYSTEM)
        self->error = why;
    else if (st != RMAP_OK)
        st = note_trouble(all, self, portion, why.text);
    return st;
}

static void tally_some(void *context, int thread)
{
    struct tallying *all = context;
    struct worker *self = &all->worker[thread];
    size_t n = all->map->content.n_portion, first;
    enum rmap_status st =
        rmap_cursor_create(all->map, RMAP_TALLY_COLUMNS, &self->cursor, &self->error);
    while (st == RMAP_OK && (first = atomic_fetch_add(&all->next, STEP)) < n)
        for (size_t i = first; st == RMAP_OK && i < n && i < first + STEP; i++)
            st = tally_portion(all, self, i);
}

static enum rmap_status run_workers(struct tallying *all, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *threads = NULL;
    for (int t = 0; t < all->n_thread; t++)
        RMAP_TRY(rmap_tally_create(all->map->scene[0], &all->worker[t].tally, err));
    RMAP_TRY(rmap_workers_start(all->n_thread, tally_some, all, &threads, err));
    rmap_workers_join(threads);
    for (int t = 0; t < all->n_thread; t++) {
        if (all->worker[t].error.status != RMAP_OK) {
            st = all->worker[t].error.status;
            (void)rmap_error_set(err, st, "%s", all->worker[t].error.text);
            goto out;
        }
        rmap_tally_merge(all->map->tally, all->worker[t].tally);
    }
out:
    return st;
}

static enum rmap_status tally_portions(struct rmap_map *map, bool *bad, size_t *n_bad,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_added = 0;
    for (size_t i = 0; i < map->content.n_portion; i++)
        n_added += map->content.portion[i].is_added != 0;
    if (n_added == 0)
        return RMAP_OK;
    size_t most = (n_added + STEP - 1) / STEP, cores = (size_t)rmap_workers_available();
    struct tallying all = {.map = map, .bad = bad, .n_thread = (int)(cores < most ? cores : most)};
    all.worker = rmap_alloc((size_t)all.n_thread, sizeof *all.worker);
    all.told = rmap_alloc(map->content.n_piece, sizeof *all.told);
    if (!all.worker || !all.told) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", all.n_thread);
        goto out;
    }
    (void)pthread_mutex_init(&all.lock, NULL);
    st = run_workers(&all, err);
    (void)pthread_mutex_destroy(&all.lock);
    for (size_t i = 0; i < map->content.n_portion; i++)
        *n_bad += bad[i];
out:
    for (int t = 0; all.worker && t < all.n_thread; t++) {
        rmap_cursor_destroy(all.worker[t].cursor);
        rmap_tally_destroy(all.worker[t].tally);
    }
    rmap_free(all.worker);
    rmap_free(all.told);
    return st;
}

static enum rmap_status complete_tally(struct rmap_map *map, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content *content = &map->content;
    size_t n_bad = 0, n = 0, n_dropped;
    bool *bad = rmap_alloc(content->n_portion, sizeof *bad);
    if (!bad) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's tables");
        goto out;
    }
    RMAP_TRY(tally_portions(map, bad, &n_bad, err));
    rmap_map_derive_flux(map);
    if (n_bad == 0)
        goto out;
    for (size_t i = 0; i < content->n_portion; i++)
        if (!bad[i])
            content->portion[n++] = content->portion[i];
    content->n_portion = n;
    rmap_map_content_drop_covered(content, &n_dropped); /* recounts rows of pieces */
    RMAP_TRY(rmap_map_content_check(content, map->path, err));
    RMAP_TRY(rmap_map_sum_up(map, err));
out:
    rmap_free(bad);
    return st;
}

enum rmap_status rmap_map_open(const char *path, struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = rmap_map_open_untallied(path, &map, err);
    if (st == RMAP_OK && !map->summary.complete)
        st = complete_tally(map, err);
    if (st == RMAP_OK)
        *map_ret = map;
    else
        rmap_map_close(map);
    return st;
}
