/* SPDX-License-Identifier: MIT
 *
 * Lines and words of a lens file, and what its readers share.
 */
#ifndef RMAP_LENS_TEXT_H
#define RMAP_LENS_TEXT_H

#include "io/lensfile/prescription.h"

enum { RMAP_LENS_WORDS_MAX = 64 };

/* The text in UTF-8 with a 0 behind it, from UTF-16 with a mark of its order, UTF-8 or Latin-1;
 * rmap_free. RMAP_INPUT: it is no text; RMAP_SYSTEM. */
enum rmap_status rmap_lens_decode(const char *bytes, size_t nbytes, char **text_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* A walk through the text, which it cuts into lines. */
struct rmap_lens_lines {
    char *at, *line;
    size_t number;
};

/* The next line, without its end and blanks there. */
bool rmap_lens_next_line(struct rmap_lens_lines *lines);

/* Cuts a text at blanks (and `more`) into words; what stands in double or single quotes is one.
 * How many, those beyond RMAP_LENS_WORDS_MAX left out. */
size_t rmap_lens_words(char *text, const char *more, char *word[RMAP_LENS_WORDS_MAX]);

bool rmap_lens_is(const char *word, const char *other); /* in any case */

/* A finite number; false: it is none, *value unset. */
bool rmap_lens_number(const char *word, double *value);

/* The k-th word as a number, or `other` where it is none. */
double rmap_lens_value(char *const *word, size_t n_word, size_t k, double other);

/* Tells of words that should be numbers and are none, after one of `keys` in any case:
 * "CURV PARM:2 CIR:$" wants one after CURV, up to two after PARM, one at the end of CIR. */
void rmap_lens_expect_number(struct rmap_prescription *lens, size_t line,
                             struct rmap_lens_surface *surface, const char *keys, const char *key,
                             char *const *word, size_t n_word);

/* Of um, without what binary fractions add behind the digits of the file. */
double rmap_lens_nm(double um);

/* Text that can stand in a line of a scene, cut where it has no room. */
void rmap_lens_copy(char *to, size_t cap, const char *text);

/* Adds words to a remark, after "; ". */
void rmap_lens_remark(struct rmap_lens_surface *surface, const char *format, ...) RMAP_PRINTF(2, 3);

/* Something that is not in the scene, or not as the file has it: in the findings with the line and
 * the surface (NULL: of the whole), and in its remark. */
void rmap_lens_lost(struct rmap_prescription *lens, size_t line, struct rmap_lens_surface *surface,
                    const char *format, ...) RMAP_PRINTF(4, 5);

/* A plain surface at the end. NULL after an error: RMAP_INPUT, RMAP_SYSTEM. */
struct rmap_lens_surface *rmap_lens_add(struct rmap_prescription *lens, size_t line,
                                        struct rmap_error *err);

enum rmap_status rmap_lens_note(struct rmap_prescription *lens, const char *text,
                                struct rmap_error *err) RMAP_MUST_USE;

/* A power of r: false where a conic has no such term and it is not 0. */
bool rmap_lens_set_asphere(struct rmap_lens_surface *surface, int power, double value);

/* A glass of a private catalogue: indices at n wavelengths in um, as far as there is room. */
enum rmap_status rmap_lens_add_glass(struct rmap_prescription *lens, size_t line, const char *name,
                                     const double *um, const double *index, size_t n,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* A term that is not 0, in the order of their numbers. False: there is no room. */
bool rmap_lens_add_term(struct rmap_lens_surface *surface, enum rmap_lens_terms kind, int i, int j,
                        double value);

/* Rotations about x, then the new y, then the new z, right-handed, after a shift: the map from the
 * new axes to the old. */
struct rmap_affine rmap_lens_turn(const double shift[3], const double tilt_deg[3]);

/* Exponents of the k-th (from 0) of x, y, x^2, x y, y^2, x^3 ... */
void rmap_lens_xy_powers(int k, int *i, int *j);

enum rmap_status rmap_lens_read_zmx(char *text, struct rmap_prescription *lens,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_lens_read_seq(char *text, struct rmap_prescription *lens,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_lens_read_oslo(char *text, struct rmap_prescription *lens,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
