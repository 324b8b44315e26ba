/* SPDX-License-Identifier: MIT
 *
 * Rows of a map's streams, from stored chunks by pread and our own inflate, or from a journal's
 * tails.
 */
#include "io/map/chunk_reader.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/codec/shuffle.h"
#include "io/file/read_exactly.h"
#include "io/map/chunk_cache.h"
#include "io/map/map_chunks.h"
#include "io/map/map_internal.h"
#include "io/map/map_memory.h"
#include "io/map/piece_columns.h"
#include "io/map/piece_file.h"

#define FILES_MAX     32
#define BUDGET_NBYTES ((size_t)64 << 20) /* of inflated chunks, at most */

struct open_file {
    size_t piece;
    bool is_beside; /* the file of its kept columns */
    int fd;         /* -1: none */
    uint64_t tick;
};

struct rmap_chunk_reader {
    const struct rmap_map *map;
    struct rmap_decoder *decoder;
    uint8_t *stored;
    size_t stored_cap;
    /* Chunks as byte planes, from which rows are taken; made when first read. */
    struct rmap_chunk_cache *cache[RMAP_ENCODING_COUNT][RMAP_STREAM_MAX];
    struct rmap_chunk_cache *kept[RMAP_STREAM_MAX]; /* of columns beside compact pieces */
    struct rmap_chunk_budget budget;                /* of all caches */
    struct open_file file[FILES_MAX];
    uint64_t tick;
    bool is_counted; /* among those that share the map's bytes: it has read chunks */
    uint64_t nbytes, nbytes_of_rows;
};

/* A stream of a piece, or a column beside it, looked up once per read. */
struct place {
    size_t piece;
    bool is_beside;
    int stream;
    uint64_t n_row; /* in the piece */
    const struct rmap_stream_info *info;
    const struct rmap_piece_chunks *chunks;
    struct rmap_chunk_cache *cache;
    size_t width, element;
};

/* What is in use is counted inside an otherwise constant map. */
static _Atomic int *n_reader(const struct rmap_map *map)
{
    return &((struct rmap_map *)(uintptr_t)map)->n_reader;
}

enum rmap_status rmap_chunk_reader_create(const struct rmap_map *map,
                                          struct rmap_chunk_reader **reader_ret,
                                          struct rmap_error *err)
{
    struct rmap_chunk_reader *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    self->map = map;
    for (int k = 0; k < FILES_MAX; k++)
        self->file[k].fd = -1;
    enum rmap_status st = rmap_decoder_create(&self->decoder, err);
    if (st != RMAP_OK) {
        rmap_free(self);
        return st;
    }
    *reader_ret = self;
    return RMAP_OK;
}

/* All readers of a map share what its queries may hold of chunks. */
static void share_budget(struct rmap_chunk_reader *self)
{
    if (!self->is_counted)
        atomic_fetch_add(n_reader(self->map), 1);
    self->is_counted = true;
    size_t share = rmap_map_share(self->map, RMAP_CHUNKS_NBYTES);
    self->budget.limit_nbytes = share < BUDGET_NBYTES ? share : BUDGET_NBYTES;
}

void rmap_chunk_reader_destroy(struct rmap_chunk_reader *self)
{
    if (!self)
        return;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++)
        for (int s = 0; s < RMAP_STREAM_MAX; s++)
            rmap_chunk_cache_destroy(self->cache[e][s]);
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_chunk_cache_destroy(self->kept[s]);
    for (int k = 0; k < FILES_MAX; k++)
        if (self->file[k].fd >= 0)
            (void)close(self->file[k].fd);
    rmap_decoder_destroy(self->decoder);
    rmap_free(self->stored);
    if (self->is_counted)
        atomic_fetch_sub(n_reader(self->map), 1);
    rmap_free(self);
}

uint64_t rmap_chunk_reader_nbytes(const struct rmap_chunk_reader *self)
{
    return self->nbytes;
}

uint64_t rmap_chunk_reader_nbytes_of_rows(const struct rmap_chunk_reader *self)
{
    return self->nbytes_of_rows;
}

void rmap_chunk_reader_set_nbytes_of_rows(struct rmap_chunk_reader *self, uint64_t nbytes)
{
    self->nbytes_of_rows = nbytes;
}

static int open_file(const struct rmap_map *map, const struct place *place, const char *path)
{
    return place->is_beside ? open(path, O_RDONLY | O_CLOEXEC)
                            : rmap_piece_file_open(map->path, &map->content.piece[place->piece]);
}

