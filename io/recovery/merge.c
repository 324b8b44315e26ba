/* SPDX-License-Identifier: MIT
 *
 * Several maps of one scene as one: their pieces are linked, not copied; the index is new.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_internal.h"
#include "io/map/map_run.h"
#include "io/map/piece_columns.h"
#include "io/recovery/merge.h"
#include "io/scene/scene_numbers.h"
#include "io/write/index_writer.h"
#include "portion/ray_plan.h"

struct merge {
    const struct rmap_merge_source *source;
    size_t n;
    const char *to;
    struct rmap_map sum; /* spaces and runs of all, for the index */
    struct rmap_map_content content;
    struct rmap_tally *tally;
    size_t n_symbolic;
};

/* The index has one set of numbers per space, and what is compact needs its own. */
static enum rmap_status check_numbers(const struct rmap_scene *scene, const struct rmap_map *map,
                                      size_t space, struct rmap_error *err)
{
    bool same = false;
    enum rmap_status st = rmap_scene_numbers_same(scene, map->scene[space], &same, err);
    if (st == RMAP_OK && !same)
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s was traced on a machine that computes other numbers from the scene "
                            "(sines, powers)",
                            map->path);
    return st;
}

/* Scenes are the sources' own. */
static enum rmap_status add_scene(struct merge *self, struct rmap_scene *scene,
                                  struct rmap_error *err)
{
    size_t n = self->sum.spaces.n;
    struct rmap_scene **list = rmap_realloc(self->sum.scene, n + 1, sizeof *list);
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
    self->sum.scene = list;
    list[n] = scene;
    return RMAP_OK;
}

/* Number in the merged map of each space of a source; *space_ret: rmap_free. */
static enum rmap_status join_spaces(struct merge *self, const struct rmap_map *map,
                                    int32_t **space_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_spaces *spaces = &self->sum.spaces;
    int32_t *number = rmap_alloc(map->spaces.n, sizeof *number);
    if (!number)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
    for (size_t k = 0; k < map->spaces.n && st == RMAP_OK; k++) {
        struct rmap_map_spaces one = {.space = &map->spaces.space[k], .n = 1};
        number[k] = rmap_map_spaces_find(spaces, one.space->digest);
        if (number[k] >= 0) {
            st = check_numbers(self->sum.scene[number[k]], map, k, err);
            continue;
        }
        number[k] = (int32_t)spaces->n;
        st = add_scene(self, map->scene[k], err);
        if (st == RMAP_OK)
            st = rmap_map_spaces_copy(spaces, &one, err);
    }
    if (st == RMAP_OK)
        *space_ret = number;
    else
        rmap_free(number);
    return st;
}

static enum rmap_status join_runs(struct merge *self, const struct rmap_map *map,
                                  const int32_t *space, struct rmap_error *err)
{
    struct rmap_run_row *row =
        rmap_realloc(self->sum.run, self->sum.n_run + map->n_run + 1, sizeof *row);
    if (!row)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of runs");
    self->sum.run = row;
    for (size_t i = 0; i < map->n_run; i++) {
        if (map->run[i].space < 0 || (size_t)map->run[i].space >= map->spaces.n)
            return rmap_error_set(err, RMAP_FORMAT, "%s/map.h5: /run names no colour space",
                                  map->path);
        row[self->sum.n_run] = map->run[i];
        row[self->sum.n_run++].space = space[map->run[i].space];
    }
    return RMAP_OK;
}

/* Appends a source's content under new shard numbers and those of its spaces. */
static enum rmap_status join_content(struct merge *self, const struct rmap_map *map,
                                     const int32_t *space, int *shard, struct rmap_error *err)
{
    struct rmap_map_content *content = &self->content;
    size_t piece = content->n_piece, portion = content->n_portion;
    enum rmap_status st = rmap_map_content_add(content, &map->content, err);
    int last = *shard;
    for (; st == RMAP_OK && piece < content->n_piece; piece++) {
        struct rmap_piece_info *info = &content->piece[piece];
        if (info->shard >= RMAP_NUMBER_END - *shard)
            return rmap_error_set(err, RMAP_INPUT, "a map has at most %d shards", RMAP_NUMBER_END);
        info->shard += *shard;
        info->space = space[info->space];
        last = info->shard >= last ? info->shard + 1 : last;
        rmap_piece_name_set(info);
    }
    for (; st == RMAP_OK && portion < content->n_portion; portion++) {
        content->portion[portion].shard += *shard;
        content->portion[portion].space = space[content->portion[portion].space];
        content->portion[portion].is_added = 0;
    }
    *shard = last;
    return st;
}

