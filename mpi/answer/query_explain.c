/* SPDX-License-Identifier: MIT
 *
 * What a query would read: portions, what of the history index, columns and bytes.
 */
#include <stdio.h>

#include "analysis/query/query_plan.h"
#include "base/grouped.h"
#include "io/map/map_history.h"
#include "io/map/map_json.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/command/json_out.h"

static json_t *explain_json(const struct rmap_map *map, const struct rmap_criterion *criterion,
                            const struct rmap_query_plan *plan,
                            const struct rmap_history_survey *indexed)
{
    size_t n_portion = rmap_map_n_portion(map);
    json_t *names = json_array();
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (plan->columns & RMAP_COLUMN_BIT(c))
            (void)json_array_append_new(names,
                                        json_string(rmap_column_info((enum rmap_column)c)->path));
    return json_pack(
        "{s:s, s:o, s:{s:I, s:I, s:I}, s:{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:s}, "
        "s:{s:I, s:I}, s:I}",
        "criterion", rmap_criterion_text(criterion), "columns", names, "portions", "total",
        (json_int_t)n_portion, "read", (json_int_t)(n_portion - plan->n_skipped), "skipped",
        (json_int_t)plan->n_skipped, "index", "by_paths", (json_int_t)plan->n_by_path, "by_rows",
        (json_int_t)plan->n_by_row, "without", (json_int_t)plan->n_by_column, "rays",
        (json_int_t)plan->n_index_ray, "undecided_rays", (json_int_t)plan->n_open_ray,
        "undecided_portions", (json_int_t)plan->n_open_portion, "bytes",
        (json_int_t)plan->index_nbytes, "unused_pieces", (json_int_t)indexed->n_unused, "why",
        indexed->why.text, "compact", "portions", (json_int_t)plan->n_compact, "traced_again",
        (json_int_t)plan->n_retraced, "bytes_decoded", (json_int_t)plan->decoded_nbytes);
}

static void print_text(const struct rmap_map *map, const struct rmap_criterion *criterion,
                       const struct rmap_query_plan *plan,
                       const struct rmap_history_survey *indexed)
{
    size_t n_portion = rmap_map_n_portion(map);
    printf("%s\n  portions %llu of %zu to read, %llu skipped\n", rmap_criterion_text(criterion),
           (unsigned long long)(n_portion - plan->n_skipped), n_portion,
           (unsigned long long)plan->n_skipped);
    if (plan->n_by_path + plan->n_by_row > 0)
        printf("  index    %s by paths, %llu by rows, %.1f MB; leaves %.3g %% of their "
               "rays undecided, in %s\n",
               rmap_counted(plan->n_by_path, "portion").text, (unsigned long long)plan->n_by_row,
               1e-6 * (double)plan->index_nbytes,
               plan->n_index_ray ? 100.0 * (double)plan->n_open_ray / (double)plan->n_index_ray
                                 : 0.0,
               rmap_counted(plan->n_open_portion, "portion").text);
    if (plan->n_by_column > 0)
        printf("  index    none for %s: columns answer\n",
               rmap_counted(plan->n_by_column, "portion").text);
    if (indexed->n_unused > 0)
        printf("  index    of %s cannot be used: raymap index makes it again (%s)\n",
               rmap_counted(indexed->n_unused, "piece").text, indexed->why.text);
    if (plan->n_compact > 0)
        printf("  compact  %s, rays traced again in %s\n",
               rmap_counted(plan->n_compact, "portion").text,
               plan->n_retraced > 0 ? rmap_counted(plan->n_retraced, "portion").text : "none");
    printf("  columns ");
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (plan->columns & RMAP_COLUMN_BIT(c))
            printf(" %s", rmap_column_info((enum rmap_column)c)->path);
    printf("%s\n  bytes    %.1f MB when decoded\n", plan->columns ? "" : " none",
           1e-6 * (double)plan->decoded_nbytes);
}

enum rmap_status rmap_query_explain(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_criterion *const *criterion, size_t n_criterion,
                                    bool rays_wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_survey indexed;
    json_t *list = json_array();
    RMAP_TRY(rmap_map_history_survey(map, &indexed, err));
    for (size_t c = 0; c < n_criterion; c++) {
        struct rmap_query_plan plan;
        RMAP_TRY(rmap_query_plan(map, criterion[c], rays_wanted, &plan, err));
        if (context->json)
            (void)json_array_append_new(
                list, rmap_json_of_map(explain_json(map, criterion[c], &plan, &indexed), map));
        else
            print_text(map, criterion[c], &plan, &indexed);
    }
    if (context->json) {
        st = rmap_json_print(list, stdout, err);
        list = NULL;
    }
out:
    json_decref(list);
    return st;
}
