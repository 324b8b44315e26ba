/* SPDX-License-Identifier: MIT
 *
 * Reading a ray map.
 */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "compact/model.h"
#include "compact/paths.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_dim.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/map_paths.h"
#include "io/map/map_rays.h"
#include "io/map/map_tally.h"
#include "io/map/named_rays.h"
#include "io/map/piece_columns.h"
#include "io/map/portion_rows.h"
#include "io/map/provenance.h"
#include "io/mesh/bundle_pack.h"
#include "io/scene/scene_numbers.h"
#include "trace/tally.h"

/* What an open map tells of itself. */

uint64_t rmap_portion_end(const struct rmap_portion_info *portion)
{
    uint64_t n = portion->n_row[RMAP_TABLE_RAY];
    if (portion->last_ray >= portion->first_ray && portion->last_ray - portion->first_ray >= n)
        return portion->last_ray == UINT64_MAX ? UINT64_MAX : portion->last_ray + 1;
    return n > UINT64_MAX - portion->first_ray ? UINT64_MAX : portion->first_ray + n;
}

bool rmap_portion_has_gaps(const struct rmap_portion_info *portion)
{
    return rmap_portion_end(portion) - portion->first_ray > portion->n_row[RMAP_TABLE_RAY];
}

const struct rmap_scene *rmap_map_scene(const struct rmap_map *map)
{
    return map->scene[0];
}

size_t rmap_map_n_space(const struct rmap_map *map)
{
    return map->spaces.n;
}

const struct rmap_scene *rmap_map_scene_of(const struct rmap_map *map, size_t space)
{
    return map->scene[space];
}

bool rmap_map_find_ray(const struct rmap_map *map, uint64_t ray, size_t *portion)
{
    const struct rmap_portion_info *info = map->content.portion;
    size_t low = 0, high = *portion;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (info[middle].first_ray <= ray)
            low = middle + 1;
        else
            high = middle;
    }
    while (low > 0 && info[low - 1].reach > ray)
        if (rmap_portion_end(&info[--low]) > ray) {
            *portion = low;
            return true;
        }
    return false;
}

size_t rmap_map_space_of_ray(const struct rmap_map *map, uint64_t ray)
{
    size_t portion = map->content.n_portion;
    if (map->spaces.n < 2 || !rmap_map_find_ray(map, ray, &portion))
        return 0;
    return (size_t)map->content.portion[portion].space;
}

int rmap_map_n_channel(const struct rmap_map *map)
{
    return map->n_channel_max;
}

size_t rmap_map_n_run(const struct rmap_map *map)
{
    return map->n_run;
}

const struct rmap_run_row *rmap_map_run(const struct rmap_map *map, size_t run)
{
    return &map->run[run];
}

size_t rmap_map_n_run_after(const struct rmap_map *map, const struct rmap_map *later)
{
    if (strcmp(map->scene_digest, later->scene_digest) != 0 || later->n_run < map->n_run)
        return 0;
    for (size_t i = 0; i < map->n_run; i++) {
        const struct rmap_run_row *a = &map->run[i], *b = &later->run[i];
        if (a->first_ray != b->first_ray || a->n_ray != b->n_ray || a->seed != b->seed ||
            a->space != b->space)
            return 0;
    }
    return later->n_run - map->n_run;
}

const struct rmap_map_content *rmap_map_contents(const struct rmap_map *map)
{
    return &map->content;
}

size_t rmap_map_n_trouble(const struct rmap_map *map)
{
    return map->n_trouble;
}

const char *rmap_map_trouble(const struct rmap_map *map, size_t i)
{
    return map->trouble[i];
}

const struct rmap_bundle *rmap_map_bundle(const struct rmap_map *map)
{
    return map->bundle;
}

const struct rmap_tally *rmap_map_tally(const struct rmap_map *map)
{
    return map->tally;
}

const struct rmap_selection *rmap_map_selection(const struct rmap_map *map)
{
    return map->selection;
}

