/* SPDX-License-Identifier: MIT
 *
 * The parser's state and its rooms: logic (criterion_parser.c), elementary tests
 * (criterion_word.c) of steps (criterion_parser.c, criterion_surface.c) and of registrations
 * (criterion_detector.c), and values: numbers, units, ranges, regions (criterion_value.c).
 */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "analysis/criterion/criterion_detector.h"
#include "analysis/criterion/criterion_file_internal.h"
#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/path_order.h"
#include "analysis/criterion/path_store.h"
#include "analysis/criterion/path_table.h"
#include "analysis/criterion/step_number.h"
#include "base/alloc.h"
#include "portion/event.h"

/* Recursive descent: or over and over not over parentheses and tests. Only parentheses recurse,
 * to a stated depth; chains of and, or, not are loops. */

enum rmap_status rmap_parser_advance(struct rmap_parser *parser)
{
    parser->taken_end = parser->token.end;
    enum rmap_status st =
        rmap_token_read(parser->text, parser->token.end, &parser->token, parser->err);
    if (st == RMAP_OK && parser->reference && parser->token.begin >= parser->definition_end)
        parser->token.kind = RMAP_TOKEN_END;
    return st;
}

bool rmap_parser_at_word(const struct rmap_parser *parser, const char *word)
{
    return rmap_token_is(parser->text, &parser->token, word);
}

const char *rmap_parser_small(const struct rmap_parser *parser)
{
    static const char *const words[] = {"and", "or", "not", "in", "where"};
    const struct rmap_token *token = &parser->token;
    const size_t len = token->end - token->begin;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i]) == len && strncasecmp(parser->text + token->begin, words[i], len) == 0)
            return words[i];
    return NULL;
}

/* What a mistake that others make, too, is to be written as; "" where it is another. */
static void tell_remedy(const struct rmap_parser *parser, char remedy[RMAP_SHOWN_NBYTES])
{
    const struct rmap_token *token = &parser->token;
    const char *text = parser->text, *small = rmap_parser_small(parser);
    remedy[0] = 0;
    if (token->kind == RMAP_TOKEN_WORD && small && !rmap_parser_at_word(parser, small))
        (void)snprintf(remedy, RMAP_SHOWN_NBYTES, ": write '%s'", small);
    else if (token->kind == RMAP_TOKEN_COMMA && token->begin > 0 &&
             isdigit((unsigned char)text[token->begin - 1]) &&
             isdigit((unsigned char)text[token->end]))
        (void)snprintf(remedy, RMAP_SHOWN_NBYTES, ": decimals have a point");
}

enum rmap_status rmap_parser_expected(const struct rmap_parser *parser, const char *what)
{
    const struct rmap_token *token = &parser->token;
    if (token->kind == RMAP_TOKEN_END)
        return RMAP_PARSER_FAIL(parser, token, "expected %s, found the end", what);
    if (token->kind == RMAP_TOKEN_PLUS || token->kind == RMAP_TOKEN_MINUS)
        return RMAP_PARSER_FAIL(parser, token, "unexpected character '%c'",
                                parser->text[token->begin]);
    char shown[RMAP_SHOWN_NBYTES], remedy[RMAP_SHOWN_NBYTES];
    rmap_token_shorten(parser->text, token, shown);
    tell_remedy(parser, remedy);
    return RMAP_PARSER_FAIL(parser, token, "expected %s, found %s%s%s%s", what,
                            *shown == '\'' ? "" : "'", shown, *shown == '\'' ? "" : "'", remedy);
}

enum rmap_status rmap_parser_take(struct rmap_parser *parser, enum rmap_token_kind kind,
                                  const char *what)
{
    return parser->token.kind == kind ? rmap_parser_advance(parser)
                                      : rmap_parser_expected(parser, what);
}

static struct rmap_criterion_node *node_at(const struct rmap_parser *parser, int32_t index)
{
    return &parser->criterion->node[index];
}

