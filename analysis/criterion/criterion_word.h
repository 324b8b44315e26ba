/* SPDX-License-Identifier: MIT
 *
 * The words of the language, in one table: the parser, its suggestions, `stats --of` and completion
 * are made of it.
 */
#ifndef RMAP_CRITERION_WORD_H
#define RMAP_CRITERION_WORD_H

#include "analysis/criterion/criterion_parser.h"

/* What a test is of decides where it may stand: STEPS, those of the ray, or inside `where` those
 * before the registration; REGISTRATION, there alone. NO_TEST: of `stats --of` alone. */
enum rmap_word_scope { RMAP_OF_RAY, RMAP_OF_STEPS, RMAP_OF_REGISTRATION, RMAP_NO_TEST };

/* Lists of words that a message may show whole, each in an order of its own. */
enum rmap_word_list { RMAP_WORDS_OF_TESTS, RMAP_WORDS_OF_WHERE, RMAP_WORDS_OF_STATS };

/* A word that begins a test, or is a number of `stats --of`. A number must be compared; a count
 * need not. */
struct rmap_word {
    const char *word;
    enum rmap_status (*parse)(struct rmap_parser *parser, struct rmap_criterion_node *node);
    int in_where, in_stats; /* place in the list, from 1; 0: not in it */
    enum rmap_word_scope scope;
    bool is_number, of_ray; /* of_ray: `ray_number` of the ray, where parse is NULL */
    enum rmap_ray_number ray_number;
    enum rmap_dimension dimension;
    bool of_registration; /* `its_number` of a registration */
    enum rmap_registration_number its_number;
};

/* The word that is next, or that a token is; NULL: none. */
const struct rmap_word *rmap_word_next(const struct rmap_parser *parser);
const struct rmap_word *rmap_word_at(const struct rmap_parser *parser,
                                     const struct rmap_token *token);

/* Fails at the token with "unknown KIND 'word'" and the nearest word of the list, or all. */
enum rmap_status rmap_word_fail(const struct rmap_parser *parser, const struct rmap_token *token,
                                const char *kind, enum rmap_word_list list);

/* Every word that a criterion or `stats --of` may have but for names: the i-th, NULL behind the
 * last. */
const char *rmap_criterion_word(size_t i);

#endif
