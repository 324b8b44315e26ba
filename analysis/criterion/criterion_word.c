/* SPDX-License-Identifier: MIT
 *
 * Elementary tests: which word begins which, tests of the ray as a whole, and what all of them
 * share: names and sets.
 */
#include <ctype.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "analysis/criterion/criterion_detector.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/step_number.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "portion/event.h"

/* Packs marks [n] into a set; without gaps it needs no memory of its own. */
enum rmap_status rmap_parser_pack_set(struct rmap_parser *parser, const uint8_t *mark, size_t n,
                                      struct rmap_index_set *set)
{
    size_t low = 0, high = n, n_marked = 0;
    while (low < high && !mark[low])
        low++;
    while (high > low && !mark[high - 1])
        high--;
    for (size_t i = low; i < high; i++)
        n_marked += mark[i];
    *set = (struct rmap_index_set){.low = (int32_t)low, .span = (uint32_t)(high - low)};
    if (n_marked == high - low)
        return RMAP_OK;
    void *block = NULL;
    enum rmap_status st =
        rmap_criterion_block_add(parser->criterion, high - low, 1, &block, parser->err);
    if (st != RMAP_OK)
        return st;
    memcpy(block, mark + low, high - low);
    set->member = block;
    return RMAP_OK;
}

/* The set that a name token stands for among the wanted kind; *found_ret: it names something. */
enum rmap_status rmap_parser_look_up(struct rmap_parser *parser, const struct rmap_token *token,
                                     enum rmap_name_wanted wanted, struct rmap_index_set *set,
                                     bool *found_ret)
{
    char name[RMAP_TOKEN_NAME_NBYTES + 1];
    rmap_token_name(parser->text, token, name);
    size_t n = rmap_names_count(parser->names, wanted);
    uint8_t *mark = rmap_alloc(n, 1);
    if (!mark)
        return rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for %zu names", n);
    rmap_names_mark(parser->names, name, strpbrk(name, "*?") != NULL, wanted, mark, found_ret);
    enum rmap_status st = *found_ret ? rmap_parser_pack_set(parser, mark, n, set) : RMAP_OK;
    rmap_free(mark);
    return st;
}

enum rmap_status rmap_parser_take_name(struct rmap_parser *parser, const char *what,
                                       struct rmap_token *token_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token whole = *token_ret = parser->token;
    if (whole.kind == RMAP_TOKEN_WORD || whole.kind == RMAP_TOKEN_QUOTED) {
        RMAP_TRY(rmap_parser_advance(parser));
        if (whole.kind == RMAP_TOKEN_QUOTED || parser->token.kind != RMAP_TOKEN_NUMBER ||
            parser->token.begin != whole.end)
            return RMAP_OK;
        char shown[RMAP_SHOWN_NBYTES];
        whole.end = parser->token.end;
        rmap_token_shorten(parser->text, &whole, shown);
        return RMAP_PARSER_FAIL(parser, &whole, "a name with signs stands in single quotes: '%s'",
                                shown);
    }
    if (parser->token.kind != RMAP_TOKEN_NUMBER)
        return rmap_parser_expected(parser, what);
    char more[96];
    (void)snprintf(more, sizeof more, "%s (one that begins with a digit stands in single quotes)",
                   what);
    st = rmap_parser_expected(parser, more);
out:
    return st;
}

enum rmap_status rmap_parse_set(struct rmap_parser *parser, enum rmap_name_wanted wanted,
                                struct rmap_index_set *set)
{
    static const char *const what[] = {
        [RMAP_WANTED_OBJECT] = "the name of an object",
        [RMAP_WANTED_SOURCE] = "the name of a source",
        [RMAP_WANTED_DETECTOR] = "the name of a detector",
        [RMAP_WANTED_SURFACE] = "the name of a surface property",
        [RMAP_WANTED_MEDIUM] = "the name of a medium",
    };
    enum rmap_status st = RMAP_OK;
    struct rmap_token token;
    bool found = false;
    RMAP_TRY(rmap_parser_take_name(parser, what[wanted], &token));
    RMAP_TRY(rmap_parser_look_up(parser, &token, wanted, set, &found));
    if (!found)
        st = rmap_names_fail(parser->names, parser->text, &token, wanted, parser->err);
out:
    return st;
}

