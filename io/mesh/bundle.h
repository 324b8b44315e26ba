/* SPDX-License-Identifier: MIT
 *
 * Everything a scene is built from, self-contained: the scene file's text, what was chosen of it,
 * and the meshes it names. Rank 0 reads it from files and broadcasts it; a map carries it.
 */
#ifndef RMAP_BUNDLE_H
#define RMAP_BUNDLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "geometry/mesh.h"
#include "gradient/grid.h"
#include "io/file/diagnostics.h"
#include "scene/file_rays.h"
#include "scene/scene.h"

/* The rays that a detector of a map (NULL: its only one) registered of those that match a criterion
 * (NULL: all). RMAP_INPUT, RMAP_SYSTEM, RMAP_FORMAT. */
typedef enum rmap_status rmap_map_rays_reader(const char *path, const char *detector,
                                              const char *where, struct rmap_file_rays **set_ret,
                                              struct rmap_error *err);

struct rmap_bundle;
struct rmap_yaml_node;

/* What part of a scene takes part, and in which light. All strings owned; NULL or 0: not given. */
struct rmap_scene_options {
    char *simulation;
    char *color;    /* "rgb" or "spectral" */
    char **only;    /* names */
    char **without; /* names */
    char **set;     /* "key.path=value" */
    size_t n_only, n_without, n_set;
    bool allows_plugins; /* of any path; a map does not keep this, nor the next */
    char *allowing;      /* the command line that would allow them, for messages; NULL: unknown */
    const char *surface; /* borrowed, of who reads the scene to ask for this one alone, and traces
                            nothing: others have no scatter models. NULL: a scene as ever */
    char *cache;         /* a folder of what was made of large files before (kept_file.h) */
    const struct rmap_yaml_node *root;     /* borrowed: the tree of the text (yaml_tree.h), without
                                              mistakes. NULL: it is to be read */
    const struct rmap_scene *before_scene; /* borrowed: see there; NULL: there is none */
    const struct rmap_bundle *before; /* borrowed, of the scene as it was: meshes of the same files
                                         are taken over. NULL: there is none */
    rmap_map_rays_reader *read_map;   /* scenes are read below maps and criteria: of who can. NULL:
                                         no source may be a map */
};
void rmap_scene_options_fini(struct rmap_scene_options *options);

/* Chooses as `from` does (simulation, color, only, without, set) where it chooses nothing itself.
 * RMAP_SYSTEM. */
enum rmap_status rmap_scene_options_choose(struct rmap_scene_options *options,
                                           const struct rmap_scene_options *from,
                                           struct rmap_error *err) RMAP_MUST_USE;

struct rmap_mesh_origin;

struct rmap_bundle {
    char *path; /* for messages; meshes are relative to its folder */
    char *text;
    size_t text_nbytes;
    struct rmap_scene_options options;
    size_t n_mesh;
    struct {
        char *geometry;                  /* name in the scene */
        struct rmap_mesh *mesh;          /* scaled as the scene says */
        struct rmap_mesh_origin *origin; /* mesh_origin.h; NULL: unknown */
    } * mesh;
    size_t n_grid;
    struct {
        char *field; /* a medium's name, with "/1" behind it for a part of a sum */
        struct rmap_grid *grid;
    } * grid;
    size_t n_file;
    struct {
        char *name; /* as the scene names it */
        char *text; /* with a 0 behind it */
        size_t nbytes;
    } * file; /* tables and the like */
    size_t n_ray_set;
    struct {
        char *name; /* of its file, as the scene names it, and what is taken of it */
        struct rmap_file_rays *set;
    } * ray_set;
    size_t n_plugin;
    struct {
        char *field;
        uint64_t xxh3; /* of the shared object */
    } * plugin;
    int meshes_complete; /* nothing but plug-ins is read from files any more */
    int loads_plugins;   /* 0: their fields stay empty, as in scenes from maps. Never packed: a map
                            must not make whoever opens it load code */
};

/* Whether what is made of its scene is kept in the cache: not of a scene at hand, which changes,
 * nor of one that is not read from files. */
