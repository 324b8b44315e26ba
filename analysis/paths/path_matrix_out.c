/* SPDX-License-Identifier: MIT
 *
 * How light came to detectors, as JSON and as CSV; and the criteria of its parts.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_matrix.h"
#include "analysis/paths/path_matrix_out.h"
#include "analysis/paths/path_text.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

/* What a printer goes through: one detector's sums of one part. */
struct rmap_path_matrix_part {
    const struct rmap_path_matrix *matrix;
    const struct rmap_scene *scene;
    const struct rmap_path_cellsum *sum;
    size_t n;
    double flux, stray; /* that the detector registered */
};

static double flux_of(const struct rmap_path_cellsum *list, size_t n, enum rmap_path_part part,
                      int32_t detector)
{
    for (size_t i = 0; i < n; i++)
        if (list[i].part == part && list[i].detector == detector)
            return list[i].flux;
    return 0.0;
}

/* The sums from *at on that are of one part and detector; moves *at behind them. */
static struct rmap_path_matrix_part path_matrix_next(const struct rmap_path_matrix *matrix,
                                                     const struct rmap_path_cellsum *list, size_t n,
                                                     size_t *at)
{
    const size_t first = *at;
    while (*at < n && list[*at].part == list[first].part &&
           list[*at].detector == list[first].detector)
        ++*at;
    return (struct rmap_path_matrix_part){
        .matrix = matrix,
        .scene = rmap_scene_with(matrix->map, matrix->overlay),
        .sum = list + first,
        .n = *at - first,
        .flux = flux_of(list, n, RMAP_PATH_ALL, list[first].detector),
        .stray = flux_of(list, n, RMAP_PATH_STRAY, list[first].detector)};
}

/* Name of the object of a sum of LAST or MET; NULL: none. */
static const char *path_matrix_object(const struct rmap_path_matrix *matrix,
                                      const struct rmap_path_cellsum *sum)
{
    return sum->a > 0 ? rmap_path_label(matrix->keys, sum->a - 1) : NULL;
}

/* "registered(sensor where ghost_order == 2 and scatter_order >= 9)" */
static void print_order_pair(const struct rmap_path_cellsum *sum, const char *detector, FILE *out)
{
    static const char *const relation[] = {"==", ">="};
    fprintf(out, "registered(%s where ghost_order %s %" PRIu32 " and scatter_order %s %" PRIu32 ")",
            detector, relation[sum->a >= RMAP_PATH_ORDER_MOST], sum->a,
            relation[sum->b >= RMAP_PATH_ORDER_MOST], sum->b);
}

/* "source(lamp) and registered(sensor where after(lens.3))" */
static enum rmap_status print_met(const struct rmap_path_matrix *matrix,
                                  const struct rmap_path_cellsum *sum, const char *detector,
                                  FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(matrix->map, matrix->overlay);
    const char *object = path_matrix_object(matrix, sum);
    char *source = NULL, *name = NULL;
    RMAP_TRY(rmap_path_quote(scene->source[sum->source].name, &source, err));
    if (object)
        RMAP_TRY(rmap_path_quote(object, &name, err));
    fprintf(out, "source(%s) and registered(%s where ", source, detector);
    if (name)
        fprintf(out, "%s(%s))", sum->part == RMAP_PATH_LAST ? "after" : "hit", name);
    else
        fputs("not hit(*))", out);
out:
    rmap_free(source);
    rmap_free(name);
    return st;
}

static enum rmap_status print_criterion(const struct rmap_path_matrix *matrix,
                                        const struct rmap_path_cellsum *sum, FILE *out,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(matrix->map, matrix->overlay);
    char *detector = NULL, *path = NULL;
    if (matrix->criterion)
        fprintf(out, "(%s) and ", matrix->criterion);
    RMAP_TRY(rmap_path_quote(scene->detector[sum->detector].name, &detector, err));
    if (sum->part == RMAP_PATH_ORDERS)
        print_order_pair(sum, detector, out);
    else if (sum->part != RMAP_PATH_GHOSTS)
        RMAP_TRY(print_met(matrix, sum, detector, out, err));
    else
        RMAP_TRY(rmap_path_ghost_criterion(matrix->keys, matrix->order, sum->a, sum->b,
                                           sum->detector, &path, err));
    if (path)
        fputs(path, out);
out:
    rmap_free(detector);
    rmap_free(path);
    return st;
}

