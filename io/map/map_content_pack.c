/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_content.h"

/* Between ranks of one program: structs as they are, with their sizes in front. */
struct head {
    char magic[8];
    uint64_t piece_nbytes, portion_nbytes, chunk_nbytes, tail_nbytes;
    uint64_t n_piece, n_portion, n_chunk, n_tail; /* behind the tails stand their data */
};

static const char magic[8] = {'R', 'M', 'A', 'P', 'C', 'N', 'T', '2'};

static struct head head_of(const struct rmap_map_content *content)
{
    struct head head = {.piece_nbytes = sizeof *content->piece,
                        .portion_nbytes = sizeof *content->portion,
                        .chunk_nbytes = sizeof *content->chunk,
                        .tail_nbytes = sizeof *content->tail,
                        .n_piece = content->n_piece,
                        .n_portion = content->n_portion,
                        .n_chunk = content->n_chunk,
                        .n_tail = content->n_tail};
    memcpy(head.magic, magic, sizeof magic);
    return head;
}

static uint8_t *put(uint8_t *to, const void *from, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(to, from, nbytes);
    return to + nbytes;
}

enum rmap_status rmap_map_content_pack(const struct rmap_map_content *content, uint8_t **blob_ret,
                                       size_t *nbytes_ret, struct rmap_error *err)
{
    const struct head head = head_of(content);
    size_t piece = content->n_piece * sizeof *content->piece;
    size_t portion = content->n_portion * sizeof *content->portion;
    size_t chunk = content->n_chunk * sizeof *content->chunk;
    size_t tail = content->n_tail * sizeof *content->tail;
    size_t nbytes = sizeof head + piece + portion + chunk + tail;
    for (size_t i = 0; i < content->n_tail; i++)
        nbytes += content->tail[i].nbytes;
    uint8_t *blob = rmap_alloc(nbytes, 1);
    if (!blob)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of %zu pieces",
                              content->n_piece);
    uint8_t *at = put(blob, &head, sizeof head);
    at = put(at, content->piece, piece);
    at = put(at, content->portion, portion);
    at = put(at, content->chunk, chunk);
    at = put(at, content->tail, tail);
    for (size_t i = 0; i < content->n_tail; i++)
        at = put(at, content->tail[i].data, content->tail[i].nbytes);
    *blob_ret = blob;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

/* Takes n rows of row_nbytes off the front; NULL when there are not as many. */
static void *take(const uint8_t **from, size_t *left, uint64_t n, size_t row_nbytes,
                  struct rmap_error *err, enum rmap_status *st)
{
    if (*st != RMAP_OK)
        return NULL;
    if (n > *left / row_nbytes) {
        *st = rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces was cut off");
        return NULL;
    }
    void *rows = rmap_alloc((size_t)n, row_nbytes);
    if (!rows)
        *st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of pieces");
    else if (n > 0)
        memcpy(rows, *from, (size_t)n * row_nbytes);
    *from += (size_t)n * row_nbytes;
    *left -= (size_t)n * row_nbytes;
    return rows;
}

/* The tails, whose pointers are another process's, and then their data. */
static void take_tails(const uint8_t **from, size_t *left, uint64_t n,
                       struct rmap_map_content *content, struct rmap_error *err,
                       enum rmap_status *st)
{
    content->tail = take(from, left, n, sizeof *content->tail, err, st);
    if (*st != RMAP_OK)
        return;
    content->n_tail = (size_t)n;
    for (size_t i = 0; i < content->n_tail; i++)
        content->tail[i].data = NULL;
    for (size_t i = 0; i < content->n_tail; i++)
        content->tail[i].data = take(from, left, content->tail[i].nbytes, 1, err, st);
}

static bool makes_sense(const struct rmap_map_content *content)
{
    bool good = true;
    for (size_t i = 0; i < content->n_piece; i++) {
        const struct rmap_piece_info *piece = &content->piece[i];
        good = good && piece->name[sizeof piece->name - 1] == 0 &&
               piece->first_chunk <= content->n_chunk &&
               piece->n_chunk <= content->n_chunk - piece->first_chunk;
    }
    for (size_t i = 0; i < content->n_portion; i++)
        good = good && content->portion[i].piece >= 0 &&
               (size_t)content->portion[i].piece < content->n_piece;
    for (size_t i = 0; i < content->n_tail; i++)
        good = good && content->tail[i].piece >= 0 &&
               (size_t)content->tail[i].piece < content->n_piece;
    return good;
}

enum rmap_status rmap_map_content_unpack(const uint8_t *blob, size_t nbytes,
                                         struct rmap_map_content *into, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content content = {0};
    const struct head mine = head_of(&content);
    struct head head;
    if (nbytes < sizeof head)
        return rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces was cut off");
    memcpy(&head, blob, sizeof head);
    if (memcmp(&head, &mine, offsetof(struct head, n_piece)) != 0)
        return rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces is of another program");
    const uint8_t *at = blob + sizeof head;
    size_t left = nbytes - sizeof head;
    content.piece = take(&at, &left, head.n_piece, sizeof *content.piece, err, &st);
    content.portion = take(&at, &left, head.n_portion, sizeof *content.portion, err, &st);
    content.chunk = take(&at, &left, head.n_chunk, sizeof *content.chunk, err, &st);
    take_tails(&at, &left, head.n_tail, &content, err, &st);
    if (st == RMAP_OK) {
        content.n_piece = (size_t)head.n_piece;
        content.n_portion = (size_t)head.n_portion;
        content.n_chunk = (size_t)head.n_chunk;
        if (left != 0 || !makes_sense(&content))
            st = rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces makes no sense");
    }
    if (st == RMAP_OK)
        st = rmap_map_content_add(into, &content, err);
    rmap_map_content_fini(&content);
    return st;
}
