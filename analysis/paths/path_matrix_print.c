/* SPDX-License-Identifier: MIT
 *
 * How light came to detectors, as tables for people.
 */
#include <inttypes.h>
#include <math.h>

#include "analysis/paths/path_matrix_part.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"

static const char *unit_of(const struct rmap_path_matrix_part *part)
{
    return part->scene->flux_unit == RMAP_FLUX_LM ? "lm" : "W";
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
        RMAP_TRY(rmap_path_matrix_criterion(part->matrix, sum, &text, err));
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
        const char *object = rmap_path_matrix_object(part->matrix, sum);
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
        const struct rmap_path_matrix_part part = rmap_path_matrix_next(matrix, list, n, &at);
        if (part.sum->part == RMAP_PATH_ORDERS)
            st = print_orders(&part, out, err);
        else if (part.sum->part == RMAP_PATH_GHOSTS)
            st = print_ghosts(&part, top, out, err);
        else if (part.sum->part >= RMAP_PATH_LAST)
            st = print_objects(&part, top, out, err);
    }
    return st;
}