/* The criterion of exactly the rays of a sum of ORDERS, GHOSTS, LAST or MET; rmap_free. */
static enum rmap_status path_matrix_criterion(const struct rmap_path_matrix *matrix,
                                              const struct rmap_path_cellsum *sum, char **text_ret,
                                              struct rmap_error *err)
{
    char *bytes = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&bytes, &nbytes);
    enum rmap_status st = out ? print_criterion(matrix, sum, out, err) : RMAP_OK;
    if ((!out || fclose(out) != 0) && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
    if (st == RMAP_OK) {
        *text_ret = rmap_strdup(bytes);
        if (!*text_ret)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
    }
    free(bytes);
    return st;
}

static json_t *criterion_json(const struct rmap_path_matrix *matrix,
                              const struct rmap_path_cellsum *sum)
{
    char *text = NULL;
    json_t *json = path_matrix_criterion(matrix, sum, &text, NULL) == RMAP_OK ? json_string(text)
                                                                              : json_null();
    rmap_free(text);
    return json;
}

static json_t *sum_json(const struct rmap_path_matrix_part *part,
                        const struct rmap_path_cellsum *sum)
{
    const bool pair = sum->part == RMAP_PATH_GHOSTS;
    json_t *json = json_pack("{s:s}", "detector", part->scene->detector[sum->detector].name);
    if (sum->part == RMAP_PATH_ORDERS)
        (void)json_object_update_new(
            json, json_pack("{s:i, s:i}", "ghost_order", sum->a, "scatter_order", sum->b));
    else if (pair)
        (void)json_object_update_new(
            json, json_pack("{s:s, s:s}", "first", rmap_path_label(part->matrix->keys, sum->a),
                            "second", rmap_path_label(part->matrix->keys, sum->b)));
    else
        (void)json_object_update_new(
            json, json_pack("{s:s, s:s?, s:s}", "source", part->scene->source[sum->source].name,
                            "object", path_matrix_object(part->matrix, sum), "met",
                            sum->part == RMAP_PATH_LAST ? "last" : "any"));
    (void)json_object_update_new(
        json, json_pack("{s:I, s:o, s:o, s:o, s:o}", "rays", (json_int_t)sum->rays, "flux",
                        rmap_json_number(sum->flux), "standard_error",
                        rmap_json_number(sum->standard_error), "share",
                        rmap_json_number(sum->flux / (pair ? part->stray : part->flux)),
                        "criterion", criterion_json(part->matrix, sum)));
    return json;
}

/* As JSON calls them, and what stands in a row of each. */
static const char *const key[RMAP_PATH_PART_COUNT] = {
    [RMAP_PATH_ORDERS] = "orders", [RMAP_PATH_GHOSTS] = "ghosts", [RMAP_PATH_MET] = "contribution"};

enum rmap_status rmap_path_matrix_json(const struct rmap_path_matrix *matrix,
                                       const struct rmap_path_cellsum *list, size_t n,
                                       json_t *document, struct rmap_error *err)
{
    json_t *array[RMAP_PATH_PART_COUNT] = {NULL};
    int failed = 0;
    for (int p = 0; p < RMAP_PATH_PART_COUNT; p++)
        if (key[p] && matrix->parts & RMAP_PATH_PART_BIT(p)) {
            array[p] = json_array();
            failed |= json_object_set_new(document, key[p], array[p]);
        }
    array[RMAP_PATH_LAST] = array[RMAP_PATH_MET];
    for (size_t at = 0; at < n;) {
        const struct rmap_path_matrix_part part = path_matrix_next(matrix, list, n, &at);
        for (size_t i = 0; array[part.sum->part] && i < part.n; i++)
            failed |= json_array_append_new(array[part.sum->part], sum_json(&part, &part.sum[i]));
    }
    if (failed)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a JSON document");
    return RMAP_OK;
}

static void put_line(size_t index, json_t *row, FILE *out)
{
    const char *name;
    json_t *value;
    fprintf(out, "%zu", index + 1);
    json_object_foreach(row, name, value)
    {
        if (json_is_integer(value))
            fprintf(out, ",%" JSON_INTEGER_FORMAT, json_integer_value(value));
        else if (json_is_string(value) || strcmp(name, "object") == 0)
            rmap_csv_put_text(json_string_value(value), out);
        else
            rmap_csv_put_number(json_is_real(value) ? json_real_value(value) : (double)NAN, out);
    }
    fputc('\n', out);
}