/* A symbolic link that holds wherever the map lies. */
static int link_from_afar(const char *from, const char *to)
{
    char here[PATH_MAX];
    if (from[0] == '/')
        return symlink(from, to);
    char *whole = getcwd(here, sizeof here) ? rmap_path_format("%s/%s", here, from) : NULL;
    int failed = whole ? symlink(whole, to) : -1;
    int reason = errno;
    rmap_free(whole);
    errno = reason;
    return failed;
}

/* A hard link, or a symbolic one from another file system. */
static enum rmap_status link_piece(struct merge *self, const char *from, const char *to,
                                   struct rmap_error *err)
{
    int failed = linkat(AT_FDCWD, from, AT_FDCWD, to, AT_SYMLINK_FOLLOW);
    if (failed && (errno == EXDEV || errno == EPERM || errno == EOPNOTSUPP || errno == EMLINK)) {
        failed = link_from_afar(from, to);
        self->n_symbolic += !failed;
    }
    return failed
               ? rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be linked: %s", to, strerror(errno))
               : RMAP_OK;
}

/* What stands beside the piece, if there is something: it finds its rays wherever it stands. */
static enum rmap_status link_beside(const struct merge *self, const struct rmap_map *map, size_t i,
                                    const struct rmap_piece_info *info,
                                    char *(*path_of)(const char *map_path,
                                                     const struct rmap_piece_info *piece),
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat file;
    struct merge uncounted = *self;
    char *from = path_of(map->path, &map->content.piece[i]);
    char *to = path_of(self->to, info);
    if (!from || !to)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    else if (stat(from, &file) == 0)
        st = link_piece(&uncounted, from, to, err);
    rmap_free(from);
    rmap_free(to);
    return st;
}

/* The questions of all maps, each map's under a number of its own. */
static enum rmap_status join_selections(const struct merge *self,
                                        struct rmap_selection **selection_ret,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_selection *sum = NULL;
    int32_t part = 0;
    if (!self->source[0].map->selection)
        return RMAP_OK;
    RMAP_TRY(rmap_selection_copy(self->source[0].map->selection, &sum, err));
    for (size_t k = 0; k < self->n; k++) {
        const struct rmap_selection *own = self->source[k].map->selection;
        int32_t first = part;
        for (size_t i = 0; i < own->n; i++) {
            struct rmap_selection_step step = own->step[i];
            step.part += first;
            part = step.part >= part ? step.part + 1 : part;
            if (k > 0)
                RMAP_TRY(rmap_selection_add(sum, &step, err));
        }
    }
    *selection_ret = sum;
    sum = NULL;
out:
    rmap_selection_destroy(sum);
    return st;
}

/* Links piece i of a source as `info`, in a directory that is made for the first of its shard. */
static enum rmap_status place_piece(struct merge *self, const struct rmap_map *map, size_t i,
                                    const struct rmap_piece_info *info, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *from = rmap_map_piece_path(map, i);
    char *to = rmap_path_format("%s/%s", self->to, info->name);
    char *shard = rmap_path_format("%s/shard-%05d", self->to, (int)info->shard);
    if (!from || !to || !shard) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    if (mkdir(shard, 0777) != 0 && errno != EEXIST) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot make the directory: %s", shard,
                            strerror(errno));
        goto out;
    }
    RMAP_TRY(link_piece(self, from, to, err));
    RMAP_TRY(link_beside(self, map, i, info, rmap_piece_columns_path, err));
    if (i + 1 == map->content.n_piece || info[1].shard != info->shard)
        RMAP_TRY(rmap_sync_directory(shard, err));
out:
    rmap_free(from);
    rmap_free(to);
    rmap_free(shard);
    return st;
}

static enum rmap_status place_pieces(struct merge *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t at = 0;
    for (size_t k = 0; k < self->n; k++)
        for (size_t i = 0; i < self->source[k].map->content.n_piece; i++, at++)
            RMAP_TRY(place_piece(self, self->source[k].map, i, &self->content.piece[at], err));
    RMAP_TRY(rmap_sync_directory(self->to, err));
out:
    return st;
}

static enum rmap_status join(struct merge *self, bool *complete, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int shard = 0;
    for (size_t k = 0; k < self->n && st == RMAP_OK; k++) {
        const struct rmap_map *map = self->source[k].map;
        int32_t *space = NULL;
        st = join_spaces(self, map, &space, err);
        if (st == RMAP_OK)
            st = join_runs(self, map, space, err);
        if (st == RMAP_OK)
            st = join_content(self, map, space, &shard, err);
        if (st == RMAP_OK)
            rmap_tally_merge(self->tally, map->tally);
        *complete = *complete && map->summary.complete;
        rmap_free(space);
    }
    return st;
}

