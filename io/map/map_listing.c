/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/history_file.h"
#include "io/map/map_directory.h"

struct walk {
    const char *map_path, *shard_name;
    int shard;
    struct rmap_map_listing *listing;
};

static enum rmap_status add_name(struct rmap_piece_list *list, int shard, int number,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(list->name, list->cap, list->n + 1, err);
    if (st == RMAP_OK)
        list->name[list->n++] = (struct rmap_piece_name){shard, number};
    return st;
}

/* One row per file; the two of a piece are joined later. */
static enum rmap_status add_leftover(const struct walk *walk, const char *name,
                                     struct rmap_error *err)
{
    struct rmap_map_listing *listing = walk->listing;
    struct rmap_leftover row = {.shard = walk->shard,
                                .has_part = rmap_leftover_is_part(name),
                                .has_journal = rmap_leftover_is_journal(name)};
    if (!row.has_part && !row.has_journal)
        return RMAP_OK;
    int stem = (int)(strlen(name) - strlen(row.has_part ? ".part" : ".journal"));
    if ((size_t)snprintf(row.name, sizeof row.name, "%s/%.*s.part", walk->shard_name, stem, name) >=
        sizeof row.name)
        return RMAP_OK; /* no name of ours is that long */
    enum rmap_status st =
        RMAP_RESERVE(listing->leftover, listing->cap_leftover, listing->n_leftover + 1, err);
    if (st == RMAP_OK)
        listing->leftover[listing->n_leftover++] = row;
    return st;
}

static enum rmap_status list_in_shard(void *context, int directory, const char *name,
                                      struct rmap_error *err)
{
    (void)directory;
    const struct walk *walk = context;
    int piece = rmap_directory_number(name, "piece-", ".h5");
    int history = rmap_directory_number(name, "piece-", RMAP_HISTORY_SUFFIX);
    if (piece >= 0)
        return add_name(&walk->listing->pieces, walk->shard, piece, err);
    if (history >= 0)
        return add_name(&walk->listing->histories, walk->shard, history, err);
    return add_leftover(walk, name, err);
}

/* What stands there as a link is none of the map's: it is told, and left to itself. */
static enum rmap_status list_in_map(void *context, int directory, const char *name,
                                    struct rmap_error *err)
{
    struct rmap_error why = {0};
    struct walk *walk = context;
    walk->listing->has_half_index |= rmap_leftover_is_half_index(name);
    walk->shard = rmap_directory_number(name, "shard-", "");
    walk->shard_name = name;
    if (walk->shard < 0)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", walk->map_path, name);
    enum rmap_status st = path ? rmap_shard_visit(directory, path, list_in_shard, walk, &why)
                               : rmap_error_set(&why, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    if (st == RMAP_USAGE)
        walk->listing->link = why;
    else if (st != RMAP_OK && err)
        *err = why;
    return st == RMAP_USAGE ? RMAP_OK : st;
}

static int by_place(const void *a, const void *b)
{
    const struct rmap_piece_name *x = a, *y = b;
    if (x->shard != y->shard)
        return x->shard < y->shard ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static void sort_names(struct rmap_piece_list *list)
{
    if (list->n > 0)
        qsort(list->name, list->n, sizeof *list->name, by_place);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct rmap_leftover *)a)->name, ((const struct rmap_leftover *)b)->name);
}

static void join_leftovers(struct rmap_map_listing *listing)
{
    struct rmap_leftover *list = listing->leftover;
    size_t kept = 0;
    if (listing->n_leftover > 0)
        qsort(list, listing->n_leftover, sizeof *list, by_name);
    for (size_t i = 0; i < listing->n_leftover; i++) {
        if (kept > 0 && strcmp(list[kept - 1].name, list[i].name) == 0) {
            list[kept - 1].has_part |= list[i].has_part;
            list[kept - 1].has_journal |= list[i].has_journal;
        } else {
            list[kept++] = list[i];
        }
    }
    listing->n_leftover = kept;
}

enum rmap_status rmap_map_list(const char *map_path, struct rmap_map_listing *listing,
                               struct rmap_error *err)
{
    struct walk walk = {.map_path = map_path, .listing = listing};
    *listing = (struct rmap_map_listing){0};
    enum rmap_status st = rmap_directory_visit(map_path, list_in_map, &walk, err);
    if (st != RMAP_OK)
        rmap_map_listing_fini(listing);
    sort_names(&listing->pieces);
    sort_names(&listing->histories);
    join_leftovers(listing);
    return st;
}

void rmap_map_listing_fini(struct rmap_map_listing *listing)
{
    rmap_free(listing->pieces.name);
    rmap_free(listing->histories.name);
    rmap_free(listing->leftover);
    *listing = (struct rmap_map_listing){0};
}

/* ---- one kind alone ---- */

static enum rmap_status list_names(const char *map_path, bool histories,
                                   struct rmap_piece_name **name_ret, size_t *n_ret,
                                   struct rmap_error *err)
{
    struct rmap_map_listing listing;
    enum rmap_status st = rmap_map_list(map_path, &listing, err);
    struct rmap_piece_list *list = histories ? &listing.histories : &listing.pieces;
    if (st == RMAP_OK) {
        *name_ret = list->name;
        *n_ret = list->n;
        list->name = NULL;
    }
    rmap_map_listing_fini(&listing);
    return st;
}

enum rmap_status rmap_map_list_pieces(const char *map_path, struct rmap_piece_name **name_ret,
                                      size_t *n_ret, struct rmap_error *err)
{
    return list_names(map_path, false, name_ret, n_ret, err);
}

enum rmap_status rmap_map_list_histories(const char *map_path, struct rmap_piece_name **name_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    return list_names(map_path, true, name_ret, n_ret, err);
}

enum rmap_status rmap_map_list_leftovers(const char *map_path, struct rmap_leftover **leftover_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    struct rmap_map_listing listing;
    enum rmap_status st = rmap_map_list(map_path, &listing, err);
    if (st == RMAP_OK) {
        *leftover_ret = listing.leftover;
        *n_ret = listing.n_leftover;
        listing.leftover = NULL;
    }
    rmap_map_listing_fini(&listing);
    return st;
}
