/* SPDX-License-Identifier: MIT
 *
 * The file of a piece: that it is there, whole, sealed, itself, and of one mind with the index.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/codec/codec.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_internal.h"
#include "io/map/map_scan.h"
#include "io/map/piece_file.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_columns.h"
#include "io/recovery/verify_paths.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_tables.h"

/* First number of a field, for a message. */
static void number_text(const struct rmap_h5_field *field, const void *row, char text[32])
{
    const uint8_t *at = (const uint8_t *)row + field->offset;
    uint64_t u = 0;
    int32_t i32;
    float f32;
    memcpy(&u, at, rmap_element_nbytes(field->element));
    memcpy(&i32, at, field->element == RMAP_I32 ? sizeof i32 : 0);
    memcpy(&f32, at, field->element == RMAP_F32 ? sizeof f32 : 0);
    if (field->element == RMAP_I32)
        (void)snprintf(text, 32, "%d", (int)i32);
    else if (field->element == RMAP_F32)
        (void)snprintf(text, 32, "%.9g", (double)f32);
    else
        (void)snprintf(text, 32, "%llu", (unsigned long long)u);
}

/* Which of the field's numbers differs first, or -1. */
static int differs(const struct rmap_h5_field *field, const void *a, const void *b)
{
    size_t element = rmap_element_nbytes(field->element);
    for (size_t k = 0; k < field->width; k++)
        if (memcmp((const uint8_t *)a + field->offset + k * element,
                   (const uint8_t *)b + field->offset + k * element, element) != 0)
            return (int)k;
    return -1;
}

enum rmap_status rmap_verify_tables(const struct rmap_table_pair *pair,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t f = 0; f < pair->table.n && st == RMAP_OK; f++) {
        const struct rmap_h5_field *field = &pair->table.field[f];
        struct rmap_finding finding;
        size_t n = 0;
        for (size_t i = 0; i < pair->n; i++) {
            const uint8_t *says = (const uint8_t *)pair->says + i * pair->row_nbytes;
            const uint8_t *is = (const uint8_t *)pair->is + i * pair->row_nbytes;
            int at = differs(field, says, is);
            if (at < 0)
                continue;
            if (n++ == 0) {
                struct rmap_h5_field one = *field;
                char a[32], b[32];
                one.offset += (size_t)at * rmap_element_nbytes(field->element);
                number_text(&one, says, a);
                number_text(&one, is, b);
                rmap_finding_set(&finding, pair->file, field->path,
                                 "says %s where %s has %s (row %zu of its rows)", a, pair->what, b,
                                 i);
            }
            if (pair->portion)
                rmap_finding_add_portion(&finding, &pair->portion[i]);
        }
        if (n > 0)
            st = rmap_findings_add(findings, &finding, err);
    }
    return st;
}

/* ---- a piece's tables and the index's ---- */

struct piece_check {
    struct rmap_verification *self;
    size_t piece; /* of self->claimed */
    const struct rmap_piece_info *info;
    struct rmap_map_content own;       /* what the file says: one piece */
    struct rmap_portion_info *claimed; /* its portions in the index [n_claimed], by row */
    size_t n_claimed;
    struct rmap_findings *findings;
};

static int by_row(const void *a, const void *b)
{
    const struct rmap_portion_info *x = a, *y = b;
    int order =
        (x->stored_first[0] > y->stored_first[0]) - (x->stored_first[0] < y->stored_first[0]);
    return order ? order : (x->first_ray > y->first_ray) - (x->first_ray < y->first_ray);
}

