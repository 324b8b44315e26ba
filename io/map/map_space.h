/* SPDX-License-Identifier: MIT
 *
 * The colour spaces of a map: the same scene, its light described in several ways. Objects, media,
 * sources and detectors are the same in all of them, and have the same numbers.
 */
#ifndef RMAP_MAP_SPACE_H
#define RMAP_MAP_SPACE_H

#include "io/map/map_content.h"
#include "io/mesh/bundle.h"

struct rmap_map_space {
    int32_t mode; /* enum rmap_colour_mode */
    int32_t n_channel;
    double wavelength_nm[RMAP_CHANNEL_MAX]; /* [n_channel] */
    char digest[33];                        /* rmap_piece_origin.space_digest */
    uint8_t *options;                       /* packed bundle of the options alone; owned */
    size_t options_nbytes;
};

/* Zeroed: empty. */
struct rmap_map_spaces {
    struct rmap_map_space *space;
    size_t n, cap;
};

void rmap_map_spaces_fini(struct rmap_map_spaces *spaces);

/* Number of the space with this digest, or -1. */
int32_t rmap_map_spaces_find(const struct rmap_map_spaces *spaces, const char *digest);

/* Appends the space of a scene. */
enum rmap_status rmap_map_spaces_add(struct rmap_map_spaces *spaces,
                                     const struct rmap_bundle *bundle,
                                     const struct rmap_scene *scene, const char *digest,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_map_spaces_copy(struct rmap_map_spaces *to,
                                      const struct rmap_map_spaces *from,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The scene of a bundle in that space; the bundle is as before when it returns. Checked: its
 * channels and numbers of objects are those stated, or those of `first` (NULL: not checked).
 * RMAP_FORMAT. */
enum rmap_status rmap_map_space_scene(const struct rmap_map_space *space,
                                      struct rmap_bundle *bundle, const struct rmap_scene *first,
                                      const char *path, struct rmap_scene **scene_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* /space of an index. */
struct rmap_h5;
enum rmap_status rmap_map_spaces_write(struct rmap_h5 *h5, const struct rmap_map_spaces *spaces,
                                       struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_map_spaces_read(struct rmap_h5 *h5, struct rmap_map_spaces *spaces,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* What chooses a colour space: a bundle with options and nothing else; the caller destroys it. */
enum rmap_status rmap_map_options_of(const struct rmap_map *map, size_t space,
                                     struct rmap_bundle **options_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
