/* SPDX-License-Identifier: MIT
 *
 * How light came to detectors, as tables and as JSON.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/path_matrix.h"
#include "analysis/text_table.h"
#include "base/alloc.h"

/* What a printer goes through: one detector's sums of one part. */
struct part {
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
static struct part next_part(const struct rmap_path_matrix *matrix,
                             const struct rmap_path_cellsum *list, size_t n, size_t *at)
{
    const size_t first = *at;
    while (*at < n && list[*at].part == list[first].part &&
           list[*at].detector == list[first].detector)
        ++*at;
    return (struct part){.matrix = matrix,
                         .scene = rmap_scene_with(matrix->map, matrix->overlay),
                         .sum = list + first,
                         .n = *at - first,
                         .flux = flux_of(list, n, RMAP_PATH_ALL, list[first].detector),
                         .stray = flux_of(list, n, RMAP_PATH_STRAY, list[first].detector)};
}

static const char *unit_of(const struct part *part)
{
    return part->scene->flux_unit == RMAP_FLUX_LM ? "lm" : "W";
}

static const char *object_of(const struct part *part, uint32_t a)
{
    return a > 0 ? rmap_path_label(part->matrix->keys, a - 1) : NULL;
}

static const struct rmap_path_cellsum *order_at(const struct part *part, uint32_t ghost,
                                                uint32_t scatter)
{
    for (size_t i = 0; i < part->n; i++)
        if (part->sum[i].a == ghost && part->sum[i].b == scatter)
            return &part->sum[i];
    return NULL;
}

/* Ghost orders down, scatter orders across. */
static enum rmap_status print_orders(const struct part *part, FILE *out, struct rmap_error *err)
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
                rmap_text_table_add(&table, "%.3g +- %.1g %%", 100.0 * sum->flux / part->flux,
                                    100.0 * sum->standard_error / part->flux);
            else
                rmap_text_table_add(&table, "-");
        }
    }
    enum rmap_status st = rmap_text_table_print(&table, "rrrrrrrrrrrr", out, err);
    rmap_text_table_fini(&table);
    return st;
}

static enum rmap_status print_ghosts(const struct part *part, uint64_t top, FILE *out,
                                     struct rmap_error *err)
{
    struct rmap_text_table table;
    const struct rmap_path_keys *keys = part->matrix->keys;
    fprintf(out, "\n%s: pairs of reflections that make ghosts, of %.5g %s of stray light\n",
            part->scene->detector[part->sum->detector].name, part->stray, unit_of(part));
    rmap_text_table_init(&table, 5);
    for (size_t i = 0; i < part->n && i < top; i++) {
        const struct rmap_path_cellsum *sum = &part->sum[i];
        rmap_text_table_add(&table, "%s then %s:", rmap_path_label(keys, sum->a),
                            rmap_path_label(keys, sum->b));
        rmap_text_table_add(&table, "%.3g +- %.1g %%", 100.0 * sum->flux / part->stray,
                            100.0 * sum->standard_error / part->stray);
        rmap_text_table_add(&table, "%.5g %s", sum->flux, unit_of(part));
        rmap_text_table_add(&table, "%" PRIu64, sum->rays);
        rmap_text_table_add(&table, "rays");
    }
    enum rmap_status st = rmap_text_table_print(&table, "lrrrl", out, err);
    rmap_text_table_fini(&table);
    return st;
}

static enum rmap_status print_objects(const struct part *part, uint64_t top, FILE *out,
                                      struct rmap_error *err)
{
    struct rmap_text_table table;
    fprintf(out, "\n%s: share of the flux by source and %s\n",
            part->scene->detector[part->sum->detector].name,
            part->sum->part == RMAP_PATH_LAST ? "last object met before"
                                              : "each object met before (shares overlap)");
    rmap_text_table_init(&table, 4);
    for (size_t i = 0; i < part->n && i < top; i++) {
        const struct rmap_path_cellsum *sum = &part->sum[i];
        const char *object = object_of(part, sum->a);
        rmap_text_table_add(&table, "%s", part->scene->source[sum->source].name);
        rmap_text_table_add(&table, "%s", object ? object : "(none)");
        rmap_text_table_add(&table, "%.3g +- %.1g %%", 100.0 * sum->flux / part->flux,
                            100.0 * sum->standard_error / part->flux);
        rmap_text_table_add(&table, "%.5g %s", sum->flux, unit_of(part));
    }
    enum rmap_status st = rmap_text_table_print(&table, "llrr", out, err);
    rmap_text_table_fini(&table);
    return st;
}

