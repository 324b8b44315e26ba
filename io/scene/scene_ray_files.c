/* SPDX-License-Identifier: MIT
 *
 * Sources whose rays stand in files. The bundle carries the rays, so that maps need no file.
 */
#include "io/scene/scene_ray_files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "io/rays/ray_file.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_placement.h"

static struct rmap_file_rays *in_bundle(const struct rmap_bundle *bundle, const char *name)
{
    for (size_t i = 0; i < bundle->n_ray_set; i++)
        if (strcmp(bundle->ray_set[i].name, name) == 0)
            return bundle->ray_set[i].set;
    return NULL;
}

/* Its name says so, or its format. */
static bool is_map(const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *format = rmap_yaml_get(node, "format");
    const char *name = rmap_yaml_get(node, "file")->text;
    size_t n = strlen(name);
    while (n > 0 && name[n - 1] == '/')
        n--;
    return format ? format->text && strcmp(format->text, "raymap") == 0
                  : n > 7 && strncasecmp(name + n - 7, ".raymap", 7) == 0;
}

static bool format_of(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool steps,
                      enum rmap_ray_format *format)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "file");
    int choice = -1;
    if (rmap_yaml_get(node, "format")) {
        const bool good = rmap_reader_choice(
            reader, node, "format", RMAP_OPTIONAL,
            steps ? "csv hdf5 mcpl" : "tm25 lighttools csv hdf5 mcpl raymap", &choice);
        *format = (enum rmap_ray_format)(choice + (steps ? (int)RMAP_RAYS_CSV : 0));
        return good && choice >= 0;
    }
    if (rmap_ray_format_of(at->text, format) && !(steps && *format < RMAP_RAYS_CSV))
        return true;
    rmap_reader_error(
        reader, at,
        "'%.100s' is no file of %s by its name: they end in %s.csv, .h5, .mcpl; or say "
        "'format'",
        at->text, steps ? "steps" : "rays", steps ? "" : ".tm25ray, .ray, .raymap, ");
    return false;
}

/* The rays of a file, or of a map. */
static enum rmap_status read_set(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                 const char *path, struct rmap_ray_wanted *wanted,
                                 const char *where, struct rmap_file_rays **set)
{
    enum rmap_ray_format format;
    rmap_map_rays_reader *const read_map = reader->bundle->options.read_map;
    const bool map = !wanted->steps && is_map(node);
    if (map && !read_map)
        return rmap_error_set(&reader->failure, RMAP_INPUT,
                              "%.100s: maps are not read here: write its rays to a file, raymap "
                              "query MAP -o rays.h5",
                              path);
    if (!map && !format_of(reader, node, wanted->steps, &format))
        return RMAP_INPUT;
    if (!map && (where || (wanted->detector && format != RMAP_RAYS_HDF5))) {
        rmap_reader_error(reader, rmap_yaml_get(node, where ? "where" : "detector"), "%s",
                          where ? "'where' is for a map: pick the rays of a file with raymap query"
                                : "'detector' is for a map, or a file .h5 that a query wrote");
        return RMAP_INPUT;
    }
    if (!map)
        return rmap_ray_file_read(path, format, wanted, set, &reader->failure);
    const enum rmap_status st = read_map(path, wanted->detector, where, set, &reader->failure);
    if (st == RMAP_OK || st == RMAP_SYSTEM)
        return st;
    reader->failure.text[strcspn(reader->failure.text, "\n")] = 0; /* no caret under a criterion */
    return RMAP_INPUT;
}

