/* SPDX-License-Identifier: MIT
 *
 * What decoding a compact piece takes beside its portions' rows: the model of its colour space's
 * scene, and the paths that its rays refer to.
 */
#include "io/map/map_paths.h"

#include "base/alloc.h"
#include "compact/model.h"
#include "compact/paths.h"
#include "compact/streams.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_chunks.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/scene/scene_limits.h"

/* What is kept is a cache inside an otherwise constant map. */
static struct rmap_map *inside(const struct rmap_map *map)
{
    return (struct rmap_map *)(uintptr_t)map;
}

enum rmap_status rmap_map_model(const struct rmap_map *map, size_t space, bool traces,
                                const struct rmap_compact_model **model_ret, struct rmap_error *err)
{
    struct rmap_map *self = inside(map);
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(&self->lock);
    if (!self->model[space])
        st = rmap_compact_model_begin(self->scene[space], &self->model[space], err);
    if (st == RMAP_OK && traces)
        st = rmap_compact_model_complete(self->model[space], err);
    (void)pthread_mutex_unlock(&self->lock);
    *model_ret = self->model[space];
    return st;
}

static enum rmap_status read_tables(const struct rmap_map *map, size_t piece, uint32_t tables,
                                    struct rmap_chunk_reader *reader, struct rmap_rows *rows,
                                    struct rmap_error *err)
{
    const struct rmap_piece_info *info = &map->content.piece[piece];
    for (int s = 0; s < rows->layout->n_stream; s++) {
        const struct rmap_stream_info *stream = &rows->layout->stream[s];
        if (!(rows->layout->whole_tables & (UINT32_C(1) << stream->table)))
            continue;
        uint64_t n = info->stored_rows[stream->table];
        if (n > RMAP_PATH_ROW_MAX)
            return rmap_error_set(err, RMAP_FORMAT, "%s: %s has %llu rows, more than any piece has",
                                  info->name, stream->path, (unsigned long long)n);
        rows->n_row[stream->table] = (size_t)n;
        if (!(tables & (UINT32_C(1) << stream->table)))
            continue;
        rows->data[s] =
            rmap_alloc_unset((size_t)n, rmap_stream_row_nbytes(stream, rows->n_channel));
        if (!rows->data[s])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a piece");
        enum rmap_status st =
            rmap_chunk_reader_rows(reader, piece, s, 0, (size_t)n, rows->data[s], err);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

static bool is_in_scene(const struct rmap_scene *scene, const struct rmap_path_table *table)
{
    const struct rmap_portion *rays = rmap_path_table_rays(table);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c) &&
            rmap_portion_column(rays, (enum rmap_column)c) &&
            !rmap_portion_within(scene, rays, (enum rmap_column)c))
            return false;
    return true;
}

static enum rmap_status load(struct rmap_map *map, size_t piece, bool whole,
                             struct rmap_chunk_reader *reader, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_info *info = &map->content.piece[piece];
    struct rmap_kept_paths *kept = &map->paths[piece];
    const struct rmap_compact_model *model;
    const struct rmap_piece_chunks *chunks;
    const uint32_t heads = UINT32_C(1) << RMAP_COMPACT_PATH;
    struct rmap_rows rows = {.layout = rmap_map_piece_layout(map, piece),
                             .n_channel = rmap_map_piece_n_channel(map, piece)};
    RMAP_TRY(rmap_map_model(map, (size_t)info->space, false, &model, err));
    /* The piece's chunks vouch for its rows before memory is taken for them. */
    RMAP_TRY(rmap_map_piece_chunks(map, piece, &chunks, err));
    const uint64_t before = rmap_chunk_reader_nbytes_of_rows(reader);
    RMAP_TRY(read_tables(map, piece, heads, reader, &rows, err));
    kept->stored_nbytes[false] = rmap_chunk_reader_nbytes_of_rows(reader) - before;
    if (whole)
        RMAP_TRY(read_tables(map, piece, ~heads, reader, &rows, err));
    kept->stored_nbytes[whole] = rmap_chunk_reader_nbytes_of_rows(reader) - before;
    rmap_chunk_reader_set_nbytes_of_rows(reader, before);
    st = rmap_path_table_create(model, &rows, &kept->table[whole], err);
    if (st == RMAP_OK)
        kept->names_nothing |= !is_in_scene(map->scene[0], kept->table[whole]);
    else
        rmap_error_context(err, "%s", info->name);
out:
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_free(rows.data[s]);
    return st;
}

void rmap_kept_paths_fini(struct rmap_kept_paths *kept)
{
    for (int k = 0; k < 2; k++) {
        rmap_path_table_destroy(kept->table[k]);
        rmap_free(kept->sum[k]);
    }
    *kept = (struct rmap_kept_paths){0};
}