/* Text of a token as a word, for messages and tables. */
void rmap_parser_word(const struct rmap_parser *parser, const struct rmap_token *token,
                      char word[RMAP_TOKEN_NAME_NBYTES + 1])
{
    size_t len = token->end - token->begin;
    if (len > RMAP_TOKEN_NAME_NBYTES)
        len = RMAP_TOKEN_NAME_NBYTES;
    memcpy(word, parser->text + token->begin, len);
    word[len] = 0;
}

/* The shortest candidate that a word of three letters or more begins; NULL: none. */
static const char *beginning_with(const char *word, const char *const *candidate, size_t n)
{
    const char *shortest = NULL;
    size_t len = strlen(word);
    for (size_t i = 0; len >= 3 && i < n; i++)
        if (strncmp(candidate[i], word, len) == 0 &&
            (!shortest || strlen(candidate[i]) < strlen(shortest)))
            shortest = candidate[i];
    return shortest;
}

/* "unknown KIND 'word' (did you mean 'x'?)" */
enum { KNOWN_NBYTES = 384 }; /* all words of the longest list */

enum rmap_status rmap_parser_fail_word(const struct rmap_parser *parser,
                                       const struct rmap_token *token, const char *kind,
                                       const char *const *candidate, size_t n)
{
    char word[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES];
    rmap_parser_word(parser, token, word);
    rmap_criterion_shorten(word, shown);
    const char *near = beginning_with(word, candidate, n);
    if (!near)
        near = rmap_nearest_word(word, candidate, n);
    if (near)
        return RMAP_PARSER_FAIL(parser, token, "unknown %s '%s' (did you mean '%s'?)", kind, shown,
                                near);
    char known[KNOWN_NBYTES] = "";
    for (size_t i = 0, len = 0; i < n && len < sizeof known; i++)
        len += (size_t)snprintf(known + len, sizeof known - len, " %s", candidate[i]);
    return RMAP_PARSER_FAIL(parser, token, "unknown %s '%s': say one of%s", kind, shown, known);
}

static enum rmap_status parse_all(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    (void)parser;
    node->kind = RMAP_CRITERION_ALL;
    return RMAP_OK;
}

static enum rmap_status parse_source(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    node->kind = RMAP_CRITERION_SOURCE;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_SOURCE, &node->source));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
out:
    return st;
}

/* An object, a group or a medium; both where both have the name. */
static enum rmap_status parse_place(struct rmap_parser *parser, struct rmap_ending_test *ending)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token token;
    bool object = false, medium = false;
    ending->somewhere = true;
    RMAP_TRY(rmap_parser_take_name(parser, "the name of an object or a medium", &token));
    RMAP_TRY(rmap_parser_look_up(parser, &token, RMAP_WANTED_OBJECT, &ending->object, &object));
    RMAP_TRY(rmap_parser_look_up(parser, &token, RMAP_WANTED_MEDIUM, &ending->medium, &medium));
    if (!object && !medium)
        st = rmap_names_fail(parser->names, parser->text, &token, RMAP_WANTED_PLACE, parser->err);
out:
    return st;
}

static const char *const stop_words[] = {
#define ROW(symbol, value, word) [value] = word,
    RMAP_STOP_TABLE(ROW)
#undef ROW
};

static enum rmap_status parse_ended(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ending_test *ending = &node->ending;
    node->kind = RMAP_CRITERION_ENDED;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    struct rmap_token word = parser->token;
    while (ending->stop < RMAP_STOP_COUNT && !rmap_parser_at_word(parser, stop_words[ending->stop]))
        ending->stop++;
    if (word.kind != RMAP_TOKEN_WORD)
        return rmap_parser_expected(parser, "absorbed, left, limit or error");
    if (ending->stop == RMAP_STOP_COUNT)
        return rmap_parser_fail_word(parser, &word, "ending", stop_words, RMAP_STOP_COUNT);
    RMAP_TRY(rmap_parser_advance(parser));
    if (parser->token.kind == RMAP_TOKEN_COMMA) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(parse_place(parser, ending));
    }
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "',' or ')'"));
out:
    return st;
}

enum rmap_status rmap_parse_media(struct rmap_parser *parser, struct rmap_index_set *media)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_OPEN, "'('"));
    RMAP_TRY(rmap_parse_set(parser, RMAP_WANTED_MEDIUM, media));
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "')'"));
out:
    return st;
}

