/* SPDX-License-Identifier: MIT
 *
 * Any number of a ray or of its registrations, by the words of the criterion language: what
 * statistics are made of.
 */
#include "analysis/query/quantity.h"

#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_detector.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/path_in.h"
#include "analysis/criterion/registration_response.h"
#include "analysis/query/quantity_count.h"
#include "analysis/query/quantity_read.h"
#include "base/alloc.h"
#include "base/unit.h"

/* What of the language's words (criterion_word.h) is more than a number of it. */
static const struct own_word {
    const char *word;
    enum rmap_quantity_kind kind;
    const char *counts; /* COUNT: the test, with or without a detector */
} own_word_table[] = {
    {"cell", RMAP_QUANTITY_CELL, NULL},
    {"cell_i", RMAP_QUANTITY_CELL_I, NULL},
    {"cell_j", RMAP_QUANTITY_CELL_J, NULL},
    {"bounces", RMAP_QUANTITY_COUNT, "bounces >= 0"},
    {"ghost_order", RMAP_QUANTITY_GHOST_ORDER, NULL},
    {"scatter_order", RMAP_QUANTITY_SCATTER_ORDER, NULL},
    {"registrations", RMAP_QUANTITY_COUNT, "registered(*)"},
};
enum { N_OWN_WORD = sizeof own_word_table / sizeof *own_word_table };

static const struct own_word *own_word(const struct rmap_parser *parser)
{
    for (size_t i = 0; i < N_OWN_WORD; i++)
        if (rmap_parser_at_word(parser, own_word_table[i].word))
            return &own_word_table[i];
    return NULL;
}

static bool is_order(enum rmap_quantity_kind kind)
{
    return kind == RMAP_QUANTITY_GHOST_ORDER || kind == RMAP_QUANTITY_SCATTER_ORDER;
}

static const char *unit_of(const struct rmap_scene *scene, enum rmap_dimension dimension)
{
    switch (dimension) {
    case RMAP_DIMENSION_LENGTH:
        return scene->unit;
    case RMAP_DIMENSION_ANGLE:
        return "deg";
    case RMAP_DIMENSION_WAVELENGTH:
        return "nm";
    case RMAP_DIMENSION_TIME:
        return "s";
    case RMAP_DIMENSION_FLUX:
        return rmap_flux_unit_name(scene);
    case RMAP_DIMENSION_ENERGY:
        return "eV";
    case RMAP_DIMENSION_NONE:
    case RMAP_DIMENSION_SHARE:
    case RMAP_DIMENSION_TEMPERATURE:
    case RMAP_DIMENSION_PER_LENGTH:
    case RMAP_DIMENSION_MIXED:
        break;
    }
    return "";
}

struct making {
    struct rmap_quantities *self;
    struct rmap_parser parser;
    bool has_detector; /* self->detector is known */
    bool is_given;     /* by --detector */
};

static bool same_set(const struct rmap_quantities *self, const struct rmap_index_set *set)
{
    for (size_t d = 0; d < self->scene->n_detector; d++)
        if (rmap_index_set_has(set, (int32_t)d) != rmap_index_set_has(&self->detector, (int32_t)d))
            return false;
    return true;
}

/* "(detector)" behind the word of a registration's number, or nothing where it is clear. */
static enum rmap_status take_detector(struct making *making, const struct rmap_token *word)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_parser *parser = &making->parser;
    struct rmap_quantities *self = making->self;
    struct rmap_index_set set = {.low = 0, .span = 1};
    if (parser->token.kind == RMAP_TOKEN_OPEN) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_DETECTOR, &set));
        RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
    } else if (making->has_detector) {
        return RMAP_OK;
    } else if (self->scene->n_detector != 1) {
        return RMAP_PARSER_FAIL(parser, word, "'%.*s' of which detector? write %.*s(NAME)",
                                (int)(word->end - word->begin), parser->text + word->begin,
                                (int)(word->end - word->begin), parser->text + word->begin);
    }
    if (making->has_detector && !same_set(self, &set))
        return RMAP_PARSER_FAIL(parser, word, "all numbers must be of the same detector");
    self->detector = set;
    making->has_detector = true;
