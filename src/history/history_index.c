/* SPDX-License-Identifier: MIT
 *
 * The history index of a piece: everything of its rays that is no floating number (source, stop,
 * object, event and medium of each segment, detector of each registration), in a form that a
 * question is answered from without a column being inflated.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "history/history_builder.h"
#include "history/history_parts.h"
#include "portion/event.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "an index is little-endian in memory");
_Static_assert(sizeof(struct rmap_history_head) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_place) == 64, "no padding");
_Static_assert(sizeof(struct rmap_history_shape) == 40, "no padding");
_Static_assert(sizeof(struct rmap_step_class) == 12, "no padding");
_Static_assert(sizeof(struct rmap_history_hit) == 8, "no padding");
_Static_assert(sizeof(struct rmap_history_made) == 16, "no padding");
_Static_assert((int)RMAP_HEAD_PARTS <= (int)RMAP_PART_COUNT_OF, "one layout serves both");
_Static_assert((int)RMAP_MADE_PARTS <= (int)RMAP_PART_COUNT_OF, "and a third");

/* Numbers are below 2^32 and sizes below 64: sums stay below 2^64. */
static void stack(uint64_t start, const uint64_t (*array)[2], size_t n,
                  struct rmap_history_layout *layout)
{
    layout->at[0] = start;
    for (size_t i = 0; i < n; i++)
        layout->at[i + 1] = layout->at[i] + (array[i][0] * array[i][1] + 7) / 8 * 8;
}

void rmap_history_arrange(const struct rmap_history_place *place,
                          const struct rmap_history_shape *shape,
                          struct rmap_history_layout *layout)
{
    bool rows = place->form == RMAP_HISTORY_ROWS;
    uint64_t n_ray = place->n_row[RMAP_TABLE_RAY];
    uint64_t n_segment = rows ? place->n_row[RMAP_TABLE_SEGMENT] : 0;
    uint64_t n_registration = place->n_row[RMAP_TABLE_REGISTRATION];
    uint64_t n_hit = rows ? n_registration : 0;
    const uint64_t array[RMAP_PART_COUNT_OF][2] = {
        [RMAP_PART_PATH_ROW] = {shape->n_path, 4},
        [RMAP_PART_PATH_RAYS] = {shape->n_path, 2},
        [RMAP_PART_PATH] = {rows ? 0 : n_ray, 2},
        [RMAP_PART_KIND_SOURCE] = {shape->n_kind, 4},
        [RMAP_PART_KIND_STOP] = {shape->n_kind, 1},
        [RMAP_PART_KIND] = {rows ? n_ray : 0, shape->kind_nbytes},
        [RMAP_PART_LOCAL_CLASS] = {shape->n_local, 2},
        [RMAP_PART_LOCAL_ROWS] = {shape->n_local, 1},
        [RMAP_PART_FREQUENT] = {shape->n_frequent, 4},
        [RMAP_PART_CODE] = {n_segment, 1},
        [RMAP_PART_RARE] = {shape->n_rare, 1},
        [RMAP_PART_COUNT] = {rows ? n_ray : 0, 1},
        [RMAP_PART_LONG] = {shape->n_long, 4},
        [RMAP_PART_HITS] = {n_hit > 0 ? (n_ray + 1) / 2 : 0, 1},
        [RMAP_PART_MANY] = {shape->n_many, 4},
        [RMAP_PART_HIT] = {shape->hit_nbytes ? n_hit : 1,
                           shape->hit_nbytes ? shape->hit_nbytes : 2},
        [RMAP_PART_SEGMENT] = {n_hit, 1},
        [RMAP_PART_FAR] = {shape->n_far, 4},
        [RMAP_PART_RELATIVE] = {place->has_relative ? n_registration : 0, 4},
    };
    stack(sizeof *shape, array, RMAP_PART_COUNT_OF, layout);
}

