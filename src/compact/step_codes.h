/* SPDX-License-Identifier: MIT
 *
 * Classes of the segments of a portion's own paths as codes of a byte each, so that what every
 * question about steps reads need not be inflated.
 */
#ifndef RMAP_COMPACT_STEP_CODES_H
#define RMAP_COMPACT_STEP_CODES_H

#include "base/status.h"
#include "compact/layout.h"

/* Rows of /own_segment/object then are words: n_code classes, those met most often first; four
 * codes a word, the first in its lowest byte; two classes a word for codes RMAP_STEP_RARE, in
 * order, the first in its lower half. What is left of a word is 0. */
enum { RMAP_STEP_RARE = 255, RMAP_STEP_CLASS_MAX = 65536 };

/* A class, and how often a portion has it. */
struct rmap_step_met {
    uint32_t n, class;
};

/* Zero it at first. */
struct rmap_step_coder {
    uint32_t *n_met; /* [classes] */
    uint8_t *code;   /* [classes] */
    struct rmap_step_met *met;
    uint32_t *word;
    size_t n_met_cap, code_cap, met_cap, word_cap;
};
void rmap_step_coder_fini(struct rmap_step_coder *coder);

/* Codes n classes, all less than n_class: coder->word [*n_word_ret]. *n_code_ret: 0 where codes
 * would take as many words as there are classes. RMAP_SYSTEM. */
enum rmap_status rmap_step_codes_make(struct rmap_step_coder *coder, const uint32_t *class,
                                      size_t n, size_t n_class, size_t *n_word_ret,
                                      size_t *n_code_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Those of a portion, borrowed from its rows. */
struct rmap_step_codes {
    size_t n_code; /* 0: segments are not coded; nothing else is set then */
    size_t n;      /* segments */
    const uint32_t
        *class_of;       /* [n_code]; this and the next two NULL where the stream is not there */
    const uint8_t *code; /* [n]; those from n_code on but RMAP_STEP_RARE have no class */
    const uint32_t *rare;
    size_t n_rare_word;
};

/* n_code: as the portion's header says. RMAP_FORMAT where words are too few for the segments. */
enum rmap_status rmap_step_codes_open(const struct rmap_rows *rows, size_t n_code,
                                      struct rmap_step_codes *codes,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A bit for each segment whose class passes: pass [n_class]. bits: [rmap_bit_words(n)]. */
void rmap_step_codes_mark(const struct rmap_step_codes *codes, const uint8_t *pass, size_t n_class,
                          uint64_t *bits);

/* What stands for the class of each segment: of_class [n_class + 1], the last for other numbers.
 * out: [n]. */
void rmap_step_codes_look_up(const struct rmap_step_codes *codes, const uint16_t *of_class,
                             size_t n_class, uint16_t *out);

/* Zero it at first; rmap_free(class). */
struct rmap_step_buffer {
    uint32_t *class;
    size_t cap;
};

/* *out: the portion's rows with classes in the place of codes, in the buffer, if there are codes
 * and the stream is there; else they are counted alone. Other rows as they are, and borrowed.
 * RMAP_FORMAT where codes are not as many as own paths have segments; RMAP_SYSTEM. */
enum rmap_status rmap_step_codes_unpack(const struct rmap_rows *rows, size_t n_code,
                                        struct rmap_step_buffer *buffer, struct rmap_rows *out,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
