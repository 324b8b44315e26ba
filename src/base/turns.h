/* SPDX-License-Identifier: MIT
 *
 * Numbers whose places in an array repeat, as those of rays that one of several sources emits in
 * its turn: picked by places known beforehand, without a look at whose each is.
 */
#ifndef RMAP_TURNS_H
#define RMAP_TURNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RMAP_TURNS_MOST = 64, RMAP_TURNS_ABREAST = 8 };

/* Where so many that follow each other come from. */
struct rmap_turns_step {
    uint16_t first;                    /* place of the first of them */
    uint8_t after[RMAP_TURNS_ABREAST]; /* places of all, from that one on */
};

/* Of one of those who take turns. No memory of its own. */
struct rmap_turns {
    size_t period, n; /* n places in so many numbers */
    uint8_t place[RMAP_TURNS_MOST];
    /* Steps, until they repeat `stride` numbers further on. They read no further than `reach`. */
    size_t n_step, stride, reach;
    bool are_near; /* numbers of each step stand close together */
    struct rmap_turns_step step[RMAP_TURNS_MOST];
};

/* Those with cycle[(k + phase) % period] == which; 0 < period <= RMAP_TURNS_MOST, phase < period.
 */
void rmap_turns_init(struct rmap_turns *turns, const int32_t *cycle, size_t period, size_t phase,
                     int32_t which);

/* Those of n values, in their order: to `to`, which has room for them. Returns how many. */
size_t rmap_turns_pick(const struct rmap_turns *turns, const double *value, size_t n, double *to);

#endif
