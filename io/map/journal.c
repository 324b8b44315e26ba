/* SPDX-License-Identifier: MIT
 *
 * Reading: records are taken as they come, and count once a COMMIT behind them holds. A torn end
 * is no error; numbers in a commit that holds and yet contradict each other are.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/file/read_exactly.h"
#include "io/map/journal.h"

#define XXH_INLINE_ALL
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/map/journal_format.h"

#define BUFFER_NBYTES 65536

struct source {
    int fd, reason; /* errno of a failed read, or 0 */
    uint64_t left;  /* of the file, behind what was taken */
    uint64_t taken;
    XXH3_state_t hash; /* of what was taken since the last commit */
    size_t have, used;
    uint8_t buffer[BUFFER_NBYTES];
};

struct reading {
    struct rmap_journal *journal;
    struct source *source;
    size_t n_entry, cap_entry, n_portion, cap_portion, n_tail, cap_tail; /* not yet committed */
};

static bool fill(struct source *source)
{
    ssize_t got;
    do
        got = read(source->fd, source->buffer, sizeof source->buffer);
    while (got < 0 && errno == EINTR);
    if (got < 0)
        source->reason = errno;
    source->used = 0;
    source->have = got > 0 ? (size_t)got : 0;
    return got > 0;
}

/* Takes n bytes, to nowhere when `to` is NULL; false when the file has no more. */
static bool take(struct source *source, void *to, size_t n)
{
    if (n > source->left)
        return false;
    source->left -= n;
    source->taken += n;
    while (n > 0) {
        if (source->used == source->have && !fill(source))
            return false;
        size_t part = source->have - source->used < n ? source->have - source->used : n;
        const uint8_t *from = source->buffer + source->used;
        (void)XXH3_64bits_update(&source->hash, from, part);
        if (to)
            memcpy(to, from, part);
        to = to ? (uint8_t *)to + part : NULL;
        source->used += part;
        n -= part;
    }
    return true;
}

/* ---- records; false: the file is not right from here on ---- */

static bool take_rows(struct reading *self, struct rmap_field_table table, size_t nbytes,
                      void **rows, size_t *n, size_t *cap, size_t row_nbytes, enum rmap_status *st,
                      struct rmap_error *err)
{
    uint8_t packed[1024];
    size_t size = rmap_journal_row_nbytes(table), more = nbytes / size;
    if (nbytes % size != 0 || size > sizeof packed)
        return false;
    *st = rmap_reserve(rows, cap, *n + more, row_nbytes, err);
    if (*st != RMAP_OK)
        return false;
    for (size_t i = 0; i < more; i++) {
        uint8_t *row = (uint8_t *)*rows + *n * row_nbytes;
        if (!take(self->source, packed, size))
            return false;
        memset(row, 0, row_nbytes);
        rmap_journal_row_unpack(table, packed, row);
        (*n)++;
    }
    return true;
}

static bool take_chunks(struct reading *self, size_t nbytes, enum rmap_status *st,
                        struct rmap_error *err)
{
    void *rows = self->journal->entry;
    bool good = take_rows(self, rmap_chunk_fields(), nbytes, &rows, &self->n_entry,
                          &self->cap_entry, sizeof *self->journal->entry, st, err);
    self->journal->entry = rows;
    return good;
}

static bool is_curved(const struct rmap_journal_header *header)
{
    return header->format_major == RMAP_JOURNAL_CURVED;
}

static bool take_portions(struct reading *self, size_t nbytes, enum rmap_status *st,
                          struct rmap_error *err)
{
    void *rows = self->journal->portion;
    bool good =
        take_rows(self, rmap_portion_fields_piece(is_curved(&self->journal->header)), nbytes, &rows,
                  &self->n_portion, &self->cap_portion, sizeof *self->journal->portion, st, err);
    self->journal->portion = rows;
    return good;
}

