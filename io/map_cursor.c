/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/chunk_cache.h"
#include "io/codec.h"
#include "io/map_internal.h"
#include "io/shuffle.h"
#include "trace/event.h"

#define FILES_MAX 32

struct open_file {
    size_t piece;
    int fd; /* -1: none */
    uint64_t tick;
};

struct rmap_cursor {
    const struct rmap_map *map;
    rmap_column_set columns;
    struct rmap_portion *portion;
    struct rmap_decoder *decoder;
    uint8_t *stored;
    size_t stored_cap;
    /* Of the cursor's columns: chunks as byte planes, from which portions take their rows. */
    struct rmap_chunk_cache *cache[RMAP_COLUMN_COUNT];
    struct open_file file[FILES_MAX];
    uint64_t tick;
    uint64_t nbytes, nbytes_of_rows;
};

enum rmap_status rmap_cursor_create(const struct rmap_map *map, rmap_column_set columns,
                                    struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    self->map = map;
    self->columns = columns;
    for (int k = 0; k < FILES_MAX; k++)
        self->file[k].fd = -1;
    self->portion = rmap_alloc(1, sizeof *self->portion);
    if (!self->portion) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
        goto out;
    }
    self->portion->n_channel = map->scene->channels.n;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            RMAP_TRY(rmap_chunk_cache_create(
                RMAP_CHUNK_ROWS * rmap_portion_row_nbytes(self->portion, (enum rmap_column)c),
                (size_t)map->summary.n_shard, &self->cache[c], err));
    RMAP_TRY(rmap_decoder_create(&self->decoder, err));
    *cursor_ret = self;
    self = NULL;
out:
    rmap_cursor_destroy(self);
    return st;
}

void rmap_cursor_destroy(struct rmap_cursor *self)
{
    if (!self)
        return;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        rmap_chunk_cache_destroy(self->cache[c]);
    for (int k = 0; k < FILES_MAX; k++)
        if (self->file[k].fd >= 0)
            (void)close(self->file[k].fd);
    rmap_decoder_destroy(self->decoder);
    rmap_portion_destroy(self->portion);
    rmap_free(self->stored);
    rmap_free(self);
}

uint64_t rmap_cursor_nbytes(const struct rmap_cursor *self)
{
    return self->nbytes;
}

uint64_t rmap_cursor_nbytes_of_rows(const struct rmap_cursor *self)
{
    return self->nbytes_of_rows;
}

static enum rmap_status open_piece(struct rmap_cursor *self, size_t piece, int *fd_ret,
                                   struct rmap_error *err)
{
    struct open_file *oldest = &self->file[0];
    for (int k = 0; k < FILES_MAX; k++) {
        struct open_file *file = &self->file[k];
        if (file->fd >= 0 && file->piece == piece) {
            file->tick = ++self->tick;
            *fd_ret = file->fd;
            return RMAP_OK;
        }
        if (file->fd < 0 || (oldest->fd >= 0 && file->tick < oldest->tick))
            oldest = file;
    }
    char *path = rmap_map_piece_path(self->map, piece);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = RMAP_OK;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        st = rmap_error_set(err, errno == ENOENT ? RMAP_FORMAT : RMAP_SYSTEM,
                            "%s: cannot be opened: %s", path, strerror(errno));
    rmap_free(path);
    if (st != RMAP_OK)
        return st;
    if (oldest->fd >= 0)
        (void)close(oldest->fd);
    *oldest = (struct open_file){piece, fd, ++self->tick};
    *fd_ret = fd;
    return RMAP_OK;
}

