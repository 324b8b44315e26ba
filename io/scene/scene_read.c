/* SPDX-License-Identifier: MIT
 *
 * From a bundle's text to a scene: the tree, its edits, its sections in the order in which they
 * need each other (in the file they may stand in any order).
 */
#include <locale.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/kept_file.h"
#include "io/scene/scene_attributes.h"
#include "io/scene/scene_boxes.h"
#include "io/scene/scene_cameras.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_detectors.h"
#include "io/scene/scene_field_frames.h"
#include "io/scene/scene_field_probe.h"
#include "io/scene/scene_films.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_include.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_objects.h"
#include "io/scene/scene_simulations.h"
#include "io/scene/scene_skies.h"
#include "io/scene/scene_sources.h"
#include "io/scene/scene_species.h"
#include "io/scene/scene_surfaces.h"
#include "io/scene/scene_turbid.h"
#include "io/scene/yaml_pack.h"

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

const struct rmap_mapping rmap_root_keys = {
    "The scene file",
    NULL,
    {{"a scene", "raymap include units spectrum limits media films surfaces geometries objects "
                 "attributes sources detectors "
                 "cameras background time simulations"}}};

static void read_sections(struct rmap_reader *reader)
{
    static void (*const section[])(struct rmap_reader *) = {check_version,
                                                            rmap_reader_choose_simulation,
                                                            rmap_reader_read_units,
                                                            rmap_reader_read_limits,
                                                            rmap_reader_read_channels,
                                                            rmap_reader_read_media,
                                                            rmap_reader_read_films,
                                                            rmap_reader_read_surfaces,
                                                            rmap_reader_read_geometries,
                                                            rmap_reader_apply_attributes,
                                                            rmap_reader_read_objects,
                                                            rmap_reader_check_attributes,
                                                            rmap_reader_make_gradients,
                                                            rmap_reader_read_turbid,
                                                            rmap_reader_read_sources,
                                                            rmap_reader_read_detectors,
                                                            rmap_reader_aim_skies,
                                                            rmap_reader_read_receivers,
                                                            rmap_reader_read_cameras,
                                                            rmap_reader_read_background,
                                                            rmap_reader_settle_frames,
                                                            rmap_reader_read_simulations};
    if (!rmap_reader_known(reader, reader->root, &rmap_root_keys, 0))
        return;
    for (size_t i = 0;
         i < RMAP_COUNT(section) && reader->status == RMAP_OK && !reader->has_bad_rule; i++)
        section[i](reader);
}

static enum rmap_status parse_text(struct rmap_reader *reader)
{
    return rmap_yaml_parse(reader->bundle->text, reader->bundle->text_nbytes, &reader->own,
                           reader->diagnostics, reader->err);
}

/* The tree as it was kept of an earlier reading, or else kept for later. That it cannot be is no
 * failure. */
static enum rmap_status parse_kept(struct rmap_reader *reader)
{
    const struct rmap_bundle *bundle = reader->bundle;
    struct rmap_kept kept = {0};
    struct rmap_error note = {0};
    uint8_t *bytes = NULL;
    const uint8_t *body = NULL;
    size_t nbytes = 0;
    enum rmap_status st = RMAP_OK,
                     found = rmap_kept_init(&kept, bundle->options.cache, bundle->path, "scene",
                                            ".scene", bundle->text, bundle->text_nbytes, &note);
    if (found == RMAP_OK)
        found = rmap_kept_read(&kept, &bytes, &body, &nbytes, &note);
    if (bytes)
        found = rmap_yaml_unpack(body, nbytes, &reader->own, &note);
    rmap_free(bytes);
    bytes = NULL;
    if (reader->own)
        goto out;
    RMAP_TRY(parse_text(reader));
    if (found != RMAP_SYSTEM && reader->diagnostics->n == 0 &&
        rmap_yaml_pack(reader->own, &bytes, &nbytes, &note) == RMAP_OK)
        found = rmap_kept_write(&kept, bytes, nbytes, &note);
    if (note.status != RMAP_OK && kept.path) /* a pipe has no place */
        rmap_reader_warn(reader, reader->own, "%s; the scene's own text is read", note.text);
out:
    rmap_free(bytes);
    rmap_kept_fini(&kept);
    return st;
}

/* Read as it is where nothing is put into it while it is read. */
static enum rmap_status take_tree(struct rmap_reader *reader)
{
    const struct rmap_scene_options *options = &reader->bundle->options;
    if (options->n_set > 0 || options->simulation || rmap_yaml_get(options->root, "attributes"))
        return rmap_yaml_duplicate(options->root, &reader->own, reader->err);
    reader->root = options->root;
    return RMAP_OK;
}

