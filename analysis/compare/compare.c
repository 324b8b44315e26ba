/* SPDX-License-Identifier: MIT
 *
 * A comparison of two samples of rays: tests of everything that can be named in both, corrected
 * for their number, and the outcome.
 */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/compare/compare.h"
#include "analysis/compare/compare_internal.h"
#include "base/alloc.h"
#include "portion/event.h"

static const char *source_name(const struct rmap_scene *scene, size_t i)
{
    return scene->source[i].name;
}

static const char *detector_name(const struct rmap_scene *scene, size_t i)
{
    return scene->detector[i].name;
}

static const char *object_name(const struct rmap_scene *scene, size_t i)
{
    return scene->object[i].name;
}

static const char *medium_name(const struct rmap_scene *scene, size_t i)
{
    return scene->medium[i].name;
}

static struct rmap_names names_of_sources(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "source", scene->n_source, source_name};
}

static struct rmap_names names_of_detectors(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "detector", scene->n_detector, detector_name};
}

static struct rmap_names names_of_objects(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "object", scene->n_object, object_name};
}

static struct rmap_names names_of_media(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "medium", scene->n_medium, medium_name};
}

struct entry {
    const char *name;
    int32_t at;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct entry *)a)->name, ((const struct entry *)b)->name);
}

/* (*pair_ret)[i]: index of name i among those of `other`, or -1. rmap_free. RMAP_SYSTEM. */
static enum rmap_status names_pair(const struct rmap_names *own, const struct rmap_names *other,
                                   int32_t **pair_ret, struct rmap_error *err)
{
    struct entry *entry = rmap_alloc(other->n + 1, sizeof *entry);
    int32_t *pair = rmap_alloc(own->n + 1, sizeof *pair);
    if (!entry || !pair) {
        rmap_free(entry);
        rmap_free(pair);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu names", own->n + other->n);
    }
    for (size_t i = 0; i < other->n; i++)
        entry[i] = (struct entry){other->name(other->scene, i), (int32_t)i};
    qsort(entry, other->n, sizeof *entry, by_name);
    for (size_t i = 0; i < own->n; i++) {
        const struct entry key = {own->name(own->scene, i), 0};
        const struct entry *found = bsearch(&key, entry, other->n, sizeof key, by_name);
        pair[i] = found ? found->at : -1;
    }
    rmap_free(entry);
    *pair_ret = pair;
    return RMAP_OK;
}

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
        RMAP_TRY(names_pair(&own, &other, &pair, err));
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
    const struct rmap_names of_a = names_of_sources(rmap_map_scene(self->map[0]));
    const struct rmap_names of_b = names_of_sources(rmap_map_scene(self->map[1]));
    int32_t *pair[2] = {NULL, NULL};
    size_t n = of_a.n;
    self->strata.stratum = rmap_alloc(of_a.n + of_b.n + 1, sizeof *self->strata.stratum);
    if (!self->strata.stratum)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", of_a.n + of_b.n);
    RMAP_TRY(names_pair(&of_a, &of_b, &pair[0], err));
    RMAP_TRY(names_pair(&of_b, &of_a, &pair[1], err));
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
                              "equal) that criteria picked: compare these in the map that "
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
        names_of_sources, names_of_detectors, names_of_objects, names_of_media};
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

