/* SPDX-License-Identifier: MIT
 *
 * The history indexes of an open map: piece-KKKKK.history.h5 beside piece-KKKKK.h5, where it was
 * made (`raymap index`).
 */
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "history/history_builder.h"
#include "history/history_view.h"
#include "io/map/history_file.h"
#include "io/map/map_cursor.h"
#include "io/map/map_history.h"
#include "io/map/map_internal.h"

/* Those that nobody uses are let go beyond either. */
#define KEPT_NBYTES ((size_t)48 << 20)
#define KEPT_FILES  256

struct slot {
    struct rmap_history_index *index;
    struct rmap_history_bytes bytes; /* of one that is kept in memory */
    size_t nbytes;
    uint64_t last_use;
    int n_user;
    bool absent;  /* looked for, and not to be had */
    bool is_kept; /* for what was made of it */
};

struct rmap_histories {
    pthread_mutex_t lock;
    struct slot *slot; /* [n_piece] */
    size_t n_piece, n_open, nbytes, kept_nbytes;
    uint64_t clock;
    struct rmap_error damage; /* status: RMAP_OK, nothing noted so far */
    bool is_told;
};

static struct rmap_histories *create(size_t n_piece)
{
    struct rmap_histories *self = rmap_alloc(1, sizeof *self);
    struct slot *slot = rmap_alloc(n_piece, sizeof *slot);
    if (!self || !slot) {
        rmap_free(self);
        rmap_free(slot);
        return NULL;
    }
    (void)pthread_mutex_init(&self->lock, NULL);
    self->slot = slot;
    self->n_piece = n_piece;
    return self;
}

static void empty(struct rmap_histories *self, struct slot *slot)
{
    rmap_history_destroy(slot->index);
    rmap_free(slot->bytes.head);
    rmap_free(slot->bytes.body);
    self->nbytes -= slot->nbytes;
    self->n_open -= slot->index != NULL;
    *slot = (struct slot){0};
}

void rmap_histories_destroy(struct rmap_histories *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n_piece; i++)
        empty(self, &self->slot[i]);
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self->slot);
    rmap_free(self);
}

/* What is kept is a cache inside an otherwise constant map. */
static enum rmap_status histories_of(const struct rmap_map *map, struct rmap_histories **self_ret,
                                     struct rmap_error *err)
{
    struct rmap_map *inside = (struct rmap_map *)(uintptr_t)map;
    (void)pthread_mutex_lock(&inside->lock);
    if (!inside->histories)
        inside->histories = create(map->content.n_piece);
    *self_ret = inside->histories;
    (void)pthread_mutex_unlock(&inside->lock);
    return *self_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for indexes");
}

/* Makes room, the least recently used first. */
static void let_go(struct rmap_histories *self)
{
    while (self->nbytes - self->kept_nbytes > KEPT_NBYTES || self->n_open > KEPT_FILES) {
        struct slot *oldest = NULL;
        for (size_t i = 0; i < self->n_piece; i++) {
            struct slot *slot = &self->slot[i];
            if (slot->index && slot->n_user == 0 && !slot->bytes.head &&
                (!oldest || slot->last_use < oldest->last_use))
                oldest = slot;
        }
        if (!oldest)
            return;
        empty(self, oldest);
    }
}

static struct rmap_history_limits limits_of(const struct rmap_map *map)
{
    const struct rmap_scene *scene = map->scene[0];
    return (struct rmap_history_limits){scene->n_source, scene->n_object, scene->n_medium,
                                        scene->n_detector};
}

/* None of its portions may belong to other rays; those that an index does not take are not in it.
 */
static enum rmap_status compare(const struct rmap_map *map, size_t piece,
                                const struct rmap_history_index *index, const char *path,
                                struct rmap_error *err)
{
    size_t n_found = 0, n_portion = rmap_history_n_portion(index);
    for (size_t i = 0; i < map->content.n_portion; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        n_found += (size_t)info->piece == piece &&
                   rmap_history_find(index, info->first_ray, info->n_row, info->digest) != SIZE_MAX;
    }
    if (n_found == n_portion)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: %zu of its %s %s not those of its piece: make it again "
                          "with raymap index --force",
                          path, n_portion - n_found, rmap_counted(n_portion, "portion").text,
                          n_portion - n_found == 1 ? "is" : "are");
}

enum rmap_status rmap_map_history_open(const struct rmap_map *map, size_t piece,
                                       struct rmap_history_index **index_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_index *index = NULL;
    struct rmap_history_limits limits = limits_of(map);
    char *path = rmap_history_path(map->path, &map->content.piece[piece]);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    RMAP_TRY(rmap_history_file_open(path, &limits, &index, err));
    RMAP_TRY(compare(map, piece, index, path, err));
    if (index_ret) {
        *index_ret = index;
        index = NULL;
    }
out:
    rmap_history_destroy(index);
    rmap_free(path);
    return st;
}