static bool take_tail(struct reading *self, size_t nbytes, enum rmap_status *st,
                      struct rmap_error *err)
{
    struct rmap_journal_tail_head head;
    const struct rmap_journal *journal = self->journal;
    if (nbytes < sizeof head || !take(self->source, &head, sizeof head))
        return false;
    nbytes -= sizeof head;
    if (head.stream >= (uint32_t)journal->layout->n_stream || head.n_row == 0 ||
        head.n_row > RMAP_CHUNK_ROWS ||
        nbytes != head.n_row * rmap_stream_row_nbytes(&journal->layout->stream[head.stream],
                                                      (int)journal->header.n_channel))
        return false;
    *st = RMAP_RESERVE(self->journal->tail, self->cap_tail, self->n_tail + 1, err);
    if (*st != RMAP_OK)
        return false;
    self->journal->tail[self->n_tail++] =
        (struct rmap_journal_tail){head.first_row, self->source->taken, head.n_row, head.stream};
    return take(self->source, NULL, nbytes);
}

static bool take_commit(struct reading *self, size_t nbytes)
{
    struct rmap_journal *journal = self->journal;
    struct source *source = self->source;
    const bool curved = is_curved(&journal->header);
    uint64_t n_portion, n_row[RMAP_STORED_TABLE_MAX] = {0}, stored;
    if (nbytes != rmap_journal_commit_nbytes(curved) ||
        !take(source, &n_portion, sizeof n_portion) ||
        !take(source, n_row, rmap_format_n_table(curved) * sizeof *n_row))
        return false;
    uint64_t hash = XXH3_64bits_digest(&source->hash);
    if (!take(source, &stored, sizeof stored) || stored != hash || n_portion != self->n_portion)
        return false;
    (void)XXH3_64bits_reset_withSeed(&source->hash, hash);
    memcpy(journal->n_row, n_row, sizeof journal->n_row);
    journal->n_entry = self->n_entry;
    journal->n_portion = self->n_portion;
    journal->n_tail = self->n_tail;
    journal->nbytes = source->taken;
    return true;
}

static bool take_record(struct reading *self, enum rmap_status *st, struct rmap_error *err)
{
    struct rmap_journal_record_head head;
    if (!take(self->source, &head, sizeof head) || head.nbytes > self->source->left)
        return false;
    switch (head.type) {
    case RMAP_JOURNAL_CHUNK:
        return take_chunks(self, head.nbytes, st, err);
    case RMAP_JOURNAL_TAIL:
        return take_tail(self, head.nbytes, st, err);
    case RMAP_JOURNAL_PORTION:
        return take_portions(self, head.nbytes, st, err);
    case RMAP_JOURNAL_COMMIT:
        return take_commit(self, head.nbytes);
    default:
        return false;
    }
}

/* ---- the header ---- */

static bool terminated(const char *text, size_t nbytes)
{
    return memchr(text, 0, nbytes) != NULL;
}

static enum rmap_status check_header(const struct rmap_journal_header *h, const char *path,
                                     bool *other_version_ret, struct rmap_error *err)
{
    if (memcmp(h->magic, RMAP_JOURNAL_MAGIC, sizeof h->magic) != 0)
        return rmap_error_set(err, RMAP_FORMAT, "%s is no journal of a ray map, or damaged", path);
    *other_version_ret = h->version != RMAP_JOURNAL_VERSION ||
                         (h->format_major != RMAP_JOURNAL_STRAIGHT && !is_curved(h)) ||
                         h->encoding >= RMAP_ENCODING_COUNT ||
                         !rmap_layout_of(h->encoding, RMAP_COLOUR_RGB);
    if (*other_version_ret)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s was written by another version of raymap: use that one", path);
    if (h->chunk_nbytes != rmap_journal_row_nbytes(rmap_chunk_fields()) ||
        h->portion_nbytes != rmap_journal_row_nbytes(rmap_portion_fields_piece(is_curved(h))) ||
        (h->mode != RMAP_COLOUR_SPECTRAL && h->mode != RMAP_COLOUR_RGB) || h->n_channel < 1 ||
        h->n_channel > RMAP_CHANNEL_MAX || h->shard < 0 || h->shard > 99999 || h->number < 0 ||
        h->number > 99999 || !terminated(h->scene_digest, sizeof h->scene_digest) ||
        !terminated(h->space_digest, sizeof h->space_digest) ||
        !terminated(h->isa, sizeof h->isa) ||
        !terminated(h->embree_version, sizeof h->embree_version))
        return rmap_error_set(err, RMAP_FORMAT, "%s: its header is damaged", path);
    return RMAP_OK;
}

