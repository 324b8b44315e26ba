/* SPDX-License-Identifier: MIT
 *
 * Which rays a part has is decided first, which takes little memory; before they are read whole the
 * part waits until the parts that are ready leave room for them. The next part to be taken never
 * waits, so that there is always one that goes on.
 */
#include "mpi/scan/ray_parts.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "io/map/map_memory.h"

/* Bytes of picked rays that wait to be taken, per rank. */
static const size_t room_nbytes = (size_t)48 << 20;

/* Parts that a thread may be ahead of the one to be taken: an early stop costs no more. */
enum { AHEAD = 3 };

/* A thread has the rows that it evaluates, those of whole rays, and those picked of them. */
enum { COPIES = 3 };

struct slot {
    bool done;
    enum rmap_status status;
    struct rmap_error error;
    struct rmap_sheaves sheaves;
    size_t nbytes; /* of the room */
};

/* What a thread decides of the part in hand. */
struct marks {
    uint8_t *match; /* portion after portion */
    size_t cap_match;
    size_t *n;     /* [portions of the part] marked */
    size_t *first; /* [portions of the part] in match */
};

struct rmap_ray_parts {
    const struct rmap_map *map;
    const struct rmap_pick *pick;
    const struct rmap_deal *deal;
    uint64_t limit;
    int rank, n_thread;
    size_t n_part, n_slot;
    struct slot *slot; /* [n_slot], part k in slot k modulo n_slot */
    _Atomic size_t next, taken;
    _Atomic size_t in_use; /* bytes of the room */
    _Atomic bool stopped;
    pthread_mutex_t lock; /* of done */
    struct rmap_workers *workers;
};

void rmap_sheaves_fini(struct rmap_sheaves *sheaves)
{
    for (size_t i = 0; i < sheaves->n; i++)
        rmap_message_destroy(sheaves->sheaf[i].message);
    rmap_free(sheaves->sheaf);
    *sheaves = (struct rmap_sheaves){0};
}

void rmap_ray_parts_nap(void)
{
    const struct timespec nap = {.tv_nsec = 200000};
    (void)nanosleep(&nap, NULL);
}

static void marks_fini(struct marks *marks)
{
    rmap_free(marks->match);
    rmap_free(marks->n);
    rmap_free(marks->first);
}

static enum rmap_status marks_init(struct marks *marks, size_t step, struct rmap_error *err)
{
    *marks = (struct marks){.n = rmap_alloc(step, sizeof *marks->n),
                            .first = rmap_alloc(step, sizeof *marks->first)};
    return marks->n && marks->first ? RMAP_OK
                                    : rmap_error_set(err, RMAP_SYSTEM, "out of memory for marks");
}

/* Bytes that n of the rays of a portion take, about. */
static size_t rays_nbytes(const struct rmap_map *map, size_t portion, size_t n)
{
    const struct rmap_portion_info *info = rmap_map_portion(map, portion);
    const struct rmap_portion shape = {.n_channel =
                                           rmap_map_scene_of(map, (size_t)info->space)->channels.n};
    size_t nbytes = 0, n_ray = (size_t)info->n_row[RMAP_TABLE_RAY];
    const rmap_column_set columns = rmap_columns_of_run(rmap_map_scene(map)->timed);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        nbytes += (columns >> c & 1) * rmap_portion_row_nbytes(&shape, (enum rmap_column)c) *
                  (size_t)info->n_row[rmap_column_info((enum rmap_column)c)->table];
    return n_ray > 0 ? nbytes / n_ray * n + 1 : 0;
}

/* Of a portion no more are handed out than of all; how many. */
static size_t keep_first(uint8_t *match, size_t n_ray, size_t most)
{
    size_t kept = 0;
    for (size_t i = 0; i < n_ray; i++) {
        match[i] = match[i] && kept < most;
        kept += match[i];
    }
    return kept;
}

static enum rmap_status mark_part(struct rmap_ray_parts *self, struct rmap_picker *picker,
                                  const size_t *portion, size_t n, struct marks *marks,
                                  size_t *nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t used = 0;
    for (size_t i = 0; i < n && !atomic_load(&self->stopped); i++) {
        const uint8_t *match = NULL;
        size_t n_ray = (size_t)rmap_map_portion(self->map, portion[i])->n_row[RMAP_TABLE_RAY];
        RMAP_TRY(rmap_picker_mark(picker, portion[i], &match, &marks->n[i], err));
        if (!match)
            continue;
        st = RMAP_RESERVE(marks->match, marks->cap_match, used + n_ray, err);
        RMAP_TRY(st);
        memcpy(marks->match + used, match, n_ray);
        if (marks->n[i] > self->limit)
            marks->n[i] = keep_first(marks->match + used, n_ray, (size_t)self->limit);
        marks->first[i] = used;
        used += n_ray;
        *nbytes += rays_nbytes(self->map, portion[i], marks->n[i]);
    }
out:
    return st;
}

static enum rmap_status read_part(struct rmap_ray_parts *self, struct rmap_picker *picker,
                                  const size_t *portion, size_t n, const struct marks *marks,
                                  struct rmap_sheaves *sheaves, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    sheaves->sheaf = rmap_alloc(n, sizeof *sheaves->sheaf);
    if (!sheaves->sheaf)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays of a part");
    for (size_t i = 0; i < n && !atomic_load(&self->stopped); i++) {
        const struct rmap_portion *rays = NULL;
        struct rmap_sheaf *sheaf = &sheaves->sheaf[sheaves->n];
        if (marks->n[i] == 0)
            continue;
        RMAP_TRY(rmap_picker_read(picker, portion[i], marks->match + marks->first[i], marks->n[i],
                                  &rays, err));
        RMAP_TRY(rmap_message_pack(rays, rmap_pick_columns(self->pick), &sheaf->message, err));
        sheaf->portion = portion[i];
        sheaves->n++;
    }
out:
    return st;
}