enum rmap_status rmap_path_matrix_print(const struct rmap_path_matrix *matrix,
                                        const struct rmap_path_cellsum *list, size_t n,
                                        uint64_t top, FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (n == 0)
        fputs("\nnothing was registered\n", out);
    for (size_t at = 0; st == RMAP_OK && at < n;) {
        const struct part part = next_part(matrix, list, n, &at);
        if (part.sum->part == RMAP_PATH_ORDERS)
            st = print_orders(&part, out, err);
        else if (part.sum->part == RMAP_PATH_GHOSTS)
            st = print_ghosts(&part, top, out, err);
        else if (part.sum->part >= RMAP_PATH_LAST)
            st = print_objects(&part, top, out, err);
    }
    return st;
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

/* Of the rays of a pair; null where none can be said. */
static json_t *pair_criterion(const struct part *part, const struct rmap_path_cellsum *sum)
{
    const struct rmap_path_matrix *matrix = part->matrix;
    char *text = NULL;
    json_t *json = NULL;
    enum rmap_status st = rmap_path_ghost_criterion(matrix->keys, matrix->order, sum->a, sum->b,
                                                    sum->detector, &text, NULL);
    if (st == RMAP_OK && text)
        json = matrix->criterion ? json_sprintf("(%s) and %s", matrix->criterion, text)
                                 : json_string(text);
    rmap_free(text);
    return json ? json : json_null();
}

static json_t *sum_json(const struct part *part, const struct rmap_path_cellsum *sum)
{
    const bool pair = sum->part == RMAP_PATH_GHOSTS;
    json_t *json = json_pack("{s:s}", "detector", part->scene->detector[sum->detector].name);
    if (sum->part == RMAP_PATH_ORDERS)
        (void)json_object_update_new(
            json, json_pack("{s:i, s:i}", "ghost_order", sum->a, "scatter_order", sum->b));
    else if (pair)
        (void)json_object_update_new(
            json, json_pack("{s:s, s:s, s:o}", "first", rmap_path_label(part->matrix->keys, sum->a),
                            "second", rmap_path_label(part->matrix->keys, sum->b), "criterion",
                            pair_criterion(part, sum)));
    else
        (void)json_object_update_new(json, json_pack("{s:s, s:s?, s:s}", "source",
                                                     part->scene->source[sum->source].name,
                                                     "object", object_of(part, sum->a), "met",
                                                     sum->part == RMAP_PATH_LAST ? "last" : "any"));
    (void)json_object_update_new(
        json, json_pack("{s:I, s:o, s:o, s:o}", "rays", (json_int_t)sum->rays, "flux",
                        number(sum->flux), "standard_error", number(sum->standard_error), "share",
                        number(sum->flux / (pair ? part->stray : part->flux))));
    return json;
}

enum rmap_status rmap_path_matrix_json(const struct rmap_path_matrix *matrix,
                                       const struct rmap_path_cellsum *list, size_t n,
                                       json_t *document, struct rmap_error *err)
{
    static const char *const key[RMAP_PATH_PART_COUNT] = {[RMAP_PATH_ORDERS] = "orders",
                                                          [RMAP_PATH_GHOSTS] = "ghosts",
                                                          [RMAP_PATH_MET] = "contribution"};
    json_t *array[RMAP_PATH_PART_COUNT] = {NULL};
    int failed = 0;
    for (int p = 0; p < RMAP_PATH_PART_COUNT; p++)
        if (key[p] && matrix->parts & RMAP_PATH_PART_BIT(p)) {
            array[p] = json_array();
            failed |= json_object_set_new(document, key[p], array[p]);
        }
    array[RMAP_PATH_LAST] = array[RMAP_PATH_MET];
    for (size_t at = 0; at < n;) {
        const struct part part = next_part(matrix, list, n, &at);
        for (size_t i = 0; array[part.sum->part] && i < part.n; i++)
            failed |= json_array_append_new(array[part.sum->part], sum_json(&part, &part.sum[i]));
    }
    if (failed)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a JSON document");
    return RMAP_OK;
}