static enum rmap_status parse_path_in(struct rmap_parser *parser, struct rmap_criterion_node *node)
{
    node->kind = RMAP_CRITERION_PATH_IN;
    return rmap_parse_media(parser, &node->media);
}

#define RAY(number, of) .is_number = true, .of_ray = true, .ray_number = number, .dimension = of
#define ITS(number)     .of_registration = true, .its_number = number

static const struct rmap_word word_table[] = {
    {"all", parse_all},
    {"source", parse_source, .in_stats = 22, .wants = "the name of a source, as source(sun)"},
    {"hit", rmap_parse_hit, 6, 18, RMAP_OF_STEPS, .wants = "the name of an object, as hit(lens)"},
    {"surface", rmap_parse_surface, 7, 19, RMAP_OF_STEPS,
     .wants = "the name of a surface property, as surface(black)"},
    {"scatter", rmap_parse_scatter, 19, 33, RMAP_OF_STEPS,
     .wants = "a scatter model, as scatter(lambert)"},
    {"event", rmap_parse_event_test, 8, 20, RMAP_OF_STEPS},
    {"medium", rmap_parse_medium, 9, 21, RMAP_OF_STEPS,
     .wants = "the name of a medium, as medium(air)"},
    {"after", rmap_parse_after, 14, 0, RMAP_OF_REGISTRATION},
    {"at", rmap_parse_at, 15, 0, RMAP_OF_REGISTRATION},
    {"registered", rmap_parse_registered, .in_stats = 24,
     .wants = "the name of a detector, as registered(sensor)"},
    {"crossed", rmap_parse_crossed, .in_stats = 25,
     .wants = "the name of a detector, as crossed(sensor)"},
    {"detected", rmap_parse_detected, .in_stats = 35,
     .wants = "the name of a detector, as detected(sensor)"},
    {"ended", parse_ended, .in_stats = 23, .wants = "how, as ended(absorbed)"},
    {"path", rmap_parse_path, 13, 26, RMAP_OF_STEPS,
     .wants = "an expression, as path(\"T@lens .*\")"},
    {"segments", .in_stats = 5, RAY(RMAP_RAY_NUMBER_SEGMENTS, RMAP_DIMENSION_NONE)},
    {"bounces", rmap_parse_bounces, 10, 6, RMAP_OF_STEPS, true},
    {"ghost_order", rmap_parse_ghost_order, 11, 9, RMAP_OF_STEPS, true},
    {"scatter_order", rmap_parse_scatter_order, 12, 10, RMAP_OF_STEPS, true},
    {"wavelength", .in_stats = 1, RAY(RMAP_RAY_NUMBER_WAVELENGTH, RMAP_DIMENSION_WAVELENGTH)},
    {"photon_energy", .in_stats = 36, RAY(RMAP_RAY_NUMBER_PHOTON_ENERGY, RMAP_DIMENSION_ENERGY)},
    {"flux", .in_stats = 2, RAY(RMAP_RAY_NUMBER_FLUX, RMAP_DIMENSION_FLUX)},
    {"path_length", .in_stats = 3, RAY(RMAP_RAY_NUMBER_PATH_LENGTH, RMAP_DIMENSION_LENGTH)},
    {"optical_path", NULL, 5, 4, RAY(RMAP_RAY_NUMBER_OPTICAL_PATH, RMAP_DIMENSION_LENGTH),
     ITS(RMAP_REGISTRATION_OPTICAL_PATH)},
    {"group_path", NULL, 20, 34, RAY(RMAP_RAY_NUMBER_GROUP_PATH, RMAP_DIMENSION_LENGTH),
     ITS(RMAP_REGISTRATION_GROUP_PATH)},
    {"start_x", .in_stats = 30, RAY(RMAP_RAY_NUMBER_START_X, RMAP_DIMENSION_LENGTH)},
    {"start_y", .in_stats = 31, RAY(RMAP_RAY_NUMBER_START_Y, RMAP_DIMENSION_LENGTH)},
    {"start_z", .in_stats = 32, RAY(RMAP_RAY_NUMBER_START_Z, RMAP_DIMENSION_LENGTH)},
    {"ray", .in_stats = 7, RAY(RMAP_RAY_NUMBER_ID, RMAP_DIMENSION_NONE)},
    {"angle", rmap_parse_any_number, 1, 13, ITS(RMAP_REGISTRATION_ANGLE)},
    {"x", rmap_parse_any_number, 2, 11, ITS(RMAP_REGISTRATION_X)},
    {"y", rmap_parse_any_number, 3, 12, ITS(RMAP_REGISTRATION_Y)},
    {"world_x", rmap_parse_any_number, 16, 27, ITS(RMAP_REGISTRATION_WORLD_X)},
    {"world_y", rmap_parse_any_number, 17, 28, ITS(RMAP_REGISTRATION_WORLD_Y)},
    {"world_z", rmap_parse_any_number, 18, 29, ITS(RMAP_REGISTRATION_WORLD_Z)},
    {"time", rmap_parse_any_number, 4, 14, ITS(RMAP_REGISTRATION_TIME)},
    {"registrations", NULL, 0, 8, RMAP_NO_TEST},
    {"cell", NULL, 0, 15, RMAP_NO_TEST},
    {"cell_i", NULL, 0, 16, RMAP_NO_TEST},
    {"cell_j", NULL, 0, 17, RMAP_NO_TEST},
};
enum { N_WORD = sizeof word_table / sizeof *word_table };