/* A node of this kind over the text of its first child. */
static enum rmap_status add_parent(struct rmap_parser *parser, enum rmap_criterion_kind kind,
                                   int32_t child, int32_t *node_ret)
{
    struct rmap_criterion_node node = {.kind = kind,
                                       .first = child,
                                       .next = -1,
                                       .begin = node_at(parser, child)->begin,
                                       .end = node_at(parser, child)->end};
    return rmap_criterion_node_add(parser->criterion, &node, node_ret, parser->err);
}

static enum rmap_status parse_parentheses(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token open = parser->token;
    if (++parser->depth > RMAP_CRITERION_DEPTH)
        return RMAP_PARSER_FAIL(parser, &open, "more than %d nested parentheses",
                                RMAP_CRITERION_DEPTH);
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parse_logic(parser, node_ret));
    if (parser->token.kind == RMAP_TOKEN_END)
        return RMAP_PARSER_FAIL(parser, &open, "this parenthesis is never closed");
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "'and', 'or' or ')'"));
    parser->depth--;
    if (rmap_parser_at_comparison(parser))
        st = RMAP_PARSER_FAIL(parser, &parser->token,
                              "only a single test can be counted, not an expression");
out:
    return st;
}

static enum rmap_status parse_not(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t begin = parser->token.begin;
    bool negate = false;
    while (parser->token.kind == RMAP_TOKEN_NOT) {
        negate = !negate;
        RMAP_TRY(rmap_parser_advance(parser));
    }
    int32_t child = -1;
    if (parser->token.kind == RMAP_TOKEN_OPEN)
        RMAP_TRY(parse_parentheses(parser, &child));
    else
        RMAP_TRY(rmap_parse_test(parser, &child));
    *node_ret = child;
    if (negate) {
        RMAP_TRY(add_parent(parser, RMAP_CRITERION_NOT, child, node_ret));
        node_at(parser, *node_ret)->begin = begin;
    }
out:
    return st;
}

/* A chain of `part` joined by one operator; a chain of one is that one. */
static enum rmap_status parse_chain(struct rmap_parser *parser, enum rmap_token_kind joint,
                                    enum rmap_criterion_kind kind,
                                    enum rmap_status (*part)(struct rmap_parser *, int32_t *),
                                    int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    int32_t last = -1, next = -1;
    RMAP_TRY(part(parser, &last));
    *node_ret = last;
    if (parser->token.kind != joint)
        goto out;
    RMAP_TRY(add_parent(parser, kind, last, node_ret));
    while (parser->token.kind == joint) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(part(parser, &next));
        node_at(parser, last)->next = next;
        node_at(parser, *node_ret)->end = node_at(parser, next)->end;
        last = next;
    }
out:
    return st;
}

static enum rmap_status parse_and(struct rmap_parser *parser, int32_t *node_ret)
{
    return parse_chain(parser, RMAP_TOKEN_AND, RMAP_CRITERION_AND, parse_not, node_ret);
}

enum rmap_status rmap_parse_logic(struct rmap_parser *parser, int32_t *node_ret)
{
    return parse_chain(parser, RMAP_TOKEN_OR, RMAP_CRITERION_OR, parse_and, node_ret);
}