const double *rmap_map_emitted(const struct rmap_map *map)
{
    return map->selection ? map->selection->emitted : map->tally->emitted;
}

size_t rmap_map_n_portion(const struct rmap_map *map)
{
    return map->content.n_portion;
}

const struct rmap_portion_info *rmap_map_portion(const struct rmap_map *map, size_t portion)
{
    return &map->content.portion[portion];
}

size_t rmap_map_n_piece(const struct rmap_map *map)
{
    return map->content.n_piece;
}

const struct rmap_piece_info *rmap_map_piece(const struct rmap_map *map, size_t piece)
{
    return &map->content.piece[piece];
}

void rmap_map_summarise(const struct rmap_map *map, struct rmap_map_summary *summary)
{
    *summary = map->summary;
}

const double *rmap_map_flux_per_weight(const struct rmap_map *map)
{
    return map->flux_per_weight;
}

double rmap_map_flux(const struct rmap_map *map, size_t source, double weight)
{
    const double n = rmap_map_emitted(map)[source];
    return n > 0.0 && weight == n
               ? rmap_map_scene(map)->source[source].flux * rmap_map_dimmed(map, source)
               : map->flux_per_weight[source] * weight;
}

size_t rmap_map_split(const struct rmap_map *map, size_t n_part, size_t part)
{
    size_t low = 0, high = map->content.n_portion;
    if (part >= n_part)
        return high;
    /* work x part / n_part without overflow; a part's share may be off by n_part. */
    const struct rmap_portion_info *info = map->content.portion;
    uint64_t total = high > 0 ? info[high - 1].work : 0;
    uint64_t want = total / n_part * part + total % n_part * part / n_part;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if ((middle > 0 ? info[middle - 1].work : 0) < want)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Why an index could not be opened: RMAP_INPUT, RMAP_FORMAT or RMAP_SYSTEM with a remedy, instead
 * of what opening it said. */
static enum rmap_status explain(const char *path, const char *index, enum rmap_status st,
                                struct rmap_error *err)
{
    struct stat info;
    if (!*path)
        return rmap_error_set(err, RMAP_INPUT, "the name of the ray map is empty");
    if (stat(path, &info) != 0) {
        bool wrong_name = errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG;
        return rmap_error_set(err, wrong_name ? RMAP_INPUT : RMAP_SYSTEM,
                              "%s: cannot open the ray map: %s", path, strerror(errno));
    }
    if (!S_ISDIR(info.st_mode))
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s is a file, but a ray map is a directory (NAME.raymap)", path);
    if (stat(index, &info) == 0 || errno != ENOENT)
        return st;
    st = rmap_map_check_indexless(path, err);
    if (st != RMAP_OK)
        return st;
    char *scene = rmap_path_format("%s/scene.yaml", path);
    if (scene && stat(scene, &info) == 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s has no map.h5: it is no ray map (did you mean %s, or what `raymap "
                            "trace` makes of that?)",
                            path, scene);
    else
        st = rmap_error_set(err, RMAP_FORMAT, "%s has no map.h5: it is no ray map", path);
    rmap_free(scene);
    return st;
}

static enum rmap_status open_file(const char *path, const char *index, struct rmap_h5 *h5,
                                  struct rmap_map *map, struct rmap_error *err)
{
    hsize_t nbytes = 0;
    enum rmap_status st = rmap_h5_open(h5, index, err);
    if (st != RMAP_OK)
        return explain(path, index, st, err);
    if (H5Fget_filesize(h5->file, &nbytes) < 0)
        return rmap_h5_fail(h5, "its size", err);
    map->index_nbytes = nbytes;
    return RMAP_OK;
}

static enum rmap_status read_summary(struct rmap_map *map, struct rmap_h5 *h5,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary *s = &map->summary;
    int32_t ranks = 0, complete = 0;
    RMAP_TRY(rmap_h5_get(h5, "/", "seed", RMAP_U64, 1, &s->seed, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "scene_digest", map->scene_digest, sizeof map->scene_digest,
                              err));
    RMAP_TRY(rmap_tracer_revision_read(h5, &s->tracer_revision, err));
    RMAP_TRY(rmap_h5_get_text_if(h5, "/", "parent", s->parent, sizeof s->parent, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "ranks", RMAP_I32, 1, &ranks, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "complete", RMAP_I32, 1, &complete, err));
    s->n_rank = ranks;
    s->complete = complete == 1;
    const struct {
        const char *name;
        char *text;
        size_t nbytes;
    } text[] = {{"program_version", s->program_version, sizeof s->program_version},
                {"git_revision", s->git_revision, sizeof s->git_revision},
                {"isa", s->isa, sizeof s->isa},
                {"hdf5_version", s->hdf5_version, sizeof s->hdf5_version},
                {"embree_version", s->embree_version, sizeof s->embree_version}};
    for (size_t i = 0; i < sizeof text / sizeof *text; i++)
        RMAP_TRY(rmap_h5_get_text(h5, "/", text[i].name, text[i].text, text[i].nbytes, err));
out:
    return st;
}

static enum rmap_status read_runs(struct rmap_map *map, struct rmap_h5 *h5, struct rmap_error *err)
{
    struct rmap_field_table runs = rmap_run_fields();
    struct rmap_ray_set asked = {0};
    void *run = NULL;
    enum rmap_status st =
        rmap_h5_read_fields(h5, runs.field, runs.n, sizeof *map->run, &run, &map->n_run, err);
    map->run = run;
    if (st == RMAP_OK)
        st = rmap_rays_wanted(map, &asked, err);
    map->n_asked = rmap_ray_set_count(&asked);
    rmap_ray_set_fini(&asked);
    return st;
}

static enum rmap_status read_content(struct rmap_map *map, struct rmap_h5 *h5,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content *content = &map->content;
    bool curved = rmap_provenance_is_curved(h5);
    struct rmap_field_table pieces = rmap_piece_fields(curved), chunks = rmap_chunk_fields(),
                            portions = rmap_portion_fields_index(curved);
    uint64_t digest[2];
    void *piece = NULL, *chunk = NULL;
    RMAP_TRY(rmap_h5_read_fields(h5, pieces.field, pieces.n, sizeof *content->piece, &piece,
                                 &content->n_piece, err));
    content->piece = piece;
    RMAP_TRY(rmap_portion_rows_read(h5, portions, &content->portion, &content->n_portion, err));
    RMAP_TRY(rmap_h5_read_fields(h5, chunks.field, chunks.n, sizeof *content->chunk, &chunk,
                                 &content->n_chunk, err));
    content->chunk = chunk;
    content->cap_piece = content->n_piece;
    content->cap_portion = content->n_portion;
    content->cap_chunk = content->n_chunk;
    for (size_t i = 0; i < content->n_piece; i++) {
        struct rmap_piece_info *info = &content->piece[i];
        if (info->shard < 0 || info->shard > 99999 || info->number < 0 || info->number > 99999 ||
            info->space < 0 || (size_t)info->space >= map->spaces.n) {
            st = rmap_error_set(err, RMAP_FORMAT, "%s: /piece names no piece", h5->path);
            goto out;
        }
        rmap_piece_name_set(info);
    }
    RMAP_TRY(rmap_map_content_check(content, h5->path, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "digest_words", RMAP_U64, 2, digest, err));
    if (digest[0] != content->digest.low || digest[1] != content->digest.high)
        st = rmap_error_set(err, RMAP_FORMAT, "%s: its digest is not that of its portions",
                            h5->path);
out:
    return st;
}

/* One scene per colour space. */
static enum rmap_status read_scenes(struct rmap_map *map, struct rmap_h5 *h5,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hsize_t n = 0;
    void *blob = NULL;
    RMAP_TRY(rmap_h5_read(h5, "/scene/bundle", RMAP_U8, 1, &n, &blob, err));
    RMAP_TRY(rmap_bundle_unpack(blob, (size_t)n, &map->bundle, err));
    map->scene = rmap_alloc(map->spaces.n, sizeof *map->scene);
    map->model = rmap_alloc(map->spaces.n, sizeof *map->model);
    if (!map->scene || !map->model) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's scenes");
        goto out;
    }
    for (size_t i = 0; i < map->spaces.n; i++) {
        const struct rmap_map_space *space = &map->spaces.space[i];
        RMAP_TRY(
            rmap_map_space_scene(space, map->bundle, map->scene[0], h5->path, &map->scene[i], err));
        RMAP_TRY(rmap_scene_numbers_read(h5, map->scene[i], i, err));
        if (space->n_channel > map->n_channel_max)
            map->n_channel_max = space->n_channel;
    }
out:
    rmap_free(blob);
    return st;
}

