/* SPDX-License-Identifier: MIT
 *
 * Distributions for a comparison: of classes of paths, and of any number.
 */
#include "mpi/answer/compare_fields.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

/* Without a wish: fine bins of about as many readings each, merged into some that hold about as
 * many rays each. Neither a long tail nor a narrow spot then leaves all others in one bin. */
enum { FINE_BINS = 1000, MERGED_BINS = 50, WHOLE_MAX = 200, SOURCES_FEW = 16 };

/* Collective. */
static enum rmap_status run(const struct rmap_context *context,
                            const struct rmap_compare_samples *samples,
                            const struct rmap_compare_field_plan plan[2],
                            void *field[RMAP_COMPARE_SAMPLES], struct rmap_error *err)
{
    const bool of_registrations = plan[0].quantities && plan[0].quantities->of_registrations;
    const struct rmap_compare_sum sum = {
        .kind = &rmap_compare_field_kind,
        .context = {&plan[0], &plan[1]},
        .alone = of_registrations ? &plan[0] : NULL,
        .columns = {rmap_compare_field_columns(&plan[0]), rmap_compare_field_columns(&plan[1])},
        .n_sample = RMAP_COMPARE_SAMPLES};
    return rmap_compare_samples_run(context, samples, &sum, field, err);
}

static void release(void *field[RMAP_COMPARE_SAMPLES])
{
    for (int i = 0; i < RMAP_COMPARE_SAMPLES; i++) {
        rmap_compare_field_kind.destroy(field[i]);
        field[i] = NULL;
    }
}

/* Collective. Scans, and on rank 0 adds the test. */
static enum rmap_status run_and_add(const struct rmap_context *context,
                                    const struct rmap_compare_samples *samples,
                                    const struct rmap_compare_field_plan plan[2],
                                    enum rmap_compare_kind kind, const char *name,
                                    struct rmap_comparison *comparison,
                                    struct rmap_compare_bins **bins_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *field[RMAP_COMPARE_SAMPLES] = {NULL, NULL, NULL};
    RMAP_TRY(run(context, samples, plan, field, err));
    const struct rmap_compare_field *const fields[] = {field[0], field[1], field[2]};
    if (context->rank == 0)
        st = rmap_comparison_add_field(comparison, kind, name, fields, err);
    if (context->rank == 0 && st == RMAP_OK && bins_ret)
        st = rmap_compare_bins_of_field(comparison, name, fields, bins_ret, err);
    st = rmap_agree(context, st, err);
out:
    release(field);
    return st;
}