/* Under the lock. why names the file. */
static void note(const struct rmap_map *map, struct rmap_histories *self, size_t piece,
                 const struct rmap_error *why)
{
    const bool is_compact = map->content.piece[piece].encoding == RMAP_ENCODING_COMPACT;
    if (self->damage.status == RMAP_OK)
        (void)rmap_error_set(&self->damage, RMAP_FORMAT,
                             "%s; its piece is read instead, which takes longer: raymap index %s "
                             "--force%s makes it again",
                             why->text, map->path, is_compact ? " --large" : "");
}

/* Under the lock. */
static enum rmap_status look(const struct rmap_map *map, struct rmap_histories *self, size_t piece,
                             struct rmap_error *err)
{
    struct slot *slot = &self->slot[piece];
    struct rmap_error why = {0};
    struct rmap_history_index *index = NULL;
    struct rmap_history_limits limits = limits_of(map);
    char *path = rmap_history_path(map->path, &map->content.piece[piece]);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    pthread_mutex_t *hdf5_lock = &((struct rmap_map *)(uintptr_t)map)->hdf5_lock;
    (void)pthread_mutex_lock(hdf5_lock);
    /* Portions of other rays are not found in it: nothing else need be compared. */
    enum rmap_status st = map->content.piece[piece].is_open
                              ? RMAP_INPUT
                              : rmap_history_file_open(path, &limits, &index, &why);
    (void)pthread_mutex_unlock(hdf5_lock);
    rmap_free(path);
    if (st == RMAP_SYSTEM) {
        if (err)
            *err = why;
        return st;
    }
    slot->absent = st != RMAP_OK;
    if (st == RMAP_FORMAT)
        note(map, self, piece, &why);
    if (st != RMAP_OK)
        return RMAP_OK;
    slot->index = index;
    slot->nbytes = rmap_history_nbytes(index);
    self->nbytes += slot->nbytes;
    self->n_open++;
    return RMAP_OK;
}

enum rmap_status rmap_map_history(const struct rmap_map *map, size_t piece,
                                  const struct rmap_history_index **index_ret,
                                  struct rmap_error *err)
{
    struct rmap_histories *self;
    *index_ret = NULL;
    enum rmap_status st = histories_of(map, &self, err);
    if (st != RMAP_OK)
        return st;
    (void)pthread_mutex_lock(&self->lock);
    struct slot *slot = &self->slot[piece];
    if (!slot->index && !slot->absent)
        st = look(map, self, piece, err);
    if (st == RMAP_OK && slot->index) {
        slot->n_user++;
        slot->last_use = ++self->clock;
        *index_ret = slot->index;
        let_go(self);
    }
    (void)pthread_mutex_unlock(&self->lock);
    return st;
}

void rmap_map_history_release(const struct rmap_map *map, size_t piece)
{
    struct rmap_histories *self = map->histories;
    (void)pthread_mutex_lock(&self->lock);
    self->slot[piece].n_user--;
    (void)pthread_mutex_unlock(&self->lock);
}

enum rmap_status rmap_map_history_keep(const struct rmap_map *map, size_t piece,
                                       struct rmap_history_bytes *bytes, struct rmap_error *err)
{
    struct rmap_histories *self;
    struct rmap_history_limits limits = limits_of(map);
    struct rmap_history_body body = {.bytes = bytes->body, .nbytes = bytes->body_nbytes};
    struct rmap_history_index *index = NULL;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(histories_of(map, &self, err));
    RMAP_TRY(rmap_history_open(bytes->head, bytes->head_nbytes, &body, &limits, &index, err));
    (void)pthread_mutex_lock(&self->lock);
    struct slot *slot = &self->slot[piece];
    if (slot->index) {
        st = rmap_error_set(err, RMAP_INTERNAL, "a piece has a history index already");
    } else {
        slot->index = index;
        slot->bytes = *bytes;
        slot->nbytes = rmap_history_nbytes(index) + bytes->body_nbytes;
        self->nbytes += slot->nbytes;
        self->kept_nbytes += slot->nbytes;
        self->n_open++;
        index = NULL;
        *bytes = (struct rmap_history_bytes){0};
    }
    (void)pthread_mutex_unlock(&self->lock);
out:
    rmap_history_destroy(index);
    return st;
}

