/* SPDX-License-Identifier: MIT
 *
 * What an MCPL file of version 2 or 3 begins with. Behind it: a double where one_weight says so;
 * texts, each behind its length of 32 bits: the program, remarks, names of data, data; then
 * particles.
 */
#ifndef RMAP_MCPL_H
#define RMAP_MCPL_H

#include <stdint.h>

struct rmap_mcpl_head {
    char magic[8]; /* "MCPL003L": little-endian */
    uint64_t n;    /* particles */
    uint32_t n_remark, n_data;
    uint32_t flags, polarised, single; /* particles have them; numbers are floats */
    int32_t one_code;                  /* PDG code of all; 0: each has its own */
    uint32_t particle_nbytes, one_weight;
};
_Static_assert(sizeof(struct rmap_mcpl_head) == 48, "as in the file");

#endif
