/* SPDX-License-Identifier: MIT
 *
 * What detectors registered, by how the light came there: by ghost and scatter order
 * (path_order.h), by the pair of surfaces that made a ghost, by source and object.
 */
#include "analysis/paths/path_matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_report.h"
#include "base/alloc.h"
#include "portion/weight.h"

enum { PART_SHIFT = 56, SOURCE_SHIFT = 32 };

/* Numbers of an entry: the last ray, how often it came here, and how many rays did. */
enum { LAST_RAY, LAST_COUNT, RAYS };

/* A registration: its ray and where its rows begin. */
struct hit {
    const struct rmap_portion *portion;
    size_t ray, segment, number; /* its first; of the one with the hit */
    int32_t detector, source;
    double weight;
};

rmap_column_set rmap_path_matrix_columns(const struct rmap_path_matrix *matrix)
{
    return rmap_path_keys_columns(matrix->keys) | matrix->order->columns |
           RMAP_COLUMN_BIT(RMAP_RAY_weight);
}

static void destroy(void *state)
{
    struct rmap_path_matrix_sums *self = state;
    if (!self)
        return;
    rmap_key_sums_fini(&self->sums);
    rmap_free(self->met);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_path_matrix *matrix = context;
    struct rmap_path_matrix_sums *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->met = rmap_alloc(rmap_path_n_label(matrix->keys) + 1, sizeof *self->met);
    if (!self || !self->met) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths to detectors");
    }
    self->context = matrix;
    rmap_key_sums_init(&self->sums, RMAP_PATH_MATRIX_MOST);
    *state_ret = self;
    return RMAP_OK;
}

static enum rmap_status enter(struct rmap_path_matrix_sums *self, struct rmap_key key,
                              struct rmap_key_sum **sum_ret, struct rmap_error *err)
{
    enum rmap_status st = rmap_key_sums_enter(&self->sums, key, sum_ret, err);
    if (st == RMAP_OK && !*sum_ret)
        st = rmap_error_set(err, RMAP_SYSTEM,
                            "more than %zu sums of detectors, sources and objects: ask for one "
                            "detector (--detector) or for larger parts (--by group)",
                            RMAP_PATH_MATRIX_MOST);
    return st;
}

/* The ray's k-th time in a sum makes its contribution k w. */
static enum rmap_status add_sum(struct rmap_path_matrix_sums *self, const struct hit *hit,
                                enum rmap_path_part part, uint32_t a, uint32_t b,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t id = hit->portion->ray.id[hit->ray];
    struct rmap_key_sum *sum = NULL;
    const struct rmap_key key = {(uint64_t)a << 32 | b,
                                 UINT64_C(1) << 63 | (uint64_t)part << PART_SHIFT |
                                     (uint64_t)(uint32_t)hit->source << SOURCE_SHIFT |
                                     (uint32_t)hit->detector};
    RMAP_TRY(enter(self, key, &sum, err));
    bool again = sum->number[LAST_COUNT] > 0 && sum->number[LAST_RAY] == id;
    uint64_t k = again ? sum->number[LAST_COUNT] + 1 : 1;
    sum->number[LAST_RAY] = id;
    sum->number[LAST_COUNT] = k;
    sum->number[RAYS] += !again;
    sum->weight += hit->weight;
    sum->weight_squared += (2.0 * (double)k - 1.0) * rmap_weight_squared(hit->weight);
out:
    return st;
}

/* Each object met before, and the last of them. */
static enum rmap_status add_objects(struct rmap_path_matrix_sums *self, const struct hit *hit,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int32_t *label = rmap_path_labels(self->context->keys);
    const int32_t *object = hit->portion->segment.object;
    uint32_t last = 0;
    self->n_registration++;
    for (size_t i = hit->segment; i < hit->segment + hit->number; i++) {
        if (object[i] < 0)
            continue;
        last = (uint32_t)label[object[i]] + 1;
        if (self->met[last - 1] == self->n_registration)
            continue;
        self->met[last - 1] = self->n_registration;
        RMAP_TRY(add_sum(self, hit, RMAP_PATH_MET, last, 0, err));
    }
    st = add_sum(self, hit, RMAP_PATH_LAST, last, 0, err);
out:
    return st;
}

