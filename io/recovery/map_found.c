/* SPDX-License-Identifier: MIT
 *
 * What stands beside the index of a map: pieces and journals of a killed or running trace.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/map/journal.h"
#include "io/map/map_directory.h"
#include "io/map/map_internal.h"
#include "io/map/piece_file.h"
#include "io/recovery/salvage.h"

enum rmap_status rmap_map_note_trouble(struct rmap_map *map, const char *text,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(map->trouble, map->cap_trouble, map->n_trouble + 1, err);
    if (st != RMAP_OK)
        return st;
    map->trouble[map->n_trouble] = rmap_strdup(text);
    if (!map->trouble[map->n_trouble])
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a message");
    map->n_trouble++;
    return RMAP_OK;
}

/* Whether the index lists a piece; its pieces are in order, and n_piece of the index come first. */
static bool is_listed(const struct rmap_map_content *content, size_t n_piece,
                      const struct rmap_piece_name *name)
{
    size_t low = 0, high = n_piece;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const struct rmap_piece_info *piece = &content->piece[middle];
        if (piece->shard < name->shard ||
            (piece->shard == name->shard && piece->number < name->number))
            low = middle + 1;
        else
            high = middle;
    }
    return low < n_piece && content->piece[low].shard == name->shard &&
           content->piece[low].number == name->number;
}

/* Appends what `found` has, once it is in a space of the map; trouble otherwise. */
static enum rmap_status take(struct rmap_map *map, enum rmap_status read,
                             struct rmap_map_content *found, const struct rmap_piece_origin *origin,
                             struct rmap_error *why, struct rmap_error *err)
{
    if (read == RMAP_OK && found->n_piece > 0)
        read = rmap_piece_place(found, origin, map->summary.seed, map->summary.tracer_revision,
                                map->scene_digest, &map->spaces, why);
    for (size_t i = 0; i < found->n_portion; i++)
        found->portion[i].is_added = 1;
    if (read == RMAP_OK)
        return rmap_map_content_add(&map->content, found, err);
    if (read != RMAP_FORMAT)
        return rmap_error_set(err, read, "%s", why->text);
    return rmap_map_note_trouble(map, why->text, err);
}

static enum rmap_status add_piece(struct rmap_map *map, const struct rmap_piece_name *name,
                                  struct rmap_error *err)
{
    struct rmap_map_content found = {0};
    struct rmap_piece_origin origin;
    struct rmap_error why = {0};
    enum rmap_status st =
        rmap_piece_read(map->path, name->shard, name->number, &found, &origin, &why);
    st = take(map, st, &found, &origin, &why, err);
    rmap_map_content_fini(&found);
    return st;
}

static enum rmap_status add_leftover(struct rmap_map *map, const struct rmap_leftover *leftover,
                                     struct rmap_error *err)
{
    struct rmap_map_content found = {0};
    struct rmap_piece_origin origin;
    struct rmap_error why = {0};
    bool committed = false;
    enum rmap_status st =
        rmap_open_piece_read(map->path, leftover, &found, &origin, &committed, &why);
    st = take(map, st, &found, &origin, &why, err);
    rmap_map_content_fini(&found);
    return st;
}

/* Of two portions that share some of their rays, neither holding all of the other's, one is left
 * out: that of the index stays, else the first. Its other rays are missing then. Portions with gaps
 * may lie within others. */
static enum rmap_status drop_overlaps(struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_map_content *content = &map->content;
    struct rmap_portion_info *list = content->portion, *last = NULL; /* kept, without gaps */
    size_t kept = 0, n_dropped;
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *next = &list[i];
        struct rmap_error text = {0};
        bool gaps = rmap_portion_has_gaps(next);
        if (gaps || !last || next->first_ray >= rmap_portion_end(last) ||
            !(last->is_added || next->is_added)) {
            list[kept] = *next;
            last = gaps ? last : &list[kept];
            kept++;
            continue;
        }
        bool drop_last = last == &list[kept - 1] && !next->is_added;
        const struct rmap_portion_info *dropped = drop_last ? last : next;
        (void)rmap_error_set(&text, RMAP_FORMAT,
                             "%s and %s both hold some rays from %llu on: the block from ray %llu "
                             "on of %s does not count",
                             content->piece[last->piece].name, content->piece[next->piece].name,
                             (unsigned long long)next->first_ray,
                             (unsigned long long)dropped->first_ray,
                             content->piece[dropped->piece].name);
        enum rmap_status st = rmap_map_note_trouble(map, text.text, err);
        if (st != RMAP_OK)
            return st;
        if (drop_last)
            *last = *next;
    }
    content->n_portion = kept;
    rmap_map_content_drop_covered(content, &n_dropped); /* counts the rows of pieces again */
    return RMAP_OK;
}

