/* SPDX-License-Identifier: MIT
 *
 * From a bundle's text to a scene: the tree, its edits, its sections in the order in which they
 * need each other (in the file they may stand in any order).
 */
#include <locale.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/scene/scene_reader.h"

static void check_version(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(reader->root, "raymap");
    uint64_t version = 1;
    if (!node)
        rmap_reader_warn(reader, reader->root,
                         "no 'raymap: 1' says which version of the format this is; 1 is assumed");
    else if (rmap_reader_whole(reader, reader->root, "raymap", 1, 1000000, &version) &&
             version != 1)
        rmap_reader_error(reader, node,
                          "version %s of the scene format is newer than this program: it reads "
                          "version 1",
                          node->text);
}

static enum rmap_status read_sections(struct rmap_reader *reader)
{
    static const char *const key[] = {
        "raymap",  "units",   "spectrum",  "limits",  "media",      "surfaces",   "geometries",
        "objects", "sources", "detectors", "cameras", "background", "simulations"};
    enum rmap_status st = RMAP_OK;
    if (!rmap_reader_check_map(reader, reader->root, "a scene", key, RMAP_COUNT(key)))
        return RMAP_OK;
    check_version(reader);
    rmap_reader_choose_simulation(reader);
    RMAP_TRY(rmap_reader_read_units(reader));
    rmap_reader_read_limits(reader, rmap_yaml_get(reader->root, "limits"));
    RMAP_TRY(rmap_reader_read_channels(reader));
    RMAP_TRY(rmap_reader_read_media(reader));
    RMAP_TRY(rmap_reader_read_surfaces(reader));
    RMAP_TRY(rmap_reader_read_geometries(reader));
    RMAP_TRY(rmap_reader_read_objects(reader));
    RMAP_TRY(rmap_reader_make_gradients(reader));
    RMAP_TRY(rmap_reader_read_sources(reader));
    RMAP_TRY(rmap_reader_read_detectors(reader));
    RMAP_TRY(rmap_reader_read_receivers(reader));
    RMAP_TRY(rmap_reader_read_cameras(reader));
    RMAP_TRY(rmap_reader_read_background(reader));
    rmap_reader_settle_frames(reader);
    RMAP_TRY(rmap_reader_read_simulations(reader));
out:
    return st;
}

static enum rmap_status parse(struct rmap_reader *reader)
{
    const struct rmap_scene_options *options = &reader->bundle->options;
    enum rmap_status st = rmap_yaml_parse(reader->bundle->text, reader->bundle->text_nbytes,
                                          &reader->root, reader->diagnostics, reader->err);
    if (st == RMAP_INPUT) /* told in the diagnostics */
        return RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < options->n_set; i++)
        st = rmap_yaml_edit(reader->root, options->set[i], reader->diagnostics, reader->err);
    return st;
}

static void fini(struct rmap_reader *reader)
{
    rmap_yaml_destroy(reader->root);
    rmap_names_fini(&reader->media);
    rmap_names_fini(&reader->surfaces);
    rmap_names_fini(&reader->geometries);
    rmap_names_fini(&reader->members);
    rmap_names_fini(&reader->meshes);
    rmap_names_fini(&reader->grids);
    rmap_free(reader->entry);
    rmap_free(reader->group_to_world);
    rmap_free(reader->frame);
    rmap_reader_release(reader);
}

static enum rmap_status verdict(struct rmap_reader *reader)
{
    size_t n = reader->diagnostics->n_error;
    const char *path = reader->bundle->path ? reader->bundle->path : "scene";
    if (!n && reader->receivers) {
        n = reader->receivers->diagnostics->n_error;
        path = reader->receivers->path;
    }
    if (!n)
        return RMAP_OK;
    return rmap_error_set(reader->err, RMAP_INPUT, "%s in %s", rmap_counted(n, "mistake").text,
                          path);
}

/* A scene from a map may have a hundred thousand meshes. */
static enum rmap_status name_bundled(struct rmap_reader *reader)
{
    const struct rmap_bundle *bundle = reader->bundle;
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < bundle->n_mesh; i++)
        st = rmap_names_add(&reader->meshes, bundle->mesh[i].geometry, 0, (int32_t)i, 0,
                            reader->err);
    for (size_t i = 0; st == RMAP_OK && i < bundle->n_grid; i++)
        st = rmap_names_add(&reader->grids, bundle->grid[i].field, 0, (int32_t)i, 0, reader->err);
    return st;
}

/* What only the whole scene shows goes to the diagnostics as well. */
static enum rmap_status finish(struct rmap_reader *reader)
{
    struct rmap_error failure = {0};
    enum rmap_status st = rmap_scene_finish(reader->scene, &failure);
    if (st == RMAP_INPUT)
        rmap_reader_error(reader, NULL, "%s", failure.text);
    else if (st != RMAP_OK && reader->err)
        *reader->err = failure;
    return st;
}

static enum rmap_status read_scene(struct rmap_reader *reader)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_scene_create(&reader->scene, reader->err));
    RMAP_TRY(name_bundled(reader));
    RMAP_TRY(parse(reader));
    if (reader->root)
        RMAP_TRY(read_sections(reader));
    RMAP_TRY(verdict(reader));
    if (reader->receivers) /* whatever is wrong from here on is theirs */
        reader->diagnostics = reader->receivers->diagnostics;
    st = finish(reader);
    /* Scenes from maps, and from other ranks, were looked at where they came from. */
    if (st == RMAP_OK && !reader->bundle->meshes_complete && reader->scene->n_gradient) {
        RMAP_TRY(rmap_reader_probe_gradients(reader));
        RMAP_TRY(rmap_reader_probe_sag(reader));
    }
    if (st == RMAP_OK || st == RMAP_INPUT)
        st = verdict(reader);
out:
    return st;
}

static enum rmap_status read_with(const struct rmap_receivers *receivers,
                                  struct rmap_bundle *bundle, struct rmap_scene **scene_ret,
                                  struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    struct rmap_reader reader = {
        .bundle = bundle, .diagnostics = diagnostics, .receivers = receivers, .err = err};
    /* Numbers have a point, whatever the locale of the caller. */
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!plain)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a locale");
    locale_t before = uselocale(plain);
    enum rmap_status st = read_scene(&reader);
    uselocale(before);
    freelocale(plain);
    fini(&reader);
    if (st != RMAP_OK) {
        rmap_scene_destroy(reader.scene);
        return st;
    }
    bundle->meshes_complete = 1;
    *scene_ret = reader.scene;
    return RMAP_OK;
}

enum rmap_status rmap_scene_read(struct rmap_bundle *bundle, struct rmap_scene **scene_ret,
                                 struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    return read_with(NULL, bundle, scene_ret, diagnostics, err);
}

enum rmap_status rmap_scene_read_receivers(const struct rmap_bundle *bundle,
                                           const struct rmap_scene_options *options,
                                           const struct rmap_receivers *receivers,
                                           struct rmap_scene **scene_ret, struct rmap_error *err)
{
    struct rmap_diagnostics diagnostics;
    struct rmap_bundle with = *bundle; /* complete: nothing is added to it */
    if (!bundle->meshes_complete)
        return rmap_error_set(err, RMAP_INTERNAL, "receivers for a scene that is not complete");
    with.options = *options;
    rmap_diagnostics_init(&diagnostics, bundle->path);
    enum rmap_status st = read_with(receivers, &with, scene_ret, &diagnostics, err);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}