static enum rmap_status add_hit(struct rmap_path_matrix_sums *self, const struct hit *hit,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_matrix *matrix = self->context;
    const struct rmap_segment_columns *rows = &hit->portion->segment;
    const int32_t *label = rmap_path_labels(matrix->keys);
    uint32_t ghost = 0, scatter = 0, by[2] = {0, 0};
    for (size_t i = hit->segment; i < hit->segment + hit->number; i++) {
        if (rmap_path_ghost_step(matrix->order, hit->portion, i, hit->ray, hit->segment)) {
            if (ghost < 2)
                by[ghost] = (uint32_t)label[rows->object[i]];
            ghost++;
        }
        scatter += rmap_path_scatter_step(rows->event[i]);
    }
    RMAP_TRY(add_sum(self, hit, RMAP_PATH_ALL, 0, 0, err));
    if (ghost > 0 || scatter > 0)
        RMAP_TRY(add_sum(self, hit, RMAP_PATH_STRAY, 0, 0, err));
    if (matrix->parts & RMAP_PATH_PART_BIT(RMAP_PATH_GHOSTS) && ghost == 2 && scatter == 0)
        RMAP_TRY(add_sum(self, hit, RMAP_PATH_GHOSTS, by[0], by[1], err));
    if (matrix->parts & RMAP_PATH_PART_BIT(RMAP_PATH_MET))
        RMAP_TRY(add_objects(self, hit, err));
    if (matrix->parts & RMAP_PATH_PART_BIT(RMAP_PATH_ORDERS))
        st = add_sum(self, hit, RMAP_PATH_ORDERS,
                     ghost < RMAP_PATH_ORDER_MOST ? ghost : RMAP_PATH_ORDER_MOST,
                     scatter < RMAP_PATH_ORDER_MOST ? scatter : RMAP_PATH_ORDER_MOST, err);
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_matrix_sums *self = state;
    const struct rmap_portion *portion = rays->portion;
    const struct rmap_registration_columns *seen = &portion->registration;
    const uint8_t *counts = rmap_registrations_counted(rays);
    struct hit hit = {.portion = portion};
    size_t row = 0;
    for (; hit.ray < portion->n_row[RMAP_TABLE_RAY]; hit.ray++) {
        const size_t n_segment = portion->ray.segment_count[hit.ray];
        const size_t end = row + portion->ray.registration_count[hit.ray];
        hit.source = portion->ray.source[hit.ray];
        hit.weight = portion->ray.weight[hit.ray];
        for (; row < end; row++) {
            hit.detector = seen->detector[row];
            if ((rays->match && !rays->match[hit.ray]) || !counts[row] ||
                (self->context->detector >= 0 && hit.detector != self->context->detector))
                continue;
            hit.number = seen->segment[row] < n_segment ? seen->segment[row] : n_segment;
            RMAP_TRY(add_hit(self, &hit, err));
        }
        hit.segment += n_segment;
    }
out:
    return st;
}

static enum rmap_status merge_sum(struct rmap_path_matrix_sums *into,
                                  const struct rmap_key_sum *more, struct rmap_error *err)
{
    struct rmap_key_sum *sum = NULL;
    enum rmap_status st = enter(into, more->key, &sum, err);
    if (st != RMAP_OK)
        return st;
    sum->weight += more->weight;
    sum->weight_squared += more->weight_squared;
    sum->number[RAYS] += more->number[RAYS];
    return RMAP_OK;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_key_sums *sums = &((const struct rmap_path_matrix_sums *)from)->sums;
    for (size_t i = 0; i < sums->n && st == RMAP_OK; i++)
        st = merge_sum(into, &sums->entry[i], err);
    return st;
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_path_matrix_sums *self = state;
    *nbytes_ret = self->sums.n * sizeof *self->sums.entry;
    *bytes_ret = rmap_alloc_unset(*nbytes_ret + 1, 1);
    if (!*bytes_ret)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums of %zu paths",
                              self->sums.n);
    if (*nbytes_ret > 0)
        memcpy(*bytes_ret, self->sums.entry, *nbytes_ret);
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = create(context, state_ret, err);
    for (size_t at = 0; st == RMAP_OK && at + sizeof(struct rmap_key_sum) <= nbytes;
         at += sizeof(struct rmap_key_sum)) {
        struct rmap_key_sum sum;
        memcpy(&sum, bytes + at, sizeof sum);
        st = merge_sum(*state_ret, &sum, err);
    }
    return st;
}

