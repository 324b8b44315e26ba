/* SPDX-License-Identifier: MIT
 *
 * The promise: classes of steps come back out of their codes, marks are those of the classes, and
 * words that do not fit together are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "compact/compact.h"
#include "compact/step_codes.h"
#include "compact/streams.h"

enum { MOST = 20000 };

struct coded {
    struct rmap_step_coder coder;
    struct rmap_step_buffer buffer;
    uint32_t class[MOST], count[2];
    struct rmap_rows rows;
    size_t n, n_code;
};

/* Classes below n_class, small ones most often; as rows of a portion with two own paths. */
static void make(struct coded *self, size_t n, uint32_t n_class)
{
    size_t n_word = 0, n_code = 0;
    uint32_t x = 12345;
    for (size_t i = 0; i < n; i++) {
        x = x * 1664525u + 1013904223u;
        const double u = (x >> 8) / 16777216.0;
        self->class[i] = (uint32_t)(u * u * u * n_class);
    }
    self->n = n;
    assert_int_equal(
        rmap_step_codes_make(&self->coder, self->class, n, n_class, &n_word, &n_code, NULL),
        RMAP_OK);
    self->n_code = n_code;
    self->count[0] = (uint32_t)(n / 3);
    self->count[1] = (uint32_t)(n - n / 3);
    self->rows = (struct rmap_rows){.layout = &rmap_compact_layout, .n_channel = 1};
    self->rows.n_row[RMAP_COMPACT_OWN] = 2;
    self->rows.data[RMAP_STREAM_OWN_segment_count] = self->count;
    self->rows.n_row[RMAP_COMPACT_OWN_SEGMENT] = n_code > 0 ? n_word : n;
    self->rows.data[RMAP_STREAM_OWN_object] = n_code > 0 ? self->coder.word : self->class;
}

static void end(struct coded *self)
{
    rmap_step_coder_fini(&self->coder);
    rmap_free(self->buffer.class);
    rmap_free(self);
}

static void check_classes(struct coded *self)
{
    struct rmap_rows rows;
    assert_int_equal(rmap_step_codes_unpack(&self->rows, self->n_code, &self->buffer, &rows, NULL),
                     RMAP_OK);
    assert_int_equal(rows.n_row[RMAP_COMPACT_OWN_SEGMENT], self->n);
    if (self->n > 0)
        assert_memory_equal(rows.data[RMAP_STREAM_OWN_object], self->class,
                            self->n * sizeof *self->class);
}

static void check_marks(struct coded *self, uint32_t n_class)
{
    static uint64_t bits[MOST / 64 + 2];
    static uint16_t symbol[MOST];
    struct rmap_step_codes codes;
    uint8_t *pass = rmap_alloc(n_class, 1);
    uint16_t *of_class = rmap_alloc(n_class + 1, sizeof *of_class);
    for (uint32_t k = 0; k < n_class; k++)
        pass[k] = k % 3 == 1;
    for (uint32_t k = 0; k <= n_class; k++)
        of_class[k] = (uint16_t)(7 * k + 1);
    assert_int_equal(rmap_step_codes_open(&self->rows, self->n_code, &codes, NULL), RMAP_OK);
    assert_true(codes.n_code > 0 && codes.n == self->n);
    rmap_step_codes_mark(&codes, pass, n_class, bits);
    for (size_t i = 0; i < self->n; i++)
        assert_int_equal(bits[i / 64] >> i % 64 & 1, pass[self->class[i]]);
    rmap_step_codes_look_up(&codes, of_class, n_class, symbol);
    for (size_t i = 0; i < self->n; i++)
        assert_int_equal(symbol[i], of_class[self->class[i]]);
    rmap_step_codes_look_up(&codes, of_class, 2, symbol); /* the others stand for none */
    for (size_t i = 0; i < self->n; i++)
        assert_int_equal(symbol[i], of_class[self->class[i] < 2 ? self->class[i] : 2]);
    rmap_free(of_class);
    rmap_free(pass);
}

static void test_back(void **state)
{
    static const struct {
        size_t n;
        uint32_t n_class;
        bool coded;
    } list[] = {{0, 5, false},       {1, 1, false},         {2, 2, false},      {9, 2, true},
                {64, 3, true},       {1000, 255, true},     {5000, 256, true},  {5001, 700, true},
                {20000, 3000, true}, {20000, 65536, false}, {300, 70000, false}};
    (void)state;
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        struct coded *self = rmap_alloc(1, sizeof *self);
        struct rmap_step_codes codes;
        make(self, list[i].n, list[i].n_class);
        assert_int_equal(rmap_step_codes_open(&self->rows, self->n_code, &codes, NULL), RMAP_OK);
        if (list[i].n_class < 65536)
            assert_int_equal(codes.n_code > 0, list[i].coded);
        check_classes(self);
        if (codes.n_code > 0)
            check_marks(self, list[i].n_class);
        end(self);
    }
}

/* One word less or more, other counts, and codes that nothing stands for. */
static void test_damage(void **state)
{
    struct coded *self = rmap_alloc(1, sizeof *self);
    struct rmap_step_codes codes;
    struct rmap_rows rows;
    (void)state;
    make(self, 5001, 700);
    size_t *n_word = &self->rows.n_row[RMAP_COMPACT_OWN_SEGMENT];
    for (int by = -1; by <= 1; by += 2) {
        *n_word += (size_t)by;
        assert_int_equal(
            rmap_step_codes_unpack(&self->rows, self->n_code, &self->buffer, &rows, NULL),
            RMAP_FORMAT);
        *n_word -= (size_t)by;
    }
    self->count[0] = UINT32_MAX;
    assert_int_equal(rmap_step_codes_open(&self->rows, self->n_code, &codes, NULL), RMAP_FORMAT);
    self->count[0] = (uint32_t)(self->n / 3);
    check_classes(self);

    make(self, 64, 3);
    self->coder.word[3] = 0x80808080u;
    assert_int_equal(rmap_step_codes_unpack(&self->rows, self->n_code, &self->buffer, &rows, NULL),
                     RMAP_OK);
    assert_int_equal(self->buffer.class[0], UINT32_MAX);
    self->coder.word[3] = 0xffffffffu;
    assert_int_equal(rmap_step_codes_unpack(&self->rows, self->n_code, &self->buffer, &rows, NULL),
                     RMAP_FORMAT);
    end(self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_back), cmocka_unit_test(test_damage)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