/* A file that ends before its header does, or is 0 from the first byte on, was never committed:
 * *begun_ret is false then. */
static enum rmap_status take_header(struct reading *self, const char *path, bool *begun_ret,
                                    struct rmap_error *err)
{
    static const struct rmap_journal_record_head nothing,
        right = {RMAP_JOURNAL_HEADER, sizeof(struct rmap_journal_header)};
    struct rmap_journal_record_head head;
    struct rmap_journal_header *header = &self->journal->header;
    *begun_ret = take(self->source, &head, sizeof head) &&
                 memcmp(&head, &nothing, sizeof head) != 0 &&
                 take(self->source, header, sizeof *header);
    if (!*begun_ret)
        return RMAP_OK;
    enum rmap_status st = check_header(header, path, &self->journal->other_version, err);
    if (st == RMAP_OK && memcmp(&head, &right, sizeof head) != 0)
        st = rmap_error_set(err, RMAP_FORMAT, "%s: its header is damaged", path);
    return st;
}

/* ---- what was committed ---- */

static int by_stream_and_index(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

static int by_stream_and_row(const void *a, const void *b)
{
    const struct rmap_journal_tail *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->first_row > y->first_row) - (x->first_row < y->first_row);
}

static uint64_t stream_rows(const struct rmap_journal *journal, int stream)
{
    return journal->n_row[journal->layout->stream[stream].table];
}

/* Every stream has its full chunks and no others. */
static bool chunks_fit(const struct rmap_journal *journal)
{
    size_t at = 0;
    for (int s = 0; s < journal->layout->n_stream; s++) {
        uint64_t n_full = stream_rows(journal, s) / RMAP_CHUNK_ROWS;
        for (uint64_t k = 0; k < n_full; k++, at++)
            if (at >= journal->n_entry || journal->entry[at].stream != s ||
                journal->entry[at].index != k)
                return false;
    }
    return at == journal->n_entry;
}

/* Drops rows that went to a stored chunk later. */
static void drop_old_tails(struct rmap_journal *journal)
{
    size_t kept = 0;
    for (size_t i = 0; i < journal->n_tail; i++) {
        const struct rmap_journal_tail *tail = &journal->tail[i];
        uint64_t rows = stream_rows(journal, (int)tail->stream);
        if (tail->first_row >= rows - rows % RMAP_CHUNK_ROWS)
            journal->tail[kept++] = *tail;
    }
    journal->n_tail = kept;
}

static bool tails_fit(const struct rmap_journal *journal)
{
    size_t at = 0;
    for (int s = 0; s < journal->layout->n_stream; s++) {
        uint64_t rows = stream_rows(journal, s), next = rows - rows % RMAP_CHUNK_ROWS;
        for (; at < journal->n_tail && journal->tail[at].stream == (uint32_t)s; at++) {
            if (journal->tail[at].first_row != next || journal->tail[at].n_row > rows - next)
                return false;
            next += journal->tail[at].n_row;
        }
        if (next != rows)
            return false;
    }
    return at == journal->n_tail;
}

