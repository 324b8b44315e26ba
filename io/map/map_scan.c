/* SPDX-License-Identifier: MIT
 *
 * What the published pieces of a map hold, read from the pieces themselves.
 */
#include "io/map/map_scan.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/portion_rows.h"
#include "io/map/provenance.h"

static enum rmap_status read_origin(struct rmap_h5 *h5, struct rmap_piece_origin *origin,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t complete = 0;
    char encoding[16], mode[16];
    RMAP_TRY(rmap_provenance_check(h5, RMAP_FILETYPE_PIECE, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "complete", RMAP_I32, 1, &complete, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "seed", RMAP_U64, 1, &origin->seed, err));
    RMAP_TRY(rmap_tracer_revision_read(h5, &origin->tracer_revision, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "channels", RMAP_I32, 1, &origin->n_channel, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "scene_digest", origin->scene_digest,
                              sizeof origin->scene_digest, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "space_digest", origin->space_digest,
                              sizeof origin->space_digest, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "encoding", encoding, sizeof encoding, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "colour_space", mode, sizeof mode, err));
    origin->mode = strcmp(mode, "rgb") == 0 ? RMAP_COLOUR_RGB : RMAP_COLOUR_SPECTRAL;
    origin->encoding = -1;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++)
        if (strcmp(encoding, rmap_encoding_name((enum rmap_encoding)e)) == 0)
            origin->encoding = e;
    if (complete != 1)
        st = rmap_error_set(err, RMAP_FORMAT, "%s was never finished: remove it", h5->path);
    else if (origin->encoding < 0)
        st = rmap_error_set(err, RMAP_FORMAT, "%s has an unknown encoding, '%s'", h5->path,
                            encoding);
out:
    return st;
}

/* Our number of each dataset that the piece numbers, or -1. */
static enum rmap_status read_numbering(struct rmap_h5 *h5, const struct rmap_layout *layout,
                                       int **stream_ret, size_t *n_ret, struct rmap_error *err)
{
    char *name = NULL;
    size_t width = 0;
    enum rmap_status st = rmap_h5_read_names(h5, "/chunk/name", &name, n_ret, &width, err);
    if (st != RMAP_OK)
        return st;
    int *stream = rmap_alloc(*n_ret, sizeof *stream);
    for (size_t i = 0; stream && i < *n_ret; i++) {
        stream[i] = -1;
        for (int s = 0; s < layout->n_stream; s++)
            if (strcmp(name + i * width, layout->stream[s].path) == 0)
                stream[i] = s;
    }
    rmap_free(name);
    *stream_ret = stream;
    return stream ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for dataset names");
}

/* Drops entries of unknown datasets and numbers the others our way. */
static size_t renumber(struct rmap_chunk_entry *entry, size_t n, const int *stream, size_t n_stream)
{
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        if (entry[i].stream >= n_stream || stream[entry[i].stream] < 0)
            continue;
        entry[kept] = entry[i];
        entry[kept++].stream = (uint16_t)stream[entry[i].stream];
    }
    return kept;
}

static enum rmap_status read_tables(struct rmap_h5 *h5, const struct rmap_layout *layout,
                                    struct rmap_piece_info *info, struct rmap_map_content *content,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool curved = rmap_provenance_is_curved(h5);
    struct rmap_field_table portions = rmap_portion_fields_piece(curved),
                            chunks = rmap_chunk_fields();
    struct rmap_portion_info *portion = NULL;
    void *chunk = NULL;
    int *stream = NULL;
    size_t n_portion = 0, n_chunk = 0, n_stream = 0;
    RMAP_TRY(rmap_h5_get(h5, "/", "stored_rows", RMAP_U64, rmap_format_n_table(curved),
                         info->stored_rows, err));
    RMAP_TRY(read_numbering(h5, layout, &stream, &n_stream, err));
    RMAP_TRY(rmap_h5_read_fields(h5, chunks.field, chunks.n, sizeof(struct rmap_chunk_entry),
                                 &chunk, &n_chunk, err));
    RMAP_TRY(rmap_portion_rows_read(h5, portions, &portion, &n_portion, err));
    info->n_chunk = renumber(chunk, n_chunk, stream, n_stream);
    RMAP_TRY(rmap_map_content_add_piece(content, info, portion, n_portion, chunk, err));
out:
    rmap_free(portion);
    rmap_free(chunk);
    rmap_free(stream);
    return st;
}

enum rmap_status rmap_piece_read(const char *map_path, int shard, int number,
                                 struct rmap_map_content *content, struct rmap_piece_origin *origin,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_piece_info info = {.shard = shard, .number = number};
    const struct rmap_layout *layout;
    struct stat file;
    rmap_piece_name_set(&info);
    char *path = rmap_path_format("%s/%s", map_path, info.name);
    if (!path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    if (stat(path, &file) != 0) {
        st = rmap_error_set(err, errno == ENOENT ? RMAP_FORMAT : RMAP_SYSTEM, "%s: %s", path,
                            strerror(errno));
        goto out;
    }
    info.nbytes = (uint64_t)file.st_size;
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(read_origin(&h5, origin, err));
    info.encoding = origin->encoding;
    layout =
        rmap_layout_of((enum rmap_encoding)origin->encoding, (enum rmap_colour_mode)origin->mode);
    if (!layout) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s: this program does not read its encoding", path);
        goto out;
    }
    RMAP_TRY(read_tables(&h5, layout, &info, content, err));
out:
    rmap_h5_drop(&h5);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_piece_place(struct rmap_map_content *content,
                                  const struct rmap_piece_origin *origin, uint64_t seed,
                                  int32_t tracer_revision, const char *scene_digest,
                                  const struct rmap_map_spaces *spaces, struct rmap_error *err)
{
    struct rmap_piece_info *piece = &content->piece[content->n_piece - 1];
    int32_t space = rmap_map_spaces_find(spaces, origin->space_digest);
    if (origin->seed != seed || strcmp(origin->scene_digest, scene_digest) != 0)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s belongs to another scene or seed than this map: move it away",
                              piece->name);
    if (origin->tracer_revision && origin->tracer_revision != tracer_revision)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s has rays of tracer revision %d, the map of %d: move it away",
                              piece->name, (int)origin->tracer_revision, (int)tracer_revision);
    if (space < 0 || spaces->space[space].n_channel != origin->n_channel ||
        spaces->space[space].mode != origin->mode)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s is in a colour space that this map's index does not know",
                              piece->name);
    piece->space = space;
    for (size_t i = content->n_portion; i > 0; i--) {
        if (content->portion[i - 1].piece != (int32_t)content->n_piece - 1)
            break;
        content->portion[i - 1].space = space;
    }
    return RMAP_OK;
}

enum rmap_status rmap_map_scan(const char *map_path, uint64_t seed, int32_t tracer_revision,
                               const char *scene_digest, const struct rmap_map_spaces *spaces,
                               struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    struct rmap_piece_origin origin;
    size_t n = 0, n_dropped = 0;
    *content = (struct rmap_map_content){0};
    RMAP_TRY(rmap_map_list_pieces(map_path, &name, &n, err));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(rmap_piece_read(map_path, name[i].shard, name[i].number, content, &origin, err));
        RMAP_TRY(
            rmap_piece_place(content, &origin, seed, tracer_revision, scene_digest, spaces, err));
    }
    RMAP_TRY(rmap_map_content_sort(content, err));
    rmap_map_content_drop_covered(content, &n_dropped);
    RMAP_TRY(rmap_map_content_check(content, map_path, err));
out:
    rmap_free(name);
    if (st != RMAP_OK)
        rmap_map_content_fini(content);
    return st;
}
