/* SPDX-License-Identifier: MIT
 *
 * Where the rays of a map of a query come from: which questions picked them, out of which map, and
 * how many rays that map had, over which the flux of its sources stays shared out.
 */
#include "io/map/selection.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/hdf5/h5.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"

enum rmap_status rmap_selection_create(size_t n_source, struct rmap_selection **selection_ret,
                                       struct rmap_error *err)
{
    struct rmap_selection *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->emitted = rmap_alloc(n_source, sizeof *self->emitted);
    if (!self || !self->emitted) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for where rays come from");
    }
    self->n_source = n_source;
    *selection_ret = self;
    return RMAP_OK;
}

static void step_fini(struct rmap_selection_step *step)
{
    rmap_free(step->map);
    rmap_free(step->criterion);
    rmap_free(step->answer);
}

void rmap_selection_destroy(struct rmap_selection *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n; i++)
        step_fini(&self->step[i]);
    rmap_free(self->step);
    rmap_free(self->emitted);
    rmap_free(self);
}

enum rmap_status rmap_selection_add(struct rmap_selection *self,
                                    const struct rmap_selection_step *step, struct rmap_error *err)
{
    struct rmap_selection_step copy = {.part = step->part,
                                       .map = rmap_strdup(step->map),
                                       .criterion = rmap_strdup(step->criterion),
                                       .answer = rmap_strdup(step->answer)};
    struct rmap_selection_step *list = rmap_realloc(self->step, self->n + 1, sizeof *list);
    if (list)
        self->step = list;
    if (!list || !copy.map || !copy.criterion || !copy.answer) {
        step_fini(&copy);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for where rays come from");
    }
    self->step[self->n++] = copy;
    return RMAP_OK;
}

enum rmap_status rmap_selection_ask(struct rmap_selection *self,
                                    const struct rmap_selection_step *step, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_selection_step one = *step;
    int32_t n_part = 1;
    for (size_t i = 0; i < self->n; i++)
        n_part = self->step[i].part >= n_part ? self->step[i].part + 1 : n_part;
    for (one.part = 0; st == RMAP_OK && one.part < n_part; one.part++)
        st = rmap_selection_add(self, &one, err);
    return st;
}

enum rmap_status rmap_selection_copy(const struct rmap_selection *from,
                                     struct rmap_selection **selection_ret, struct rmap_error *err)
{
    struct rmap_selection *self = NULL;
    enum rmap_status st = rmap_selection_create(from->n_source, &self, err);
    for (size_t i = 0; st == RMAP_OK && i < from->n; i++)
        st = rmap_selection_add(self, &from->step[i], err);
    if (st != RMAP_OK) {
        rmap_selection_destroy(self);
        return st;
    }
    memcpy(self->digest, from->digest, sizeof self->digest);
    self->complete = from->complete;
    self->n_ray = from->n_ray;
    for (size_t s = 0; s < from->n_source; s++)
        self->emitted[s] = from->emitted[s];
    *selection_ret = self;
    return RMAP_OK;
}

bool rmap_selection_same_origin(const struct rmap_selection *a, const struct rmap_selection *b)
{
    return strcmp(a->digest, b->digest) == 0 && a->n_ray == b->n_ray &&
           a->n_source == b->n_source &&
           memcmp(a->emitted, b->emitted, a->n_source * sizeof *a->emitted) == 0;
}

static const struct rmap_h5_unit one = {"1", 1.0, {0}};

static enum rmap_status write_texts(struct rmap_h5 *h5, const struct rmap_selection *self,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char **text = rmap_alloc(3 * self->n, sizeof *text);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for where rays come from");
    const char **map = text, **criterion = text + self->n, **answer = text + 2 * self->n;
    for (size_t i = 0; i < self->n; i++) {
        map[i] = self->step[i].map;
        criterion[i] = self->step[i].criterion;
        answer[i] = self->step[i].answer;
    }
    RMAP_TRY(
        rmap_h5_write_names(h5, "/selection/map", map, self->n, "the map that was asked", err));
    RMAP_TRY(rmap_h5_write_names(h5, "/selection/criterion", criterion, self->n,
                                 "what its rays had to match", err));
    RMAP_TRY(rmap_h5_write_names(h5, "/selection/answer", answer, self->n,
                                 "how many of those: all, the first ones, or a sample", err));
out:
    rmap_free(text);
    return st;
}

