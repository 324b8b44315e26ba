/* SPDX-License-Identifier: MIT
 *
 * Stored chunks: their bytes as they lie in the file, against our checksum and HDF5's.
 */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/map/piece_file.h"
#include "io/recovery/verify_internal.h"

struct rmap_chunk_verifier {
    struct rmap_verification *verification;
    size_t piece; /* that fd belongs to */
    int fd;       /* -1: none */
    uint8_t *stored;
    size_t cap;
};

enum rmap_status rmap_chunk_verifier_create(struct rmap_verification *verification,
                                            struct rmap_chunk_verifier **self_ret,
                                            struct rmap_error *err)
{
    struct rmap_chunk_verifier *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    self->verification = verification;
    self->fd = -1;
    *self_ret = self;
    return RMAP_OK;
}

void rmap_chunk_verifier_destroy(struct rmap_chunk_verifier *self)
{
    if (!self)
        return;
    if (self->fd >= 0)
        (void)close(self->fd);
    rmap_free(self->stored);
    rmap_free(self);
}

/* Piece that holds a chunk of the content; n_piece when none does. */
static size_t piece_of(const struct rmap_verification *self, size_t chunk)
{
    const struct rmap_map_content *content = self->content;
    size_t low = 0, high = self->n_owner;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (self->owner[middle].first_chunk <= chunk)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0)
        return content->n_piece;
    const struct rmap_chunk_owner *owner = &self->owner[low - 1];
    return chunk - owner->first_chunk < content->piece[owner->piece].n_chunk ? owner->piece
                                                                             : content->n_piece;
}

static const char cut_off[] = "the file ends before the chunk does";

static enum rmap_status unreadable(const struct rmap_piece_info *info, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s cannot be read: %s", info->name, strerror(errno));
}

/* *wrong_ret: what is wrong with the bytes, or NULL. RMAP_SYSTEM, where they cannot be had: that
 * says nothing about them, and repair must not take them for lost. */
static enum rmap_status check_bytes(struct rmap_chunk_verifier *self,
                                    const struct rmap_piece_info *info,
                                    const struct rmap_chunk_entry *entry, const char **wrong_ret,
                                    struct rmap_error *err)
{
    size_t done = 0;
    while (done < entry->nbytes) {
        ssize_t got = pread(self->fd, self->stored + done, entry->nbytes - done,
                            (off_t)(entry->offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return unreadable(info, err);
        if (got == 0) {
            *wrong_ret = cut_off;
            return RMAP_OK;
        }
        done += (size_t)got;
    }
    uint32_t sum = rmap_fletcher32(self->stored, entry->nbytes - sizeof sum), found;
    memcpy(&found, self->stored + entry->nbytes - sizeof found, sizeof found);
    if (rmap_checksum(self->stored, entry->nbytes) != entry->checksum)
        *wrong_ret = "its checksum does not match: the data are damaged";
    else if (sum != found)
        *wrong_ret = "its fletcher32 does not match: HDF5 will not read it";
    return RMAP_OK;
}

/* Room and a file; *wrong_ret and status as above. */
static enum rmap_status prepare(struct rmap_chunk_verifier *self, size_t piece,
                                const struct rmap_chunk_entry *entry, const char **wrong_ret,
                                struct rmap_error *err)
{
    const struct rmap_piece_info *info = &self->verification->content->piece[piece];
    *wrong_ret = NULL;
    if (entry->nbytes < sizeof(uint32_t) || entry->offset > info->nbytes ||
        entry->nbytes > info->nbytes - entry->offset) {
        *wrong_ret = "it lies outside its file";
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(self->stored, self->cap, entry->nbytes, err);
    if (st != RMAP_OK || (self->fd >= 0 && self->piece == piece))
        return st;
    if (self->fd >= 0)
        (void)close(self->fd);
    self->fd = rmap_piece_file_open(self->verification->path, info);
    self->piece = piece;
    if (self->fd < 0 && errno != ENOENT && errno != ENOTDIR)
        return unreadable(info, err);
    *wrong_ret = self->fd < 0 ? strerror(errno) : NULL;
    return RMAP_OK;
}

/* Portions that have rows in the chunk are lost, and their rays are the finding's. */
static void add_portions(struct rmap_verification *self, size_t piece,
                         const struct rmap_layout *layout, const struct rmap_chunk_entry *entry,
                         struct rmap_finding *finding)
{
    const struct rmap_map_content *content = self->content;
    int table = layout->stream[entry->stream].table;
    bool all = layout->whole_tables & (uint32_t)1 << table;
    uint64_t first = (uint64_t)entry->index * RMAP_CHUNK_ROWS, end = first + RMAP_CHUNK_ROWS;
    uint64_t rows = content->piece[piece].stored_rows[table];
    finding->chunk = entry->index;
    finding->first_row = first;
    finding->n_row = rows < end ? (rows > first ? rows - first : 0) : RMAP_CHUNK_ROWS;
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        uint64_t from = portion->stored_first[table], n = portion->stored_rows[table];
        bool inside = n > 0 && from < end && from + n > first;
        if ((size_t)portion->piece != piece || !(all || inside))
            continue;
        rmap_finding_add_portion(finding, portion);
        rmap_verification_flag_portion(self, i, RMAP_PORTION_LOST);
    }
}

enum rmap_status rmap_verify_chunk(struct rmap_chunk_verifier *self, size_t chunk,
                                   struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_verification *verification = self->verification;
    const struct rmap_chunk_entry *entry = &verification->content->chunk[chunk];
    size_t piece = piece_of(verification, chunk);
    if (piece == verification->content->n_piece)
        return RMAP_OK;
    const struct rmap_piece_info *info = &verification->content->piece[piece];
    struct rmap_finding finding;
    if (verification->piece_flag[piece] & RMAP_PIECE_GONE)
        return RMAP_OK;
    const struct rmap_layout *layout =
        rmap_piece_layout(info, (enum rmap_colour_mode)verification->mode[piece]);
    enum rmap_status st = RMAP_OK;
    const char *wrong = NULL;
    if (!layout || entry->stream >= layout->n_stream) {
        rmap_finding_set(&finding, "map.h5", "/chunk/stream", "%s: chunk %zu is of no dataset",
                         info->name, chunk);
        return rmap_findings_add(findings, &finding, err);
    }
    st = prepare(self, piece, entry, &wrong, err);
    if (st == RMAP_OK && !wrong)
        st = check_bytes(self, info, entry, &wrong, err);
    if (st != RMAP_OK || !wrong)
        return st;
    rmap_finding_set(&finding, info->name, layout->stream[entry->stream].path, "%s", wrong);
    add_portions(verification, piece, layout, entry, &finding);
    return wrong == cut_off && verification->piece_flag[piece] & RMAP_PIECE_TORN
               ? RMAP_OK /* that it was cut is told, once */
               : rmap_findings_add(findings, &finding, err);
}
