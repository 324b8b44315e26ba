/* SPDX-License-Identifier: MIT
 *
 * Numbers compared with each other.
 */
#include "analysis/criterion/criterion_sum.h"

#include <math.h>

#include "analysis/criterion/criterion_detector.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/step_number.h"

/* ---- reading ---- */

/* The token behind one; END where there is none that can be read. */
static struct rmap_token behind(const struct rmap_parser *parser, const struct rmap_token *token)
{
    struct rmap_token next = {.kind = RMAP_TOKEN_END};
    if (rmap_token_read(parser->text, token->end, &next, NULL) != RMAP_OK)
        next.kind = RMAP_TOKEN_END;
    return next;
}

/* A sign between terms: of its own, or that of a number. */
static bool is_sign(const struct rmap_parser *parser, const struct rmap_token *token)
{
    const char c = parser->text[token->begin];
    return token->kind == RMAP_TOKEN_PLUS || token->kind == RMAP_TOKEN_MINUS ||
           (token->kind == RMAP_TOKEN_NUMBER && (c == '+' || c == '-'));
}

static bool is_times(const struct rmap_parser *parser, const struct rmap_token *token)
{
    return rmap_token_is(parser->text, token, "*");
}

/* The word of a number that sums may have. */
static const struct rmap_word *number_word(const struct rmap_parser *parser,
                                           const struct rmap_token *token)
{
    const struct rmap_word *word =
        token->kind == RMAP_TOKEN_WORD ? rmap_word_at(parser, token) : NULL;
    return word && (word->of_registration || word->of_ray) ? word : NULL;
}

static bool is_number(const struct rmap_parser *parser, const struct rmap_token *token)
{
    return parser->of_step ? rmap_step_number_is(parser, token)
                           : number_word(parser, token) != NULL;
}

/* Behind a number's word and the name of its detector, if there is one. */
static struct rmap_token behind_number(const struct rmap_parser *parser,
                                       const struct rmap_token *word)
{
    struct rmap_token next = behind(parser, word);
    if (next.kind != RMAP_TOKEN_OPEN)
        return next;
    while (next.kind != RMAP_TOKEN_CLOSE && next.kind != RMAP_TOKEN_END)
        next = behind(parser, &next);
    return behind(parser, &next);
}

bool rmap_parser_at_sum(const struct rmap_parser *parser)
{
    struct rmap_token next = behind(parser, &parser->token);
    if (parser->token.kind == RMAP_TOKEN_NUMBER)
        return is_times(parser, &next);
    if (!is_number(parser, &parser->token))
        return false;
    next = behind_number(parser, &parser->token);
    if (!rmap_token_is_relation(&next))
        return is_sign(parser, &next) || is_times(parser, &next);
    struct rmap_token right = behind(parser, &next);
    if (right.kind != RMAP_TOKEN_NUMBER)
        return is_number(parser, &right);
    next = behind(parser, &right);
    if (is_times(parser, &next))
        return true;
    if (next.kind == RMAP_TOKEN_WORD) /* a unit */
        next = behind(parser, &next);
    return is_sign(parser, &next);
}

enum { TERMS_MAX = 16 };

/* A sum as it grows. */
struct making {
    struct rmap_sum_term term[TERMS_MAX];
    size_t n;
    double constant;
    enum rmap_dimension dimension; /* once there is a term */
};

static enum rmap_status add_term(struct rmap_parser *parser, struct making *making,
                                 const struct rmap_token *word, const struct rmap_sum_term *term,
                                 enum rmap_dimension dimension)
{
    if (making->n == TERMS_MAX)
        return RMAP_PARSER_FAIL(parser, word, "more than %d numbers in one comparison", TERMS_MAX);
    if (making->n > 0 && dimension != making->dimension)
        return RMAP_PARSER_FAIL(parser, word,
                                "this number is in another unit than those before it");
    if (dimension == RMAP_DIMENSION_MIXED)
        return RMAP_PARSER_FAIL(parser, word, "the detectors differ in their units");
    making->dimension = dimension;
    making->term[making->n++] = *term;
    return RMAP_OK;
}

