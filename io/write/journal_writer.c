/* SPDX-License-Identifier: MIT
 *
 * Writing a journal: records are gathered in a batch, and a batch becomes a commit.
 */
#include "io/write/journal_writer.h"

#define XXH_INLINE_ALL
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/file/file_lock.h"
#include "io/file/write_all.h"
#include "io/map/journal_format.h"

/* Payload of one record at most, so that its size fits 32 bits whatever is added. */
#define RECORD_NBYTES_MAX ((size_t)1 << 30)

struct rmap_journal_writer {
    char *path;
    int fd;
    bool failed, curved;
    uint64_t hash;                   /* of the last commit */
    struct rmap_journal_batch begin; /* the header, until the first commit */
};

void rmap_journal_batch_fini(struct rmap_journal_batch *batch)
{
    rmap_free(batch->data);
    *batch = (struct rmap_journal_batch){0};
}

/* Room for a record, whose head is written: *payload_ret has nbytes. */
static enum rmap_status add_record(struct rmap_journal_batch *batch, enum rmap_journal_record type,
                                   size_t nbytes, uint8_t **payload_ret, struct rmap_error *err)
{
    struct rmap_journal_record_head head = {(uint32_t)type, (uint32_t)nbytes};
    enum rmap_status st =
        RMAP_RESERVE(batch->data, batch->cap, batch->nbytes + sizeof head + nbytes, err);
    if (st != RMAP_OK)
        return st;
    memcpy(batch->data + batch->nbytes, &head, sizeof head);
    *payload_ret = batch->data + batch->nbytes + sizeof head;
    batch->nbytes += sizeof head + nbytes;
    return RMAP_OK;
}

static enum rmap_status add_rows(struct rmap_journal_batch *batch, enum rmap_journal_record type,
                                 struct rmap_field_table table, const void *row, size_t n,
                                 size_t row_nbytes, struct rmap_error *err)
{
    size_t packed = rmap_journal_row_nbytes(table), most = RECORD_NBYTES_MAX / packed;
    size_t begun = batch->nbytes;
    for (size_t done = 0, part; done < n; done += part) {
        uint8_t *to;
        part = n - done < most ? n - done : most;
        enum rmap_status st = add_record(batch, type, part * packed, &to, err);
        if (st != RMAP_OK) {
            batch->nbytes = begun;
            return st;
        }
        for (size_t i = 0; i < part; i++)
            rmap_journal_row_pack(table, (const uint8_t *)row + (done + i) * row_nbytes,
                                  to + i * packed);
    }
    return RMAP_OK;
}

enum rmap_status rmap_journal_add_chunks(struct rmap_journal_batch *batch,
                                         const struct rmap_chunk_entry *entry, size_t n,
                                         struct rmap_error *err)
{
    return add_rows(batch, RMAP_JOURNAL_CHUNK, rmap_chunk_fields(), entry, n, sizeof *entry, err);
}

enum rmap_status rmap_journal_add_portions(struct rmap_journal_batch *batch, bool curved,
                                           const struct rmap_portion_info *portion, size_t n,
                                           struct rmap_error *err)
{
    return add_rows(batch, RMAP_JOURNAL_PORTION, rmap_portion_fields_piece(curved), portion, n,
                    sizeof *portion, err);
}

