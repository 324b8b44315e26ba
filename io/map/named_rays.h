/* SPDX-License-Identifier: MIT
 *
 * Rays that a map keeps by name, for criteria to ask for as @NAME: MAP/selection-NAME.h5, sealed,
 * with the dataset /ray/id. docs/map.md has the rest of it.
 */
#ifndef RMAP_NAMED_RAYS_H
#define RMAP_NAMED_RAYS_H

#include "base/id_set.h"
#include "io/map/map_reader.h"

#define RMAP_FILETYPE_NAMED_RAYS "raymap selection"

/* A name is a word of the criterion language: letters, digits and '_', no digit first. */
#define RMAP_RAYS_NAME_NBYTES 65

struct rmap_named_rays {
    char name[RMAP_RAYS_NAME_NBYTES];
    char *criterion;       /* that they matched, as it was written; owned */
    char digest[33];       /* of the map then */
    uint64_t n_ray;        /* in the set */
    uint64_t nbytes;       /* of the file */
    bool is_stale;         /* the map has other rays now */
    struct rmap_error why; /* with a text: the file is damaged, and the rest is not known */
};

struct rmap_named_rays_list {
    struct rmap_named_rays *row; /* [n], by name */
    size_t n, cap;
};

/* RMAP_USAGE: it cannot be a name. */
enum rmap_status rmap_rays_name_check(const char *name, struct rmap_error *err) RMAP_MUST_USE;

/* "MAP/selection-NAME.h5"; rmap_free. NULL when memory is short. */
char *rmap_named_rays_path(const char *map_path, const char *name);

/* The name in such a file's; false: it is none. */
bool rmap_named_rays_name(const char *file, char name[RMAP_RAYS_NAME_NBYTES]);

/* What the map at hand keeps; damaged files among them. RMAP_SYSTEM. */
enum rmap_status rmap_named_rays_list(const struct rmap_map *map, struct rmap_named_rays_list *list,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_named_rays_list_fini(struct rmap_named_rays_list *list);

/* Writes a set that is settled, of rays of the map as it is, in place of what has the name. */
enum rmap_status rmap_named_rays_write(const struct rmap_map *map, const char *name,
                                       const char *criterion, const struct rmap_id_set *set,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Reads one. info: NULL, or what the list has of it, to be rmap_named_rays_fini. RMAP_INPUT: there
 * is none; RMAP_FORMAT: damaged. */
enum rmap_status rmap_named_rays_read(const struct rmap_map *map, const char *name,
                                      struct rmap_id_set *set, struct rmap_named_rays *info,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_named_rays_fini(struct rmap_named_rays *rays);

/* Lets criteria that are compiled against the map's scenes find them; each is read when it is first
 * asked for, and stays with the map. */
struct rmap_kept_rays;
enum rmap_status rmap_map_offer_named_rays(struct rmap_map *map,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_kept_rays_destroy(struct rmap_kept_rays *kept); /* NULL is fine */

#endif