/* Appends an empty test, valid until the next one. */
static enum rmap_status comparison_test(struct rmap_comparison *self, enum rmap_compare_kind kind,
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
    RMAP_TRY(comparison_test(self, kind, name, &test, err));
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

/* Tests of a comparison from the sums of its samples, whatever has the same name in both. */

/* What is at hand while sums become tests. */
struct adding {
    struct rmap_comparison *self;
    const struct rmap_compare_sums *const *sums; /* [3] */
    struct rmap_scalar_sums *scalar;             /* [strata.n] */
    const double **count[2];                     /* [strata.n] */
};

static void add_part(const struct rmap_compare_sums *sums, int32_t source, size_t at, int k,
                     struct rmap_scalar_sums *into)
{
    if (!sums || source < 0)
        return;
    size_t i = (size_t)source * sums->layout->n_scalar + at;
    into->sum[k] += sums->sum[i];
    into->square[k] += sums->square[i];
    into->rays[k] += sums->rays[i];
}

/* at: of the scalar in each map. stratum: the only source; -1: all. */
static enum rmap_status add_scalar(struct adding *adding, enum rmap_compare_kind kind,
                                   const char *name, const size_t at[2], ptrdiff_t stratum,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_comparison *self = adding->self;
    struct rmap_compare_test *test = NULL;
    struct rmap_difference difference;
    for (size_t s = 0; s < self->strata.n; s++) {
        const int32_t *source = self->strata.stratum[s].source;
        adding->scalar[s] = (struct rmap_scalar_sums){0};
        if (stratum >= 0 && (size_t)stratum != s)
            continue;
        add_part(adding->sums[0], source[0], at[0], 0, &adding->scalar[s]);
        add_part(adding->sums[1], source[1], at[1], 1, &adding->scalar[s]);
        add_part(adding->sums[2], source[0], at[0], 2, &adding->scalar[s]);
    }
    rmap_difference_scalar(&self->strata, adding->scalar, &difference);
    if (difference.rays[0] + difference.rays[1] <= 0.0) {
        self->n_empty++;
        return RMAP_OK;
    }
    RMAP_TRY(comparison_test(self, kind, name, &test, err));
    test->scalar = difference;
    test->p = difference.p;
    if (isnan(difference.p))
        test->note = "no error can be given: fewer than 2 rays";
    /* all rays of a source count: by definition as much flux as the scene says */
    else if (difference.standard_error == 0.0 && difference.difference == 0.0) {
        test->p = (double)NAN;
        test->note = "no spread";
    }
out:
    return st;
}

/* Flux of the selection: of all sources, and of each where there are more. */
static enum rmap_status add_flux(struct adding *adding, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t at[2] = {RMAP_COMPARE_SELECTED, RMAP_COMPARE_SELECTED};
    const struct rmap_strata *strata = &adding->self->strata;
    if (strata->n > 1)
        RMAP_TRY(add_scalar(adding, RMAP_COMPARE_FLUX, "", at, -1, err));
    for (size_t s = 0; s < strata->n; s++) {
        int k = strata->stratum[s].source[0] >= 0 ? 0 : 1;
        const struct rmap_source *source =
            &rmap_map_scene(adding->self->map[k])->source[strata->stratum[s].source[k]];
        RMAP_TRY(add_scalar(adding, RMAP_COMPARE_FLUX, source->name, at, (ptrdiff_t)s, err));
    }
out:
    return st;
}

/* The same place, grid and orientation do not matter: a detector may have been moved. */
bool rmap_compare_same_grid(const struct rmap_scene *const scene[2], const size_t detector[2])
{
    const struct rmap_detector *one = &scene[0]->detector[detector[0]];
    const struct rmap_detector *other = &scene[1]->detector[detector[1]];
    bool same = one->type == other->type && one->cells[0] == other->cells[0] &&
                one->cells[1] == other->cells[1];
    for (int i = 0; i < 2 && one->type == RMAP_DETECTOR_PLANE; i++) {
        double x = one->size[i] * scene[0]->unit_m, y = other->size[i] * scene[1]->unit_m;
        same = same && fabs(x - y) <= 1e-9 * fabs(x);
    }
    return same;
}

void rmap_compare_count_both(const struct rmap_compare_sums *sums, size_t detector,
                             struct rmap_chi_square *result)
{
    const struct rmap_compare_layout *layout = sums ? sums->layout : NULL;
    for (size_t s = 0; sums && s < layout->n_source; s++)
        for (size_t c = layout->first_cell[detector]; c < layout->first_cell[detector + 1]; c++)
            for (int k = 0; k < 2; k++)
                result->rays[k] += sums->cell[s * layout->n_cell + c];
}

/* So many merged bins at most where each pair of them needs a number. */
static const double GROUPS_MAX = 150.0;

static enum rmap_status put_off(struct rmap_comparison *self, const size_t detector[2],
                                struct rmap_bins *bins, struct rmap_error *err)
{
    double rays[2] = {0.0, 0.0};
    enum rmap_status st = RMAP_RESERVE(self->again, self->cap_again, self->n_again + 1, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_compare_again again = {.detector = {detector[0], detector[1]},
                                       .group = rmap_alloc(bins->n_bin + 1, sizeof(int32_t))};
    if (!again.group)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", bins->n_bin);
    for (size_t s = 0; s < self->strata.n; s++)
        for (int k = 0; k < 2; k++)
            for (size_t b = 0; b < bins->n_bin && bins->count[k][s]; b++)
                rays[k] += bins->count[k][s][b];
    bins->rays_min = fmin(rays[0], rays[1]) / GROUPS_MAX;
    rmap_difference_merge(&self->strata, bins, false, again.group, &again.n_group);
    self->again[self->n_again++] = again;
    return RMAP_OK;
}

static enum rmap_status add_image(struct adding *adding, const char *name, const size_t detector[2],
                                  struct rmap_error *err)
{
    struct rmap_comparison *self = adding->self;
    const struct rmap_scene *const scene[2] = {rmap_comparison_scene(self, 0),
                                               rmap_comparison_scene(self, 1)};
    const uint32_t *cells = scene[0]->detector[detector[0]].cells;
    struct rmap_chi_square result = {.rays = {(double)NAN, (double)NAN}, .p = (double)NAN};
    struct rmap_bins bins = {.count = {adding->count[0], adding->count[1]},
                             .n_bin = (size_t)cells[0] * cells[1]};
    bool again = false;
    if (!rmap_compare_same_grid(scene, detector))
        return rmap_comparison_add_bins(self, RMAP_COMPARE_IMAGE, name, &result, "its grid differs",
                                        err);
    for (size_t s = 0; s < self->strata.n; s++)
        for (int k = 0; k < 2; k++) {
            const struct rmap_compare_sums *sums = adding->sums[k];
            int32_t source = self->strata.stratum[s].source[k];
            adding->count[k][s] = source < 0 ? NULL
                                             : sums->cell + (size_t)source * sums->layout->n_cell +
                                                   sums->layout->first_cell[detector[k]];
            again = again || sums->repeated[detector[k]] > 0.0;
        }
    if (again)
        return put_off(self, detector, &bins, err);
    enum rmap_status st = rmap_difference_bins(&self->strata, &bins, &result, err);
    rmap_compare_count_both(adding->sums[2], detector[0], &result);
    if (st == RMAP_OK)
        st = rmap_comparison_add_bins(self, RMAP_COMPARE_IMAGE, name, &result, NULL, err);
    return st;
}

/* One kind of things. */
struct branch {
    enum rmap_compare_kind kind;
    struct rmap_names (*names_of)(const struct rmap_scene *scene);
    size_t (*place)(const struct rmap_compare_layout *layout, size_t i);
};

static const struct branch branch[] = {
    {RMAP_COMPARE_DETECTOR, names_of_detectors, rmap_compare_detector},
    {RMAP_COMPARE_OBJECT, names_of_objects, rmap_compare_object},
    {RMAP_COMPARE_MEDIUM, names_of_media, rmap_compare_medium},
    {RMAP_COMPARE_IMAGE, names_of_detectors, NULL},
};

/* Everything of one kind that has a name in both maps; one: the only name wanted, or NULL. */
static enum rmap_status add_branch(struct adding *adding, const struct branch *of, const char *one,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_names own = of->names_of(rmap_comparison_scene(adding->self, 0));
    const struct rmap_names other = of->names_of(rmap_comparison_scene(adding->self, 1));
    int32_t *pair = NULL;
    RMAP_TRY(names_pair(&own, &other, &pair, err));
    for (size_t i = 0; i < own.n; i++) {
        const char *name = own.name(own.scene, i);
        size_t at[2] = {i, (size_t)pair[i]};
        if (pair[i] < 0 || (one && strcmp(name, one) != 0))
            continue;
        for (int k = 0; k < 2 && of->place; k++)
            at[k] = of->place(adding->sums[k]->layout, at[k]);
        RMAP_TRY(of->place ? add_scalar(adding, of->kind, name, at, -1, err)
                           : add_image(adding, name, at, err));
    }
out:
    rmap_free(pair);
    return st;
}

static enum rmap_status add_stops(struct adding *adding, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int stop = 0; stop < RMAP_STOP_COUNT; stop++) {
        const size_t at[2] = {rmap_compare_stop(adding->sums[0]->layout, stop),
                              rmap_compare_stop(adding->sums[1]->layout, stop)};
        RMAP_TRY(add_scalar(adding, RMAP_COMPARE_STOP, rmap_stop_word(stop), at, -1, err));
    }
out:
    return st;
}

enum rmap_status rmap_comparison_add_sums(struct rmap_comparison *self,
                                          const struct rmap_compare_sums *const sums[3],
                                          unsigned kinds, const char *detector,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct adding adding = {.self = self, .sums = sums};
    adding.scalar = rmap_alloc(self->strata.n + 1, sizeof *adding.scalar);
    for (int k = 0; k < 2; k++)
        adding.count[k] = rmap_alloc(self->strata.n + 1, sizeof *adding.count[k]);
    if (!adding.scalar || !adding.count[0] || !adding.count[1]) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", self->strata.n);
        goto out;
    }
    if (kinds & 1u << RMAP_COMPARE_FLUX)
        RMAP_TRY(add_flux(&adding, err));
    for (size_t i = 0; i < sizeof branch / sizeof *branch; i++) {
        if (branch[i].kind == RMAP_COMPARE_IMAGE && kinds & 1u << RMAP_COMPARE_STOP)
            RMAP_TRY(add_stops(&adding, err));
        if (kinds & 1u << branch[i].kind)
            RMAP_TRY(add_branch(&adding, &branch[i], detector, err));
    }
out:
    rmap_free(adding.scalar);
    for (int k = 0; k < 2; k++)
        rmap_free(adding.count[k]);
    return st;
}
