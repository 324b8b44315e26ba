/* SPDX-License-Identifier: MIT
 *
 * Steps that bring a damaged map back to a whole one of the rays that are left.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/seal.h"
#include "io/hdf5/h5_read.h"
#include "io/map/history_file.h"
#include "io/map/journal.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/map_rays.h"
#include "io/map/map_run.h"
#include "io/map/map_scan.h"
#include "io/map/provenance.h"
#include "io/recovery/repair.h"
#include "io/recovery/verify_columns.h"
#include "io/write/index_writer.h"

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
    struct rmap_bundle common; /* under the name that files have in maps, not their own */
    uint64_t end = 0;
    char isa[32] = "", name[] = RMAP_SCENE_NAME;
    RMAP_TRY(rmap_piece_origin_of(&run, &given, err));
    RMAP_TRY(read_disk(path, given.space_digest, &content, &found, err));
    if (strcmp(given.space_digest, found.space_digest) != 0) {
        common = *scene->bundle;
        common.path = name;
        run.bundle = &common;
        rmap_map_content_fini(&content);
        RMAP_TRY(rmap_piece_origin_of(&run, &given, err));
        RMAP_TRY(read_disk(path, given.space_digest, &content, &found, err));
    }
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

/* What a repaired map has no use for. */

struct removal {
    const struct rmap_verification *self;
    const struct rmap_map_content *now; /* what the index lists */
    struct rmap_ray_set rays;           /* that it holds */
    struct rmap_findings *done;
};

static bool lists(const struct rmap_map_content *content, const char *name)
{
    for (size_t i = 0; i < content->n_piece; i++)
        if (strcmp(content->piece[i].name, name) == 0)
            return true;
    return false;
}

static bool was_replaced(const struct rmap_verification *self, const char *name)
{
    for (size_t i = 0; i < self->content->n_piece; i++)
        if (strcmp(self->content->piece[i].name, name) == 0)
            return !(self->piece_flag[i] & RMAP_PIECE_GONE) && rmap_repair_replaces(self, i);
    return false;
}

/* *why_ret NULL: the file stays, as it does where anything of it cannot be told just now. */
static enum rmap_status why_remove(const struct removal *removal,
                                   const struct rmap_piece_name *name, const char *file,
                                   const char *path, const char **why_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = removal->self->map;
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin = {0};
    struct rmap_ray_set own = {0}, rest = {0};
    struct rmap_error why = {0};
    struct stat status;
    *why_ret = NULL;
    RMAP_TRY(rmap_path_look(path, &status, &why));
    if (S_ISDIR(status.st_mode))
        goto out; /* whoever put it there knows what is in it */
    if (was_replaced(removal->self, file)) {
        *why_ret = "removed: what was good of it stands in another piece";
        goto out;
    }
    st = rmap_seal_check(path, &why);
    if (st == RMAP_FORMAT)
        *why_ret = "removed: it was damaged";
    RMAP_TRY(st);
    RMAP_TRY(
        rmap_piece_read(removal->self->path, name->shard, name->number, &content, &origin, &why));
    if (origin.seed != map->summary.seed || strcmp(origin.scene_digest, map->scene_digest) != 0)
        goto out;
    RMAP_TRY(rmap_rays_held(&content, &own, &why));
    RMAP_TRY(rmap_ray_set_minus(&own, &removal->rays, &rest, &why));
    if (rest.n == 0)
        *why_ret = "removed: other pieces hold its rays";
out:
    rmap_ray_set_fini(&own);
    rmap_ray_set_fini(&rest);
    rmap_map_content_fini(&content);
    return st == RMAP_SYSTEM ? rmap_error_set(err, st, "%s", why.text) : RMAP_OK;
}

static enum rmap_status remove_piece(const struct removal *removal,
                                     const struct rmap_piece_name *name, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_info info = {.shard = name->shard, .number = name->number};
    rmap_piece_name_set(&info);
    if (lists(removal->now, info.name))
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", removal->self->path, info.name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    const char *why = NULL;
    st = why_remove(removal, name, info.name, path, &why, err);
    if (why && rmap_shard_unlink(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    if (why && st == RMAP_OK)
        st = rmap_findings_note(removal->done, info.name, why, err);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_repair_remove(const struct rmap_verification *self,
                                    struct rmap_findings *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    struct rmap_map *map = NULL;
    size_t n = 0;
    struct removal removal = {.self = self, .done = done};
    RMAP_TRY(rmap_map_list_pieces(self->path, &name, &n, err));
    RMAP_TRY(rmap_map_open_listed(self->path, &map, err));
    removal.now = &map->content;
    RMAP_TRY(rmap_rays_held(removal.now, &removal.rays, err));
    for (size_t i = 0; i < n; i++)
        RMAP_TRY(remove_piece(&removal, &name[i], err));
    RMAP_TRY(rmap_remove_bad_columns(map, done, err));
out:
    rmap_ray_set_fini(&removal.rays);
    rmap_map_close(map);
    rmap_free(name);
    return st;
}

enum rmap_status rmap_repair_remove_histories(const char *map_path, struct rmap_findings *done,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    RMAP_TRY(rmap_map_list_histories(map_path, &name, &n, err));
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        char *path = rmap_history_path(map_path, &name[i]);
        if (!path)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        else if (rmap_shard_unlink(path) != 0)
            st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path,
                                strerror(errno));
        else
            st = rmap_findings_note(done, path + strlen(map_path) + 1,
                                    "removed: history indexes are no longer used", err);
        rmap_free(path);
    }
out:
    rmap_free(name);
    return st;
}

enum rmap_status rmap_repair_remove_leftover(const char *path, const char *name,
                                             struct rmap_findings *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_journal journal = {0};
    struct stat info;
    char *part = rmap_path_format("%s/%s", path, name);
    char *journal_path = part ? rmap_journal_path(part) : NULL;
    if (!journal_path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    enum rmap_status read = rmap_journal_read(journal_path, &journal, NULL);
    RMAP_TRY(rmap_path_look(part, &info, err));
    const bool odd = info.st_mode != 0 && !S_ISREG(info.st_mode);
    if (read == RMAP_SYSTEM || journal.other_version ||
        (read == RMAP_OK && journal.n_portion > 0 && !odd))
        goto out; /* nobody knows, or another raymap does, or of another scene: not ours */
    if ((rmap_shard_unlink(journal_path) != 0 && errno != ENOENT) ||
        (rmap_shard_unlink(part) != 0 && errno != ENOENT)) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", part, strerror(errno));
        goto out;
    }
    st = rmap_findings_note(
        done, name, odd ? "removed: it is not a regular file" : "removed: its journal was damaged",
        err);
out:
    rmap_journal_fini(&journal);
    rmap_free(journal_path);
    rmap_free(part);
    return st;
}
