/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/map_format.h"
#include "io/map_internal.h"
#include "io/map_tally.h"
#include "io/provenance.h"
#include "io/publish.h"

/* RMAP_INPUT, RMAP_FORMAT or RMAP_SYSTEM with a remedy before HDF5 sees anything. */
static enum rmap_status check_path(const char *path, const char *index, struct rmap_map *map,
                                   struct rmap_error *err)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return rmap_error_set(err, errno == EACCES ? RMAP_SYSTEM : RMAP_INPUT,
                              "%s: cannot open the ray map: %s", path, strerror(errno));
    if (!S_ISDIR(info.st_mode))
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s is a file, but a ray map is a directory (NAME.raymap)", path);
    if (stat(index, &info) != 0 && errno == ENOENT)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s has no map.h5: it is no ray map, or its trace never finished",
                              path);
    if (access(index, R_OK) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be read: %s", index, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return rmap_error_set(err, RMAP_FORMAT, "%s is not a regular file", index);
    map->summary.nbytes = (uint64_t)info.st_size;
    return RMAP_OK;
}

static enum rmap_status read_summary(struct rmap_map *map, struct rmap_h5 *h5,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary *s = &map->summary;
    int32_t ranks = 0, complete = 0;
    RMAP_TRY(rmap_h5_get(h5, "/", "seed", RMAP_U64, 1, &s->seed, err));
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

static enum rmap_status read_content(struct rmap_map *map, struct rmap_h5 *h5,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content *content = &map->content;
    struct rmap_field_table pieces = rmap_piece_fields(), portions = rmap_portion_fields_index(),
                            chunks = rmap_chunk_fields();
    uint64_t digest[2];
    void *piece = NULL, *portion = NULL, *chunk = NULL;
    RMAP_TRY(rmap_h5_read_fields(h5, pieces.field, pieces.n, sizeof *content->piece, &piece,
                                 &content->n_piece, err));
    content->piece = piece;
    RMAP_TRY(rmap_h5_read_fields(h5, portions.field, portions.n, sizeof *content->portion, &portion,
                                 &content->n_portion, err));
    content->portion = portion;
    RMAP_TRY(rmap_h5_read_fields(h5, chunks.field, chunks.n, sizeof *content->chunk, &chunk,
                                 &content->n_chunk, err));
    content->chunk = chunk;
    for (size_t i = 0; i < content->n_piece; i++) {
        struct rmap_piece_info *info = &content->piece[i];
        if (info->shard < 0 || info->shard > 99999 || info->number < 0 || info->number > 99999) {
            st = rmap_error_set(err, RMAP_FORMAT, "%s: /piece names no piece", h5->path);
            goto out;
        }
        rmap_piece_name_set(info);
        map->summary.nbytes += info->nbytes;
        map->summary.n_shard += i == 0 || info->shard != info[-1].shard;
    }
    RMAP_TRY(rmap_map_content_check(content, h5->path, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "digest_words", RMAP_U64, 2, digest, err));
    if (digest[0] != content->digest.low || digest[1] != content->digest.high)
        st = rmap_error_set(err, RMAP_FORMAT, "%s: its digest is not that of its portions",
                            h5->path);
    memcpy(map->summary.n_row, content->n_row, sizeof content->n_row);
    map->summary.digest = content->digest;
out:
    return st;
}

static enum rmap_status read_scene(struct rmap_map *map, struct rmap_h5 *h5, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics diagnostics;
    hsize_t n = 0;
    void *blob = NULL;
    rmap_diagnostics_init(&diagnostics, h5->path);
    RMAP_TRY(rmap_h5_read(h5, "/scene/bundle", RMAP_U8, 1, &n, &blob, err));
    RMAP_TRY(rmap_bundle_unpack(blob, (size_t)n, &map->bundle, err));
    st = rmap_scene_read(map->bundle, &map->scene, &diagnostics, err);
    if (st != RMAP_OK && st != RMAP_SYSTEM)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s: the scene inside cannot be read (%s%s%zu mistakes); a program of "
                            "the version that wrote the map can",
                            h5->path, diagnostics.n ? diagnostics.item[0].text : "",
                            diagnostics.n ? "; " : "", diagnostics.n_error);
out:
    rmap_diagnostics_fini(&diagnostics);
    rmap_free(blob);
    return st;
}

