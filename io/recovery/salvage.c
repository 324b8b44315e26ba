/* SPDX-License-Identifier: MIT
 *
 * An undamaged piece is copied: its full chunks as they are stored, its last rows encoded. When a
 * chunk is damaged, or some of the rays stand in another piece, portions are copied one by one.
 */
#include "io/recovery/salvage.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/journal.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/write/piece_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

struct salvage {
    const struct rmap_map *map;
    const struct rmap_leftover *leftover;
    struct rmap_map_content *content;
    struct rmap_salvaged *salvaged;
    struct rmap_journal journal; /* for its header */
    struct rmap_piece_origin origin;
    struct rmap_run run;
    size_t piece;                      /* of the map */
    struct rmap_portion_info *portion; /* [n_portion], those that the map has of it */
    size_t n_portion;
    char *shard_path, *part_path, *journal_path;

    /* Of the copy. */
    int fd; /* the .part file */
    struct rmap_piece_writer *writer;
    struct rmap_encoder *encoder;
    uint64_t n_row[RMAP_STREAM_MAX]; /* copied */
    uint8_t *buffer, *stored;
    size_t buffer_cap, stored_cap;
};

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for salvaging a piece");
}

static enum rmap_status reserve(uint8_t **buffer, size_t *cap, size_t nbytes,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(*buffer, *cap, nbytes, err);
    return st;
}

/* ---- which rays ---- */

static int by_first_row(const void *a, const void *b)
{
    const struct rmap_portion_info *x = a, *y = b;
    return (x->stored_first[0] > y->stored_first[0]) - (x->stored_first[0] < y->stored_first[0]);
}

/* The piece in the map, and the portions that it has of it, in the order of their rows. */
static enum rmap_status find_portions(struct salvage *self, struct rmap_error *err)
{
    const struct rmap_map_content *content = &self->map->content;
    while (self->piece < content->n_piece &&
           strcmp(content->piece[self->piece].name, self->leftover->name) != 0)
        self->piece++;
    if (self->piece == content->n_piece) /* left out, or there since the map was opened */
        return rmap_error_set(err, RMAP_FORMAT, "%s holds rays, but none that this map took in",
                              self->part_path);
    self->portion = rmap_alloc(content->n_portion, sizeof *self->portion);
    if (!self->portion)
        return no_memory(err);
    for (size_t i = 0; i < content->n_portion; i++)
        if ((size_t)content->portion[i].piece == self->piece)
            self->portion[self->n_portion++] = content->portion[i];
    if (self->n_portion > 0)
        qsort(self->portion, self->n_portion, sizeof *self->portion, by_first_row);
    return RMAP_OK;
}

/* Whether these portions are all that the piece commits. */
static bool is_whole(const struct salvage *self)
{
    const struct rmap_layout *layout = rmap_map_piece_layout(self->map, self->piece);
    const struct rmap_piece_info *info = &self->map->content.piece[self->piece];
    for (int t = 0; t < layout->n_table; t++) {
        uint64_t rows = 0;
        for (size_t i = 0; i < self->n_portion; i++)
            rows += self->portion[i].stored_rows[t];
        if (!(layout->whole_tables >> t & 1) && rows != info->stored_rows[t])
            return false;
    }
    return true;
}

/* ---- the copy of an undamaged piece ---- */