void rmap_history_arrange_made(const struct rmap_history_place *place,
                               const struct rmap_history_shape *shape, uint64_t nbytes_read,
                               struct rmap_history_layout *layout)
{
    const bool rows = place->form == RMAP_HISTORY_ROWS;
    const uint64_t n_ray = rows ? place->n_row[RMAP_TABLE_RAY] : 0;
    const uint64_t n_segment = place->n_row[RMAP_TABLE_SEGMENT];
    const uint64_t n_hit = place->n_row[RMAP_TABLE_REGISTRATION];
    const uint64_t n_local = rows ? shape->n_local : 0;
    const bool has_rare = shape->n_rare > 0 || shape->n_local > shape->n_common;
    const uint64_t n_word = rows && has_rare ? n_segment / 64 + 2 : 0;
    const uint64_t array[RMAP_MADE_PARTS][2] = {
        [RMAP_MADE_BYTES] = {nbytes_read, 1},
        [RMAP_MADE_SEGMENT_COUNT] = {n_ray, 4},
        [RMAP_MADE_REGISTRATION_COUNT] = {n_hit > 0 ? n_ray : 0, 4},
        [RMAP_MADE_KIND] = {shape->kind_nbytes > 0 ? n_ray : 0, 2},
        [RMAP_MADE_LOCAL_ROWS] = {n_local, 4},
        [RMAP_MADE_RARE_MARK] = {n_word, 8},
        [RMAP_MADE_RANK] = {n_word, 4},
    };
    stack(sizeof(struct rmap_history_made), array, RMAP_MADE_PARTS, layout);
}

void rmap_history_arrange_head(const struct rmap_history_head *head,
                               struct rmap_history_layout *layout)
{
    const uint64_t array[RMAP_HEAD_PARTS][2] = {
        [RMAP_HEAD_CLASS] = {head->n_class, sizeof(struct rmap_step_class)},
        [RMAP_HEAD_HIT] = {head->n_hit, sizeof(struct rmap_history_hit)},
        [RMAP_HEAD_SOURCE] = {head->n_path, 4},
        [RMAP_HEAD_STOP] = {head->n_path, 1},
        [RMAP_HEAD_SEGMENT_COUNT] = {head->n_path, 4},
        [RMAP_HEAD_REGISTRATION_COUNT] = {head->n_path, 4},
        [RMAP_HEAD_PATH_CLASS] = {head->n_path_segment, 2},
        [RMAP_HEAD_PATH_SEGMENT] = {head->n_path_registration, 4},
        [RMAP_HEAD_PATH_HIT] = {head->n_path_registration, 2},
        [RMAP_HEAD_PORTION] = {head->n_portion, sizeof(struct rmap_history_place)},
    };
    stack(sizeof *head, array, RMAP_HEAD_PARTS, layout);
}

/* An index from bytes that may say anything. */

static enum rmap_status bad(struct rmap_error *err, const char *what)
{
    return rmap_error_set(err, RMAP_FORMAT, "the history index is damaged: %s", what);
}

static enum rmap_status check_size(const uint8_t *bytes, size_t nbytes,
                                   const struct rmap_history_body *body,
                                   struct rmap_history_head *head,
                                   struct rmap_history_layout *layout, struct rmap_error *err)
{
    uint64_t checksum;
    if (nbytes < sizeof *head + sizeof checksum)
        return bad(err, "its head is cut off");
    memcpy(head, bytes, sizeof *head);
    if (head->magic != RMAP_HISTORY_MAGIC && head->magic << 8 == RMAP_HISTORY_MAGIC << 8)
        return rmap_error_set(
            err, RMAP_FORMAT,
            "the history index is of another format: raymap index makes it again");
    if (head->magic != RMAP_HISTORY_MAGIC)
        return bad(err, "it does not begin like one");
    if (head->n_class > RMAP_HISTORY_CLASS_MAX || head->n_hit > RMAP_HISTORY_CLASS_MAX ||
        head->n_path > RMAP_HISTORY_PATH_MAX || head->n_path_segment > RMAP_HISTORY_PATH_ROW_MAX ||
        head->n_path_registration > RMAP_HISTORY_PATH_ROW_MAX || head->n_portion > UINT32_MAX)
        return bad(err, "its head has too many rows");
    rmap_history_arrange_head(head, layout);
    if (layout->at[RMAP_HEAD_PARTS] != nbytes - sizeof checksum)
        return bad(err, "its head is not as long as its rows");
    memcpy(&checksum, bytes + nbytes - sizeof checksum, sizeof checksum);
    if (checksum != XXH3_64bits(bytes, nbytes - sizeof checksum))
        return bad(err, "the checksum of its head");
    if (head->body_nbytes != body->nbytes)
        return bad(err, "its portions are cut off");
    return RMAP_OK;
}

static bool holds(int64_t value, int64_t low, size_t n)
{
    return value >= low && value < (int64_t)n;
}

