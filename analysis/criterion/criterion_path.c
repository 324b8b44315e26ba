/* SPDX-License-Identifier: MIT
 *
 * The test path("...").
 */
#include "analysis/criterion/criterion_file_internal.h"
#include "analysis/criterion/path_store.h"
#include "analysis/criterion/path_table.h"

/* A ray's sources of symbols: with names, what tells them. */
static rmap_column_set columns_of(const struct rmap_path_table *table)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_event) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    if (table->of_object || table->of_medium)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_object);
    if (table->of_medium)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    return columns;
}

/* That of the definitions, which criteria share; else one of the criterion's own. */
static enum rmap_status find_store(struct rmap_parser *parser, struct rmap_path_store **store_ret)
{
    struct rmap_criterion *criterion = parser->criterion;
    if (!criterion->paths)
        criterion->paths = parser->criteria ? rmap_path_store_hold(parser->criteria->paths)
                                            : rmap_path_store_create();
    *store_ret = criterion->paths;
    return criterion->paths
               ? RMAP_OK
               : rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the criterion");
}

enum rmap_status rmap_parse_path(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_table *table = NULL;
    struct rmap_path_store *store = NULL;
    node->kind = RMAP_CRITERION_PATH;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    struct rmap_token string = parser->token;
    if (string.kind != RMAP_TOKEN_STRING)
        return rmap_parser_expected(parser,
                                    "a sequence in double quotes, such as \"T@lens.* R .*\"");
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    RMAP_TRY(find_store(parser, &store));
    RMAP_TRY(rmap_path_store_table(store, parser, &string, &table));
    node->path.table = table;
    node->path.columns = columns_of(table);
out:
    return st;
}
