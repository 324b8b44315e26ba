/* SPDX-License-Identifier: MIT
 *
 * Text for a terminal: what would steer it is written as an escape instead.
 */
#include "base/visible_text.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static bool steers(uint32_t c)
{
    return (c < ' ' && c != '\n' && c != '\t') || (c >= 0x7f && c <= 0x9f) || c == 0x61c ||
           c == 0x200e || c == 0x200f || (c >= 0x202a && c <= 0x202e) ||
           (c >= 0x2066 && c <= 0x2069);
}

/* Bytes of the sequence that begins so; 0: none does (RFC 3629, section 4). */
static size_t sequence_nbytes(unsigned char lead)
{
    return lead < 0x80                    ? 1
           : lead >= 0xc2 && lead <= 0xdf ? 2
           : lead >= 0xe0 && lead <= 0xef ? 3
           : lead >= 0xf0 && lead <= 0xf4 ? 4
                                          : 0;
}

/* Whether a byte may be the second one: no overlong forms, no surrogates, nothing past U+10FFFF. */
static bool may_follow(unsigned char lead, unsigned char second)
{
    const unsigned char low = lead == 0xe0 ? 0xa0 : lead == 0xf0 ? 0x90 : 0x80;
    const unsigned char high = lead == 0xed ? 0x9f : lead == 0xf4 ? 0x8f : 0xbf;
    return second >= low && second <= high;
}

static size_t put_escape(char *out, char kind, size_t n_digit, uint32_t value)
{
    out[0] = '\\';
    out[1] = kind;
    for (size_t k = 0; k < n_digit; k++)
        out[2 + k] = "0123456789abcdef"[value >> 4 * (n_digit - 1 - k) & 0xf];
    return 2 + n_digit;
}

static size_t put_sequence(const struct rmap_visible_text *state, char *out)
{
    const unsigned char *b = state->begun;
    const size_t n = state->n_begun;
    uint32_t c = n == 1 ? b[0] : b[0] & (0xffu >> (n + 1));
    for (size_t k = 1; k < n; k++)
        c = c << 6 | (b[k] & 0x3f);
    if (steers(c))
        return put_escape(out, 'u', 4, c);
    memcpy(out, b, n);
    return n;
}

/* Begun, and not gone on with. */
static size_t put_bytes(struct rmap_visible_text *state, char *out)
{
    size_t n = 0;
    for (size_t k = 0; k < state->n_begun; k++)
        n += put_escape(out + n, 'x', 2, state->begun[k]);
    state->n_begun = 0;
    return n;
}

size_t rmap_visible_text(struct rmap_visible_text *state, const char *bytes, size_t nbytes,
                         char *out)
{
    size_t n = 0;
    for (size_t i = 0; i < nbytes; i++) {
        const unsigned char byte = (unsigned char)bytes[i];
        const unsigned char lead = state->begun[0];
        if (state->n_begun > 0 &&
            !(state->n_begun == 1 ? may_follow(lead, byte) : byte >= 0x80 && byte <= 0xbf))
            n += put_bytes(state, out + n);
        state->begun[state->n_begun++] = byte;
        const size_t whole = sequence_nbytes(state->begun[0]);
        if (whole == 0) {
            n += put_bytes(state, out + n);
        } else if (state->n_begun == whole) {
            n += put_sequence(state, out + n);
            state->n_begun = 0;
        }
    }
    return n;
}
