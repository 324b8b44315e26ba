/* SPDX-License-Identifier: MIT */
#include "io/map_scan.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/map_directory.h"
#include "io/provenance.h"
#include "io/publish.h"

static enum rmap_status check_origin(struct rmap_h5 *h5, uint64_t seed, const char *scene_digest,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t complete = 0;
    uint64_t piece_seed = 0;
    char digest[33];
    RMAP_TRY(rmap_provenance_check(h5, RMAP_FILETYPE_PIECE, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "complete", RMAP_I32, 1, &complete, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "seed", RMAP_U64, 1, &piece_seed, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "scene_digest", digest, sizeof digest, err));
    if (complete != 1)
        st = rmap_error_set(err, RMAP_FORMAT, "%s was never finished: remove it", h5->path);
    else if (piece_seed != seed || strcmp(digest, scene_digest) != 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s belongs to another scene or seed than this map: move it away",
                            h5->path);
out:
    return st;
}

static enum rmap_status add_portions(struct rmap_map_content *content, size_t piece,
                                     const struct rmap_portion_info *portion, size_t n,
                                     struct rmap_error *err)
{
    struct rmap_piece_info *info = &content->piece[piece];
    void *block = content->portion;
    enum rmap_status st =
        rmap_reserve(&block, &content->cap_portion, content->n_portion + n, sizeof *portion, err);
    content->portion = block;
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < n; i++) {
        struct rmap_portion_info *row = &content->portion[content->n_portion++];
        *row = portion[i];
        row->shard = info->shard;
        row->piece = (int32_t)piece;
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            info->n_row[t] += row->n_row[t];
    }
    return RMAP_OK;
}

static enum rmap_status scan_piece(const char *map_path, uint64_t seed, const char *scene_digest,
                                   struct rmap_map_content *content, size_t piece,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_field_table table = rmap_portion_fields_piece();
    struct stat info;
    void *portion = NULL;
    size_t n = 0;
    char *path = rmap_path_format("%s/%s", map_path, content->piece[piece].name);
    if (!path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    if (stat(path, &info) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", path, strerror(errno));
        goto out;
    }
    content->piece[piece].nbytes = (uint64_t)info.st_size;
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(check_origin(&h5, seed, scene_digest, err));
    RMAP_TRY(rmap_h5_read_fields(&h5, table.field, table.n, sizeof(struct rmap_portion_info),
                                 &portion, &n, err));
    RMAP_TRY(add_portions(content, piece, portion, n, err));
out:
    rmap_h5_drop(&h5);
    rmap_free(portion);
    rmap_free(path);
    return st;
}

static int by_first_ray(const void *a, const void *b)
{
    const struct rmap_portion_info *x = a, *y = b;
    if (x->first_ray != y->first_ray)
        return x->first_ray < y->first_ray ? -1 : 1;
    if (x->piece != y->piece)
        return x->piece < y->piece ? -1 : 1;
    return (x->first_row[0] > y->first_row[0]) - (x->first_row[0] < y->first_row[0]);
}

/* Blocks of the same rays come from two lives of one run: one of them must go. */
static enum rmap_status check_order(const struct rmap_map_content *content, const char *path,
                                    struct rmap_error *err)
{
    for (size_t i = 1; i < content->n_portion; i++) {
        const struct rmap_portion_info *p = &content->portion[i - 1], *q = p + 1;
        if (p->first_ray == q->first_ray)
            return rmap_error_set(err, RMAP_FORMAT, "%s: %s and %s both hold the rays from %llu on",
                                  path, content->piece[p->piece].name,
                                  content->piece[q->piece].name, (unsigned long long)q->first_ray);
    }
    return RMAP_OK;
}

/* Every table's row ranges in a piece must lie inside it, and add up to it. */
static enum rmap_status check_rows(const struct rmap_map_content *content, const char *path,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t(*sum)[RMAP_TABLE_COUNT] = rmap_alloc(content->n_piece, sizeof *sum);
    if (!sum)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t i = 0; st == RMAP_OK && i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        bool fits = portion->piece >= 0 && (size_t)portion->piece < content->n_piece;
        for (int t = 0; fits && t < RMAP_TABLE_COUNT; t++) {
            uint64_t rows = content->piece[portion->piece].n_row[t];
            fits = portion->first_row[t] <= rows &&
                   portion->n_row[t] <= rows - portion->first_row[t] &&
                   portion->n_row[t] <= rows - sum[portion->piece][t];
            if (fits)
                sum[portion->piece][t] += portion->n_row[t];
        }
        if (!fits)
            st = rmap_error_set(err, RMAP_FORMAT,
                                "%s: portion %zu of /portion points outside its piece", path, i);
    }
    for (size_t k = 0; st == RMAP_OK && k < content->n_piece; k++)
        if (memcmp(sum[k], content->piece[k].n_row, sizeof *sum) != 0)
            st = rmap_error_set(err, RMAP_FORMAT, "%s: the portions of %s do not add up to it",
                                path, content->piece[k].name);
    rmap_free(sum);
    return st;
}

enum rmap_status rmap_map_content_check(struct rmap_map_content *content, const char *path,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check_rows(content, path, err));
    RMAP_TRY(check_order(content, path, err));
    memset(content->n_row, 0, sizeof content->n_row);
    content->digest = (struct rmap_digest){0, 0};
    for (size_t i = 0; i < content->n_portion; i++) {
        rmap_digest_add(&content->digest, content->portion[i].digest);
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            content->n_row[t] += content->portion[i].n_row[t];
    }
out:
    return st;
}

enum rmap_status rmap_map_scan(const char *map_path, uint64_t seed, const char *scene_digest,
                               struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    *content = (struct rmap_map_content){0};
    RMAP_TRY(rmap_map_list_pieces(map_path, &name, &content->n_piece, err));
    content->piece = rmap_alloc(content->n_piece, sizeof *content->piece);
    if (!content->piece) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
        goto out;
    }
    for (size_t i = 0; i < content->n_piece; i++) {
        struct rmap_piece_info *piece = &content->piece[i];
        piece->shard = name[i].shard;
        piece->number = name[i].number;
        rmap_piece_name_set(piece);
        RMAP_TRY(scan_piece(map_path, seed, scene_digest, content, i, err));
    }
    if (content->n_portion > 0)
        qsort(content->portion, content->n_portion, sizeof *content->portion, by_first_ray);
    RMAP_TRY(rmap_map_content_check(content, map_path, err));
out:
    rmap_free(name);
    if (st != RMAP_OK)
        rmap_map_content_fini(content);
    return st;
}

void rmap_map_content_fini(struct rmap_map_content *content)
{
    rmap_free(content->piece);
    rmap_free(content->portion);
    *content = (struct rmap_map_content){0};
}
