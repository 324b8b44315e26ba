/* SPDX-License-Identifier: MIT
 *
 * Writes a portion in the form ROWS: a byte for the class of a leg, and one more for the few that
 * are too rare to have a code.
 */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "history/history_builder.h"

enum { MANY = 15 }; /* registrations that four bits do not hold */

static int by_rows(const void *a, const void *b)
{
    const struct rmap_history_tally *x = a, *y = b;
    if (x->rows != y->rows)
        return x->rows < y->rows ? 1 : -1;
    return (x->class_number > y->class_number) - (x->class_number < y->class_number);
}

/* Lists the portion's classes, the most frequent first, and gives them local numbers. */
static enum rmap_status tally_classes(struct rmap_history_builder *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->local_of, self->cap_local_of, self->class_of.n + 1, err));
    RMAP_TRY(RMAP_RESERVE(self->tally, self->cap_tally, self->class_of.n + 1, err));
    memset(self->local_of, 0, self->class_of.n * sizeof *self->local_of);
    for (size_t i = 0; i < self->portion->n_row[RMAP_TABLE_SEGMENT]; i++)
        self->local_of[self->row_class[i]]++;
    self->n_tally = 0;
    for (size_t c = 0; c < self->class_of.n; c++)
        if (self->local_of[c] > 0)
            self->tally[self->n_tally++] =
                (struct rmap_history_tally){(uint32_t)c, self->local_of[c]};
    if (self->n_tally > 0)
        qsort(self->tally, self->n_tally, sizeof *self->tally, by_rows);
    for (size_t k = 0; k < self->n_tally; k++)
        self->local_of[self->tally[k].class_number] = (uint32_t)k;
out:
    return st;
}

static uint32_t count_from(uint32_t limit, const uint32_t *count, size_t n)
{
    uint32_t n_long = 0;
    for (size_t i = 0; i < n; i++)
        n_long += count[i] >= limit;
    return n_long;
}

static uint32_t largest(const uint32_t *number, size_t n)
{
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = number[i] > most ? number[i] : most;
    return most;
}

static uint8_t bytes_for(uint32_t number)
{
    return number <= UINT8_MAX ? 1 : 2;
}

static bool all_alike(const uint32_t *number, size_t n)
{
    size_t others = 0;
    for (size_t i = 1; i < n; i++)
        others += number[i] != number[0];
    return others == 0;
}

enum rmap_status rmap_history_shape_rows(struct rmap_history_builder *self,
                                         struct rmap_history_shape *shape, struct rmap_error *err)
{
    const struct rmap_portion *p = self->portion;
    size_t n_ray = p->n_row[RMAP_TABLE_RAY], n_registration = p->n_row[RMAP_TABLE_REGISTRATION];
    enum rmap_status st = tally_classes(self, err);
    if (st != RMAP_OK)
        return st;
    uint32_t n_local = (uint32_t)self->n_tally, n_coded = 256 - rmap_history_n_page(n_local);
    *shape = (struct rmap_history_shape){
        .n_kind = (uint32_t)self->kind.n,
        .n_local = n_local,
        .n_common = n_local < n_coded ? n_local : n_coded,
        .n_long = count_from(UINT8_MAX, p->ray.segment_count, n_ray),
        .n_many = count_from(MANY, p->ray.registration_count, n_ray),
        .n_far = count_from(UINT8_MAX, p->registration.segment, n_registration),
        .kind_nbytes = self->kind.n > 1 ? bytes_for((uint32_t)self->kind.n - 1) : 0,
        .hit_nbytes = all_alike(self->row_hit, n_registration)
                          ? 0
                          : bytes_for(largest(self->row_hit, n_registration)),
    };
    for (size_t k = 0; k < self->n_tally; k++)
        shape->n_frequent += self->tally[k].rows >= UINT8_MAX;
    for (size_t k = shape->n_common; k < self->n_tally; k++)
        shape->n_rare += self->tally[k].rows;
    return RMAP_OK;
}