static enum rmap_status read_classes(struct rmap_history_index *self,
                                     const struct rmap_history_limits *limits,
                                     const struct rmap_history_layout *layout, const uint8_t *bytes,
                                     struct rmap_error *err)
{
    bool good = true;
    self->class_of = rmap_alloc(self->n_class, sizeof *self->class_of);
    self->hit = rmap_alloc(self->n_hit, sizeof *self->hit);
    if (!self->class_of || !self->hit)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    memcpy(self->class_of, bytes + layout->at[RMAP_HEAD_CLASS],
           self->n_class * sizeof *self->class_of);
    memcpy(self->hit, bytes + layout->at[RMAP_HEAD_HIT], self->n_hit * sizeof *self->hit);
    for (size_t k = 0; k < self->n_class; k++)
        good &= holds(self->class_of[k].object, -1, limits->n_object) &&
                holds(self->class_of[k].medium, -1, limits->n_medium);
    for (size_t k = 0; k < self->n_hit; k++)
        good &= holds(self->hit[k].detector, 0, limits->n_detector) &&
                holds(self->hit[k].registered, 0, 2);
    return good ? RMAP_OK : bad(err, "a class of it names nothing in the scene");
}

static enum rmap_status reserve_paths(struct rmap_history_index *self,
                                      const struct rmap_history_head *head, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t n[RMAP_TABLE_HISTORY_COUNT] = {head->n_path, head->n_path_segment,
                                                  head->n_path_registration};
    self->paths = rmap_alloc(1, sizeof *self->paths);
    self->path_segment = rmap_alloc((size_t)head->n_path, sizeof *self->path_segment);
    self->path_registration = rmap_alloc((size_t)head->n_path, sizeof *self->path_registration);
    if (!self->paths || !self->path_segment || !self->path_registration)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(self->paths, (enum rmap_table)t, (size_t)n[t],
                                      RMAP_COLUMNS_DISCRETE, err));
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        self->paths->n_row[t] = (size_t)n[t];
out:
    return st;
}

static enum rmap_status read_path_rays(struct rmap_history_index *self,
                                       const struct rmap_history_limits *limits,
                                       const struct rmap_history_layout *layout,
                                       const uint8_t *bytes, struct rmap_error *err)
{
    struct rmap_portion *paths = self->paths;
    size_t n = paths->n_row[RMAP_TABLE_RAY];
    uint64_t n_segment = 0, n_registration = 0;
    bool good = true;
    memcpy(paths->ray.source, bytes + layout->at[RMAP_HEAD_SOURCE], n * sizeof(int32_t));
    memcpy(paths->ray.stop, bytes + layout->at[RMAP_HEAD_STOP], n);
    memcpy(paths->ray.segment_count, bytes + layout->at[RMAP_HEAD_SEGMENT_COUNT],
           n * sizeof(uint32_t));
    memcpy(paths->ray.registration_count, bytes + layout->at[RMAP_HEAD_REGISTRATION_COUNT],
           n * sizeof(uint32_t));
    for (size_t i = 0; i < n; i++) {
        good &= holds(paths->ray.source[i], 0, limits->n_source) &&
                paths->ray.stop[i] < RMAP_STOP_COUNT;
        self->path_segment[i] = (uint32_t)n_segment;
        self->path_registration[i] = (uint32_t)n_registration;
        n_segment += paths->ray.segment_count[i];
        n_registration += paths->ray.registration_count[i];
    }
    if (!good)
        return bad(err, "a path of it names nothing in the scene");
    if (n_segment != paths->n_row[RMAP_TABLE_SEGMENT] ||
        n_registration != paths->n_row[RMAP_TABLE_REGISTRATION])
        return bad(err, "its paths do not add up");
    return RMAP_OK;
}

static enum rmap_status read_path_rows(struct rmap_history_index *self,
                                       const struct rmap_history_layout *layout,
                                       const uint8_t *bytes, struct rmap_error *err)
{
    struct rmap_portion *paths = self->paths;
    const uint16_t *class_of = (const void *)(bytes + layout->at[RMAP_HEAD_PATH_CLASS]);
    const uint16_t *hit = (const void *)(bytes + layout->at[RMAP_HEAD_PATH_HIT]);
    for (size_t i = 0; i < paths->n_row[RMAP_TABLE_SEGMENT]; i++) {
        if (class_of[i] >= self->n_class)
            return bad(err, "a segment of its paths has no class");
        const struct rmap_step_class *what = &self->class_of[class_of[i]];
        paths->segment.object[i] = what->object;
        paths->segment.event[i] = what->event;
        paths->segment.medium[i] = (int16_t)what->medium;
    }
    memcpy(paths->registration.segment, bytes + layout->at[RMAP_HEAD_PATH_SEGMENT],
           paths->n_row[RMAP_TABLE_REGISTRATION] * sizeof(uint32_t));
    for (size_t i = 0; i < paths->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        if (hit[i] >= self->n_hit)
            return bad(err, "a registration of its paths has no detector");
        paths->registration.detector[i] = self->hit[hit[i]].detector;
        paths->registration.registered[i] = (uint8_t)self->hit[hit[i]].registered;
    }
    return RMAP_OK;
}

