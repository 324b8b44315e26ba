/* SPDX-License-Identifier: MIT
 *
 * Which ink each ray of a picture has: that of its light, or that of a group of rays (a path, a
 * criterion, an order), with what a legend says of the groups.
 */
#include "analysis/figure/ray_paint.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/path_order.h"
#include "analysis/paths/path_class.h"
#include "analysis/query/which.h"
#include "analysis/table/line_mark.h"
#include "base/alloc.h"

/* Paths that have an ink of their own, and orders: the last one is that order and all above. */
enum { PATHS_SHOWN = 7, ORDERS_SHOWN = 4, LABEL_NBYTES = 90 };

static const struct rmap_line_mark other = {.ink = "#9a9a9a"};

const char *rmap_paint_word(enum rmap_paint_kind kind)
{
    static const char *const word[] = {"natural", "path", "criterion", "order"};
    return word[kind];
}

static enum rmap_status add_group(struct rmap_ray_paint *self, struct rmap_line_mark mark,
                                  const char *label, struct rmap_error *err)
{
    struct rmap_paint_group *group = &self->group[self->n_group];
    const size_t nbytes = strlen(label) + 1;
    group->label = rmap_alloc(nbytes, 1);
    if (!group->label)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a legend");
    memcpy(group->label, label, nbytes);
    (void)snprintf(group->ink, sizeof group->ink, "%s", mark.ink);
    group->dash = mark.dash;
    self->n_group++;
    return RMAP_OK;
}

/* From fine to coarse. */
static const struct {
    struct rmap_path_view view;
    const char *note;
} paths_by[] = {
    {{.level = RMAP_PATH_OBJECT}, NULL},
    {{.level = RMAP_PATH_OBJECT, .collapsed = true}, "equal steps in a row count as one"},
    {{.level = RMAP_PATH_GROUP, .collapsed = true},
     "by groups of the scene, equal steps in a row count as one"},
};
enum { PATHS_BY_COUNT = sizeof paths_by / sizeof *paths_by, SEVERAL_RAYS = 3 };

/* Whether most paths with an ink have several rays, or they are all there are. */
static bool hold_several(const struct rmap_path_classes *classes)
{
    size_t n = 0;
    for (size_t k = 0; k < classes->n && k < PATHS_SHOWN; k++)
        n += classes->path[k].rays >= SEVERAL_RAYS;
    return classes->n <= PATHS_SHOWN || 2 * n > PATHS_SHOWN;
}

static enum rmap_status find_paths(struct rmap_ray_paint *self,
                                   const struct rmap_paint_request *request,
                                   struct rmap_path_classes **classes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < PATHS_BY_COUNT; k++) {
        struct rmap_path_view view = paths_by[k].view;
        if (request->level)
            view.level = *request->level;
        else
            self->note = paths_by[k].note;
        rmap_path_classes_destroy(*classes_ret);
        *classes_ret = NULL;
        RMAP_TRY(rmap_path_classes_create(request->scene, &view, request->rays,
                                          request->flux_per_weight, classes_ret, err));
        if (request->level || hold_several(*classes_ret))
            break;
    }
out:
    return st;
}

static enum rmap_status group_by_path(struct rmap_ray_paint *self,
                                      const struct rmap_paint_request *request,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_classes *classes = NULL;
    char *label = NULL, others[64];
    RMAP_TRY(find_paths(self, request, &classes, err));
    const size_t n = classes->n < PATHS_SHOWN ? classes->n : PATHS_SHOWN;
    for (size_t k = 0; k < n; k++) {
        rmap_free(label);
        label = NULL;
        RMAP_TRY(rmap_path_class_label(classes, k, LABEL_NBYTES, &label, err));
        RMAP_TRY(add_group(self, rmap_line_mark(k), label, err));
    }
    if (classes->n > n) {
        (void)snprintf(others, sizeof others, "%zu other paths", classes->n - n);
        RMAP_TRY(add_group(self, other, others, err));
    }
    for (size_t i = 0; i < request->rays->n_row[RMAP_TABLE_RAY]; i++)
        self->of_ray[i] = classes->of_ray[i] < n ? classes->of_ray[i] : (uint32_t)n;
out:
    rmap_free(label);
    rmap_path_classes_destroy(classes);
    return st;
}

/* Of rays that a criterion asks about on a detector: the orders there, as paths and images have
 * them, not those with which the ray ends. */
static enum rmap_status take_orders_there(const struct rmap_paint_request *request,
                                          const struct rmap_path_order *order, uint32_t *ghost,
                                          uint32_t *scatter, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *rays = request->rays;
    const size_t n = rays->n_row[RMAP_TABLE_REGISTRATION];
    const struct rmap_index_set all = {.low = 0, .span = (uint32_t)request->scene->n_detector};
    struct rmap_which *which = NULL;
    uint8_t *chosen = rmap_alloc(n + 1, 1);
    uint32_t *there = rmap_alloc(2 * n + 1, sizeof *there);
    if (!chosen || !there)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for orders of ghosts"));
    RMAP_TRY(
        rmap_which_create(request->scene, &all, NULL, NULL, request->criterion[0], &which, err));
    RMAP_TRY(rmap_which_mark(which, rays, chosen, err));
    rmap_path_orders_of_registrations(order, rays, there, there + n);
    for (size_t i = 0, row = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t end = row + rays->ray.registration_count[i];
        while (row < end && !(chosen[row] && which->asked_on[rays->registration.detector[row]]))
            row++;
        if (row < end) {
            ghost[i] = there[row];
            scatter[i] = there[n + row];
        }
        row = end;
    }
out:
    rmap_which_destroy(which);
    rmap_free(chosen);
    rmap_free(there);
    return st;
}

