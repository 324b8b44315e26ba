/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/path_order.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "analysis/paths/path_class.h"
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
