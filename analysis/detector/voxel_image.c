/* SPDX-License-Identifier: MIT
 *
 * Fluence rate and absorbed power per volume in the voxels of a box.
 */
#include "analysis/detector/voxel_image.h"

#include <math.h>
#include <string.h>

#include "analysis/table/csv_field.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

static void name_parts(struct rmap_voxel_image *image)
{
#define PARTS(flux, area, volume, way)                                                             \
    {                                                                                              \
        {"fluence_rate", area, "fluence rate: flux times length of way over the volume",           \
         .total_unit = way},                                                                       \
            {"absorbed", volume, "absorbed in media, over the volume", .total_unit = flux},        \
        {                                                                                          \
            "absorbed_on_surfaces", volume, "absorbed on surfaces in the voxel, over its volume",  \
                .total_unit = flux                                                                 \
        }                                                                                          \
    }
    static const struct rmap_voxel_part name[][RMAP_VOXEL_PARTS] = {
        [RMAP_FLUX_W] = PARTS("W", "W/m2", "W/m3", "W m"),
        [RMAP_FLUX_LM] = PARTS("lm", "lm/m2", "lm/m3", "lm m"),
        [RMAP_FLUX_PHOTON_RATE] =
            PARTS("photons/s", "photons/(s m2)", "photons/(s m3)", "photons m/s"),
        [RMAP_FLUX_PHOTONS] = PARTS("photons", "photons/m2", "photons/m3", "photons m"),
        [RMAP_FLUX_J] = PARTS("J", "J/m2", "J/m3", "J m")};
#undef PARTS
    memcpy(image->part, name[image->scene->flux_unit], sizeof image->part);
}

static void fill(const struct rmap_voxel_sums *sums, const struct rmap_voxel_image *image, int what,
                 struct rmap_voxel_part *part)
{
    const struct rmap_voxel_grid *grid = &image->grid;
    const size_t n = rmap_voxel_grid_n(grid);
    const double m = image->scene->unit_m;
    const double volume = grid->step[0] * grid->step[1] * grid->step[2] * m * m * m;
    const double unit = what == RMAP_VOXEL_PASSING ? grid->diagonal * m : 1.0;
    for (size_t c = 0; c <= n; c++) {
        double flux, error;
        rmap_cell_sums_flux(&sums->part[what], sums->ask->map, c, &flux, &error);
        if (c == n) {
            part->total = flux * unit;
            part->total_error = error * unit;
            break;
        }
        part->value[c] = flux * unit / volume;
        part->standard_error[c] = error * unit / volume;
        if (part->value[c] > part->peak) {
            part->peak = part->value[c];
            part->peak_voxel = c;
        }
    }
    part->mean = part->total / (volume * (double)n);
    part->mean_error = part->total_error / (volume * (double)n);
}

enum rmap_status rmap_voxel_image_create(const struct rmap_voxel_sums *sums,
                                         struct rmap_voxel_image **image_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = rmap_voxel_grid_n(&sums->ask->grid);
    struct rmap_voxel_image *image = rmap_alloc(1, sizeof *image);
    if (!image)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for voxels");
    image->scene = rmap_map_scene(sums->ask->map);
    image->grid = sums->ask->grid;
    name_parts(image);
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++) {
        struct rmap_voxel_part *part = &image->part[k];
        part->value = rmap_alloc(n, sizeof *part->value);
        part->standard_error = rmap_alloc(n, sizeof *part->standard_error);
        if (!part->value || !part->standard_error)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu voxels", n));
        fill(sums, image, k, part);
    }
    *image_ret = image;
    image = NULL;
out:
    rmap_voxel_image_destroy(image);
    return st;
}

void rmap_voxel_image_destroy(struct rmap_voxel_image *image)
{
    for (int k = 0; image && k < RMAP_VOXEL_PARTS; k++) {
        rmap_free(image->part[k].value);
        rmap_free(image->part[k].standard_error);
    }
    rmap_free(image);
}

static void indices(const struct rmap_voxel_grid *grid, size_t voxel, uint32_t at[3])
{
    at[0] = (uint32_t)(voxel % grid->n[0]);
    at[1] = (uint32_t)(voxel / grid->n[0] % grid->n[1]);
    at[2] = (uint32_t)(voxel / grid->n[0] / grid->n[1]);
}

