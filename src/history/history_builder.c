/* SPDX-License-Identifier: MIT
 *
 * Numbers what happens in the portions of a piece, and chooses for each the form that takes less.
 */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "history/history_builder.h"

/* Writes a portion in the form ROWS: a byte for the class of a segment, and one more for the few
 * that are too rare to have a code. */

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

static enum rmap_status history_shape_rows(struct rmap_history_builder *self,
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

static void write_segments(const struct rmap_history_builder *self,
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

/* The portion in hand in the form ROWS: its shape; then its bytes (zeroed, as many as it takes). */
static void history_write_rows(const struct rmap_history_builder *self,
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
    write_segments(self, shape, layout, bytes);
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
    write_counts(p->registration.segment, n_registration, bytes + at[RMAP_PART_SEGMENT],
                 (uint32_t *)(void *)(bytes + at[RMAP_PART_FAR]));
}

enum rmap_status rmap_history_builder_create(struct rmap_history_builder **builder_ret,
                                             struct rmap_error *err)
{
    *builder_ret = rmap_alloc(1, sizeof **builder_ret);
    return *builder_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for an index");
}

void rmap_history_builder_destroy(struct rmap_history_builder *self)
{
    if (!self)
        return;
    rmap_word_book_fini(&self->class_of);
    rmap_word_book_fini(&self->hit);
    rmap_word_book_fini(&self->path);
    rmap_word_book_fini(&self->distinct);
    rmap_word_book_fini(&self->kind);
    rmap_free(self->place);
    rmap_free(self->body);
    rmap_free(self->row_class);
    rmap_free(self->row_hit);
    rmap_free(self->ray_path);
    rmap_free(self->ray_kind);
    rmap_free(self->word);
    rmap_free(self->tally);
    rmap_free(self->local_of);
    rmap_free(self);
}

static enum rmap_status reserve_words(uint32_t **block, size_t *cap, size_t need,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(*block, *cap, need + 1, err);
    return st;
}

static enum rmap_status reserve_rows(struct rmap_history_builder *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t *n = self->portion->n_row;
    size_t n_segment = n[RMAP_TABLE_SEGMENT], n_registration = n[RMAP_TABLE_REGISTRATION];
    RMAP_TRY(reserve_words(&self->row_class, &self->cap_row_class, n_segment, err));
    RMAP_TRY(reserve_words(&self->row_hit, &self->cap_row_hit, n_registration, err));
    RMAP_TRY(reserve_words(&self->ray_path, &self->cap_ray_path, n[RMAP_TABLE_RAY], err));
    RMAP_TRY(reserve_words(&self->ray_kind, &self->cap_ray_kind, n[RMAP_TABLE_RAY], err));
    RMAP_TRY(reserve_words(&self->word, &self->cap_word,
                           RMAP_HISTORY_WORD_HEAD + n_segment + 2 * n_registration, err));
out:
    return st;
}

/* Few words, many times: cheaper than a hash of bytes. */
static uint64_t hash_of_three(uint32_t a, uint32_t b, uint32_t c)
{
    uint64_t x = (a + UINT64_C(1)) * UINT64_C(0x9e3779b97f4a7c15) ^
                 (b + UINT64_C(1)) * UINT64_C(0xc2b2ae3d27d4eb4f) ^
                 (c + UINT64_C(1)) * UINT64_C(0x165667b19e3779f9);
    return (x ^ x >> 29) * UINT64_C(0xbf58476d1ce4e5b9);
}

/* *number_ret: UINT32_MAX when there are too many to have another one. */
static enum rmap_status number_one(struct rmap_word_book *book, const uint32_t word[3],
                                   uint32_t *number_ret, struct rmap_error *err)
{
    uint64_t hash = hash_of_three(word[0], word[1], word[2]);
    *number_ret = rmap_word_book_find(book, hash, word, 3);
    if (*number_ret != UINT32_MAX || book->n >= RMAP_HISTORY_CLASS_MAX)
        return RMAP_OK;
    return rmap_word_book_enter(book, hash, word, 3, number_ret, err);
}

/* *fits_ret: whether every row and ray could be given a number. */
static enum rmap_status number_rows(struct rmap_history_builder *self, bool *fits_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *p = self->portion;
    bool fits = true;
    rmap_word_book_clear(&self->kind);
    for (size_t i = 0; fits && i < p->n_row[RMAP_TABLE_SEGMENT]; i++) {
        const uint32_t word[3] = {(uint32_t)p->segment.object[i], p->segment.event[i],
                                  (uint32_t)(int32_t)p->segment.medium[i]};
        RMAP_TRY(number_one(&self->class_of, word, &self->row_class[i], err));
        fits = self->row_class[i] != UINT32_MAX;
    }
    for (size_t i = 0; fits && i < p->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        const uint32_t word[3] = {(uint32_t)p->registration.detector[i],
                                  p->registration.registered[i], 0};
        RMAP_TRY(number_one(&self->hit, word, &self->row_hit[i], err));
        fits = self->row_hit[i] != UINT32_MAX;
    }
    for (size_t i = 0; fits && i < p->n_row[RMAP_TABLE_RAY]; i++) {
        const uint32_t word[3] = {(uint32_t)p->ray.source[i], p->ray.stop[i], 0};
        RMAP_TRY(number_one(&self->kind, word, &self->ray_kind[i], err));
        fits = self->ray_kind[i] != UINT32_MAX;
    }
    *fits_ret = fits;
out:
    return st;
}

/* Numbers the distinct histories of the portion's rays. */
static enum rmap_status find_distinct(struct rmap_history_builder *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *p = self->portion;
    size_t segment = 0, registration = 0;
    rmap_word_book_clear(&self->distinct);
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_RAY] && st == RMAP_OK; i++) {
        size_t n = p->ray.segment_count[i], m = p->ray.registration_count[i];
        uint32_t *word = self->word;
        word[RMAP_HISTORY_WORD_SOURCE] = (uint32_t)p->ray.source[i];
        word[RMAP_HISTORY_WORD_STOP] = p->ray.stop[i];
        word[RMAP_HISTORY_WORD_SEGMENTS] = (uint32_t)n;
        word[RMAP_HISTORY_WORD_REGISTRATIONS] = (uint32_t)m;
        word += RMAP_HISTORY_WORD_HEAD;
        for (size_t k = 0; k < n; k++)
            *word++ = self->row_class[segment + k];
        for (size_t k = 0; k < m; k++)
            *word++ = p->registration.segment[registration + k];
        for (size_t k = 0; k < m; k++)
            *word++ = self->row_hit[registration + k];
        size_t n_word = RMAP_HISTORY_WORD_HEAD + n + 2 * m;
        uint64_t hash = XXH3_64bits(self->word, n_word * sizeof *word);
        st = rmap_word_book_enter(&self->distinct, hash, self->word, n_word, &self->ray_path[i],
                                  err);
        segment += n;
        registration += m;
    }
    return st;
}

