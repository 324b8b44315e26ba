/* SPDX-License-Identifier: MIT
 *
 * Classes of the rays of a portion in memory: those of one source with one path (path_key.h).
 */
#include "analysis/paths/path_class.h"

#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_text.h"
#include "base/alloc.h"

/* A ray that has a path. */
struct member {
    struct rmap_key key;
    struct rmap_path_place_of_ray place;
};

static int compare_members(const void *a_, const void *b_)
{
    const struct member *a = a_, *b = b_;
    int order = (a->key.low > b->key.low) - (a->key.low < b->key.low);
    order = order != 0 ? order : (a->key.high > b->key.high) - (a->key.high < b->key.high);
    return order != 0 ? order : (a->place.ray > b->place.ray) - (a->place.ray < b->place.ray);
}

static int compare_classes(const void *a_, const void *b_)
{
    const struct rmap_path_class *a = a_, *b = b_;
    int order = (a->flux < b->flux) - (a->flux > b->flux);
    return order != 0 ? order : (a->first_ray > b->first_ray) - (a->first_ray < b->first_ray);
}

struct work {
    const struct rmap_portion *portion;
    const double *flux_per_weight;
    struct member *member; /* [n_ray] those that have a path */
    size_t n_member;
    uint32_t *number;       /* [n_ray] a class's number before ranking, by its first row */
    rmap_path_step *symbol; /* of one ray */
};

static enum rmap_status allocate(struct rmap_path_classes *classes, struct work *work,
                                 struct rmap_error *err)
{
    const struct rmap_portion *portion = work->portion;
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    size_t longest = 0;
    for (size_t i = 0; i < n_ray; i++) {
        size_t n = (size_t)portion->ray.segment_count[i] + portion->ray.registration_count[i];
        longest = n > longest ? n : longest;
    }
    work->member = rmap_alloc(n_ray + 1, sizeof *work->member);
    work->number = rmap_alloc(n_ray + 1, sizeof *work->number);
    work->symbol = rmap_alloc(longest + 1, sizeof *work->symbol);
    classes->path = rmap_alloc(n_ray + 1, sizeof *classes->path);
    classes->of_ray = rmap_alloc(n_ray + 1, sizeof *classes->of_ray);
    if (work->member && work->number && work->symbol && classes->path && classes->of_ray)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of %zu rays", n_ray);
}

/* Until a detector, a ray that registered there more than once has the first of its paths. */
static void find_members(const struct rmap_path_classes *classes, struct work *work)
{
    const struct rmap_portion *portion = work->portion;
    struct rmap_path_place_of_ray place = {0};
    size_t n_step;
    for (; place.ray < portion->n_row[RMAP_TABLE_RAY]; place.ray++) {
        if (rmap_path_key_of(classes->keys, portion, &place, work->symbol, &n_step))
            work->member[work->n_member++] = (struct member){
                rmap_path_key_hash(work->symbol, n_step, portion->ray.source[place.ray]), place};
        place.segment += portion->ray.segment_count[place.ray];
        place.registration += portion->ray.registration_count[place.ray];
    }
}

/* The member in [first, last) with the smallest id. */
static const struct member *first_ray(const struct work *work, size_t first, size_t last)
{
    const uint64_t *id = work->portion->ray.id;
    const struct member *least = &work->member[first];
    for (size_t i = first + 1; i < last; i++)
        if (id[work->member[i].place.ray] < id[least->place.ray])
            least = &work->member[i];
    return least;
}

