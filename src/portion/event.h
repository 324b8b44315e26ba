/* SPDX-License-Identifier: MIT
 *
 * What can happen at the end of a segment. This one table drives the tracer, the writer, the
 * reader, the words of the criterion language, the report's text and the docs.
 * Columns: symbol, bit, letter (of `path("...")`), word, meaning.
 */
#ifndef RMAP_EVENT_H
#define RMAP_EVENT_H

#include <stdint.h>

#define RMAP_EVENT_TABLE(X)                                                                        \
    X(REFLECT_SPECULAR, 0, 'R', "reflect_specular", "specular reflection")                         \
    X(REFLECT_DIFFUSE, 1, 'D', "reflect_diffuse", "diffuse reflection")                            \
    X(TRANSMIT_SPECULAR, 2, 'T', "transmit_specular", "specular transmission")                     \
    X(TRANSMIT_DIFFUSE, 3, 'd', "transmit_diffuse", "diffuse transmission")                        \
    X(TOTAL_REFLECTION, 4, 'I', "total_reflection", "total internal reflection")                   \
    X(ABSORB, 5, 'A', "absorb", "absorption")                                                      \
    X(SCATTER_VOLUME, 6, 'S', "scatter_volume", "scattering in a volume")                          \
    X(FLUORESCE, 7, 'F', "fluoresce", "fluorescence")                                              \
    X(GRADIENT, 8, 0, "gradient", "curved leg through a gradient medium")                          \
    X(ELEMENT, 9, 'O', "element", "passage through an optical element")                            \
    X(LEFT, 10, 'X', "left", "left the scene")                                                     \
    X(LIMIT, 11, 'K', "limit", "stopped by a limit")                                               \
    X(ERROR, 12, 'E', "error", "stopped by an error")

enum rmap_event {
#define RMAP_EVENT_ENUM(symbol, bit, letter, word, meaning) RMAP_EVENT_##symbol = 1u << (bit),
    RMAP_EVENT_TABLE(RMAP_EVENT_ENUM)
#undef RMAP_EVENT_ENUM
};

/* Unions with words of their own in the criterion language. */
#define RMAP_EVENT_UNION_TABLE(X)                                                                  \
    X("reflect",                                                                                   \
      RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TOTAL_REFLECTION)      \
    X("transmit", RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TRANSMIT_DIFFUSE)                      \
    X("specular",                                                                                  \
      RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TOTAL_REFLECTION)    \
    X("diffuse", RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE)                         \
    X("scatter",                                                                                   \
      RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE | RMAP_EVENT_SCATTER_VOLUME)

/* Why a ray ended; stored in /ray/stop. Words as in `ended(...)`. */
#define RMAP_STOP_TABLE(X)                                                                         \
    X(ABSORBED, 0, "absorbed")                                                                     \
    X(LEFT, 1, "left")                                                                             \
    X(LIMIT, 2, "limit")                                                                           \
    X(ERROR, 3, "error")

enum rmap_stop {
#define RMAP_STOP_ENUM(symbol, value, word) RMAP_STOP_##symbol = (value),
    RMAP_STOP_TABLE(RMAP_STOP_ENUM)
#undef RMAP_STOP_ENUM
        RMAP_STOP_COUNT
};

/* Word of a single event bit, or NULL. */
const char *rmap_event_word(uint32_t bit);

/* Bits that a word (event or union) stands for; 0 when the word is unknown. */
uint32_t rmap_event_mask(const char *word);

/* The letter of a step with these bits: the first of E K O F S I R T D d A X that is set;
 * 0 for none. */
char rmap_event_letter(uint32_t events);

/* What every bit means: "reflect_specular = 2^0, reflect_diffuse = 2^1, ...". */
const char *rmap_event_bits(void);

/* Word of a stop reason, or NULL. */
const char *rmap_stop_word(int stop);

#endif
