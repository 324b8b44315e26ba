/* SPDX-License-Identifier: MIT
 *
 * Whether what a map says to hold fits together, before anybody relies on it.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_content.h"

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
