/* SPDX-License-Identifier: MIT */
#include "io/recovery/repair.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/map_run.h"
#include "io/map/map_scan.h"
#include "io/map/provenance.h"

/* ---- the index without rays ---- */

static enum rmap_status write_bare(const char *path, const struct rmap_map *map,
                                   struct rmap_error *err)
{
    struct rmap_map_run run = {0};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_map_run_init(map, 0, RMAP_ENCODING_PLAIN, &run, err));
    const struct rmap_index index = {.run = &run.run, .before = map};
    RMAP_TRY(rmap_index_write_content(path, &index, err));
out:
    rmap_map_run_fini(&run);
    return st;
}

/* All pieces that open, whatever they hold; the origin of one in the colour space of that digest,
 * or the last one's. */
static enum rmap_status read_disk(const char *path, const char *space_digest,
                                  struct rmap_map_content *content,
                                  struct rmap_piece_origin *origin, struct rmap_error *err)
{
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_map_list_pieces(path, &name, &n, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++) {
        struct rmap_error why = {0};
        struct rmap_piece_origin one = {0};
        st = rmap_piece_read(path, name[i].shard, name[i].number, content, &one, &why);
        if (st == RMAP_OK && strcmp(origin->space_digest, space_digest) != 0)
            *origin = one;
        st = st == RMAP_SYSTEM ? rmap_error_set(err, st, "%s", why.text) : RMAP_OK;
    }
    rmap_free(name);
    return st;
}

/* Of a piece's file; empty when it does not say. */
static enum rmap_status read_isa(const char *path, const char *name, char isa[32],
                                 struct rmap_error *err)
{
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    char *file = rmap_path_format("%s/%s", path, name);
    if (!file)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = rmap_h5_open(&h5, file, err);
    if (st == RMAP_OK)
        st = rmap_h5_get_text(&h5, "/", "isa", isa, 32, err);
    if (st != RMAP_OK)
        isa[0] = 0;
    rmap_h5_drop(&h5);
    rmap_free(file);
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

/* With the scene alone nobody knows how many rays were asked for: those up to the last one. */
static enum rmap_status write_from_scene(const char *path, const struct rmap_run *scene,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content content = {0};
    struct rmap_piece_origin found = {0}, given;
    struct rmap_run run = *scene;
    struct rmap_run_row row = {.first_ray = UINT64_MAX, .n_rank = 1};
    uint64_t end = 0;
    char isa[32] = "";
    RMAP_TRY(rmap_piece_origin_of(&run, &given, err));
    RMAP_TRY(read_disk(path, given.space_digest, &content, &found, err));
    if (content.n_piece == 0) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s holds no piece that can be read", path);
        goto out;
    }
    RMAP_TRY(read_isa(path, content.piece[content.n_piece - 1].name, isa, err));
    run.isa = isa;
    run.seed = row.seed = found.seed;
    run.n_rank = 1;
    if (strcmp(given.space_digest, found.space_digest) != 0) {
        st =
            rmap_error_set(err, RMAP_INPUT,
                           "the pieces of %s were traced with another scene than the one given, or "
                           "with another --simulation, --only, --without, --set or --color",
                           path);
        goto out;
    }
    for (size_t i = 0; i < content.n_portion; i++) {
        const struct rmap_portion_info *info = &content.portion[i];
        row.first_ray = info->first_ray < row.first_ray ? info->first_ray : row.first_ray;
        if (rmap_portion_end(info) > end)
            end = rmap_portion_end(info);
    }
    row.n_ray = end > row.first_ray ? end - row.first_ray : 0;
    const struct rmap_index index = {.run = &run, .row = &row};
    RMAP_TRY(rmap_index_write_content(path, &index, err));
out:
    rmap_map_content_fini(&content);
    return st;
}

/* *map_ret NULL: it is not there or damaged, or its scene is another than the one that was traced.
 * RMAP_SYSTEM, where that cannot be told. */