enum rmap_status rmap_selection_write(struct rmap_h5 *h5, const struct rmap_selection *self,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    static const struct rmap_h5_field part = {"/selection/part", RMAP_I32, 1,
                                              offsetof(struct rmap_selection_step, part),
                                              "which of the maps that were merged; 0: none were"};
    const struct rmap_h5_array emitted = {"/selection/emitted",
                                          RMAP_F64,
                                          1,
                                          {self->n_source},
                                          one,
                                          "rays of the traced map, per "
                                          "source"};
    RMAP_TRY(rmap_h5_group(h5, "/selection", err));
    RMAP_TRY(rmap_h5_put_text(h5, "/selection", "digest", self->digest, err));
    RMAP_TRY(rmap_h5_put(h5, "/selection", "rays", RMAP_U64, 1, &self->n_ray, err));
    RMAP_TRY(rmap_h5_put(h5, "/selection", "complete", RMAP_I32, 1, &self->complete, err));
    RMAP_TRY(rmap_h5_write(h5, &emitted, self->emitted, err));
    RMAP_TRY(rmap_h5_write_fields(h5, &part, 1, self->step, self->n, sizeof *self->step, err));
    RMAP_TRY(write_texts(h5, self, err));
out:
    return st;
}

/* [n] texts. */
struct texts {
    char *text;
    size_t n, width;
};

static enum rmap_status read_steps(struct rmap_h5 *h5, struct rmap_selection *self,
                                   struct rmap_error *err)
{
    static const char *const path[3] = {"/selection/map", "/selection/criterion",
                                        "/selection/answer"};
    enum rmap_status st = RMAP_OK;
    struct texts list[3] = {{0}};
    void *part = NULL;
    hsize_t n = 0;
    RMAP_TRY(rmap_h5_read(h5, "/selection/part", RMAP_I32, 1, &n, &part, err));
    for (int k = 0; k < 3; k++) {
        RMAP_TRY(rmap_h5_read_names(h5, path[k], &list[k].text, &list[k].n, &list[k].width, err));
        if (list[k].n != n)
            RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: /selection makes no sense", h5->path));
    }
    for (size_t i = 0; i < n; i++) {
        const struct rmap_selection_step step = {.part = ((int32_t *)part)[i],
                                                 .map = list[0].text + i * list[0].width,
                                                 .criterion = list[1].text + i * list[1].width,
                                                 .answer = list[2].text + i * list[2].width};
        RMAP_TRY(rmap_selection_add(self, &step, err));
    }
out:
    for (int k = 0; k < 3; k++)
        rmap_free(list[k].text);
    rmap_free(part);
    return st;
}

static bool good_counts(const double *emitted, size_t n)
{
    bool good = true;
    for (size_t s = 0; s < n; s++)
        good = good && isfinite(emitted[s]) && emitted[s] >= 0.0;
    return good;
}

enum rmap_status rmap_selection_read(struct rmap_h5 *h5, size_t n_source,
                                     struct rmap_selection **selection_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_selection *self = NULL;
    void *emitted = NULL;
    hsize_t n = n_source;
    *selection_ret = NULL;
    if (!rmap_h5_has(h5, "/selection"))
        return RMAP_OK;
    RMAP_TRY(rmap_selection_create(n_source, &self, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/selection", "digest", self->digest, sizeof self->digest, err));
    RMAP_TRY(rmap_h5_get(h5, "/selection", "rays", RMAP_U64, 1, &self->n_ray, err));
    RMAP_TRY(rmap_h5_get(h5, "/selection", "complete", RMAP_I32, 1, &self->complete, err));
    RMAP_TRY(rmap_h5_read(h5, "/selection/emitted", RMAP_F64, 1, &n, &emitted, err));
    if (n != n_source || !good_counts(emitted, n_source))
        RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: /selection/emitted does not fit the scene",
                                h5->path));
    memcpy(self->emitted, emitted, n_source * sizeof *self->emitted);
    RMAP_TRY(read_steps(h5, self, err));
    *selection_ret = self;
    self = NULL;
out:
    rmap_selection_destroy(self);
    rmap_free(emitted);
    return st;
}
