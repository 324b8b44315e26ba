/* SPDX-License-Identifier: MIT
 *
 * An index from bytes that may say anything.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "history/history_parts.h"
#include "portion/event.h"

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
            return bad(err, "a leg of its paths has no class");
        const struct rmap_history_class *what = &self->class_of[class_of[i]];
        paths->segment.object[i] = what->object;
        paths->segment.event[i] = what->event;
        paths->segment.medium[i] = (int16_t)what->medium;
    }
    memcpy(paths->registration.segment, bytes + layout->at[RMAP_HEAD_PATH_LEG],
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

const struct rmap_history_class *rmap_history_classes(const struct rmap_history_index *self)
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