static enum rmap_status read_chunk(struct salvage *self, const struct rmap_chunk_entry *entry,
                                   struct rmap_error *err)
{
    enum rmap_status st = reserve(&self->buffer, &self->buffer_cap, entry->nbytes, err);
    size_t done = 0;
    while (st == RMAP_OK && done < entry->nbytes) {
        ssize_t got = pread(self->fd, self->buffer + done, entry->nbytes - done,
                            (off_t)(entry->offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return rmap_error_set(err, RMAP_SYSTEM, "%s: reading: %s", self->part_path,
                                  strerror(errno));
        if (got == 0)
            break;
        done += (size_t)got;
    }
    if (st == RMAP_OK &&
        (done < entry->nbytes || rmap_checksum(self->buffer, entry->nbytes) != entry->checksum))
        st = rmap_error_set(err, RMAP_FORMAT, "%s: a chunk is damaged", self->part_path);
    return st;
}

static enum rmap_status copy_chunk(struct salvage *self, const struct rmap_chunk_entry *entry,
                                   struct rmap_error *err)
{
    uint64_t *n_row = &self->n_row[entry->stream];
    uint64_t end = ((uint64_t)entry->index + 1) * RMAP_CHUNK_ROWS;
    enum rmap_status st = read_chunk(self, entry, err);
    if (st != RMAP_OK)
        return st;
    *n_row = end > *n_row ? end : *n_row;
    return rmap_piece_writer_put(self->writer, entry->stream, entry->index, *n_row, self->buffer,
                                 entry->nbytes, err);
}

static int by_offset(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

/* In the order in which they were stored, so that rows of one time stay together. */
static enum rmap_status copy_chunks(struct salvage *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_chunks *chunks;
    struct rmap_chunk_entry *entry = NULL;
    size_t n = (size_t)self->map->content.piece[self->piece].n_chunk;
    RMAP_TRY(rmap_map_piece_chunks(self->map, self->piece, &chunks, err));
    entry = rmap_alloc(n, sizeof *entry);
    if (!entry) {
        st = no_memory(err);
        goto out;
    }
    if (n > 0) {
        memcpy(entry, chunks->entry, n * sizeof *entry);
        qsort(entry, n, sizeof *entry, by_offset);
    }
    for (size_t i = 0; i < n; i++)
        RMAP_TRY(copy_chunk(self, &entry[i], err));
out:
    rmap_free(entry);
    return st;
}

/* The last rows, as the shard's writer would have stored them. */
static enum rmap_status encode_tail(struct salvage *self, int stream, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stream_tail *tail =
        rmap_map_content_tail(&self->map->content, self->piece, stream);
    if (!tail)
        return RMAP_OK;
    const struct rmap_stream_info *info =
        &rmap_map_piece_layout(self->map, self->piece)->stream[stream];
    size_t nbytes = RMAP_CHUNK_ROWS * rmap_stream_row_nbytes(info, self->run.scene->channels.n);
    size_t element = rmap_element_nbytes(info->element), n = nbytes / element;
    size_t stored_nbytes;
    RMAP_TRY(reserve(&self->buffer, &self->buffer_cap, tail->nbytes, err));
    RMAP_TRY(reserve(&self->stored, &self->stored_cap, rmap_codec_bound(n, element), err));
    memcpy(self->buffer, tail->data, tail->nbytes); /* aligned */
    RMAP_TRY(rmap_encoder_encode(self->encoder, self->buffer, tail->nbytes / element, n, element,
                                 self->stored, &stored_nbytes, err));
    RMAP_TRY(
        rmap_piece_writer_put(self->writer, stream, (uint32_t)(tail->first_row / RMAP_CHUNK_ROWS),
                              tail->first_row + tail->n_row, self->stored, stored_nbytes, err));
out:
    return st;
}

static enum rmap_status copy_piece(struct salvage *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_layout *layout = rmap_map_piece_layout(self->map, self->piece);
    const int number = rmap_map_content_next_number(&self->map->content, self->leftover->shard);
    self->fd = open(self->part_path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (self->fd < 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", self->part_path, strerror(errno));
        goto out;
    }
    RMAP_TRY(rmap_encoder_create(&self->encoder, err));
    RMAP_TRY(rmap_piece_writer_create(self->shard_path, self->leftover->shard, number, &self->run,
                                      &self->origin, &self->writer, err));
    RMAP_TRY(copy_chunks(self, err));
    for (int s = 0; s < layout->n_stream; s++)
        RMAP_TRY(encode_tail(self, s, err));
    RMAP_TRY(rmap_piece_writer_finish(self->writer, self->portion, self->n_portion,
                                      self->map->content.piece[self->piece].stored_rows, NULL,
                                      self->content, err));
out:
    rmap_piece_writer_destroy(self->writer);
    self->writer = NULL;
    return st;
}

/* ---- portion by portion ---- */

static enum rmap_status lose(struct salvage *self, const struct rmap_portion_info *info,
                             const struct rmap_error *why)
{
    struct rmap_salvaged *salvaged = self->salvaged;
    struct rmap_error text = {0};
    (void)rmap_error_set(
        &text, RMAP_FORMAT, "rays %llu to %llu are lost: %s", (unsigned long long)info->first_ray,
        (unsigned long long)(info->first_ray + info->n_row[RMAP_TABLE_RAY] - 1), why->text);
    if (salvaged->n_portion_lost == 0)
        memcpy(salvaged->first_lost, text.text, sizeof salvaged->first_lost);
    salvaged->n_portion_lost++;
    salvaged->n_ray_lost += info->n_row[RMAP_TABLE_RAY];
    return RMAP_OK;
}

static enum rmap_status copy_portion(struct salvage *self, struct rmap_cursor *cursor,
                                     struct rmap_shard_writer *writer, size_t portion,
                                     struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->map->content.portion[portion];
    const struct rmap_portion *rows = NULL;
    struct rmap_error why = {0};
    bool did = true;
    enum rmap_status st = rmap_cursor_read(cursor, portion, &rows, &why);
    if (st == RMAP_OK) {
        struct rmap_digest digest = rmap_portion_digest(rows);
        if (memcmp(&digest, &info->digest, sizeof digest) != 0)
            st = rmap_error_set(&why, RMAP_FORMAT, "%s: the rays' digest does not match",
                                self->part_path);
    }
    if (st == RMAP_FORMAT)
        return lose(self, info, &why);
    if (st != RMAP_OK)
        return rmap_error_set(err, st, "%s", why.text);
    RMAP_TRY(rmap_shard_writer_append(writer, rows, err));
    while (did)
        RMAP_TRY(rmap_shard_writer_encode(writer, &did, err));
    RMAP_TRY(rmap_shard_writer_store(writer, err));
out:
    return st;
}

static enum rmap_status copy_portions(struct salvage *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_map_content *content = &self->map->content;
    const struct rmap_shard_options options = {.origin = &self->origin};
    RMAP_TRY(rmap_cursor_create(self->map, RMAP_COLUMNS_ALL, &cursor, err));
    RMAP_TRY(rmap_shard_writer_create(self->map->path, self->leftover->shard, &self->run, &options,
                                      &writer, err));
    for (size_t i = 0; i < content->n_portion; i++)
        if ((size_t)content->portion[i].piece == self->piece)
            RMAP_TRY(copy_portion(self, cursor, writer, i, err));
    RMAP_TRY(rmap_shard_writer_finish(writer, err));
    RMAP_TRY(rmap_map_content_add(self->content, rmap_shard_writer_content(writer), err));
out:
    rmap_shard_writer_destroy(writer);
    rmap_cursor_destroy(cursor);
    return st;
}

/* ---- all of it ---- */

static enum rmap_status remove_file(const char *path, struct rmap_error *err)
{
    if (rmap_shard_unlink(path) != 0 && errno != ENOENT)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    return RMAP_OK;
}

/* The journal first: a .part alone is known to be worth nothing. */
static enum rmap_status remove_leftover(const struct salvage *self, struct rmap_error *err)
{
    enum rmap_status st = remove_file(self->journal_path, err);
    return st == RMAP_OK ? remove_file(self->part_path, err) : st;
}

/* Whether the leftover can be one of the map's; sets the run that wrote it. */
static enum rmap_status place(struct salvage *self, struct rmap_error *err)
{
    const struct rmap_journal_header *header = &self->journal.header;
    const struct rmap_map *map = self->map;
    rmap_journal_origin(&self->journal, &self->origin);
    int32_t space = rmap_map_spaces_find(&map->spaces, self->origin.space_digest);
    if (self->origin.seed != map->summary.seed ||
        strcmp(self->origin.scene_digest, map->scene_digest) != 0 || space < 0)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s belongs to another scene, seed or colour space than this map",
                              self->part_path);
    if ((header->format_major == RMAP_JOURNAL_CURVED) != rmap_scene_keeps_curves(map->scene[space]))
        return rmap_error_set(err, RMAP_FORMAT, "%s has another format than this map's scene",
                              self->part_path);
    self->run = (struct rmap_run){.bundle = map->bundle,
                                  .scene = map->scene[space],
                                  .seed = header->seed,
                                  .n_rank = map->summary.n_rank,
                                  .encoding = (enum rmap_encoding)header->encoding,
                                  .space = space,
                                  .isa = header->isa,
                                  .embree_version = header->embree_version,
                                  .tracer_revision = map->summary.tracer_revision,
                                  .selection = map->selection};
    return RMAP_OK;
}

static enum rmap_status begin(struct salvage *self, struct rmap_error *err)
{
    const char *name = self->leftover->name;
    self->part_path = rmap_path_format("%s/%s", self->map->path, name);
    self->journal_path = self->part_path ? rmap_journal_path(self->part_path) : NULL;
    self->shard_path = rmap_path_format("%s/%.*s", self->map->path, (int)strcspn(name, "/"), name);
    return self->journal_path && self->shard_path ? RMAP_OK : no_memory(err);
}

static enum rmap_status publish(struct salvage *self, struct rmap_error *err)
{
    enum rmap_status st = is_whole(self) ? copy_piece(self, err) : RMAP_FORMAT;
    if (st == RMAP_FORMAT)
        st = copy_portions(self, err);
    return st;
}

enum rmap_status rmap_salvage(const struct rmap_map *map, const struct rmap_leftover *leftover,
                              struct rmap_map_content *content, struct rmap_salvaged *salvaged,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content own = {0};
    struct salvage self = {
        .map = map, .leftover = leftover, .content = &own, .salvaged = salvaged, .fd = -1};
    *salvaged = (struct rmap_salvaged){0};
    RMAP_TRY(begin(&self, err));
    if (leftover->has_journal && leftover->has_part)
        RMAP_TRY(rmap_journal_read(self.journal_path, &self.journal, err));
    if (self.journal.n_portion > 0) {
        RMAP_TRY(place(&self, err));
        RMAP_TRY(find_portions(&self, err));
    }
    if (self.n_portion > 0)
        RMAP_TRY(publish(&self, err));
    RMAP_TRY(rmap_map_content_add(content, &own, err));
    salvaged->n_piece = own.n_piece;
    for (size_t i = 0; i < own.n_portion; i++)
        salvaged->n_ray += own.portion[i].n_row[RMAP_TABLE_RAY];
    RMAP_TRY(remove_leftover(&self, err));
out:
    if (self.fd >= 0)
        (void)close(self.fd);
    rmap_encoder_destroy(self.encoder);
    rmap_map_content_fini(&own);
    rmap_journal_fini(&self.journal);
    rmap_free(self.portion);
    rmap_free(self.buffer);
    rmap_free(self.stored);
    rmap_free(self.shard_path);
    rmap_free(self.part_path);
    rmap_free(self.journal_path);
    return st;
}
