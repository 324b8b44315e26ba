/* SPDX-License-Identifier: MIT
 *
 * The parts of a page's data.
 */
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/path_order.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "analysis/paths/path_class.h"
#include "analysis/paths/path_key.h"
#include "analysis/paths/path_text.h"
#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

/* Length of sequences; the text of a longer one is cut. */
enum { MOST_SEQUENCE = 200 };

struct named {
    const char *text;
    int32_t row;
};

/* The report's classes by their texts, "lamp: T@lens.1 ...". */
struct names {
    char **text;          /* [n], as the report's rows */
    struct named *sorted; /* [n] */
    size_t n;
};

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const struct named *)a)->text, ((const struct named *)b)->text);
}

static void names_fini(struct names *names)
{
    for (size_t i = 0; names->text && i < names->n; i++)
        rmap_free(names->text[i]);
    rmap_free(names->text);
    rmap_free(names->sorted);
}

static enum rmap_status names_init(const struct rmap_path_report *report, struct names *names,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    names->n = report->n_row;
    names->text = rmap_alloc(names->n + 1, sizeof *names->text);
    names->sorted = rmap_alloc(names->n + 1, sizeof *names->sorted);
    if (!names->text || !names->sorted)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
    for (size_t i = 0; i < names->n; i++) {
        RMAP_TRY(rmap_path_with_source(report->keys, report->row[i].source, report->row[i].sequence,
                                       &names->text[i], err));
        names->sorted[i] = (struct named){names->text[i], (int32_t)i};
    }
    qsort(names->sorted, names->n, sizeof *names->sorted, compare_names);
out:
    return st;
}

/* The row of the report that each class of the page's rays is: [classes->n], -1 for none. */
static enum rmap_status find_rows(const struct names *names,
                                  const struct rmap_path_classes *classes, int32_t *row,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < classes->n; k++) {
        char *own = NULL;
        RMAP_TRY(rmap_path_class_label(classes, k, 0, &own, err));
        const struct named key = {.text = own};
        const struct named *found =
            bsearch(&key, names->sorted, names->n, sizeof key, compare_names);
        row[k] = found ? found->row : -1;
        rmap_free(own);
    }
out:
    return st;
}

/* here: its rays in the page. criterion: null where a path is too long to write. */
static json_t *class_json(const struct rmap_path_row *row, const char *name, size_t here)
{
    char sequence[MOST_SEQUENCE + 400];
    rmap_path_shorten(name, MOST_SEQUENCE, sequence, sizeof sequence);
    return json_pack(
        "{s:o, s:o, s:I, s:I, s:I, s:o, s:o, s:o, s:I}", "sequence", rmap_page_string(sequence),
        "criterion", rmap_page_string(row->criterion), "here", (json_int_t)here, "rays",
        (json_int_t)row->rays, "segments", (json_int_t)row->segments, "flux",
        rmap_json_number(row->flux), "share", rmap_json_number(row->share), "standard_error",
        rmap_json_number(row->standard_error), "first_ray", (json_int_t)row->first_ray);
}

static json_t *rest_json(const struct rmap_path_report *report)
{
    const struct rmap_path_total *rest = &report->rest;
    if (rest->rays == 0)
        return json_null();
    return json_pack(
        "{s:I, s:o, s:o, s:o}", "rays", (json_int_t)rest->rays, "flux",
        rmap_json_number(rest->flux), "share",
        rmap_json_number(report->total.flux > 0.0 ? rest->flux / report->total.flux : 0.0),
        "standard_error", rmap_json_number(rest->standard_error));
}

/* The classes as rows, in the report's order. */
static enum rmap_status list_classes(const struct rmap_path_report *report,
                                     const struct names *names, const size_t *here, json_t *list,
                                     struct rmap_error *err)
{
    for (size_t i = 0; i < report->n_row; i++)
        if (json_array_append_new(list, class_json(&report->row[i], names->text[i], here[i])) != 0)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
    return RMAP_OK;
}