/* n numbers of nbytes bytes each; 0: the first of them, in two. */
static void write_numbers(const uint32_t *number, size_t n, unsigned nbytes, uint8_t *to)
{
    uint16_t *two = (uint16_t *)(void *)to;
    if (nbytes == 0 && n > 0)
        two[0] = (uint16_t)number[0];
    for (size_t i = 0; nbytes == 1 && i < n; i++)
        to[i] = (uint8_t)number[i];
    for (size_t i = 0; nbytes == 2 && i < n; i++)
        two[i] = (uint16_t)number[i];
}

/* In a byte where it is below 255, else in the list of long ones. */
static void write_counts(const uint32_t *count, size_t n, uint8_t *to, uint32_t *longer)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = count[i] < UINT8_MAX ? (uint8_t)count[i] : UINT8_MAX;
        if (to[i] == UINT8_MAX)
            *longer++ = count[i];
    }
}

static void write_legs(const struct rmap_history_builder *self,
                       const struct rmap_history_shape *shape,
                       const struct rmap_history_layout *layout, uint8_t *bytes)
{
    uint16_t *local = (uint16_t *)(void *)(bytes + layout->at[RMAP_PART_LOCAL_CLASS]);
    uint8_t *rows = bytes + layout->at[RMAP_PART_LOCAL_ROWS];
    uint32_t *frequent = (uint32_t *)(void *)(bytes + layout->at[RMAP_PART_FREQUENT]);
    uint8_t *code = bytes + layout->at[RMAP_PART_CODE];
    uint8_t *rare = bytes + layout->at[RMAP_PART_RARE];
    const struct rmap_portion *p = self->portion;
    for (size_t k = 0; k < self->n_tally; k++) {
        local[k] = (uint16_t)self->tally[k].class_number;
        rows[k] = (uint8_t)(self->tally[k].rows < UINT8_MAX ? self->tally[k].rows : UINT8_MAX);
        if (rows[k] == UINT8_MAX)
            *frequent++ = self->tally[k].rows;
    }
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t k = self->local_of[self->row_class[i]];
        uint32_t behind = k < shape->n_common ? 0 : k - shape->n_common;
        code[i] = (uint8_t)(k < shape->n_common ? k : 255 - behind / 256);
        if (k >= shape->n_common)
            *rare++ = (uint8_t)(behind % 256);
    }
}

void rmap_history_write_rows(const struct rmap_history_builder *self,
                             const struct rmap_history_shape *shape,
                             const struct rmap_history_layout *layout, uint8_t *bytes)
{
    const struct rmap_portion *p = self->portion;
    const uint64_t *at = layout->at;
    size_t n_ray = p->n_row[RMAP_TABLE_RAY], n_registration = p->n_row[RMAP_TABLE_REGISTRATION];
    int32_t *source = (int32_t *)(void *)(bytes + at[RMAP_PART_KIND_SOURCE]);
    for (size_t k = 0; k < self->kind.n; k++) {
        const uint32_t *word = self->kind.word + self->kind.entry[k].first;
        source[k] = (int32_t)word[0];
        bytes[at[RMAP_PART_KIND_STOP] + k] = (uint8_t)word[1];
    }
    if (shape->kind_nbytes > 0)
        write_numbers(self->ray_kind, n_ray, shape->kind_nbytes, bytes + at[RMAP_PART_KIND]);
    write_legs(self, shape, layout, bytes);
    write_counts(p->ray.segment_count, n_ray, bytes + at[RMAP_PART_COUNT],
                 (uint32_t *)(void *)(bytes + at[RMAP_PART_LONG]));
    uint32_t *many = (uint32_t *)(void *)(bytes + at[RMAP_PART_MANY]);
    for (size_t i = 0; n_registration > 0 && i < n_ray; i++) {
        uint32_t n = p->ray.registration_count[i] < MANY ? p->ray.registration_count[i] : MANY;
        bytes[at[RMAP_PART_HITS] + i / 2] |= (uint8_t)(n << i % 2 * 4);
        if (n == MANY)
            *many++ = p->ray.registration_count[i];
    }
    write_numbers(self->row_hit, n_registration, shape->hit_nbytes, bytes + at[RMAP_PART_HIT]);
    write_counts(p->registration.segment, n_registration, bytes + at[RMAP_PART_LEG],
                 (uint32_t *)(void *)(bytes + at[RMAP_PART_FAR]));
}
