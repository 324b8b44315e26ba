/* SPDX-License-Identifier: MIT */
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "analysis/paths/path_key.h"
#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

/* Cells of a page's image along each side, at most; more are averaged. */
enum { MOST_CELLS = 256 };

/* Solid angle or area of a cell, relative. */
static double weight_of(const struct rmap_detector_image *image, uint32_t i)
{
    if (image->detector->type != RMAP_DETECTOR_INTENSITY)
        return 1.0;
    return cos(RMAP_PI * i / image->n[0]) - cos(RMAP_PI * (i + 1.0) / image->n[0]);
}

static double mean_of(const struct rmap_detector_image *image, uint32_t i0, uint32_t j0,
                      uint32_t step)
{
    double sum = 0.0, weight = 0.0;
    for (uint32_t j = j0; j < j0 + step && j < image->n[1]; j++)
        for (uint32_t i = i0; i < i0 + step && i < image->n[0]; i++) {
            double w = weight_of(image, i);
            sum += w * image->value[(size_t)j * image->n[0] + i];
            weight += w;
        }
    return sum / weight;
}

/* Values as parts of the largest, in 65535ths; what is not 0 stays so. */
static json_t *levels(const double *value, size_t n, double most)
{
    uint16_t *level = rmap_alloc(n + 1, sizeof *level);
    for (size_t i = 0; level && i < n; i++)
        level[i] = (uint16_t)(most > 0.0 ? ceil(65535.0 * fmin(value[i] / most, 1.0)) : 0.0);
    json_t *json = level ? rmap_page_shorts(level, n) : NULL;
    rmap_free(level);
    return json;
}

/* step: cells that were averaged, along each side; most: the largest value in the picture. */
static json_t *image_json(const struct rmap_detector_image *image)
{
    uint32_t side = image->n[0] > image->n[1] ? image->n[0] : image->n[1];
    uint32_t step = (side + MOST_CELLS - 1) / MOST_CELLS;
    uint32_t nx = (image->n[0] + step - 1) / step, ny = (image->n[1] + step - 1) / step;
    double *value = rmap_alloc((size_t)nx * ny, sizeof *value), most = 0.0;
    if (!value)
        return NULL;
    for (uint32_t j = 0; j < ny; j++)
        for (uint32_t i = 0; i < nx; i++) {
            double mean = mean_of(image, i * step, j * step, step);
            value[(size_t)j * nx + i] = mean;
            most = fmax(most, mean);
        }
    json_t *json = json_pack(
        "{s:[i, i], s:[i, i], s:i, s:o, s:o, s:s, s:s, s:o, s:o, s:o, s:o}", "n", (int)nx, (int)ny,
        "cells", (int)image->n[0], (int)image->n[1], "step", (int)step, "most",
        rmap_json_number(most), "level", levels(value, (size_t)nx * ny, most), "quantity",
        image->quantity, "unit", image->unit, "flux", rmap_json_number(image->flux), "flux_error",
        rmap_json_number(image->flux_error), "peak", rmap_json_number(image->peak), "registrations",
        rmap_json_number(image->registrations));
    rmap_free(value);
    return json;
}

static json_t *vector(struct rmap_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

/* As a criterion wants it. */
static json_t *quoted_name(const struct rmap_detector *detector, struct rmap_error *err)
{
    char *text = NULL;
    if (rmap_path_quote(detector->name, &text, err) != RMAP_OK)
        return NULL;
    json_t *json = rmap_page_string(text);
    rmap_free(text);
    return json;
}

static json_t *detector_json(const struct rmap_page *page, const struct rmap_detector *detector,
                             struct rmap_error *err)
{
    const struct rmap_detector_image *image = NULL;
    for (size_t i = 0; i < page->n_image && !image; i++)
        if (page->image[i] && page->image[i]->detector == detector)
            image = page->image[i];
    return json_pack("{s:o, s:o, s:s, s:o, s:o, s:o, s:o, s:[f, f], s:b, s:o}", "name",
                     rmap_page_string(detector->name), "word", quoted_name(detector, err), "type",
                     detector->type == RMAP_DETECTOR_INTENSITY ? "intensity" : "plane", "origin",
                     vector(detector->origin), "x", vector(detector->x), "y", vector(detector->y),
                     "axis", vector(detector->axis), "size", detector->size[0], detector->size[1],
                     "after_step", (int)(detector->on_object >= 0 || detector->on_group >= 0),
                     "image", image ? image_json(image) : json_null());
}

json_t *rmap_page_detectors(const struct rmap_page *page, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_scene_with(page->map, page->overlay);
    struct rmap_colour_map map;
    json_t *list = json_array(), *json = NULL;
    bool whole = list != NULL;
    for (size_t d = 0; d < scene->n_detector && whole; d++)
        whole = json_array_append_new(list, detector_json(page, &scene->detector[d], err)) == 0;
    rmap_colour_map_init(&map);
    if (whole)
        json = json_pack("{s:o, s:o}", "list", list, "scale",
                         rmap_page_bytes(map.rgb[0], sizeof map.rgb));
    else
        json_decref(list);
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the detectors of a page");
    return json;
}
