/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/picture/picture.h"
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

void rmap_fuzz_picture(const uint8_t *data, size_t nbytes)
{
    struct rmap_picture picture = {.rgb = NULL};
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    const enum rmap_status st = rmap_picture_read(data, nbytes, &picture, &err);
    if (st == RMAP_OK)
        for (size_t i = 0; i < 3 * (size_t)picture.size[0] * picture.size[1]; i++)
            rmap_fuzz_demand(picture.rgb[i] >= 0.0F && isfinite(picture.rgb[i]), "light");
    else
        rmap_fuzz_demand(st == RMAP_INPUT && err.text[0], "what is wrong is said");
    rmap_picture_fini(&picture);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
}

size_t rmap_fuzz_seed_text(const char *const *seed, size_t n, unsigned k, uint8_t *to, size_t cap)
{
    if (k >= n || strlen(seed[k]) > cap)
        return 0;
    memcpy(to, seed[k], strlen(seed[k]));
    return strlen(seed[k]);
}
