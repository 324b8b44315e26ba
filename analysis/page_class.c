/* SPDX-License-Identifier: MIT */
#include "analysis/page_pack.h"
#include "analysis/page_parts.h"
#include "analysis/path_class.h"
#include "analysis/path_order.h"
#include "base/alloc.h"

/* Classes that a page lists, and length of their sequences; the text of a longer one is cut. */
enum { MOST_CLASSES = 500, MOST_SEQUENCE = 200 };

/* share: of the flux of the page's rays. criterion: null where a path is too long to write. */
static enum rmap_status class_json(const struct rmap_path_classes *classes, size_t index,
                                   double flux, json_t **json_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_class *path = &classes->path[index];
    char *sequence = NULL, *criterion = NULL;
    RMAP_TRY(rmap_path_class_label(classes, index, MOST_SEQUENCE, &sequence, err));
    RMAP_TRY(rmap_path_class_criterion(classes, index, &criterion, err));
    *json_ret =
        json_pack("{s:o, s:o, s:I, s:I, s:o, s:o, s:I}", "sequence", rmap_page_string(sequence),
                  "criterion", rmap_page_string(criterion), "rays", (json_int_t)path->rays,
                  "segments", (json_int_t)path->segments, "flux", rmap_page_number(path->flux),
                  "share", rmap_page_number(flux > 0.0 ? path->flux / flux : 0.0), "first_ray",
                  (json_int_t)path->first_ray);
    if (!*json_ret)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
out:
    rmap_free(sequence);
    rmap_free(criterion);
    return st;
}

/* The class of every ray, -1 where it is not listed. */
static json_t *classes_of_rays(const struct rmap_path_classes *classes, size_t n_ray)
{
    int32_t *of = rmap_alloc(n_ray + 1, sizeof *of);
    for (size_t i = 0; of && i < n_ray; i++)
        of[i] = classes->of_ray[i] < MOST_CLASSES ? (int32_t)classes->of_ray[i] : -1;
    json_t *json = of ? rmap_page_integers(of, n_ray) : NULL;
    rmap_free(of);
    return json;
}

json_t *rmap_page_classes(const struct rmap_page *page, struct rmap_error *err)
{
    static const struct rmap_path_view view = {.level = RMAP_PATH_SURFACE};
    enum rmap_status st = RMAP_OK;
    struct rmap_path_classes *classes = NULL;
    json_t *list = json_array(), *one = NULL, *json = NULL;
    double flux = 0.0;
    RMAP_TRY(rmap_path_classes_create(rmap_map_scene(page->map), &view, page->rays,
                                      rmap_map_flux_per_weight(page->map), &classes, err));
    for (size_t i = 0; i < classes->n; i++)
        flux += classes->path[i].flux;
    for (size_t i = 0; i < classes->n && i < MOST_CLASSES; i++) {
        RMAP_TRY(class_json(classes, i, flux, &one, err));
        json_array_append_new(list, one);
    }
    json = json_pack("{s:I, s:O, s:o}", "count", (json_int_t)classes->n, "list", list, "of",
                     classes_of_rays(classes, page->rays->n_row[RMAP_TABLE_RAY]));
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a page");
out:
    json_decref(list);
    rmap_path_classes_destroy(classes);
    return json;
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