static const uint32_t *words_of(const struct rmap_word_book *book, size_t k)
{
    return book->word + book->entry[k].first;
}

/* Bytes that the paths of the portion add to the dictionary; UINT64_MAX: it has no room. */
static uint64_t dictionary_growth(const struct rmap_history_builder *self)
{
    uint64_t n = 0, n_segment = 0, n_registration = 0;
    for (size_t k = 0; k < self->distinct.n; k++) {
        const struct rmap_word_entry *entry = &self->distinct.entry[k];
        const uint32_t *word = words_of(&self->distinct, k);
        if (rmap_word_book_find(&self->path, entry->hash, word, entry->n) != UINT32_MAX)
            continue;
        n++;
        n_segment += word[RMAP_HISTORY_WORD_SEGMENTS];
        n_registration += word[RMAP_HISTORY_WORD_REGISTRATIONS];
    }
    if (self->path.n + n > RMAP_HISTORY_PATH_MAX ||
        self->n_path_segment + n_segment > RMAP_HISTORY_PATH_ROW_MAX ||
        self->n_path_registration + n_registration > RMAP_HISTORY_PATH_ROW_MAX)
        return UINT64_MAX;
    return 13 * n + 2 * n_segment + 6 * n_registration;
}

/* Room for the portion's bytes, zeroed, at the end of the body, with its shape. */
static enum rmap_status extend_body(struct rmap_history_builder *self,
                                    struct rmap_history_place *place,
                                    const struct rmap_history_shape *shape, uint64_t nbytes,
                                    struct rmap_error *err)
{
    if (nbytes > UINT32_MAX)
        return rmap_error_set(err, RMAP_INTERNAL, "a portion's index is too large");
    enum rmap_status st =
        RMAP_RESERVE(self->body, self->cap_body, self->body_nbytes + (size_t)nbytes, err);
    if (st != RMAP_OK)
        return st;
    place->offset = self->body_nbytes;
    place->nbytes = (uint32_t)nbytes;
    memset(self->body + place->offset, 0, (size_t)nbytes);
    memcpy(self->body + place->offset, shape, sizeof *shape);
    self->body_nbytes += (size_t)nbytes;
    return RMAP_OK;
}

/* Enters the portion's paths in the dictionary, and writes each ray's. */
static enum rmap_status write_paths(struct rmap_history_builder *self,
                                    const struct rmap_history_layout *layout, uint8_t *bytes,
                                    struct rmap_error *err)
{
    uint32_t *row = (uint32_t *)(void *)(bytes + layout->at[RMAP_PART_PATH_ROW]);
    uint16_t *rays = (uint16_t *)(void *)(bytes + layout->at[RMAP_PART_PATH_RAYS]);
    uint16_t *path = (uint16_t *)(void *)(bytes + layout->at[RMAP_PART_PATH]);
    for (size_t k = 0; k < self->distinct.n; k++) {
        const struct rmap_word_entry *entry = &self->distinct.entry[k];
        const uint32_t *word = words_of(&self->distinct, k);
        size_t before = self->path.n;
        enum rmap_status st =
            rmap_word_book_enter(&self->path, entry->hash, word, entry->n, &row[k], err);
        if (st != RMAP_OK)
            return st;
        if (self->path.n == before)
            continue;
        self->n_path_segment += word[RMAP_HISTORY_WORD_SEGMENTS];
        self->n_path_registration += word[RMAP_HISTORY_WORD_REGISTRATIONS];
    }
    for (size_t i = 0; i < self->portion->n_row[RMAP_TABLE_RAY]; i++) {
        path[i] = (uint16_t)self->ray_path[i];
        rays[path[i]]++;
    }
    return RMAP_OK;
}

