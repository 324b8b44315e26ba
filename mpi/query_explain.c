/* SPDX-License-Identifier: MIT
 *
 * What a query would read: columns, portions and bytes.
 */
#include <stdio.h>

#include "mpi/json_out.h"
#include "mpi/query_rays_out.h"

/* Rows of a column, decoded, in the portions that may match. */
static uint64_t decoded_nbytes(const struct rmap_map *map, enum rmap_column column, uint64_t n_row)
{
    const struct rmap_column_info *info = rmap_column_info(column);
    if (column == RMAP_SEGMENT_colour)
        return n_row * 2 * (uint64_t)rmap_map_n_channel(map);
    return n_row * (uint64_t)info->width * rmap_element_nbytes(info->element);
}

static json_t *explain_json(const struct rmap_map *map, const struct rmap_criterion *criterion,
                            rmap_column_set columns)
{
    uint64_t n_row[RMAP_TABLE_COUNT] = {0};
    size_t n_read = 0, n_portion = rmap_map_n_portion(map);
    for (size_t p = 0; p < n_portion; p++) {
        const struct rmap_portion_info *info = rmap_map_portion(map, p);
        if (!rmap_criterion_may_match(criterion, &info->summary))
            continue;
        n_read++;
        for (int table = 0; table < RMAP_TABLE_COUNT; table++)
            n_row[table] += info->n_row[table];
    }
    json_t *names = json_array();
    uint64_t nbytes = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const struct rmap_column_info *info = rmap_column_info((enum rmap_column)c);
        if (!(columns & RMAP_COLUMN_BIT(c)))
            continue;
        (void)json_array_append_new(names, json_string(info->path));
        nbytes += decoded_nbytes(map, (enum rmap_column)c, n_row[info->table]);
    }
    return json_pack("{s:s, s:o, s:{s:I, s:I, s:I}, s:I}", "criterion",
                     rmap_criterion_text(criterion), "columns", names, "portions", "total",
                     (json_int_t)n_portion, "read", (json_int_t)n_read, "skipped",
                     (json_int_t)(n_portion - n_read), "bytes_decoded", (json_int_t)nbytes);
}

static void print_text(const json_t *document)
{
    const json_t *portions = json_object_get(document, "portions");
    printf("%s\n  columns ", json_string_value(json_object_get(document, "criterion")));
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(document, "columns"), i, name)
        printf(" %s", json_string_value(name));
    printf("\n  portions %lld of %lld to read, %lld skipped\n",
           (long long)json_integer_value(json_object_get(portions, "read")),
           (long long)json_integer_value(json_object_get(portions, "total")),
           (long long)json_integer_value(json_object_get(portions, "skipped")));
    printf("  bytes    %.1f MB when decoded\n",
           1e-6 * (double)json_integer_value(json_object_get(document, "bytes_decoded")));
}

enum rmap_status rmap_query_explain(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_criterion *const *criterion, size_t n_criterion,
                                    bool rays_wanted, struct rmap_error *err)
{
    json_t *list = json_array();
    for (size_t c = 0; c < n_criterion; c++) {
        rmap_column_set columns =
            rays_wanted ? RMAP_COLUMNS_ALL : rmap_criterion_columns(criterion[c]);
        json_t *document = explain_json(map, criterion[c], columns);
        if (!context->json && document)
            print_text(document);
        (void)json_array_append_new(list, document);
    }
    if (context->json)
        return rmap_json_print(list, stdout, err);
    json_decref(list);
    return RMAP_OK;
}
