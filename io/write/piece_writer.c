/* SPDX-License-Identifier: MIT
 *
 * One piece of a shard: a complete HDF5 file that takes ready chunks and is published at the end.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "compact/paths.h"
#include "io/codec/codec.h"
#include "io/file/directory.h"
#include "io/file/file_lock.h"
#include "io/file/publish.h"
#include "io/file/seal.h"
#include "io/file/write_back.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/portion_rows.h"
#include "io/map/provenance.h"
#include "io/write/piece_internal.h"
#include "io/write/piece_writer.h"
#include "io/write/stream_set.h"
#include "portion/event.h"

static enum rmap_status piece_check_number(int number, struct rmap_error *err) RMAP_MUST_USE;

/* After so many bytes the system is asked to begin writing them, so that a flush and the end of a
 * piece wait for no more than the last of them. */
#define WRITE_BACK_NBYTES ((size_t)4 << 20)

enum rmap_status rmap_piece_writer_put(struct rmap_piece_writer *self, int stream, uint32_t index,
                                       uint64_t n_row, const uint8_t *stored, size_t nbytes,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->entry, self->cap_entry, self->n_entry + 1, err));
    RMAP_TRY(rmap_stream_set_put(&self->h5, self->set[stream], &self->layout->stream[stream],
                                 self->run->scene->channels.n, stream, index, n_row, stored, nbytes,
                                 &self->entry[self->n_entry], err));
    self->n_entry++;
    self->resting_nbytes += nbytes;
    if (self->resting_nbytes >= WRITE_BACK_NBYTES) {
        rmap_write_back_begin(self->fd);
        self->resting_nbytes = 0;
    }
out:
    return st;
}

/* ---- flushing ---- */

static enum rmap_status begin_journal(struct rmap_piece_writer *self, struct rmap_error *err)
{
    const struct rmap_piece_origin *origin = &self->origin;
    struct rmap_journal_header header = {.format_major = self->curved ? RMAP_JOURNAL_CURVED
                                                                      : RMAP_JOURNAL_STRAIGHT,
                                         .encoding = (uint32_t)origin->encoding,
                                         .mode = (uint32_t)origin->mode,
                                         .n_channel = (uint32_t)origin->n_channel,
                                         .shard = self->shard,
                                         .number = self->number,
                                         .seed = origin->seed};
    (void)snprintf(header.scene_digest, sizeof header.scene_digest, "%s", origin->scene_digest);
    (void)snprintf(header.space_digest, sizeof header.space_digest, "%s", origin->space_digest);
    (void)snprintf(header.isa, sizeof header.isa, "%s", self->run->isa ? self->run->isa : "");
    (void)snprintf(header.embree_version, sizeof header.embree_version, "%s",
                   self->run->embree_version ? self->run->embree_version : "");
    return rmap_journal_create(self->journal_path, &header, &self->journal, err);
}

/* The stored chunks first, then the journal that speaks of them, then, once, the names of both. */
enum rmap_status rmap_piece_writer_flush(struct rmap_piece_writer *self,
                                         struct rmap_journal_batch *batch,
                                         const uint64_t *stored_rows, uint64_t n_portion,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool first = !self->journal;
    if (self->h5.failed)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: an earlier write failed", self->h5.path);
    if (fdatasync(self->fd) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: syncing to disk: %s", self->temporary,
                            strerror(errno));
        goto out;
    }
    if (first)
        RMAP_TRY(begin_journal(self, err));
    RMAP_TRY(rmap_journal_add_chunks(batch, self->entry + self->n_safe,
                                     self->n_entry - self->n_safe, err));
    RMAP_TRY(rmap_journal_commit(self->journal, batch, stored_rows, n_portion, err));
    self->n_safe = self->n_entry;
    if (first)
        RMAP_TRY(rmap_sync_directory(self->directory, err));
out:
    if (st != RMAP_OK)
        self->h5.failed = true; /* what comes later would not be safe */
    return st;
}

/* ---- finishing ---- */