enum rmap_status rmap_path_matrix_csv(const struct rmap_path_matrix *matrix,
                                      const struct rmap_path_cellsum *list, size_t n, FILE *out,
                                      struct rmap_error *err)
{
    static const char *const names[RMAP_PATH_PART_COUNT] = {[RMAP_PATH_ORDERS] =
                                                                "ghost_order,scatter_order",
                                                            [RMAP_PATH_GHOSTS] = "first,second",
                                                            [RMAP_PATH_MET] = "source,object,met"};
    json_t *document = json_object(), *row;
    size_t i;
    enum rmap_status st = rmap_path_matrix_json(matrix, list, n, document, err);
    for (int p = 0; st == RMAP_OK && p < RMAP_PATH_PART_COUNT; p++) {
        const json_t *rows = key[p] ? json_object_get(document, key[p]) : NULL;
        if (!rows)
            continue;
        fprintf(out, "# criterion: %s\nrow,detector,%s,rays,flux,standard_error,share,criterion\n",
                matrix->criterion ? matrix->criterion : "all", names[p]);
        json_array_foreach(rows, i, row) put_line(i, row, out);
    }
    json_decref(document);
    return st;
}

/* How light came to detectors, as tables for people. */

static const char *unit_of(const struct rmap_path_matrix_part *part)
{
    return rmap_flux_unit_name(part->scene);
}

static const struct rmap_path_cellsum *order_at(const struct rmap_path_matrix_part *part,
                                                uint32_t ghost, uint32_t scatter)
{
    for (size_t i = 0; i < part->n; i++)
        if (part->sum[i].a == ghost && part->sum[i].b == scatter)
            return &part->sum[i];
    return NULL;
}

static void add_share(struct rmap_text_table *table, const struct rmap_path_cellsum *sum,
                      double whole)
{
    if (isfinite(sum->standard_error))
        rmap_text_table_add(table, "%.3g +- %.1g %%", 100.0 * sum->flux / whole,
                            100.0 * sum->standard_error / whole);
    else
        rmap_text_table_add(table, "%.3g %%", 100.0 * sum->flux / whole);
}

/* What selects the rays of the first rows, one line each. */
static enum rmap_status print_criteria(const struct rmap_path_matrix_part *part, uint64_t top,
                                       FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    fputs(top > 0 ? "criteria\n" : "", out);
    for (size_t i = 0; i < part->n && i < top; i++) {
        char *text = NULL;
        const struct rmap_path_cellsum *sum = &part->sum[i];
        RMAP_TRY(path_matrix_criterion(part->matrix, sum, &text, err));
        if (sum->part == RMAP_PATH_ORDERS)
            fprintf(out, "%" PRIu32 " %" PRIu32 "  %s\n", sum->a, sum->b, text);
        else
            fprintf(out, "%zu  %s\n", i + 1, text);
        rmap_free(text);
    }
out:
    return st;
}

/* What stands behind the first rows; whole: of what their shares are, 0 where these overlap. */
static void print_rest(const struct rmap_path_matrix_part *part, uint64_t top, double whole,
                       FILE *out)
{
    double flux = 0.0;
    if (part->n <= top)
        return;
    for (size_t i = (size_t)top; i < part->n; i++)
        flux += part->sum[i].flux;
    fprintf(out, "and %zu more", part->n - (size_t)top);
    if (whole > 0.0)
        fprintf(out, ": %.3g %%, %.5g %s", 100.0 * flux / whole, flux, unit_of(part));
    fputc('\n', out);
}

/* Ghost orders down, scatter orders across. */
static enum rmap_status print_orders(const struct rmap_path_matrix_part *part, FILE *out,
                                     struct rmap_error *err)
{
    struct rmap_text_table table;
    uint32_t most[2] = {0, 0};
    for (size_t i = 0; i < part->n; i++) {
        most[0] = part->sum[i].a > most[0] ? part->sum[i].a : most[0];
        most[1] = part->sum[i].b > most[1] ? part->sum[i].b : most[1];
    }
    fprintf(out, "\n%s: share of the flux by ghost order (down) and scatter order (across)\n",
            part->scene->detector[part->sum->detector].name);
    rmap_text_table_init(&table, most[1] + 2);
    rmap_text_table_add(&table, "%s", "");
    for (uint32_t s = 0; s <= most[1]; s++)
        rmap_text_table_add(&table, "%u%s", s, s == RMAP_PATH_ORDER_MOST ? "+" : "");
    for (uint32_t g = 0; g <= most[0]; g++) {
        rmap_text_table_add(&table, "%u%s", g, g == RMAP_PATH_ORDER_MOST ? "+" : "");
        for (uint32_t s = 0; s <= most[1]; s++) {
            const struct rmap_path_cellsum *sum = order_at(part, g, s);
            if (sum)
                add_share(&table, sum, part->flux);
            else
                rmap_text_table_add(&table, "-");
        }
    }
    enum rmap_status st = rmap_text_table_print(&table, "rrrrrrrrrrrr", out, err);
    rmap_text_table_fini(&table);
    return st == RMAP_OK ? print_criteria(part, UINT64_MAX, out, err) : st;
}