/* The whole text; detector NULL: the whole language. */
static enum rmap_status parse(struct rmap_criterion *criterion,
                              const struct rmap_criteria *criteria,
                              const struct rmap_index_set *detector, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node node;
    struct rmap_parser parser = {
        .criterion = criterion, .text = criterion->text, .criteria = criteria, .err = err};
    RMAP_TRY(rmap_criterion_check_utf8(parser.text, err));
    RMAP_TRY(rmap_names_create(criterion->scene, &parser.names, err));
    RMAP_TRY(rmap_parser_advance(&parser));
    if (detector) {
        RMAP_TRY(rmap_parse_which(&parser, detector, &node));
        st = rmap_criterion_node_add(criterion, &node, &criterion->root, err);
        goto out;
    }
    if (parser.token.kind == RMAP_TOKEN_END) {
        st = RMAP_PARSER_FAIL(&parser, &parser.token,
                              "the criterion is empty (all rays: write 'all')");
        goto out;
    }
    RMAP_TRY(rmap_parse_logic(&parser, &criterion->root));
    if (parser.token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(&parser, "'and', 'or' or the end");
out:
    rmap_names_destroy(parser.names);
    return st;
}

enum rmap_status rmap_criterion_parse(struct rmap_criterion *criterion,
                                      const struct rmap_criteria *criteria, struct rmap_error *err)
{
    return parse(criterion, criteria, NULL, err);
}

enum rmap_status rmap_criterion_parse_which(struct rmap_criterion *criterion,
                                            const struct rmap_criteria *criteria,
                                            const struct rmap_index_set *detector,
                                            struct rmap_error *err)
{
    return parse(criterion, criteria, detector, err);
}

/* Tests of a ray's steps: hit, event, medium, and of a registration: after, at. */

static const char *const event_words[] = {
#define ROW(symbol, bit, letter, word, meaning) word,
    RMAP_EVENT_TABLE(ROW)
#undef ROW
#define ROW(word, mask) word,
        RMAP_EVENT_UNION_TABLE(ROW)
#undef ROW
};

enum rmap_status rmap_parse_event(struct rmap_parser *parser, uint32_t *events)
{
    struct rmap_token token = parser->token;
    char word[RMAP_TOKEN_NAME_NBYTES + 1];
    if (token.kind != RMAP_TOKEN_WORD)
        return rmap_parser_expected(parser, "the name of an event");
    if (*events)
        return RMAP_PARSER_FAIL(parser, &token, "only one event can be given");
    rmap_parser_word(parser, &token, word);
    *events = rmap_event_mask(word);
    if (!*events)
        return rmap_parser_fail_word(parser, &token, "event", event_words,
                                     sizeof event_words / sizeof *event_words);
    return rmap_parser_advance(parser);
}

/* Faces or triangles of an object; analytic surfaces are one face of one triangle. */
static size_t part_count(const struct rmap_scene *scene, int32_t object, enum rmap_part part)
{
    const struct rmap_mesh *mesh = scene->geometry[scene->object[object].geometry].mesh;
    if (!mesh)
        return 1;
    return part == RMAP_PART_FACE ? mesh->n_face : mesh->n_triangle;
}

static enum rmap_status parse_part(struct rmap_parser *parser, enum rmap_part part,
                                   struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    const char *noun = part == RMAP_PART_FACE ? "face" : "triangle";
    struct rmap_token word = parser->token;
    if (steps->part != RMAP_PART_ALL)
        return RMAP_PARSER_FAIL(parser, &word, "only one range of faces or triangles can be given");
    steps->part = part;
    RMAP_TRY(rmap_parser_advance(parser));
    struct rmap_token number = parser->token;
    size_t most = 0;
    for (size_t o = 0; o < scene->n_object; o++)
        if (rmap_index_set_has(&steps->object, (int32_t)o)) {
            size_t n = part_count(scene, (int32_t)o, part);
            most = n > most ? n : most;
        }
    if (number.kind == RMAP_TOKEN_WORD || number.kind == RMAP_TOKEN_QUOTED) {
        char what[80];
        (void)snprintf(what, sizeof what, "the number of a %s, 0 to %zu here (none has a name)",
                       noun, most ? most - 1 : 0);
        return rmap_parser_expected(parser, what);
    }
    RMAP_TRY(rmap_parse_index_range(parser, &steps->part_low, &steps->part_high));
    if (steps->part_low >= most)
        st = RMAP_PARSER_FAIL(parser, &number, "there is no %s %u: %s 0 to %zu exist here", noun,
                              steps->part_low, noun, most ? most - 1 : 0);
out:
    return st;
}

/* What of a step a test asks: its object, event, part, and side: bits as in rmap_step_test. */
struct asked {
    struct rmap_step_test *steps;
    unsigned side;
};

static enum rmap_status parse_side(struct rmap_parser *parser, unsigned *side)
{
    static const char *const words[] = {"front", "back"};
    enum rmap_status st = RMAP_OK;
    struct rmap_token word = parser->token;
    if (*side)
        return RMAP_PARSER_FAIL(parser, &word, "only one side can be given");
    RMAP_TRY(rmap_parser_advance(parser));
    for (unsigned k = 0; k < 2; k++)
        *side |= (unsigned)rmap_parser_at_word(parser, words[k]) << k;
    if (!*side)
        return rmap_parser_expected(parser, "front or back");
    RMAP_TRY(rmap_parser_advance(parser));
out:
    return st;
}

static enum rmap_status parse_asked(struct rmap_parser *parser, struct asked *asked)
{
    if (rmap_parser_at_word(parser, "face"))
        return parse_part(parser, RMAP_PART_FACE, asked->steps);
    if (rmap_parser_at_word(parser, "triangle"))
        return parse_part(parser, RMAP_PART_TRIANGLE, asked->steps);
    if (rmap_parser_at_word(parser, "side"))
        return parse_side(parser, &asked->side);
    return rmap_parse_event(parser, &asked->steps->events);
}

/* `, ...)` */
static enum rmap_status parse_more(struct rmap_parser *parser, struct asked *asked)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_step_test *steps = asked->steps;
    const size_t n_object = parser->criterion->scene->n_object;
    void *block = NULL;
    while (parser->token.kind == RMAP_TOKEN_COMMA) {
        RMAP_TRY(rmap_parser_advance(parser));
        if (rmap_parser_at_word(parser, "where"))
            break;
        RMAP_TRY(parse_asked(parser, asked));
    }
    RMAP_TRY(rmap_parse_step_end(parser, steps, "',' or ')'"));
    if (!asked->side)
        goto out;
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, n_object, 1, &block, parser->err));
    steps->side = block;
    for (size_t o = 0; o < n_object; o++)
        steps->side[o] = rmap_index_set_has(&steps->object, (int32_t)o) ? (uint8_t)asked->side : 0;
