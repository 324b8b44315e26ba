/* SPDX-License-Identifier: MIT
 *
 * The view of all pieces as one: each of its datasets names every piece, in order, all rows.
 */
#include <string.h>

#include "io/map/map_internal.h"
#include "io/recovery/verify_internal.h"

/* The datasets' sources, one after the other. */
struct source {
    const struct rmap_verification *self;
    const struct rmap_stream_info *stream;
    size_t piece; /* next to be named */
    hsize_t at;   /* next row */
};

static enum rmap_status tell(const struct source *source, const char *piece, const char *text,
                             struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, "map.h5", source->stream->path, "%s%s", text, piece);
    return rmap_findings_add(findings, &finding, err);
}

/* Moves on to the next piece that has rows; false when there is none. */
static bool next_piece(struct source *source)
{
    const struct rmap_map_content *content = source->self->content;
    while (source->piece < content->n_piece &&
           content->piece[source->piece].n_row[source->stream->table] == 0)
        source->piece++;
    return source->piece < content->n_piece;
}

/* Whether mapping i is that of the next piece. */
static bool fits(struct source *source, hid_t create, size_t i)
{
    const struct rmap_piece_info *piece = &source->self->content->piece[source->piece];
    hsize_t rows = piece->n_row[source->stream->table];
    hsize_t first[2] = {0}, last[2] = {0};
    char name[sizeof piece->name] = "", set[128] = "";
    hid_t space = H5Pget_virtual_vspace(create, i);
    bool good = H5Pget_virtual_filename(create, i, name, sizeof name) > 0 &&
                H5Pget_virtual_dsetname(create, i, set, sizeof set) > 0 && space >= 0 &&
                H5Sget_simple_extent_ndims(space) <= 2 &&
                H5Sget_select_bounds(space, first, last) >= 0 && strcmp(name, piece->name) == 0 &&
                strcmp(set, source->stream->path) == 0 && first[0] == source->at &&
                last[0] + 1 == source->at + rows;
    if (space >= 0)
        (void)H5Sclose(space);
    source->at += rows;
    return good;
}

static enum rmap_status check_set(struct source *source, hid_t create,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    size_t n = 0;
    if (H5Pget_layout(create) != H5D_VIRTUAL)
        return next_piece(source) ? tell(source, "", "the view lacks this column", findings, err)
                                  : RMAP_OK;
    if (H5Pget_virtual_count(create, &n) < 0)
        return tell(source, "", "the view's list of pieces cannot be read", findings, err);
    for (size_t i = 0; i < n; i++) {
        if (!next_piece(source))
            return tell(source, "", "the view names more pieces than there are", findings, err);
        const char *name = source->self->content->piece[source->piece].name;
        if (!fits(source, create, i))
            return tell(source, name, "the view does not show, in its place, ", findings, err);
        source->piece++;
    }
    if (next_piece(source))
        return tell(source, source->self->content->piece[source->piece].name,
                    "the view does not show ", findings, err);
    return RMAP_OK;
}

/* The view is made of plain pieces of one colour space. */
static bool has_view(const struct rmap_map_content *content)
{
    bool has = content->n_piece > 0 && content->n_piece <= RMAP_VIEW_PIECES_MAX;
    for (size_t i = 0; i < content->n_piece; i++)
        has = has && content->piece[i].encoding == RMAP_ENCODING_PLAIN &&
              content->piece[i].space == content->piece[0].space;
    return has;
}

enum rmap_status rmap_verify_view(struct rmap_verification *self, struct rmap_h5 *h5,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!has_view(self->content))
        return RMAP_OK;
    const struct rmap_layout *layout = rmap_map_piece_layout(self->map, 0);
    int n_stream = rmap_layout_n_stream(layout, rmap_scene_is_curved(self->map->scene[0]));
    for (int s = 0; s < n_stream && st == RMAP_OK; s++) {
        struct source source = {.self = self, .stream = &layout->stream[s]};
        hid_t set = rmap_h5_has(h5, source.stream->path)
                        ? H5Dopen2(h5->file, source.stream->path, H5P_DEFAULT)
                        : H5I_INVALID_HID;
        hid_t create = set >= 0 ? H5Dget_create_plist(set) : H5I_INVALID_HID;
        st = create >= 0 ? check_set(&source, create, findings, err)
                         : tell(&source, "", "the view lacks this column", findings, err);
        if (create >= 0)
            (void)H5Pclose(create);
        if (set >= 0)
            (void)H5Dclose(set);
    }
    return st;
}