static enum rmap_status open_bare(const char *path, const char *name, struct rmap_map **map_ret,
                                  struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = rmap_map_open_bare(path, name, &map, err);
    if (st == RMAP_OK)
        st = rmap_map_check_scene(map, err);
    if (st != RMAP_OK)
        rmap_map_close(map);
    else
        *map_ret = map;
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

enum rmap_status rmap_repair_index(const char *path, const struct rmap_run *scene,
                                   struct rmap_findings *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *index = NULL, *start = NULL;
    RMAP_TRY(open_bare(path, "map.h5", &index, err));
    RMAP_TRY(open_bare(path, RMAP_INDEX_START, &start, err));
    const bool itself = index && (!start || rmap_map_n_run_after(index, start) == 0);
    if (index || start) {
        RMAP_TRY(write_bare(path, itself ? index : start, err));
        RMAP_TRY(rmap_findings_note(
            done, "map.h5",
            itself ? "made again: scene and runs from itself, rays from the pieces"
                   : "made again: scene and runs from " RMAP_INDEX_START ", rays from the pieces",
            err));
    } else if (scene) {
        RMAP_TRY(write_from_scene(path, scene, err));
        RMAP_TRY(rmap_findings_note(done, "map.h5",
                                    "made again: the scene as given, rays from the pieces", err));
    } else {
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s: neither map.h5 nor " RMAP_INDEX_START
                            " can be read; give the scene that was traced, with --scene FILE",
                            path);
    }
out:
    rmap_map_close(index);
    rmap_map_close(start);
    return st;
}

/* ---- what stays ---- */

static bool has_lost(const struct rmap_verification *self, size_t piece)
{
    const struct rmap_map_content *content = self->content;
    bool lost = false;
    for (size_t i = 0; i < content->n_portion && !lost; i++)
        lost =
            (size_t)content->portion[i].piece == piece && self->portion_flag[i] & RMAP_PORTION_LOST;
    return lost;
}

bool rmap_repair_replaces(const struct rmap_verification *self, size_t piece)
{
    return !self->content->piece[piece].is_open &&
           (self->piece_flag[piece] != 0 || has_lost(self, piece));
}

static enum rmap_status keep_piece(const struct rmap_map_content *content, size_t piece,
                                   struct rmap_map_content *kept, struct rmap_error *err)
{
    const struct rmap_piece_info *info = &content->piece[piece];
    struct rmap_portion_info *portion = rmap_alloc(content->n_portion, sizeof *portion);
    size_t n = 0;
    if (!portion)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
    for (size_t i = 0; i < content->n_portion; i++)
        if ((size_t)content->portion[i].piece == piece) {
            portion[n] = content->portion[i];
            portion[n++].is_added = 0;
        }
    enum rmap_status st = RMAP_OK;
    if (n > 0)
        st = rmap_map_content_add_piece(kept, info, portion, n, content->chunk + info->first_chunk,
                                        err);
    rmap_free(portion);
    return st;
}

enum rmap_status rmap_repair_write(const struct rmap_verification *self,
                                   const struct rmap_map_content *copied,
                                   const struct rmap_tally *tally, bool complete,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content kept = {0};
    struct rmap_map_run run = {0};
    for (size_t i = 0; i < self->content->n_piece; i++)
        if (!self->content->piece[i].is_open && !rmap_repair_replaces(self, i))
            RMAP_TRY(keep_piece(self->content, i, &kept, err));
    RMAP_TRY(rmap_map_content_add(&kept, copied, err));
    RMAP_TRY(rmap_map_run_init(self->map, 0, RMAP_ENCODING_PLAIN, &run, err));
    const struct rmap_index index = {.run = &run.run,
                                     .before = self->map,
                                     .content = &kept,
                                     .tally = tally,
                                     .complete = complete};
    RMAP_TRY(rmap_index_write_content(self->path, &index, err));
out:
    rmap_map_run_fini(&run);
    rmap_map_content_fini(&kept);
    return st;
}

enum rmap_status rmap_repair_free_shard(const char *path, int *shard_ret, struct rmap_error *err)
{
    struct rmap_piece_name *name = NULL;
    struct stat info;
    size_t n = 0;
    bool taken = true;
    *shard_ret = 0;
    enum rmap_status st = rmap_map_list_pieces(path, &name, &n, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++)
        *shard_ret = name[i].shard >= *shard_ret ? name[i].shard + 1 : *shard_ret;
    rmap_free(name);
    while (st == RMAP_OK && taken) { /* shards without a piece */
        char *shard = rmap_path_format("%s/shard-%05d", path, *shard_ret);
        if (!shard)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        st = rmap_path_look(shard, &info, err);
        taken = info.st_mode != 0;
        *shard_ret += taken;
        rmap_free(shard);
    }
    return st;
}
