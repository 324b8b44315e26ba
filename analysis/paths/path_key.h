/* SPDX-License-Identifier: MIT
 *
 * What tells the paths of rays apart: a path as a row of symbols, written for people, and written
 * as the criterion that selects exactly the rays with that path.
 */
#ifndef RMAP_PATH_KEY_H
#define RMAP_PATH_KEY_H

#include <stdbool.h>
#include <stdint.h>

#include "analysis/table/key_sums.h"
#include "portion/portion.h"
#include "scene/scene.h"

/* Whose names stand in a path. SURFACE: each object of the scene, such as lens.3. OBJECT: what is
 * one entry of the scene file, so that the surfaces of a prescription are one lens. GROUP: the
 * outermost group, or the object that is in none. */
enum rmap_path_level {
    RMAP_PATH_SURFACE,
    RMAP_PATH_OBJECT,
    RMAP_PATH_GROUP,
    RMAP_PATH_LEVEL_COUNT
};

/* "surface", "object", "group". */
const char *rmap_path_level_word(enum rmap_path_level level);

struct rmap_path_view {
    enum rmap_path_level level;
    bool without_events; /* what happened at an object does not count */
    bool collapsed;      /* equal steps in a row count as one */
    bool until_detector; /* histories end with a registration on `detector`, and a ray has as many
                            as registrations there; what happens at the object that it lies on does
                            not count */
    int32_t detector;
};

/* A step: letter (an index into RMAP_PATH_LETTERS, or ANY), and above it the place. */
typedef uint32_t rmap_path_step;

struct rmap_path_keys; /* immutable, thread-safe */
enum rmap_status rmap_path_keys_create(const struct rmap_scene *scene,
                                       const struct rmap_path_view *view,
                                       struct rmap_path_keys **keys_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_keys_destroy(struct rmap_path_keys *keys);

const struct rmap_path_view *rmap_path_keys_view(const struct rmap_path_keys *keys);

/* Columns that rmap_path_key_of reads. */
rmap_column_set rmap_path_keys_columns(const struct rmap_path_keys *keys);

/* Where a ray's rows begin in a portion. */
struct rmap_path_place_of_ray {
    size_t ray, segment, registration;
    size_t until; /* behind the registration that the path is to end with; 0: the first */
};

/* Its path: at most as many symbols as it has segments and registrations. False: it has none. */
bool rmap_path_key_of(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                      const struct rmap_path_place_of_ray *place, rmap_path_step *symbol,
                      size_t *n_ret);

/* Scenes with more sources are refused: a key has the source in it. */
#define RMAP_PATH_SOURCES_MAX ((size_t)1 << 20)

/* The key of a path and the source of its ray, which rays of a map share where both are equal: XXH3
 * of the steps, of which 107 bits are kept, so that of 100 million classes two share a key by a
 * chance of 2^-54. */
struct rmap_key rmap_path_key_hash(const rmap_path_step *symbol, size_t n, int32_t source);

static inline int32_t rmap_path_source_of(struct rmap_key key)
{
    return (int32_t)(key.high & (RMAP_PATH_SOURCES_MAX - 1));
}

/* `source(lamp) and path("...")`, rmap_free; true of exactly the rays with this path. A path too
 * long for the criterion language (some 16,000 steps) becomes `ray == only_ray` where it is of one
 * ray alone, else NULL. */
#define RMAP_PATH_MANY_RAYS UINT64_MAX

/* The name an object has at this level, and all of them, in the order of their first objects. */
size_t rmap_path_n_label(const struct rmap_path_keys *keys);
const char *rmap_path_label(const struct rmap_path_keys *keys, size_t label);
const int32_t *rmap_path_labels(const struct rmap_path_keys *keys); /* [n_object] */

#endif
