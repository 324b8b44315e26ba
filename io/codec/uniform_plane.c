/* SPDX-License-Identifier: MIT
 *
 * The byte once, then copies of 258 bytes from one byte before, then the copies or bytes that are
 * left over. Four symbols have codes: the longest copy one bit, the others two or three.
 */
#include "io/codec/uniform_plane.h"

#include <string.h>

#include "io/file/bit_writer.h"

enum {
    END = 256,
    COPY_FIRST = 257,
    COPY_LONGEST = 285,
    COPY_MIN = 3,
    COPY_MAX = 258,
    SYMBOLS = 286,
    MANY_MIN = 11, /* symbols without a code that one number counts */
    MANY_MAX = 138
};

/* What is copied last: RFC 1951 3.2.5. */
struct copy {
    uint32_t symbol, n_extra, extra;
};

static struct copy copy_of(uint32_t length)
{
    uint32_t over = length - COPY_MIN, n_extra = 0;
    while (over >> (n_extra + 3))
        n_extra++;
    return (struct copy){COPY_FIRST + 4 * n_extra + (over >> n_extra), n_extra,
                         over & ((UINT32_C(1) << n_extra) - 1)};
}

/* Codes of the lengths: 2 bits for 0 and 18 (11 to 138 times 0), 3 for 1, 2, 3 and 17 (3 to 10
 * times 0). The list is in the stream's order: 16, 17, 18, 0, 8, 7, 9, 6, 10 and so on. */
static void put_length_codes(struct rmap_bits *bits)
{
    static const uint8_t length[] = {0, 3, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 3, 0, 3};
    enum { N = sizeof length, LEAST = 4 };
    rmap_bits_put(bits, N - LEAST, 4);
    for (int i = 0; i < N; i++)
        rmap_bits_put(bits, length[i], 3);
}

static void put_no_codes(struct rmap_bits *bits, uint32_t n)
{
    while (n >= MANY_MIN) {
        uint32_t some = n < MANY_MAX ? n : MANY_MAX;
        rmap_bits_put(bits, rmap_bits_turned(1, 2) | (some - MANY_MIN) << 2, 2 + 7);
        n -= some;
    }
    if (n >= COPY_MIN)
        rmap_bits_put(bits, rmap_bits_turned(7, 3) | (n - 3) << 3, 3 + 3);
    else
        rmap_bits_put(bits, 0, 2 * n);
}

static void put_length(struct rmap_bits *bits, uint32_t length)
{
    rmap_bits_put(bits, rmap_bits_turned(3 + length, 3), 3);
}

/* last: the symbol of the copy that is left over, or COPY_LONGEST. */
static void put_header(struct rmap_bits *bits, uint8_t byte, uint32_t last)
{
    uint32_t rare = last < COPY_LONGEST ? 3 : 2;
    rmap_bits_put(bits, 4, 3);                    /* not the last block; codes of its own */
    rmap_bits_put(bits, SYMBOLS - COPY_FIRST, 5); /* the longest copy is the last symbol */
    rmap_bits_put(bits, 0, 5);                    /* one distance: one byte before */
    put_length_codes(bits);
    put_no_codes(bits, byte);
    put_length(bits, 2);
    put_no_codes(bits, (uint32_t)END - byte - 1);
    put_length(bits, rare);
    put_no_codes(bits, last - END - 1);
    if (last < COPY_LONGEST) {
        put_length(bits, rare);
        put_no_codes(bits, COPY_LONGEST - last - 1);
    }
    put_length(bits, 1);
    put_length(bits, 1); /* of the distance */
}

size_t rmap_uniform_plane(uint8_t byte, size_t nbytes, uint8_t *out)
{
    struct rmap_bits bits = {.out = out};
    size_t n_copy = (nbytes - 1) / COPY_MAX;
    uint32_t rest = (uint32_t)((nbytes - 1) % COPY_MAX), one = rmap_bits_turned(2, 2);
    struct copy last = rest < COPY_MIN ? (struct copy){.symbol = COPY_LONGEST} : copy_of(rest);
    bool copied = last.symbol < COPY_LONGEST;
    put_header(&bits, byte, last.symbol);
    rmap_bits_put(&bits, one, 2);
    for (size_t left = 2 * n_copy, n; left > 0; left -= n) {
        n = left < 56 ? left : 56;
        rmap_bits_put(&bits, 0, (unsigned)n);
    }
    if (copied)
        rmap_bits_put(&bits, 7 | last.extra << 3, 3 + last.n_extra + 1); /* and its distance */
    else
        rmap_bits_put(&bits, rest > 1 ? one | one << 2 : one, 2 * rest);
    rmap_bits_put(&bits, copied ? rmap_bits_turned(6, 3) : 3, copied ? 3 : 2);
    return (size_t)(rmap_bits_align(&bits) - out);
}

/* A stream that is compared with what would be written. */
struct comparison {
    const uint8_t *at;
    size_t left;
    bool is_equal;
};

static void compare(struct comparison *with, const uint8_t *bytes, size_t n)
{
    with->is_equal = with->is_equal && n <= with->left && memcmp(with->at, bytes, n) == 0;
    if (with->is_equal) {
        with->at += n;
        with->left -= n;
    }
}

enum { PLANE_MOST = 1 << 16 };

static void compare_plane(struct comparison *with, uint8_t byte, size_t n)
{
    uint8_t block[RMAP_UNIFORM_BOUND + PLANE_MOST / 8];
    if (n > 0 && with->is_equal)
        compare(with, block, rmap_uniform_plane(byte, n, block));
}

bool rmap_uniform_stream(const uint8_t *stream, size_t nbytes, const uint8_t *byte, size_t n_plane,
                         size_t n_used, size_t n_zero)
{
    static const uint8_t header[2] = {0x78, 0x01}, final_block[2] = {0x03, 0x00};
    struct comparison with = {stream, nbytes, n_used + n_zero <= PLANE_MOST};
    compare(&with, header, sizeof header);
    for (size_t k = 0; k < n_plane && with.is_equal; k++) {
        compare_plane(&with, byte[k], byte[k] ? n_used : n_used + n_zero);
        compare_plane(&with, 0, byte[k] ? n_zero : 0);
    }
    compare(&with, final_block, sizeof final_block);
    return with.is_equal && with.left == 0;
}