void rmap_map_history_blame(const struct rmap_map *map, size_t piece, const struct rmap_error *why)
{
    struct rmap_histories *self = map->histories;
    struct rmap_error named = *why;
    char *path = rmap_history_path(map->path, &map->content.piece[piece]);
    rmap_error_context(&named, "%s", path ? path : map->path);
    (void)pthread_mutex_lock(&self->lock);
    note(map, self, piece, &named);
    (void)pthread_mutex_unlock(&self->lock);
    rmap_free(path);
}

bool rmap_map_history_damage(const struct rmap_map *map, struct rmap_error *why_ret)
{
    struct rmap_histories *self = map->histories;
    if (!self)
        return false;
    (void)pthread_mutex_lock(&self->lock);
    *why_ret = self->damage;
    const bool is_news = why_ret->status != RMAP_OK && !self->is_told;
    (void)pthread_mutex_unlock(&self->lock);
    return is_news;
}

void rmap_map_history_told(const struct rmap_map *map)
{
    struct rmap_histories *self;
    if (histories_of(map, &self, NULL) != RMAP_OK)
        return; /* told twice, perhaps */
    (void)pthread_mutex_lock(&self->lock);
    self->is_told = true;
    (void)pthread_mutex_unlock(&self->lock);
}

/* Whether the index of a piece, which the caller has, stays open until the map is closed: what is
 * made of it may be kept, then. Thread-safe. */
static bool map_history_stays(const struct rmap_map *map, size_t piece)
{
    struct rmap_histories *self = map->histories;
    (void)pthread_mutex_lock(&self->lock);
    struct slot *slot = &self->slot[piece];
    if (!slot->is_kept && !slot->bytes.head && map->arena &&
        rmap_arena_claim(map->arena, slot->nbytes)) {
        self->kept_nbytes += slot->nbytes;
        slot->n_user++; /* for good */
        slot->is_kept = true;
    }
    bool stays = slot->is_kept || slot->bytes.head;
    (void)pthread_mutex_unlock(&self->lock);
    return stays;
}

/* Indexes that are in memory for good: those that were given to the map, and those of views that
 * are kept. */
static size_t map_history_kept_nbytes(const struct rmap_map *map)
{
    struct rmap_histories *self = map->histories;
    if (!self)
        return 0;
    (void)pthread_mutex_lock(&self->lock);
    size_t nbytes = self->kept_nbytes;
    (void)pthread_mutex_unlock(&self->lock);
    return nbytes;
}