static enum rmap_status parse(struct rmap_reader *reader)
{
    const struct rmap_scene_options *options = &reader->bundle->options;
    enum rmap_status st =
        rmap_scene_include_files(reader->bundle, reader->diagnostics, reader->err);
    if (st != RMAP_OK ||
        reader->diagnostics->n_error > 0) /* half a scene has mistakes without end */
        return st;
    /* What includes files is read with them. */
    const bool alone = !strstr(reader->bundle->text, RMAP_INCLUDE_MARK);
    if (options->root && alone && !rmap_yaml_get(options->root, "include"))
        st = take_tree(reader);
    else if (rmap_bundle_is_kept(reader->bundle) && alone &&
             reader->bundle->text_nbytes >= RMAP_KEPT_LEAST)
        st = parse_kept(reader);
    else
        st = parse_text(reader);
    if (st == RMAP_INPUT) /* reported in the diagnostics */
        return RMAP_OK;
    if (reader->own)
        reader->root = reader->own;
    if (st == RMAP_OK)
        st = rmap_reader_set_simulation(reader);
    for (size_t i = 0; st == RMAP_OK && i < options->n_set; i++)
        st = rmap_yaml_edit(reader->own, options->set[i], -(int)(i + 1), reader->diagnostics,
                            reader->err);
    return st;
}

static void fini(struct rmap_reader *reader)
{
    rmap_yaml_destroy(reader->own);
    rmap_names_fini(&reader->media);
    rmap_names_fini(&reader->films);
    rmap_names_fini(&reader->surfaces);
    rmap_names_fini(&reader->geometries);
    rmap_names_fini(&reader->members);
    rmap_names_fini(&reader->meshes);
    rmap_names_fini(&reader->grids);
    rmap_free(reader->entry);
    rmap_free(reader->placed);
    rmap_free(reader->mesh_part);
    rmap_free(reader->rule);
    rmap_free(reader->frame);
    rmap_free(reader->sky);
    rmap_reader_release(reader);
}

static enum rmap_status outcome(struct rmap_reader *reader)
{
    size_t n = reader->diagnostics->n_error;
    const char *path = reader->bundle->path ? reader->bundle->path : "scene";
    if (reader->status != RMAP_OK)
        return reader->status;
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
static void name_bundled(struct rmap_reader *reader)
{
    const struct rmap_bundle *bundle = reader->bundle;
    for (size_t i = 0; i < bundle->n_mesh; i++)
        rmap_reader_add_name(reader, &reader->meshes, bundle->mesh[i].geometry, 0, (int32_t)i, 0);
    for (size_t i = 0; i < bundle->n_grid; i++)
        rmap_reader_add_name(reader, &reader->grids, bundle->grid[i].field, 0, (int32_t)i, 0);
}

/* What only the whole scene shows goes to the diagnostics as well. */
static void finish(struct rmap_reader *reader)
{
    reader->scene->totals_on_demand = reader->bundle->options.surface != NULL;
    struct rmap_boxes boxes = {0};
    rmap_boxes_find(reader, &boxes);
    reader->scene->before = reader->bundle->options.before_scene;
    enum rmap_status st = rmap_scene_finish(reader->scene, &reader->failure);
    reader->scene->before = NULL;
    rmap_boxes_keep(reader, st, &boxes);
    if (st == RMAP_INPUT)
        rmap_reader_error(reader, NULL, "%s", reader->failure.text);
    else if (st != RMAP_OK)
        rmap_reader_fail(reader, st);
    /* Scenes from maps, and from other ranks, were looked at where they came from. */
    if (st != RMAP_OK || reader->bundle->meshes_complete)
        return;
    rmap_reader_check_worth(reader);
    if (reader->scene->n_gradient) {
        rmap_reader_probe_gradients(reader);
        rmap_reader_probe_sag(reader);
    }
}

static enum rmap_status read_scene(struct rmap_reader *reader)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_scene_create(&reader->scene, reader->err));
    RMAP_TRY(parse(reader));
    name_bundled(reader);
    if (reader->root)
        read_sections(reader);
    RMAP_TRY(outcome(reader));
    if (reader->receivers) /* whatever is wrong from here on is theirs */
        reader->diagnostics = reader->receivers->diagnostics;
    finish(reader);
    st = outcome(reader);
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
    bundle->options.root = NULL; /* borrowed until here */
    bundle->options.before = NULL;
    bundle->options.before_scene = NULL;
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