out:
    return st;
}

enum rmap_status rmap_parse_hit(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct asked asked = {.steps = &node->steps};
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.of_object = true;
    const struct rmap_token *word = &parser->word;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    if (rmap_parser_at_word(parser, "where") && !rmap_names_lookup(parser->names, "where"))
        return RMAP_PARSER_FAIL(parser, &parser->token,
                                "expected the name of an object before 'where', or * for any: "
                                "'%.*s(* where ...)'",
                                (int)(word->end - word->begin), parser->text + word->begin);
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_OBJECT, &node->steps.object));
    RMAP_TRY(parse_more(parser, &asked));
out:
    return st;
}

/* Objects that the detectors of the `where` in hand lie on; RMAP_INPUT without any. */
static enum rmap_status set_lain_on(struct rmap_parser *parser, struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    bool any = false;
    uint8_t *mark = rmap_alloc(scene->n_object + 1, 1);
    if (!mark)
        return rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the objects");
    for (size_t d = 0; d < scene->n_detector; d++)
        for (size_t o = 0; rmap_index_set_has(parser->detector, (int32_t)d) && o < scene->n_object;
             o++) {
            mark[o] |= rmap_detector_lies_at(scene, &scene->detector[d], o);
            any |= mark[o];
        }
    if (any)
        st = rmap_parser_pack_set(parser, mark, scene->n_object, &steps->object);
    else
        st =
            RMAP_PARSER_FAIL(parser, &parser->word,
                             "'at' is of detectors that lie on an object ('on' in the scene); free "
                             "in space there is no step at the detector's place");
    rmap_free(mark);
    return st;
}