/* Chooses the form and writes the portion in it. */
static enum rmap_status write_portion(struct rmap_history_builder *self,
                                      struct rmap_history_place *place, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n_segment = place->n_row[RMAP_TABLE_SEGMENT];
    uint64_t n_registration = place->n_row[RMAP_TABLE_REGISTRATION];
    struct rmap_history_shape shape = {.n_path = (uint32_t)self->distinct.n};
    struct rmap_history_layout paths, rows;
    /* Coordinates are noise: kept where they weigh little. */
    place->form = RMAP_HISTORY_PATHS;
    place->has_relative = n_registration > 0 && 4 * n_registration <= n_segment;
    rmap_history_arrange(place, &shape, &paths);
    uint64_t growth = dictionary_growth(self), end = paths.at[RMAP_PART_COUNT_OF];
    bool repeats = 2 * self->distinct.n <= place->n_row[RMAP_TABLE_RAY];
    uint64_t as_rows = n_segment + 2 * (uint64_t)place->n_row[RMAP_TABLE_RAY]; /* about */
    if (repeats && growth != UINT64_MAX && growth + end <= as_rows) {
        RMAP_TRY(extend_body(self, place, &shape, end, err));
        RMAP_TRY(write_paths(self, &paths, self->body + place->offset, err));
        rows = paths;
    } else {
        shape = (struct rmap_history_shape){0};
        place->form = RMAP_HISTORY_ROWS;
        place->has_relative = n_registration > 0 && 7 * n_registration <= n_segment;
        RMAP_TRY(history_shape_rows(self, &shape, err));
        rmap_history_arrange(place, &shape, &rows);
        RMAP_TRY(extend_body(self, place, &shape, rows.at[RMAP_PART_COUNT_OF], err));
        history_write_rows(self, &shape, &rows, self->body + place->offset);
    }
    if (place->has_relative)
        memcpy(self->body + place->offset + rows.at[RMAP_PART_RELATIVE],
               self->portion->registration.relative, (size_t)n_registration * 4);
    place->checksum = XXH3_64bits(self->body + place->offset, place->nbytes);
out:
    return st;
}

static bool all_one(const double *weight, size_t n)
{
    size_t others = 0;
    for (size_t i = 0; i < n; i++)
        others += weight[i] != 1.0;
    return others == 0;
}

static bool counts_hold(const struct rmap_portion *portion)
{
    uint64_t n_segment = 0, n_registration = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        n_segment += portion->ray.segment_count[i];
        n_registration += portion->ray.registration_count[i];
    }
    return n_segment == portion->n_row[RMAP_TABLE_SEGMENT] &&
           n_registration == portion->n_row[RMAP_TABLE_REGISTRATION];
}

enum rmap_status rmap_history_builder_add(struct rmap_history_builder *self,
                                          const struct rmap_portion *portion,
                                          struct rmap_digest digest, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t *n = portion->n_row;
    bool fits = true;
    struct rmap_history_place place = {.first_ray = portion->first_ray,
                                       .digest_low = digest.low,
                                       .digest_high = digest.high,
                                       .n_row = {(uint32_t)n[0], (uint32_t)n[1], (uint32_t)n[2]}};
    if (!counts_hold(portion))
        return rmap_error_set(err, RMAP_INTERNAL, "a portion's counts do not sum up to its rows");
    if (n[RMAP_TABLE_RAY] == 0 || n[RMAP_TABLE_RAY] > RMAP_HISTORY_RAY_MAX ||
        n[RMAP_TABLE_SEGMENT] > INT32_MAX / 16 || n[RMAP_TABLE_REGISTRATION] > INT32_MAX / 16)
        return RMAP_OK;
    self->portion = portion;
    RMAP_TRY(RMAP_RESERVE(self->place, self->cap_place, self->n_place + 1, err));
    RMAP_TRY(reserve_rows(self, err));
    RMAP_TRY(number_rows(self, &fits, err));
    if (!fits)
        return RMAP_OK;
    RMAP_TRY(find_distinct(self, err));
    place.unit_weight = all_one(portion->ray.weight, n[RMAP_TABLE_RAY]);
    RMAP_TRY(write_portion(self, &place, err));
    self->place[self->n_place++] = place;
out:
    return st;
}
