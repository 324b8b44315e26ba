/* SPDX-License-Identifier: MIT
 *
 * How light came to detectors, as JSON and as CSV; and the criteria of its parts.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_matrix_part.h"
#include "analysis/table/csv_field.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

static double flux_of(const struct rmap_path_cellsum *list, size_t n, enum rmap_path_part part,
                      int32_t detector)
{
    for (size_t i = 0; i < n; i++)
        if (list[i].part == part && list[i].detector == detector)
            return list[i].flux;
    return 0.0;
}

struct rmap_path_matrix_part rmap_path_matrix_next(const struct rmap_path_matrix *matrix,
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

const char *rmap_path_matrix_object(const struct rmap_path_matrix *matrix,
                                    const struct rmap_path_cellsum *sum)
{
    return sum->a > 0 ? rmap_path_label(matrix->keys, sum->a - 1) : NULL;
}

/* "registered(sensor where ghost_order == 2 and scatter_order >= 9)" */
static void print_orders(const struct rmap_path_cellsum *sum, const char *detector, FILE *out)
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
    const char *object = rmap_path_matrix_object(matrix, sum);
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
        print_orders(sum, detector, out);
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

enum rmap_status rmap_path_matrix_criterion(const struct rmap_path_matrix *matrix,
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
    json_t *json = rmap_path_matrix_criterion(matrix, sum, &text, NULL) == RMAP_OK
                       ? json_string(text)
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
                            "object", rmap_path_matrix_object(part->matrix, sum), "met",
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
        const struct rmap_path_matrix_part part = rmap_path_matrix_next(matrix, list, n, &at);
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
