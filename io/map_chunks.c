/* SPDX-License-Identifier: MIT
 *
 * Where the chunks of a piece lie. The table comes from the file, so nothing in it is believed:
 * each column must have exactly the chunks that its rows need, inside the file.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/codec.h"
#include "io/map_internal.h"
#include "io/provenance.h"
#include "io/publish.h"

char *rmap_map_piece_path(const struct rmap_map *map, size_t piece)
{
    return rmap_path_format("%s/%s", map->path, map->content.piece[piece].name);
}

static enum rmap_status check_file(const char *path, uint64_t nbytes, struct rmap_error *err)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return rmap_error_set(err, errno == ENOENT ? RMAP_FORMAT : RMAP_SYSTEM,
                              errno == ENOENT ? "%s is missing, though map.h5 lists it (%s)"
                                              : "%s cannot be read (%s)",
                              path, strerror(errno));
    if ((uint64_t)info.st_size != nbytes)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s has %lld bytes, but map.h5 says %llu: it was cut off or replaced",
                              path, (long long)info.st_size, (unsigned long long)nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_map_check_pieces(const struct rmap_map *map, struct rmap_error *err)
{
    for (size_t i = 0; i < map->content.n_piece; i++) {
        char *path = rmap_map_piece_path(map, i);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        enum rmap_status st = check_file(path, map->content.piece[i].nbytes, err);
        rmap_free(path);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

/* Our column of each dataset that the piece numbers, or -1. */
static enum rmap_status read_numbering(struct rmap_h5 *h5, enum rmap_colour_mode mode,
                                       int **column_ret, size_t *n_ret, struct rmap_error *err)
{
    char *name = NULL;
    size_t width = 0;
    enum rmap_status st = rmap_h5_read_names(h5, "/chunk/name", &name, n_ret, &width, err);
    if (st != RMAP_OK)
        return st;
    int *column = rmap_alloc(*n_ret, sizeof *column);
    for (size_t i = 0; column && i < *n_ret; i++) {
        column[i] = -1;
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
            if (strcmp(name + i * width, rmap_column_path((enum rmap_column)c, mode)) == 0)
                column[i] = c;
    }
    rmap_free(name);
    *column_ret = column;
    return column ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for column names");
}

static int by_column(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->column != y->column)
        return x->column < y->column ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Drops entries of unknown datasets, numbers the others our way, and sorts. */
static size_t renumber(struct rmap_chunk_entry *entry, size_t n, const int *column, size_t n_column)
{
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        if (entry[i].column >= n_column || column[entry[i].column] < 0)
            continue;
        entry[kept] = entry[i];
        entry[kept++].column = (uint16_t)column[entry[i].column];
    }
    if (kept > 0)
        qsort(entry, kept, sizeof *entry, by_column);
    return kept;
}

/* Finds each column's run of entries; false when one has not exactly its chunks, in the file. */
static bool place(const struct rmap_map *map, const struct rmap_piece_info *piece,
                  const struct rmap_chunk_entry *entry, size_t n, size_t *first)
{
    size_t at = 0;
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column c = (enum rmap_column)i;
        const struct rmap_column_info *info = rmap_column_info(c);
        uint64_t rows = piece->n_row[info->table];
        uint64_t n_chunk = rows / RMAP_CHUNK_ROWS + (rows % RMAP_CHUNK_ROWS != 0);
        size_t bound =
            rmap_codec_bound(RMAP_CHUNK_ROWS * rmap_column_width(c, map->scene->channels.n),
                             rmap_element_nbytes(info->element));
        first[i] = at;
        for (uint64_t k = 0; k < n_chunk; k++, at++)
            if (at >= n || entry[at].column != i || entry[at].index != k ||
                entry[at].nbytes > bound || entry[at].offset > piece->nbytes ||
                entry[at].nbytes > piece->nbytes - entry[at].offset)
                return false;
    }
    first[RMAP_COLUMN_COUNT] = at;
    return at == n;
}

static enum rmap_status load(const struct rmap_map *map, size_t piece,
                             struct rmap_piece_chunks *chunks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_field_table table = rmap_chunk_fields();
    const struct rmap_piece_info *info = &map->content.piece[piece];
    int *column = NULL;
    void *entry = NULL;
    size_t n = 0, n_column = 0;
    char *path = rmap_map_piece_path(map, piece);
    if (!path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    RMAP_TRY(check_file(path, info->nbytes, err));
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(rmap_provenance_check(&h5, RMAP_FILETYPE_PIECE, err));
    RMAP_TRY(read_numbering(&h5, map->scene->channels.mode, &column, &n_column, err));
    RMAP_TRY(
        rmap_h5_read_fields(&h5, table.field, table.n, sizeof *chunks->entry, &entry, &n, err));
    n = renumber(entry, n, column, n_column);
    if (!place(map, info, entry, n, chunks->first)) {
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s: its /chunk table does not fit the rows that map.h5 lists", path);
        goto out;
    }
    chunks->entry = entry;
    chunks->loaded = true;
    entry = NULL;
out:
    rmap_h5_drop(&h5);
    rmap_free(entry);
    rmap_free(column);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_piece_chunks(const struct rmap_map *map, size_t piece,
                                       const struct rmap_piece_chunks **chunks_ret,
                                       struct rmap_error *err)
{
    /* The table is a cache inside an otherwise constant map. */
    pthread_mutex_t *lock = &((struct rmap_map *)(uintptr_t)map)->lock;
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(lock);
    if (!map->chunks[piece].loaded)
        st = load(map, piece, &map->chunks[piece], err);
    (void)pthread_mutex_unlock(lock);
    *chunks_ret = &map->chunks[piece];
    return st;
}