static enum rmap_status group_by_order(struct rmap_ray_paint *self,
                                       const struct rmap_paint_request *request,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = request->rays->n_row[RMAP_TABLE_RAY];
    struct rmap_path_order order = {0};
    uint32_t *ghost = rmap_alloc(n_ray + 1, sizeof *ghost);
    uint32_t *scatter = rmap_alloc(n_ray + 1, sizeof *scatter);
    char label[64];
    if (!ghost || !scatter)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for orders of ghosts"));
    RMAP_TRY(rmap_path_order_init(&order, request->scene, err));
    rmap_path_orders_of_rays(&order, request->rays, ghost, scatter);
    if (request->n_criterion == 1)
        RMAP_TRY(take_orders_there(request, &order, ghost, scatter, err));
    for (int k = 0; k <= ORDERS_SHOWN; k++) {
        (void)snprintf(label, sizeof label, "ghost order %d%s", k,
                       k == ORDERS_SHOWN ? " and above"
                       : k == 0          ? ", direct light"
                                         : "");
        RMAP_TRY(add_group(self, rmap_line_mark((size_t)k), label, err));
    }
    RMAP_TRY(add_group(self, other, "scattered", err));
    for (size_t i = 0; i < n_ray; i++)
        self->of_ray[i] = scatter[i] > 0            ? ORDERS_SHOWN + 1
                          : ghost[i] < ORDERS_SHOWN ? ghost[i]
                                                    : ORDERS_SHOWN;
out:
    rmap_path_order_fini(&order);
    rmap_free(ghost);
    rmap_free(scatter);
    return st;
}

static enum rmap_status group_by_criterion(struct rmap_ray_paint *self,
                                           const struct rmap_paint_request *request,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = request->rays->n_row[RMAP_TABLE_RAY], n = request->n_criterion;
    uint8_t *match = rmap_alloc(n_ray + 1, sizeof *match);
    if (!match)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", n_ray);
    for (size_t i = 0; i < n_ray; i++)
        self->of_ray[i] = (uint32_t)n;
    for (size_t c = 0; c < n; c++) {
        const char *name = rmap_criterion_name(request->criterion[c]);
        RMAP_TRY(add_group(self, rmap_line_mark(c),
                           name ? name : rmap_criterion_text(request->criterion[c]), err));
        self->group[c].asked = true;
        RMAP_TRY(rmap_criterion_evaluate(request->criterion[c], request->rays,
                                         request->flux_per_weight, match, err));
        for (size_t i = 0; i < n_ray; i++)
            if (match[i] && self->of_ray[i] == n)
                self->of_ray[i] = (uint32_t)c;
    }
    RMAP_TRY(add_group(self, other, "none of these", err));
out:
    rmap_free(match);
    return st;
}

static void add_up(struct rmap_ray_paint *self, const struct rmap_paint_request *request)
{
    const struct rmap_portion *rays = request->rays;
    double greatest = 0.0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        const double flux = rays->ray.weight[i] * request->flux_per_weight[rays->ray.source[i]];
        self->strength[i] = flux;
        self->flux += flux;
        greatest = fmax(greatest, flux);
        if (self->of_ray) {
            self->group[self->of_ray[i]].rays++;
            self->group[self->of_ray[i]].flux += flux;
        }
    }
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++)
        self->strength[i] = greatest > 0.0 ? self->strength[i] / greatest : 1.0;
}

enum rmap_status rmap_ray_paint_create(const struct rmap_paint_request *request,
                                       struct rmap_ray_paint **paint_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = request->rays->n_row[RMAP_TABLE_RAY];
    struct rmap_ray_paint *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays' colours");
    self->kind = request->kind;
    self->strength = rmap_alloc(n_ray + 1, sizeof *self->strength);
    self->group = rmap_alloc(request->n_criterion + PATHS_SHOWN + 2, sizeof *self->group);
    if (request->kind != RMAP_PAINT_NATURAL)
        self->of_ray = rmap_alloc(n_ray + 1, sizeof *self->of_ray);
    if (!self->strength || !self->group || (request->kind != RMAP_PAINT_NATURAL && !self->of_ray))
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM, "out of memory for the colours of %zu rays", n_ray));
    if (request->kind == RMAP_PAINT_PATH)
        RMAP_TRY(group_by_path(self, request, err));
    if (request->kind == RMAP_PAINT_ORDER)
        RMAP_TRY(group_by_order(self, request, err));
    if (request->kind == RMAP_PAINT_CRITERION)
        RMAP_TRY(group_by_criterion(self, request, err));
    add_up(self, request);
    *paint_ret = self;
    self = NULL;
out:
    rmap_ray_paint_destroy(self);
    return st;
}

void rmap_ray_paint_destroy(struct rmap_ray_paint *self)
{
    if (!self)
        return;
    for (size_t k = 0; self->group && k < self->n_group; k++)
        rmap_free(self->group[k].label);
    rmap_free(self->group);
    rmap_free(self->of_ray);
    rmap_free(self->strength);
    rmap_free(self);
}
