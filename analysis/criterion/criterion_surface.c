/* SPDX-License-Identifier: MIT
 *
 * The tests surface(...) and scatter(...): which objects have such a surface, and on which side.
 */
#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/step_number.h"
#include "base/alloc.h"
#include "portion/event.h"

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

/* Models of a surface, as bits; Lambert's law of surfaces that need no model for it, too. */
static uint32_t models_of(const struct rmap_scene *scene, int32_t index, bool passes)
{
    const struct rmap_surface *surface = &scene->surface[index];
    const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, passes);
    uint32_t models = 0;
    if (!its && (surface->type == RMAP_SURFACE_LAMBERT || surface->type == RMAP_SURFACE_MIXTURE))
        return 1U << RMAP_SCATTER_LAMBERT;
    for (; its; its = its->next > 0 ? &scene->scatter[its->next - 1] : NULL)
        models |= 1U << its->model;
    return models;
}

const char *rmap_scatter_word(size_t i)
{
    return i < RMAP_SCATTER_COUNT ? rmap_scatter_name[i].name : NULL;
}

/* Sides of an object that scatter by one of the models, as in rmap_step_test. */
static unsigned sides_by(const struct rmap_scene *scene, const struct rmap_object *object,
                         uint32_t models)
{
    unsigned sides = 0;
    for (int way = 0; way < 2; way++)
        for (int back = 0; back < 2; back++) {
            const uint32_t its =
                models_of(scene, back ? object->surface_back : object->surface_front, way == 1);
            sides |= (unsigned)((its & models) != 0) << (2 * way + back);
        }
    return sides;
}

/* What no model of `all` does, no step does: such sides count as those that do. */
static enum rmap_status set_models(struct rmap_parser *parser, uint32_t models,
                                   struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    uint8_t *mark = rmap_alloc(scene->n_object + 1, 1);
    void *block = NULL;
    bool matters = false;
    RMAP_TRY(
        rmap_criterion_block_add(parser->criterion, scene->n_object + 1, 1, &block, parser->err));
    if (!mark) {
        st = rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the surfaces");
        goto out;
    }
    uint8_t *side = block;
    for (size_t o = 0; o < scene->n_object; o++) {
        const unsigned asked = sides_by(scene, &scene->object[o], models),
                       none = ~sides_by(scene, &scene->object[o], UINT32_MAX) & 15U;
        mark[o] = asked != 0;
        side[o] = (uint8_t)(asked ? asked | none : 0);
        matters = matters || (asked && side[o] != 15);
    }
    steps->of_object = true;
    steps->by_way = matters;
    steps->side = matters ? side : NULL;
    RMAP_TRY(rmap_parser_pack_set(parser, mark, scene->n_object, &steps->object));
out:
    rmap_free(mark);
    return st;
}

/* Is one of the models beside another one, so that the surface does not tell which it was? */
static bool is_beside(const struct rmap_scene *scene, uint32_t models)
{
    bool beside = false;
    for (size_t s = 0; s < scene->n_surface; s++)
        for (int way = 0; way < 2; way++) {
            const uint32_t its = models_of(scene, (int32_t)s, way == 1);
            beside = beside || ((its & models) && (its & ~models));
        }
    return beside;
}

static enum rmap_status limit_model(struct rmap_parser *parser, double model,
                                    struct rmap_step_test *steps)
{
    enum rmap_status st = RMAP_OK;
    void *block = NULL;
    struct {
        struct rmap_step_limit limit;
        struct rmap_sum_term term;
    } * its;
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, 1, sizeof *its, &block, parser->err));
    its = block;
    its->term = (struct rmap_sum_term){.factor = 1.0, .step_number = RMAP_STEP_MODEL};
    its->limit = (struct rmap_step_limit){{&its->term, 1, 0.0}, {model, model, false}};
    steps->limit = &its->limit;
    steps->n_limit = 1;
out:
    return st;
}

enum rmap_status rmap_parse_scatter(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token name;
    uint32_t models = 0;
    size_t model = 0;
    node->kind = RMAP_CRITERION_STEPS;
    node->steps.events = RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parser_take_name(parser, "a scatter model, or *", &name));
    const char *words[RMAP_SCATTER_COUNT];
    for (size_t i = 0; i < RMAP_SCATTER_COUNT; i++) {
        words[i] = rmap_scatter_name[i].name;
        if (!rmap_token_is(parser->text, &name, "*") &&
            !rmap_token_is(parser->text, &name, words[i]))
            continue;
        models |= 1U << i;
        model = i;
    }
    if (!models)
        return rmap_parser_fail_word(parser, &name, "scatter model", words, RMAP_SCATTER_COUNT);
    RMAP_TRY(set_models(parser, models, &node->steps));
    if (is_beside(parser->criterion->scene, models))
        RMAP_TRY(limit_model(parser, (double)model, &node->steps));
    RMAP_TRY(rmap_parse_step_end(parser, &node->steps, "')'"));
out:
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

const char *rmap_surface_parameter_word(size_t i)
{
    return i < sizeof parameter_words / sizeof *parameter_words ? parameter_words[i] : NULL;
}

static bool is_parameter(const struct rmap_parser *parser, const struct rmap_token *token)
{
    for (size_t i = 0; rmap_surface_parameter_word(i); i++)
        if (rmap_token_is(parser->text, token, parameter_words[i]))
            return true;
    return false;
}

/* Mean over the channels; NaN where it depends on the angle (bare glass, films, metal, models). */
static double surface_parameter(const struct rmap_scene *scene, const struct rmap_surface *surface,
                                enum parameter parameter)
{
    bool fresnel = rmap_surface_look(surface) == RMAP_LOOK_REFRACTING;
    bool film = fresnel && surface->coat == RMAP_COAT_FILM;
    bool bare = film || (fresnel && surface->coat == RMAP_COAT_NONE);
    bool metal = surface->is_metal;
    double reflect = channel_mean(scene, surface->reflect_specular);
    double diffuse = channel_mean(scene, surface->reflect_diffuse);
    double transmit = channel_mean(scene, surface->transmit_specular);
    double transmit_diffuse = channel_mean(scene, surface->transmit_diffuse);
    if (bare || metal)
        reflect = (double)NAN;
    if (rmap_surface_scatters(surface)) { /* shares by angle */
        const bool total = surface->reflect_is_total && !bare && !metal;
        return parameter == PARAMETER_REFLECTANCE && total ? reflect : (double)NAN;
    }
    if (metal)
        transmit = (double)NAN;
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
        return fresnel && !film ? 0.0 : 1.0 - reflect - diffuse - transmit - transmit_diffuse;
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
        RMAP_TRY(rmap_parse_event(parser, &node->steps.events));
    }
    RMAP_TRY(rmap_parse_step_end(parser, &node->steps, "',' or ')'"));
out:
    return st;
}