enum rmap_status rmap_map_sum_up(struct rmap_map *map, struct rmap_error *err)
{
    const struct rmap_map_content *content = &map->content;
    struct rmap_map_summary *summary = &map->summary;
    rmap_free(map->chunks);
    map->chunks = rmap_alloc(content->n_piece, sizeof *map->chunks);
    if (!map->paths)
        map->paths = rmap_alloc(content->n_piece, sizeof *map->paths);
    if (!map->chunks || !map->paths)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's tables");
    summary->nbytes = map->index_nbytes;
    summary->n_shard = 0;
    for (size_t i = 0; i < content->n_piece; i++) {
        const struct rmap_piece_info *piece = &content->piece[i];
        summary->nbytes += piece->nbytes;
        summary->n_shard += i == 0 || piece->shard != piece[-1].shard;
    }
    memcpy(summary->n_row, content->n_row, sizeof content->n_row);
    summary->digest = content->digest;
    return RMAP_OK;
}

/* bare: without content and sums. */
static enum rmap_status read_index(struct rmap_map *map, struct rmap_h5 *h5, bool bare,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_provenance_check(h5, RMAP_FILETYPE_MAP, err));
    RMAP_TRY(read_summary(map, h5, err));
    RMAP_TRY(rmap_map_spaces_read(h5, &map->spaces, err));
    if (map->spaces.n == 0) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s: /space is empty", h5->path);
        goto out;
    }
    RMAP_TRY(read_runs(map, h5, err));
    if (!bare)
        RMAP_TRY(read_content(map, h5, err));
    RMAP_TRY(read_scenes(map, h5, err));
    RMAP_TRY(rmap_selection_read(h5, map->scene[0]->n_source, &map->selection, err));
    RMAP_TRY(bare ? rmap_tally_create(map->scene[0], &map->tally, err)
                  : rmap_map_tally_read(h5, map->scene[0], &map->tally, err));
