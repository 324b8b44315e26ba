/* SPDX-License-Identifier: MIT
 *
 * Steps of many legs at once, where a step's place is the number of its object: the letter of a set
 * of events is the least of the letters of its bits, so that each four bits of the set have a table
 * of their own that fits into a register.
 */
#ifndef RMAP_STEP_LETTERS_H
#define RMAP_STEP_LETTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rmap_step_letters {
    bool is_usable;        /* the tables say what `letter` says, and this machine can */
    uint8_t least[4][16];  /* of bits 4 k to 4 k + 3 */
    uint8_t is_inside[16]; /* 255: of this letter is something that can happen without an object */
};

/* letter: [2^13] of sets of events, below 16; inside: bits of letters. */
void rmap_step_letters_init(struct rmap_step_letters *letters, const uint8_t *letter,
                            uint32_t inside);

/* step[i] = (object[i] + 1) << 4 | letter for the first of n legs, objects being from -1 to 4094;
 * returns how many: all but at most 15, or none where the tables are not usable. *inside_ret: some
 * of them have no object and such a letter. */
size_t rmap_step_letters_steps(const struct rmap_step_letters *letters, const int32_t *object,
                               const uint32_t *event, size_t n, uint16_t *step, bool *inside_ret);

#endif
