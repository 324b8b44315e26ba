/* SPDX-License-Identifier: MIT
 *
 * Tests of a ray's steps: hit, event, medium, surface.
 */
#include <math.h>
#include <string.h>

#include "analysis/criterion_parser.h"
#include "analysis/path_order.h"
#include "base/alloc.h"
#include "trace/event.h"

static const char *const event_words[] = {
#define ROW(symbol, bit, letter, word, meaning) word,
    RMAP_EVENT_TABLE(ROW)
#undef ROW
#define ROW(word, mask) word,
        RMAP_EVENT_UNION_TABLE(ROW)
#undef ROW
};

static enum rmap_status parse_event(struct rmap_parser *parser, uint32_t *events)
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

enum rmap_status rmap_parse_hit(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_step_test *steps = &node->steps;
    node->kind = RMAP_CRITERION_STEPS;
    steps->of_object = true;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_OBJECT, &steps->object));
    while (parser->token.kind == RMAP_TOKEN_COMMA) {
        RMAP_TRY(rmap_parser_advance(parser));
        if (rmap_parser_at_word(parser, "face"))
            RMAP_TRY(parse_part(parser, RMAP_PART_FACE, steps));
        else if (rmap_parser_at_word(parser, "triangle"))
            RMAP_TRY(parse_part(parser, RMAP_PART_TRIANGLE, steps));
        else
            RMAP_TRY(parse_event(parser, &steps->events));
    }
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "',' or ')'"));
out:
    return st;
}

enum rmap_status rmap_parse_event_test(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    node->kind = RMAP_CRITERION_STEPS;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(parse_event(parser, &node->steps.events));
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

/* Objects that carry a marked surface, and on which side where that matters. */
static enum rmap_status set_surfaces(struct rmap_parser *parser, const struct rmap_index_set *set,
                                     struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    bool one_sided = false;
    uint8_t *mark = rmap_alloc(scene->n_object, 1);
    void *block = NULL;
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, scene->n_object, 1, &block, parser->err));
    if (!mark) {
        st = rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the surfaces");
        goto out;
    }
    uint8_t *side = block;
    for (size_t o = 0; o < scene->n_object; o++) {
        bool front = rmap_index_set_has(set, scene->object[o].surface_front);
        bool back = rmap_index_set_has(set, scene->object[o].surface_back);
        side[o] = (uint8_t)(front | back << 1);
        mark[o] = front || back;
        one_sided |= front != back;
    }
    steps->of_object = true;
    steps->side = one_sided ? side : NULL;
    RMAP_TRY(rmap_parser_pack_set(parser, mark, scene->n_object, &steps->object));
out:
    rmap_free(mark);
    return st;
}

static double channel_mean(const struct rmap_scene *scene, const double *value)
{
    double sum = 0.0;
    for (int c = 0; c < scene->channels.n; c++)
        sum += value[c];
    return scene->channels.n > 0 ? sum / scene->channels.n : 0.0;
}

enum parameter {
    PARAMETER_REFLECTANCE,
    PARAMETER_REFLECT_SPECULAR,
    PARAMETER_REFLECT_DIFFUSE,
    PARAMETER_TRANSMIT_SPECULAR,
    PARAMETER_TRANSMIT_DIFFUSE,
    PARAMETER_ABSORB
};
static const char *const parameter_words[] = {
    "reflectance",       "reflect_specular", "reflect_diffuse",
    "transmit_specular", "transmit_diffuse", "absorb",
};

static bool is_parameter(const struct rmap_parser *parser, const struct rmap_token *token)
{
    for (size_t i = 0; i < sizeof parameter_words / sizeof *parameter_words; i++)
        if (rmap_token_is(parser->text, token, parameter_words[i]))
            return true;
    return false;
}

