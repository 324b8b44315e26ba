/* SPDX-License-Identifier: MIT
 *
 * The test path("...").
 */
#include "analysis/path_table.h"
#include "base/alloc.h"

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

static enum rmap_status begin_table(struct rmap_parser *parser, struct rmap_path_table **table_ret)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    void *block = NULL, *follows = NULL;
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, 1, sizeof(struct rmap_path_table), &block,
                                      parser->err));
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, scene->n_detector + 1, 1, &follows,
                                      parser->err));
    struct rmap_path_table *table = block;
    uint8_t *mark = follows;
    for (size_t d = 0; d < scene->n_detector; d++)
        mark[d] = rmap_detector_lies_on(&scene->detector[d]);
    *table = (struct rmap_path_table){.n_object = scene->n_object,
                                      .n_medium = scene->n_medium,
                                      .n_detector = scene->n_detector,
                                      .follows_object = follows};
    *table_ret = table;
out:
    return st;
}

static enum rmap_status compile(struct rmap_parser *parser, const struct rmap_token *string,
                                struct rmap_path_table *table)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_regex regex = {0};
    struct rmap_path_alphabet alphabet = {0};
    RMAP_TRY(rmap_path_regex_parse(parser, string, &regex));
    RMAP_TRY(rmap_path_alphabet_create(parser, string, &regex, table, &alphabet));
    RMAP_TRY(rmap_path_needs_create(parser, &regex, &alphabet, table));
    RMAP_TRY(rmap_path_automaton_create(parser, string, &regex, &alphabet, table));
out:
    rmap_free(alphabet.has);
    rmap_path_regex_fini(&regex);
    return st;
}

enum rmap_status rmap_parse_path(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_table *table = NULL;
    node->kind = RMAP_CRITERION_PATH;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    struct rmap_token string = parser->token;
    if (string.kind != RMAP_TOKEN_STRING)
        return rmap_parser_expected(parser,
                                    "a sequence in double quotes, such as \"T@lens.* R .*\"");
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    RMAP_TRY(begin_table(parser, &table));
    RMAP_TRY(compile(parser, &string, table));
    node->path.table = table;
    node->path.columns = columns_of(table);
out:
    return st;
}