static enum rmap_status fail_alone(const struct rmap_parser *parser, const struct rmap_token *word,
                                   const char *name)
{
    return RMAP_PARSER_FAIL(parser, word, "%.*s%s is compared with values alone, not in sums",
                            (int)(word->end - word->begin), parser->text + word->begin, name);
}

/* A number of the ray, of its registrations on a detector, or of the registration in hand. */
static enum rmap_status parse_its_number(struct rmap_parser *parser, struct rmap_sum_term *term,
                                         enum rmap_dimension *dimension)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_word *word = number_word(parser, &parser->token);
    const struct rmap_index_set *its = parser->detector;
    const struct rmap_token token = parser->token;
    const struct rmap_word *alone = rmap_word_at(parser, &token);
    if (alone && !word && (alone->is_number || rmap_parser_at_word(parser, "event")))
        return fail_alone(parser, &token, "");
    if (!word || (its && !word->of_registration))
        return rmap_parser_expected(parser, its ? "a number of a registration such as x"
                                                : "a number such as x(NAME) or path_length");
    term->ray_number = word->ray_number;
    *dimension = word->dimension;
    RMAP_TRY(rmap_parser_advance(parser));
    if (!word->of_registration && parser->token.kind == RMAP_TOKEN_OPEN)
        return fail_alone(parser, &token, "(NAME)");
    if (!its && parser->token.kind != RMAP_TOKEN_OPEN && word->of_registration)
        its = parser->given;
    if (its) {
        term->detector = *its;
    } else if (word->of_registration && (!word->of_ray || parser->token.kind == RMAP_TOKEN_OPEN)) {
        RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'(' and the name of a detector"));
        RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_DETECTOR, &term->detector));
        RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    } else {
        return RMAP_OK;
    }
    term->of_registration = true;
    term->its_number = rmap_time_in(parser->criterion->scene, word->its_number);
    *dimension =
        rmap_its_number_dimension(parser->criterion->scene, term->its_number, &term->detector);
out:
    return st;
}

static enum rmap_status parse_number(struct rmap_parser *parser, double factor,
                                     struct making *making)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_token token = parser->token;
    struct rmap_sum_term term = {.factor = factor};
    enum rmap_dimension dimension;
    RMAP_TRY(parser->of_step ? rmap_parse_step_number(parser, &term.step_number, &dimension)
                             : parse_its_number(parser, &term, &dimension));
    if (is_times(parser, &parser->token))
        return RMAP_PARSER_FAIL(parser, &parser->token, "the factor stands before: '2 * %.*s'",
                                (int)(parser->taken_end - token.begin), parser->text + token.begin);
    st = add_term(parser, making, &token, &term, dimension);
out:
    return st;
}

/* FACTOR * NUMBER, NUMBER, or a value. */
static enum rmap_status parse_term(struct rmap_parser *parser, double sign, struct making *making)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_token next = behind(parser, &parser->token);
    double value = 0.0;
    if (parser->token.kind != RMAP_TOKEN_NUMBER)
        return parse_number(parser, sign, making);
    if (is_times(parser, &next)) {
        const double factor = sign * parser->token.number;
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(rmap_parser_advance(parser));
        return parse_number(parser, factor, making);
    }
    if (making->n == 0)
        return parser->of_step
                   ? parse_number(parser, sign, making)
                   : rmap_parser_expected(parser, "a number such as x(NAME), then the value");
    RMAP_TRY(rmap_parse_value(parser, making->dimension, &value));
    making->constant += sign * value;
out:
    return st;
}

static enum rmap_status parse_side(struct rmap_parser *parser, double side, struct making *making)
{
    enum rmap_status st = RMAP_OK;
    double sign = side;
    for (;;) {
        RMAP_TRY(parse_term(parser, sign, making));
        if (!is_sign(parser, &parser->token))
            break;
        sign = parser->token.kind == RMAP_TOKEN_MINUS ? -side : side;
        if (parser->token.kind != RMAP_TOKEN_NUMBER)
            RMAP_TRY(rmap_parser_advance(parser));
    }
out:
    return st;
}

