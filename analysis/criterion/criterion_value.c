/* SPDX-License-Identifier: MIT
 *
 * Values in a criterion: numbers with units, comparisons, ranges, regions.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_value.h"
#include "base/alloc.h"
#include "base/vec.h"

/* A value in the written unit times `times`, over `over`, is in the map's. Two factors, so that
 * powers of ten stay exact: 120 um are 120 / 1000 mm. */
struct unit_factor {
    double times, over;
};

static struct unit_factor factor_of(double base, double own)
{
    double ratio = base / own;
    double times = round(ratio), over = round(1.0 / ratio);
    /* Ratios of powers of ten come out within a few ulp of a whole number. */
    if (ratio >= 1.0 && fabs(ratio - times) <= 1e-14 * ratio)
        return (struct unit_factor){times, 1.0};
    if (ratio < 1.0 && fabs(1.0 / ratio - over) <= 1e-14 / ratio)
        return (struct unit_factor){1.0, over};
    return (struct unit_factor){ratio, 1.0};
}

double rmap_unit_size_of(const struct rmap_scene *scene, enum rmap_dimension dimension)
{
    return dimension == RMAP_DIMENSION_WAVELENGTH ? 1e-9
           : dimension == RMAP_DIMENSION_LENGTH   ? scene->unit_m
           : dimension == RMAP_DIMENSION_ENERGY   ? RMAP_EV_J
                                                  : 1.0;
}

bool rmap_unit_fits(const struct rmap_written_unit *unit, enum rmap_dimension dimension,
                    const struct rmap_scene *scene)
{
    if (dimension == RMAP_DIMENSION_WAVELENGTH)
        dimension = RMAP_DIMENSION_LENGTH;
    if (dimension == RMAP_DIMENSION_FLUX && scene->flux_unit == RMAP_FLUX_J)
        dimension = RMAP_DIMENSION_ENERGY;
    return unit->in_criteria && unit->dimension == dimension &&
           (dimension != RMAP_DIMENSION_FLUX || unit->flux == scene->flux_unit);
}

void rmap_unit_list(enum rmap_dimension dimension, const struct rmap_scene *scene,
                    char list[RMAP_UNITS_NBYTES])
{
    const struct rmap_written_unit *unit;
    size_t len = 0;
    (void)snprintf(list, RMAP_UNITS_NBYTES, "none: %s",
                   dimension == RMAP_DIMENSION_MIXED ? "the detectors differ in theirs"
                                                     : "this is a plain number");
    for (size_t i = 0; (unit = rmap_unit_at(i)) != NULL && len < RMAP_UNITS_NBYTES; i++)
        if (rmap_unit_fits(unit, dimension, scene))
            len += (size_t)snprintf(list + len, RMAP_UNITS_NBYTES - len, "%s%s", len ? " " : "",
                                    unit->name);
}

/* A word behind a number is a unit, unless it begins the next test (a forgotten `and`). */
static bool at_unit(const struct rmap_parser *parser)
{
    const char *behind = parser->text + parser->token.end;
    return parser->token.kind == RMAP_TOKEN_WORD && behind[strspn(behind, " \t\r\n")] != '(' &&
           !rmap_parser_at_word(parser, "where");
}

static enum rmap_status parse_unit(struct rmap_parser *parser, enum rmap_dimension dimension,
                                   double own, struct unit_factor *factor)
{
    const struct rmap_scene *scene = parser->criterion->scene;
    const struct rmap_written_unit *unit = rmap_unit_named(parser->text + parser->token.begin,
                                                           parser->token.end - parser->token.begin);
    char units[RMAP_UNITS_NBYTES];
    if (unit && rmap_unit_fits(unit, dimension, scene)) {
        *factor = factor_of(unit->size, own);
        return rmap_parser_advance(parser);
    }
    if (parser->text[parser->token.begin] == '*')
        return RMAP_PARSER_FAIL(parser, &parser->token, RMAP_FACTOR_HINT);
    rmap_unit_list(dimension, scene, units);
    return RMAP_PARSER_FAIL(parser, &parser->token, "'%.*s' is no unit here (%s)",
                            (int)(parser->token.end - parser->token.begin < 32
                                      ? parser->token.end - parser->token.begin
                                      : 32),
                            parser->text + parser->token.begin, units);
}

struct value {
    double number;
    bool has_unit;
    struct unit_factor factor;
};

static enum rmap_status parse_value(struct rmap_parser *parser, enum rmap_dimension dimension,
                                    double own, struct value *value)
{
    enum rmap_status st = RMAP_OK;
    *value = (struct value){.number = parser->token.number, .factor = {1.0, 1.0}};
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_NUMBER, "a number"));
    value->has_unit = at_unit(parser);
    if (value->has_unit)
        RMAP_TRY(parse_unit(parser, dimension, own, &value->factor));
