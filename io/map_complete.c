/* SPDX-License-Identifier: MIT
 *
 * The tally of an incomplete map: that of its index, and of what stands beside it.
 */
#include <errno.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/map_internal.h"
#include "trace/tally.h"

/* Reads an added portion into the tally. */
static enum rmap_status tally_portion(struct rmap_map *map, struct rmap_cursor *cursor,
                                      size_t portion, struct rmap_error *err)
{
    const struct rmap_portion *rows = NULL;
    enum rmap_status st = rmap_cursor_read(cursor, portion, &rows, err);
    return st == RMAP_OK ? rmap_tally_add_portion(map->tally, rows, err) : st;
}

/* Adds the added portions to the tally. bad[i] says of one that it cannot be read: it is left out,
 * as if its writer had died a little earlier. */
static enum rmap_status tally_portions(struct rmap_map *map, bool *bad, size_t *n_bad,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    int32_t told = -1;
    RMAP_TRY(rmap_cursor_create(map, RMAP_TALLY_COLUMNS, &cursor, err));
    for (size_t i = 0; i < map->content.n_portion; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        struct rmap_error why = {0};
        st = info->is_added ? tally_portion(map, cursor, i, &why) : RMAP_OK;
        if (st == RMAP_SYSTEM && err)
            *err = why;
        if (st == RMAP_SYSTEM)
            goto out;
        bad[i] = st != RMAP_OK;
        *n_bad += bad[i];
        if (bad[i] && info->piece != told)
            RMAP_TRY(rmap_map_note_trouble(map, why.text, err));
        if (bad[i])
            told = info->piece;
        st = RMAP_OK;
    }
out:
    rmap_cursor_destroy(cursor);
    return st;
}

static enum rmap_status complete_tally(struct rmap_map *map, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content *content = &map->content;
    size_t n_bad = 0, n = 0, n_dropped;
    bool *bad = rmap_alloc(content->n_portion, sizeof *bad);
    if (!bad) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's tables");
        goto out;
    }
    RMAP_TRY(tally_portions(map, bad, &n_bad, err));
    rmap_map_derive_flux(map);
    if (n_bad == 0)
        goto out;
    for (size_t i = 0; i < content->n_portion; i++)
        if (!bad[i])
            content->portion[n++] = content->portion[i];
    content->n_portion = n;
    rmap_map_content_drop_covered(content, &n_dropped); /* recounts rows of pieces */
    RMAP_TRY(rmap_map_content_check(content, map->path, err));
    RMAP_TRY(rmap_map_sum_up(map, err));
out:
    rmap_free(bad);
    return st;
}

/* Whether a piece that was open when the map was is finished by now: it has another name. */
static bool has_moved_on(const struct rmap_map *map)
{
    bool moved = false;
    for (size_t i = 0; i < map->content.n_piece && !moved; i++) {
        char *path = map->content.piece[i].is_open ? rmap_map_piece_path(map, i) : NULL;
        moved = path && access(path, F_OK) != 0 && errno == ENOENT;
        rmap_free(path);
    }
    return moved;
}

static enum rmap_status open_once(const char *path, struct rmap_map **map_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = rmap_map_open_untallied(path, map_ret, err);
    if (st == RMAP_OK && !(*map_ret)->summary.complete)
        st = complete_tally(*map_ret, err);
    return st;
}

enum rmap_status rmap_map_open(const char *path, struct rmap_map **map_ret, struct rmap_error *err)
{
    enum { TRIES = 4 }; /* of a map that is being traced */
    struct rmap_map *map = NULL;
    enum rmap_status st = open_once(path, &map, err);
    for (int k = 1; k < TRIES && st == RMAP_OK && has_moved_on(map); k++) {
        rmap_map_close(map);
        map = NULL;
        st = open_once(path, &map, err);
    }
    if (st == RMAP_OK)
        *map_ret = map;
    else
        rmap_map_close(map);
    return st;
}