static enum rmap_status seal(struct rmap_piece_writer *self, struct rmap_error *err)
{
    struct rmap_range *range = rmap_alloc(self->n_entry, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the seal of a piece");
    for (size_t i = 0; i < self->n_entry; i++)
        range[i] = (struct rmap_range){self->entry[i].offset, self->entry[i].nbytes};
    enum rmap_status st = rmap_seal_append(self->fd, self->temporary, range, self->n_entry, err);
    rmap_free(range);
    return st;
}

/* Under its own number, or the next that is free: a rank of a node that was cut off may have come
 * first. */
static enum rmap_status publish(struct rmap_piece_writer *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool taken = true;
    while (taken) {
        char *final = rmap_path_format("%s/piece-%05d.h5", self->directory, self->number);
        if (!final)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
        st = rmap_publish_new(self->directory, self->temporary, final, &taken, err);
        rmap_free(final);
        if (st == RMAP_OK && taken)
            st = rmap_shard_next_piece(self->directory, &self->number, err);
        if (st == RMAP_OK)
            st = piece_check_number(self->number, err);
        if (st != RMAP_OK)
            return st;
    }
    if (self->journal)
        (void)unlink(self->journal_path);
    rmap_free(self->temporary);
    self->temporary = NULL;
    return st;
}

static enum rmap_status close_file(struct rmap_piece_writer *self, uint64_t *nbytes_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat file;
    for (int s = 0; s < self->n_stream; s++) {
        if (H5Dclose(self->set[s]) < 0) {
            st = rmap_h5_fail(&self->h5, self->layout->stream[s].path, err);
            goto out;
        }
        self->set[s] = H5I_INVALID_HID;
    }
    RMAP_TRY(rmap_h5_close(&self->h5, err));
    rmap_file_lock(self->fd); /* if HDF5's own lock came first, it is gone now */
    RMAP_TRY(seal(self, err));
    if (fstat(self->fd, &file) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", self->temporary, strerror(errno));
        goto out;
    }
    *nbytes_ret = (uint64_t)file.st_size;
out:
    return st;
}

enum rmap_status rmap_piece_writer_finish(struct rmap_piece_writer *self,
                                          const struct rmap_portion_info *portion, size_t n_portion,
                                          const uint64_t *stored_rows,
                                          const struct rmap_path_sum *path,
                                          struct rmap_map_content *content, struct rmap_error *err)
{
    static const int32_t complete = 1;
    enum rmap_status st = RMAP_OK;
    struct rmap_field_table chunks = rmap_chunk_fields(),
                            portions = rmap_portion_fields_piece(self->curved),
                            sums = rmap_path_sum_fields();
    struct rmap_piece_info info = {.shard = self->shard,
                                   .encoding = (int32_t)self->layout->encoding,
                                   .space = self->run->space,
                                   .n_chunk = self->n_entry};
    RMAP_TRY(rmap_h5_write_fields(&self->h5, chunks.field, chunks.n, self->entry, self->n_entry,
                                  sizeof *self->entry, err));
    RMAP_TRY(rmap_portion_rows_write(&self->h5, portions, portion, n_portion,
                                     self->run->selection != NULL, err));
    if (path && stored_rows[RMAP_COMPACT_PATH] > 0)
        RMAP_TRY(rmap_h5_write_fields(&self->h5, sums.field, sums.n, path,
                                      (size_t)stored_rows[RMAP_COMPACT_PATH], sizeof *path, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "stored_rows", RMAP_U64, rmap_format_n_table(self->curved),
                         stored_rows, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "complete", RMAP_I32, 1, &complete, err));
    RMAP_TRY(close_file(self, &info.nbytes, err));
    RMAP_TRY(publish(self, err));
    info.number = self->number;
    memcpy(info.stored_rows, stored_rows, sizeof info.stored_rows);
    rmap_piece_name_set(&info);
    RMAP_TRY(rmap_map_content_add_piece(content, &info, portion, n_portion, self->entry, err));
out:
    return st;
}

void rmap_piece_writer_destroy(struct rmap_piece_writer *self)
{
    if (!self)
        return;
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        if (self->set[s] >= 0 && !self->h5.failed)
            (void)H5Dclose(self->set[s]);
    rmap_h5_drop(&self->h5);
    if (self->fd >= 0)
        (void)close(self->fd);
    if (self->temporary && !self->journal)
        (void)unlink(self->temporary);
    rmap_journal_writer_destroy(self->journal);
    rmap_free(self->directory);
    rmap_free(self->temporary);
    rmap_free(self->journal_path);
    rmap_free(self->entry);
    rmap_free(self);
}

/* A new piece: its file with empty datasets. */

/* Datasets are numbered in the order of their names' list, which the file carries. */
static enum rmap_status write_stream_names(struct rmap_piece_writer *self, struct rmap_error *err)
{
    const char *name[RMAP_STREAM_MAX];
    for (int s = 0; s < self->n_stream; s++)
        name[s] = self->layout->stream[s].path;
    return rmap_h5_write_names(&self->h5, "/chunk/name", name, (size_t)self->n_stream,
                               "datasets that /chunk/stream counts", err);
}

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

static enum rmap_status describe_values(struct rmap_piece_writer *self, struct rmap_error *err)
{
    const struct rmap_channels *channels = &self->run->scene->channels;
    enum rmap_status st = RMAP_OK;
    for (int s = 0; st == RMAP_OK && s < self->n_stream; s++) {
        const struct rmap_stream_info *stream = &self->layout->stream[s];
        if (stream->width == 0)
            st = rmap_h5_put(&self->h5, stream->path, "wavelength_nm", RMAP_F64,
                             (size_t)channels->n, channels->wavelength_nm, err);
        else if (ends_with(stream->path, "/event"))
            st = rmap_h5_put_text(&self->h5, stream->path, "bits", rmap_event_bits(), err);
    }
    return st;
}

static enum rmap_status create_file(struct rmap_piece_writer *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int32_t place[2] = {self->shard, self->number};
    const char *encoding = rmap_encoding_name(self->layout->encoding);
    RMAP_TRY(rmap_h5_create(&self->h5, self->temporary, err));
    RMAP_TRY(rmap_provenance_put(&self->h5, RMAP_FILETYPE_PIECE, self->run, &self->origin, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "shard", RMAP_I32, 1, &place[0], err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "piece", RMAP_I32, 1, &place[1], err));
    RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "encoding", encoding, err));
    for (int t = 0; t < self->n_table; t++)
        RMAP_TRY(rmap_h5_group(&self->h5, self->layout->table_path[t], err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/chunk", err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/portion", err));
    if (self->layout->encoding == RMAP_ENCODING_COMPACT)
        RMAP_TRY(rmap_h5_group(&self->h5, "/tally", err));
    for (int s = 0; s < self->n_stream; s++)
        RMAP_TRY(rmap_stream_set_create(&self->h5, &self->layout->stream[s], self->run->scene,
                                        &self->set[s], err));
    RMAP_TRY(describe_values(self, err));
    RMAP_TRY(write_stream_names(self, err));