/* Takes room for the rays of a part, or waits for it. False: stopped. */
static bool take_room(struct rmap_ray_parts *self, size_t part, size_t nbytes)
{
    for (;; rmap_ray_parts_nap()) {
        size_t used = atomic_load(&self->in_use);
        if (atomic_load(&self->stopped))
            return false;
        if (used + nbytes > room_nbytes && part != atomic_load(&self->taken))
            continue;
        if (atomic_compare_exchange_strong(&self->in_use, &used, used + nbytes))
            return true;
    }
}

static enum rmap_status make_part(struct rmap_ray_parts *self, size_t part,
                                  struct rmap_picker *picker, struct marks *marks,
                                  struct slot *slot, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0, nbytes = 0;
    const size_t *portion = rmap_deal_part(self->deal, self->rank, part, &n);
    RMAP_TRY(mark_part(self, picker, portion, n, marks, &nbytes, err));
    if (nbytes == 0 || !take_room(self, part, nbytes))
        goto out;
    slot->nbytes = nbytes;
    RMAP_TRY(read_part(self, picker, portion, n, marks, &slot->sheaves, err));
out:
    return st;
}

static void finish(struct rmap_ray_parts *self, struct slot *slot, enum rmap_status st)
{
    slot->status = st;
    (void)pthread_mutex_lock(&self->lock);
    slot->done = true;
    (void)pthread_mutex_unlock(&self->lock);
}

/* Waits until the part's slot is free. */
static bool wait_for_slot(const struct rmap_ray_parts *self, size_t part)
{
    while (!atomic_load(&self->stopped)) {
        if (part - atomic_load(&self->taken) < self->n_slot)
            return true;
        rmap_ray_parts_nap();
    }
    return false;
}

static void work(void *context, int thread)
{
    struct rmap_ray_parts *self = context;
    struct rmap_picker *picker = NULL;
    struct marks marks = {0};
    struct rmap_error error = {0};
    (void)thread;
    enum rmap_status st = rmap_picker_create(self->map, self->pick, &picker, &error);
    if (st == RMAP_OK)
        st = marks_init(&marks, self->deal->step, &error);
    while (!atomic_load(&self->stopped)) {
        size_t part = atomic_fetch_add(&self->next, 1);
        if (part >= self->n_part || !wait_for_slot(self, part))
            break;
        struct slot *slot = &self->slot[part % self->n_slot];
        slot->error = error;
        finish(self, slot,
               st == RMAP_OK ? make_part(self, part, picker, &marks, slot, &slot->error) : st);
    }
    marks_fini(&marks);
    rmap_picker_destroy(picker);
}

enum rmap_status rmap_ray_parts_start(const struct rmap_map *map, const struct rmap_pick *pick,
                                      const struct rmap_deal *deal, uint64_t limit, int rank,
                                      int n_thread, struct rmap_ray_parts **parts_ret,
                                      struct rmap_error *err)
{
    struct rmap_ray_parts *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a stream of rays");
    (void)pthread_mutex_init(&self->lock, NULL);
    self->map = map;
    self->pick = pick;
    self->deal = deal;
    self->limit = limit;
    self->rank = rank;
    self->n_part = rmap_deal_n_part(deal, rank);
    self->n_slot = (size_t)n_thread * AHEAD;
    self->slot = rmap_alloc(self->n_slot, sizeof *self->slot);
    n_thread = rmap_map_readers(map, RMAP_COLUMNS_ALL, COPIES, n_thread);
    if (self->n_part < (size_t)n_thread)
        n_thread = self->n_part > 0 ? (int)self->n_part : 1;
    enum rmap_status st = RMAP_OK;
    if (!self->slot)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a stream of rays");
    else
        st = rmap_workers_start(n_thread, work, self, &self->workers, err);
    if (st == RMAP_OK)
        *parts_ret = self;
    else
        rmap_ray_parts_stop(self);
    return st;
}

enum rmap_status rmap_ray_parts_take(struct rmap_ray_parts *self, bool *done_ret,
                                     struct rmap_sheaves *sheaves, struct rmap_error *err)
{
    struct slot *slot = &self->slot[atomic_load(&self->taken) % self->n_slot];
    (void)pthread_mutex_lock(&self->lock);
    *done_ret = slot->done;
    (void)pthread_mutex_unlock(&self->lock);
    if (!*done_ret)
        return RMAP_OK;
    enum rmap_status st = slot->status;
    if (st != RMAP_OK && err)
        *err = slot->error;
    *sheaves = slot->sheaves;
    slot->sheaves = (struct rmap_sheaves){0};
    atomic_fetch_sub(&self->in_use, slot->nbytes);
    slot->nbytes = 0;
    slot->done = false;
    atomic_fetch_add(&self->taken, 1);
    return st;
}

void rmap_ray_parts_stop(struct rmap_ray_parts *self)
{
    if (!self)
        return;
    atomic_store(&self->stopped, true);
    if (self->workers)
        rmap_workers_join(self->workers);
    for (size_t i = 0; self->slot && i < self->n_slot; i++)
        rmap_sheaves_fini(&self->slot[i].sheaves);
    rmap_free(self->slot);
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self);
}