static enum rmap_status read_exactly(int fd, uint8_t *to, size_t nbytes, uint64_t offset,
                                     struct rmap_error *err)
{
    while (nbytes > 0) {
        ssize_t got = pread(fd, to, nbytes, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return rmap_error_set(err, RMAP_SYSTEM, "reading failed: %s", strerror(errno));
        if (got == 0)
            return rmap_error_set(err, RMAP_FORMAT, "the file ends before the chunk does");
        to += got;
        nbytes -= (size_t)got;
        offset += (uint64_t)got;
    }
    return RMAP_OK;
}

/* Values that index the scene's tables must lie in them: [low, high). False: any value will do. */
static bool column_limits(const struct rmap_scene *scene, enum rmap_column column, int64_t *low,
                          int64_t *high)
{
    *low = -1;
    switch (column) {
    case RMAP_RAY_source:
        *low = 0;
        *high = (int64_t)scene->n_source;
        return true;
    case RMAP_RAY_stop:
        *low = 0;
        *high = RMAP_STOP_COUNT;
        return true;
    case RMAP_RAY_start_object:
    case RMAP_SEGMENT_object:
        *high = (int64_t)scene->n_object;
        return true;
    case RMAP_SEGMENT_medium:
        *high = (int64_t)scene->n_medium;
        return true;
    case RMAP_REGISTRATION_detector:
        *low = 0;
        *high = (int64_t)scene->n_detector;
        return true;
    default:
        return false;
    }
}

/* Written so that compilers make vectors of it: a mask, no branch. */
static bool all_within(enum rmap_element element, const void *data, size_t n, int64_t low,
                       int64_t high)
{
    const uint8_t *u8 = data;
    const int16_t *i16 = data;
    const int32_t *i32 = data;
    const int32_t least = (int32_t)low, end = (int32_t)high;
    int32_t outside = 0;
    for (size_t i = 0; element == RMAP_U8 && i < n; i++)
        outside |= u8[i] >= end;
    for (size_t i = 0; element == RMAP_I16 && i < n; i++)
        outside |= (i16[i] < least) | (i16[i] >= end);
    for (size_t i = 0; element == RMAP_I32 && i < n; i++)
        outside |= (i32[i] < least) | (i32[i] >= end);
    return !outside;
}

static enum rmap_status decode(struct rmap_cursor *self, enum rmap_column column,
                               const struct rmap_chunk_entry *entry, int fd, uint8_t *plane,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t width = rmap_column_width(column, self->portion->n_channel);
    struct rmap_stream_size size = {entry->nbytes, entry->lead_nbytes, entry->lead_planes};
    void *block = self->stored;
    st =
        rmap_reserve(&block, &self->stored_cap, (size_t)entry->nbytes + RMAP_DECODER_SLACK, 1, err);
    self->stored = block;
    if (st != RMAP_OK)
        return st;
    RMAP_TRY(read_exactly(fd, self->stored, entry->nbytes, entry->offset, err));
    self->nbytes += entry->nbytes;
    if (rmap_checksum(self->stored, entry->nbytes) != entry->checksum)
        return rmap_error_set(err, RMAP_FORMAT, "checksum does not match: the data are damaged");
    RMAP_TRY(rmap_decoder_planes(self->decoder, self->stored, &size, RMAP_CHUNK_ROWS * width,
                                 rmap_element_nbytes(rmap_column_info(column)->element), plane,
                                 err));
out:
    return st;
}

/* The chunk's planes, from the cache or the file. */
static enum rmap_status find_chunk(struct rmap_cursor *self, enum rmap_column column, size_t piece,
                                   uint64_t index, const uint8_t **plane_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_chunks *chunks;
    struct rmap_chunk_cache *cache = self->cache[column];
    uint8_t *plane;
    int fd = -1;
    *plane_ret = rmap_chunk_cache_find(cache, piece, index);
    if (*plane_ret)
        return RMAP_OK;
    RMAP_TRY(rmap_chunk_cache_room(cache, piece, index, &plane, err));
    RMAP_TRY(rmap_map_piece_chunks(self->map, piece, &chunks, err));
    RMAP_TRY(open_piece(self, piece, &fd, err));
    st = decode(self, column, &chunks->entry[chunks->first[column] + index], fd, plane, err);
    if (st != RMAP_OK) {
        rmap_error_context(err, "%s: %s chunk %llu", self->map->content.piece[piece].name,
                           rmap_column_path(column, self->map->scene->channels.mode),
                           (unsigned long long)index);
        goto out;
    }
    rmap_chunk_cache_keep(cache, piece, index);
    *plane_ret = plane;
out:
    return st;
}

static enum rmap_status check_limits(const struct rmap_cursor *self, enum rmap_column column,
                                     const struct rmap_portion_info *info, struct rmap_error *err)
{
    int64_t low, high;
    const struct rmap_column_info *what = rmap_column_info(column);
    if (!column_limits(self->map->scene, column, &low, &high) ||
        all_within(what->element, rmap_portion_column(self->portion, column),
                   self->portion->n_row[what->table], low, high))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: %s: a value of the block from ray %llu on names "
                          "nothing in the map's scene",
                          self->map->content.piece[info->piece].name, what->path,
                          (unsigned long long)info->first_ray);
}