enum rmap_status rmap_journal_add_tail(struct rmap_journal_batch *batch, int stream,
                                       uint64_t first_row, size_t n_row, size_t row_nbytes,
                                       const void *rows, struct rmap_error *err)
{
    struct rmap_journal_tail_head head = {(uint32_t)stream, (uint32_t)n_row, first_row};
    uint8_t *to;
    enum rmap_status st =
        add_record(batch, RMAP_JOURNAL_TAIL, sizeof head + n_row * row_nbytes, &to, err);
    if (st != RMAP_OK)
        return st;
    memcpy(to, &head, sizeof head);
    memcpy(to + sizeof head, rows, n_row * row_nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_journal_create(const char *path, const struct rmap_journal_header *header,
                                     struct rmap_journal_writer **writer_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_journal_header full = *header;
    uint8_t *to;
    memcpy(full.magic, RMAP_JOURNAL_MAGIC, sizeof full.magic);
    full.version = RMAP_JOURNAL_VERSION;
    bool curved = full.format_major == RMAP_JOURNAL_CURVED;
    full.format_major = curved ? RMAP_JOURNAL_CURVED : RMAP_JOURNAL_STRAIGHT;
    full.format_minor = 0;
    full.chunk_nbytes = (uint32_t)rmap_journal_row_nbytes(rmap_chunk_fields());
    full.portion_nbytes = (uint32_t)rmap_journal_row_nbytes(rmap_portion_fields_piece(curved));
    struct rmap_journal_writer *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a journal");
    self->fd = -1;
    self->curved = curved;
    self->path = rmap_strdup(path);
    if (!self->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a journal");
        goto out;
    }
    RMAP_TRY(add_record(&self->begin, RMAP_JOURNAL_HEADER, sizeof full, &to, err));
    memcpy(to, &full, sizeof full);
    self->fd = open(path, O_CREAT | O_EXCL | O_WRONLY | O_APPEND | O_CLOEXEC, 0666);
    if (self->fd < 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be made: %s", path, strerror(errno));
        goto out;
    }
    rmap_file_lock(self->fd);
    *writer_ret = self;
    self = NULL;
out:
    rmap_journal_writer_destroy(self);
    return st;
}

static enum rmap_status write_all(struct rmap_journal_writer *self, const uint8_t *from,
                                  size_t nbytes, struct rmap_error *err)
{
    return rmap_write_all(self->fd, from, nbytes)
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "%s: writing: %s", self->path, strerror(errno));
}

enum rmap_status rmap_journal_commit(struct rmap_journal_writer *self,
                                     struct rmap_journal_batch *batch,
                                     const uint64_t n_row[RMAP_STORED_TABLE_MAX],
                                     uint64_t n_portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t rows_nbytes = rmap_format_n_table(self->curved) * sizeof *n_row;
    XXH3_state_t state;
    uint64_t hash = 0;
    uint8_t *to;
    if (self->failed)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: an earlier write failed", self->path);
    RMAP_TRY(
        add_record(batch, RMAP_JOURNAL_COMMIT, rmap_journal_commit_nbytes(self->curved), &to, err));
    memcpy(to, &n_portion, sizeof n_portion);
    memcpy(to + sizeof n_portion, n_row, rows_nbytes);
    XXH3_INITSTATE(&state);
    (void)XXH3_64bits_reset_withSeed(&state, self->hash);
    if (self->begin.nbytes > 0)
        (void)XXH3_64bits_update(&state, self->begin.data, self->begin.nbytes);
    (void)XXH3_64bits_update(&state, batch->data, batch->nbytes - sizeof hash);
    hash = XXH3_64bits_digest(&state);
    memcpy(to + sizeof n_portion + rows_nbytes, &hash, sizeof hash);
    RMAP_TRY(write_all(self, self->begin.data, self->begin.nbytes, err));
    RMAP_TRY(write_all(self, batch->data, batch->nbytes, err));
    if (fdatasync(self->fd) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: syncing to disk: %s", self->path,
                            strerror(errno));
        goto out;
    }
    self->hash = hash;
    self->begin.nbytes = 0;
    batch->nbytes = 0;
out:
    self->failed = st != RMAP_OK;
    return st;
}

void rmap_journal_writer_destroy(struct rmap_journal_writer *self)
{
    if (!self)
        return;
    if (self->fd >= 0)
        (void)close(self->fd);
    rmap_journal_batch_fini(&self->begin);
    rmap_free(self->path);
    rmap_free(self);
}