/* Words behind those, where a test or the logic has them. */
static const char *const inner_words[] = {"and",
                                          "or",
                                          "not",
                                          "in",
                                          "where",
                                          "let",
                                          "rect",
                                          "ellipse",
                                          "polygon",
                                          "cells",
                                          "rel",
                                          "world",
                                          "face",
                                          "triangle",
                                          "side",
                                          "front",
                                          "back",
#define ROW(symbol, value, word) word,
                                          RMAP_STOP_TABLE(ROW)
#undef ROW
#define ROW(symbol, bit, letter, word, meaning) word,
                                              RMAP_EVENT_TABLE(ROW)
#undef ROW
#define ROW(word, mask) word,
                                                  RMAP_EVENT_UNION_TABLE(ROW)
#undef ROW
};
enum { N_INNER = sizeof inner_words / sizeof *inner_words };

const char *rmap_criterion_word(size_t i)
{
    if (i < N_WORD)
        return word_table[i].word;
    i -= N_WORD;
    if (i < N_INNER)
        return inner_words[i];
    i -= N_INNER;
    for (size_t k = 0; rmap_unit_at(k); k++)
        if (rmap_unit_at(k)->in_criteria && i-- == 0)
            return rmap_unit_at(k)->name;
    for (size_t k = 0; rmap_step_number_word(k); k++)
        if (i-- == 0)
            return rmap_step_number_word(k);
    for (size_t k = 0; rmap_surface_parameter_word(k); k++)
        if (i-- == 0)
            return rmap_surface_parameter_word(k);
    return rmap_scatter_word(i);
}

const struct rmap_word *rmap_stats_word(int place)
{
    for (size_t i = 0; i < N_WORD; i++)
        if (place > 0 && word_table[i].in_stats == place)
            return &word_table[i];
    return NULL;
}

/* The word of a number of the ray where a detector stands behind it; of its length, a medium. */
static const struct rmap_word its_word = {"", rmap_parse_any_number};
static const struct rmap_word path_in_word = {"path_length", parse_path_in, .is_number = true,
                                              .dimension = RMAP_DIMENSION_LENGTH};

const struct rmap_word *rmap_word_at(const struct rmap_parser *parser,
                                     const struct rmap_token *token)
{
    for (size_t i = 0; i < N_WORD; i++)
        if (rmap_token_is(parser->text, token, word_table[i].word))
            return &word_table[i];
    return NULL;
}

const struct rmap_word *rmap_word_next(const struct rmap_parser *parser)
{
    return rmap_word_at(parser, &parser->token);
}

