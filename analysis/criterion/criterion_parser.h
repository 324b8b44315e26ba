/* SPDX-License-Identifier: MIT
 *
 * The parser's state and its rooms: logic (criterion_parser.c), elementary tests
 * (criterion_word.c) of steps (criterion_parser.c, criterion_surface.c) and of registrations
 * (criterion_detector.c), and values: numbers, units, ranges, regions (criterion_value.c).
 */
#ifndef RMAP_CRITERION_PARSER_H
#define RMAP_CRITERION_PARSER_H

#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_names.h"
#include "analysis/criterion/criterion_tree.h"
#include "base/unit.h"

/* Definitions nest 2000 deep: what has room for names is no part of the frame of who nests. */
#define RMAP_OWN_FRAME __attribute__((noinline))

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
    const struct rmap_index_set *given;    /* detector of numbers that name none; or NULL */
    bool of_step; /* numbers are those of a step, in a `where` of its own */
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

/* The word of the logic that the next token is, be it in capitals; NULL: none. */
const char *rmap_parser_small(const struct rmap_parser *parser);

/* "expected WHAT, found 'token'", and the remedy of mistakes that many make. */
enum rmap_status rmap_parser_expected(const struct rmap_parser *parser, const char *what);

/* Takes a token of this kind, or fails with "expected WHAT". */
enum rmap_status rmap_parser_take(struct rmap_parser *parser, enum rmap_token_kind kind,
                                  const char *what) RMAP_MUST_USE;

/* Fails at a token (any, also one already taken). */
#define RMAP_PARSER_FAIL(parser, token, ...)                                                       \
    rmap_criterion_fail((parser)->text, (token)->begin, (token)->end, (parser)->err, __VA_ARGS__)

#define RMAP_FACTOR_HINT                                                                           \
    "a factor stands before a number that sums may have, with blanks around the *: 2 * "           \
    "path_length"

/* or-expression: the whole language, or the inside of a `where`. */
enum rmap_status rmap_parse_logic(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* @NAME; the sign is next. */
enum rmap_status rmap_parse_reference(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* What surface(...) may compare: the i-th, NULL behind the last. */
const char *rmap_surface_parameter_word(size_t i);
/* What scatter(...) may ask for. */
const char *rmap_scatter_word(size_t i);

/* The name of an event, into *events, which has none yet. */
enum rmap_status rmap_parse_event(struct rmap_parser *parser, uint32_t *events) RMAP_MUST_USE;

/* What stands behind the word of a test, which has been taken. */
enum rmap_status rmap_parse_hit(struct rmap_parser *parser,
                                struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_event_test(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_medium(struct rmap_parser *parser,
                                   struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_scatter(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;
enum rmap_status rmap_parse_surface(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;

/* A test of registrations on these detectors, from behind their name on. */
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

#endif
