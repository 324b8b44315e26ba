/* SPDX-License-Identifier: MIT
 *
 * Tests of a ray's steps: hit, event, medium, and of a registration: after, at.
 */
#include <string.h>

#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/path_order.h"
#include "base/alloc.h"
#include "portion/event.h"

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
    RMAP_TRY(rmap_parse_index_range(parser, &steps->part_low, &steps->part_high));
    size_t most = 0;
    for (size_t o = 0; o < scene->n_object; o++)
        if (rmap_index_set_has(&steps->object, (int32_t)o)) {
            size_t n = part_count(scene, (int32_t)o, part);
            most = n > most ? n : most;
        }
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
        RMAP_TRY(parse_asked(parser, asked));
    }
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "',' or ')'"));
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
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
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
    else
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
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
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
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
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
