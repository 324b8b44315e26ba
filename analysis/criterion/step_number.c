/* SPDX-License-Identifier: MIT
 *
 * Numbers of a step, by which a test chooses among the steps of its kind.
 */
#include "analysis/criterion/step_number.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "base/vec.h"
#include "compact/step.h"

#define POSITION RMAP_COLUMN_BIT(RMAP_SEGMENT_position)
#define LEG                                                                                        \
    (POSITION | RMAP_COLUMN_BIT(RMAP_RAY_start) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |        \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_event))
#define OBJECT RMAP_COLUMN_BIT(RMAP_SEGMENT_object)

static const struct {
    const char *word;
    enum rmap_dimension dimension;
    rmap_column_set columns;
} number_table[] = {
    [RMAP_STEP_ANGLE] = {"angle", RMAP_DIMENSION_ANGLE, LEG | RMAP_COLUMN_BIT(RMAP_SEGMENT_normal)},
    [RMAP_STEP_X] = {"x", RMAP_DIMENSION_LENGTH, POSITION | OBJECT},
    [RMAP_STEP_Y] = {"y", RMAP_DIMENSION_LENGTH, POSITION | OBJECT},
    [RMAP_STEP_Z] = {"z", RMAP_DIMENSION_LENGTH, POSITION | OBJECT},
    [RMAP_STEP_WORLD_X] = {"world_x", RMAP_DIMENSION_LENGTH, POSITION},
    [RMAP_STEP_WORLD_Y] = {"world_y", RMAP_DIMENSION_LENGTH, POSITION},
    [RMAP_STEP_WORLD_Z] = {"world_z", RMAP_DIMENSION_LENGTH, POSITION},
    [RMAP_STEP_LENGTH] = {"length", RMAP_DIMENSION_LENGTH, LEG},
    [RMAP_STEP_PATH_LENGTH] = {"path_length", RMAP_DIMENSION_LENGTH, LEG},
    [RMAP_STEP_ORDER] = {"step", RMAP_DIMENSION_NONE, RMAP_COLUMN_BIT(RMAP_RAY_segment_count)},
    [RMAP_STEP_WAVELENGTH] = {"wavelength", RMAP_DIMENSION_WAVELENGTH,
                              RMAP_COLUMN_BIT(RMAP_SEGMENT_colour)},
    [RMAP_STEP_MODEL] = {NULL, RMAP_DIMENSION_NONE,
                         LEG | OBJECT | RMAP_COLUMN_BIT(RMAP_SEGMENT_normal) |
                             RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |
                             RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive) |
                             RMAP_COLUMN_BIT(RMAP_SEGMENT_colour) | RMAP_COLUMN_BIT(RMAP_RAY_id)},
};
enum { NUMBERS = RMAP_STEP_MODEL };

const char *rmap_step_number_word(size_t i)
{
    return i < NUMBERS ? number_table[i].word : NULL;
}

bool rmap_step_number_is(const struct rmap_parser *parser, const struct rmap_token *token)
{
    bool is = false;
    for (size_t i = 0; i < NUMBERS && token->kind == RMAP_TOKEN_WORD; i++)
        is |= rmap_token_is(parser->text, token, number_table[i].word);
    return is;
}

enum rmap_status rmap_parse_step_number(struct rmap_parser *parser,
                                        enum rmap_step_number *number_ret,
                                        enum rmap_dimension *dimension_ret)
{
    const char *word[NUMBERS];
    const struct rmap_token token = parser->token;
    for (size_t i = 0; i < NUMBERS; i++) {
        word[i] = number_table[i].word;
        if (rmap_parser_at_word(parser, word[i])) {
            *number_ret = (enum rmap_step_number)i;
            *dimension_ret = number_table[i].dimension;
            return rmap_parser_advance(parser);
        }
    }
    if (token.kind != RMAP_TOKEN_WORD)
        return rmap_parser_expected(parser, "a number of a step such as angle, x or length");
    return rmap_parser_fail_word(parser, &token, "number of a step", word, NUMBERS);
}

static enum rmap_status parse_limit(struct rmap_parser *parser, struct rmap_step_limit *limit)
{
    enum rmap_status st = RMAP_OK;
    enum rmap_dimension dimension;
    parser->of_step = true;
    if (rmap_parser_at_sum(parser)) {
        RMAP_TRY(rmap_parse_comparison(parser, &limit->sum, &limit->interval));
    } else {
        RMAP_TRY(rmap_parse_sum_alone(parser, &limit->sum, &dimension));
        if (!rmap_parser_at_comparison(parser))
            return rmap_parser_expected(parser, "a comparison, as in 'angle > 60' or 'x in -1..1'");
        RMAP_TRY(rmap_parse_interval(parser, dimension, &limit->interval));
    }
    parser->of_step = false;
out:
    return st;
}

