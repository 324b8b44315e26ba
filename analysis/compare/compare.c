/* SPDX-License-Identifier: MIT */
#include "analysis/compare/compare.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/compare/compare_internal.h"
#include "base/alloc.h"

const char *const rmap_compare_word[RMAP_COMPARE_KIND_COUNT + 1] = {
    "flux", "detector", "object", "medium", "stop", "image", "paths", "number", NULL};

static enum rmap_status add_only(struct rmap_comparison *self, int k, const char *what,
                                 const char *name, struct rmap_error *err)
{
    char text[600];
    enum rmap_status st = RMAP_RESERVE(self->only[k], self->cap_only[k], self->n_only[k] + 1, err);
    if (st != RMAP_OK)
        return st;
    (void)snprintf(text, sizeof text, "%s %s", what, name);
    char *copy = rmap_strdup(text);
    if (!copy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    self->only[k][self->n_only[k]++] = copy;
    return RMAP_OK;
}

/* Names that one map has and the other has not. */
static enum rmap_status find_alone(struct rmap_comparison *self,
                                   struct rmap_names (*names_of)(const struct rmap_scene *),
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t *pair = NULL;
    for (int k = 0; k < 2; k++) {
        const struct rmap_names own = names_of(rmap_comparison_scene(self, k));
        const struct rmap_names other = names_of(rmap_comparison_scene(self, 1 - k));
        RMAP_TRY(rmap_names_pair(&own, &other, &pair, err));
        for (size_t i = 0; i < own.n; i++)
            if (pair[i] < 0)
                RMAP_TRY(add_only(self, k, own.what, own.name(own.scene, i), err));
        rmap_free(pair);
        pair = NULL;
    }
out:
    rmap_free(pair);
    return st;
}

/* Sources of both maps, by name; then those of the second alone. */
static enum rmap_status pair_sources(struct rmap_comparison *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_names of_a = rmap_names_of_sources(rmap_map_scene(self->map[0]));
    const struct rmap_names of_b = rmap_names_of_sources(rmap_map_scene(self->map[1]));
    int32_t *pair[2] = {NULL, NULL};
    size_t n = of_a.n;
    self->strata.stratum = rmap_alloc(of_a.n + of_b.n + 1, sizeof *self->strata.stratum);
    if (!self->strata.stratum)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", of_a.n + of_b.n);
    RMAP_TRY(rmap_names_pair(&of_a, &of_b, &pair[0], err));
    RMAP_TRY(rmap_names_pair(&of_b, &of_a, &pair[1], err));
    for (size_t s = 0; s < of_a.n; s++) {
        self->strata.stratum[s].source[0] = (int32_t)s;
        self->strata.stratum[s].source[1] = pair[0][s];
    }
    for (size_t s = 0; s < of_b.n; s++)
        if (pair[1][s] < 0) {
            self->strata.stratum[n].source[0] = -1;
            self->strata.stratum[n++].source[1] = (int32_t)s;
        }
    self->strata.n = n;
    if (n == of_a.n + of_b.n)
        st =
            rmap_error_set(err, RMAP_INPUT,
                           "the maps have no source of the same name: there is nothing to compare");
out:
    rmap_free(pair[0]);
    rmap_free(pair[1]);
    return st;
}

static void fill_strata(struct rmap_comparison *self)
{
    bool same_rays = self->overlap.same_scene && self->overlap.rays > 0 && !self->strata.paired;
    struct rmap_map_summary summary;
    rmap_map_summarise(self->map[0], &summary);
    double part = (double)self->overlap.rays / fmax((double)summary.n_row[RMAP_TABLE_RAY], 1.0);
    for (size_t s = 0; s < self->strata.n; s++) {
        struct rmap_stratum *stratum = &self->strata.stratum[s];
        for (int k = 0; k < 2; k++) {
            int32_t source = stratum->source[k];
            stratum->emitted[k] = source >= 0 ? rmap_map_emitted(self->map[k])[source] : 0.0;
            stratum->unit[k] = source >= 0 ? rmap_map_flux_per_weight(self->map[k])[source] : 0.0;
        }
        stratum->shared = same_rays ? part * stratum->emitted[0] : 0.0;
    }
}

/* What makes a comparison of two maps meaningless. */
static enum rmap_status check_maps(const struct rmap_comparison *self, struct rmap_error *err)
{
    const struct rmap_scene *a = rmap_map_scene(self->map[0]), *b = rmap_map_scene(self->map[1]);
    bool picked = rmap_map_selection(self->map[0]) || rmap_map_selection(self->map[1]);
    const char *const *criterion = self->criterion;
    bool other = criterion[0] && criterion[1] ? strcmp(criterion[0], criterion[1]) != 0
                                              : criterion[0] != criterion[1];
    if (a->flux_unit != b->flux_unit)
        return rmap_error_set(err, RMAP_INPUT,
                              "the flux of one map is in W and that of the other in lm: they "
                              "cannot be compared");
    if (self->overlap.rays > 0 && self->overlap.same_scene && (picked || other))
        return rmap_error_set(err, RMAP_INPUT,
                              "both maps hold rays of one and the same trace (seed and scene are "
                              "equal), picked by different criteria: compare these in the map that "
                              "was traced, compare MAP --where A --where B");
    return RMAP_OK;
}

enum rmap_status rmap_comparison_create(const struct rmap_map *const map[2],
                                        const struct rmap_overlay *const overlay[2],
                                        const char *const path[2], const char *const criterion[2],
                                        struct rmap_comparison **comparison_ret,
                                        struct rmap_error *err)
{
    struct rmap_names (*const names_of[])(const struct rmap_scene *) = {
        rmap_names_of_sources, rmap_names_of_detectors, rmap_names_of_objects, rmap_names_of_media};
    enum rmap_status st = RMAP_OK;
    struct rmap_comparison *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a comparison");
    for (int k = 0; k < 2; k++) {
        self->map[k] = map[k];
        self->overlay[k] = overlay[k];
        self->path[k] = path[k];
        self->criterion[k] = criterion[k];
    }
    self->strata.paired = map[0] == map[1];
    if (!self->strata.paired) {
        RMAP_TRY(rmap_compare_overlap(self->map, &self->overlap, err));
        RMAP_TRY(check_maps(self, err));
        for (size_t i = 0; i < sizeof names_of / sizeof *names_of; i++)
            RMAP_TRY(find_alone(self, names_of[i], err));
    }
    RMAP_TRY(pair_sources(self, err));
    fill_strata(self);
    *comparison_ret = self;
    self = NULL;
out:
    rmap_comparison_destroy(self);
    return st;
}

void rmap_comparison_destroy(struct rmap_comparison *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n; i++)
        rmap_free(self->test[i].name);
    rmap_free(self->test);
    for (size_t i = 0; i < self->n_again; i++)
        rmap_free(self->again[i].group);
    rmap_free(self->again);
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < self->n_only[k]; i++)
            rmap_free(self->only[k][i]);
        rmap_free(self->only[k]);
    }
    rmap_free(self->strata.stratum);
    rmap_free(self);
}