/* Sums over members [first, last), which are those of one class. */
static enum rmap_status add_class(struct rmap_path_classes *classes, struct work *work,
                                  size_t first, size_t last, size_t *cap, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = work->portion;
    const struct rmap_path_place_of_ray place = first_ray(work, first, last)->place;
    struct rmap_path_class *path = &classes->path[classes->n];
    const struct rmap_path_class *before = classes->n > 0 ? path - 1 : NULL;
    *path = (struct rmap_path_class){.source = portion->ray.source[place.ray],
                                     .first_ray = portion->ray.id[place.ray],
                                     .first_row = place.ray,
                                     .rays = last - first,
                                     .first_symbol =
                                         before ? before->first_symbol + before->n_symbol : 0};
    (void)rmap_path_key_of(classes->keys, portion, &place, work->symbol, &path->n_symbol);
    RMAP_TRY(RMAP_RESERVE(classes->symbol, *cap, path->first_symbol + path->n_symbol + 1, err));
    memcpy(classes->symbol + path->first_symbol, work->symbol,
           path->n_symbol * sizeof *work->symbol);
    for (size_t i = first; i < last; i++) {
        size_t row = work->member[i].place.ray;
        path->segments += portion->ray.segment_count[row];
        path->flux += portion->ray.weight[row];
        classes->of_ray[row] = (uint32_t)place.ray;
    }
    path->flux *= work->flux_per_weight[path->source];
    classes->n++;
out:
    return st;
}

/* of_ray: from rows of first rays to ranks. */
static void rank(struct rmap_path_classes *classes, struct work *work)
{
    qsort(classes->path, classes->n, sizeof *classes->path, compare_classes);
    for (size_t k = 0; k < classes->n; k++)
        work->number[classes->path[k].first_row] = (uint32_t)k;
    for (size_t i = 0; i < work->portion->n_row[RMAP_TABLE_RAY]; i++)
        if (classes->of_ray[i] != RMAP_PATH_NO_CLASS)
            classes->of_ray[i] = work->number[classes->of_ray[i]];
}

enum rmap_status
rmap_path_classes_create(const struct rmap_scene *scene, const struct rmap_path_view *view,
                         const struct rmap_portion *portion, const double *flux_per_weight,
                         struct rmap_path_classes **classes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct work work = {.portion = portion, .flux_per_weight = flux_per_weight};
    size_t cap = 0;
    struct rmap_path_classes *classes = rmap_alloc(1, sizeof *classes);
    if (!classes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    RMAP_TRY(rmap_path_keys_create(scene, view, &classes->keys, err));
    RMAP_TRY(allocate(classes, &work, err));
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++)
        classes->of_ray[i] = RMAP_PATH_NO_CLASS;
    find_members(classes, &work);
    qsort(work.member, work.n_member, sizeof *work.member, compare_members);
    for (size_t i = 0; i < work.n_member;) {
        size_t first = i++;
        while (i < work.n_member && rmap_keys_equal(work.member[i].key, work.member[first].key))
            i++;
        RMAP_TRY(add_class(classes, &work, first, i, &cap, err));
    }
    rank(classes, &work);
    *classes_ret = classes;
    classes = NULL;
out:
    rmap_free(work.member);
    rmap_free(work.number);
    rmap_free(work.symbol);
    rmap_path_classes_destroy(classes);
    return st;
}

void rmap_path_classes_destroy(struct rmap_path_classes *classes)
{
    if (!classes)
        return;
    rmap_path_keys_destroy(classes->keys);
    rmap_free(classes->path);
    rmap_free(classes->of_ray);
    rmap_free(classes->symbol);
    rmap_free(classes);
}

enum rmap_status rmap_path_class_label(const struct rmap_path_classes *classes, size_t index,
                                       size_t most_nbytes, char **text_ret, struct rmap_error *err)
{
    const struct rmap_path_class *path = &classes->path[index];
    char *steps = NULL;
    enum rmap_status st = rmap_path_key_text(classes->keys, classes->symbol + path->first_symbol,
                                             path->n_symbol, most_nbytes, &steps, err);
    if (st == RMAP_OK)
        st = rmap_path_with_source(classes->keys, path->source, steps, text_ret, err);
    rmap_free(steps);
    return st;
}

enum rmap_status rmap_path_class_criterion(const struct rmap_path_classes *classes, size_t index,
                                           char **text_ret, struct rmap_error *err)
{
    const struct rmap_path_class *path = &classes->path[index];
    return rmap_path_criterion_of(
        classes->keys, path->source, classes->symbol + path->first_symbol, path->n_symbol,
        path->rays == 1 ? path->first_ray : RMAP_PATH_MANY_RAYS, text_ret, err);
}