static enum rmap_status parse_where(struct rmap_parser *parser, struct rmap_step_test *test)
{
    enum { MOST = 32 };
    enum rmap_status st = RMAP_OK;
    struct rmap_step_limit limit[MOST];
    void *block = NULL;
    size_t n = test->n_limit;
    if (n > 0)
        memcpy(limit, test->limit, n * sizeof *limit);
    do {
        struct rmap_step_limit more;
        if (n == MOST)
            return RMAP_PARSER_FAIL(parser, &parser->token, "more than %d conditions on a step",
                                    MOST);
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(parse_limit(parser, &more));
        /* What paths tell comes first: it can be asked for alone. */
        const size_t at = rmap_step_limits_known(limit, n, RMAP_COLUMNS_DISCRETE);
        const bool is_known = rmap_step_limits_known(&more, 1, RMAP_COLUMNS_DISCRETE) > 0;
        limit[n++] = is_known ? limit[at] : more;
        limit[is_known ? at : n - 1] = more;
    } while (parser->token.kind == RMAP_TOKEN_AND);
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, n, sizeof *limit, &block, parser->err));
    test->limit = memcpy(block, limit, n * sizeof *limit);
    test->n_limit = n;
out:
    return st;
}

enum rmap_status rmap_parse_step_end(struct rmap_parser *parser, struct rmap_step_test *test,
                                     const char *what)
{
    const bool limited = rmap_parser_at_word(parser, "where");
    enum rmap_status st = limited ? parse_where(parser, test) : RMAP_OK;
    return st == RMAP_OK
               ? rmap_parser_take(parser, RMAP_TOKEN_CLOSE, limited ? "'and' or ')'" : what)
               : st;
}

static rmap_column_set limit_columns(const struct rmap_step_limit *limit)
{
    rmap_column_set columns = 0;
    for (size_t k = 0; k < limit->sum.n; k++)
        columns |= number_table[limit->sum.term[k].step_number].columns;
    return columns;
}

rmap_column_set rmap_step_limit_columns(const struct rmap_step_test *test)
{
    rmap_column_set columns = 0;
    for (size_t i = 0; i < test->n_limit; i++)
        columns |= limit_columns(&test->limit[i]);
    return columns;
}

size_t rmap_step_limits_known(const struct rmap_step_limit *limit, size_t n,
                              rmap_column_set columns)
{
    size_t known = 0;
    while (known < n && !(limit_columns(&limit[known]) & ~columns))
        known++;
    return known;
}

/* The straight leg that ends in a row; NaN of a curved one. */
static struct rmap_vec3 leg(const struct rmap_portion *portion, size_t row, size_t ray,
                            size_t ray_row)
{
    const float *to = portion->segment.position + 3 * row;
    if (portion->segment.event[row] & RMAP_EVENT_GRADIENT)
        return rmap_vec3((double)NAN, (double)NAN, (double)NAN);
    return rmap_sub(rmap_vec3_of(to),
                    rmap_vec3_of(row > ray_row ? to - 3 : portion->ray.start + 3 * ray));
}

static double leg_length(const struct rmap_portion *portion, size_t row, size_t ray, size_t ray_row)
{
    if (portion->segment.event[row] & RMAP_EVENT_LEFT)
        return 0.0;
    return rmap_length(leg(portion, row, ray, ray_row));
}

static double path_length(const struct rmap_portion *portion, size_t row, size_t ray,
                          size_t ray_row)
{
    double sum = 0.0;
    for (size_t k = ray_row; k <= row; k++)
        sum += leg_length(portion, k, ray, ray_row);
    return sum;
}

static double incidence(const struct rmap_portion *portion, size_t row, size_t ray, size_t ray_row)
{
    const int16_t *n = portion->segment.normal + 3 * row;
    const struct rmap_vec3 light = leg(portion, row, ray, ray_row),
                           normal = rmap_vec3(n[0], n[1], n[2]);
    const double size = rmap_length(light) * rmap_length(normal);
    return size > 0.0 ? acos(fmin(fabs(rmap_dot(light, normal)) / size, 1.0)) * 180.0 / RMAP_PI
                      : (double)NAN;
}