/* What is derived: fluxes per weight, the running sum of work, room for chunk tables. */
static enum rmap_status derive(struct rmap_map *map, struct rmap_error *err)
{
    const struct rmap_map_content *content = &map->content;
    map->n_channel_max = map->scene->channels.n;
    map->flux_per_weight = rmap_alloc(map->scene->n_source, sizeof *map->flux_per_weight);
    map->work = rmap_alloc(content->n_portion + 1, sizeof *map->work);
    map->chunks = rmap_alloc(content->n_piece, sizeof *map->chunks);
    if (!map->flux_per_weight || !map->work || !map->chunks)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's tables");
    for (size_t s = 0; s < map->scene->n_source; s++)
        if (map->tally->emitted[s] > 0.0)
            map->flux_per_weight[s] = map->scene->source[s].flux / map->tally->emitted[s];
    for (size_t i = 0; i < content->n_portion; i++)
        map->work[i + 1] = map->work[i] + content->portion[i].n_row[RMAP_TABLE_RAY] +
                           content->portion[i].n_row[RMAP_TABLE_SEGMENT];
    return RMAP_OK;
}

enum rmap_status rmap_map_open(const char *path, struct rmap_map **map_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_map *map = rmap_alloc(1, sizeof *map);
    char *index = rmap_path_format("%s/map.h5", path);
    if (map)
        (void)pthread_mutex_init(&map->lock, NULL);
    if (map)
        map->path = rmap_strdup(path);
    if (!map || !index || !map->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map");
        goto out;
    }
    RMAP_TRY(check_path(path, index, map, err));
    RMAP_TRY(rmap_h5_open(&h5, index, err));
    RMAP_TRY(rmap_provenance_check(&h5, RMAP_FILETYPE_MAP, err));
    RMAP_TRY(read_summary(map, &h5, err));
    RMAP_TRY(read_content(map, &h5, err));
    RMAP_TRY(read_scene(map, &h5, err));
    RMAP_TRY(rmap_map_tally_read(&h5, map->scene, &map->tally, err));
    RMAP_TRY(derive(map, err));
    *map_ret = map;
    map = NULL;
out:
    rmap_h5_drop(&h5);
    rmap_free(index);
    rmap_map_close(map);
    return st;
}

void rmap_map_close(struct rmap_map *map)
{
    if (!map)
        return;
    (void)pthread_mutex_destroy(&map->lock);
    rmap_tally_destroy(map->tally);
    rmap_scene_destroy(map->scene);
    rmap_bundle_destroy(map->bundle);
    rmap_map_content_fini(&map->content);
    rmap_free(map->flux_per_weight);
    rmap_free(map->work);
    rmap_free(map->chunks);
    rmap_free(map->path);
    rmap_free(map);
}

const struct rmap_scene *rmap_map_scene(const struct rmap_map *map)
{
    return map->scene;
}

const struct rmap_bundle *rmap_map_bundle(const struct rmap_map *map)
{
    return map->bundle;
}

const struct rmap_tally *rmap_map_tally(const struct rmap_map *map)
{
    return map->tally;
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

size_t rmap_map_split(const struct rmap_map *map, size_t n_part, size_t part)
{
    size_t low = 0, high = map->content.n_portion;
    if (part >= n_part)
        return high;
    /* work x part / n_part without overflow; a part's share may be off by n_part. */
    uint64_t total = map->work[high];
    uint64_t want = total / n_part * part + total % n_part * part / n_part;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (map->work[middle] < want)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}