out:
    return st;
}

static enum rmap_status parse_its(struct making *making, struct rmap_quantity *quantity)
{
    struct rmap_token word = making->parser.token;
    enum rmap_status st = rmap_parser_advance(&making->parser);
    if (st == RMAP_OK)
        st = take_detector(making, &word);
    quantity->of_registration = true;
    if (st == RMAP_OK && quantity->kind == RMAP_QUANTITY_ITS_NUMBER)
        quantity->dimension = rmap_its_number_dimension(making->self->scene, quantity->its_number,
                                                        &making->self->detector);
    return st;
}

/* One test of the criterion language, whose text takes the parser to its end. */
static enum rmap_status parse_count(struct making *making, const struct own_word *own,
                                    struct rmap_quantity *quantity)
{
    quantity->kind = RMAP_QUANTITY_COUNT;
    quantity->is_whole = true;
    return rmap_quantity_parse_count(&making->parser, making->self->scene, own ? own->counts : NULL,
                                     &quantity->counted);
}

/* True when a parenthesis stands behind the next token. */
static bool is_called(const struct rmap_parser *parser)
{
    const char *behind = parser->text + parser->token.end;
    return behind[strspn(behind, " \t\r\n")] == '(';
}

/* With --detector it is of registrations there, else of the ray. */
static enum rmap_status parse_sum(struct making *making, struct rmap_quantity *quantity)
{
    struct rmap_parser *parser = &making->parser;
    const struct rmap_token first = parser->token;
    quantity->kind = RMAP_QUANTITY_SUM;
    quantity->of_registration = making->is_given;
    parser->given = making->is_given ? &making->self->detector : NULL;
    enum rmap_status st = rmap_parse_sum_alone(parser, &quantity->sum, &quantity->dimension);
    for (size_t k = 0; making->is_given && st == RMAP_OK && k < quantity->sum.n; k++)
        if (quantity->sum.term[k].of_registration &&
            !same_set(making->self, &quantity->sum.term[k].detector))
            st = RMAP_PARSER_FAIL(parser, &first, "all numbers must be of the same detector");
    return st;
}

static enum rmap_status parse_quantity(struct making *making, struct rmap_quantity *quantity)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_parser *parser = &making->parser;
    const struct own_word *own = own_word(parser);
    const struct rmap_word *word = rmap_word_next(parser);
    const bool is_its = word && word->of_registration;
    if (rmap_parser_at_sum(parser)) {
        st = parse_sum(making, quantity);
    } else if (word && word->ray_number == RMAP_RAY_NUMBER_PATH_LENGTH && is_called(parser)) {
        quantity->kind = RMAP_QUANTITY_PATH_IN;
        quantity->dimension = RMAP_DIMENSION_LENGTH;
        st = rmap_parser_advance(parser);
        if (st == RMAP_OK)
            st = rmap_parse_media(parser, &quantity->media);
    } else if (rmap_parser_at_word(parser, "event") && !is_called(parser)) {
        const char *trouble = rmap_scene_events_trouble(making->self->scene);
        if (trouble)
            return RMAP_PARSER_FAIL(parser, &parser->token, "%s", trouble);
        quantity->kind = RMAP_QUANTITY_RAY_NUMBER;
        quantity->ray_number = RMAP_RAY_NUMBER_EVENT;
        quantity->is_whole = true;
        st = rmap_parser_advance(parser);
    } else if (word && word->of_ray && !(is_its && (is_called(parser) || making->is_given))) {
        quantity->kind = RMAP_QUANTITY_RAY_NUMBER;
        quantity->ray_number = word->ray_number;
        quantity->dimension = word->dimension;
        quantity->is_whole = quantity->dimension == RMAP_DIMENSION_NONE;
        st = rmap_parser_advance(parser);
    } else if (is_its) {
        quantity->kind = RMAP_QUANTITY_ITS_NUMBER;
        quantity->its_number = rmap_time_in(making->self->scene, word->its_number);
        st = parse_its(making, quantity);
    } else if (own && is_order(own->kind)) {
        quantity->kind = own->kind;
        quantity->is_whole = true;
        st = is_called(parser) ? parse_its(making, quantity) : rmap_parser_advance(parser);
    } else if (own && own->kind != RMAP_QUANTITY_COUNT) {
        quantity->kind = own->kind;
        quantity->is_whole = true;
        st = parse_its(making, quantity);
    } else if (own || (word && word->in_stats && is_called(parser))) {
        return parse_count(making, own, quantity);
    } else if (word && word->wants) {
        return RMAP_PARSER_FAIL(parser, &parser->token, "'%s' wants in brackets %s", word->word,
                                word->wants);
    } else if (parser->token.kind != RMAP_TOKEN_WORD) {
        return rmap_parser_expected(parser, "a number such as wavelength or x(NAME)");
    } else {
        return rmap_word_fail(parser, &parser->token, "number", RMAP_WORDS_OF_STATS);
    }
    if (st == RMAP_OK && parser->token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(parser, "the end");
    return st;
}