static enum rmap_status read_places(struct rmap_history_index *self,
                                    const struct rmap_history_layout *layout, const uint8_t *bytes,
                                    struct rmap_error *err)
{
    bool good = true;
    self->place = rmap_alloc(self->n_portion, sizeof *self->place);
    if (!self->place)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    memcpy(self->place, bytes + layout->at[RMAP_HEAD_PORTION],
           self->n_portion * sizeof *self->place);
    for (size_t i = 0; i < self->n_portion; i++) {
        const struct rmap_history_place *place = &self->place[i];
        uint32_t n_ray = place->n_row[RMAP_TABLE_RAY];
        good &= n_ray > 0 && n_ray <= RMAP_HISTORY_RAY_MAX && place->form <= RMAP_HISTORY_ROWS &&
                place->offset % 8 == 0 && place->nbytes <= self->body.nbytes &&
                place->offset <= self->body.nbytes - place->nbytes &&
                place->nbytes >= sizeof(struct rmap_history_shape) &&
                (i == 0 || self->place[i - 1].first_ray < place->first_ray);
    }
    return good ? RMAP_OK : bad(err, "its list of portions");
}

enum rmap_status rmap_history_open(const uint8_t *head, size_t head_nbytes,
                                   const struct rmap_history_body *body,
                                   const struct rmap_history_limits *limits,
                                   struct rmap_history_index **index_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_head rows;
    struct rmap_history_layout layout;
    struct rmap_history_index *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    RMAP_TRY(check_size(head, head_nbytes, body, &rows, &layout, err));
    self->n_class = (size_t)rows.n_class;
    self->n_hit = (size_t)rows.n_hit;
    self->n_portion = (size_t)rows.n_portion;
    self->n_source = limits->n_source;
    self->body.nbytes = body->nbytes;
    RMAP_TRY(read_classes(self, limits, &layout, head, err));
    RMAP_TRY(reserve_paths(self, &rows, err));
    RMAP_TRY(read_path_rays(self, limits, &layout, head, err));
    RMAP_TRY(read_path_rows(self, &layout, head, err));
    RMAP_TRY(read_places(self, &layout, head, err));
    self->body = *body;
    *index_ret = self;
    self = NULL;
out:
    rmap_history_destroy(self);
    return st;
}

void rmap_history_destroy(struct rmap_history_index *self)
{
    if (!self)
        return;
    if (self->body.release)
        self->body.release(self->body.context);
    rmap_portion_destroy(self->paths);
    rmap_free(self->path_segment);
    rmap_free(self->path_registration);
    rmap_free(self->class_of);
    rmap_free(self->hit);
    rmap_free(self->place);
    rmap_free(self);
}

/* ---- what it shows ---- */

size_t rmap_history_nbytes(const struct rmap_history_index *self)
{
    size_t nbytes = sizeof *self + self->n_class * sizeof *self->class_of +
                    self->n_hit * sizeof *self->hit + self->n_portion * sizeof *self->place +
                    2 * sizeof(uint32_t) * self->paths->n_row[RMAP_TABLE_RAY];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c))
            nbytes += self->paths->cap[rmap_column_info((enum rmap_column)c)->table] *
                      rmap_portion_row_nbytes(self->paths, (enum rmap_column)c);
    return nbytes;
}

size_t rmap_history_n_class(const struct rmap_history_index *self)
{
    return self->n_class;
}

const struct rmap_step_class *rmap_history_classes(const struct rmap_history_index *self)
{
    return self->class_of;
}

size_t rmap_history_n_hit(const struct rmap_history_index *self)
{
    return self->n_hit;
}

const struct rmap_history_hit *rmap_history_hits(const struct rmap_history_index *self)
{
    return self->hit;
}

const struct rmap_portion *rmap_history_paths(const struct rmap_history_index *self)
{
    return self->paths;
}

size_t rmap_history_n_portion(const struct rmap_history_index *self)
{
    return self->n_portion;
}

size_t rmap_history_find(const struct rmap_history_index *self, uint64_t first_ray,
                         const uint64_t n_row[RMAP_TABLE_HISTORY_COUNT], struct rmap_digest digest)
{
    size_t low = 0, high = self->n_portion;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (self->place[middle].first_ray < first_ray)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == self->n_portion)
        return SIZE_MAX;
    const struct rmap_history_place *place = &self->place[low];
    bool same = place->first_ray == first_ray && place->digest_low == digest.low &&
                place->digest_high == digest.high;
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        same &= place->n_row[t] == n_row[t];
    return same ? low : SIZE_MAX;
}

