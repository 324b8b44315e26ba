/* SPDX-License-Identifier: MIT
 *
 * Chunks come back equal whatever is in them and however they are deflated, zlib itself reads them,
 * fletcher32 is Fletcher's, and no flipped bit goes unseen.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/codec/shuffle.h"

enum { N_MAX = 3 * 65536, N_KIND = 6 };

static uint64_t next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return *state >> 33;
}

/* Kinds of columns: constant, noise, floats of a scene, small counts, repeated paths,
 * zeros. */
static void fill(int kind, uint8_t *raw, size_t n, size_t size)
{
    uint64_t random = (uint64_t)kind + 1;
    for (size_t i = 0; i < n * size; i++)
        raw[i] = kind == 0   ? 7
                 : kind == 1 ? (uint8_t)next_random(&random)
                 : kind == 3 ? (uint8_t)(i % size ? 0 : next_random(&random) % 9)
                 : kind == 5 ? 0
                 : kind == 4 ? (uint8_t)("lens barrel sensor "[i % 19])
                             : 0;
    for (size_t i = 0; kind == 2 && size == 4 && i < n; i++) {
        float x = 100.0f * (float)next_random(&random) / 2147483648.0f - 50.0f;
        memcpy(raw + 4 * i, &x, 4);
    }
}

/* The planes come back from chunks deflated in every way, each of which does what it is for. */
static void check_ways(struct rmap_encoder *encoder, struct rmap_decoder *decoder, int kind,
                       const uint8_t *planes, size_t n, size_t size)
{
    enum { ANY, RUNS = RMAP_ENCODE_RUNS, QUICK = RMAP_ENCODE_QUICK, BOTH = RUNS | QUICK };
    uint8_t *stored = rmap_alloc(rmap_codec_bound(n, size) + RMAP_INFLATE_SLACK, 1);
    uint8_t *back = rmap_alloc(n, size);
    size_t nbytes[BOTH + 1];
    for (unsigned how = ANY; how <= BOTH; how++) {
        nbytes[how] = rmap_encoder_encode_planes(encoder, planes, n, size, how, stored);
        uLongf got = n * size;
        assert_int_equal(uncompress(back, &got, stored, nbytes[how] - 4), Z_OK);
        assert_int_equal(rmap_decoder_planes(decoder, stored, nbytes[how], n, size, back, NULL),
                         RMAP_OK);
        assert_memory_equal(planes, back, n * size);
    }
    if (kind == 3 && n >= 4096) /* one of nine values, by chance: runs */
        assert_true(nbytes[RUNS] < nbytes[ANY] && nbytes[BOTH] == nbytes[RUNS]);
    if (kind == 4 && n >= 4096) /* what comes again and again: matches */
        assert_int_equal(nbytes[RUNS], nbytes[ANY]);
    if (kind == 1) /* noise: as it is */
        assert_true(nbytes[QUICK] > n * size && nbytes[BOTH] == nbytes[QUICK]);
    rmap_free(stored);
    rmap_free(back);
}

/* n elements, of which those from n_used on are 0. */
static void check_round_trip(struct rmap_encoder *encoder, struct rmap_decoder *decoder, int kind,
                             size_t n_used, size_t n, size_t size)
{
    uint8_t *raw = rmap_alloc(n, size), *back = rmap_alloc(n, size), *planes = rmap_alloc(n, size);
    uint8_t *stored = rmap_alloc(rmap_codec_bound(n, size) + RMAP_INFLATE_SLACK, 1);
    size_t nbytes;
    fill(kind, raw, n, size);
    memset(raw + n_used * size, 0x55, (n - n_used) * size); /* not to be looked at */
    assert_int_equal(rmap_encoder_encode(encoder, raw, n_used, n, size, stored, &nbytes, NULL),
                     RMAP_OK);
    memset(raw + n_used * size, 0, (n - n_used) * size);
    assert_true(nbytes <= rmap_codec_bound(n, size));
    assert_int_equal(rmap_decoder_planes(decoder, stored, nbytes, n, size, planes, NULL), RMAP_OK);
    rmap_unshuffle(planes, n, 0, n, size, back);
    assert_memory_equal(raw, back, n * size);
    rmap_unshuffle(planes, n, n / 3, n / 2, size, back); /* a range alone */
    assert_memory_equal(raw + n / 3 * size, back, n / 2 * size);

    uLongf got = n * size;
    assert_int_equal(uncompress(planes, &got, stored, nbytes - 4), Z_OK);
    assert_int_equal(got, n * size);
    for (size_t i = 0; i < n * size; i++) /* HDF5's shuffle, by its definition */
        assert_int_equal(planes[i], raw[i % n * size + i / n]);
    if (n_used == n && size == 4)
        check_ways(encoder, decoder, kind, planes, n, size);
    rmap_free(raw);
    rmap_free(back);
    rmap_free(planes);
    rmap_free(stored);
}