/* The parser at the first token of a text. */
static enum rmap_status begin(struct making *making, const char *text, struct rmap_error *err)
{
    making->parser.text = text;
    making->parser.err = err;
    making->parser.token = (struct rmap_token){0};
    enum rmap_status st = rmap_criterion_check_utf8(text, err);
    return st == RMAP_OK ? rmap_parser_advance(&making->parser) : st;
}

/* A detector's name as it is, blanks and all, or as the language has names. */
static enum rmap_status parse_detector(struct making *making, const char *text,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = making->self->scene;
    making->has_detector = making->is_given = true;
    for (size_t d = 0; d < scene->n_detector; d++)
        if (strcmp(scene->detector[d].name, text) == 0) {
            making->self->detector = (struct rmap_index_set){.low = (int32_t)d, .span = 1};
            return RMAP_OK;
        }
    RMAP_TRY(begin(making, text, err));
    RMAP_TRY(rmap_parse_set(&making->parser, RMAP_WANTED_DETECTOR, &making->self->detector));
    if (making->parser.token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(&making->parser, "the end");
out:
    if (st != RMAP_OK)
        rmap_criterion_relabel("--detector", err);
    return st;
}

static rmap_column_set columns_of(const struct rmap_quantity *quantity)
{
    switch (quantity->kind) {
    case RMAP_QUANTITY_RAY_NUMBER:
        return rmap_ray_number_columns(quantity->ray_number);
    case RMAP_QUANTITY_PATH_IN:
        return RMAP_PATH_IN_COLUMNS;
    case RMAP_QUANTITY_ITS_NUMBER:
        return rmap_registration_number_columns(quantity->its_number);
    case RMAP_QUANTITY_SUM:
        return rmap_sum_columns(&quantity->sum);
    case RMAP_QUANTITY_COUNT:
        return rmap_criterion_columns(quantity->counted);
    case RMAP_QUANTITY_GHOST_ORDER:
    case RMAP_QUANTITY_SCATTER_ORDER:
        return 0; /* its own: see rmap_quantities_create_over */
    case RMAP_QUANTITY_CELL:
    case RMAP_QUANTITY_CELL_I:
    case RMAP_QUANTITY_CELL_J:
        break;
    }
    return RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell);
}

/* Rays of a map in several colour spaces have wavelengths in some of them. */
static bool any_spectral(const struct rmap_map *map)
{
    for (size_t s = 0; s < rmap_map_n_space(map); s++)
        if (rmap_map_scene_of(map, s)->channels.mode == RMAP_COLOUR_SPECTRAL)
            return true;
    return false;
}

