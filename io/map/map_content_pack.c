/* SPDX-License-Identifier: MIT
 *
 * What pieces hold, as a block of bytes for another process.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/file/write_all.h"
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

void rmap_pack(struct rmap_packing *packing, const void *from, size_t nbytes)
{
    if (!packing->to) {
        packing->failed = packing->failed || !rmap_write_all(packing->fd, from, nbytes);
    } else if (nbytes > 0) {
        memcpy(packing->to, from, nbytes);
        packing->to += nbytes;
    }
}

size_t rmap_map_content_packed_nbytes(const struct rmap_map_content *content)
{
    size_t nbytes = sizeof(struct head) + content->n_piece * sizeof *content->piece +
                    content->n_portion * sizeof *content->portion +
                    content->n_chunk * sizeof *content->chunk +
                    content->n_tail * sizeof *content->tail;
    for (size_t i = 0; i < content->n_tail; i++)
        nbytes += content->tail[i].nbytes;
    return nbytes;
}

void rmap_map_content_pack(const struct rmap_map_content *content, struct rmap_packing *packing)
{
    const struct head head = head_of(content);
    rmap_pack(packing, &head, sizeof head);
    rmap_pack(packing, content->piece, content->n_piece * sizeof *content->piece);
    rmap_pack(packing, content->portion, content->n_portion * sizeof *content->portion);
    rmap_pack(packing, content->chunk, content->n_chunk * sizeof *content->chunk);
    rmap_pack(packing, content->tail, content->n_tail * sizeof *content->tail);
    for (size_t i = 0; i < content->n_tail; i++)
        rmap_pack(packing, content->tail[i].data, content->tail[i].nbytes);
}

/* Takes n rows of row_nbytes off the front; NULL when there are not as many. */
static void *take(uint8_t **from, size_t *left, uint64_t n, size_t row_nbytes)
{
    void *rows = *from;
    if (!rows || n > *left / row_nbytes) {
        *from = NULL;
        return NULL;
    }
    *from += (size_t)n * row_nbytes;
    *left -= (size_t)n * row_nbytes;
    return rows;
}

/* The tails, whose pointers are another process's, and then their data. */
static enum rmap_status take_tails(uint8_t **from, size_t *left, uint64_t n,
                                   struct rmap_map_content *view, struct rmap_error *err)
{
    const void *tail = take(from, left, n, sizeof *view->tail);
    if (!tail || n == 0)
        return RMAP_OK;
    view->tail = rmap_alloc((size_t)n, sizeof *view->tail);
    if (!view->tail)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of pieces");
    memcpy(view->tail, tail, (size_t)n * sizeof *view->tail);
    view->n_tail = (size_t)n;
    for (size_t i = 0; i < view->n_tail; i++)
        view->tail[i].data = take(from, left, view->tail[i].nbytes, 1);
    return RMAP_OK;
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

enum rmap_status rmap_map_content_view(uint8_t *blob, size_t nbytes,
                                       struct rmap_map_content *view_ret, struct rmap_error *err)
{
    struct rmap_map_content view = {0};
    const struct head mine = head_of(&view);
    struct head head;
    if (nbytes < sizeof head)
        return rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces was cut off");
    memcpy(&head, blob, sizeof head);
    if (memcmp(&head, &mine, offsetof(struct head, n_piece)) != 0)
        return rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces is of another program");
    uint8_t *at = blob + sizeof head;
    size_t left = nbytes - sizeof head;
    view.piece = take(&at, &left, view.n_piece = (size_t)head.n_piece, sizeof *view.piece);
    view.portion = take(&at, &left, view.n_portion = (size_t)head.n_portion, sizeof *view.portion);
    view.chunk = take(&at, &left, view.n_chunk = (size_t)head.n_chunk, sizeof *view.chunk);
    enum rmap_status st = take_tails(&at, &left, head.n_tail, &view, err);
    if (st == RMAP_OK && (!at || left != 0))
        st = rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces was cut off");
    if (st == RMAP_OK)
        *view_ret = view;
    else
        rmap_free(view.tail);
    return st;
}

enum rmap_status rmap_map_content_unpack(uint8_t *blob, size_t nbytes,
                                         struct rmap_map_content *into, struct rmap_error *err)
{
    struct rmap_map_content view;
    enum rmap_status st = rmap_map_content_view(blob, nbytes, &view, err);
    if (st != RMAP_OK)
        return st;
    st = makes_sense(&view)
             ? rmap_map_content_add(into, &view, err)
             : rmap_error_set(err, RMAP_FORMAT, "a rank's list of pieces makes no sense");
    rmap_free(view.tail);
    return st;
}