static enum rmap_status open_piece(struct rmap_chunk_reader *self, const struct place *place,
                                   int *fd_ret, struct rmap_error *err)
{
    const size_t piece = place->piece;
    struct open_file *oldest = &self->file[0];
    for (int k = 0; k < FILES_MAX; k++) {
        struct open_file *file = &self->file[k];
        if (file->fd >= 0 && file->piece == piece && file->is_beside == place->is_beside) {
            file->tick = ++self->tick;
            *fd_ret = file->fd;
            return RMAP_OK;
        }
        if (file->fd < 0 || (oldest->fd >= 0 && file->tick < oldest->tick))
            oldest = file;
    }
    char *path = place->is_beside
                     ? rmap_piece_columns_path(self->map->path, &self->map->content.piece[piece])
                     : rmap_map_piece_path(self->map, piece);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = RMAP_OK;
    int fd = open_file(self->map, place, path);
    if (fd < 0)
        st = rmap_error_set(err, errno == ENOENT ? RMAP_FORMAT : RMAP_SYSTEM,
                            "%s: cannot be opened: %s", path, strerror(errno));
    rmap_free(path);
    if (st != RMAP_OK)
        return st;
    if (oldest->fd >= 0)
        (void)close(oldest->fd);
    *oldest = (struct open_file){piece, place->is_beside, fd, ++self->tick};
    *fd_ret = fd;
    return RMAP_OK;
}

static enum rmap_status read_stored(struct rmap_chunk_reader *self,
                                    const struct rmap_chunk_entry *entry, int fd,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    st = RMAP_RESERVE(self->stored, self->stored_cap, (size_t)entry->nbytes + RMAP_INFLATE_SLACK,
                      err);
    if (st != RMAP_OK)
        return st;
    memset(self->stored + entry->nbytes, 0, RMAP_INFLATE_SLACK);
    RMAP_TRY(rmap_read_exactly(fd, self->stored, entry->nbytes, entry->offset, err));
    self->nbytes += entry->nbytes;
    if (rmap_checksum(self->stored, entry->nbytes) != entry->checksum)
        st = rmap_error_set(err, RMAP_FORMAT, "checksum does not match: the data are damaged");
out:
    return st;
}

static enum rmap_status decode(struct rmap_chunk_reader *self, const struct place *place,
                               const struct rmap_chunk_entry *entry, int fd, uint8_t *plane,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(read_stored(self, entry, fd, err));
    RMAP_TRY(rmap_decoder_planes(self->decoder, self->stored, entry->nbytes,
                                 RMAP_CHUNK_ROWS * place->width, place->element, plane, err));
out:
    return st;
}

/* The chunk's planes, from the cache or the file. */
static enum rmap_status find_chunk(struct rmap_chunk_reader *self, const struct place *place,
                                   uint64_t index, const uint8_t **plane_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *plane;
    int fd = -1;
    *plane_ret = rmap_chunk_cache_find(place->cache, place->piece, index);
    if (*plane_ret)
        return RMAP_OK;
    RMAP_TRY(rmap_chunk_cache_room(place->cache, place->piece, index, &plane, err));
    RMAP_TRY(open_piece(self, place, &fd, err));
    st = decode(self, place, &place->chunks->entry[place->chunks->first[place->stream] + index], fd,
                plane, err);
    if (st != RMAP_OK) {
        rmap_error_context(err, "%s%s: %s chunk %llu", place->is_beside ? "kept columns of " : "",
                           self->map->content.piece[place->piece].name, place->info->path,
                           (unsigned long long)index);
        goto out;
    }
    rmap_chunk_cache_keep(place->cache, place->piece, index);
    *plane_ret = plane;
out:
    return st;
}

/* Rows of the piece in a chunk; what else stands there is 0. */
static uint64_t rows_of_chunk(const struct place *place, uint64_t index)
{
    const uint64_t rows = place->n_row - index * RMAP_CHUNK_ROWS;
    return rows < RMAP_CHUNK_ROWS ? rows : RMAP_CHUNK_ROWS;
}

/* Of the stored bytes of a chunk, those of its rows [first, last). Telescopes. */
static uint64_t share_of_chunk(const struct place *place, uint64_t index, size_t first, size_t last)
{
    uint64_t nbytes = place->chunks->entry[place->chunks->first[place->stream] + index].nbytes;
    uint64_t rows = rows_of_chunk(place, index);
    return nbytes * last / rows - nbytes * first / rows;
}