json_t *rmap_page_classes(const struct rmap_page *page, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_report *report = page->paths;
    const size_t n_ray = page->rays->n_row[RMAP_TABLE_RAY];
    struct rmap_path_classes *classes = NULL;
    struct names names = {0};
    json_t *list = json_array(), *json = NULL;
    int32_t *of = rmap_alloc(n_ray + 1, sizeof *of), *row = NULL;
    size_t *here = rmap_alloc(report->n_row + 1, sizeof *here);
    RMAP_TRY(rmap_path_classes_create(report->scene, &report->view, page->rays,
                                      rmap_map_flux_per_weight(page->map), &classes, err));
    row = rmap_alloc(classes->n + 1, sizeof *row);
    if (!of || !here || !row)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page"));
    RMAP_TRY(names_init(report, &names, err));
    RMAP_TRY(find_rows(&names, classes, row, err));
    for (size_t i = 0; i < n_ray; i++) {
        of[i] = classes->of_ray[i] == RMAP_PATH_NO_CLASS ? -1 : row[classes->of_ray[i]];
        if (of[i] >= 0)
            here[of[i]]++;
    }
    RMAP_TRY(list_classes(report, &names, here, list, err));
    json = json_pack("{s:o, s:s, s:O, s:o, s:o}", "count",
                     report->exact ? json_integer((json_int_t)report->n_class) : json_null(), "by",
                     rmap_path_level_word(report->view.level), "list", list, "rest",
                     rest_json(report), "of", rmap_page_integers(of, n_ray));
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
out:
    json_decref(list);
    names_fini(&names);
    rmap_free(of);
    rmap_free(row);
    rmap_free(here);
    rmap_path_classes_destroy(classes);
    return st == RMAP_OK ? json : NULL;
}

json_t *rmap_page_where(const struct rmap_page *page, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = page->rays->n_row[RMAP_TABLE_RAY];
    json_t *list = json_array(), *json = NULL;
    uint8_t *match = rmap_alloc(n_ray + 1, sizeof *match);
    int32_t *bits = rmap_alloc(n_ray + 1, sizeof *bits);
    if (!match || !bits)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria of a page"));
    for (size_t c = 0; c < page->n_where; c++) {
        json_int_t n = 0;
        const char *name = rmap_criterion_name(page->where[c]);
        RMAP_TRY(rmap_criterion_evaluate(page->where[c], page->rays,
                                         rmap_map_flux_per_weight(page->map), match, err));
        for (size_t i = 0; i < n_ray; i++) {
            bits[i] |= (int32_t)match[i] << c;
            n += match[i];
        }
        json_array_append_new(
            list, json_pack("{s:o, s:o, s:I}", "name", rmap_page_string(name), "criterion",
                            rmap_page_string(rmap_criterion_text(page->where[c])), "here", n));
    }
    json = json_pack("{s:O, s:o}", "list", list, "match", rmap_page_integers(bits, n_ray));
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria of a page");
out:
    json_decref(list);
    rmap_free(match);
    rmap_free(bits);
    return st == RMAP_OK ? json : NULL;
}

/* Numbers up to 2^31 fit every page. */
static json_t *counts(const uint32_t *value, size_t n)
{
    int32_t *copy = rmap_alloc(n + 1, sizeof *copy);
    for (size_t i = 0; copy && i < n; i++)
        copy[i] = (int32_t)value[i];
    json_t *json = copy ? rmap_page_integers(copy, n) : NULL;
    rmap_free(copy);
    return json;
}

json_t *rmap_page_orders(const struct rmap_page *page, struct rmap_error *err)
{
    size_t n = page->rays->n_row[RMAP_TABLE_RAY];
    struct rmap_path_order order = {0};
    uint32_t *ghost = rmap_alloc(n + 1, sizeof *ghost), *scatter = rmap_alloc(n + 1, sizeof *ghost);
    json_t *json = NULL;
    if (ghost && scatter &&
        rmap_path_order_init(&order, rmap_map_scene(page->map), err) == RMAP_OK) {
        rmap_path_orders_of_rays(&order, page->rays, ghost, scatter);
        json = json_pack("{s:o, s:o}", "ghost", counts(ghost, n), "scatter", counts(scatter, n));
    }
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
    rmap_path_order_fini(&order);
    rmap_free(ghost);
    rmap_free(scatter);
    return json;
}

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

/* As floats: the flux of a region is a sum of them, and peaks hide nothing. */
static json_t *singles(const double *value, size_t n)
{
    float *single = rmap_alloc(n + 1, sizeof *single);
    for (size_t i = 0; single && i < n; i++)
        single[i] = (float)value[i];
    json_t *json = single ? rmap_page_floats(single, n) : NULL;
    rmap_free(single);
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
        rmap_json_number(most), "value", singles(value, (size_t)nx * ny), "quantity",
        image->quantity, "unit", image->unit, "flux", rmap_json_number(image->flux), "flux_error",
        rmap_json_number(image->flux_error), "peak", rmap_json_number(image->peak), "registrations",
        rmap_json_number(image->registrations));
    rmap_free(value);
    return json;
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
                     rmap_page_vector(detector->origin), "x", rmap_page_vector(detector->x), "y",
                     rmap_page_vector(detector->y), "axis", rmap_page_vector(detector->axis),
                     "size", detector->size[0], detector->size[1], "after_step",
                     (int)(detector->on_object >= 0 || detector->on_group >= 0), "image",
                     image ? image_json(image) : json_null());
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