/* Puts the rays into the bundle. */
static struct rmap_file_rays *load(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                   const char *name, const char *detector, const char *where,
                                   bool steps)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "file");
    struct rmap_ray_wanted wanted = {.detector = detector, .steps = steps};
    struct rmap_file_rays *set = NULL;
    const char *path = rmap_reader_path(reader, at->text);
    if (!path)
        return NULL;
    const size_t before = reader->diagnostics->n_error;
    enum rmap_status st = read_set(reader, node, path, &wanted, where, &set);
    if (st != RMAP_OK && reader->diagnostics->n_error > before)
        return NULL; /* it is told */
    if (st == RMAP_OK) {
        st = rmap_bundle_add_ray_set(reader->bundle, name, set, &reader->failure);
        if (st != RMAP_OK)
            rmap_file_rays_drop(set);
    }
    rmap_reader_made(reader, at, st);
    if (st == RMAP_OK && wanted.n_passed_over > 0)
        rmap_reader_warn(reader, at, "%zu particles that are no photons are left out",
                         wanted.n_passed_over);
    return st == RMAP_OK ? set : NULL;
}

struct rmap_file_rays *rmap_reader_file_rays(struct rmap_reader *reader,
                                             const struct rmap_yaml_node *node, bool steps)
{
    const char *file = rmap_reader_text(reader, node, "file", RMAP_REQUIRED);
    const char *detector = rmap_reader_text(reader, node, "detector", RMAP_OPTIONAL);
    const char *where = steps ? NULL : rmap_reader_text(reader, node, "where", RMAP_OPTIONAL);
    if (!file)
        return NULL;
    /* The same file may be asked for rays and for steps. */
    const char *part = steps ? "#" : detector;
    const size_t nbytes =
        strlen(file) + (part ? strlen(part) : 0) + (where ? strlen(where) : 0) + 3;
    char *name = rmap_reader_alloc(reader, nbytes, 1);
    if (!name)
        return NULL;
    (void)snprintf(name, nbytes, "%s%s%s%s%s", file, part ? "#" : "", part ? part : "",
                   where ? "#" : "", where ? where : "");
    struct rmap_file_rays *set = in_bundle(reader->bundle, name);
    if (!set && !reader->bundle->meshes_complete)
        return load(reader, node, name, detector, where, steps);
    if (!set)
        rmap_reader_error(reader, rmap_yaml_get(node, "file"),
                          "the rays of '%.100s' are not stored with the scene", file);
    return set;
}

/* All of the file's wavelengths are in the bands of the scene's, or it is told which are not. */
static void check_wavelengths(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                              const struct rmap_file_rays *set)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    if (channels->mode != RMAP_COLOUR_SPECTRAL || isnan(set->least_nm))
        return;
    const double *nm = channels->wavelength_nm;
    const int last = channels->n - 1;
    const double below = last > 0 ? 0.5 * (nm[1] - nm[0]) : 1e-6 * nm[0],
                 above = last > 0 ? 0.5 * (nm[last] - nm[last - 1]) : below;
    if (set->least_nm < nm[0] - below || set->greatest_nm > nm[last] + above)
        rmap_reader_error(reader, at,
                          "its rays have wavelengths from %g to %g nm, and the scene has %g to %g "
                          "nm: add theirs to 'wavelengths' of 'spectrum'",
                          set->least_nm, set->greatest_nm, nm[0], nm[last]);
}

void rmap_reader_read_ray_file(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_source *source, struct rmap_source_light *light)
{
    const struct rmap_written_unit *unit = rmap_reader_length_unit(reader, node, "unit");
    const bool placed = rmap_reader_placement(reader, node, &source->frame);
    struct rmap_file_rays *set = rmap_reader_file_rays(reader, node, false);
    source->type = RMAP_SOURCE_RAYS;
    if (!set)
        return;
    source->rays = rmap_file_rays_hold(set);
    check_wavelengths(reader, rmap_yaml_get(node, "file"), set);
    const double unit_m = unit ? unit->size : set->unit_m,
                 times = unit_m > 0.0 ? unit_m / reader->scene->unit_m : 1.0;
    for (int i = 0; placed && i < 3; i++)
        for (int j = 0; j < 3; j++)
            source->frame.m[i][j] *= times;
    if (!rmap_yaml_get(node, "flux") && set->flux > 0.0) {
        light->flux = set->flux;
        light->unit = set->flux_unit;
        light->bare = false;
    }
}