enum rmap_status rmap_comparison_test(struct rmap_comparison *self, enum rmap_compare_kind kind,
                                      const char *name, struct rmap_compare_test **test_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(self->test, self->cap, self->n + 1, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_compare_test *test = &self->test[self->n];
    *test = (struct rmap_compare_test){.kind = kind,
                                       .name = rmap_strdup(name),
                                       .p = (double)NAN,
                                       .adjusted = (double)NAN,
                                       .same = true};
    if (!test->name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a test's name");
    self->n++;
    *test_ret = test;
    return RMAP_OK;
}

enum rmap_status rmap_comparison_add_bins(struct rmap_comparison *self, enum rmap_compare_kind kind,
                                          const char *name, const struct rmap_chi_square *result,
                                          const char *note, struct rmap_error *err)
{
    struct rmap_compare_test *test = NULL;
    enum rmap_status st = RMAP_OK;
    if (result->rays[0] + result->rays[1] <= 0.0) {
        self->n_empty++;
        return RMAP_OK;
    }
    RMAP_TRY(rmap_comparison_test(self, kind, name, &test, err));
    test->is_bins = true;
    test->bins = *result;
    test->p = result->p;
    test->note = note;
    if (!note && isnan(result->p))
        test->note = "too few rays";
out:
    return st;
}

/* A distribution of less freedom agrees that well by chance soon. */
static const double DEGREES_MIN = 5.0;

enum rmap_status rmap_comparison_conclude(struct rmap_comparison *self, double significance,
                                          enum rmap_correction correction, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double *p = rmap_alloc(2 * self->n + 1, sizeof *p), least = 1.0;
    size_t n_bins = 0;
    if (!p)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu tests", self->n);
    self->significance = significance;
    self->correction = correction;
    self->same = true;
    for (size_t i = 0; i < self->n; i++)
        p[i] = self->test[i].p;
    RMAP_TRY(rmap_significance_correct(correction, p, self->n, p + self->n, err));
    for (size_t i = 0; i < self->n; i++) {
        struct rmap_compare_test *test = &self->test[i];
        test->adjusted = p[self->n + i];
        test->same = !(test->adjusted < significance);
        self->same = self->same && test->same;
        if (test->is_bins && test->bins.degrees >= DEGREES_MIN && !isnan(test->p)) {
            n_bins++;
            least = fmin(least, 1.0 - test->p);
        }
    }
    /* the same rays twice are no surprise */
    self->too_equal =
        self->overlap.rays == 0 && n_bins > 0 && least * (double)n_bins < significance;
out:
    rmap_free(p);
    return st;
}
