/* SPDX-License-Identifier: MIT */
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
