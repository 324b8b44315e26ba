/* SPDX-License-Identifier: MIT
 *
 * Tests of a comparison from the sums of its samples, whatever has the same name in both.
 */
#include <math.h>
#include <string.h>

#include "analysis/compare/compare_internal.h"
#include "base/alloc.h"
#include "portion/event.h"

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
    RMAP_TRY(rmap_comparison_test(self, kind, name, &test, err));
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
    {RMAP_COMPARE_DETECTOR, rmap_names_of_detectors, rmap_compare_detector},
    {RMAP_COMPARE_OBJECT, rmap_names_of_objects, rmap_compare_object},
    {RMAP_COMPARE_MEDIUM, rmap_names_of_media, rmap_compare_medium},
    {RMAP_COMPARE_IMAGE, rmap_names_of_detectors, NULL},
};

/* Everything of one kind that has a name in both maps; one: the only name wanted, or NULL. */
static enum rmap_status add_branch(struct adding *adding, const struct branch *of, const char *one,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_names own = of->names_of(rmap_comparison_scene(adding->self, 0));
    const struct rmap_names other = of->names_of(rmap_comparison_scene(adding->self, 1));
    int32_t *pair = NULL;
    RMAP_TRY(rmap_names_pair(&own, &other, &pair, err));
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