static struct rmap_vec3 centre_of(const struct rmap_voxel_image *image, size_t voxel)
{
    const struct rmap_voxel_grid *grid = &image->grid;
    uint32_t at[3];
    indices(grid, voxel, at);
    return rmap_vec3(grid->low[0] + (at[0] + 0.5) * grid->step[0],
                     grid->low[1] + (at[1] + 0.5) * grid->step[1],
                     grid->low[2] + (at[2] + 0.5) * grid->step[2]);
}

/* ---- a slice ---- */

static struct rmap_vec3 unit_vector(int axis)
{
    return rmap_vec3(axis == 0, axis == 1, axis == 2);
}

/* The plane of the layer, and the picture's axes in it. */
static void lay_plane(const struct rmap_voxel_grid *grid, int axis, uint32_t layer,
                      struct rmap_voxel_slice *slice)
{
    const int across[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    double middle[3];
    for (int k = 0; k < 3; k++)
        middle[k] = k == axis ? grid->low[k] + (layer + 0.5) * grid->step[k]
                              : 0.5 * (grid->low[k] + grid->high[k]);
    struct rmap_detector_bins *bins = &slice->image.bins;
    slice->detector.origin = rmap_vec3(middle[0], middle[1], middle[2]);
    slice->detector.x = unit_vector(across[0]);
    slice->detector.y = unit_vector(across[1]);
    slice->detector.axis = rmap_cross(slice->detector.x, slice->detector.y);
    *bins = (struct rmap_detector_bins){.detector = &slice->detector, .cosine = 1.0};
    for (int k = 0; k < 2; k++) {
        slice->detector.size[k] = grid->high[across[k]] - grid->low[across[k]];
        bins->high[k] = 0.5 * slice->detector.size[k];
        bins->low[k] = -bins->high[k];
        bins->n[k] = slice->image.n[k] = grid->n[across[k]];
    }
}

enum rmap_status rmap_voxel_slice_init(const struct rmap_voxel_image *image,
                                       enum rmap_voxel_what what, int axis, uint32_t layer,
                                       struct rmap_voxel_slice *slice, struct rmap_error *err)
{
    static const char *const title[RMAP_VOXEL_PARTS] = {"fluence rate", "absorbed in media",
                                                        "absorbed on surfaces"};
    const struct rmap_voxel_grid *grid = &image->grid;
    const struct rmap_voxel_part *part = &image->part[what];
    *slice = (struct rmap_voxel_slice){.detector = {.type = RMAP_DETECTOR_PLANE}};
    struct rmap_detector_image *flat = &slice->image;
    lay_plane(grid, axis, layer, slice);
    const double where = grid->low[axis] + (layer + 0.5) * grid->step[axis];
    static const char name[] = "xyz";
    (void)snprintf(slice->name, sizeof slice->name, "%c = %.6g %.20s", name[axis], where,
                   image->scene->unit);
    slice->detector.name = slice->name;
    flat->scene = image->scene;
    flat->detector = &slice->detector;
    flat->world = true;
    flat->quantity = title[what];
    flat->unit = part->unit;
    const size_t n = (size_t)flat->n[0] * flat->n[1];
    flat->value = rmap_alloc(n, sizeof *flat->value);
    flat->standard_error = rmap_alloc(n, sizeof *flat->standard_error);
    if (!flat->value || !flat->standard_error) {
        rmap_voxel_slice_fini(slice);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    }
    for (size_t c = 0, to = 0; c < rmap_voxel_grid_n(grid); c++) {
        uint32_t at[3];
        indices(grid, c, at);
        if (at[axis] != layer)
            continue;
        flat->value[to] = part->value[c];
        flat->standard_error[to++] = part->standard_error[c];
        flat->peak = fmax(flat->peak, part->value[c]);
    }
    return RMAP_OK;
}

void rmap_voxel_slice_fini(struct rmap_voxel_slice *slice)
{
    rmap_free(slice->image.value);
    rmap_free(slice->image.standard_error);
    *slice = (struct rmap_voxel_slice){.name = ""};
}

/* ---- text ---- */

static const char *asked(const struct rmap_voxel_image *image)
{
    return image->criterion ? image->criterion : "all";
}

void rmap_voxel_image_csv(const struct rmap_voxel_image *image, FILE *out)
{
    const struct rmap_voxel_grid *grid = &image->grid;
    fprintf(out, "# criterion: %s\n# length unit: %s\n", asked(image), image->scene->unit);
    for (int p = 0; p < RMAP_VOXEL_PARTS; p++)
        fprintf(out, "# %s: %s, %s\n", image->part[p].name, image->part[p].description,
                image->part[p].unit);
    fputs("i,j,k,x,y,z", out);
    for (int p = 0; p < RMAP_VOXEL_PARTS; p++)
        fprintf(out, ",%s,%s_error", image->part[p].name, image->part[p].name);
    fputc('\n', out);
    for (size_t c = 0; c < rmap_voxel_grid_n(grid); c++) {
        uint32_t at[3];
        const struct rmap_vec3 p = centre_of(image, c);
        indices(grid, c, at);
        fprintf(out, "%u,%u,%u,%.10g,%.10g,%.10g", at[0], at[1], at[2], p.x, p.y, p.z);
        for (int k = 0; k < RMAP_VOXEL_PARTS; k++)
            rmap_csv_put_estimate(image->part[k].value[c], image->part[k].standard_error[c], out);
        fputc('\n', out);
    }
}

void rmap_voxel_image_print(const struct rmap_voxel_image *image, FILE *out)
{
    static const char *const label[RMAP_VOXEL_PARTS] = {"fluence rate", "absorbed", "on surfaces"};
    const struct rmap_voxel_grid *grid = &image->grid;
    fprintf(out, "%-14s %u x %u x %u, each %.6g x %.6g x %.6g %s\n", "voxels", grid->n[0],
            grid->n[1], grid->n[2], grid->step[0], grid->step[1], grid->step[2],
            image->scene->unit);
    fprintf(out, "%-14s %.6g..%.6g, %.6g..%.6g, %.6g..%.6g %s\n", "region", grid->low[0],
            grid->high[0], grid->low[1], grid->high[1], grid->low[2], grid->high[2],
            image->scene->unit);
    fprintf(out, "%-14s %s\n", "rays", asked(image));
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++) {
        const struct rmap_voxel_part *part = &image->part[k];
        if (k == RMAP_VOXEL_PASSING)
            fprintf(out, "%-14s mean %.6g +- %.2g %s", label[k], part->mean, part->mean_error,
                    part->unit);
        else
            fprintf(out, "%-14s %.6g +- %.2g %s", label[k], part->total, part->total_error,
                    part->total_unit);
        if (part->peak > 0.0) {
            const struct rmap_vec3 p = centre_of(image, part->peak_voxel);
            fprintf(out, ", peak %.5g +- %.2g %s at (%.6g, %.6g, %.6g)", part->peak,
                    part->standard_error[part->peak_voxel], part->unit, p.x, p.y, p.z);
        }
        fputc('\n', out);
    }
}

