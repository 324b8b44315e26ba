/* SPDX-License-Identifier: MIT
 *
 * libdeflate is fastest at matches, ISA-L at literals: it reads short codes two and three at a
 * time. How far a stream shrank tells them apart.
 */
#include "io/codec/inflate.h"

#include <libdeflate.h>
#ifdef RAYMAP_HAVE_ISAL
#include <isa-l/igzip_lib.h>
#endif

#include "base/alloc.h"

struct rmap_inflater {
    struct libdeflate_decompressor *decompressor;
#ifdef RAYMAP_HAVE_ISAL
    struct inflate_state state;
#endif
};

#ifdef RAYMAP_HAVE_ISAL
/* A byte of matches takes less than so many bits, one of literals more. */
#define LITERALS_PER_BYTE 8

static bool has_literals(size_t n_in, size_t n_out)
{
    return n_in > n_out / LITERALS_PER_BYTE && n_out <= UINT32_MAX && n_in <= UINT32_MAX;
}

static bool inflate_literals(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in,
                             uint8_t *out, size_t n_out)
{
    struct inflate_state *state = &inflater->state;
    union {
        const uint8_t *in;
        uint8_t *next_in;
    } source = {.in = in}; /* ISA-L's field lacks the const that it keeps */
    isal_inflate_init(state);
    state->crc_flag = ISAL_DEFLATE;
    state->next_in = source.next_in;
    state->avail_in = (uint32_t)n_in;
    state->next_out = out;
    state->avail_out = (uint32_t)n_out;
    return isal_inflate_stateless(state) == ISAL_DECOMP_OK && state->avail_out == 0;
}
#else
static bool has_literals(size_t n_in, size_t n_out)
{
    (void)n_in;
    (void)n_out;
    return false;
}

static bool inflate_literals(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in,
                             uint8_t *out, size_t n_out)
{
    (void)inflater;
    (void)in;
    (void)n_in;
    (void)out;
    (void)n_out;
    return false;
}
#endif

enum rmap_status rmap_inflater_create(struct rmap_inflater **inflater_ret, struct rmap_error *err)
{
    struct rmap_inflater *inflater = rmap_alloc(1, sizeof *inflater);
    if (inflater)
        inflater->decompressor = libdeflate_alloc_decompressor();
    if (!inflater || !inflater->decompressor) {
        rmap_free(inflater);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoder");
    }
    *inflater_ret = inflater;
    return RMAP_OK;
}

void rmap_inflater_destroy(struct rmap_inflater *inflater)
{
    if (!inflater)
        return;
    libdeflate_free_decompressor(inflater->decompressor);
    rmap_free(inflater);
}

bool rmap_inflate(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in, uint8_t *out,
                  size_t n_out)
{
    if (has_literals(n_in, n_out) && inflate_literals(inflater, in, n_in, out, n_out))
        return true;
    return libdeflate_deflate_decompress(inflater->decompressor, in, n_in, out, n_out, NULL) ==
           LIBDEFLATE_SUCCESS;
}
