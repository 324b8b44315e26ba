/* SPDX-License-Identifier: MIT
 *
 * Tests of a ray's registrations: registered, crossed, angle, x, y, time, optical_path, where.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_detector.h"
#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/registration_response.h"

enum rmap_dimension rmap_its_number_dimension(const struct rmap_scene *scene,
                                              enum rmap_registration_number number,
                                              const struct rmap_index_set *detector)
{
    switch (number) {
    case RMAP_REGISTRATION_ANGLE:
        return RMAP_DIMENSION_ANGLE;
    case RMAP_REGISTRATION_TIME:
    case RMAP_REGISTRATION_ARRIVAL:
        return RMAP_DIMENSION_TIME;
    case RMAP_REGISTRATION_OPTICAL_PATH:
    case RMAP_REGISTRATION_GROUP_PATH:
    case RMAP_REGISTRATION_WORLD_X:
    case RMAP_REGISTRATION_WORLD_Y:
    case RMAP_REGISTRATION_WORLD_Z:
        return RMAP_DIMENSION_LENGTH;
    case RMAP_REGISTRATION_DETECTED:
        return RMAP_DIMENSION_NONE;
    case RMAP_REGISTRATION_X:
    case RMAP_REGISTRATION_Y:
        break;
    }
    return rmap_detector_dimension(scene, detector);
}

/* The comparison behind a number of a registration, as a node of its own. */
static enum rmap_status parse_its_comparison(struct rmap_parser *parser,
                                             const struct rmap_word *row,
                                             const struct rmap_token *word,
                                             const struct rmap_index_set *detector,
                                             int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node node = {.kind = RMAP_CRITERION_ITS_NUMBER,
                                       .first = -1,
                                       .next = -1,
                                       .begin = word->begin,
                                       .its_number =
                                           rmap_time_in(parser->criterion->scene, row->its_number)};
    size_t written = parser->taken_end - word->begin; /* with the detector's name, if any */
    if (parser->text[parser->token.begin] == '*')
        return RMAP_PARSER_FAIL(parser, &parser->token, RMAP_FACTOR_HINT);
    if (!rmap_parser_at_comparison(parser))
        return RMAP_PARSER_FAIL(parser, word, "'%s' is a number: compare it, as in '%.*s > 10'",
                                row->word, (int)(written < 48 ? written : 48),
                                parser->text + word->begin);
    const enum rmap_dimension dimension =
        rmap_its_number_dimension(parser->criterion->scene, row->its_number, detector);
    parser->criterion->is_mixed |= dimension == RMAP_DIMENSION_MIXED;
    RMAP_TRY(rmap_parse_interval(parser, dimension, &node.interval));
    node.end = parser->taken_end;
    RMAP_TRY(rmap_criterion_node_add(parser->criterion, &node, node_ret, parser->err));
out:
    return st;
}

enum rmap_status rmap_parse_where_test(struct rmap_parser *parser, int32_t *node_ret)
{
    struct rmap_token word = parser->token;
    const struct rmap_word *row = rmap_word_next(parser);
    if (word.kind == RMAP_TOKEN_AT)
        return RMAP_PARSER_FAIL(parser, &word,
                                "names cannot stand inside 'where': they are of whole rays; put "
                                "@NAME beside registered(...) with 'and'");
    if (word.kind != RMAP_TOKEN_WORD)
        return rmap_parser_expected(parser, "angle, x, y, time, optical_path, or a test of the "
                                            "steps before such as hit(NAME)");
    if (row && row->scope == RMAP_OF_RAY && !row->of_registration)
        return RMAP_PARSER_FAIL(parser, &word,
                                "'%s' is of the whole ray, not of a registration: put it beside "
                                "registered(...) with 'and'",
                                row->word);
    char text[RMAP_TOKEN_NAME_NBYTES + 1];
    rmap_token_name(parser->text, &word, text);
    const struct rmap_name *name = row ? NULL : rmap_names_lookup(parser->names, text);
    if (name)
        return RMAP_PARSER_FAIL(parser, &word, "'%.*s' is %s, not a test of a registration",
                                (int)(word.end - word.begin), text,
                                rmap_name_kind_phrase(name->kind));
    if (!row || !row->of_registration)
        return rmap_word_fail(parser, &word, "number of a registration", RMAP_WORDS_OF_WHERE);
    enum rmap_status st = rmap_parser_advance(parser);
    if (st == RMAP_OK)
        st = parse_its_comparison(parser, row, &word, parser->detector, node_ret);
    return st;
}

/* The condition of one registration. */
static enum rmap_status parse_condition(struct rmap_parser *parser,
                                        struct rmap_registration_test *test)
{
    parser->detector = &test->detector;
    enum rmap_status st = rmap_parse_logic(parser, &test->where);
    parser->detector = NULL;
    return st;
}

static enum rmap_status parse_where(struct rmap_parser *parser, struct rmap_registration_test *test)
{
    enum rmap_status st = rmap_parser_advance(parser);
    return st == RMAP_OK ? parse_condition(parser, test) : st;
}

/* What chooses registrations, as it is written from `begin` on; before: words in front of it. */
static enum rmap_status keep_chooses(struct rmap_parser *parser, const char *before, size_t begin,
                                     const char **chooses_ret)
{
    const size_t n = parser->taken_end - begin, n_before = strlen(before);
    void *block = NULL;
    enum rmap_status st =
        rmap_criterion_block_add(parser->criterion, n_before + n + 1, 1, &block, parser->err);
    if (st != RMAP_OK)
        return st;
    memcpy(block, before, n_before);
    memcpy((char *)block + n_before, parser->text + begin, n);
    *chooses_ret = block;
    return RMAP_OK;
}