static int by_stream(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* A finding about the whole piece; its rays go with it. */
static enum rmap_status whole(struct piece_check *check, const char *file, const char *dataset,
                              int flag, const char *text, struct rmap_error *err)
{
    struct rmap_verification *self = check->self;
    struct rmap_finding finding;
    rmap_finding_set(&finding, file, dataset, "%s", text);
    rmap_finding_add_piece(&finding, self->claimed, check->piece);
    if (self->map && flag)
        rmap_verification_flag_piece(self, check->piece, flag);
    return rmap_findings_add(check->findings, &finding, err);
}

static enum rmap_status gather_claimed(struct piece_check *check, struct rmap_error *err)
{
    const struct rmap_map_content *claimed = check->self->claimed;
    check->claimed = rmap_alloc(claimed->n_portion, sizeof *check->claimed);
    if (!check->claimed)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the portions of a piece");
    for (size_t i = 0; i < claimed->n_portion; i++)
        if ((size_t)claimed->portion[i].piece == check->piece)
            check->claimed[check->n_claimed++] = claimed->portion[i];
    if (check->n_claimed > 0)
        qsort(check->claimed, check->n_claimed, sizeof *check->claimed, by_row);
    if (check->own.n_portion > 0)
        qsort(check->own.portion, check->own.n_portion, sizeof *check->own.portion, by_row);
    return RMAP_OK;
}

/* A piece that was found beside an incomplete index was read from the file itself, and some of its
 * portions may have been left out as those of another piece. */
static bool from_index(const struct piece_check *check)
{
    bool listed = check->n_claimed > 0 || !check->self->map || check->self->map->summary.complete;
    for (size_t i = 0; i < check->n_claimed; i++)
        listed = listed && !check->claimed[i].is_added;
    return listed;
}

/* Portions of which index and piece tell different things are not compared with their rays again.
 */
static void flag_unsure(struct piece_check *check)
{
    const struct rmap_map_content *claimed = check->self->claimed;
    if (!check->self->map)
        return;
    for (size_t i = 0; i < claimed->n_portion; i++)
        if ((size_t)claimed->portion[i].piece == check->piece)
            rmap_verification_flag_portion(check->self, i, RMAP_PORTION_UNSURE);
}

static enum rmap_status compare_portions(struct piece_check *check, struct rmap_error *err)
{
    size_t before = check->findings->n;
    struct rmap_table_pair pair = {.file = "map.h5",
                                   .what = check->info->name,
                                   .table = rmap_portion_fields_piece(true),
                                   .says = check->claimed,
                                   .is = check->own.portion,
                                   .n = check->n_claimed,
                                   .row_nbytes = sizeof *check->claimed,
                                   .portion = check->own.portion};
    enum rmap_status st;
    char text[400];
    if (check->n_claimed == check->own.n_portion) {
        st = rmap_verify_tables(&pair, check->findings, err);
        pair.table = rmap_portion_fields_picked();
        if (st == RMAP_OK)
            st = rmap_verify_tables(&pair, check->findings, err);
    } else {
        (void)snprintf(text, sizeof text, "lists %s of %s, which has %zu",
                       rmap_counted(check->n_claimed, "portion").text, check->info->name,
                       check->own.n_portion);
        st = whole(check, "map.h5", "/portion", 0, text, err);
    }
    if (check->findings->n > before)
        flag_unsure(check);
    return st;
}

static enum rmap_status compare_chunks(struct piece_check *check, struct rmap_error *err)
{
    const struct rmap_map_content *claimed = check->self->claimed;
    size_t n = (size_t)check->info->n_chunk;
    struct rmap_chunk_entry *says = rmap_alloc(n, sizeof *says), *is = check->own.chunk;
    const struct rmap_table_pair pair = {.file = "map.h5",
                                         .what = check->info->name,
                                         .table = rmap_chunk_fields(),
                                         .says = says,
                                         .is = is,
                                         .n = n,
                                         .row_nbytes = sizeof *says};
    enum rmap_status st;
    char text[400];
    if (!says)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the chunks of a piece");
    if (n == check->own.n_chunk && n > 0) {
        memcpy(says, claimed->chunk + check->info->first_chunk, n * sizeof *says);
        qsort(says, n, sizeof *says, by_stream);
        qsort(is, n, sizeof *is, by_stream);
        st = rmap_verify_tables(&pair, check->findings, err);
    } else if (n == check->own.n_chunk) {
        st = RMAP_OK;
    } else {
        (void)snprintf(text, sizeof text, "lists %s of %s, which has %zu",
                       rmap_counted(n, "chunk").text, check->info->name, check->own.n_chunk);
        st = whole(check, "map.h5", "/chunk", 0, text, err);
    }
    rmap_free(says);
    return st;
}

/* Sizes and numbers of the piece itself, but for those that number rows of the index. */
static enum rmap_status compare_info(struct piece_check *check, struct rmap_error *err)
{
    struct rmap_piece_info is = check->own.piece[0];
    is.first_chunk = check->info->first_chunk;
    is.space = check->info->space;
    const struct rmap_table_pair pair = {.file = "map.h5",
                                         .what = check->info->name,
                                         .table = rmap_piece_fields(true),
                                         .says = check->info,
                                         .is = &is,
                                         .n = 1,
                                         .row_nbytes = sizeof is};
    return rmap_verify_tables(&pair, check->findings, err);
}

/* ---- the file ---- */

/* "shard-00000/piece-00001.h5" under which the piece was made; "": it does not say. */
static enum rmap_status own_name(const char *path, struct rmap_piece_info *name,
                                 struct rmap_error *err)
{
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(rmap_h5_get(&h5, "/", "shard", RMAP_I32, 1, &name->shard, err));
    RMAP_TRY(rmap_h5_get(&h5, "/", "piece", RMAP_I32, 1, &name->number, err));
    if (name->shard >= 0 && name->shard < RMAP_NUMBER_END && name->number >= 0 &&
        name->number < RMAP_NUMBER_END)
        rmap_piece_name_set(name);
out:
    rmap_h5_drop(&h5);
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

/* Whether the file holds the portions that the index lists, as far as their first rays go. A piece
 * of a merged map keeps the name inside under which it was made. */
static bool holds_listed(const struct piece_check *check)
{
    const struct rmap_map_content *claimed = check->self->claimed;
    size_t n = 0, same = 0;
    for (size_t i = 0; i < claimed->n_portion; i++) {
        if ((size_t)claimed->portion[i].piece != check->piece)
            continue;
        n++;
        for (size_t k = 0; k < check->own.n_portion; k++)
            if (check->own.portion[k].first_ray == claimed->portion[i].first_ray) {
                same++;
                break;
            }
    }
    return 2 * same >= n;
}

/* Whether the file may be compared with the index; else says why not. */
static enum rmap_status check_file(struct piece_check *check, bool *same,
                                   struct rmap_piece_origin *origin, struct rmap_error *err)
{
    const struct rmap_piece_info *info = check->info;
    struct rmap_piece_info name = {0};
    struct rmap_error why = {0};
    struct stat file;
    char text[512];
    *same = false;
    char *path = rmap_path_format("%s/%s", check->self->path, info->name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = RMAP_OK;
    if (stat(path, &file) != 0) {
        st = errno == ENOENT
                 ? whole(check, info->name, "", RMAP_PIECE_GONE, "the piece is missing", err)
                 : rmap_error_set(err, RMAP_SYSTEM, "%s: %s", path, strerror(errno));
        goto out;
    }
    bool cut = (uint64_t)file.st_size != info->nbytes;
    st = rmap_piece_read(check->self->path, info->shard, info->number, &check->own, origin, &why);
    if (st == RMAP_SYSTEM) { /* nothing is known of it: no finding */
        st = rmap_error_set(err, st, "%s", why.text);
        goto out;
    }
    bool reads = st == RMAP_OK;
    st = RMAP_OK;
    if (reads && !holds_listed(check))
        RMAP_TRY(own_name(path, &name, err));
    if (name.name[0] && strcmp(name.name, info->name) != 0) {
        (void)snprintf(text, sizeof text, "this is %s under another name", name.name);
        st = whole(check, info->name, "", RMAP_PIECE_GONE, text, err);
    } else if (cut && (!reads || check->self->map)) {
        /* What precedes a cut, its chunks' checksums tell. */
        bool is_start = !reads && S_ISREG(file.st_mode) && (uint64_t)file.st_size < info->nbytes;
        (void)snprintf(text, sizeof text,
                       "has %lld bytes, but map.h5 says %llu: it was cut off or replaced",
                       (long long)file.st_size, (unsigned long long)info->nbytes);
        st = whole(check, info->name, "", is_start ? RMAP_PIECE_TORN : RMAP_PIECE_GONE, text, err);
    } else if (!reads) {
        st = whole(check, info->name, "", RMAP_PIECE_TORN, why.text, err);
    } else {
        *same = true;
    }
out:
    rmap_free(path);
    return st;
}

static enum rmap_status check_origin(struct piece_check *check,
                                     const struct rmap_piece_origin *origin, bool *same,
                                     struct rmap_error *err)
{
    const struct rmap_map *map = check->self->map;
    const char *text = NULL;
    if (!map)
        return RMAP_OK;
    if (origin->seed != map->summary.seed)
        text = "it was traced with another seed";
    else if (origin->tracer_revision != map->summary.tracer_revision)
        text = "it was traced by another revision of the tracer";
    else if (strcmp(origin->scene_digest, map->scene_digest) != 0)
        text = "it belongs to another scene";
    else if (strcmp(origin->space_digest, map->spaces.space[check->info->space].digest) != 0)
        text = "it is in another colour space";
    *same = !text;
    return text ? whole(check, check->info->name, "", RMAP_PIECE_GONE, text, err) : RMAP_OK;
}

enum rmap_status rmap_verify_piece(struct rmap_verification *self, size_t piece,
                                   struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_origin origin = {0};
    struct rmap_error why = {0};
    bool same = false;
    struct piece_check check = {
        .self = self, .piece = piece, .info = &self->claimed->piece[piece], .findings = findings};
    if (check.info->is_open || (self->map && self->piece_flag[piece] & RMAP_PIECE_GONE))
        return RMAP_OK;
    RMAP_TRY(check_file(&check, &same, &origin, err));
    if (same)
        RMAP_TRY(check_origin(&check, &origin, &same, err));
    if (!same)
        goto out;
    st = rmap_map_content_sort(&check.own, &why);
    if (st == RMAP_OK)
        st = rmap_map_content_check(&check.own, check.info->name, &why);
    if (st != RMAP_OK) {
        st = st == RMAP_SYSTEM
                 ? rmap_error_set(err, st, "%s", why.text)
                 : whole(&check, check.info->name, "/portion", RMAP_PIECE_TORN, why.text, err);
        goto out;
    }
    RMAP_TRY(gather_claimed(&check, err));
    if (!from_index(&check))
        goto out;
    RMAP_TRY(compare_info(&check, err));
    RMAP_TRY(compare_portions(&check, err));
    RMAP_TRY(compare_chunks(&check, err));
    if (self->map)
        RMAP_TRY(rmap_verify_columns_file(self, piece, findings, err));
    if (self->map)
        RMAP_TRY(rmap_verify_path_rays(self, piece, findings, err));
out:
    rmap_map_content_fini(&check.own);
    rmap_free(check.claimed);
    return st;
}

/* Stored chunks: their bytes as they lie in the file, against our checksum and HDF5's. */

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
               ? RMAP_OK /* that it was cut is reported, once */
               : rmap_findings_add(findings, &finding, err);
}