const struct rmap_fold_kind rmap_path_matrix_kind = {.create = create,
                                                     .destroy = destroy,
                                                     .add = add,
                                                     .merge = merge,
                                                     .pack = pack,
                                                     .unpack = unpack};

static bool is_per_source(enum rmap_path_part part)
{
    return part == RMAP_PATH_LAST || part == RMAP_PATH_MET;
}

/* One source's sum; variance in standard_error until sums over sources are closed. */
static struct rmap_path_cellsum open_sum(const struct rmap_map *map, const struct rmap_key_sum *sum)
{
    const int32_t source = (int32_t)(sum->key.high >> SOURCE_SHIFT & (RMAP_PATH_SOURCES_MAX - 1));
    struct rmap_path_cellsum cell = {.part =
                                         (enum rmap_path_part)(sum->key.high >> PART_SHIFT & 0x7f),
                                     .detector = (int32_t)(uint32_t)sum->key.high,
                                     .source = source,
                                     .a = (uint32_t)(sum->key.low >> 32),
                                     .b = (uint32_t)sum->key.low,
                                     .rays = sum->number[RAYS]};
    rmap_path_flux(map, (size_t)source, sum->weight, sum->weight_squared, &cell.flux,
                   &cell.standard_error);
    cell.standard_error *= cell.standard_error;
    return cell;
}

static int compare(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

/* By what is summed, sources last. */
static int compare_places(const void *a_, const void *b_)
{
    const struct rmap_path_cellsum *a = a_, *b = b_;
    const int order[] = {compare(a->part, b->part),
                         compare((uint32_t)a->detector, (uint32_t)b->detector), compare(a->a, b->a),
                         compare(a->b, b->b), compare((uint32_t)a->source, (uint32_t)b->source)};
    for (size_t i = 0; i < sizeof order / sizeof *order; i++)
        if (order[i] != 0)
            return order[i];
    return 0;
}

static int compare_ranks(const void *a_, const void *b_)
{
    const struct rmap_path_cellsum *a = a_, *b = b_;
    if (a->part == b->part && a->detector == b->detector && a->part != RMAP_PATH_ORDERS &&
        a->flux != b->flux)
        return a->flux > b->flux ? -1 : 1;
    return compare_places(a_, b_);
}

enum rmap_status rmap_path_matrix_list(const struct rmap_path_matrix_sums *sums,
                                       struct rmap_path_cellsum **list_ret, size_t *n_ret,
                                       struct rmap_error *err)
{
    struct rmap_path_cellsum *list = rmap_alloc(sums->sums.n + 1, sizeof *list);
    const size_t n_open = sums->sums.n;
    size_t n = 0;
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sums", sums->sums.n);
    for (size_t i = 0; i < n_open; i++)
        list[i] = open_sum(sums->context->map, &sums->sums.entry[i]);
    qsort(list, n_open, sizeof *list, compare_places);
    for (size_t i = 0; i < n_open; i++) {
        struct rmap_path_cellsum cell = list[i], *last = n > 0 ? &list[n - 1] : NULL;
        if (!is_per_source(cell.part))
            cell.source = -1;
        if (last && compare_places(last, &cell) == 0) {
            last->rays += cell.rays;
            last->flux += cell.flux;
            last->standard_error += cell.standard_error;
        } else {
            list[n++] = cell;
        }
    }
    for (size_t i = 0; i < n; i++)
        list[i].standard_error = sqrt(list[i].standard_error);
    qsort(list, n, sizeof *list, compare_ranks);
    *list_ret = list;
    *n_ret = n;
    return RMAP_OK;
}
