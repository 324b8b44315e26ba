/* SPDX-License-Identifier: MIT
 *
 * What an index says of the scene: its text and meshes, the names of what columns count, and its
 * light.
 */
#include "io/write/index_scene.h"

#include <string.h>

#include "base/alloc.h"
#include "io/hdf5/h5_write.h"
#include "io/map/provenance.h"

static const struct rmap_h5_unit one = {"1", 1.0, {0}};

static enum rmap_status write_bundle(struct rmap_h5 *h5, const struct rmap_bundle *bundle,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    RMAP_TRY(rmap_scene_pack(bundle, &blob, &nbytes, err));
    RMAP_TRY(rmap_h5_group(h5, "/scene", err));
    const char *text = bundle->text ? bundle->text : "";
    RMAP_TRY(rmap_h5_write_names(h5, "/scene/text", &text, 1, "the scene file", err));
    struct rmap_h5_array array = {
        "/scene/bundle", RMAP_U8, 1,
        {nbytes},        one,     "scene text, choices and meshes as the program packs them"};
    RMAP_TRY(rmap_h5_write(h5, &array, blob, err));
out:
    rmap_free(blob);
    return st;
}

const char *rmap_name_of(const struct rmap_name_list *list, size_t i)
{
    const char *name = NULL;
    memcpy(&name, (const char *)list->first + i * list->struct_nbytes + list->name_offset,
           sizeof name);
    return name;
}

static enum rmap_status write_name_list(struct rmap_h5 *h5, const struct rmap_name_list *list,
                                        struct rmap_error *err)
{
    const char **name = rmap_alloc(list->n, sizeof *name);
    if (!name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    for (size_t i = 0; i < list->n; i++)
        name[i] = rmap_name_of(list, i);
    enum rmap_status st =
        rmap_h5_write_names(h5, list->path, name, list->n, list->description, err);
    rmap_free(name);
    return st;
}

void rmap_index_name_lists(const struct rmap_scene *scene,
                           struct rmap_name_list list[RMAP_NAME_LISTS])
{
#define LIST(member, text)                                                                         \
    {                                                                                              \
        "/name/" #member, text, scene->member, scene->n_##member, sizeof *scene->member,           \
            offsetof(struct rmap_##member, name)                                                   \
    }
    const struct rmap_name_list all[RMAP_NAME_LISTS] = {
        LIST(source, "names of sources; /ray/source counts them"),
        LIST(object, "names of objects; /segment/object counts them"),
        LIST(group, "names of groups of objects"),
        LIST(surface, "names of optical surfaces"),
        LIST(medium, "names of media; /segment/medium counts them"),
        LIST(detector, "names of detectors; /registration/detector counts them"),
        LIST(geometry, "names of unique geometries"),
    };
#undef LIST
    memcpy(list, all, sizeof all);
}

struct rmap_field_table rmap_index_object_fields(void)
{
    static const struct rmap_h5_field field[] = {
        {"/name/object_id", RMAP_U64, 1, offsetof(struct rmap_object, id), "stable id of objects"},
        {"/name/object_group", RMAP_I32, 1, offsetof(struct rmap_object, parent),
         "group that holds an object, as a row of /name/group; -1: none"},
        {"/name/object_geometry", RMAP_I32, 1, offsetof(struct rmap_object, geometry),
         "geometry of an object, as a row of /name/geometry"},
    };
    return (struct rmap_field_table){field, sizeof field / sizeof *field};
}

struct rmap_field_table rmap_index_group_fields(void)
{
    static const struct rmap_h5_field field[] = {
        {"/name/group_id", RMAP_U64, 1, offsetof(struct rmap_group, id), "stable id of groups"},
        {"/name/group_group", RMAP_I32, 1, offsetof(struct rmap_group, parent),
         "group that holds a group; -1: none"},
    };
    return (struct rmap_field_table){field, sizeof field / sizeof *field};
}

static enum rmap_status write_names(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_field_table object = rmap_index_object_fields(),
                                  group = rmap_index_group_fields();
    struct rmap_name_list list[RMAP_NAME_LISTS];
    rmap_index_name_lists(scene, list);
    RMAP_TRY(rmap_h5_group(h5, "/name", err));
    for (size_t i = 0; i < RMAP_NAME_LISTS; i++)
        RMAP_TRY(write_name_list(h5, &list[i], err));
    RMAP_TRY(rmap_h5_write_fields(h5, object.field, object.n, scene->object, scene->n_object,
                                  sizeof *scene->object, err));
    RMAP_TRY(rmap_h5_write_fields(h5, group.field, group.n, scene->group, scene->n_group,
                                  sizeof *scene->group, err));
out:
    return st;
}

static enum rmap_status write_light(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                    const double *emitted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = scene->n_source, n_channel = (size_t)scene->channels.n;
    const struct rmap_h5_unit nm = {"nm", 1e-9, {1}};
    const struct rmap_h5_unit flux_unit[] = {
        [RMAP_FLUX_W] = {"W", 1.0, {2, 1, -3}},
        [RMAP_FLUX_LM] = {"lm", 1.0, {[6] = 1}},
        [RMAP_FLUX_PHOTON_RATE] = {"photons/s", 1.0, {[2] = -1}},
        [RMAP_FLUX_PHOTONS] = {"photons", 1.0, {0}},
        [RMAP_FLUX_J] = {"J", 1.0, {2, 1, -2}}};
    double *flux = rmap_alloc(n, sizeof *flux);
    double *colour = rmap_alloc(n * n_channel, sizeof *colour);
    if (!flux || !colour) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sources");
        goto out;
    }
    for (size_t s = 0; s < n; s++) {
        flux[s] = scene->source[s].flux;
        memcpy(colour + s * n_channel, scene->source[s].colour, n_channel * sizeof *colour);
    }
    const struct rmap_h5_array array[] = {
        {"/channel/wavelength", RMAP_F64, 1, {n_channel}, nm, "vacuum wavelength of each channel"},
        {"/source/flux", RMAP_F64, 1, {n}, flux_unit[scene->flux_unit], "flux of each source"},
        {"/source/emitted",
         RMAP_F64,
         1,
         {n},
         one,
         "rays that each source's flux is shared out over: those in the map, or in the map whose "
         "rays these were picked from"},
        {"/source/colour", RMAP_F64, 2, {n, n_channel}, one, "share of the flux per channel"},
    };
    RMAP_TRY(rmap_h5_group(h5, "/channel", err));
    RMAP_TRY(rmap_h5_group(h5, "/source", err));
    RMAP_TRY(rmap_h5_write(h5, &array[0], scene->channels.wavelength_nm, err));
    RMAP_TRY(rmap_h5_write(h5, &array[1], flux, err));
    RMAP_TRY(rmap_h5_write(h5, &array[2], emitted, err));
    RMAP_TRY(rmap_h5_write(h5, &array[3], colour, err));
out:
    rmap_free(flux);
    rmap_free(colour);
    return st;
}

enum rmap_status rmap_index_scene_write(struct rmap_h5 *h5, const struct rmap_run *run,
                                        const double *emitted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(write_bundle(h5, run->bundle, err));
    RMAP_TRY(write_names(h5, run->scene, err));
    RMAP_TRY(write_light(h5, run->scene, emitted, err));
out:
    return st;
}
