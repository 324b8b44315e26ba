/* SPDX-License-Identifier: MIT
 *
 * The words of the language, in one table: the parser, its suggestions, `stats --of` and completion
 * are made of it.
 */
#ifndef RMAP_CRITERION_WORD_H
#define RMAP_CRITERION_WORD_H

#include "analysis/criterion/criterion_mark.h"
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
    const char *wants; /* in brackets, with an example; NULL: a number may stand alone */
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

/* The number of `stats --of` at a place of their list, from 1; NULL behind the last. */
const struct rmap_word *rmap_stats_word(int place);

/* One elementary test with its comparison. */
enum rmap_status rmap_parse_test(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* Name tokens, and the sets they stand for among the wanted kind. look_up: *found_ret says
 * whether the name is known; parse_set fails when it is not. */
enum rmap_status rmap_parser_take_name(struct rmap_parser *parser, const char *what,
                                       struct rmap_token *token_ret) RMAP_MUST_USE;
enum rmap_status rmap_parser_look_up(struct rmap_parser *parser, const struct rmap_token *token,
                                     enum rmap_name_wanted wanted, struct rmap_index_set *set,
                                     bool *found_ret) RMAP_MUST_USE;
enum rmap_status rmap_parse_set(struct rmap_parser *parser, enum rmap_name_wanted wanted,
                                struct rmap_index_set *set) RMAP_MUST_USE;

/* "(NAME)" of media, as behind path_length. */
enum rmap_status rmap_parse_media(struct rmap_parser *parser,
                                  struct rmap_index_set *media) RMAP_MUST_USE;

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

#endif