/* nm, of the light that comes there; NaN where it has several. */
static double wavelength(const struct rmap_channels *channels, const struct rmap_portion *portion,
                         size_t row)
{
    const int channel = rmap_portion_channel(portion, row);
    const uint16_t *share = portion->colour + row * (size_t)portion->n_channel;
    return channels->mode == RMAP_COLOUR_SPECTRAL && share[channel] == UINT16_MAX
               ? channels->wavelength_nm[channel]
               : (double)NAN;
}

static const struct rmap_medium *medium_of(const struct rmap_scene *scene, int16_t medium)
{
    return medium >= 0 && (size_t)medium < scene->n_medium ? &scene->medium[medium] : NULL;
}

/* Of models beside each other the tracer's choice is made again, from the angle as it is stored. */
static double model_at(const struct rmap_scene *scene, const struct rmap_portion *portion,
                       size_t row, size_t ray, size_t ray_row)
{
    const struct rmap_segment_columns *segment = &portion->segment;
    const int16_t *n = segment->normal + 3 * row;
    const struct rmap_vec3 light = leg(portion, row, ray, ray_row),
                           normal = rmap_normalize(rmap_vec3(n[0], n[1], n[2]));
    const size_t next = row + (row + 1 < ray_row + portion->ray.segment_count[ray]);
    const struct rmap_turning turning = {.seed = scene->seed,
                                         .ray = portion->ray.id[ray],
                                         .step = (uint32_t)(row - ray_row) + 1,
                                         .event = segment->event[row],
                                         .near = medium_of(scene, segment->medium[row]),
                                         .far = medium_of(scene, segment->medium[next]),
                                         .channel = rmap_portion_channel(portion, next),
                                         .scene = scene,
                                         .object = segment->object[row],
                                         .primitive = segment->primitive[row],
                                         .front = rmap_dot(light, normal) < 0.0,
                                         .position = rmap_vec3_of(segment->position + 3 * row)};
    const struct rmap_draw draw = {turning.seed, turning.ray, turning.step};
    struct rmap_scatter_side side;
    if (!(rmap_dot(light, light) > 0.0) || (turning.near && turning.near->field) ||
        (turning.far && turning.far->field))
        return (double)NAN;
    return rmap_step_side(&turning, turning.front ? normal : rmap_scale(normal, -1.0), &side)
               ? rmap_scatter_picked(&side, (turning.event & RMAP_EVENT_TRANSMIT_DIFFUSE) != 0,
                                     rmap_normalize(light), &draw)
                     ->model
               : RMAP_SCATTER_LAMBERT;
}

static double coordinate(struct rmap_vec3 p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

static double number_at(const struct rmap_scene *scene, enum rmap_step_number number,
                        const struct rmap_portion *portion, size_t row, size_t ray, size_t ray_row)
{
    const struct rmap_segment_columns *segment = &portion->segment;
    switch (number) {
    case RMAP_STEP_ANGLE:
        return incidence(portion, row, ray, ray_row);
    case RMAP_STEP_X:
    case RMAP_STEP_Y:
    case RMAP_STEP_Z:
        return segment->object[row] < 0
                   ? (double)NAN
                   : coordinate(rmap_affine_point(&scene->object[segment->object[row]].to_local,
                                                  rmap_vec3_of(segment->position + 3 * row)),
                                (int)number - RMAP_STEP_X);
    case RMAP_STEP_WORLD_X:
    case RMAP_STEP_WORLD_Y:
    case RMAP_STEP_WORLD_Z:
        return (double)segment->position[3 * row + (size_t)number - RMAP_STEP_WORLD_X];
    case RMAP_STEP_LENGTH:
        return leg_length(portion, row, ray, ray_row);
    case RMAP_STEP_PATH_LENGTH:
        return path_length(portion, row, ray, ray_row);
    case RMAP_STEP_ORDER:
        return (double)(row - ray_row);
    case RMAP_STEP_WAVELENGTH:
        return wavelength(&scene->channels, portion, row);
    case RMAP_STEP_MODEL:
        return model_at(scene, portion, row, ray, ray_row);
    }
    return (double)NAN;
}

bool rmap_step_limits_hold(const struct rmap_scene *scene, const struct rmap_step_test *test,
                           const struct rmap_portion *portion, size_t row, size_t ray,
                           size_t ray_row)
{
    for (size_t i = 0; i < test->n_limit; i++) {
        const struct rmap_sum *sum = &test->limit[i].sum;
        double value = sum->constant;
        for (size_t k = 0; k < sum->n; k++)
            value += sum->term[k].factor *
                     number_at(scene, sum->term[k].step_number, portion, row, ray, ray_row);
        if (!rmap_interval_holds(&test->limit[i].interval, value))
            return false;
    }
    return true;
}
