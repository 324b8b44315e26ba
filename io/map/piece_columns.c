/* SPDX-License-Identifier: MIT
 *
 * Columns of a compact piece that stand beside it as they are.
 */
#include "io/map/piece_columns.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "compact/streams.h"
#include "io/codec/codec.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_chunks.h"
#include "io/map/map_format.h"
#include "io/map/provenance.h"

rmap_column_set rmap_keepable_columns(void)
{
    return rmap_compact_traced(true);
}

char *rmap_piece_columns_path(const char *map_path, const struct rmap_piece_info *piece)
{
    return rmap_path_format("%s/shard-%05d/piece-%05d" RMAP_COLUMNS_SUFFIX, map_path,
                            (int)piece->shard, (int)piece->number);
}

void rmap_piece_columns_fini(struct rmap_piece_columns *columns)
{
    rmap_free(columns->entry);
    *columns = (struct rmap_piece_columns){0};
}

/* ---- reading a file ---- */

static int column_of(const char *path, const struct rmap_layout *plain)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (rmap_keepable_columns() & RMAP_COLUMN_BIT(c) &&
            strcmp(plain->stream[c].path, path) == 0)
            return c;
    return -1;
}

static int by_stream(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

static enum rmap_status misfit(const struct rmap_h5 *h5, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "%s: its chunks are not those of its columns",
                          h5->path);
}

/* Entries count columns of this program from here on; those of columns that it does not know go. */
static enum rmap_status name_streams(struct rmap_h5 *h5, const struct rmap_layout *plain,
                                     struct rmap_piece_columns *self, struct rmap_error *err)
{
    char *name = NULL;
    size_t n = 0, width = 0, kept = 0;
    enum rmap_status st = rmap_h5_read_names(h5, "/chunk/name", &name, &n, &width, err);
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        const int c = column_of(name + i * width, plain);
        if (c >= 0)
            self->columns |= RMAP_COLUMN_BIT(c);
    }
    for (size_t i = 0; i < self->n_entry && st == RMAP_OK; i++) {
        struct rmap_chunk_entry entry = self->entry[i];
        const int c = entry.stream < n ? column_of(name + entry.stream * width, plain) : -1;
        if (entry.stream >= n)
            st = misfit(h5, err);
        entry.stream = (uint16_t)c;
        if (c >= 0)
            self->entry[kept++] = entry;
    }
    self->n_entry = kept;
    rmap_free(name);
    return st;
}

/* Each column has exactly the chunks that its rows need, inside the file. */
static enum rmap_status check_chunks(const struct rmap_map *map, size_t piece,
                                     const struct rmap_layout *plain, struct rmap_h5 *h5,
                                     struct rmap_piece_columns *self, struct rmap_error *err)
{
    const struct rmap_piece_info *info = &map->content.piece[piece];
    size_t at = 0;
    if (self->n_entry > 0)
        qsort(self->entry, self->n_entry, sizeof *self->entry, by_stream);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const size_t n = RMAP_CHUNK_ROWS *
                         rmap_stream_width(&plain->stream[c], rmap_map_piece_n_channel(map, piece));
        const uint64_t n_row = info->n_row[rmap_column_info((enum rmap_column)c)->table];
        const uint64_t n_chunk = self->columns & RMAP_COLUMN_BIT(c)
                                     ? (n_row + RMAP_CHUNK_ROWS - 1) / RMAP_CHUNK_ROWS
                                     : 0;
        self->chunks.first[c] = at;
        for (uint64_t k = 0; k < n_chunk; k++, at++) {
            const struct rmap_chunk_entry *entry = &self->entry[at];
            if (at == self->n_entry || entry->stream != c || entry->index != k ||
                entry->offset > self->nbytes || entry->nbytes > self->nbytes - entry->offset ||
                entry->nbytes > rmap_codec_bound(n, rmap_element_nbytes(plain->stream[c].element)))
                return misfit(h5, err);
        }
    }
    for (int c = RMAP_COLUMN_COUNT; c <= RMAP_STREAM_MAX; c++)
        self->chunks.first[c] = at;
    self->chunks.entry = self->entry;
    self->chunks.loaded = true;
    return at == self->n_entry ? RMAP_OK : misfit(h5, err);
}