enum rmap_status rmap_merge(const struct rmap_merge_source *source, size_t n, const char *to,
                            size_t *n_symbolic_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct merge self = {.source = source, .n = n, .to = to};
    struct rmap_map_run run = {0};
    struct rmap_selection *selection = NULL;
    bool complete = true;
    RMAP_TRY(rmap_tally_create(rmap_map_scene(source[0].map), &self.tally, err));
    RMAP_TRY(join(&self, &complete, err));
    RMAP_TRY(rmap_map_run_init(source[0].map, 0, RMAP_ENCODING_PLAIN, &run, err));
    RMAP_TRY(join_selections(&self, &selection, err));
    run.run.selection = selection;
    for (size_t k = 1; k < n; k++)
        if (source[k].map->summary.n_rank > run.run.n_rank)
            run.run.n_rank = source[k].map->summary.n_rank;
    struct rmap_index index = {.run = &run.run, .before = &self.sum};
    RMAP_TRY(rmap_index_write_content(to, &index, err));
    RMAP_TRY(place_pieces(&self, err));
    index.content = &self.content;
    index.tally = self.tally;
    index.complete = complete;
    RMAP_TRY(rmap_index_write_content(to, &index, err));
    *n_symbolic_ret = self.n_symbolic;
out:
    rmap_map_run_fini(&run);
    rmap_selection_destroy(selection);
    rmap_tally_destroy(self.tally);
    rmap_map_content_fini(&self.content);
    rmap_map_spaces_fini(&self.sum.spaces);
    rmap_free(self.sum.run);
    rmap_free(self.sum.scene);
    return st;
}

/* May maps be one? */

/* A portion of one of the maps. */
struct held {
    const struct rmap_portion_info *info;
    size_t source, portion;
};

static int by_first(const void *a, const void *b)
{
    const struct held *x = a, *y = b;
    return (x->info->first_ray > y->info->first_ray) - (x->info->first_ray < y->info->first_ray);
}

/* Ids are read where portions with gaps lie within each other; a cursor per map. */
struct reading {
    const struct rmap_merge_source *source;
    struct rmap_cursor **cursor; /* [n] of maps, made when first needed */
};

static enum rmap_status read_ids(const struct reading *self, const struct held *held,
                                 const struct rmap_portion **rows_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor **cursor = &self->cursor[held->source];
    if (!*cursor)
        st = rmap_cursor_create(self->source[held->source].map, RMAP_COLUMN_BIT(RMAP_RAY_id),
                                cursor, err);
    return st == RMAP_OK ? rmap_cursor_read(*cursor, held->portion, rows_ret, err) : st;
}

/* Rays that two of the maps hold both: the first two that were found. */
struct shared {
    size_t source[2];
    struct rmap_ray_range *range; /* [n], in the order in which they were found */
    size_t n, cap;
};

static enum rmap_status add_shared(struct shared *shared, struct rmap_ray_range range,
                                   struct rmap_error *err)
{
    if (shared->n > 0 && shared->range[shared->n - 1].end == range.first) {
        shared->range[shared->n - 1].end = range.end;
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(shared->range, shared->cap, shared->n + 1, err);
    if (st == RMAP_OK)
        shared->range[shared->n++] = range;
    return st;
}

/* Of two portions, the second of which begins within the first. */
static enum rmap_status find_shared(const struct reading *self, const struct held *a,
                                    const struct held *b, struct shared *shared,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *x = NULL, *y = NULL;
    if (!rmap_portion_has_gaps(a->info) && !rmap_portion_has_gaps(b->info)) {
        uint64_t end = rmap_portion_end(a->info), other = rmap_portion_end(b->info);
        return add_shared(
            shared, (struct rmap_ray_range){b->info->first_ray, end < other ? end : other}, err);
    }
    RMAP_TRY(read_ids(self, a, &x, err));
    RMAP_TRY(read_ids(self, b, &y, err));
    for (size_t i = 0, k = 0; i < x->n_row[RMAP_TABLE_RAY] && k < y->n_row[RMAP_TABLE_RAY];) {
        uint64_t ray = x->ray.id[i];
        if (ray == y->ray.id[k])
            RMAP_TRY(add_shared(shared, (struct rmap_ray_range){ray, ray + 1}, err));
        if (ray < y->ray.id[k])
            i++;
        else
            k++;
    }
out:
    return st;
}

/* "ray 7", "the rays 0 to 4095, 8192 to 9000 and others (12,345 rays)" */
static void name_rays(const struct rmap_ray_set *rays, char *text, size_t cap)
{
    enum { SHOWN = 3 };
    const uint64_t n = rmap_ray_set_count(rays);
    size_t at = (size_t)snprintf(text, cap, "%s", n == 1 ? "ray" : "the rays");
    for (size_t i = 0; i < rays->n && i < SHOWN; i++) {
        const struct rmap_ray_range *range = &rays->range[i];
        at += (size_t)snprintf(text + at, cap - at, "%s%llu", i ? ", " : " ",
                               (unsigned long long)range->first);
        if (range->end - range->first > 1)
            at += (size_t)snprintf(text + at, cap - at, " to %llu",
                                   (unsigned long long)range->end - 1);
    }
    if (n > 1)
        (void)snprintf(text + at, cap - at, "%s (%s)", rays->n > SHOWN ? " and others" : "",
                       rmap_counted(n, "ray").text);
}

static enum rmap_status refuse_shared(const struct rmap_merge_source *source,
                                      const struct shared *shared, struct rmap_error *err)
{
    struct rmap_ray_set rays = {0};
    char text[256];
    enum rmap_status st = rmap_ray_set_make(shared->range, shared->n, &rays, err);
    if (st != RMAP_OK)
        return st;
    name_rays(&rays, text, sizeof text);
    rmap_ray_set_fini(&rays);
    const struct rmap_merge_source *a = &source[shared->source[0]], *b = &source[shared->source[1]];
    return rmap_error_set(
        err, RMAP_INPUT, "%s and %s both hold %s: only maps of different rays can be merged%s",
        a->path, b->path, text, a->map->selection ? "" : " (trace with --first-ray)");
}

/* Each portion against those before it that reach as far. */
static enum rmap_status compare_held(const struct reading *self, const struct held *held,
                                     size_t total, struct shared *shared, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < total; i++)
        for (size_t k = i + 1;
             k < total && held[k].info->first_ray < rmap_portion_end(held[i].info); k++) {
            size_t a = held[i].source, b = held[k].source, low = a < b ? a : b, high = a + b - low;
            if (a == b) /* its own index was checked when it was opened */
                continue;
            if (shared->n == 0)
                memcpy(shared->source, (const size_t[]){low, high}, sizeof shared->source);
            if (shared->source[0] == low && shared->source[1] == high)
                RMAP_TRY(find_shared(self, &held[i], &held[k], shared, err));
        }
    if (shared->n > 0)
        st = refuse_shared(self->source, shared, err);
out:
    return st;
}

