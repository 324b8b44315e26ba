/* SPDX-License-Identifier: MIT
 *
 * Writes a portion in the form ROWS: a byte for the class of a leg, and the few that are too rare
 * for one of 255 codes in a list.
 */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "history/history_builder.h"

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
    void *local_of = self->local_of, *tally = self->tally;
    RMAP_TRY(rmap_reserve(&local_of, &self->cap_local_of, self->class_of.n + 1,
                          sizeof *self->local_of, err));
    self->local_of = local_of;
    RMAP_TRY(
        rmap_reserve(&tally, &self->cap_tally, self->class_of.n + 1, sizeof *self->tally, err));
    self->tally = tally;
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

static uint32_t count_long(const uint32_t *count, size_t n)
{
    uint32_t n_long = 0;
    for (size_t i = 0; i < n; i++)
        n_long += count[i] >= UINT8_MAX;
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
    if (number <= UINT8_MAX)
        return 1;
    return number <= UINT16_MAX ? 2 : 4;
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
    *shape = (struct rmap_history_shape){
        .n_kind = (uint32_t)self->kind.n,
        .n_local = (uint32_t)self->n_tally,
        .n_common =
            (uint32_t)(self->n_tally < RMAP_HISTORY_RARE ? self->n_tally : RMAP_HISTORY_RARE),
        .n_long = count_long(p->ray.segment_count, n_ray),
        .n_many = count_long(p->ray.registration_count, n_ray),
        .kind_nbytes = self->kind.n > 1 ? bytes_for((uint32_t)self->kind.n - 1) : 0,
        .leg_nbytes = bytes_for(largest(p->registration.segment, n_registration)),
        .hit_nbytes = all_alike(self->row_hit, n_registration)
                          ? 0
                          : bytes_for(largest(self->row_hit, n_registration)),
    };
    for (size_t k = shape->n_common; k < self->n_tally; k++)
        shape->n_rare += self->tally[k].rows;
    return RMAP_OK;
}

/* n numbers of nbytes bytes each; 0: the first of them, in two. */
static void write_numbers(const uint32_t *number, size_t n, unsigned nbytes, uint8_t *to)
{
    uint16_t *two = (uint16_t *)(void *)to;
    uint32_t *four = (uint32_t *)(void *)to;
    if (nbytes == 0 && n > 0)
        two[0] = (uint16_t)number[0];
    for (size_t i = 0; nbytes == 1 && i < n; i++)
        to[i] = (uint8_t)number[i];
    for (size_t i = 0; nbytes == 2 && i < n; i++)
        two[i] = (uint16_t)number[i];
    for (size_t i = 0; nbytes == 4 && i < n; i++)
        four[i] = number[i];
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
    uint32_t *rows = (uint32_t *)(void *)(bytes + layout->at[RMAP_PART_LOCAL_ROWS]);
    uint8_t *code = bytes + layout->at[RMAP_PART_CODE];
    uint16_t *rare = (uint16_t *)(void *)(bytes + layout->at[RMAP_PART_RARE]);
    uint64_t *end = (uint64_t *)(void *)(bytes + layout->at[RMAP_PART_END]);
    const struct rmap_portion *p = self->portion;
    size_t row = 0;
    for (size_t k = 0; k < self->n_tally; k++) {
        local[k] = (uint16_t)self->tally[k].class_number;
        rows[k] = self->tally[k].rows;
    }
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t k = self->local_of[self->row_class[i]];
        code[i] = k < shape->n_common ? (uint8_t)k : RMAP_HISTORY_RARE;
        if (code[i] == RMAP_HISTORY_RARE)
            *rare++ = (uint16_t)k;
    }
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_RAY]; i++) {
        row += p->ray.segment_count[i];
        if (p->ray.segment_count[i] > 0)
            end[(row - 1) / 64] |= UINT64_C(1) << (row - 1) % 64;
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
    if (n_registration > 0)
        write_counts(p->ray.registration_count, n_ray, bytes + at[RMAP_PART_HITS],
                     (uint32_t *)(void *)(bytes + at[RMAP_PART_MANY]));
    write_numbers(self->row_hit, n_registration, shape->hit_nbytes, bytes + at[RMAP_PART_HIT]);
    write_numbers(p->registration.segment, n_registration, shape->leg_nbytes,
                  bytes + at[RMAP_PART_LEG]);
}
