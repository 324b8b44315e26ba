/* SPDX-License-Identifier: MIT
 *
 * The regular expression of a path("..."), parsed: what its atoms match, and how they follow
 * each other.
 */
#ifndef RMAP_PATH_REGEX_H
#define RMAP_PATH_REGEX_H

#include "analysis/criterion/criterion_parser.h"

/* Letters, as bits: those of steps by precedence, then the registration. */
#define RMAP_PATH_LETTERS "EKOFSIRTDdAXV"
enum {
    RMAP_PATH_LETTER_V = 12,
    RMAP_PATH_LETTER_COUNT = 13,
    RMAP_PATH_STEPS = (1 << RMAP_PATH_LETTER_V) - 1,
    RMAP_PATH_ANY = (1 << RMAP_PATH_LETTER_COUNT) - 1,
    RMAP_PATH_INSIDE = 1 << 4 | 1 << 10 /* S and A, which also happen inside a medium */
};

/* What one path may hold; beyond, it is refused with a message. */
enum {
    RMAP_PATH_NAME_MAX = 1000,  /* different names */
    RMAP_PATH_ATOM_MAX = 4096,  /* different [letters]@name */
    RMAP_PATH_DEPTH_MAX = 2000, /* nested parentheses */
    RMAP_PATH_REPEAT_MAX = 1000000
};

/* What a name stands for: empty sets where it stands for none. */
struct rmap_path_place {
    size_t begin, end; /* bytes of the text */
    struct rmap_index_set object, medium, detector;
    bool is_object, is_medium, is_detector;
};

struct rmap_path_atom {
    uint32_t letters; /* bits */
    int32_t place;    /* -1: anywhere */
};

enum rmap_path_term_kind {
    RMAP_PATH_ATOM,
    RMAP_PATH_SEQUENCE,
    RMAP_PATH_CHOICE,
    RMAP_PATH_REPEAT /* of the one child */
};

#define RMAP_PATH_UNBOUNDED UINT32_MAX

struct rmap_path_term {
    enum rmap_path_term_kind kind;
    int32_t last, prev;   /* last child, previous sibling; -1: none */
    uint32_t atom;        /* ATOM */
    uint32_t least, most; /* REPEAT */
    size_t begin, end;    /* bytes of the text: the letter, or the quantifier */
};

struct rmap_path_regex {
    struct rmap_path_place *place;
    struct rmap_path_atom *atom;
    struct rmap_path_term *term;
    size_t n_place, place_cap, n_atom, atom_cap, n_term, term_cap;
    int32_t root;
};

/* Parses the inside of a STRING token of the parser's text; *regex is zeroed. RMAP_INPUT with a
 * caret at the place within the text. Released by rmap_path_regex_fini whatever happened. */
enum rmap_status rmap_path_regex_parse(struct rmap_parser *parser, const struct rmap_token *string,
                                       struct rmap_path_regex *regex) RMAP_MUST_USE;
void rmap_path_regex_fini(struct rmap_path_regex *regex);

#endif
