/* SPDX-License-Identifier: MIT
 *
 * A foreign history index: opening it and its portions ends in what they hold or in RMAP_FORMAT,
 * and what is held can be counted and unfolded. The input is {u8 flags; u32 bytes of the head; the
 * head; the body}. Flag 1 makes the checksums right, so that what they vouch for is looked at.
 */
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "history/history_builder.h"
#include "history/history_gather.h"
#include "history/history_parts.h"
#include "history/history_view.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 6000;

enum { MEND = 1, N_RAY = 90, N_OBJECT = 300 };
static const struct rmap_history_limits limits = {2, N_OBJECT, 2, 3};

static void mend(uint8_t *head, size_t head_nbytes, const uint8_t *body, size_t body_nbytes)
{
    struct rmap_history_head rows;
    struct rmap_history_layout layout;
    if (head_nbytes < sizeof rows + sizeof(uint64_t))
        return;
    memcpy(&rows, head, sizeof rows);
    size_t end = head_nbytes - sizeof(uint64_t);
    if ((rows.n_class | rows.n_hit | rows.n_path | rows.n_path_segment | rows.n_path_registration |
         rows.n_portion) >>
            24 ==
        0) {
        rmap_history_arrange_head(&rows, &layout);
        uint64_t at = layout.at[RMAP_HEAD_PORTION];
        for (uint64_t i = 0; i < rows.n_portion && at + sizeof(struct rmap_history_place) <= end;
             i++, at += sizeof(struct rmap_history_place)) {
            struct rmap_history_place place;
            memcpy(&place, head + at, sizeof place);
            if (place.nbytes <= body_nbytes && place.offset <= body_nbytes - place.nbytes)
                place.checksum = XXH3_64bits(body + place.offset, place.nbytes);
            memcpy(head + at, &place, sizeof place);
        }
    }
    uint64_t checksum = XXH3_64bits(head, end);
    memcpy(head + end, &checksum, sizeof checksum);
}

/* What is marked, ray by ray. */
static void count_marks(const struct rmap_history_view *view, const uint64_t *bits,
                        const uint32_t *n_rows, uint64_t *any)
{
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint32_t *count = rmap_alloc(n_ray, sizeof *count);
    rmap_fuzz_demand(count != NULL, "memory");
    rmap_bits_count_groups(bits, n_rows, n_ray, count);
    rmap_bits_any_groups(bits, n_rows, n_ray, any);
    for (size_t i = 0; i < n_ray; i++)
        rmap_fuzz_demand((any[i / 64] >> i % 64 & 1) == (count[i] > 0), "bits");
    rmap_free(count);
}

static void use_rows(const struct rmap_history_view *view)
{
    const struct rmap_history_index *index = view->index;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY], n_segment = view->n_row[RMAP_TABLE_SEGMENT];
    uint8_t *wanted = rmap_alloc(RMAP_HISTORY_CLASS_MAX + 1, 1);
    uint64_t *any = rmap_alloc(rmap_bit_words(n_ray), sizeof *any);
    uint16_t *row_class = rmap_alloc(n_segment, sizeof *row_class);
    rmap_fuzz_demand(wanted && any && row_class, "memory");
    for (size_t step = 1; step < 6; step++) {
        for (size_t k = 0; k <= RMAP_HISTORY_CLASS_MAX; k++)
            wanted[k] = k % step == 0;
        const uint64_t *segments = rmap_history_mark(view, wanted);
        if (segments)
            count_marks(view, segments, view->segment_count, any);
        const uint64_t *hits = rmap_history_mark_hits(view, wanted);
        if (hits)
            count_marks(view, hits, view->registration_count, any);
    }
    rmap_history_row_classes(view, row_class);
    for (size_t i = 0; i < n_segment; i++)
        rmap_fuzz_demand(row_class[i] < rmap_history_n_class(index), "a class of the index");
    rmap_free(wanted);
    rmap_free(any);
    rmap_free(row_class);
}