/* Lets tables go that nobody has, until all take no more than the budget or none is left. */
static void shrink(struct rmap_map *map)
{
    while (map->paths_nbytes > map->paths_budget) {
        struct rmap_kept_paths *oldest = NULL;
        for (size_t i = 0; i < map->content.n_piece; i++) {
            struct rmap_kept_paths *kept = &map->paths[i];
            if (kept->nbytes > 0 && kept->n_user == 0 && (!oldest || kept->tick < oldest->tick))
                oldest = kept;
        }
        if (!oldest)
            return;
        map->paths_nbytes -= oldest->nbytes;
        rmap_kept_paths_fini(oldest);
    }
}

enum rmap_status rmap_map_paths(const struct rmap_map *map, size_t piece, bool whole,
                                struct rmap_chunk_reader *reader,
                                const struct rmap_path_table **paths_ret, struct rmap_error *err)
{
    struct rmap_map *self = inside(map);
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(&self->paths_lock);
    struct rmap_kept_paths *kept = &self->paths[piece];
    whole |= kept->table[true] != NULL;
    if (!kept->table[whole]) {
        st = load(self, piece, whole, reader, err);
        const size_t nbytes = st == RMAP_OK ? rmap_path_table_nbytes(kept->table[whole]) : 0;
        kept->nbytes += nbytes;
        self->paths_nbytes += nbytes;
    }
    *paths_ret = st == RMAP_OK ? kept->table[whole] : NULL;
    kept->n_user += st == RMAP_OK;
    kept->tick = ++self->paths_tick;
    shrink(self);
    (void)pthread_mutex_unlock(&self->paths_lock);
    return st;
}

/* A piece that is still being written says nothing yet. */
static enum rmap_status read_sums(const struct rmap_map *map, size_t piece, bool lengths,
                                  struct rmap_path_sum **sum_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_field_table fields = rmap_path_sum_fields();
    const struct rmap_piece_info *info = &map->content.piece[piece];
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    void *rows = NULL;
    size_t n = 0;
    if (info->is_open || info->stored_rows[RMAP_COMPACT_PATH] == 0)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", map->path, info->name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    if (!rmap_h5_has(&h5, fields.field->path))
        goto out;
    RMAP_TRY(rmap_h5_read_fields(&h5, fields.field, lengths ? fields.n : 1, sizeof **sum_ret, &rows,
                                 &n, err));
    if (n != info->stored_rows[RMAP_COMPACT_PATH])
        RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: %s has not as many rows as there are paths",
                                path, fields.field->path));
    *sum_ret = rows;
    rows = NULL;
out:
    rmap_h5_drop(&h5);
    rmap_free(rows);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_path_sums(const struct rmap_map *map, size_t piece, bool lengths,
                                    const struct rmap_path_sum **sum_ret, struct rmap_error *err)
{
    struct rmap_map *self = inside(map);
    struct rmap_kept_paths *kept = &self->paths[piece];
    enum rmap_status st = RMAP_OK;
    struct rmap_error why = {0};
    (void)pthread_mutex_lock(&self->paths_lock);
    if (!kept->knows_sums[lengths]) {
        (void)pthread_mutex_lock(&self->hdf5_lock);
        st = read_sums(map, piece, lengths, &kept->sum[lengths], &why);
        (void)pthread_mutex_unlock(&self->hdf5_lock);
        if (st == RMAP_FORMAT) /* its rays are whole, for all that is known: verify tells */
            st = RMAP_OK;
        else if (st != RMAP_OK && err)
            *err = why;
        kept->knows_sums[lengths] = st == RMAP_OK;
        const size_t n = kept->sum[lengths]
                             ? (size_t)map->content.piece[piece].stored_rows[RMAP_COMPACT_PATH]
                             : 0;
        kept->nbytes += n * sizeof **kept->sum;
        self->paths_nbytes += n * sizeof **kept->sum;
    }
    *sum_ret = kept->sum[lengths];
    (void)pthread_mutex_unlock(&self->paths_lock);
    return st;
}

uint64_t rmap_map_paths_stored_nbytes(const struct rmap_map *map, size_t piece, bool whole)
{
    return map->paths[piece].stored_nbytes[whole];
}

bool rmap_map_paths_fit(const struct rmap_map *map, size_t piece)
{
    return !map->paths[piece].names_nothing;
}

void rmap_map_paths_give_back(const struct rmap_map *map, size_t piece,
                              const struct rmap_path_table *paths)
{
    struct rmap_map *self = inside(map);
    if (!paths)
        return;
    (void)pthread_mutex_lock(&self->paths_lock);
    self->paths[piece].n_user--;
    shrink(self);
    (void)pthread_mutex_unlock(&self->paths_lock);
}