enum rmap_status rmap_word_fail(const struct rmap_parser *parser, const struct rmap_token *token,
                                const char *kind, enum rmap_word_list list)
{
    const char *candidate[N_WORD];
    size_t n = 0;
    if (memchr(parser->text + token->begin, '*', token->end - token->begin))
        return RMAP_PARSER_FAIL(parser, token, RMAP_FACTOR_HINT);
    for (size_t i = 0; i < N_WORD; i++) {
        const struct rmap_word *word = &word_table[i];
        int place = list == RMAP_WORDS_OF_WHERE   ? word->in_where
                    : list == RMAP_WORDS_OF_STATS ? word->in_stats
                    : word->scope != RMAP_NO_TEST ? (int)i + 1
                                                  : 0;
        if (place)
            candidate[place - 1] = word->word;
        n += place > 0;
    }
    return rmap_parser_fail_word(parser, token, kind, candidate, n);
}

/* The word is none: say which one was meant, or how to ask for what it names. */
RMAP_OWN_FRAME static enum rmap_status fail_unknown(const struct rmap_parser *parser)
{
    const struct rmap_token *token = &parser->token;
    char word[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES];
    if (rmap_parser_at_word(parser, "let"))
        return RMAP_PARSER_FAIL(parser, token,
                                "'let' defines names in a file that --criteria names");
    if (token->kind == RMAP_TOKEN_NUMBER)
        return RMAP_PARSER_FAIL(parser, token,
                                "what is compared stands first, a factor before it, with blanks "
                                "around the *: hit(lens) > 2, 2 * x(NAME) > 3");
    if (token->kind != RMAP_TOKEN_WORD && token->kind != RMAP_TOKEN_QUOTED)
        return rmap_parser_expected(parser, "a test such as hit(name) or all");
    const char *small = rmap_parser_small(parser);
    if (small && !rmap_parser_at_word(parser, small))
        return RMAP_PARSER_FAIL(parser, token, "write '%s', in small letters", small);
    rmap_token_name(parser->text, token, word);
    rmap_criterion_shorten(word, shown);
    const struct rmap_name *name = rmap_names_lookup(parser->names, word);
    if (!name && (strcasecmp(word, "true") == 0 || strcasecmp(word, "false") == 0))
        return RMAP_PARSER_FAIL(parser, token, "'%s' is no test (%s)", shown,
                                tolower((unsigned char)*word) == 't' ? "all rays: write 'all'"
                                                                     : "no ray: write 'not all'");
    if (name) {
        char written[RMAP_SHOWN_NBYTES];
        rmap_token_shorten(parser->text, token, written);
        return RMAP_PARSER_FAIL(parser, token, "'%s' is %s, not a test (use %s(%s))", shown,
                                rmap_name_kind_phrase(name->kind), rmap_name_kind_usage(name->kind),
                                written);
    }
    return rmap_word_fail(parser, token, "test", RMAP_WORDS_OF_TESTS);
}

/* Behind the word `event` stands a relation: it is the number of the ray's event. */
static const struct rmap_word event_word = {"event", NULL,
                                            RAY(RMAP_RAY_NUMBER_EVENT, RMAP_DIMENSION_NONE)};

static enum rmap_status check_events(const struct rmap_parser *parser,
                                     const struct rmap_token *token)
{
    const char *trouble = rmap_scene_events_trouble(parser->names->scene);
    if (parser->detector)
        return RMAP_PARSER_FAIL(parser, token,
                                "the number of the event is of the whole ray, not of a "
                                "registration: put it beside registered(...) with 'and'");
    return trouble ? RMAP_PARSER_FAIL(parser, token, "%s", trouble) : RMAP_OK;
}

static enum rmap_status parse_comparison(struct rmap_parser *parser, const struct rmap_word *word,
                                         const struct rmap_token *token,
                                         struct rmap_interval *interval)
{
    if (rmap_parser_at_comparison(parser))
        return rmap_parse_interval(parser, word->dimension, interval);
    if (word->is_number && parser->token.kind == RMAP_TOKEN_OPEN)
        return RMAP_PARSER_FAIL(parser, token,
                                word->of_registration || word->in_where
                                    ? "'%s' takes no name here; at a registration it is asked for "
                                      "as registered(NAME where %s >= 1)"
                                    : "'%s' is a number of the whole ray and takes no name: "
                                      "'%s > 10'",
                                word->word, word->word);
    if (word->is_number)
        return RMAP_PARSER_FAIL(parser, token,
                                "'%s' is a number: compare it, as in '%s > 10' or '%s in 1..10'",
                                word->word, word->word, word->word);
    *interval = (struct rmap_interval){1.0, (double)INFINITY, false};
    return RMAP_OK;
}