out:
    return st;
}

void rmap_map_derive_flux(struct rmap_map *map)
{
    const struct rmap_scene *scene = map->scene[0];
    const double *emitted = rmap_map_emitted(map);
    for (size_t s = 0; s < scene->n_source; s++)
        map->flux_per_weight[s] =
            emitted[s] > 0.0 ? scene->source[s].flux * rmap_map_dimmed(map, s) / emitted[s] : 0.0;
}

/* How much of a map is opened. */
enum scope {
    SCOPE_BARE,   /* scene, spaces, runs */
    SCOPE_LISTED, /* and what the index lists */
    SCOPE_FOUND   /* and, if it is incomplete, what stands beside it */
};

static enum rmap_status open_index(const char *path, const char *name, enum scope scope,
                                   const struct rmap_map_listing *found, struct rmap_map **map_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_map *map = rmap_alloc(1, sizeof *map);
    char *index = rmap_path_format("%s/%s", path, name);
    if (map) {
        (void)pthread_mutex_init(&map->lock, NULL);
        (void)pthread_mutex_init(&map->paths_lock, NULL);
        (void)pthread_mutex_init(&map->hdf5_lock, NULL);
        map->paths_budget = RMAP_PATHS_NBYTES;
    }
    if (map)
        map->path = rmap_strdup(path);
    if (!map || !index || !map->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map");
        goto out;
    }
    RMAP_TRY(open_file(path, index, &h5, map, err));
    RMAP_TRY(read_index(map, &h5, scope == SCOPE_BARE, err));
    if (scope == SCOPE_FOUND && !map->summary.complete)
        RMAP_TRY(rmap_map_add_found(map, found, err));
    map->flux_per_weight = rmap_alloc(map->scene[0]->n_source, sizeof *map->flux_per_weight);
    if (!map->flux_per_weight) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's tables");
        goto out;
    }
    rmap_map_derive_flux(map);
    RMAP_TRY(rmap_map_sum_up(map, err));
    RMAP_TRY(rmap_map_offer_named_rays(map, err));
    *map_ret = map;
    map = NULL;
