/* SPDX-License-Identifier: MIT
 *
 * Portions: recording, appending, the summary, and a digest that does not depend on blocks.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <cmocka.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "portion/portion_recorder.h"

#define N_CHANNEL 3

/* Numbers that look like a trace's, from a multiplicative hash of the ray's id. */
static double noise(uint64_t ray, uint64_t k)
{
    uint64_t x = (ray * 1000003 + k) * UINT64_C(0x9E3779B97F4A7C15);
    return (double)(x >> 11) / 9007199254740992.0;
}

static void record_ray(struct rmap_recorder *out, uint64_t ray)
{
    const double white[N_CHANNEL] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    const double red[N_CHANNEL] = {1, 0, 0};
    int n_segment = ray == 7 ? 2000 : 1 + (int)(ray % 9);
    struct rmap_emission emission = {.ray = ray,
                                     .source = (int32_t)(ray % 3),
                                     .object = -1,
                                     .primitive = -1,
                                     .position = {-0.0, noise(ray, 1), -5},
                                     .direction = {0, 0, 1},
                                     .colour = white};
    out->emit(out, &emission);
    for (int k = 0; k < n_segment; k++) {
        bool last = k == n_segment - 1;
        struct rmap_step step = {.object = last ? -1 : k % 300,
                                 .primitive = last ? -1 : k,
                                 .events = last ? RMAP_EVENT_LEFT : RMAP_EVENT_REFLECT_SPECULAR,
                                 .medium = 1,
                                 .position = {noise(ray, 10 + (uint64_t)k), k, -k},
                                 .normal = {0, last ? 0 : -1, last ? 0 : 0.5},
                                 .colour = k < 2 ? white : red};
        for (uint64_t j = 0; ray % 5 == 4 && k % 2 == 1 && j < 3; j++) {
            struct rmap_curve_point point = {.segment = (uint32_t)k,
                                             .position = {noise(ray, 40 + j), -0.0, -(double)j}};
            step.events |= RMAP_EVENT_GRADIENT;
            out->curve(out, &point);
        }
        out->step(out, &step);
        struct rmap_registration hit = {.detector = 5,
                                        .segment = (uint32_t)k,
                                        .cell = {1, 2},
                                        .relative = {0.25, 1.0},
                                        .registered = true,
                                        .direction = {0, 0, 1}};
        if (k == 1)
            out->registration(out, &hit);
    }
    struct rmap_ending ending = {.stop = RMAP_STOP_LEFT,
                                 .weight = 1,
                                 .wavelength_nm = (double)NAN,
                                 .path_length = 3,
                                 .optical_path = 4,
                                 .direction = {0, 1, 0}};
    out->end(out, &ending);
}

static struct rmap_portion *record(uint64_t first, uint64_t n)
{
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    assert_int_equal(rmap_portion_create(1, N_CHANNEL, &portion, NULL), RMAP_OK);
    rmap_portion_recorder_init(&recorder, portion);
    for (uint64_t ray = first; ray < first + n; ray++)
        record_ray(&recorder.base, ray);
    assert_int_equal(recorder.status, RMAP_OK);
    return portion;
}