static enum rmap_status read_open(const struct rmap_map *map, size_t piece,
                                  const struct rmap_digest *its, struct rmap_h5 *h5,
                                  struct rmap_piece_columns *self, bool *is_stale_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char digest[33], own[33];
    void *entry = NULL;
    struct rmap_field_table fields = rmap_chunk_fields();
    const struct rmap_piece_info *info = &map->content.piece[piece];
    const struct rmap_layout *plain =
        rmap_layout_of(RMAP_ENCODING_PLAIN, map->spaces.space[info->space].mode);
    RMAP_TRY(rmap_provenance_check(h5, RMAP_FILETYPE_COLUMNS, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "digest", digest, sizeof digest, err));
    rmap_digest_text(*its, own);
    *is_stale_ret = strcmp(digest, own) != 0;
    if (*is_stale_ret)
        return rmap_error_set(err, RMAP_FORMAT, "%s: its columns are of other rays", h5->path);
    RMAP_TRY(rmap_h5_read_fields(h5, fields.field, fields.n, sizeof *self->entry, &entry,
                                 &self->n_entry, err));
    self->entry = entry;
    RMAP_TRY(name_streams(h5, plain, self, err));
    st = check_chunks(map, piece, plain, h5, self, err);
out:
    return st;
}

static enum rmap_status read_file(const struct rmap_map *map, size_t piece,
                                  const struct rmap_digest *digest, struct rmap_piece_columns *self,
                                  bool *is_stale_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct stat file;
    *self = (struct rmap_piece_columns){0};
    *is_stale_ret = false;
    if (!digest)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
    char *path = rmap_piece_columns_path(map->path, &map->content.piece[piece]);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (stat(path, &file) != 0)
        RMAP_TRY(rmap_error_set(err, errno == ENOENT ? RMAP_INPUT : RMAP_SYSTEM, "%s: %s", path,
                                strerror(errno)));
    self->nbytes = (uint64_t)file.st_size;
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    st = read_open(map, piece, digest, &h5, self, is_stale_ret, err);
out:
    rmap_h5_drop(&h5);
    if (st != RMAP_OK)
        rmap_piece_columns_fini(self);
    rmap_free(path);
    return st;
}

/* ---- those of an open map ---- */

struct slot {
    _Atomic bool is_known;
    enum rmap_status st;
    struct rmap_error why;
    struct rmap_piece_columns columns;
};

struct rmap_column_files {
    struct slot *slot; /* [n] */
    size_t n;
    struct rmap_digest *digest;          /* [n], once they were asked for */
    uint64_t (*first)[RMAP_TABLE_COUNT]; /* [n_portion], once a piece has columns */
};

void rmap_column_files_destroy(struct rmap_column_files *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n; i++)
        rmap_piece_columns_fini(&self->slot[i].columns);
    rmap_free(self->digest);
    rmap_free(self->first);
    rmap_free(self->slot);
    rmap_free(self);
}

/* Under the lock of HDF5. */
static struct rmap_column_files *files_of(struct rmap_map *map)
{
    if (map->column_files)
        return map->column_files;
    struct rmap_column_files *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->slot = rmap_alloc(map->content.n_piece, sizeof *self->slot);
    if (!self || !self->slot) {
        rmap_column_files_destroy(self);
        return NULL;
    }
    self->n = map->content.n_piece;
    map->column_files = self;
    return self;
}

static enum rmap_status list_first_rows(const struct rmap_map *map, struct rmap_column_files *self,
                                        struct rmap_error *err)
{
    uint64_t(*row)[RMAP_TABLE_COUNT] = rmap_alloc(map->content.n_piece, sizeof *row);
    self->first = rmap_alloc(map->content.n_portion, sizeof *self->first);
    for (size_t i = 0; row && self->first && i < map->content.n_portion; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
            self->first[i][t] = row[info->piece][t];
            row[info->piece][t] += info->n_row[t];
        }
    }
    rmap_free(row);
    return row && self->first ? RMAP_OK
                              : rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
}

/* Under the lock of HDF5. NULL: memory is short. */
static const struct rmap_digest *digest_of(const struct rmap_map *map, size_t piece,
                                           struct rmap_column_files *self)
{
    if (!self->digest && (self->digest = rmap_alloc(self->n, sizeof *self->digest)))
        for (size_t i = 0; i < map->content.n_portion; i++)
            rmap_digest_add(&self->digest[map->content.portion[i].piece],
                            map->content.portion[i].digest);
    return self->digest ? &self->digest[piece] : NULL;
}

static bool stands(const struct rmap_map *map, const struct rmap_piece_info *info)
{
    struct stat file;
    if (info->is_open || info->encoding != RMAP_ENCODING_COMPACT)
        return false;
    char *path = rmap_piece_columns_path(map->path, info);
    const bool is_there = path && stat(path, &file) == 0;
    rmap_free(path);
    return is_there;
}