static enum rmap_status print_ghosts(const struct rmap_path_matrix_part *part, uint64_t top,
                                     FILE *out, struct rmap_error *err)
{
    struct rmap_text_table table;
    const struct rmap_path_keys *keys = part->matrix->keys;
    fprintf(out, "\n%s: pairs of reflections that make ghosts, of %.5g %s of stray light\n",
            part->scene->detector[part->sum->detector].name, part->stray, unit_of(part));
    rmap_text_table_init(&table, 6);
    for (size_t i = 0; i < part->n && i < top; i++) {
        const struct rmap_path_cellsum *sum = &part->sum[i];
        rmap_text_table_add(&table, "%zu", i + 1);
        rmap_text_table_add(&table, "%s then %s:", rmap_path_label(keys, sum->a),
                            rmap_path_label(keys, sum->b));
        add_share(&table, sum, part->stray);
        rmap_text_table_add(&table, "%.5g %s", sum->flux, unit_of(part));
        rmap_text_table_add(&table, "%" PRIu64, sum->rays);
        rmap_text_table_add(&table, sum->rays == 1 ? "ray" : "rays");
    }
    enum rmap_status st = rmap_text_table_print(&table, "rlrrrl", out, err);
    rmap_text_table_fini(&table);
    if (st == RMAP_OK)
        print_rest(part, top, part->stray, out);
    return st == RMAP_OK ? print_criteria(part, top, out, err) : st;
}

static enum rmap_status print_objects(const struct rmap_path_matrix_part *part, uint64_t top,
                                      FILE *out, struct rmap_error *err)
{
    struct rmap_text_table table;
    fprintf(out, "\n%s: share of the flux by source and %s\n",
            part->scene->detector[part->sum->detector].name,
            part->sum->part == RMAP_PATH_LAST ? "last object met before"
                                              : "each object met before (shares overlap)");
    rmap_text_table_init(&table, 5);
    for (size_t i = 0; i < part->n && i < top; i++) {
        const struct rmap_path_cellsum *sum = &part->sum[i];
        const char *object = path_matrix_object(part->matrix, sum);
        rmap_text_table_add(&table, "%zu", i + 1);
        rmap_text_table_add(&table, "%s", part->scene->source[sum->source].name);
        rmap_text_table_add(&table, "%s", object ? object : "(none)");
        add_share(&table, sum, part->flux);
        rmap_text_table_add(&table, "%.5g %s", sum->flux, unit_of(part));
    }
    enum rmap_status st = rmap_text_table_print(&table, "rllrr", out, err);
    rmap_text_table_fini(&table);
    if (st == RMAP_OK)
        print_rest(part, top, part->sum->part == RMAP_PATH_LAST ? part->flux : 0.0, out);
    return st == RMAP_OK ? print_criteria(part, top, out, err) : st;
}

enum rmap_status rmap_path_matrix_print(const struct rmap_path_matrix *matrix,
                                        const struct rmap_path_cellsum *list, size_t n,
                                        uint64_t top, FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (n == 0)
        fputs("\nnothing was registered\n", out);
    for (size_t at = 0; st == RMAP_OK && at < n;) {
        const struct rmap_path_matrix_part part = path_matrix_next(matrix, list, n, &at);
        if (part.sum->part == RMAP_PATH_ORDERS)
            st = print_orders(&part, out, err);
        else if (part.sum->part == RMAP_PATH_GHOSTS)
            st = print_ghosts(&part, top, out, err);
        else if (part.sum->part >= RMAP_PATH_LAST)
            st = print_objects(&part, top, out, err);
    }
    return st;
}