static uint64_t id_of(long double v)
{
    return v >= (long double)UINT64_MAX ? UINT64_MAX : (uint64_t)v;
}

/* The ids that the comparison at byte `begin`, parsed already, holds for. */
static enum rmap_status set_ids(struct rmap_parser *parser, size_t begin,
                                struct rmap_criterion_node *node)
{
    enum rmap_status st = RMAP_OK;
    const char *text = parser->text;
    struct rmap_token relation, low, high;
    RMAP_TRY(rmap_token_read(text, begin, &relation, parser->err));
    RMAP_TRY(rmap_token_read(text, relation.end, &low, parser->err));
    high = low;
    if (relation.kind == RMAP_TOKEN_WORD) {
        RMAP_TRY(rmap_token_read(text, low.end, &high, parser->err));
        RMAP_TRY(rmap_token_read(text, high.end, &high, parser->err));
    }
    long double v = strtold(text + low.begin, NULL), from = ceill(v);
    long double to = floorl(strtold(text + high.begin, NULL));
    if (relation.kind == RMAP_TOKEN_LT || relation.kind == RMAP_TOKEN_LE)
        from = 0;
    else if (relation.kind == RMAP_TOKEN_GT || relation.kind == RMAP_TOKEN_GE)
        to = (long double)INFINITY;
    if (relation.kind == RMAP_TOKEN_LT)
        to = ceill(v) - 1;
    else if (relation.kind == RMAP_TOKEN_GT)
        from = floorl(v) + 1;
    from = fmaxl(from, 0);
    node->id_low = from <= to ? id_of(from) : 1; /* 1 > 0: none */
    node->id_high = from <= to ? id_of(to) : 0;
    if (node->ray_number == RMAP_RAY_NUMBER_EVENT)
        rmap_scene_rays_of_events(parser->names->scene, node->id_low, node->id_high, &node->ray_low,
                                  &node->ray_high);
out:
    return st;
}

enum rmap_status rmap_parse_test(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token token = parser->token;
    const struct rmap_word *word = rmap_word_next(parser);
    if (rmap_parser_at_sum(parser))
        return rmap_parse_sum(parser, node_ret);
    if (word && word->scope == RMAP_NO_TEST)
        word = NULL;
    if (parser->detector && (!word || word->scope == RMAP_OF_RAY))
        return rmap_parse_where_test(parser, node_ret);
    if (token.kind == RMAP_TOKEN_AT)
        return rmap_parse_reference(parser, node_ret);
    if (!word)
        return fail_unknown(parser);
    if (!parser->detector && word->scope == RMAP_OF_REGISTRATION)
        return RMAP_PARSER_FAIL(parser, &token,
                                "'%s' is of a registration: registered(NAME where %s(OBJECT))",
                                word->word, word->word);
    struct rmap_criterion_node node = {.first = -1, .next = -1, .begin = token.begin};
    parser->word = token;
    RMAP_TRY(rmap_parser_advance(parser));
    if (word->of_registration && !parser->detector && parser->token.kind == RMAP_TOKEN_OPEN)
        word = &its_word; /* optical_path(sensor) */
    if (word->ray_number == RMAP_RAY_NUMBER_PATH_LENGTH && parser->token.kind == RMAP_TOKEN_OPEN)
        word = &path_in_word; /* path_length(glass) */
    if (word->parse == rmap_parse_event_test && rmap_parser_at_comparison(parser)) {
        RMAP_TRY(check_events(parser, &token));
        word = &event_word;
    }
    if (word->parse) {
        RMAP_TRY(word->parse(parser, &node));
    } else {
        node.kind = RMAP_CRITERION_NUMBER;
        node.ray_number = word->ray_number;
    }
    size_t begin = parser->token.begin;
    RMAP_TRY(parse_comparison(parser, word, &token, &node.interval));
    if (node.kind == RMAP_CRITERION_NUMBER &&
        (node.ray_number == RMAP_RAY_NUMBER_ID || node.ray_number == RMAP_RAY_NUMBER_EVENT))
        RMAP_TRY(set_ids(parser, begin, &node));
    node.end = parser->taken_end;
    RMAP_TRY(rmap_criterion_node_add(parser->criterion, &node, node_ret, parser->err));
out:
    return st;
}