/* Portions follow each other and fill the tables, but for those of the piece as a whole. */
static bool portions_fit(const struct rmap_journal *journal)
{
    const struct rmap_layout *layout = journal->layout;
    uint64_t next[RMAP_STORED_TABLE_MAX] = {0};
    for (size_t i = 0; i < journal->n_portion; i++) {
        const struct rmap_portion_info *portion = &journal->portion[i];
        for (int t = 0; t < layout->n_table; t++) {
            if (layout->whole_tables >> t & 1)
                continue;
            if (portion->stored_first[t] != next[t] ||
                portion->stored_rows[t] > journal->n_row[t] - next[t])
                return false;
            next[t] += portion->stored_rows[t];
        }
    }
    for (int t = 0; t < RMAP_STORED_TABLE_MAX; t++) {
        bool whole = layout->whole_tables >> t & 1;
        if (!whole && next[t] != journal->n_row[t])
            return false;
    }
    return true;
}

static enum rmap_status check(struct rmap_journal *journal, const char *path,
                              struct rmap_error *err)
{
    if (journal->n_entry > 0)
        qsort(journal->entry, journal->n_entry, sizeof *journal->entry, by_stream_and_index);
    drop_old_tails(journal);
    if (journal->n_tail > 0)
        qsort(journal->tail, journal->n_tail, sizeof *journal->tail, by_stream_and_row);
    if (!chunks_fit(journal) || !tails_fit(journal) || !portions_fit(journal))
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s: what it commits contradicts itself: the file is damaged", path);
    return RMAP_OK;
}

static enum rmap_status read_records(struct reading *self, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_journal *journal = self->journal;
    bool begun;
    (void)XXH3_64bits_reset_withSeed(&self->source->hash, 0);
    RMAP_TRY(take_header(self, path, &begun, err));
    if (begun) {
        journal->layout = rmap_layout_of(journal->header.encoding, journal->header.mode);
        while (take_record(self, &st, err))
            ;
    }
    if (st == RMAP_OK && self->source->reason)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: reading: %s", path,
                            strerror(self->source->reason));
    if (st == RMAP_OK && journal->n_portion > 0)
        st = check(journal, path, err);
    if (journal->n_portion == 0)
        journal->layout = NULL;
out:
    return st;
}

enum rmap_status rmap_journal_read(const char *path, struct rmap_journal *journal,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat info;
    *journal = (struct rmap_journal){0};
    struct source source; /* the hash's state wants its alignment, which the stack gives */
    struct reading self = {.journal = journal, .source = &source};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 || fstat(fd, &info) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", path, strerror(errno));
        goto out;
    }
    if (!S_ISREG(info.st_mode)) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s is not a regular file", path);
        goto out;
    }
    source.fd = fd;
    source.left = (uint64_t)info.st_size;
    source.reason = 0;
    source.taken = source.have = source.used = 0;
    XXH3_INITSTATE(&source.hash);
    RMAP_TRY(read_records(&self, path, err));
    journal->nbytes_dropped = (uint64_t)info.st_size - journal->nbytes;
out:
    if (fd >= 0)
        (void)close(fd);
    return st;
}

void rmap_journal_fini(struct rmap_journal *journal)
{
    rmap_free(journal->entry);
    rmap_free(journal->portion);
    rmap_free(journal->tail);
    *journal = (struct rmap_journal){0};
}

void rmap_journal_origin(const struct rmap_journal *journal, struct rmap_piece_origin *origin)
{
    const struct rmap_journal_header *header = &journal->header;
    *origin = (struct rmap_piece_origin){.seed = header->seed,
                                         .encoding = (int32_t)header->encoding,
                                         .mode = (int32_t)header->mode,
                                         .n_channel = (int32_t)header->n_channel};
    (void)snprintf(origin->scene_digest, sizeof origin->scene_digest, "%.32s",
                   header->scene_digest);
    (void)snprintf(origin->space_digest, sizeof origin->space_digest, "%.32s",
                   header->space_digest);
}