/* Under the lock of HDF5. */
static void look(struct rmap_map *map, size_t piece, struct rmap_column_files *self)
{
    struct slot *slot = &self->slot[piece];
    bool is_stale = false;
    slot->st = RMAP_INPUT;
    if (stands(map, &map->content.piece[piece]))
        slot->st = read_file(map, piece, digest_of(map, piece, self), &slot->columns, &is_stale,
                             &slot->why);
    if (slot->st == RMAP_OK && !self->first)
        slot->st = list_first_rows(map, self, &slot->why);
    if (slot->st == RMAP_INPUT || is_stale)
        slot->st = RMAP_OK;
    if (slot->st == RMAP_FORMAT)
        rmap_error_context(&slot->why, "kept columns, which raymap keep --force makes again");
    atomic_store(&slot->is_known, true);
}

static struct slot *slot_of(const struct rmap_map *map, size_t piece)
{
    struct rmap_map *inside = (struct rmap_map *)(uintptr_t)map; /* a cache in a constant map */
    struct rmap_column_files *self = atomic_load(&inside->column_files);
    if (self && atomic_load(&self->slot[piece].is_known))
        return &self->slot[piece];
    (void)pthread_mutex_lock(&inside->hdf5_lock);
    self = files_of(inside);
    if (self && !self->slot[piece].is_known)
        look(inside, piece, self);
    (void)pthread_mutex_unlock(&inside->hdf5_lock);
    return self ? &self->slot[piece] : NULL;
}

const struct rmap_digest *rmap_map_piece_digest(const struct rmap_map *map, size_t piece)
{
    struct rmap_map *inside = (struct rmap_map *)(uintptr_t)map;
    (void)pthread_mutex_lock(&inside->hdf5_lock);
    struct rmap_column_files *self = files_of(inside);
    const struct rmap_digest *digest = self ? digest_of(map, piece, self) : NULL;
    (void)pthread_mutex_unlock(&inside->hdf5_lock);
    return digest;
}

enum rmap_status rmap_piece_columns_read(const struct rmap_map *map, size_t piece,
                                         struct rmap_piece_columns *self, bool *is_stale_ret,
                                         struct rmap_error *err)
{
    return read_file(map, piece, rmap_map_piece_digest(map, piece), self, is_stale_ret, err);
}

enum rmap_status rmap_map_columns_survey(const struct rmap_map *map,
                                         struct rmap_columns_survey *survey, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *survey = (struct rmap_columns_survey){.columns = RMAP_COLUMNS_ALL};
    for (size_t i = 0; i < map->content.n_piece && st == RMAP_OK; i++) {
        const struct rmap_piece_info *info = &map->content.piece[i];
        struct rmap_piece_columns columns;
        struct rmap_error why = {0};
        bool is_stale;
        if (info->is_open || info->encoding != RMAP_ENCODING_COMPACT)
            continue;
        survey->n_compact++;
        st = rmap_piece_columns_read(map, i, &columns, &is_stale, &why);
        if (st == RMAP_OK) {
            survey->n_piece++;
            survey->columns &= columns.columns;
            survey->nbytes += columns.nbytes;
        } else if (st == RMAP_FORMAT && survey->n_unused++ == 0) {
            survey->why = why;
        } else if (st == RMAP_SYSTEM) {
            (void)rmap_error_set(err, st, "%s", why.text);
        }
        st = st == RMAP_SYSTEM ? st : RMAP_OK;
        rmap_piece_columns_fini(&columns);
    }
    if (survey->n_piece == 0)
        survey->columns = 0;
    return st;
}

rmap_column_set rmap_map_columns_beside(const struct rmap_map *map, size_t piece)
{
    const struct slot *slot = slot_of(map, piece);
    return slot && slot->st == RMAP_OK ? slot->columns.columns : 0;
}

enum rmap_status rmap_map_piece_columns(const struct rmap_map *map, size_t piece,
                                        const struct rmap_piece_columns **columns_ret,
                                        struct rmap_error *err)
{
    const struct slot *slot = slot_of(map, piece);
    *columns_ret = NULL;
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
    if (slot->st != RMAP_OK)
        return rmap_error_set(err, slot->st, "%s", slot->why.text);
    if (slot->columns.columns)
        *columns_ret = &slot->columns;
    return RMAP_OK;
}

const uint64_t *rmap_map_first_rows(const struct rmap_map *map, size_t portion)
{
    return map->column_files->first[portion];
}