out:
    return st;
}

static double value_in(const struct value *value, const struct unit_factor *factor)
{
    return value->number * factor->times / factor->over;
}

enum rmap_status rmap_parse_range(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  double own, struct rmap_interval *interval)
{
    enum rmap_status st = RMAP_OK;
    struct value low, high;
    struct rmap_token begin = parser->token;
    RMAP_TRY(parse_value(parser, dimension, own, &low));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_RANGE, "'..' and the end of the range"));
    RMAP_TRY(parse_value(parser, dimension, own, &high));
    /* In `10..20 um` the unit is meant for both. */
    interval->low = value_in(&low, low.has_unit ? &low.factor : &high.factor);
    interval->high = value_in(&high, &high.factor);
    if (interval->low > interval->high)
        st = RMAP_PARSER_FAIL(parser, &begin, "this range runs backwards");
out:
    return st;
}

bool rmap_parser_at_comparison(const struct rmap_parser *parser)
{
    return rmap_token_is_relation(&parser->token) || rmap_parser_at_word(parser, "in");
}

enum rmap_status rmap_parse_interval(struct rmap_parser *parser, enum rmap_dimension dimension,
                                     struct rmap_interval *interval)
{
    enum rmap_status st = RMAP_OK;
    const double infinity = (double)INFINITY;
    const double own = rmap_unit_size_of(parser->criterion->scene, dimension);
    enum rmap_token_kind relation = parser->token.kind;
    *interval = (struct rmap_interval){-infinity, infinity, relation == RMAP_TOKEN_NE};
    RMAP_TRY(rmap_parser_advance(parser));
    if (relation == RMAP_TOKEN_WORD)
        return rmap_parse_range(parser, dimension, own, interval);
    struct value value;
    RMAP_TRY(parse_value(parser, dimension, own, &value));
    double v = value_in(&value, &value.factor);
    if (relation == RMAP_TOKEN_LT)
        interval->high = nextafter(v, -infinity);
    else if (relation == RMAP_TOKEN_LE)
        interval->high = v;
    else if (relation == RMAP_TOKEN_GT)
        interval->low = nextafter(v, infinity);
    else if (relation == RMAP_TOKEN_GE)
        interval->low = v;
    else
        interval->low = interval->high = v;
out:
    return st;
}

enum rmap_status rmap_parse_value(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  double *value_ret)
{
    struct value value;
    enum rmap_status st = parse_value(
        parser, dimension, rmap_unit_size_of(parser->criterion->scene, dimension), &value);
    if (st == RMAP_OK)
        *value_ret = value_in(&value, &value.factor);
    return st;
}

static enum rmap_status parse_index(struct rmap_parser *parser, uint32_t *index)
{
    const struct rmap_token *token = &parser->token;
    double v = token->number;
    if (token->kind == RMAP_TOKEN_NUMBER && (v < 0 || v > INT32_MAX || v != floor(v)))
        return RMAP_PARSER_FAIL(parser, token,
                                v > INT32_MAX ? "this number is too large: at most 2147483647"
                                              : "expected a whole number from 0");
    *index = token->kind == RMAP_TOKEN_NUMBER ? (uint32_t)v : 0;
    return rmap_parser_take(parser, RMAP_TOKEN_NUMBER, "a whole number");
}

enum rmap_status rmap_parse_index_range(struct rmap_parser *parser, uint32_t *low, uint32_t *high)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token begin = parser->token;
    RMAP_TRY(parse_index(parser, low));
    *high = *low;
    if (parser->token.kind == RMAP_TOKEN_RANGE) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(parse_index(parser, high));
    }
    if (*low > *high)
        st = RMAP_PARSER_FAIL(parser, &begin, "this range runs backwards");
out:
    return st;
}

enum rmap_dimension rmap_detector_dimension(const struct rmap_scene *scene,
                                            const struct rmap_index_set *detector)
{
    bool has[2] = {false, false};
    for (size_t d = 0; d < scene->n_detector; d++)
        if (rmap_index_set_has(detector, (int32_t)d))
            has[scene->detector[d].type == RMAP_DETECTOR_INTENSITY] = true;
    if (has[0] && has[1])
        return RMAP_DIMENSION_MIXED;
    return has[1] ? RMAP_DIMENSION_ANGLE : RMAP_DIMENSION_LENGTH;
}

/* Numbers of a region up to its closing parenthesis, with `rel` or `world` as the last word if it
 * stands. */
struct coordinates {
    struct value *value;
    size_t n, cap;
    bool relative;
    const struct rmap_detector *world; /* the one detector of coordinates in the world, or NULL */
};

/* Value i, x or y of a place. */
static double coordinate(const struct coordinates *list, size_t i)
{
    const double value = value_in(&list->value[i], &list->value[i].factor);
    return list->world ? rmap_detector_from_world(list->world, (int)(i % 2), value) : value;
}