out:
    rmap_h5_drop(&h5);
    rmap_free(index);
    rmap_map_close(map);
    return st;
}

enum rmap_status rmap_map_open_untallied(const char *path, struct rmap_map **map_ret,
                                         struct rmap_error *err)
{
    return open_index(path, "map.h5", SCOPE_FOUND, NULL, map_ret, err);
}

enum rmap_status rmap_map_open_found(const char *path, const struct rmap_map_listing *found,
                                     struct rmap_map **map_ret, struct rmap_error *err)
{
    return open_index(path, "map.h5", SCOPE_FOUND, found, map_ret, err);
}

enum rmap_status rmap_map_open_bare(const char *path, const char *name, struct rmap_map **map_ret,
                                    struct rmap_error *err)
{
    return open_index(path, name, SCOPE_BARE, NULL, map_ret, err);
}

enum rmap_status rmap_map_open_listed(const char *path, struct rmap_map **map_ret,
                                      struct rmap_error *err)
{
    return open_index(path, "map.h5", SCOPE_LISTED, NULL, map_ret, err);
}

void rmap_map_forget(struct rmap_map *map)
{
    rmap_column_files_destroy(map->column_files);
    map->column_files = NULL;
    for (size_t i = 0; map->paths && i < map->content.n_piece; i++) {
        rmap_kept_paths_fini(&map->paths[i]);
    }
    rmap_free(map->paths);
    map->paths = NULL;
    map->paths_nbytes = 0;
}

struct rmap_map *rmap_map_lend(struct rmap_map *map)
{
    map->n_lent++;
    return map;
}

void rmap_map_close(struct rmap_map *map)
{
    if (!map || map->n_lent > 0) {
        if (map && --map->n_lent == 0)
            rmap_map_undim(map);
        return;
    }
    (void)pthread_mutex_destroy(&map->lock);
    for (size_t i = 0; map->held && i < map->content.n_portion; i++)
        rmap_portion_destroy(map->held[i]);
    rmap_free(map->held);
    rmap_free(map->held_elsewhere);
    rmap_tally_destroy(map->tally);
    rmap_selection_destroy(map->selection);
    rmap_column_store_destroy(map->store);
    rmap_map_forget(map);
    rmap_kept_rays_destroy(map->kept_rays);
    (void)pthread_mutex_destroy(&map->paths_lock);
    (void)pthread_mutex_destroy(&map->hdf5_lock);
    for (size_t i = 0; map->model && i < map->spaces.n; i++)
        rmap_compact_model_destroy(map->model[i]);
    rmap_free(map->model);
    for (size_t i = 0; map->scene && i < map->spaces.n; i++)
        rmap_scene_destroy(map->scene[i]);
    rmap_free(map->scene);
    rmap_map_spaces_fini(&map->spaces);
    for (size_t i = 0; i < map->n_trouble; i++)
        rmap_free(map->trouble[i]);
    rmap_free(map->trouble);
    rmap_free(map->run);
    rmap_bundle_destroy(map->bundle);
    rmap_map_content_fini(&map->content);
    rmap_free(map->flux_per_weight);
    rmap_free(map->dim);
    rmap_free(map->chunks);
    rmap_free(map->path);
    rmap_free(map);
}