enum rmap_status rmap_map_history_make(const struct rmap_map *map, size_t piece, size_t most,
                                       void (*tick)(void *context, uint64_t n_row), void *context,
                                       struct rmap_history_bytes *bytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    struct rmap_history_builder *builder = NULL;
    RMAP_TRY(rmap_cursor_create(map, RMAP_HISTORY_COLUMNS, &cursor, err));
    RMAP_TRY(rmap_history_builder_create(&builder, err));
    for (size_t i = 0; i < map->content.n_portion && most > 0; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        const struct rmap_portion *portion;
        if ((size_t)info->piece != piece)
            continue;
        most--;
        RMAP_TRY(rmap_cursor_read(cursor, i, &portion, err));
        RMAP_TRY(rmap_history_builder_add(builder, portion, info->digest, err));
        if (tick)
            tick(context, info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
    }
    st = rmap_history_builder_finish(builder, bytes, err);
out:
    rmap_history_builder_destroy(builder);
    rmap_cursor_destroy(cursor);
    return st;
}

enum rmap_status rmap_map_history_measure(const struct rmap_map *map, size_t *n_piece_ret,
                                          uint64_t *nbytes_ret, struct rmap_error *err)
{
    *n_piece_ret = 0;
    *nbytes_ret = 0;
    for (size_t i = 0; i < map->content.n_piece; i++) {
        struct stat file;
        char *path = rmap_history_path(map->path, &map->content.piece[i]);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
        if (stat(path, &file) == 0) {
            *n_piece_ret += 1;
            *nbytes_ret += (uint64_t)file.st_size;
        }
        rmap_free(path);
    }
    return RMAP_OK;
}

enum rmap_status rmap_map_history_survey(const struct rmap_map *map,
                                         struct rmap_history_survey *survey, struct rmap_error *err)
{
    *survey = (struct rmap_history_survey){0};
    enum rmap_status st = rmap_map_history_measure(map, &survey->n_piece, &survey->nbytes, err);
    if (st != RMAP_OK || survey->n_piece == 0)
        return st;
    for (size_t i = 0; i < map->content.n_piece; i++) {
        struct rmap_error why = {0};
        st = rmap_map_history_open(map, i, NULL, &why);
        if (st == RMAP_OK || st == RMAP_INPUT)
            continue;
        if (survey->n_unused++ == 0)
            survey->why = why;
    }
    return RMAP_OK;
}

enum rmap_status rmap_map_history_check(const struct rmap_map *map, size_t piece,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_index *index = NULL;
    struct rmap_history_view view = {0};
    RMAP_TRY(rmap_map_history_open(map, piece, &index, err));
    for (size_t i = 0; i < rmap_history_n_portion(index); i++)
        RMAP_TRY(rmap_history_view_open(index, i, &view, err));
out:
    rmap_history_view_fini(&view);
    rmap_history_destroy(index);
    return st;
}

/* What of an open map stays in memory from one question to the next. */

/* Indexes that the map was given count from the start, as many of their bytes as may. */
static void claim_given(struct rmap_map *map, size_t budget_nbytes)
{
    const size_t given = map_history_kept_nbytes(map);
    (void)rmap_arena_claim(map->arena, given < budget_nbytes ? given : budget_nbytes);
}

enum rmap_status rmap_map_keep(struct rmap_map *map, size_t budget_nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_portion = map->content.n_portion;
    if (map->arena)
        return rmap_error_set(err, RMAP_USAGE, "%s: columns are kept already", map->path);
    RMAP_TRY(rmap_arena_create(budget_nbytes, &map->arena, err));
    claim_given(map, budget_nbytes);
    RMAP_TRY(rmap_kept_views_create(n_portion, map->arena, &map->views, err));
    RMAP_TRY(rmap_column_store_create(n_portion, map->arena, &map->store, err));
out:
    return st;
}

rmap_column_set rmap_map_borrow_columns(const struct rmap_map *map, size_t portion,
                                        rmap_column_set columns, struct rmap_portion *rows)
{
    rmap_column_set found = 0;
    for (int c = 0; map->store && c < RMAP_COLUMN_COUNT; c++) {
        void *kept = columns & RMAP_COLUMN_BIT(c)
                         ? rmap_column_store_get(map->store, portion, (enum rmap_column)c)
                         : NULL;
        if (!kept)
            continue;
        *rmap_portion_column_address(rows, (enum rmap_column)c) = kept;
        found |= RMAP_COLUMN_BIT(c);
    }
    return found;
}

void rmap_map_keep_columns(const struct rmap_map *map, size_t portion, rmap_column_set columns,
                           const struct rmap_portion *rows)
{
    for (int c = 0; map->store && c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            rmap_column_store_offer(map->store, portion, (enum rmap_column)c,
                                    rmap_portion_column(rows, (enum rmap_column)c),
                                    rows->n_row[rmap_column_info((enum rmap_column)c)->table] *
                                        rmap_portion_row_nbytes(rows, (enum rmap_column)c));
}

enum rmap_status rmap_history_reader_enter(const struct rmap_map *map,
                                           const struct rmap_history_index *index, size_t at,
                                           size_t portion, struct rmap_history_reader *self,
                                           struct rmap_error *err)
{
    rmap_history_reader_leave(map, self);
    self->portion = portion;
    self->borrowed = map->views ? rmap_kept_views_borrow(map->views, portion) : NULL;
    enum rmap_status st =
        self->borrowed ? rmap_history_view_reopen(index, at, self->borrowed, &self->view, err)
                       : rmap_history_view_open(index, at, &self->view, err);
    self->is_open = st == RMAP_OK;
    if (self->is_open && !self->borrowed)
        self->nbytes += self->view.nbytes;
    if (!self->is_open)
        rmap_history_reader_leave(map, self);
    return st;
}

void rmap_history_reader_leave(const struct rmap_map *map, struct rmap_history_reader *self)
{
    if (self->borrowed)
        rmap_kept_views_give_back(map->views, self->portion, self->borrowed);
    else if (self->is_open && map->views &&
             map_history_stays(map, (size_t)map->content.portion[self->portion].piece))
        rmap_kept_views_offer(map->views, self->portion, &self->view);
    self->borrowed = NULL;
    self->is_open = false;
}

void rmap_history_reader_fini(const struct rmap_map *map, struct rmap_history_reader *self)
{
    rmap_history_reader_leave(map, self);
    rmap_history_view_fini(&self->view);
}

void rmap_map_kept(const struct rmap_map *map, struct rmap_map_kept *kept)
{
    *kept = (struct rmap_map_kept){.indexes = map_history_kept_nbytes(map)};
    if (!map->arena)
        return;
    kept->budget = rmap_arena_limit(map->arena);
    kept->taken = rmap_arena_nbytes(map->arena);
    kept->views = map->views ? rmap_kept_views_nbytes(map->views) : 0;
    kept->columns = map->store ? rmap_column_store_nbytes(map->store) : 0;
}