/* The word `world` at hand. */
static enum rmap_status parse_world(struct rmap_parser *parser, const struct rmap_index_set *of,
                                    struct coordinates *list)
{
    const struct rmap_scene *scene = parser->criterion->scene;
    const struct rmap_token word = parser->token;
    size_t n = 0;
    for (size_t d = 0; d < scene->n_detector; d++)
        if (rmap_index_set_has(of, (int32_t)d)) {
            list->world = &scene->detector[d];
            n++;
        }
    if (n != 1 || rmap_detector_along(list->world, 0) < 0 ||
        rmap_detector_along(list->world, 1) < 0)
        return RMAP_PARSER_FAIL(parser, &word,
                                "'world' is for one plane whose x and y lie along axes of the "
                                "world; say where world_x in 0..1 and world_y in 0..1");
    return rmap_parser_advance(parser);
}

/* Lengths or angles on the detector; the fifth number of an ellipse is the angle it is turned by.
 */
static enum rmap_status parse_coordinates(struct rmap_parser *parser,
                                          const struct rmap_registration_test *test,
                                          struct coordinates *list)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_index_set *detector = &test->detector;
    const enum rmap_dimension places = rmap_detector_dimension(parser->criterion->scene, detector);
    for (;;) {
        const bool turn = test->region == RMAP_REGION_ELLIPSE && list->n == 4;
        const enum rmap_dimension dimension = turn ? RMAP_DIMENSION_ANGLE : places;
        if (list->n > 0 && rmap_parser_at_word(parser, "rel")) {
            list->relative = true;
            RMAP_TRY(rmap_parser_advance(parser));
            break;
        }
        if (list->n > 0 && rmap_parser_at_word(parser, "world")) {
            RMAP_TRY(parse_world(parser, detector, list));
            break;
        }
        RMAP_TRY(RMAP_RESERVE(list->value, list->cap, list->n + 1, parser->err));
        RMAP_TRY(parse_value(parser, dimension,
                             rmap_unit_size_of(parser->criterion->scene, dimension),
                             &list->value[list->n]));
        list->n++;
        if (parser->token.kind != RMAP_TOKEN_COMMA)
            break;
        RMAP_TRY(rmap_parser_advance(parser));
    }
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "',' or ')'"));
out:
    return st;
}

static enum rmap_status set_polygon(struct rmap_parser *parser, const struct rmap_token *word,
                                    const struct coordinates *list,
                                    struct rmap_registration_test *test)
{
    if (list->n < 6 || list->n % 2)
        return RMAP_PARSER_FAIL(parser, word, "polygon wants pairs x, y for three corners or more");
    void *block = NULL;
    enum rmap_status st = rmap_criterion_block_add(parser->criterion, list->n / 2,
                                                   sizeof *test->corner, &block, parser->err);
    if (st != RMAP_OK)
        return st;
    test->corner = block;
    test->n_corner = list->n / 2;
    for (size_t i = 0; i < list->n; i++)
        test->corner[i / 2][i % 2] = coordinate(list, i);
    return RMAP_OK;
}

static enum rmap_status add_boxes(struct rmap_parser *parser, struct rmap_registration_test *test)
{
    void *block = NULL;
    enum rmap_status st =
        rmap_criterion_block_add(parser->criterion, parser->criterion->scene->n_detector,
                                 sizeof *test->box, &block, parser->err);
    if (st == RMAP_OK)
        test->box = block;
    return st;
}