static enum rmap_status check_rays(const struct rmap_merge_source *source, size_t n,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t total = 0, at = 0;
    for (size_t k = 0; k < n; k++)
        total += rmap_map_n_portion(source[k].map);
    struct held *held = rmap_alloc(total, sizeof *held);
    struct reading reading = {source, rmap_alloc(n, sizeof *reading.cursor)};
    struct shared shared = {0};
    if (!held || !reading.cursor) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
        goto out;
    }
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < rmap_map_n_portion(source[k].map); i++)
            held[at++] = (struct held){rmap_map_portion(source[k].map, i), k, i};
    if (total > 0)
        qsort(held, total, sizeof *held, by_first);
    st = compare_held(&reading, held, total, &shared, err);
out:
    for (size_t k = 0; reading.cursor && k < n; k++)
        rmap_cursor_destroy(reading.cursor[k]);
    rmap_free(reading.cursor);
    rmap_free(shared.range);
    rmap_free(held);
    return st;
}

/* The flux of picked rays is shared out over all of the map they were picked from. */
static enum rmap_status check_selections(const struct rmap_merge_source *source, size_t k,
                                         struct rmap_error *err)
{
    const struct rmap_selection *a = source[0].map->selection, *b = source[k].map->selection;
    if (!a && !b)
        return RMAP_OK;
    if (a && b && rmap_selection_same_origin(a, b))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s: rays that a query picked can only be merged with rays picked from "
                          "the same map: merge the whole maps, and ask the one that they make",
                          source[a ? 0 : k].path);
}

static enum rmap_status check_pieces(const struct rmap_merge_source *source, struct rmap_error *err)
{
    for (size_t i = 0; i < rmap_map_n_piece(source->map); i++)
        if (rmap_map_piece(source->map, i)->is_open)
            return rmap_error_set(err, RMAP_INPUT,
                                  "%s has pieces that were never finished; first: raymap repair %s",
                                  source->path, source->path);
    return rmap_map_check_pieces(source->map, err);
}

enum rmap_status rmap_merge_check(const struct rmap_merge_source *source, size_t n,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < n; k++) {
        struct rmap_map_run run;
        int32_t space;
        RMAP_TRY(check_pieces(&source[k], err));
        RMAP_TRY(check_selections(source, k, err));
        st = rmap_map_run_init(source[k].map, 0, RMAP_ENCODING_PLAIN, &run, err);
        if (st == RMAP_OK)
            st = rmap_map_admit(source[0].map, &run.run, &space, err);
        rmap_map_run_fini(&run);
        if (st != RMAP_OK) {
            rmap_error_context(err, "%s cannot join", source[k].path);
            goto out;
        }
    }
    RMAP_TRY(check_rays(source, n, err));
out:
    return st;
}
