/* SPDX-License-Identifier: MIT
 *
 * Where the chunks of a piece lie. The table comes from a file, so nothing in it is believed: each
 * stream must have exactly the chunks that its rows need, inside the piece's file.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/file/publish.h"
#include "io/map/map_chunks.h"
#include "io/map/map_internal.h"
#include "io/map/piece_file.h"

char *rmap_map_piece_path(const struct rmap_map *map, size_t piece)
{
    return rmap_path_format("%s/%s", map->path, map->content.piece[piece].name);
}

const struct rmap_layout *rmap_map_piece_layout(const struct rmap_map *map, size_t piece)
{
    return rmap_piece_layout(
        &map->content.piece[piece],
        (enum rmap_colour_mode)map->spaces.space[map->content.piece[piece].space].mode);
}

int rmap_map_piece_n_channel(const struct rmap_map *map, size_t piece)
{
    return map->spaces.space[map->content.piece[piece].space].n_channel;
}

/* A sealed piece has one size for ever; an open one has at least what its journal saw. */
static enum rmap_status check_file(const struct rmap_map *map, const char *path,
                                   const struct rmap_piece_info *piece, struct rmap_error *err)
{
    struct stat info;
    if (rmap_piece_file_stat(map->path, piece, &info) != 0)
        return rmap_error_set(err, errno == ENOENT ? RMAP_FORMAT : RMAP_SYSTEM,
                              errno == ENOENT ? "%s is missing, though map.h5 lists it (%s)"
                                              : "%s cannot be read (%s)",
                              path, strerror(errno));
    if (piece->is_open   ? (uint64_t)info.st_size < piece->nbytes
        : map->takes_cut ? (uint64_t)info.st_size > piece->nbytes
                         : (uint64_t)info.st_size != piece->nbytes)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s has %lld bytes, but map.h5 says %llu: it was cut off or replaced",
                              path, (long long)info.st_size, (unsigned long long)piece->nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_map_check_pieces(const struct rmap_map *map, struct rmap_error *err)
{
    for (size_t i = 0; i < map->content.n_piece; i++) {
        if (map->content.piece[i].is_open) /* was examined when it was found */
            continue;
        char *path = rmap_map_piece_path(map, i);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        enum rmap_status st = check_file(map, path, &map->content.piece[i], err);
        rmap_free(path);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

static int by_stream(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Rows of a stream that its stored chunks must hold: all, but for those in a journal. */
static uint64_t rows_in_chunks(const struct rmap_map *map, size_t piece, int stream, uint64_t rows)
{
    const struct rmap_stream_tail *tail = rmap_map_content_tail(&map->content, piece, stream);
    if (tail && tail->first_row <= rows && tail->n_row >= rows - tail->first_row)
        return tail->first_row;
    return rows;
}

/* Finds each stream's run of entries; false when one has not exactly its chunks, in the file. */
static bool place(const struct rmap_map *map, size_t piece, const struct rmap_chunk_entry *entry,
                  size_t *first)
{
    const struct rmap_piece_info *info = &map->content.piece[piece];
    const struct rmap_layout *layout = rmap_map_piece_layout(map, piece);
    size_t at = 0, n = (size_t)info->n_chunk;
    uint64_t left = info->nbytes; /* chunks share no bytes: a small file must not be many chunks */
    for (int s = 0; s < layout->n_stream; s++) {
        const struct rmap_stream_info *stream = &layout->stream[s];
        uint64_t rows = rows_in_chunks(map, piece, s, info->stored_rows[stream->table]);
        uint64_t n_chunk = rows / RMAP_CHUNK_ROWS + (rows % RMAP_CHUNK_ROWS != 0);
        size_t width = rmap_stream_width(stream, rmap_map_piece_n_channel(map, piece));
        size_t bound =
            rmap_codec_bound(RMAP_CHUNK_ROWS * width, rmap_element_nbytes(stream->element));
        first[s] = at;
        for (uint64_t k = 0; k < n_chunk; k++, at++)
            if (at >= n || entry[at].stream != s || entry[at].index != k ||
                entry[at].nbytes > bound || entry[at].offset > info->nbytes ||
                entry[at].nbytes > info->nbytes - entry[at].offset || entry[at].nbytes > left)
                return false;
            else
                left -= entry[at].nbytes;
    }
    first[layout->n_stream] = at;
    return at == n;
}

static enum rmap_status load(struct rmap_map *map, size_t piece, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_info *info = &map->content.piece[piece];
    struct rmap_piece_chunks *chunks = &map->chunks[piece];
    struct rmap_chunk_entry *entry = map->content.chunk + info->first_chunk;
    char *path = rmap_map_piece_path(map, piece);
    if (!path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    RMAP_TRY(check_file(map, path, info, err));
    if (info->n_chunk > 0)
        qsort(entry, (size_t)info->n_chunk, sizeof *entry, by_stream);
    if (!place(map, piece, entry, chunks->first)) {
        st =
            rmap_error_set(err, RMAP_FORMAT, "%s: its table of chunks does not fit its rows", path);
        goto out;
    }
    chunks->entry = entry;
    chunks->loaded = true;
out:
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_piece_chunks(const struct rmap_map *map, size_t piece,
                                       const struct rmap_piece_chunks **chunks_ret,
                                       struct rmap_error *err)
{
    /* The table is a cache inside an otherwise constant map. */
    struct rmap_map *inside = (struct rmap_map *)(uintptr_t)map;
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(&inside->lock);
    if (!map->chunks[piece].loaded)
        st = load(inside, piece, err);
    (void)pthread_mutex_unlock(&inside->lock);
    *chunks_ret = &map->chunks[piece];
    return st;
}