static void test_round_trip(void **state)
{
    (void)state;
    static const size_t rows[] = {1, 2, 7, 4095, 4096, 5000, 65536, N_MAX};
    static const size_t sizes[] = {1, 2, 4, 8};
    struct rmap_encoder *encoder = NULL;
    struct rmap_decoder *decoder = NULL;
    assert_int_equal(rmap_encoder_create(&encoder, NULL), RMAP_OK);
    assert_int_equal(rmap_decoder_create(&decoder, NULL), RMAP_OK);
    for (int kind = 0; kind < N_KIND; kind++)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
            for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
                check_round_trip(encoder, decoder, kind, rows[i], rows[i], sizes[k]);
                check_round_trip(encoder, decoder, kind, rows[i] - 1, rows[i], sizes[k]);
                check_round_trip(encoder, decoder, kind, rows[i] / 3, rows[i], sizes[k]);
            }
    rmap_encoder_destroy(encoder);
    rmap_decoder_destroy(decoder);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The sums as Fletcher (1982, doi:10.1109/TCOM.1982.1095369) defines them, word by word. */
static uint32_t fletcher_by_definition(const uint8_t *data, size_t nbytes)
{
    uint32_t sum1 = 0, sum2 = 0;
    for (size_t i = 0; i < nbytes; i += 2) {
        sum1 += (uint32_t)data[i] << 8 | (i + 1 < nbytes ? data[i + 1] : 0u);
        sum1 = (sum1 & 0xffff) + (sum1 >> 16);
        sum2 += sum1;
        sum2 = (sum2 & 0xffff) + (sum2 >> 16);
    }
    return sum2 << 16 | sum1;
}

static void test_fletcher(void **state)
{
    (void)state;
    static uint8_t data[20000];
    uint64_t random = 1;
    assert_int_equal(rmap_fletcher32(data, sizeof data), 0);
    memset(data, 0xff, sizeof data);
    assert_int_equal(rmap_fletcher32(data, sizeof data), fletcher_by_definition(data, 20000));
    for (size_t n = 0; n < sizeof data; n = n < 100 ? n + 1 : n + 997) {
        for (size_t i = 0; i < n; i++)
            data[i] = (uint8_t)next_random(&random);
        assert_int_equal(rmap_fletcher32(data, n), fletcher_by_definition(data, n));
    }
}

static void test_damage_is_seen(void **state)
{
    (void)state;
    enum { N = 5000 };
    static uint8_t raw[4 * N], back[4 * N];
    struct rmap_encoder *encoder = NULL;
    struct rmap_decoder *decoder = NULL;
    uint8_t *stored = rmap_alloc(rmap_codec_bound(N, 4) + RMAP_INFLATE_SLACK, 1);
    size_t nbytes;
    uint64_t random = 9;
    assert_int_equal(rmap_encoder_create(&encoder, NULL), RMAP_OK);
    assert_int_equal(rmap_decoder_create(&decoder, NULL), RMAP_OK);
    fill(2, raw, N, 4);
    assert_int_equal(rmap_encoder_encode(encoder, raw, N, N, 4, stored, &nbytes, NULL), RMAP_OK);
    uint64_t sum = rmap_checksum(stored, nbytes);
    for (int k = 0; k < 500; k++) {
        size_t at = next_random(&random) % nbytes;
        uint8_t bit = (uint8_t)(1u << (next_random(&random) % 8));
        stored[at] ^= bit;
        assert_true(rmap_checksum(stored, nbytes) != sum);
        assert_int_equal(rmap_decoder_planes(decoder, stored, nbytes, N, 4, back, NULL),
                         RMAP_FORMAT);
        stored[at] ^= bit;
    }
    for (size_t cut = 0; cut < nbytes; cut += 101)
        assert_int_equal(rmap_decoder_planes(decoder, stored, cut, N, 4, back, NULL), RMAP_FORMAT);
    assert_int_equal(rmap_decoder_planes(decoder, stored, nbytes, N - 1, 4, back, NULL),
                     RMAP_FORMAT);
    rmap_encoder_destroy(encoder);
    rmap_decoder_destroy(decoder);
    rmap_free(stored);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_fletcher),
        cmocka_unit_test(test_damage_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
