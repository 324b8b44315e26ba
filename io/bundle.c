/* SPDX-License-Identifier: MIT */
#include "io/bundle.h"

#include <string.h>

#include "base/alloc.h"
#include "io/text_file.h"

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
    free_list(options->only, options->n_only);
    free_list(options->without, options->n_without);
    free_list(options->set, options->n_set);
    *options = (struct rmap_scene_options){0};
}

static const struct rmap_text_kind scene_file = {
    "a scene file", "YAML text", " (meshes belong into files of their own)", (size_t)64 << 20};

enum rmap_status rmap_bundle_open(const char *path, struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
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
    bundle->path = rmap_strdup(path);
    if (!bundle->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
        goto out;
    }
    RMAP_TRY(rmap_text_file_read(path, &scene_file, &bundle->text, &bundle->text_nbytes, err));
    *bundle_ret = bundle;
    bundle = NULL;
out:
    rmap_bundle_destroy(bundle);
    return st;
}

void rmap_bundle_destroy(struct rmap_bundle *bundle)
{
    if (!bundle)
        return;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        rmap_free(bundle->mesh[i].geometry);
        rmap_mesh_destroy(bundle->mesh[i].mesh);
    }
    rmap_free(bundle->mesh);
    rmap_free(bundle->path);
    rmap_free(bundle->text);
    rmap_scene_options_fini(&bundle->options);
    rmap_free(bundle);
}

enum rmap_status rmap_bundle_add_mesh(struct rmap_bundle *bundle, const char *geometry,
                                      struct rmap_mesh *mesh, struct rmap_error *err)
{
    char *name = rmap_strdup(geometry);
    void *grown =
        name ? rmap_realloc(bundle->mesh, bundle->n_mesh + 1, sizeof *bundle->mesh) : NULL;
    if (!grown) {
        rmap_free(name);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a mesh");
    }
    bundle->mesh = grown;
    bundle->mesh[bundle->n_mesh].geometry = name;
    bundle->mesh[bundle->n_mesh].mesh = mesh;
    bundle->n_mesh++;
    return RMAP_OK;
}