/* What a place of that stream takes; its chunks are known. */
static enum rmap_status prepare(struct rmap_chunk_reader *self, struct place *place,
                                struct rmap_chunk_cache **cache, struct rmap_error *err)
{
    const struct rmap_map *map = self->map;
    enum rmap_status st = RMAP_OK;
    place->width = rmap_stream_width(place->info, rmap_map_piece_n_channel(map, place->piece));
    place->element = rmap_element_nbytes(place->info->element);
    share_budget(self);
    if (!*cache)
        st = rmap_chunk_cache_create(&self->budget,
                                     RMAP_CHUNK_ROWS *
                                         rmap_stream_row_nbytes(place->info, map->n_channel_max),
                                     (size_t)map->summary.n_shard, cache, err);
    place->cache = *cache;
    return st;
}

/* Rows that the journal holds, behind the last stored chunk. */
static size_t copy_tail(struct rmap_chunk_reader *self, const struct place *place, uint64_t at,
                        size_t n, uint8_t *to)
{
    const struct rmap_stream_tail *tail =
        rmap_map_content_tail(&self->map->content, place->piece, place->stream);
    size_t row = place->width * place->element, skip = (size_t)(at % RMAP_CHUNK_ROWS);
    if (!tail || tail->n_row < skip + n || tail->nbytes / row < skip + n)
        return 0;
    memcpy(to, tail->data + skip * row, n * row);
    self->nbytes_of_rows += n * row;
    return n;
}

static enum rmap_status read_rows(struct rmap_chunk_reader *self, const struct place *place,
                                  uint64_t first, size_t n_row, uint8_t *out,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t *of = &place->chunks->first[place->stream], n_chunk = of[1] - of[0];
    for (uint64_t at = first, end = first + n_row; at < end;) {
        const uint8_t *plane = NULL;
        uint64_t index = at / RMAP_CHUNK_ROWS, skip = at % RMAP_CHUNK_ROWS;
        size_t n = (size_t)(end - at < RMAP_CHUNK_ROWS - skip ? end - at : RMAP_CHUNK_ROWS - skip);
        if (index < n_chunk) {
            st = find_chunk(self, place, index, &plane, err);
            if (st != RMAP_OK)
                return st;
            rmap_unshuffle(plane, RMAP_CHUNK_ROWS * place->width, (size_t)skip * place->width,
                           n * place->width, place->element, out);
            self->nbytes_of_rows += share_of_chunk(place, index, (size_t)skip, (size_t)skip + n);
        } else if (place->is_beside || copy_tail(self, place, at, n, out) != n) {
            return rmap_error_set(err, RMAP_FORMAT, "%s: %s: rows from %llu on are not there",
                                  self->map->content.piece[place->piece].name, place->info->path,
                                  (unsigned long long)at);
        }
        out += n * place->width * place->element;
        at += n;
    }
    return st;
}

enum rmap_status rmap_chunk_reader_rows(struct rmap_chunk_reader *self, size_t piece, int stream,
                                        uint64_t first, size_t n, void *to, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_layout *layout = rmap_map_piece_layout(self->map, piece);
    const struct rmap_stream_info *info = &layout->stream[stream];
    struct place place = {.piece = piece,
                          .stream = stream,
                          .info = info,
                          .n_row = self->map->content.piece[piece].stored_rows[info->table]};
    RMAP_TRY(rmap_map_piece_chunks(self->map, piece, &place.chunks, err));
    RMAP_TRY(prepare(self, &place, &self->cache[layout->encoding][stream], err));
    st = read_rows(self, &place, first, n, to, err);
out:
    return st;
}

enum rmap_status rmap_chunk_reader_kept(struct rmap_chunk_reader *self, size_t piece, int column,
                                        uint64_t first, size_t n, void *to, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_info *info = &self->map->content.piece[piece];
    const enum rmap_colour_mode mode = self->map->spaces.space[info->space].mode;
    const struct rmap_piece_columns *columns;
    struct place place = {.piece = piece,
                          .is_beside = true,
                          .stream = column,
                          .info = &rmap_layout_of(RMAP_ENCODING_PLAIN, mode)->stream[column],
                          .n_row = info->n_row[rmap_column_info((enum rmap_column)column)->table]};
    RMAP_TRY(rmap_map_piece_columns(self->map, piece, &columns, err));
    if (!columns)
        return rmap_error_set(err, RMAP_INTERNAL, "%s has no kept columns", info->name);
    place.chunks = &columns->chunks;
    RMAP_TRY(prepare(self, &place, &self->kept[column], err));
    st = read_rows(self, &place, first, n, to, err);
    if (st == RMAP_FORMAT && err)
        (void)strncat(err->text, "; raymap keep --force makes them again",
                      sizeof err->text - strlen(err->text) - 1);
out:
    return st;
}