/* One tail of the records [*at, ...) of a stream, which follow each other. */
static enum rmap_status add_tail(const struct rmap_journal *journal, int fd, size_t *at,
                                 struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_journal_tail *record = journal->tail + *at;
    size_t row = rmap_stream_row_nbytes(&journal->layout->stream[record->stream],
                                        (int)journal->header.n_channel);
    struct rmap_stream_tail tail = {.piece = (int32_t)content->n_piece - 1,
                                    .stream = (int32_t)record->stream,
                                    .first_row = record->first_row};
    size_t n = 0;
    for (; *at + n < journal->n_tail && record[n].stream == record->stream; n++)
        tail.n_row += record[n].n_row;
    tail.nbytes = tail.n_row * row;
    tail.data = rmap_alloc(tail.nbytes, 1);
    if (!tail.data)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the last rows of a piece");
    uint8_t *to = tail.data;
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(rmap_read_exactly(fd, to, record[i].n_row * row, record[i].offset, err));
        to += record[i].n_row * row;
    }
    RMAP_TRY(rmap_map_content_add_tail(content, &tail, err));
    *at += n;
    tail.data = NULL;
out:
    rmap_free(tail.data);
    return st;
}

enum rmap_status rmap_journal_content(const struct rmap_journal *journal, const char *journal_path,
                                      const char *name, uint64_t part_nbytes,
                                      struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content own = {0};
    struct rmap_piece_info info = {.shard = journal->header.shard,
                                   .number = journal->header.number,
                                   .nbytes = part_nbytes,
                                   .encoding = (int32_t)journal->header.encoding,
                                   .is_open = 1,
                                   .n_chunk = journal->n_entry};
    int fd = -1;
    if (journal->n_portion == 0)
        return RMAP_OK;
    memcpy(info.stored_rows, journal->n_row, sizeof info.stored_rows);
    if ((size_t)snprintf(info.name, sizeof info.name, "%s", name) >= sizeof info.name) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s: the name is too long", name);
        goto out;
    }
    RMAP_TRY(rmap_map_content_add_piece(&own, &info, journal->portion, journal->n_portion,
                                        journal->entry, err));
    fd = open(journal_path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", journal_path, strerror(errno));
        goto out;
    }
    for (size_t at = 0; at < journal->n_tail;) {
        st = add_tail(journal, fd, &at, &own, err);
        if (st != RMAP_OK) {
            rmap_error_context(err, "%s", journal_path);
            goto out;
        }
    }
    RMAP_TRY(rmap_map_content_add(content, &own, err));
out:
    if (fd >= 0)
        (void)close(fd);
    rmap_map_content_fini(&own);
    return st;
}

static bool exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 || errno != ENOENT;
}

enum rmap_status rmap_open_piece_read(const char *map_path, const struct rmap_leftover *leftover,
                                      struct rmap_map_content *content,
                                      struct rmap_piece_origin *origin, bool *committed_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_journal journal = {0};
    struct stat part;
    char *part_path = rmap_path_format("%s/%s", map_path, leftover->name);
    char *path = part_path ? rmap_journal_path(part_path) : NULL;
    *committed_ret = false;
    if (!leftover->has_journal || !leftover->has_part)
        goto out;
    if (!path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    RMAP_TRY(rmap_journal_read(path, &journal, err));
    if (journal.n_portion == 0)
        goto out;
    if (journal.header.shard != leftover->shard) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s belongs to shard %d: it was moved", path,
                            (int)journal.header.shard);
        goto out;
    }
    if (stat(part_path, &part) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", part_path, strerror(errno));
        goto out;
    }
    if (!S_ISREG(part.st_mode)) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s is not a regular file", part_path);
        goto out;
    }
    RMAP_TRY(
        rmap_journal_content(&journal, path, leftover->name, (uint64_t)part.st_size, content, err));
    rmap_journal_origin(&journal, origin);
    *committed_ret = true;
out:
    if (st == RMAP_SYSTEM && path && (!exists(part_path) || !exists(path)))
        st = RMAP_OK; /* published meanwhile: a piece has its rays */
    rmap_journal_fini(&journal);
    rmap_free(part_path);
    rmap_free(path);
    return st;
}