static void test_recorded(void **state)
{
    (void)state;
    struct rmap_portion *p = record(100, 50);
    assert_int_equal(p->first_ray, 100);
    assert_int_equal(p->n_row[RMAP_TABLE_RAY], 50);
    size_t segments = 0, registrations = 0;
    for (uint64_t ray = 100; ray < 150; ray++) {
        segments += 1 + ray % 9;
        registrations += ray % 9 > 0;
    }
    assert_int_equal(p->n_row[RMAP_TABLE_SEGMENT], segments);
    assert_int_equal(p->n_row[RMAP_TABLE_REGISTRATION], registrations);
    assert_int_equal(p->ray.segment_count[0], 1 + 100 % 9);
    assert_int_equal(p->segment.normal[1], -32767);
    assert_int_equal(p->segment.normal[2], 16384);
    assert_int_equal(p->registration.relative[0], 16384);
    assert_int_equal(p->registration.relative[1], 65535);
    assert_int_equal(p->colour[0], 21845);
    size_t first = 99, points = 0;
    for (uint64_t ray = 100; ray < 150; ray++) {
        size_t n = rmap_portion_curve_of(p, ray, &first);
        assert_int_equal(n, ray % 5 == 4 ? 3 * ((1 + ray % 9) / 2) : 0);
        assert_int_equal(first, points);
        for (size_t k = 0; k < n; k++) {
            assert_int_equal(p->curve.ray[first + k], ray);
            assert_int_equal(p->curve.segment[first + k], 1 + 2 * (k / 3));
            assert_true(p->curve.position[3 * (first + k) + 2] == -(float)(k % 3));
        }
        points += n;
    }
    assert_int_equal(p->n_row[RMAP_TABLE_CURVE], points);
    assert_int_equal(rmap_portion_curve_of(p, 99, &first), 0);
    assert_int_equal(rmap_portion_curve_of(p, UINT64_MAX, &first), 0);
    float zero = 0;
    assert_memory_equal(p->curve.position + 1, &zero, sizeof zero);
    assert_memory_equal(p->ray.start, &zero, sizeof zero); /* -0 was stored as 0 */
    rmap_portion_destroy(p);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_summary(void **state)
{
    (void)state;
    struct rmap_portion *p = record(0, 9);
    struct rmap_portion_summary s;
    rmap_portion_summarise(p, &s);
    assert_int_equal(s.events, RMAP_EVENT_LEFT | RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_GRADIENT);
    assert_int_equal(s.stops, 1 << RMAP_STOP_LEFT);
    assert_int_equal(s.sources, 7);
    assert_int_equal(s.detectors, 1 << 5);
    assert_true(s.objects[0] == UINT64_MAX && s.objects[3] == UINT64_MAX); /* 300 objects mod 256 */
    assert_true(s.box_min[2] == -1999.0f && s.box_max[1] == 1999.0f && s.box_max[2] == 0.0f);
    p->curve.position[4] = 5000; /* points of curved segments lie in the box */
    rmap_portion_summarise(p, &s);
    assert_true(s.box_max[1] == 5000.0f);
    rmap_portion_clear(p);
    rmap_portion_summarise(p, &s);
    assert_true(s.objects[0] == 0 && isinf(s.box_min[0]));
    rmap_portion_destroy(p);
}

/* Summaries of two parts make that of both. */
static void test_summary_of_parts(void **state)
{
    (void)state;
    struct rmap_portion *first = record(0, 2), *second = record(2, 7), *both = record(0, 9);
    struct rmap_portion_summary sum, more, whole;
    rmap_portion_summarise(first, &sum);
    rmap_portion_summarise(second, &more);
    rmap_portion_summarise(both, &whole);
    assert_true(memcmp(&sum, &whole, sizeof sum) != 0);
    rmap_portion_summary_add(&sum, &more);
    assert_memory_equal(&sum, &whole, sizeof sum);
    rmap_portion_destroy(first);
    rmap_portion_destroy(second);
    rmap_portion_destroy(both);
}

/* The same rays in one block, in blocks of other sizes, and copied in reverse order. */
static void test_digest_of_any_blocks(void **state)
{
    (void)state;
    struct rmap_portion *all = record(0, 64), *copy = NULL;
    struct rmap_digest want = rmap_portion_digest(all), sum = {0, 0};
    for (uint64_t first = 0; first < 64; first += 16) {
        struct rmap_portion *part = record(first, 16);
        rmap_digest_add(&sum, rmap_portion_digest(part));
        rmap_portion_destroy(part);
    }
    assert_memory_equal(&sum, &want, sizeof sum);

    size_t segment = all->n_row[RMAP_TABLE_SEGMENT];
    size_t registration = all->n_row[RMAP_TABLE_REGISTRATION];
    assert_int_equal(rmap_portion_create(1, N_CHANNEL, &copy, NULL), RMAP_OK);
    for (size_t ray = 64; ray-- > 0;) {
        segment -= all->ray.segment_count[ray];
        registration -= all->ray.registration_count[ray];
        assert_int_equal(rmap_portion_append_ray(copy, all, ray, segment, registration, NULL),
                         RMAP_OK);
    }
    assert_int_equal(copy->first_ray, 0);
    sum = rmap_portion_digest(copy);
    assert_memory_equal(&sum, &want, sizeof sum);

    copy->segment.position[4] = nextafterf(copy->segment.position[4], 1e9f);
    sum = rmap_portion_digest(copy);
    assert_memory_not_equal(&sum, &want, sizeof sum);
    copy->segment.position[4] = nextafterf(copy->segment.position[4], -1e9f);
    copy->curve.position[7] = nextafterf(copy->curve.position[7], 1e9f);
    sum = rmap_portion_digest(copy);
    assert_memory_not_equal(&sum, &want, sizeof sum);
    rmap_portion_destroy(copy);
    rmap_portion_destroy(all);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The digest of one ray is XXH3-128 of its rows, column after column in the table's order. */
static void test_digest_by_definition(void **state)
{
    (void)state;
    /* 2000 segments, 9 segments, 1 segment, 2 segments, 6 segments of which 3 are curved */
    static const uint64_t rays[] = {7, 8, 9, 10, 14};
    for (size_t k = 0; k < sizeof rays / sizeof *rays; k++) {
        struct rmap_portion *p = record(rays[k], 1);
        uint8_t *bytes = rmap_alloc(100000, 1);
        size_t used = 0;
        for (int i = 0; i < RMAP_RAY_group_path; i++) { /* without those of timed runs */
            enum rmap_column c = (enum rmap_column)i;
            size_t n = p->n_row[rmap_column_info(c)->table] * rmap_portion_row_nbytes(p, c);
            if (n > 0)
                memcpy(bytes + used, rmap_portion_column(p, c), n);
            used += n;
        }
        XXH128_hash_t want = XXH3_128bits(bytes, used);
        struct rmap_digest got = rmap_portion_digest(p);
        assert_true(got.low == want.low64 && got.high == want.high64);
        rmap_free(bytes);
        rmap_portion_destroy(p);
    }
}

static void test_digest_carries(void **state)
{
    (void)state;
    struct rmap_digest sum = {UINT64_MAX, UINT64_MAX};
    rmap_digest_add(&sum, (struct rmap_digest){1, 0});
    assert_true(sum.low == 0 && sum.high == 0);
    char text[33];
    rmap_digest_text((struct rmap_digest){0x1234, 0xabcd}, text);
    assert_string_equal(text, "000000000000abcd0000000000001234");
}

static void test_colour_sums(void **state)
{
    (void)state;
    uint16_t q[RMAP_CHANNEL_MAX];
    for (int n = 1; n <= 100; n++) {
        double colour[RMAP_CHANNEL_MAX], total = 0;
        for (int i = 0; i < n; i++)
            total += colour[i] = noise((uint64_t)n, (uint64_t)i) * (i % 3 ? 1 : 1e-6);
        for (int i = 0; i < n; i++)
            colour[i] /= total;
        rmap_colour_quantise(colour, n, q);
        long sum = 0;
        for (int i = 0; i < n; i++) {
            sum += q[i];
            assert_true(fabs(q[i] - 65535 * colour[i]) < 1.0 + 1e-6);
        }
        assert_int_equal(sum, 65535);
    }
    rmap_colour_quantise((const double[]){0.5, 0.5}, 2, q);
    assert_int_equal(q[0], 32768); /* a tie goes to the lowest channel */
}

/* Whatever allocation fails, nothing leaks and the recorder says so. */
static void test_out_of_memory(void **state)
{
    (void)state;
    bool ran_through = false;
    for (int64_t k = 1; !ran_through; k++) {
        struct rmap_portion *p = NULL;
        struct rmap_portion_recorder recorder;
        rmap_alloc_fail_at(k);
        enum rmap_status st = rmap_portion_create(1, N_CHANNEL, &p, NULL);
        if (st == RMAP_OK) {
            rmap_portion_recorder_init(&recorder, p);
            record_ray(&recorder.base, 7);
            st = recorder.status;
        }
        rmap_alloc_fail_at(0);
        ran_through = st == RMAP_OK;
        assert_true(ran_through || st == RMAP_SYSTEM);
        rmap_portion_destroy(p);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_recorded),
        cmocka_unit_test(test_summary),
        cmocka_unit_test(test_summary_of_parts),
        cmocka_unit_test(test_digest_of_any_blocks),
        cmocka_unit_test(test_digest_by_definition),
        cmocka_unit_test(test_digest_carries),
        cmocka_unit_test(test_colour_sums),
        cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
