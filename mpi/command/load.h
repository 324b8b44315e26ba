/* SPDX-License-Identifier: MIT
 *
 * A command's inputs, on every rank.
 */
#ifndef RMAP_LOAD_H
#define RMAP_LOAD_H

#include "accel/accel.h"
#include "io/map/map_reader.h"
#include "io/mesh/bundle.h"
#include "mpi/command/command.h"

/* Of every command that reads scenes; or $RAYMAP_CACHE. */
#define RMAP_CACHE_OPTION                                                                          \
    {                                                                                              \
        "cache", 0, "FOLDER",                                                                      \
            "keep large meshes there as they are read, for the next start (default: none, or "     \
            "$RAYMAP_CACHE)"                                                                       \
    }

/* What `--simulation --only --without --set --allow-plugins --cache --color` are in an option
 * table, and what they say. */
#define RMAP_SCENE_OPTIONS                                                                         \
    {"simulation", 0, "NAME", "one of the scene's named simulations"},                             \
        {"only", 0, "NAMES", "objects, groups, sources or detectors that alone take part"},        \
        {"without", 0, "NAMES", "objects, groups, sources or detectors to leave out"},             \
        {"set", 0, "KEY=VALUE", "another value for a key of the scene, as limits.steps=100"},      \
        {"allow-plugins", 0, NULL, "run the code of plug-ins that the scene names"},               \
        RMAP_CACHE_OPTION,                                                                         \
    {                                                                                              \
        "color", 0, "MODE", "spectral or rgb: how light is described", .words = "spectral rgb"     \
    }

enum rmap_status rmap_scene_options_read(const struct rmap_arguments *given,
                                         struct rmap_scene_options *options,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Of a scene's file, or of what is at hand of it. options are taken over. */
enum rmap_status rmap_load_bundle(const struct rmap_context *context, const char *path,
                                  struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Rank 0 reads the scene and all its files and prints every mistake found; the other
 * ranks build the same scene from what it sends. options are taken over. The caller destroys
 * both. */
enum rmap_status rmap_load_scene(const struct rmap_context *context, const char *path,
                                 struct rmap_scene_options *options,
                                 struct rmap_bundle **bundle_ret, struct rmap_scene **scene_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The same; what was found is told there, on rank 0, in place of being printed. */
enum rmap_status rmap_load_scene_told(const struct rmap_context *context, const char *path,
                                      struct rmap_scene_options *options,
                                      struct rmap_diagnostics *found,
                                      struct rmap_bundle **bundle_ret,
                                      struct rmap_scene **scene_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The best of Embree's instruction sets that all ranks have. */
enum rmap_status rmap_common_isa(const struct rmap_context *context, int *level_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The structure of the scene, on every rank with the same of Embree's instruction sets:
 * the best that all have, or a lesser one, where `isa` ("AVX2"; NULL or unknown: any) is such. */
enum rmap_status rmap_load_accel(const struct rmap_context *context, const struct rmap_scene *scene,
                                 const char *isa, struct rmap_accel **accel_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Opens the map on every rank, in the same state on all of them; ranks of a node have
 * its rows in the same memory. */
enum rmap_status rmap_load_map(const struct rmap_context *context, const char *path,
                               struct rmap_map **map_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The same for a command that writes to the map, without sums over what stands beside its index
 * (rmap_map_open_found). found: rank 0's. */
enum rmap_status rmap_load_map_found(const struct rmap_context *context, const char *path,
                                     const struct rmap_map_listing *found,
                                     struct rmap_map **map_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The content of an open map becomes as rank 0's. */
enum rmap_status rmap_share_map(const struct rmap_context *context, struct rmap_map *map,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Takes away what a command that failed has made of a map; err says so where that fails, too. */
void rmap_discard_map(const char *path, struct rmap_error *err);

#endif
