/* SPDX-License-Identifier: MIT
 *
 * The parser's state and its rooms: logic (criterion_parse.c), elementary tests
 * (criterion_word.c) of steps (criterion_step.c, criterion_surface.c) and of registrations
 * (criterion_detector.c), and values: numbers, units, ranges, regions (criterion_value.c).
 */
#ifndef RMAP_CRITERION_PARSER_H
#define RMAP_CRITERION_PARSER_H

#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_names.h"
#include "analysis/criterion/criterion_tree.h"
#include "base/unit.h"

struct rmap_criteria;
struct rmap_reference;

struct rmap_parser {
    struct rmap_criterion *criterion;
    const char *text; /* of the criterion, or of the definition in hand */
    struct rmap_names *names;
    struct rmap_token token;               /* the next one, not yet taken */
    size_t taken_end;                      /* byte behind the last one taken */
    struct rmap_token word;                /* that began the test in hand */
    const struct rmap_index_set *detector; /* of the `where` in hand; NULL outside */
    int depth;
    const struct rmap_criteria *criteria;   /* what @names stand for, or NULL */
    const struct rmap_reference *reference; /* the definition in hand; NULL outside */
    size_t definition_end;                  /* where its text ends */
    size_t path_work;                       /* spent on automata; see path_automaton.c */
    const uint8_t *path_letters;            /* made for the first path; see path_alphabet.c */
    struct rmap_error *err;
};

/* Takes the next token, and looks at the one behind it. */
enum rmap_status rmap_parser_advance(struct rmap_parser *parser) RMAP_MUST_USE;

/* True when the next token is this very word. */
bool rmap_parser_at_word(const struct rmap_parser *parser, const char *word);

/* "expected WHAT, found 'token'". */
enum rmap_status rmap_parser_expected(const struct rmap_parser *parser, const char *what);

/* Takes a token of this kind, or fails with "expected WHAT". */
enum rmap_status rmap_parser_take(struct rmap_parser *parser, enum rmap_token_kind kind,
                                  const char *what) RMAP_MUST_USE;

/* Fails at a token (any, also one already taken). */
#define RMAP_PARSER_FAIL(parser, token, ...)                                                       \
    rmap_criterion_fail((parser)->text, (token)->begin, (token)->end, (parser)->err, __VA_ARGS__)

/* or-expression: the whole language, or the inside of a `where`. */
enum rmap_status rmap_parse_logic(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* One elementary test with its comparison. */
enum rmap_status rmap_parse_test(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* @NAME; the sign is next. */
enum rmap_status rmap_parse_reference(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* Name tokens, and the sets they stand for among the wanted kind. look_up: *found_ret says
 * whether the name is known; parse_set fails when it is not. */
enum rmap_status rmap_parser_take_name(struct rmap_parser *parser, const char *what,
                                       struct rmap_token *token_ret) RMAP_MUST_USE;
enum rmap_status rmap_parser_look_up(struct rmap_parser *parser, const struct rmap_token *token,
                                     enum rmap_name_wanted wanted, struct rmap_index_set *set,
                                     bool *found_ret) RMAP_MUST_USE;
enum rmap_status rmap_parse_set(struct rmap_parser *parser, enum rmap_name_wanted wanted,
                                struct rmap_index_set *set) RMAP_MUST_USE;

/* Packs marks [n] into a set; without gaps it needs no memory of its own. */
enum rmap_status rmap_parser_pack_set(struct rmap_parser *parser, const uint8_t *mark, size_t n,
                                      struct rmap_index_set *set) RMAP_MUST_USE;

/* Text of a token, cut to a name's length. */
void rmap_parser_word(const struct rmap_parser *parser, const struct rmap_token *token,
                      char word[RMAP_TOKEN_NAME_NBYTES + 1]);

/* Fails with "unknown KIND 'word' (did you mean 'x'?)". */
enum rmap_status rmap_parser_fail_word(const struct rmap_parser *parser,
                                       const struct rmap_token *token, const char *kind,
                                       const char *const *candidate, size_t n);

/* What surface(...) may compare: the i-th, NULL behind the last. */
const char *rmap_surface_parameter_word(size_t i);

/* The name of an event, into *events, which has none yet. */
enum rmap_status rmap_parse_event(struct rmap_parser *parser, uint32_t *events) RMAP_MUST_USE;

/* What stands behind the word of a test, which has been taken. */
enum rmap_status rmap_parse_hit(struct rmap_parser *parser,
                                struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_event_test(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_medium(struct rmap_parser *parser,
                                   struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_surface(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_registered(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_crossed(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;

/* A test of registrations on these detectors, from behind their name on. */
enum rmap_status rmap_parse_which(struct rmap_parser *parser, const struct rmap_index_set *detector,
                                  struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_path(struct rmap_parser *parser,
                                 struct rmap_criterion_node *node) RMAP_MUST_USE;

/* As hit, of the step at a registration's own place; of the last object met before it; numbers that
 * count steps. */
enum rmap_status rmap_parse_at(struct rmap_parser *parser,
                               struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_after(struct rmap_parser *parser,
                                  struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_bounces(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_ghost_order(struct rmap_parser *parser,
                                        struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_scatter_order(struct rmap_parser *parser,
                                          struct rmap_criterion_node *node) RMAP_MUST_USE;

/* angle(detector) < ... and its like: any registration there satisfies the comparison. */
enum rmap_status rmap_parse_any_number(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;

/* Of which dimension a number of a registration is on these detectors. */
enum rmap_dimension rmap_its_number_dimension(const struct rmap_scene *scene,
                                              enum rmap_registration_number number,
                                              const struct rmap_index_set *detector);

/* One comparison inside `where`. */
enum rmap_status rmap_parse_where_test(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

bool rmap_parser_at_comparison(const struct rmap_parser *parser);

/* `a..b`, a unit behind b meant for both where a has none. */
enum rmap_status rmap_parse_range(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  struct rmap_interval *interval) RMAP_MUST_USE;

/* Comparison with a value, or `in` with a range. */
enum rmap_status rmap_parse_interval(struct rmap_parser *parser, enum rmap_dimension dimension,
                                     struct rmap_interval *interval) RMAP_MUST_USE;

/* N or N..M, whole numbers from 0. */
enum rmap_status rmap_parse_index_range(struct rmap_parser *parser, uint32_t *low,
                                        uint32_t *high) RMAP_MUST_USE;

/* rect(...), ellipse(...), polygon(...), cells(...); the word is the next token. */
bool rmap_parser_at_region(const struct rmap_parser *parser);
enum rmap_status rmap_parse_region(struct rmap_parser *parser,
                                   struct rmap_registration_test *test) RMAP_MUST_USE;

/* What positions on these detectors are measured in. */
enum rmap_dimension rmap_detector_dimension(const struct rmap_scene *scene,
                                            const struct rmap_index_set *detector);

#endif