/* Mean over the channels; NaN where it depends on the angle (bare glass, metal). */
static double surface_parameter(const struct rmap_scene *scene, const struct rmap_surface *surface,
                                enum parameter parameter)
{
    bool fresnel = surface->type == RMAP_SURFACE_FRESNEL;
    bool bare = fresnel && surface->coat == RMAP_COAT_NONE;
    bool metal = surface->type == RMAP_SURFACE_MIRROR && surface->is_metal;
    double reflect = channel_mean(scene, surface->reflect_specular);
    double diffuse = channel_mean(scene, surface->reflect_diffuse);
    double transmit = channel_mean(scene, surface->transmit_specular);
    double transmit_diffuse = channel_mean(scene, surface->transmit_diffuse);
    if (bare || metal)
        reflect = (double)NAN;
    else if (fresnel && surface->coat == RMAP_COAT_IDEAL)
        reflect = 0.0;
    if (fresnel)
        transmit = 1.0 - reflect;
    switch (parameter) {
    case PARAMETER_REFLECTANCE:
        return reflect + diffuse;
    case PARAMETER_REFLECT_SPECULAR:
        return reflect;
    case PARAMETER_REFLECT_DIFFUSE:
        return diffuse;
    case PARAMETER_TRANSMIT_SPECULAR:
        return transmit;
    case PARAMETER_TRANSMIT_DIFFUSE:
        return transmit_diffuse;
    case PARAMETER_ABSORB:
        return fresnel ? 0.0 : 1.0 - reflect - diffuse - transmit - transmit_diffuse;
    }
    return (double)NAN;
}

static enum rmap_status parse_parameter(struct rmap_parser *parser, const struct rmap_token *token,
                                        struct rmap_index_set *set)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_word = sizeof parameter_words / sizeof *parameter_words;
    const struct rmap_scene *scene = parser->criterion->scene;
    char word[RMAP_TOKEN_NAME_NBYTES + 1];
    size_t parameter = 0;
    struct rmap_interval interval;
    uint8_t *mark = NULL;
    rmap_parser_word(parser, token, word);
    while (parameter < n_word && strcmp(word, parameter_words[parameter]) != 0)
        parameter++;
    if (parameter == n_word)
        return rmap_parser_fail_word(parser, token, "surface parameter", parameter_words, n_word);
    RMAP_TRY(rmap_parse_interval(parser, RMAP_DIMENSION_NONE, &interval));
    mark = rmap_alloc(scene->n_surface, 1);
    if (!mark) {
        st = rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the surfaces");
        goto out;
    }
    for (size_t s = 0; s < scene->n_surface; s++)
        mark[s] = rmap_interval_holds(
            &interval, surface_parameter(scene, &scene->surface[s], (enum parameter)parameter));
    RMAP_TRY(rmap_parser_pack_set(parser, mark, scene->n_surface, set));
out:
    rmap_free(mark);
    return st;
}

enum rmap_status rmap_parse_surface(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token name;
    struct rmap_index_set set = {0};
    node->kind = RMAP_CRITERION_STEPS;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parser_take_name(parser, "the name of a surface property", &name));
    if (rmap_parser_at_comparison(parser)) {
        RMAP_TRY(parse_parameter(parser, &name, &set));
    } else {
        bool found = false;
        RMAP_TRY(rmap_parser_look_up(parser, &name, RMAP_WANTED_SURFACE, &set, &found));
        if (!found && is_parameter(parser, &name)) {
            st = RMAP_PARSER_FAIL(parser, &name,
                                  "'%.*s' is a number: compare it, as in 'surface(%.*s < 0.1)'",
                                  (int)(name.end - name.begin), parser->text + name.begin,
                                  (int)(name.end - name.begin), parser->text + name.begin);
            goto out;
        }
        if (!found) {
            st = rmap_names_fail(parser->names, parser->text, &name, RMAP_WANTED_SURFACE,
                                 parser->err);
            goto out;
        }
    }
    RMAP_TRY(set_surfaces(parser, &set, &node->steps));
    if (parser->token.kind == RMAP_TOKEN_COMMA) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(parse_event(parser, &node->steps.events));
    }
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "',' or ')'"));
out:
    return st;
}

enum rmap_status rmap_parse_after(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    node->steps.of_last = true;
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

enum rmap_status rmap_parse_ghost_order(struct rmap_parser *parser,
                                        struct rmap_criterion_node *node)
{
    struct rmap_path_order order = {0};
    enum rmap_status st = rmap_path_order_init(&order, parser->criterion->scene, parser->err);
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.of_object = true;
    node->steps.events = RMAP_PATH_GHOST_EVENTS;
    if (st == RMAP_OK)
        st = rmap_parser_pack_set(parser, order.makes_ghosts, order.n_object, &node->steps.object);
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