/* What all of them need, once each is known. */
static void plan(struct rmap_quantities *self, bool has_detector)
{
    self->columns = 0;
    self->of_registrations = has_detector;
    for (size_t i = 0; i < self->n; i++) {
        struct rmap_quantity *quantity = &self->of[i];
        quantity->unit = unit_of(self->scene, quantity->dimension);
        quantity->unit_size = rmap_unit_size_of(self->scene, quantity->dimension);
        self->columns |= columns_of(quantity);
        self->spreads = self->spreads || (quantity->kind == RMAP_QUANTITY_RAY_NUMBER &&
                                          quantity->ray_number == RMAP_RAY_NUMBER_WAVELENGTH);
    }
    const rmap_column_set of_flux =
        RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    self->deferred = of_flux & ~self->columns;
    self->columns |= of_flux;
    if (self->of_registrations)
        self->columns |= RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                         RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                         RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    for (size_t d = 0; self->of_registrations && d < self->scene->n_detector; d++)
        if (rmap_index_set_has(&self->detector, (int32_t)d))
            self->detector_bits |= 1ULL << d % 64;
    for (size_t d = 0; self->of_registrations && d < self->scene->n_detector; d++)
        self->weighs = self->weighs || (rmap_index_set_has(&self->detector, (int32_t)d) &&
                                        rmap_detector_weighs(&self->scene->detector[d]));
    if (self->weighs)
        self->columns |= RMAP_RESPONSE_COLUMNS;
    if (!self->spreads || !any_spectral(self->map))
        return;
    self->columns |= RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_SEGMENT_colour);
    if (self->of_registrations)
        self->columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment);
}

static enum rmap_status parse_all(struct making *making, const char *const *text,
                                  const char *detector, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (detector)
        RMAP_TRY(parse_detector(making, detector, err));
    for (size_t i = 0; i < making->self->n; i++) {
        struct rmap_quantity *quantity = &making->self->of[i];
        quantity->name = rmap_strdup(text[i]);
        if (!quantity->name)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for --of");
        st = begin(making, quantity->name, err);
        if (st == RMAP_OK)
            st = parse_quantity(making, quantity);
        if (st != RMAP_OK) {
            rmap_criterion_relabel("--of", err);
            goto out;
        }
    }
    plan(making->self, making->has_detector);
out:
    return st;
}

enum rmap_status rmap_quantities_create(const struct rmap_map *map, const char *const *text,
                                        size_t n, const char *detector,
                                        struct rmap_quantities **quantities_ret,
                                        struct rmap_error *err)
{
    return rmap_quantities_create_over(map, NULL, text, n, detector, quantities_ret, err);
}

enum rmap_status
rmap_quantities_create_over(const struct rmap_map *map, const struct rmap_overlay *overlay,
                            const char *const *text, size_t n, const char *detector,
                            struct rmap_quantities **quantities_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_names *names = NULL;
    struct rmap_quantities *self = rmap_alloc(1, sizeof *self);
    if (n < 1 || n > RMAP_QUANTITIES_MAX) {
        st = rmap_error_set(err, RMAP_USAGE, "--of stands once, or twice for a histogram of two");
        goto out;
    }
    if (self)
        self->holder = rmap_alloc(1, sizeof *self->holder);
    if (!self || !self->holder) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for --of");
        goto out;
    }
    self->map = map;
    self->overlay = overlay;
    self->scene = self->holder->scene = rmap_scene_with(map, overlay);
    self->n = n;
    RMAP_TRY(rmap_names_create(self->scene, &names, err));
    struct making making = {.self = self, .parser = {.criterion = self->holder, .names = names}};
    RMAP_TRY(parse_all(&making, text, detector, err));
    RMAP_TRY(rmap_check_times(self->scene, self->columns, err));
    for (size_t i = 0; i < n && !self->order.makes_ghosts; i++)
        if (is_order(self->of[i].kind))
            RMAP_TRY(rmap_path_order_init(&self->order, self->scene, err));
    self->columns |= self->order.columns;
    *quantities_ret = self;
    self = NULL;
out:
    rmap_names_destroy(names);
    rmap_quantities_destroy(self);
    return st;
}

