/* SPDX-License-Identifier: MIT
 *
 * Whether columns that are kept beside pieces are sound, and those that the pieces decode to.
 */
#include "io/recovery/verify_columns.h"

#include <errno.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/piece_columns.h"

static enum rmap_status tell(const struct rmap_piece_info *piece,
                             const struct rmap_portion_info *portion, const char *dataset,
                             const char *text, struct rmap_findings *findings,
                             struct rmap_error *err)
{
    struct rmap_finding finding;
    char *path = rmap_piece_columns_path("", piece); /* "/shard-00000/..." */
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_finding_set(&finding, path + 1, dataset, "%s", text);
    if (portion)
        rmap_finding_add_rays(&finding, portion->first_ray, portion->n_row[RMAP_TABLE_RAY]);
    rmap_free(path);
    return rmap_findings_add(findings, &finding, err);
}

enum rmap_status rmap_verify_columns_file(struct rmap_verification *self, size_t piece,
                                          struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_piece_columns columns;
    struct rmap_error why = {0};
    bool is_stale;
    enum rmap_status st = rmap_piece_columns_read(self->map, piece, &columns, &is_stale, &why);
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    if (st == RMAP_FORMAT)
        return tell(&self->content->piece[piece], NULL, "", why.text, findings, err);
    if (st == RMAP_OK)
        rmap_piece_columns_fini(&columns);
    return RMAP_OK;
}

enum rmap_status rmap_verify_columns(struct rmap_verification *self, struct rmap_cursor *cursor,
                                     size_t portion, struct rmap_findings *findings,
                                     struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const struct rmap_piece_info *piece = &self->content->piece[info->piece];
    struct rmap_error why = {0};
    enum rmap_column differs;
    if (rmap_map_columns_beside(self->map, (size_t)info->piece) == 0)
        return RMAP_OK; /* or its file is a finding already */
    const enum rmap_status st = rmap_cursor_compare_beside(cursor, &differs, &why);
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    if (st == RMAP_FORMAT)
        return tell(piece, NULL, "", why.text, findings, err); /* once, and no ray is lost */
    return differs == RMAP_COLUMN_COUNT
               ? RMAP_OK
               : tell(piece, info, rmap_column_info(differs)->path,
                      "says another thing than its piece: make it again with raymap keep --force",
                      findings, err);
}

static bool is_listed(const struct rmap_piece_name *piece, size_t n, struct rmap_piece_name one)
{
    size_t i = 0;
    while (i < n && (piece[i].shard != one.shard || piece[i].number != one.number))
        i++;
    return i < n;
}

enum rmap_status rmap_verify_stray_columns(struct rmap_verification *self,
                                           const struct rmap_piece_name *piece, size_t n_piece,
                                           struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_map_listing found;
    enum rmap_status st = rmap_map_list(self->path, &found, err);
    for (size_t i = 0; st == RMAP_OK && i < found.columns.n; i++) {
        const struct rmap_piece_name name = found.columns.name[i];
        const struct rmap_piece_info info = {.shard = name.shard, .number = name.number};
        if (!is_listed(piece, n_piece, name))
            st = tell(&info, NULL, "", "the piece that it belongs to is not there", findings, err);
    }
    rmap_map_listing_fini(&found);
    return st;
}

static enum rmap_status take_away(const struct rmap_map *map, const struct rmap_piece_info *info,
                                  const char *why, struct rmap_findings *done,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *path = rmap_piece_columns_path(map->path, info);
    if (!path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    else if (rmap_shard_unlink(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    else
        st = rmap_findings_note(done, path + strlen(map->path) + 1, why, err);
    rmap_free(path);
    return st;
}

/* Every stored chunk must hold, too: who reads it would be told. */
static enum rmap_status read_all(const struct rmap_map *map, size_t piece, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    const struct rmap_portion *rows;
    const rmap_column_set columns = rmap_map_columns_beside(map, piece);
    RMAP_TRY(rmap_cursor_create(map, columns, &cursor, err));
    for (size_t i = 0; i < map->content.n_portion; i++)
        if ((size_t)map->content.portion[i].piece == piece)
            RMAP_TRY(rmap_cursor_read(cursor, i, &rows, err));
out:
    rmap_cursor_destroy(cursor);
    return st;
}

static enum rmap_status check_one(const struct rmap_map *map, size_t piece,
                                  struct rmap_findings *done, struct rmap_error *err)
{
    struct rmap_piece_columns columns;
    struct rmap_error why = {0};
    bool is_stale = false;
    enum rmap_status st = rmap_piece_columns_read(map, piece, &columns, &is_stale, &why);
    if (st == RMAP_OK) {
        rmap_piece_columns_fini(&columns);
        st = read_all(map, piece, &why);
    }
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    return st == RMAP_FORMAT
               ? take_away(map, &map->content.piece[piece],
                           is_stale ? "removed: it was of other rays"
                                    : "removed: it was damaged; raymap keep makes it again",
                           done, err)
               : RMAP_OK;
}

enum rmap_status rmap_remove_bad_columns(const struct rmap_map *map, struct rmap_findings *done,
                                         struct rmap_error *err)
{
    struct rmap_map_listing found;
    enum rmap_status st = rmap_map_list(map->path, &found, err);
    for (size_t k = 0; st == RMAP_OK && k < found.columns.n; k++) {
        const struct rmap_piece_name name = found.columns.name[k];
        const struct rmap_piece_info stray = {.shard = name.shard, .number = name.number};
        size_t i = 0;
        while (i < map->content.n_piece && (map->content.piece[i].shard != name.shard ||
                                            map->content.piece[i].number != name.number))
            i++;
        st = i == map->content.n_piece
                 ? take_away(map, &stray, "removed: its piece is gone", done, err)
                 : check_one(map, i, done, err);
    }
    rmap_map_listing_fini(&found);
    return st;
}
