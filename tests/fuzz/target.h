/* SPDX-License-Identifier: MIT
 *
 * A fuzz target: bytes in, nothing out, abort() where a promise is broken. The preset `fuzz` links
 * each with libFuzzer; every other preset links it with seeded_driver.c, which feeds it mutations
 * of its seeds, the same ones every time, so that the promise is kept where clang is not.
 */
#ifndef RMAP_FUZZ_TARGET_H
#define RMAP_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes);

/* Inputs that lead past the first checks: writes the k-th and returns its size, at most cap; 0
 * when there is no k-th. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap);

/* rmap_fuzz_seed of a target whose seeds are the texts [n]. */
size_t rmap_fuzz_seed_text(const char *const *seed, size_t n, unsigned k, uint8_t *to, size_t cap);

/* Mutations that the seeded driver tries: some seconds' worth. */
extern const unsigned rmap_fuzz_rounds;

/* The n bytes at *data, taken off; zeros where there are fewer. */
void rmap_fuzz_take(const uint8_t **data, size_t *nbytes, void *to, size_t n);

/* Reads a picture of the surroundings: it is refused with a sentence, or its pixels are numbers of
 * light. */
void rmap_fuzz_picture(const uint8_t *data, size_t nbytes);

/* abort() with a word of what is wrong, unless `good`. */
void rmap_fuzz_demand(int good, const char *what);

#endif