static inline bool rmap_bundle_is_kept(const struct rmap_bundle *bundle)
{
    return bundle->options.cache && !bundle->options.before && !bundle->meshes_complete;
}

/* Reads the scene file's text (regular file or pipe, at most 64 MiB); options are taken over.
 * RMAP_INPUT: missing, a directory, empty or binary; RMAP_SYSTEM: no permission, no memory. */
enum rmap_status rmap_bundle_open(const char *path, struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_bundle_destroy(struct rmap_bundle *bundle);

/* The same of a text that stands in memory, with the files beside `path`. RMAP_SYSTEM. */
enum rmap_status rmap_bundle_of_text(const char *path, const char *text,
                                     struct rmap_scene_options *options,
                                     struct rmap_bundle **bundle_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The same with a text of its own and all else of `from`, whose meshes, grids and rays both hold;
 * so what was chosen of the scene, where the options choose nothing. Of a scene that names no more
 * files. RMAP_SYSTEM. */
enum rmap_status rmap_bundle_share(const struct rmap_bundle *from, const char *text,
                                   struct rmap_scene_options *options,
                                   struct rmap_bundle **bundle_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* What a scene's file is called in new maps, so that its name is no part of the scene; maps of
 * before have the file's own. Keeps the folder, where plug-ins are found. RMAP_SYSTEM. */
#define RMAP_SCENE_NAME "scene.yaml"
enum rmap_status rmap_bundle_rename(struct rmap_bundle *bundle, const char *name,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Do faces of its meshes lie on surfaces? */
bool rmap_bundle_has_surfaces(const struct rmap_bundle *bundle);

/* Takes the mesh over, on success alone; for rmap_scene_read. */
enum rmap_status rmap_bundle_add_mesh(struct rmap_bundle *bundle, const char *geometry,
                                      struct rmap_mesh *mesh, struct rmap_error *err) RMAP_MUST_USE;

/* The same for a grid, whose one hold is taken over, and for what a plug-in's file was. */
enum rmap_status rmap_bundle_add_grid(struct rmap_bundle *bundle, const char *field,
                                      struct rmap_grid *grid, struct rmap_error *err) RMAP_MUST_USE;
/* A file's text, taken over on success alone. */
enum rmap_status rmap_bundle_add_file(struct rmap_bundle *bundle, const char *name, char *text,
                                      size_t nbytes, struct rmap_error *err) RMAP_MUST_USE;
/* The same for rays of a file, whose one hold is taken over. */
enum rmap_status rmap_bundle_add_ray_set(struct rmap_bundle *bundle, const char *name,
                                         struct rmap_file_rays *set,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bundle_add_plugin(struct rmap_bundle *bundle, const char *field,
                                        uint64_t xxh3, struct rmap_error *err) RMAP_MUST_USE;

/* Builds the scene. Reads meshes and grids from files into the bundle unless meshes_complete, and
 * sets it.
 * Lists every mistake in diagnostics; RMAP_INPUT when any of them is an error. */
enum rmap_status rmap_scene_read(struct rmap_bundle *bundle, struct rmap_scene **scene_ret,
                                 struct rmap_diagnostics *diagnostics,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* STL, OBJ, PLY, glTF through assimp; groups, objects and materials of the file become faces.
 * Degenerate triangles are dropped and counted. RMAP_INPUT when it cannot be read as a mesh. */
/* A field's numbers of three axes in an HDF5 file. dataset NULL: "n". placing: what the scene says
 * of where it lies; parts that it leaves NaN (and axes NULL) come from the dataset's attributes
 * `origin` (or `lower`), `spacing` (or `upper`), `length_unit`, `axes`. unit_m: metres of the
 * scene's unit, to which lengths are brought. RMAP_INPUT with what is wrong and the remedy. */
struct rmap_grid_file {
    const char *path, *dataset;
    const char *axes; /* "xyz": the dataset's indices in this order; "zyx" */
    double lower[3], upper[3], spacing[3];
    double length_unit_m, unit_m;
};
enum rmap_status rmap_grid_read(const struct rmap_grid_file *file, struct rmap_grid **grid_ret,
                                size_t *n_hole_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
