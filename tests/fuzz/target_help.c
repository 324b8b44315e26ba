/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "target.h"

void rmap_fuzz_take(const uint8_t **data, size_t *nbytes, void *to, size_t n)
{
    size_t have = n < *nbytes ? n : *nbytes;
    memset(to, 0, n);
    if (have > 0)
        memcpy(to, *data, have);
    *data += have;
    *nbytes -= have;
}

void rmap_fuzz_demand(int good, const char *what)
{
    if (good)
        return;
    (void)fprintf(stderr, "broken: %s\n", what);
    abort();
}

size_t rmap_fuzz_seed_text(const char *const *seed, size_t n, unsigned k, uint8_t *to, size_t cap)
{
    if (k >= n || strlen(seed[k]) > cap)
        return 0;
    memcpy(to, seed[k], strlen(seed[k]));
    return strlen(seed[k]);
}
