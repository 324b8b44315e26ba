/* SPDX-License-Identifier: MIT
 *
 * What pieces hold: their portions and where their chunks lie.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "base/alloc.h"
#include "io/map/map_content.h"

void rmap_map_content_fini(struct rmap_map_content *content)
{
    if (content->mapped) {
        (void)munmap(content->mapped, content->mapped_nbytes);
    } else {
        for (size_t i = 0; i < content->n_tail; i++)
            rmap_free(content->tail[i].data);
        rmap_free(content->piece);
        rmap_free(content->portion);
        rmap_free(content->chunk);
    }
    rmap_free(content->tail);
    *content = (struct rmap_map_content){0};
}

static enum rmap_status make_room(struct rmap_map_content *content, size_t n_piece,
                                  size_t n_portion, size_t n_chunk, size_t n_tail,
                                  struct rmap_error *err)
{
    const struct {
        void *pointer; /* to a pointer */
        size_t *cap, need, size;
    } list[] = {
        {&content->piece, &content->cap_piece, content->n_piece + n_piece, sizeof *content->piece},
        {&content->portion, &content->cap_portion, content->n_portion + n_portion,
         sizeof *content->portion},
        {&content->chunk, &content->cap_chunk, content->n_chunk + n_chunk, sizeof *content->chunk},
        {&content->tail, &content->cap_tail, content->n_tail + n_tail, sizeof *content->tail},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        void *block;
        memcpy(&block, list[i].pointer, sizeof block);
        enum rmap_status st = rmap_reserve(&block, list[i].cap, list[i].need, list[i].size, err);
        memcpy(list[i].pointer, &block, sizeof block);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

enum rmap_status rmap_map_content_add_piece(struct rmap_map_content *content,
                                            const struct rmap_piece_info *info,
                                            const struct rmap_portion_info *portion,
                                            size_t n_portion, const struct rmap_chunk_entry *chunk,
                                            struct rmap_error *err)
{
    enum rmap_status st = make_room(content, 1, n_portion, (size_t)info->n_chunk, 0, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_piece_info *piece = &content->piece[content->n_piece];
    *piece = *info;
    piece->first_chunk = content->n_chunk;
    memset(piece->n_row, 0, sizeof piece->n_row);
    for (size_t i = 0; i < n_portion; i++) {
        struct rmap_portion_info *row = &content->portion[content->n_portion + i];
        *row = portion[i];
        row->shard = info->shard;
        row->piece = (int32_t)content->n_piece;
        row->space = info->space;
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            piece->n_row[t] += row->n_row[t];
    }
    if (info->n_chunk > 0)
        memcpy(content->chunk + content->n_chunk, chunk, (size_t)info->n_chunk * sizeof *chunk);
    content->n_piece++;
    content->n_portion += n_portion;
    content->n_chunk += (size_t)info->n_chunk;
    return RMAP_OK;
}

enum rmap_status rmap_map_content_add_tail(struct rmap_map_content *content,
                                           const struct rmap_stream_tail *tail,
                                           struct rmap_error *err)
{
    enum rmap_status st = make_room(content, 0, 0, 0, 1, err);
    if (st == RMAP_OK)
        content->tail[content->n_tail++] = *tail;
    return st;
}

/* Bytes of a tail's data cannot be told without its layout's widths: the copy needs the size. */
static enum rmap_status copy_tail(const struct rmap_stream_tail *from, struct rmap_stream_tail *to,
                                  struct rmap_error *err)
{
    *to = *from;
    to->data = rmap_alloc(from->nbytes, 1);
    if (!to->data)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rows of a journal");
    memcpy(to->data, from->data, from->nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_map_content_add(struct rmap_map_content *into,
                                      const struct rmap_map_content *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_tail = into->n_tail;
    RMAP_TRY(make_room(into, from->n_piece, from->n_portion, from->n_chunk, from->n_tail, err));
    for (size_t i = 0; i < from->n_tail; i++) {
        RMAP_TRY(copy_tail(&from->tail[i], &into->tail[into->n_tail], err));
        into->tail[into->n_tail++].piece += (int32_t)into->n_piece;
    }
    for (size_t i = 0; i < from->n_portion; i++) {
        into->portion[into->n_portion] = from->portion[i];
        into->portion[into->n_portion++].piece += (int32_t)into->n_piece;
    }
    for (size_t i = 0; i < from->n_piece; i++) {
        into->piece[into->n_piece] = from->piece[i];
        into->piece[into->n_piece++].first_chunk += into->n_chunk;
    }
    if (from->n_chunk > 0)
        memcpy(into->chunk + into->n_chunk, from->chunk, from->n_chunk * sizeof *from->chunk);
    into->n_chunk += from->n_chunk;
out:
    while (st != RMAP_OK && into->n_tail > n_tail)
        rmap_free(into->tail[--into->n_tail].data);
    return st;
}

enum rmap_status rmap_map_content_own(struct rmap_map_content *content, struct rmap_error *err)
{
    struct rmap_map_content own = {0};
    if (!content->mapped)
        return RMAP_OK;
    const enum rmap_status st = rmap_map_content_add(&own, content, err);
    if (st != RMAP_OK) {
        rmap_map_content_fini(&own);
        return st;
    }
    memcpy(own.n_row, content->n_row, sizeof own.n_row);
    own.digest = content->digest;
    rmap_map_content_fini(content);
    *content = own;
    return RMAP_OK;
}

struct piece_place {
    struct rmap_piece_info info;
    size_t was;
};

static int by_place(const void *a, const void *b)
{
    const struct rmap_piece_info *x = a, *y = b; /* first member */
    if (x->shard != y->shard)
        return x->shard < y->shard ? -1 : 1;
    if (x->number != y->number)
        return x->number < y->number ? -1 : 1;
    return (x->is_open > y->is_open) - (x->is_open < y->is_open);
}

static int by_first_ray(const void *a, const void *b)
{
    const struct rmap_portion_info *x = a, *y = b;
    if (x->first_ray != y->first_ray)
        return x->first_ray < y->first_ray ? -1 : 1;
    if (x->is_added != y->is_added)
        return x->is_added < y->is_added ? -1 : 1;
    if (x->n_row[RMAP_TABLE_RAY] != y->n_row[RMAP_TABLE_RAY])
        return x->n_row[RMAP_TABLE_RAY] > y->n_row[RMAP_TABLE_RAY] ? -1 : 1;
    if (x->piece != y->piece)
        return x->piece < y->piece ? -1 : 1;
    return (x->stored_first[0] > y->stored_first[0]) - (x->stored_first[0] < y->stored_first[0]);
}

static int by_stream(const void *a, const void *b)
{
    const struct rmap_stream_tail *x = a, *y = b;
    if (x->piece != y->piece)
        return x->piece < y->piece ? -1 : 1;
    return (x->stream > y->stream) - (x->stream < y->stream);
}

const struct rmap_stream_tail *rmap_map_content_tail(const struct rmap_map_content *content,
                                                     size_t piece, int stream)
{
    const struct rmap_stream_tail key = {.piece = (int32_t)piece, .stream = stream};
    return content->n_tail == 0
               ? NULL
               : bsearch(&key, content->tail, content->n_tail, sizeof *content->tail, by_stream);
}

static int by_stream_and_index(const void *a, const void *b)
{
    const struct rmap_chunk_entry *x = a, *y = b;
    if (x->stream != y->stream)
        return x->stream < y->stream ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Puts the chunks of the pieces in the order of these, each piece's by stream and index. */
static enum rmap_status sort_chunks(struct rmap_map_content *content, struct rmap_error *err)
{
    struct rmap_chunk_entry *chunk = rmap_alloc(content->n_chunk, sizeof *chunk);
    size_t n = 0;
    if (!chunk)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of chunks");
    for (size_t i = 0; i < content->n_piece; i++) {
        struct rmap_piece_info *piece = &content->piece[i];
        size_t n_chunk = (size_t)piece->n_chunk;
        if (n_chunk > content->n_chunk - n) {
            rmap_free(chunk);
            return rmap_error_set(err, RMAP_INTERNAL, "pieces share chunks");
        }
        if (n_chunk > 0) {
            memcpy(chunk + n, content->chunk + piece->first_chunk, n_chunk * sizeof *chunk);
            qsort(chunk + n, n_chunk, sizeof *chunk, by_stream_and_index);
        }
        piece->first_chunk = n;
        n += n_chunk;
    }
    rmap_free(content->chunk);
    content->chunk = chunk;
    content->cap_chunk = content->n_chunk;
    content->n_chunk = n;
    return RMAP_OK;
}

enum rmap_status rmap_map_content_sort(struct rmap_map_content *content, struct rmap_error *err)
{
    struct piece_place *place = rmap_alloc(content->n_piece, sizeof *place);
    int32_t *now = rmap_alloc(content->n_piece, sizeof *now);
    if (!place || !now) {
        rmap_free(place);
        rmap_free(now);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    }
    for (size_t i = 0; i < content->n_piece; i++)
        place[i] = (struct piece_place){content->piece[i], i};
    if (content->n_piece > 0)
        qsort(place, content->n_piece, sizeof *place, by_place);
    for (size_t i = 0; i < content->n_piece; i++) {
        content->piece[i] = place[i].info;
        now[place[i].was] = (int32_t)i;
    }
    for (size_t i = 0; i < content->n_portion; i++)
        content->portion[i].piece = now[content->portion[i].piece];
    for (size_t i = 0; i < content->n_tail; i++)
        content->tail[i].piece = now[content->tail[i].piece];
    if (content->n_portion > 0)
        qsort(content->portion, content->n_portion, sizeof *content->portion, by_first_ray);
    if (content->n_tail > 0)
        qsort(content->tail, content->n_tail, sizeof *content->tail, by_stream);
    rmap_free(place);
    rmap_free(now);
    return sort_chunks(content, err);
}

/* Of two portions of just the same rays, whether the second is the better one to keep. */
static bool is_better(const struct rmap_map_content *content, const struct rmap_portion_info *kept,
                      const struct rmap_portion_info *other)
{
    return kept->is_added && content->piece[kept->piece].is_open &&
           !content->piece[other->piece].is_open && kept->first_ray == other->first_ray &&
           rmap_portion_end(kept) == rmap_portion_end(other);
}

/* Whether `kept`, which begins no later, has all rays of the other: of portions with gaps that is
 * known only where they are two copies of one. */
static bool covers(const struct rmap_portion_info *kept, const struct rmap_portion_info *other)
{
    if (rmap_portion_end(other) > rmap_portion_end(kept))
        return false;
    return !rmap_portion_has_gaps(kept) ||
           (kept->first_ray == other->first_ray &&
            memcmp(&kept->digest, &other->digest, sizeof kept->digest) == 0);
}

void rmap_map_content_drop_covered(struct rmap_map_content *content, size_t *n_dropped_ret)
{
    size_t n = 0;
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        struct rmap_portion_info *last = n > 0 ? &content->portion[n - 1] : NULL;
        if (!last || !covers(last, portion))
            content->portion[n++] = *portion;
        else if (is_better(content, last, portion))
            *last = *portion;
    }
    *n_dropped_ret = content->n_portion - n;
    content->n_portion = n;
    for (size_t i = 0; i < content->n_piece; i++)
        memset(content->piece[i].n_row, 0, sizeof content->piece[i].n_row);
    for (size_t i = 0; i < n; i++)
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            content->piece[content->portion[i].piece].n_row[t] += content->portion[i].n_row[t];
}

enum rmap_status rmap_map_content_drop_open(struct rmap_map_content *content,
                                            struct rmap_error *err)
{
    size_t n_piece = 0, n = 0;
    int32_t *now = rmap_alloc(content->n_piece, sizeof *now);
    if (!now)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t i = 0; i < content->n_piece; i++) {
        now[i] = content->piece[i].is_open ? -1 : (int32_t)n_piece;
        if (!content->piece[i].is_open)
            content->piece[n_piece++] = content->piece[i];
    }
    content->n_piece = n_piece;
    for (size_t i = 0; i < content->n_portion; i++) {
        int32_t piece = now[content->portion[i].piece];
        if (piece < 0)
            continue;
        content->portion[n] = content->portion[i];
        content->portion[n++].piece = piece;
    }
    content->n_portion = n;
    while (content->n_tail > 0)
        rmap_free(content->tail[--content->n_tail].data);
    rmap_free(now);
    return RMAP_OK;
}

const struct rmap_layout *rmap_piece_layout(const struct rmap_piece_info *piece,
                                            enum rmap_colour_mode mode)
{
    return rmap_layout_of((enum rmap_encoding)piece->encoding, mode);
}

void rmap_piece_name_set(struct rmap_piece_info *piece)
{
    (void)snprintf(piece->name, sizeof piece->name, "shard-%05d/piece-%05d.h5", (int)piece->shard,
                   (int)piece->number);
}

int rmap_map_content_next_number(const struct rmap_map_content *content, int shard)
{
    int next = 0;
    for (size_t i = 0; i < content->n_piece; i++) {
        const struct rmap_piece_info *piece = &content->piece[i];
        if (piece->shard == shard && !piece->is_open && piece->number >= next)
            next = piece->number + 1;
    }
    return next;
}

const char *rmap_map_content_encodings(const struct rmap_map_content *content)
{
    static const char *const words[] = {"", "plain", "compact", "plain and compact"};
    unsigned met = 0;
    for (size_t i = 0; i < content->n_piece; i++)
        met |= content->piece[i].encoding == RMAP_ENCODING_COMPACT ? 2U : 1U;
    return words[met];
}

/* Whether what a map says to hold fits together, before anybody relies on it. */

/* Rows of portions must lie in their piece and share none of them. */
static enum rmap_status check_rows(const struct rmap_map_content *content, const char *path,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t(*sum)[RMAP_STORED_TABLE_MAX] = rmap_alloc(content->n_piece, sizeof *sum);
    if (!sum)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t i = 0; st == RMAP_OK && i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        bool fits = portion->piece >= 0 && (size_t)portion->piece < content->n_piece &&
                    portion->space == content->piece[portion->piece].space;
        bool plain = fits && content->piece[portion->piece].encoding == RMAP_ENCODING_PLAIN;
        for (int t = 0; plain && t < RMAP_TABLE_COUNT; t++)
            fits = fits && portion->n_row[t] == portion->stored_rows[t];
        for (int t = 0; fits && t < RMAP_STORED_TABLE_MAX; t++) {
            uint64_t rows = content->piece[portion->piece].stored_rows[t];
            fits = portion->stored_first[t] <= rows &&
                   portion->stored_rows[t] <= rows - portion->stored_first[t] &&
                   portion->stored_rows[t] <= rows - sum[portion->piece][t];
            if (fits)
                sum[portion->piece][t] += portion->stored_rows[t];
        }
        if (!fits)
            st = rmap_error_set(err, RMAP_FORMAT,
                                "%s: portion %zu of /portion points outside its piece", path, i);
    }
    rmap_free(sum);
    return st;
}

static enum rmap_status check_pieces(const struct rmap_map_content *content, const char *path,
                                     struct rmap_error *err)
{
    bool good = true;
    uint64_t n_chunk = 0;
    for (size_t i = 0; good && i < content->n_piece; i++) {
        const struct rmap_piece_info *piece = &content->piece[i];
        good = piece->encoding >= 0 && piece->encoding < RMAP_ENCODING_COUNT &&
               rmap_piece_layout(piece, RMAP_COLOUR_SPECTRAL) && piece->first_chunk == n_chunk &&
               piece->n_chunk <= content->n_chunk - n_chunk;
        n_chunk += good ? piece->n_chunk : 0;
    }
    for (size_t i = 0; i < content->n_tail; i++) {
        const struct rmap_stream_tail *tail = &content->tail[i];
        good = good && tail->piece >= 0 && (size_t)tail->piece < content->n_piece &&
               content->piece[tail->piece].is_open && tail->n_row <= RMAP_CHUNK_ROWS &&
               tail->first_row % RMAP_CHUNK_ROWS == 0;
    }
    return good ? RMAP_OK
                : rmap_error_set(err, RMAP_FORMAT, "%s: its table of pieces makes no sense", path);
}

/* No chunk belongs to two pieces: each piece puts its own in order when it is first read. */
static enum rmap_status check_chunks(const struct rmap_map_content *content, const char *path,
                                     struct rmap_error *err)
{
    bool twice = false;
    uint8_t *taken = rmap_alloc(content->n_chunk, 1);
    if (!taken)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of chunks");
    for (size_t i = 0; !twice && i < content->n_piece; i++)
        for (uint64_t k = 0; !twice && k < content->piece[i].n_chunk; k++)
            twice = taken[content->piece[i].first_chunk + k]++;
    rmap_free(taken);
    return twice ? rmap_error_set(err, RMAP_FORMAT, "%s: two pieces claim the same chunks", path)
                 : RMAP_OK;
}

static enum rmap_status share_rays(const struct rmap_map_content *content, const char *path,
                                   const struct rmap_portion_info *p,
                                   const struct rmap_portion_info *q, struct rmap_error *err)
{
    uint64_t end =
        rmap_portion_end(p) < rmap_portion_end(q) ? rmap_portion_end(p) : rmap_portion_end(q);
    if (rmap_portion_has_gaps(p) || rmap_portion_has_gaps(q))
        end = q->first_ray + 1; /* of the others nobody knows */
    return rmap_error_set(err, RMAP_FORMAT, "%s: %s and %s both hold the rays from %llu to %llu",
                          path, content->piece[p->piece].name, content->piece[q->piece].name,
                          (unsigned long long)q->first_ray, (unsigned long long)end - 1);
}

/* Blocks of the same rays come from two lives of one run: one of them must go. Portions with gaps
 * may lie within each other, but no two begin with the same ray. */
static enum rmap_status check_order(const struct rmap_map_content *content, const char *path,
                                    struct rmap_error *err)
{
    const struct rmap_portion_info *last = NULL; /* without gaps */
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *q = &content->portion[i], *p = i > 0 ? q - 1 : NULL;
        bool gaps = rmap_portion_has_gaps(q);
        if (p && p->first_ray > q->first_ray)
            return rmap_error_set(err, RMAP_FORMAT, "%s: /portion is not in the order of ray ids",
                                  path);
        if (p && p->first_ray == q->first_ray)
            return share_rays(content, path, p, q, err);
        if (last && !gaps && q->first_ray < rmap_portion_end(last))
            return share_rays(content, path, last, q, err);
        if (!gaps)
            last = q;
    }
    return RMAP_OK;
}

void rmap_map_content_run_up(struct rmap_map_content *content, size_t first)
{
    uint64_t work = first > 0 ? content->portion[first - 1].work : 0;
    uint64_t reach = first > 0 ? content->portion[first - 1].reach : 0;
    for (size_t i = first; i < content->n_portion; i++) {
        struct rmap_portion_info *info = &content->portion[i];
        const uint64_t end = rmap_portion_end(info);
        info->work = work += info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT];
        info->reach = reach = end > reach ? end : reach;
    }
}

/* Sums must not run over, or a small file could ask for any amount of memory. */
static enum rmap_status sum_up(struct rmap_map_content *content, const char *path,
                               struct rmap_error *err)
{
    memset(content->n_row, 0, sizeof content->n_row);
    content->digest = (struct rmap_digest){0, 0};
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        rmap_digest_add(&content->digest, portion->digest);
        for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
            if (portion->n_row[t] > UINT64_MAX / 4 - content->n_row[t])
                return rmap_error_set(err, RMAP_FORMAT,
                                      "%s: portion %zu of /portion has too many rows", path, i);
            content->n_row[t] += portion->n_row[t];
        }
    }
    rmap_map_content_run_up(content, 0);
    return RMAP_OK;
}

enum rmap_status rmap_map_content_check(struct rmap_map_content *content, const char *path,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check_pieces(content, path, err));
    RMAP_TRY(check_chunks(content, path, err));
    RMAP_TRY(check_rows(content, path, err));
    RMAP_TRY(check_order(content, path, err));
    RMAP_TRY(sum_up(content, path, err));
out:
    return st;
}