out:
    return st;
}

/* Names that nothing has yet: in a container the process that was killed may have had our number,
 * and what it left holds rays. */
static enum rmap_status choose_names(struct rmap_piece_writer *self, struct rmap_error *err)
{
    char name[32];
    struct stat info;
    for (int attempt = 0;; attempt++) {
        (void)snprintf(name, sizeof name, attempt ? "piece-%05d.h5.%d" : "piece-%05d.h5",
                       self->number, attempt);
        self->temporary = rmap_temporary_path(self->directory, name);
        self->journal_path = self->temporary ? rmap_journal_path(self->temporary) : NULL;
        bool named = self->journal_path;
        if (named && lstat(self->temporary, &info) != 0 && lstat(self->journal_path, &info) != 0)
            return RMAP_OK;
        rmap_free(self->temporary); /* not ours: the destructor must not remove it */
        rmap_free(self->journal_path);
        self->temporary = self->journal_path = NULL;
        if (!named)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
    }
}

/* RMAP_USAGE: a shard has no more pieces than numbers. */
static enum rmap_status piece_check_number(int number, struct rmap_error *err)
{
    if (number < RMAP_NUMBER_END)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "a shard has at most %d pieces: a greater --piece-size makes fewer",
                          RMAP_NUMBER_END);
}

enum rmap_status rmap_piece_writer_create(const char *shard_path, int shard, int number,
                                          const struct rmap_run *run,
                                          const struct rmap_piece_origin *origin,
                                          struct rmap_piece_writer **writer_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int folder = -1;
    struct rmap_piece_writer *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
    self->run = run;
    self->shard = shard;
    self->number = number;
    self->layout = rmap_layout_of(run->encoding, run->scene->channels.mode);
    self->curved = rmap_scene_keeps_curves(run->scene);
    self->n_table = rmap_layout_n_table(self->layout, run->scene);
    self->n_stream = rmap_layout_n_stream(self->layout, run->scene);
    self->h5.file = H5I_INVALID_HID;
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        self->set[s] = H5I_INVALID_HID;
    self->origin = *origin;
    self->fd = -1;
    self->directory = rmap_strdup(shard_path);
    if (!self->directory) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
        goto out;
    }
    RMAP_TRY(piece_check_number(number, err));
    RMAP_TRY(rmap_shard_open(AT_FDCWD, shard_path, &folder, err));
    RMAP_TRY(choose_names(self, err));
    RMAP_TRY(create_file(self, err));
    /* By way of the folder: had a link taken its place meanwhile, the file would not be in it. */
    self->fd = openat(folder, strrchr(self->temporary, '/') + 1, O_RDWR | O_NOFOLLOW | O_CLOEXEC);
    if (self->fd < 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", self->temporary, strerror(errno));
        goto out;
    }
    rmap_file_lock(self->fd);
    *writer_ret = self;
    self = NULL;
out:
    if (folder >= 0)
        (void)close(folder);
    rmap_piece_writer_destroy(self);
    return st;
}