static enum rmap_status parse_relation(struct rmap_parser *parser, struct rmap_interval *interval)
{
    const double infinity = (double)INFINITY;
    *interval = (struct rmap_interval){-infinity, infinity, false};
    switch (parser->token.kind) {
    case RMAP_TOKEN_LT:
        interval->high = nextafter(0.0, -infinity);
        break;
    case RMAP_TOKEN_LE:
        interval->high = 0.0;
        break;
    case RMAP_TOKEN_GT:
        interval->low = nextafter(0.0, infinity);
        break;
    case RMAP_TOKEN_GE:
        interval->low = 0.0;
        break;
    default:
        return rmap_parser_expected(
            parser, "<, <=, > or >= (numbers are compared with each other by these)");
    }
    return rmap_parser_advance(parser);
}

/* The terms, with memory of the criterion. */
static enum rmap_status keep(struct rmap_parser *parser, const struct making *making,
                             struct rmap_sum *sum)
{
    void *block = NULL;
    enum rmap_status st = rmap_criterion_block_add(parser->criterion, making->n,
                                                   sizeof *making->term, &block, parser->err);
    struct rmap_sum_term *term = block;
    for (size_t k = 0; st == RMAP_OK && k < making->n; k++)
        term[k] = making->term[k];
    *sum = (struct rmap_sum){term, making->n, making->constant};
    return st;
}

enum rmap_status rmap_parse_sum_alone(struct rmap_parser *parser, struct rmap_sum *sum,
                                      enum rmap_dimension *dimension_ret)
{
    enum rmap_status st = RMAP_OK;
    struct making making = {.n = 0};
    RMAP_TRY(parse_side(parser, 1.0, &making));
    *dimension_ret = making.dimension;
    st = keep(parser, &making, sum);
out:
    return st;
}

enum rmap_status rmap_parse_comparison(struct rmap_parser *parser, struct rmap_sum *sum,
                                       struct rmap_interval *interval)
{
    enum rmap_status st = RMAP_OK;
    struct making making = {.n = 0};
    RMAP_TRY(parse_side(parser, 1.0, &making));
    RMAP_TRY(parse_relation(parser, interval));
    RMAP_TRY(parse_side(parser, -1.0, &making));
    if (rmap_parser_at_comparison(parser))
        RMAP_TRY(RMAP_PARSER_FAIL(parser, &parser->token, "a comparison has two sides"));
    st = keep(parser, &making, sum);
out:
    return st;
}

enum rmap_status rmap_parse_sum(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node node = {
        .kind = RMAP_CRITERION_SUM, .first = -1, .next = -1, .begin = parser->token.begin};
    RMAP_TRY(rmap_parse_comparison(parser, &node.sum, &node.interval));
    node.end = parser->taken_end;
    RMAP_TRY(rmap_criterion_node_add(parser->criterion, &node, node_ret, parser->err));
out:
    return st;
}

/* ---- what they are ---- */

rmap_column_set rmap_sum_columns(const struct rmap_sum *sum)
{
    rmap_column_set columns = 0;
    for (size_t k = 0; k < sum->n; k++) {
        const struct rmap_sum_term *term = &sum->term[k];
        columns |= !term->of_registration ? rmap_ray_number_columns(term->ray_number)
                                          : rmap_registration_number_columns(term->its_number) |
                                                RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                                                RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) |
                                                RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    }
    return columns;
}

/* The least and the greatest value that a sum can have. */
struct range {
    double low, high;
};

/* False: the number is not defined. */
static bool add_value(struct range *sum, double factor, double least, double greatest)
{
    const double a = factor * least, b = factor * greatest;
    sum->low += fmin(a, b);
    sum->high += fmax(a, b);
    return least <= greatest;
}