static json_t *estimate(double value, double error)
{
    return json_pack("{s:o, s:o}", "value", rmap_json_number(value), "standard_error",
                     rmap_json_number(error));
}

static json_t *part_json(const struct rmap_voxel_image *image, const struct rmap_voxel_part *part)
{
    json_t *peak = json_null();
    if (part->peak > 0.0) {
        const struct rmap_vec3 p = centre_of(image, part->peak_voxel);
        uint32_t at[3];
        indices(&image->grid, part->peak_voxel, at);
        peak =
            json_pack("{s:o, s:o, s:[f, f, f], s:[i, i, i]}", "value", rmap_json_number(part->peak),
                      "standard_error", rmap_json_number(part->standard_error[part->peak_voxel]),
                      "at", p.x, p.y, p.z, "voxel", (int)at[0], (int)at[1], (int)at[2]);
    }
    return json_pack("{s:s, s:o, s:o, s:s, s:o}", "unit", part->unit, "mean",
                     estimate(part->mean, part->mean_error), "total",
                     estimate(part->total, part->total_error), "total_unit", part->total_unit,
                     "peak", peak);
}

json_t *rmap_voxel_image_json(const struct rmap_voxel_image *image)
{
    const struct rmap_voxel_grid *grid = &image->grid;
    json_t *document =
        json_pack("{s:s, s:[i, i, i], s:{s:[f, f, f], s:[f, f, f], s:s}}", "criterion",
                  asked(image), "cells", (int)grid->n[0], (int)grid->n[1], (int)grid->n[2],
                  "region", "low", grid->low[0], grid->low[1], grid->low[2], "high", grid->high[0],
                  grid->high[1], grid->high[2], "unit", image->scene->unit);
    for (int k = 0; document && k < RMAP_VOXEL_PARTS; k++)
        (void)json_object_set_new(document, image->part[k].name, part_json(image, &image->part[k]));
    return document;
}