static enum rmap_status add_leftovers(struct rmap_map *map, const struct rmap_map_listing *found,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < found->n_leftover && st == RMAP_OK; i++)
        st = add_leftover(map, &found->leftover[i], err);
    return st;
}

static enum rmap_status add_pieces(struct rmap_map *map, const struct rmap_map_listing *found,
                                   size_t n_listed, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < found->pieces.n && st == RMAP_OK; i++)
        if (!is_listed(&map->content, n_listed, &found->pieces.name[i]))
            st = add_piece(map, &found->pieces.name[i], err);
    return st;
}

/* Without a listing somebody may be writing: pieces are listed after journals were read, so that
 * one that is finished meanwhile is found as a piece, at worst as both. */
enum rmap_status rmap_map_add_found(struct rmap_map *map, const struct rmap_map_listing *given,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_listing found = {0};
    size_t n_listed = map->content.n_piece, n_dropped = 0;
    if (!given)
        RMAP_TRY(rmap_map_list(map->path, &found, err));
    const char *link = given ? given->link.text : found.link.text;
    if (link[0])
        RMAP_TRY(rmap_map_note_trouble(map, link, err));
    RMAP_TRY(add_leftovers(map, given ? given : &found, err));
    if (!given) {
        rmap_map_listing_fini(&found);
        RMAP_TRY(rmap_map_list(map->path, &found, err));
    }
    RMAP_TRY(add_pieces(map, given ? given : &found, n_listed, err));
    RMAP_TRY(rmap_map_content_sort(&map->content, err));
    rmap_map_content_drop_covered(&map->content, &n_dropped);
    RMAP_TRY(drop_overlaps(map, err));
    RMAP_TRY(rmap_map_content_check(&map->content, map->path, err));
out:
    rmap_map_listing_fini(&found);
    return st;
}

enum rmap_status rmap_map_add_salvaged(struct rmap_map *map,
                                       const struct rmap_map_content *salvaged,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content *content = &map->content;
    size_t n_dropped = 0;
    rmap_map_forget(map);
    RMAP_TRY(rmap_map_content_own(content, err));
    RMAP_TRY(rmap_map_content_drop_open(content, err));
    const size_t n_before = content->n_portion;
    RMAP_TRY(rmap_map_content_add(content, salvaged, err));
    for (size_t i = n_before; i < content->n_portion; i++)
        content->portion[i].is_added = 1;
    RMAP_TRY(rmap_map_content_sort(content, err));
    rmap_map_content_drop_covered(content, &n_dropped);
    RMAP_TRY(rmap_map_content_check(content, map->path, err));
    RMAP_TRY(rmap_map_sum_up(map, err));
out:
    return st;
}

static enum rmap_status compare_piece(struct rmap_map *map, const struct rmap_piece_info *piece,
                                      struct rmap_error *err)
{
    struct stat file;
    struct rmap_error text = {0};
    const int got = rmap_piece_file_stat(map->path, piece, &file);
    if (got != 0 && errno == ENOMEM)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (got != 0)
        (void)rmap_error_set(&text, RMAP_FORMAT, "%s/%s %s (%s)", map->path, piece->name,
                             errno == ENOENT ? "is missing" : "cannot be examined",
                             strerror(errno));
    else if (!piece->is_open && (uint64_t)file.st_size != piece->nbytes)
        (void)rmap_error_set(
            &text, RMAP_FORMAT, "%s/%s has %lld bytes, not %llu: it was cut off or replaced",
            map->path, piece->name, (long long)file.st_size, (unsigned long long)piece->nbytes);
    return text.text[0] ? rmap_map_note_trouble(map, text.text, err) : RMAP_OK;
}

enum rmap_status rmap_map_compare_directory(struct rmap_map *map, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    for (size_t i = 0; i < map->content.n_piece; i++)
        RMAP_TRY(compare_piece(map, &map->content.piece[i], err));
    if (!map->summary.complete) /* what stood beside the index was found, what came since is new */
        goto out;
    RMAP_TRY(rmap_map_list_pieces(map->path, &name, &n, err));
    for (size_t i = 0; i < n; i++) {
        struct rmap_error text = {0};
        if (is_listed(&map->content, map->content.n_piece, &name[i]))
            continue;
        (void)rmap_error_set(&text, RMAP_FORMAT,
                             "%s/shard-%05d/piece-%05d.h5 is not in the index: its rays do not "
                             "count",
                             map->path, name[i].shard, name[i].number);
        RMAP_TRY(rmap_map_note_trouble(map, text.text, err));
    }
out:
    rmap_free(name);
    return st;
}