static void use(const struct rmap_history_index *index)
{
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    struct rmap_portion *out = rmap_alloc(1, sizeof *out);
    rmap_fuzz_demand(out != NULL, "memory");
    for (size_t i = 0; i < rmap_history_n_portion(index) && i < 50; i++) {
        enum rmap_status st = rmap_history_view_open(index, i, &view, &err);
        rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign portion");
        if (st != RMAP_OK)
            continue;
        if (view.form == RMAP_HISTORY_ROWS)
            use_rows(&view);
        st = rmap_history_unfold(&view, RMAP_COLUMNS_DISCRETE, out, &err);
        rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of its columns");
    }
    rmap_portion_destroy(out);
    rmap_history_view_fini(&view);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    int64_t live = rmap_alloc_live();
    uint8_t flags = 0;
    uint32_t head_nbytes = 0;
    rmap_fuzz_take(&data, &nbytes, &flags, 1);
    rmap_fuzz_take(&data, &nbytes, &head_nbytes, 4);
    head_nbytes = head_nbytes < nbytes ? head_nbytes : (uint32_t)nbytes;
    size_t body_nbytes = nbytes - head_nbytes;
    uint8_t *head = rmap_alloc(head_nbytes, 1), *body = rmap_alloc(body_nbytes, 1);
    struct rmap_history_index *index = NULL;
    struct rmap_error err = {0};
    rmap_fuzz_demand(head && body, "memory");
    if (head_nbytes > 0)
        memcpy(head, data, head_nbytes);
    if (body_nbytes > 0)
        memcpy(body, data + head_nbytes, body_nbytes);
    if (flags & MEND)
        mend(head, head_nbytes, body, body_nbytes);
    const struct rmap_history_body where = {.bytes = body, .nbytes = body_nbytes};
    enum rmap_status st = rmap_history_open(head, head_nbytes, &where, &limits, &index, &err);
    rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign index");
    if (st == RMAP_OK)
        use(index);
    rmap_history_destroy(index);
    rmap_free(head);
    rmap_free(body);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* Rays that repeat 5 histories, or that have each its own. */
static struct rmap_portion *make_portion(unsigned k)
{
    struct rmap_portion *p = NULL;
    struct rmap_error err = {0};
    size_t row = 0;
    rmap_fuzz_demand(rmap_portion_create(N_RAY, 1, &p, &err) == RMAP_OK &&
                         rmap_portion_reserve(p, RMAP_TABLE_SEGMENT, (size_t)N_RAY * 300,
                                              RMAP_COLUMNS_ALL, &err) == RMAP_OK,
                     "a portion");
    p->first_ray = 100 * k;
    p->n_row[RMAP_TABLE_RAY] = N_RAY;
    for (unsigned i = 0; i < N_RAY; i++) {
        unsigned what = k == 0 ? i % 5 : i, n = k == 2 && i == 7 ? 290 : 1 + what % 9;
        p->ray.source[i] = (int32_t)(what % 2);
        p->ray.stop[i] = (uint8_t)(what % 3);
        p->ray.weight[i] = 1.0;
        p->ray.segment_count[i] = n;
        p->ray.registration_count[i] = i % 11 == 0;
        for (unsigned s = 0; s < n; s++, row++) {
            p->segment.object[row] = (int32_t)((what * 7 + s * 13) % (N_OBJECT + 1)) - 1;
            p->segment.event[row] = UINT32_C(1) << (s % 3);
            p->segment.medium[row] = (int16_t)(s % 2);
        }
    }
    p->n_row[RMAP_TABLE_SEGMENT] = row;
    for (size_t i = 0; i < N_RAY; i += 11) {
        size_t at = p->n_row[RMAP_TABLE_REGISTRATION]++;
        p->registration.detector[at] = (int32_t)(k == 0 ? i % 5 % 3 : i % 3);
        p->registration.registered[at] = (uint8_t)(i % 2);
    }
    return p;
}

/* An index of three portions in both forms, as it is and with its checksums mended. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    struct rmap_history_builder *builder = NULL;
    struct rmap_history_bytes bytes;
    struct rmap_error err = {0};
    if (k > 1)
        return 0;
    rmap_fuzz_demand(rmap_history_builder_create(&builder, &err) == RMAP_OK, "a builder");
    for (unsigned i = 0; i < 3; i++) {
        struct rmap_portion *p = make_portion(i);
        rmap_fuzz_demand(rmap_history_builder_add(builder, p, (struct rmap_digest){i, i}, &err) ==
                             RMAP_OK,
                         "a portion is added");
        rmap_portion_destroy(p);
    }
    rmap_fuzz_demand(rmap_history_builder_finish(builder, &bytes, &err) == RMAP_OK, "an index");
    rmap_history_builder_destroy(builder);
    uint32_t head_nbytes = (uint32_t)bytes.head_nbytes;
    size_t n = 5 + bytes.head_nbytes + bytes.body_nbytes;
    rmap_fuzz_demand(n <= cap, "room for a seed");
    to[0] = (uint8_t)k;
    memcpy(to + 1, &head_nbytes, sizeof head_nbytes);
    memcpy(to + 5, bytes.head, bytes.head_nbytes);
    memcpy(to + 5 + bytes.head_nbytes, bytes.body, bytes.body_nbytes);
    rmap_free(bytes.head);
    rmap_free(bytes.body);
    return n;
}