enum rmap_status rmap_compare_paths_run(const struct rmap_context *context,
                                        const struct rmap_compare_samples *samples,
                                        struct rmap_comparison *comparison, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compare_field_plan plan[2] = {{0}, {0}};
    for (int k = 0; k < 2 && st == RMAP_OK; k++)
        st = rmap_compare_paths_plan(&plan[k], samples->map[k], err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = run_and_add(context, samples, plan, RMAP_COMPARE_PATHS, "", comparison, NULL, err);
out:
    for (int k = 0; k < 2; k++)
        rmap_compare_field_plan_fini(&plan[k]);
    return st;
}

/* Collective. Least and largest reading of both samples, on every rank. */
static enum rmap_status find_extent(const struct rmap_context *context,
                                    const struct rmap_compare_samples *samples,
                                    struct rmap_quantities *const of[2], double range[2],
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compare_field_plan plan[2] = {{0}, {0}};
    void *field[RMAP_COMPARE_SAMPLES] = {NULL, NULL, NULL};
    range[0] = HUGE_VAL;
    range[1] = -HUGE_VAL;
    for (int k = 0; k < 2; k++)
        RMAP_TRY(rmap_compare_number_plan(&plan[k], of[k], 0, 0.0, 0.0, err));
    RMAP_TRY(run(context, samples, plan, field, err));
    for (size_t i = 0; i < samples->n && context->rank == 0; i++) {
        const struct rmap_compare_field *one = field[i];
        range[0] = fmin(range[0], one->extent[0]);
        range[1] = fmax(range[1], one->extent[1]);
    }
    st = RMAP_MPI(MPI_Bcast(range, 2, MPI_DOUBLE, 0, context->comm));
out:
    release(field);
    for (int k = 0; k < 2; k++)
        rmap_compare_field_plan_fini(&plan[k]);
    return st;
}

/* Bins of their own for whole numbers, as long as those are few. 0: to be cut. */
static size_t choose_bins(const struct rmap_quantities *of, size_t wanted, double range[2])
{
    double span = range[1] - range[0];
    if (wanted == 0 && of->of[0].is_whole && span < WHOLE_MAX) {
        range[0] = ceil(range[0]) - 0.5;
        range[1] = floor(range[1]) + 0.5;
        return (size_t)fmax(range[1] - range[0], 1.0);
    }
    if (!(span > 0.0))
        range[1] = range[0] + fmax(fabs(range[0]), 1.0) * 1e-6;
    return wanted;
}

/* Collective. The cut by the readings of both samples, on every rank (rmap_free). */
static enum rmap_status make_cut(const struct rmap_context *context,
                                 const struct rmap_compare_samples *samples,
                                 struct rmap_quantities *const of[2], const double range[2],
                                 struct rmap_compare_cut **cut_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compare_field_plan plan[2] = {{0}, {0}};
    void *field[RMAP_COMPARE_SAMPLES] = {NULL, NULL, NULL};
    const size_t n_source = of[0]->scene->n_source;
    struct rmap_compare_cut *cut = rmap_alloc(1, sizeof *cut);
    if (!cut)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the bins of a number");
    for (int k = 0; k < 2 && st == RMAP_OK; k++)
        st = rmap_compare_cut_plan(&plan[k], of[k], NULL, range[0], range[1], err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(run(context, samples, plan, field, err));
    if (context->rank == 0) {
        double *count = ((struct rmap_compare_field *)field[0])->count + 1;
        const double *more = ((struct rmap_compare_field *)field[1])->count + 1;
        for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++)
            count[c] += more[c];
        rmap_compare_cut_make(cut, count, n_source <= SOURCES_FEW ? FINE_BINS : FINE_BINS / 4);
    }
    RMAP_TRY(RMAP_MPI(MPI_Bcast(cut, (int)sizeof *cut, MPI_BYTE, 0, context->comm)));
    *cut_ret = cut;
    cut = NULL;
out:
    release(field);
    for (int k = 0; k < 2; k++)
        rmap_compare_field_plan_fini(&plan[k]);
    rmap_free(cut);
    return st;
}

static enum rmap_status create_both(const struct rmap_compare_samples *samples,
                                    const struct rmap_compare_number *number,
                                    struct rmap_quantities *of[2], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int k = 0; k < 2; k++)
        RMAP_TRY(rmap_quantities_create_over(samples->map[k], samples->overlay[k], &number->of, 1,
                                             number->detector, &of[k], err));
    if (strcmp(of[0]->of[0].unit, of[1]->of[0].unit) != 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s is in %s in one map and in %s in the other",
                            number->of, of[0]->of[0].unit, of[1]->of[0].unit);
out:
    return st;
}

enum rmap_status rmap_compare_number_run(const struct rmap_context *context,
                                         const struct rmap_compare_samples *samples,
                                         const struct rmap_compare_number *number,
                                         struct rmap_comparison *comparison,
                                         struct rmap_compare_bins **bins_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_quantities *of[2] = {NULL, NULL};
    struct rmap_compare_field_plan plan[2] = {{0}, {0}};
    struct rmap_compare_cut *cut = NULL;
    double range[2] = {0.0, 0.0};
    st = create_both(samples, number, of, err);
    if (st == RMAP_OK && number->range)
        st = rmap_quantity_range(of[0], 0, number->range, "--range", range, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (!number->range)
        RMAP_TRY(find_extent(context, samples, of, range, err));
    if (range[0] > range[1]) { /* no reading at all: empty bins, where they are wanted */
        range[0] = 0.0;
        range[1] = 1.0;
        comparison->n_empty += bins_ret ? 0 : 1;
        if (!bins_ret)
            goto out;
    }
    const size_t n_bin = choose_bins(of[0], number->n_bin, range);
    if (n_bin == 0)
        RMAP_TRY(make_cut(context, samples, of, range, &cut, err));
    for (int k = 0; k < 2 && st == RMAP_OK; k++) {
        st = cut ? rmap_compare_cut_plan(&plan[k], of[k], cut, range[0], range[1], err)
                 : rmap_compare_number_plan(&plan[k], of[k], n_bin, range[0], range[1], err);
        plan[k].n_merged = cut ? MERGED_BINS : 0;
    }
    RMAP_TRY(rmap_agree(context, st, err));
    st = run_and_add(context, samples, plan, RMAP_COMPARE_NUMBER, number->of, comparison, bins_ret,
                     err);
out:
    for (int k = 0; k < 2; k++) {
        rmap_compare_field_plan_fini(&plan[k]);
        rmap_quantities_destroy(of[k]);
    }
    rmap_free(cut);
    return st;
}
