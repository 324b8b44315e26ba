/* SPDX-License-Identifier: MIT
 *
 * Everything a scene is built from, self-contained: the scene file's text, what was chosen of it,
 * and the meshes it names.
 */
#include "io/mesh/bundle.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/text_file.h"
#include "io/mesh/mesh_origin.h"

static void free_list(char **list, size_t n)
{
    for (size_t i = 0; list && i < n; i++)
        rmap_free(list[i]);
    rmap_free(list);
}

void rmap_scene_options_fini(struct rmap_scene_options *options)
{
    rmap_free(options->simulation);
    rmap_free(options->color);
    rmap_free(options->allowing);
    rmap_free(options->cache);
    free_list(options->only, options->n_only);
    free_list(options->without, options->n_without);
    free_list(options->set, options->n_set);
    *options = (struct rmap_scene_options){0};
}

static enum rmap_status copy_text(const char *from, char **to, struct rmap_error *err)
{
    if (from && !*to && !(*to = rmap_strdup(from)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    return RMAP_OK;
}

static enum rmap_status copy_list(char *const *from, size_t n, char ***to, size_t *n_to,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (n == 0 || *n_to > 0)
        return RMAP_OK;
    *to = rmap_alloc(n, sizeof **to);
    if (!*to)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    for (; *n_to < n && st == RMAP_OK; ++*n_to)
        st = copy_text(from[*n_to], &(*to)[*n_to], err);
    return st;
}

enum rmap_status rmap_scene_options_choose(struct rmap_scene_options *options,
                                           const struct rmap_scene_options *from,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(copy_text(from->simulation, &options->simulation, err));
    RMAP_TRY(copy_text(from->color, &options->color, err));
    RMAP_TRY(copy_list(from->only, from->n_only, &options->only, &options->n_only, err));
    RMAP_TRY(
        copy_list(from->without, from->n_without, &options->without, &options->n_without, err));
    st = copy_list(from->set, from->n_set, &options->set, &options->n_set, err);
out:
    return st;
}

static const struct rmap_text_kind scene_file = {
    "a scene file", "YAML text", " (meshes belong into files of their own)", (size_t)64 << 20};

/* Without a text. */
static enum rmap_status begin(const char *path, struct rmap_scene_options *options,
                              struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct rmap_scene_options taken = {0};
    if (options) {
        taken = *options;
        *options = (struct rmap_scene_options){0};
    }
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    if (!bundle) {
        rmap_scene_options_fini(&taken);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    }
    bundle->options = taken;
    bundle->loads_plugins = 1;
    bundle->path = rmap_strdup(path);
    if (!bundle->path) {
        rmap_bundle_destroy(bundle);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    }
    *bundle_ret = bundle;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_open(const char *path, struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    enum rmap_status st = begin(path, options, &bundle, err);
    if (st == RMAP_OK)
        st = rmap_text_file_read(path, &scene_file, &bundle->text, &bundle->text_nbytes, err);
    if (st == RMAP_OK)
        *bundle_ret = bundle;
    else
        rmap_bundle_destroy(bundle);
    return st;
}

enum rmap_status rmap_bundle_of_text(const char *path, const char *text,
                                     struct rmap_scene_options *options,
                                     struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    enum rmap_status st = begin(path, options, &bundle, err);
    if (st != RMAP_OK)
        return st;
    bundle->text = rmap_strdup(text);
    if (!bundle->text) {
        rmap_bundle_destroy(bundle);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    }
    bundle->text_nbytes = strlen(text);
    *bundle_ret = bundle;
    return RMAP_OK;
}

void rmap_bundle_destroy(struct rmap_bundle *bundle)
{
    if (!bundle)
        return;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        rmap_free(bundle->mesh[i].geometry);
        rmap_mesh_destroy(bundle->mesh[i].mesh);
        rmap_mesh_origin_destroy(bundle->mesh[i].origin);
    }
    rmap_free(bundle->mesh);
    for (size_t i = 0; i < bundle->n_grid; i++) {
        rmap_free(bundle->grid[i].field);
        rmap_grid_drop(bundle->grid[i].grid);
    }
    rmap_free(bundle->grid);
    for (size_t i = 0; i < bundle->n_file; i++) {
        rmap_free(bundle->file[i].name);
        rmap_free(bundle->file[i].text);
    }
    rmap_free(bundle->file);
    for (size_t i = 0; i < bundle->n_ray_set; i++) {
        rmap_free(bundle->ray_set[i].name);
        rmap_file_rays_drop(bundle->ray_set[i].set);
    }
    rmap_free(bundle->ray_set);
    for (size_t i = 0; i < bundle->n_plugin; i++)
        rmap_free(bundle->plugin[i].field);
    rmap_free(bundle->plugin);
    rmap_free(bundle->path);
    rmap_free(bundle->text);
    rmap_scene_options_fini(&bundle->options);
    rmap_free(bundle);
}

enum rmap_status rmap_bundle_rename(struct rmap_bundle *bundle, const char *name,
                                    struct rmap_error *err)
{
    const char *slash = bundle->path ? strrchr(bundle->path, '/') : NULL;
    size_t folder = slash ? (size_t)(slash - bundle->path) + 1 : 0;
    char *path = rmap_alloc(folder + strlen(name) + 1, 1);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    if (folder)
        memcpy(path, bundle->path, folder);
    memcpy(path + folder, name, strlen(name) + 1);
    rmap_free(bundle->path);
    bundle->path = path;
    return RMAP_OK;
}

/* A list with room for one more item of `size` bytes, and a copy of the item's name. */
static void *grow(void *list, size_t n, size_t size, const char *name, char **name_ret,
                  struct rmap_error *err)
{
    *name_ret = rmap_strdup(name);
    void *grown = *name_ret ? rmap_realloc(list, n + 1, size) : NULL;
    if (grown)
        return grown;
    rmap_free(*name_ret);
    (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a scene");
    return NULL;
}

enum rmap_status rmap_bundle_add_mesh(struct rmap_bundle *bundle, const char *geometry,
                                      struct rmap_mesh *mesh, struct rmap_error *err)
{
    char *name = NULL;
    void *list = grow(bundle->mesh, bundle->n_mesh, sizeof *bundle->mesh, geometry, &name, err);
    if (!list)
        return RMAP_SYSTEM;
    bundle->mesh = list;
    bundle->mesh[bundle->n_mesh].geometry = name;
    bundle->mesh[bundle->n_mesh].origin = NULL;
    bundle->mesh[bundle->n_mesh++].mesh = mesh;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_add_grid(struct rmap_bundle *bundle, const char *field,
                                      struct rmap_grid *grid, struct rmap_error *err)
{
    char *name = NULL;
    void *list = grow(bundle->grid, bundle->n_grid, sizeof *bundle->grid, field, &name, err);
    if (!list)
        return RMAP_SYSTEM;
    bundle->grid = list;
    bundle->grid[bundle->n_grid].field = name;
    bundle->grid[bundle->n_grid++].grid = grid;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_add_file(struct rmap_bundle *bundle, const char *name, char *text,
                                      size_t nbytes, struct rmap_error *err)
{
    char *copy = NULL;
    void *list = grow(bundle->file, bundle->n_file, sizeof *bundle->file, name, &copy, err);
    if (!list)
        return RMAP_SYSTEM;
    bundle->file = list;
    bundle->file[bundle->n_file].name = copy;
    bundle->file[bundle->n_file].text = text;
    bundle->file[bundle->n_file++].nbytes = nbytes;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_add_ray_set(struct rmap_bundle *bundle, const char *name,
                                         struct rmap_file_rays *set, struct rmap_error *err)
{
    char *copy = NULL;
    void *list =
        grow(bundle->ray_set, bundle->n_ray_set, sizeof *bundle->ray_set, name, &copy, err);
    if (!list)
        return RMAP_SYSTEM;
    bundle->ray_set = list;
    bundle->ray_set[bundle->n_ray_set].name = copy;
    bundle->ray_set[bundle->n_ray_set++].set = set;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_add_plugin(struct rmap_bundle *bundle, const char *field,
                                        uint64_t xxh3, struct rmap_error *err)
{
    char *name = NULL;
    void *list = grow(bundle->plugin, bundle->n_plugin, sizeof *bundle->plugin, field, &name, err);
    if (!list)
        return RMAP_SYSTEM;
    bundle->plugin = list;
    bundle->plugin[bundle->n_plugin].field = name;
    bundle->plugin[bundle->n_plugin++].xxh3 = xxh3;
    return RMAP_OK;
}

static enum rmap_status share_files(const struct rmap_bundle *from, struct rmap_bundle *bundle,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < from->n_file && st == RMAP_OK; i++) {
        char *text = rmap_alloc(from->file[i].nbytes + 1, 1);
        if (!text)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a scene");
        memcpy(text, from->file[i].text, from->file[i].nbytes);
        st = rmap_bundle_add_file(bundle, from->file[i].name, text, from->file[i].nbytes, err);
        if (st != RMAP_OK)
            rmap_free(text);
    }
    return st;
}

enum rmap_status rmap_bundle_share(const struct rmap_bundle *from, const char *text,
                                   struct rmap_scene_options *options,
                                   struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    enum rmap_status st = rmap_bundle_of_text(from->path, text, options, &bundle, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_scene_options_choose(&bundle->options, &from->options, err));
    for (size_t i = 0; i < from->n_mesh; i++) {
        RMAP_TRY(rmap_bundle_add_mesh(bundle, from->mesh[i].geometry, from->mesh[i].mesh, err));
        (void)rmap_mesh_hold(from->mesh[i].mesh);
    }
    for (size_t i = 0; i < from->n_grid; i++) {
        RMAP_TRY(rmap_bundle_add_grid(bundle, from->grid[i].field, from->grid[i].grid, err));
        (void)rmap_grid_hold(from->grid[i].grid);
    }
    RMAP_TRY(share_files(from, bundle, err));
    for (size_t i = 0; i < from->n_ray_set; i++) {
        RMAP_TRY(rmap_bundle_add_ray_set(bundle, from->ray_set[i].name, from->ray_set[i].set, err));
        (void)rmap_file_rays_hold(from->ray_set[i].set);
    }
    for (size_t i = 0; i < from->n_plugin; i++)
        RMAP_TRY(rmap_bundle_add_plugin(bundle, from->plugin[i].field, from->plugin[i].xxh3, err));
    bundle->meshes_complete = from->meshes_complete;
    bundle->loads_plugins = 0;
    *bundle_ret = bundle;
    bundle = NULL;
out:
    rmap_bundle_destroy(bundle);
    return st;
}