static bool add_registrations(const struct rmap_scene *scene, const struct rmap_sum_term *term,
                              const struct rmap_portion *portion, size_t first, size_t n,
                              struct range *sum)
{
    const struct rmap_registration_columns *its = &portion->registration;
    double least = (double)INFINITY, greatest = -(double)INFINITY;
    for (size_t row = first; row < first + n; row++) {
        if (!its->registered[row] || !rmap_index_set_has(&term->detector, its->detector[row]))
            continue;
        const double value = rmap_registration_number(scene, portion, row, term->its_number);
        least = value < least ? value : least;
        greatest = value > greatest ? value : greatest;
    }
    return least <= greatest && add_value(sum, term->factor, least, greatest);
}

/* Whether any value in the range lies in an interval that is open to one side. */
static bool meets(const struct range *sum, const struct rmap_interval *interval)
{
    return sum->low <= interval->high && sum->high >= interval->low;
}

/* False: a number of it is not defined. */
static bool range_of_ray(const struct rmap_scene *scene, const struct rmap_sum *sum,
                         const struct rmap_portion *portion, const double *flux_per_weight,
                         size_t i, size_t first, size_t n, struct range *range)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    *range = (struct range){sum->constant, sum->constant};
    for (size_t k = 0; k < sum->n; k++) {
        const struct rmap_sum_term *term = &sum->term[k];
        if (term->of_registration) {
            if (!add_registrations(scene, term, portion, first, n, range))
                return false;
            continue;
        }
        const bool knows =
            term->ray_number != RMAP_RAY_NUMBER_FLUX || (size_t)ray->source[i] < scene->n_source;
        const double value =
            knows ? rmap_ray_number_at(term->ray_number, scene, ray, i, flux_per_weight)
                  : (double)NAN;
        if (!add_value(range, term->factor, value, value))
            return false;
    }
    return true;
}

bool rmap_sum_is_bounded(const struct rmap_sum *sum)
{
    bool all = true;
    for (size_t k = 0; k < sum->n; k++)
        all &= !sum->term[k].of_registration && rmap_number_is_bounded(sum->term[k].ray_number);
    return all;
}

void rmap_sum_bound(const struct rmap_sum *sum, const struct rmap_path_sum *of, double bound[2])
{
    struct range range = {sum->constant, sum->constant};
    bool known = true;
    for (size_t k = 0; k < sum->n; k++) {
        double its[2];
        rmap_number_bound(sum->term[k].ray_number, of, its);
        known &= add_value(&range, sum->term[k].factor, its[0], its[1]);
    }
    bound[0] = known ? range.low : (double)NAN;
    bound[1] = known ? range.high : (double)NAN;
}

bool rmap_sum_holds_for_ray(const struct rmap_criterion *criterion,
                            const struct rmap_criterion_node *node,
                            const struct rmap_portion *portion, const double *flux_per_weight,
                            size_t i, size_t first, size_t n)
{
    struct range range;
    return range_of_ray(criterion->scene, &node->sum, portion, flux_per_weight, i, first, n,
                        &range) &&
           meets(&range, &node->interval);
}

double rmap_sum_of_ray(const struct rmap_scene *scene, const struct rmap_sum *sum,
                       const struct rmap_portion *portion, const double *flux_per_weight, size_t i,
                       size_t first, size_t n)
{
    struct range range;
    const bool is_one = range_of_ray(scene, sum, portion, flux_per_weight, i, first, n, &range) &&
                        range.low == range.high;
    return is_one ? range.low : (double)NAN;
}

bool rmap_sum_holds_for_registration(const struct rmap_criterion *criterion,
                                     const struct rmap_criterion_node *node,
                                     const struct rmap_portion *portion, size_t row)
{
    double value = node->sum.constant;
    for (size_t k = 0; k < node->sum.n; k++)
        value += node->sum.term[k].factor * rmap_registration_number(criterion->scene, portion, row,
                                                                     node->sum.term[k].its_number);
    return rmap_interval_holds(&node->interval, value);
}