/* Writes the head of an index: what a piece has in common, and where its portions stand. */

static const uint32_t *words_of(const struct rmap_word_book *book, size_t k)
{
    return book->word + book->entry[k].first;
}

static void write_paths(const struct rmap_word_book *path, const struct rmap_history_layout *layout,
                        uint8_t *bytes)
{
    const uint64_t *at = layout->at;
    int32_t *source = (int32_t *)(void *)(bytes + at[RMAP_HEAD_SOURCE]);
    uint32_t *segments = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_SEGMENT_COUNT]);
    uint32_t *registrations = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_REGISTRATION_COUNT]);
    uint16_t *class_of = (uint16_t *)(void *)(bytes + at[RMAP_HEAD_PATH_CLASS]);
    uint32_t *segment = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_PATH_SEGMENT]);
    uint16_t *hit = (uint16_t *)(void *)(bytes + at[RMAP_HEAD_PATH_HIT]);
    for (size_t i = 0; i < path->n; i++) {
        const uint32_t *word = words_of(path, i);
        source[i] = (int32_t)word[RMAP_HISTORY_WORD_SOURCE];
        bytes[at[RMAP_HEAD_STOP] + i] = (uint8_t)word[RMAP_HISTORY_WORD_STOP];
        segments[i] = word[RMAP_HISTORY_WORD_SEGMENTS];
        registrations[i] = word[RMAP_HISTORY_WORD_REGISTRATIONS];
        word += RMAP_HISTORY_WORD_HEAD;
        for (uint32_t k = 0; k < segments[i]; k++)
            *class_of++ = (uint16_t)*word++;
        for (uint32_t k = 0; k < registrations[i]; k++)
            *segment++ = *word++;
        for (uint32_t k = 0; k < registrations[i]; k++)
            *hit++ = (uint16_t)*word++;
    }
}

static void write_head(const struct rmap_history_builder *self,
                       const struct rmap_history_head *head,
                       const struct rmap_history_layout *layout, uint8_t *bytes)
{
    struct rmap_step_class *class_of = (void *)(bytes + layout->at[RMAP_HEAD_CLASS]);
    struct rmap_history_hit *hit = (void *)(bytes + layout->at[RMAP_HEAD_HIT]);
    memcpy(bytes, head, sizeof *head);
    for (size_t k = 0; k < self->class_of.n; k++) {
        const uint32_t *word = words_of(&self->class_of, k);
        class_of[k] = (struct rmap_step_class){(int32_t)word[0], word[1], (int32_t)word[2]};
    }
    for (size_t k = 0; k < self->hit.n; k++) {
        const uint32_t *word = words_of(&self->hit, k);
        hit[k] = (struct rmap_history_hit){(int32_t)word[0], (int32_t)word[1]};
    }
    write_paths(&self->path, layout, bytes);
    if (self->n_place > 0)
        memcpy(bytes + layout->at[RMAP_HEAD_PORTION], self->place,
               self->n_place * sizeof *self->place);
}

enum rmap_status rmap_history_builder_finish(struct rmap_history_builder *self,
                                             struct rmap_history_bytes *bytes,
                                             struct rmap_error *err)
{
    const struct rmap_history_head head = {.magic = RMAP_HISTORY_MAGIC,
                                           .n_class = self->class_of.n,
                                           .n_hit = self->hit.n,
                                           .n_path = self->path.n,
                                           .n_path_segment = self->n_path_segment,
                                           .n_path_registration = self->n_path_registration,
                                           .n_portion = self->n_place,
                                           .body_nbytes = self->body_nbytes};
    struct rmap_history_layout layout;
    rmap_history_arrange_head(&head, &layout);
    size_t nbytes = (size_t)layout.at[RMAP_HEAD_PARTS];
    uint8_t *block = rmap_alloc(nbytes + sizeof(uint64_t), 1);
    if (!block)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an index");
    write_head(self, &head, &layout, block);
    uint64_t checksum = XXH3_64bits(block, nbytes);
    memcpy(block + nbytes, &checksum, sizeof checksum);
    *bytes = (struct rmap_history_bytes){.head = block,
                                         .head_nbytes = nbytes + sizeof checksum,
                                         .body = self->body,
                                         .body_nbytes = self->body_nbytes};
    self->body = NULL;
    self->body_nbytes = self->cap_body = self->n_place = 0;
    self->n_path_segment = self->n_path_registration = 0;
    rmap_word_book_clear(&self->class_of);
    rmap_word_book_clear(&self->hit);
    rmap_word_book_clear(&self->path);
    return RMAP_OK;
}