bool rmap_quantities_of_phase_time(const struct rmap_quantities *self)
{
    bool of = false;
    for (size_t i = 0; i < self->n; i++) {
        const struct rmap_quantity *one = &self->of[i];
        of |=
            (one->kind == RMAP_QUANTITY_ITS_NUMBER && one->its_number == RMAP_REGISTRATION_TIME) ||
            (one->kind == RMAP_QUANTITY_SUM && rmap_sum_of_phase_time(&one->sum)) ||
            (one->kind == RMAP_QUANTITY_COUNT && rmap_criterion_of_phase_time(one->counted));
    }
    return of;
}

bool rmap_quantities_of_ids(const struct rmap_quantities *self)
{
    bool of = false;
    for (size_t i = 0; i < self->n; i++) {
        const struct rmap_quantity *one = &self->of[i];
        of |= (one->kind == RMAP_QUANTITY_RAY_NUMBER && one->ray_number == RMAP_RAY_NUMBER_ID) ||
              (one->kind == RMAP_QUANTITY_SUM && rmap_sum_of_ids(&one->sum)) ||
              (one->kind == RMAP_QUANTITY_COUNT && rmap_criterion_of_ids(one->counted));
    }
    return of;
}

void rmap_quantities_destroy(struct rmap_quantities *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n; i++) {
        rmap_criterion_destroy(self->of[i].counted);
        rmap_free(self->of[i].name);
    }
    rmap_path_order_fini(&self->order);
    rmap_free(self->event);
    rmap_free(self->event_name);
    rmap_criterion_destroy(self->holder);
    rmap_free(self);
}

enum rmap_status rmap_quantity_set_unit(struct rmap_quantities *self, size_t index,
                                        const char *name, struct rmap_error *err)
{
    struct rmap_quantity *quantity = &self->of[index];
    const struct rmap_written_unit *unit = rmap_unit_named(name, strlen(name));
    char units[RMAP_UNITS_NBYTES];
    if (unit && rmap_unit_fits(unit, quantity->dimension, self->scene)) {
        quantity->unit = unit->name;
        quantity->unit_size = unit->size;
        return RMAP_OK;
    }
    rmap_unit_list(quantity->dimension, self->scene, units);
    return rmap_error_set(err, RMAP_USAGE, "--unit '%.20s' is no unit of %s (%s)", name,
                          quantity->name, units);
}

double rmap_quantity_scale(const struct rmap_quantities *self, size_t index)
{
    return rmap_unit_size_of(self->scene, self->of[index].dimension) / self->of[index].unit_size;
}

bool rmap_quantity_bound(const struct rmap_quantities *self, size_t index,
                         const struct rmap_path_sum *of, double bound[2])
{
    const struct rmap_quantity *quantity = &self->of[index];
    const bool is_sum = quantity->kind == RMAP_QUANTITY_SUM;
    if (is_sum ? !rmap_sum_is_bounded(&quantity->sum)
               : quantity->kind != RMAP_QUANTITY_RAY_NUMBER ||
                     !rmap_number_is_bounded(quantity->ray_number))
        return false;
    if (is_sum)
        rmap_sum_bound(&quantity->sum, of, bound);
    else
        rmap_number_bound(quantity->ray_number, of, bound);
    for (int k = 0; k < 2; k++)
        bound[k] *= rmap_quantity_scale(self, index);
    return true;
}

enum rmap_status rmap_quantity_range(const struct rmap_quantities *self, size_t index,
                                     const char *text, const char *option, double range[2],
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_interval interval;
    struct making making = {.parser = {.criterion = self->holder}};
    RMAP_TRY(begin(&making, text, err));
    RMAP_TRY(rmap_parse_range(&making.parser, self->of[index].dimension, self->of[index].unit_size,
                              &interval));
    if (making.parser.token.kind != RMAP_TOKEN_END)
        RMAP_TRY(rmap_parser_expected(&making.parser, "the end"));
    range[0] = interval.low;
    range[1] = interval.high;
out:
    if (st == RMAP_INPUT) {
        rmap_criterion_relabel(option, err);
        st = err ? err->status = RMAP_USAGE : RMAP_USAGE;
    }
    return st;
}