/* How many of the stored values 0 to 65535 are below v, or at most v. */
static uint32_t count_below(const struct rmap_detector *detector, int axis, bool relative, double v,
                            bool at_most)
{
    uint32_t low = 0, high = 65536;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        double its = rmap_detector_coordinate(detector, (uint16_t)middle, axis, relative);
        if (its < v || (at_most && its == v))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* A rectangle becomes the ranges of stored values that lie in it, per detector: rows then need
 * no arithmetic. */
static enum rmap_status set_rect(struct rmap_parser *parser, struct rmap_registration_test *test)
{
    const struct rmap_scene *scene = parser->criterion->scene;
    enum rmap_status st = add_boxes(parser, test);
    for (size_t d = 0; st == RMAP_OK && d < scene->n_detector; d++)
        for (int axis = 0; axis < 2; axis++) {
            double from = fmin(test->bound[axis], test->bound[axis + 2]);
            double to = fmax(test->bound[axis], test->bound[axis + 2]);
            const struct rmap_detector *detector = &scene->detector[d];
            uint32_t below = count_below(detector, axis, test->relative, from, false);
            uint32_t most = count_below(detector, axis, test->relative, to, true);
            test->box[d].low[axis] = most > 0 ? below : 1; /* 1 > 0: empty */
            test->box[d].high[axis] = most > 0 ? most - 1 : 0;
        }
    return st;
}

enum rmap_status rmap_parser_box_place(struct rmap_parser *parser,
                                       struct rmap_registration_test *test)
{
    const struct rmap_criterion_node *node =
        test->where < 0 ? NULL : &parser->criterion->node[test->where];
    if (!node || node->kind != RMAP_CRITERION_ITS_NUMBER || test->region != RMAP_REGION_ALL ||
        (node->its_number != RMAP_REGISTRATION_X && node->its_number != RMAP_REGISTRATION_Y) ||
        node->interval.outside || node->interval.low > node->interval.high)
        return RMAP_OK;
    const int axis = node->its_number == RMAP_REGISTRATION_Y;
    test->bound[axis] = node->interval.low;
    test->bound[axis + 2] = node->interval.high;
    test->bound[1 - axis] = -(double)INFINITY;
    test->bound[3 - axis] = (double)INFINITY;
    test->where = -1;
    return set_rect(parser, test);
}

static enum rmap_status set_bounds(struct rmap_parser *parser, const struct rmap_token *word,
                                   const struct coordinates *list,
                                   struct rmap_registration_test *test)
{
    double *b = test->bound;
    bool rect = test->region == RMAP_REGION_RECT;
    double turn = 0.0;
    if (list->n != 4 && (rect || list->n != 5))
        return RMAP_PARSER_FAIL(parser, word, "%s, not %zu%s",
                                rect ? "rect wants four numbers x0, y0, x1, y1"
                                     : "ellipse wants four numbers cx, cy, rx, ry (and an angle)",
                                list->n, list->n == 8 ? " (decimals have a point)" : "");
    for (size_t i = 0; i < 4; i++)
        b[i] =
            rect || i < 2 ? coordinate(list, i) : value_in(&list->value[i], &list->value[i].factor);
    if (rect)
        return set_rect(parser, test);
    if (!(b[2] > 0 && b[3] > 0))
        return RMAP_PARSER_FAIL(parser, word, "the half-axes of an ellipse must be > 0");
    if (list->n == 5 && list->relative)
        return RMAP_PARSER_FAIL(parser, word,
                                "an ellipse in relative coordinates cannot be turned: leave out "
                                "the angle, or 'rel'");
    if (list->n == 5)
        turn = value_in(&list->value[4], &list->value[4].factor) * RMAP_PI / 180.0;
    test->cosine = cos(turn);
    test->sine = sin(turn);
    return RMAP_OK;
}

static enum rmap_status parse_cells(struct rmap_parser *parser, struct rmap_registration_test *test)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_box box;
    RMAP_TRY(rmap_parse_index_range(parser, &box.low[0], &box.high[0]));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_COMMA, "',' and the second range of cells"));
    RMAP_TRY(rmap_parse_index_range(parser, &box.low[1], &box.high[1]));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    RMAP_TRY(add_boxes(parser, test));
    for (size_t d = 0; d < parser->criterion->scene->n_detector; d++)
        test->box[d] = box;
out:
    return st;
}

static enum rmap_region region_at(const struct rmap_parser *parser)
{
    static const struct {
        const char *word;
        enum rmap_region region;
    } table[] = {{"rect", RMAP_REGION_RECT},
                 {"ellipse", RMAP_REGION_ELLIPSE},
                 {"polygon", RMAP_REGION_POLYGON},
                 {"cells", RMAP_REGION_CELLS}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (rmap_parser_at_word(parser, table[i].word))
            return table[i].region;
    return RMAP_REGION_ALL;
}

bool rmap_parser_at_region(const struct rmap_parser *parser)
{
    return region_at(parser) != RMAP_REGION_ALL;
}

enum rmap_status rmap_parse_region(struct rmap_parser *parser, struct rmap_registration_test *test)
{
    enum rmap_status st = RMAP_OK;
    struct coordinates list = {0};
    struct rmap_token word = parser->token;
    if (test->region != RMAP_REGION_ALL)
        return RMAP_PARSER_FAIL(parser, &word, "only one region can be given");
    test->region = region_at(parser);
    if (test->region == RMAP_REGION_ALL)
        return rmap_parser_expected(parser, "rect, ellipse, polygon, cells or where");
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    if (test->region == RMAP_REGION_CELLS) {
        RMAP_TRY(parse_cells(parser, test));
        goto out;
    }
    RMAP_TRY(parse_coordinates(parser, test, &list));
    test->relative = list.relative;
    for (size_t i = 0; i < list.n; i++)
        if (list.relative && list.value[i].has_unit) {
            st = RMAP_PARSER_FAIL(parser, &word, "relative coordinates have no unit");
            goto out;
        }
    st = test->region == RMAP_REGION_POLYGON ? set_polygon(parser, &word, &list, test)
                                             : set_bounds(parser, &word, &list, test);
out:
    rmap_free(list.value);
    return st;
}