static bool at_asked(const struct rmap_parser *parser)
{
    char word[RMAP_TOKEN_NAME_NBYTES + 1];
    if (parser->token.kind != RMAP_TOKEN_WORD)
        return false;
    rmap_parser_word(parser, &parser->token, word);
    return rmap_event_mask(word) != 0 || strcmp(word, "face") == 0 ||
           strcmp(word, "triangle") == 0 || strcmp(word, "side") == 0;
}

enum rmap_status rmap_parse_at(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct asked asked = {.steps = &node->steps};
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.of = RMAP_STEPS_OWN;
    node->steps.of_object = true;
    RMAP_TRY(set_lain_on(parser, &node->steps));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    if (at_asked(parser))
        RMAP_TRY(parse_asked(parser, &asked));
    else if (!rmap_parser_at_word(parser, "where"))
        RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_OBJECT, &node->steps.object));
    RMAP_TRY(parse_more(parser, &asked));
out:
    return st;
}

enum rmap_status rmap_parse_event_test(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    node->kind = RMAP_CRITERION_STEPS;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_event(parser, &node->steps.events));
    RMAP_TRY(rmap_parse_step_end(parser, &node->steps, "')'"));
out:
    return st;
}

enum rmap_status rmap_parse_medium(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.of_medium = true;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_MEDIUM, &node->steps.medium));
    RMAP_TRY(rmap_parse_step_end(parser, &node->steps, "')'"));
out:
    return st;
}

enum rmap_status rmap_parse_after(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    node->steps.of = RMAP_STEPS_LAST;
    return rmap_parse_hit(parser, node);
}

/* Steps lettered O F S I R T D d: a limit or an error takes the letter. */
enum rmap_status rmap_parse_bounces(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    (void)parser;
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.events = RMAP_EVENT_ELEMENT | RMAP_EVENT_FLUORESCE | RMAP_EVENT_SCATTER_VOLUME |
                         RMAP_EVENT_TOTAL_REFLECTION | RMAP_EVENT_REFLECT_SPECULAR |
                         RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE |
                         RMAP_EVENT_TRANSMIT_DIFFUSE;
    node->steps.events_not = RMAP_EVENT_LIMIT | RMAP_EVENT_ERROR;
    return RMAP_OK;
}

/* Objects that make ghosts, and on which side where that matters. */
static enum rmap_status set_ghosts(struct rmap_parser *parser, const struct rmap_path_order *order,
                                   struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    void *block = NULL;
    uint8_t *mark = rmap_alloc(order->n_object + 1, 1);
    if (!mark)
        return rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the criterion");
    for (size_t o = 0; o < order->n_object; o++)
        mark[o] = order->makes_ghosts[o] != 0;
    RMAP_TRY(rmap_parser_pack_set(parser, mark, order->n_object, &steps->object));
    if (!order->by_side)
        goto out;
    RMAP_TRY(
        rmap_criterion_block_add(parser->criterion, order->n_object + 1, 1, &block, parser->err));
    steps->side = memcpy(block, order->makes_ghosts, order->n_object);
out:
    rmap_free(mark);
    return st;
}

enum rmap_status rmap_parse_ghost_order(struct rmap_parser *parser,
                                        struct rmap_criterion_node *node)
{
    struct rmap_path_order order = {0};
    enum rmap_status st = rmap_path_order_init(&order, parser->criterion->scene, parser->err);
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.of_object = true;
    node->steps.events = RMAP_PATH_GHOST_EVENTS;
    if (st == RMAP_OK)
        st = set_ghosts(parser, &order, &node->steps);
    rmap_path_order_fini(&order);
    return st;
}

enum rmap_status rmap_parse_scatter_order(struct rmap_parser *parser,
                                          struct rmap_criterion_node *node)
{
    (void)parser;
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.events = RMAP_PATH_SCATTER_EVENTS;
    return RMAP_OK;
}

/* The test path("..."). */

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