/* Of the stored bytes of a chunk, those of its rows [first, last). Telescopes. */
static uint64_t share_of_chunk(const struct rmap_cursor *self, enum rmap_column column,
                               size_t piece, uint64_t index, size_t first, size_t last)
{
    const struct rmap_piece_chunks *chunks = &self->map->chunks[piece];
    uint64_t nbytes = chunks->entry[chunks->first[column] + index].nbytes;
    uint64_t rows = self->map->content.piece[piece].n_row[rmap_column_info(column)->table];
    rows -= index * RMAP_CHUNK_ROWS;
    rows = rows < RMAP_CHUNK_ROWS ? rows : RMAP_CHUNK_ROWS;
    return nbytes * last / rows - nbytes * first / rows;
}

static enum rmap_status read_column(struct rmap_cursor *self, enum rmap_column column,
                                    const struct rmap_portion_info *info, struct rmap_error *err)
{
    enum rmap_table table = rmap_column_info(column)->table;
    size_t width = rmap_column_width(column, self->portion->n_channel);
    size_t element = rmap_element_nbytes(rmap_column_info(column)->element);
    uint8_t *to = rmap_portion_column(self->portion, column);
    uint64_t at = info->first_row[table], end = at + info->n_row[table];
    while (at < end) {
        const uint8_t *plane = NULL;
        uint64_t index = at / RMAP_CHUNK_ROWS, skip = at % RMAP_CHUNK_ROWS;
        size_t n = (size_t)(end - at < RMAP_CHUNK_ROWS - skip ? end - at : RMAP_CHUNK_ROWS - skip);
        enum rmap_status st = find_chunk(self, column, (size_t)info->piece, index, &plane, err);
        if (st != RMAP_OK)
            return st;
        rmap_unshuffle(plane, RMAP_CHUNK_ROWS * width, (size_t)skip * width, n * width, element,
                       to);
        self->nbytes_of_rows += share_of_chunk(self, column, (size_t)info->piece, index,
                                               (size_t)skip, (size_t)skip + n);
        to += n * width * element;
        at += n;
    }
    return check_limits(self, column, info, err);
}

/* Counts must add up, or whoever walks the tables walks past their ends. */
static enum rmap_status check_counts(const struct rmap_cursor *self, const uint32_t *count,
                                     enum rmap_table table, size_t portion, struct rmap_error *err)
{
    uint64_t sum = 0;
    const struct rmap_portion *rows = self->portion;
    for (size_t i = 0; count && i < rows->n_row[RMAP_TABLE_RAY]; i++)
        sum += count[i];
    if (!count || sum == rows->n_row[table])
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: the counts of portion %zu do not add up to its %s",
                          self->map->path, portion, rmap_table_path[table]);
}

/* Cells index images. */
static enum rmap_status check_cells(const struct rmap_cursor *self, size_t portion,
                                    struct rmap_error *err)
{
    const struct rmap_registration_columns *hit = &self->portion->registration;
    const struct rmap_detector *detector = self->map->scene->detector;
    bool outside = false;
    if (!hit->cell || !hit->detector)
        return RMAP_OK;
    for (size_t i = 0; i < self->portion->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        const uint32_t *cells = detector[hit->detector[i]].cells;
        outside |= hit->cell[2 * i] >= cells[0] || hit->cell[2 * i + 1] >= cells[1];
    }
    if (!outside)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: a cell in portion %zu lies outside its detector",
                          self->map->path, portion);
}

enum rmap_status rmap_cursor_read(struct rmap_cursor *self, size_t portion,
                                  const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[portion];
    const struct rmap_piece_chunks *chunks;
    struct rmap_portion *rows = self->portion;
    rmap_portion_clear(rows);
    /* The piece's chunks vouch for its rows before memory is taken for them. */
    RMAP_TRY(rmap_map_piece_chunks(self->map, (size_t)info->piece, &chunks, err));
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(rows, (enum rmap_table)t, (size_t)info->n_row[t],
                                      self->columns, err));
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rows->n_row[t] = (size_t)info->n_row[t];
    rows->first_ray = info->first_ray;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->columns & RMAP_COLUMN_BIT(c))
            RMAP_TRY(read_column(self, (enum rmap_column)c, info, err));
    RMAP_TRY(check_counts(self, rows->ray.segment_count, RMAP_TABLE_SEGMENT, portion, err));
    RMAP_TRY(
        check_counts(self, rows->ray.registration_count, RMAP_TABLE_REGISTRATION, portion, err));
    RMAP_TRY(check_cells(self, portion, err));
    *portion_ret = rows;
out:
    return st;
}
