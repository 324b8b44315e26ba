/* SPDX-License-Identifier: MIT
 *
 * A path("...") ready to run. A row of /segment has one of RMAP_PATH_LETTER_COUNT letters and a
 * KIND: objects (and media, for a row without an object) that no name of the expression tells
 * apart are of one kind. Letter and kind give the row's SYMBOL; so does the detector of a
 * registration. A deterministic automaton walks over the symbols.
 */
#ifndef RMAP_PATH_TABLE_H
#define RMAP_PATH_TABLE_H

#include "analysis/criterion/path_regex.h"

enum { RMAP_PATH_EVENT_BITS = 13, RMAP_PATH_EVENT_CODES = 1 << RMAP_PATH_EVENT_BITS };

/* Needs that a path keeps: more would not rule out many more rays. */
enum { RMAP_PATH_NEED_MAX = 4 };

/* What every history that matches has somewhere: a step, or a registration, with one of these
 * symbols. Rays that lack it need not be run. */
struct rmap_path_need {
    const uint8_t *has; /* [n_symbol] */
    bool is_hit;        /* a registration */
};

/* A symbol is below n_symbol; that of a ray's last row is greater by n_symbol; a ray without any
 * has 2 * n_symbol alone. */
struct rmap_path_table {
    size_t n_object, n_medium, n_detector;
    bool of_object, of_medium; /* names of objects, of media stand in the expression */
    uint16_t n_kind;
    const uint8_t *letter_of_event; /* [RMAP_PATH_EVENT_CODES] shared by a criterion's paths */
    const uint16_t *kind_of_object; /* [n_object + 1], the last for any other number */
    const uint16_t *kind_of_medium; /* [n_medium + 1], likewise, where there is no object */
    const uint16_t *symbol_of_base; /* [letter * n_kind + kind] */
    const uint16_t *symbol_of_hit;  /* [n_detector + 1], likewise */
    const uint8_t *follows_object;  /* [n_detector] registers behind the step, not before it */
    uint32_t n_symbol, n_state;
    uint32_t width;       /* 2 * n_symbol + 1 */
    const uint32_t *next; /* [n_state][width] state * width. Behind a ray's last symbol it is 0, or
                             `width` when the ray matched; either begins the next ray */
    const uint8_t *first; /* [n_symbol] that a matching history may begin with; NULL: any */
    const uint8_t *needs_met; /* [n_symbol] bit k: by need k */
    int n_need;
    struct rmap_path_need need[RMAP_PATH_NEED_MAX];
};

/* The symbols of n rows of /segment; that of one, and of a registration on a detector. */
void rmap_path_symbols(const struct rmap_path_table *table,
                       const struct rmap_segment_columns *segment, size_t first, size_t n,
                       uint16_t *symbol);
uint16_t rmap_path_row_symbol(const struct rmap_path_table *table,
                              const struct rmap_segment_columns *segment, size_t row);
uint16_t rmap_path_hit_symbol(const struct rmap_path_table *table, int32_t detector);

/* Number of a ray's steps before a registration, a row of /registration. */
size_t rmap_path_place(const struct rmap_path_table *table,
                       const struct rmap_registration_columns *registration, size_t row);

/* What the automaton is built over. */
struct rmap_path_alphabet {
    uint32_t n_symbol;
    uint8_t *has; /* [n_atom][n_symbol] */
};

/* Fills the table's maps, whose memory the criterion owns; alphabet->has is the caller's, also on
 * failure. RMAP_INPUT when names tell too many kinds apart. */
enum rmap_status rmap_path_alphabet_create(struct rmap_parser *parser,
                                           const struct rmap_token *string,
                                           const struct rmap_path_regex *regex,
                                           struct rmap_path_table *table,
                                           struct rmap_path_alphabet *alphabet) RMAP_MUST_USE;

/* Fills need, which keeps parts of alphabet->has: the criterion's copy of it. */
enum rmap_status rmap_path_needs_create(struct rmap_parser *parser,
                                        const struct rmap_path_regex *regex,
                                        const struct rmap_path_alphabet *alphabet,
                                        struct rmap_path_table *table) RMAP_MUST_USE;

/* Fills next, n_state and width; bounded in time and memory: RMAP_INPUT when it would take more. */
enum rmap_status rmap_path_automaton_create(struct rmap_parser *parser,
                                            const struct rmap_token *string,
                                            const struct rmap_path_regex *regex,
                                            const struct rmap_path_alphabet *alphabet,
                                            struct rmap_path_table *table) RMAP_MUST_USE;

#endif