static enum rmap_status parse_registrations(struct rmap_parser *parser,
                                            struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_registration_test *test = &node->registrations;
    size_t begin = SIZE_MAX;
    node->kind = RMAP_CRITERION_REGISTRATIONS;
    test->where = -1;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_DETECTOR, &test->detector));
    while (parser->token.kind == RMAP_TOKEN_COMMA) {
        RMAP_TRY(rmap_parser_advance(parser));
        begin = begin < parser->token.begin ? begin : parser->token.begin;
        if (rmap_parser_at_word(parser, "where"))
            break;
        RMAP_TRY(rmap_parse_region(parser, test));
    }
    if (rmap_parser_at_word(parser, "where")) {
        begin = begin < parser->token.begin ? begin : parser->token.begin;
        RMAP_TRY(parse_where(parser, test));
    }
    if (begin < SIZE_MAX)
        RMAP_TRY(keep_chooses(parser, "", begin, &test->chooses));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE,
                              test->where < 0 ? "',', 'where' or ')'" : "'and', 'or' or ')'"));
    st = rmap_parser_box_place(parser, test);
out:
    return st;
}

enum rmap_status rmap_parse_which(struct rmap_parser *parser, const struct rmap_index_set *detector,
                                  struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_registration_test *test = &node->registrations;
    const size_t begin = parser->token.begin;
    const bool at_region = rmap_parser_at_region(parser);
    *node = (struct rmap_criterion_node){.kind = RMAP_CRITERION_REGISTRATIONS,
                                         .first = -1,
                                         .next = -1,
                                         .begin = begin,
                                         .interval = {1.0, (double)INFINITY, false},
                                         .registrations = {.detector = *detector, .where = -1}};
    if (at_region)
        RMAP_TRY(rmap_parse_region(parser, test));
    if (at_region && parser->token.kind == RMAP_TOKEN_COMMA)
        RMAP_TRY(rmap_parser_advance(parser));
    if (rmap_parser_at_word(parser, "where"))
        RMAP_TRY(parse_where(parser, test));
    else if (!at_region)
        RMAP_TRY(parse_condition(parser, test));
    node->end = parser->taken_end;
    RMAP_TRY(keep_chooses(parser, "", begin, &test->chooses));
    if (parser->token.kind != RMAP_TOKEN_END)
        RMAP_TRY(rmap_parser_expected(parser, test->where < 0 ? "'where' or the end"
                                                              : "'and', 'or' or the end"));
    st = rmap_parser_box_place(parser, test);
out:
    return st;
}

enum rmap_status rmap_parse_registered(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    return parse_registrations(parser, node);
}

/* A chance on one of the detectors; else what is registered there is detected. */
static enum rmap_status check_chances(const struct rmap_parser *parser,
                                      const struct rmap_token *word,
                                      const struct rmap_index_set *detector)
{
    const struct rmap_scene *scene = parser->criterion->scene;
    for (size_t d = 0; d < scene->n_detector; d++)
        if (rmap_index_set_has(detector, (int32_t)d) && rmap_detector_chances(&scene->detector[d]))
            return RMAP_OK;
    return RMAP_PARSER_FAIL(parser, word,
                            "no detector of these detects by chance: ask for registered(NAME), or "
                            "give it 'response' and 'detect: chance'");
}

/* registered(...), and the draw beside what stands behind `where`. */
enum rmap_status rmap_parse_detected(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_token word = parser->word;
    struct rmap_registration_test *test = &node->registrations;
    struct rmap_criterion_node drawn = {.kind = RMAP_CRITERION_ITS_NUMBER,
                                        .first = -1,
                                        .next = -1,
                                        .begin = word.begin,
                                        .end = word.end,
                                        .interval = {1.0, (double)INFINITY, false},
                                        .its_number = RMAP_REGISTRATION_DETECTED};
    struct rmap_criterion_node both = {.kind = RMAP_CRITERION_AND, .next = -1};
    RMAP_TRY(parse_registrations(parser, node));
    RMAP_TRY(check_chances(parser, &word, &test->detector));
    drawn.next = test->where;
    RMAP_TRY(rmap_criterion_node_add(parser->criterion, &drawn, &both.first, parser->err));
    if (test->where < 0) {
        test->where = both.first;
        return RMAP_OK;
    }
    both.begin = word.begin;
    both.end = parser->taken_end;
    st = rmap_criterion_node_add(parser->criterion, &both, &test->where, parser->err);
out:
    return st;
}

enum rmap_status rmap_parse_crossed(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    node->registrations.crossed = true;
    return parse_registrations(parser, node);
}

enum rmap_status rmap_parse_any_number(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_registration_test *test = &node->registrations;
    struct rmap_token word = parser->word;
    const struct rmap_word *row = rmap_word_at(parser, &word);
    char before[40];
    node->kind = RMAP_CRITERION_REGISTRATIONS;
    test->where = -1;
    test->of_number = true;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_DETECTOR, &test->detector));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    const size_t begin = parser->token.begin;
    RMAP_TRY(parse_its_comparison(parser, row, &word, &test->detector, &test->where));
    (void)snprintf(before, sizeof before, "where %s ", row->word);
    RMAP_TRY(keep_chooses(parser, before, begin, &test->chooses));
    st = rmap_parser_box_place(parser, test);
out:
    return st;
}
