/* SPDX-License-Identifier: MIT
 *
 * What a sweep asks of one variant's map.
 */
#include "mpi/sweep/sweep_answers.h"

#include <math.h>
#include <stdio.h>

#include "analysis/detector/detector_image.h"
#include "analysis/detector/spot.h"
#include "base/alloc.h"
#include "io/map/map_content.h"
#include "mpi/answer/detector_request.h"
#include "mpi/answer/detector_spot.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"
#include "mpi/scan/stats_run.h"

static void put(struct rmap_sweep_result *result, double value, double error, const char *unit)
{
    *result = (struct rmap_sweep_result){.value = value, .standard_error = error};
    (void)snprintf(result->unit, sizeof result->unit, "%s", unit);
}

/* Of "registrations": those that the criterion itself chooses, as everywhere. */
static enum rmap_status choose(const struct rmap_scene *scene,
                               const struct rmap_index_set *detector,
                               const struct rmap_criterion *criterion, struct rmap_which **which,
                               struct rmap_error *err)
{
    enum rmap_status st = rmap_which_create(scene, detector, NULL, NULL, criterion, which, err);
    return st == RMAP_OK ? rmap_which_detect(*which, detector, err) : st;
}

/* Collective. *state_ret: on rank 0 the answer by blocks of rays, with what is summed up beside it.
 */
static enum rmap_status fold_parts(const struct rmap_context *context,
                                   struct rmap_sweep_parts_ask *ask, rmap_column_set columns,
                                   const struct rmap_choice *choice, void **state_ret,
                                   struct rmap_error *err)
{
    ask->n_ray = rmap_map_contents(ask->map)->n_row[RMAP_TABLE_RAY];
    const struct rmap_fold fold = {.kind = &rmap_sweep_parts_kind,
                                   .context = ask,
                                   .map = ask->map,
                                   .criterion = choice->criterion,
                                   .which = choice->which,
                                   .columns = columns | rmap_sweep_parts_columns(ask),
                                   .only_detector = ask->bins ? 1 + ask->detector : 0};
    return rmap_fold_run(context, &fold, state_ret, err);
}

static void put_of_image(const struct rmap_sweep_answer *answer,
                         const struct rmap_detector_image *image, struct rmap_sweep_result *result)
{
    const double none = (double)NAN;
    const size_t peak = image->peak_cell[0] + (size_t)image->n[0] * image->peak_cell[1];
    const struct rmap_uniformity *even = image->uniformity;
    const struct rmap_biased *of = answer->of == RMAP_SWEEP_OF_LEAST      ? &even->least
                                   : answer->of == RMAP_SWEEP_OF_GREATEST ? &even->greatest
                                   : answer->of == RMAP_SWEEP_OF_U0       ? &even->u0
                                                                          : &even->ud;
    if (answer->of == RMAP_SWEEP_OF_FLUX)
        put(result, image->flux, image->flux_error, image->flux_unit);
    else if (answer->of == RMAP_SWEEP_OF_MEAN)
        put(result, image->mean, image->mean_error, image->unit);
    else if (answer->of == RMAP_SWEEP_OF_PEAK)
        put(result, image->peak, image->peak > 0.0 ? image->standard_error[peak] : none,
            image->unit);
    else if (answer->of == RMAP_SWEEP_OF_REGISTRATIONS)
        put(result, image->registrations, none, "");
    else
        put(result, of->value, of->standard_error,
            answer->of >= RMAP_SWEEP_OF_U0 ? "" : image->unit);
}

static void put_of_spot(const struct rmap_sweep_answer *answer, const struct rmap_spot *spot,
                        struct rmap_sweep_result *result)
{
    const struct rmap_estimate of = answer->of == RMAP_SWEEP_OF_CENTROID_X   ? spot->centroid[0]
                                    : answer->of == RMAP_SWEEP_OF_CENTROID_Y ? spot->centroid[1]
                                    : answer->of == RMAP_SWEEP_OF_RMS_RADIUS
                                        ? spot->rms_radius
                                        : spot->radius[answer->of - RMAP_SWEEP_OF_RADIUS_50];
    put(result, of.value, of.standard_error, spot->unit);
}

/* Collective. */
static enum rmap_status
ask_detector(const struct rmap_context *context, const struct rmap_sweep_answer *answer,
             const struct rmap_map *map, const struct rmap_criterion *criterion,
             struct rmap_sweep_result *result, double *part, struct rmap_error *err)
{
    const bool is_spot = answer->of >= RMAP_SWEEP_OF_CENTROID_X;
    const struct rmap_detector_request request = {.detector = answer->detector,
                                                  .unit = answer->unit,
                                                  .bins = {.rotate_deg = (double)NAN},
                                                  .spot = is_spot,
                                                  .moments_alone =
                                                      answer->of < RMAP_SWEEP_OF_RADIUS_50};
    struct rmap_detector_ask ask = {.map = map};
    struct rmap_detector_image *image = NULL;
    struct rmap_spot *spot = NULL;
    struct rmap_which *which = NULL;
    void *state = NULL;
    enum rmap_status st = rmap_detector_request_ask(context, &request, map, NULL, &ask, err);
    const struct rmap_index_set detector = {.low = ask.detector, .span = 1};
    if (st == RMAP_OK)
        st = choose(rmap_map_scene(map), &detector, criterion, &which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_choice choice = {criterion, which};
    struct rmap_sweep_parts_ask parts = {.answer = answer,
                                         .map = map,
                                         .detector = ask.detector,
                                         .bins = &ask.bins,
                                         .with = &rmap_detector_sums_kind,
                                         .with_context = &ask};
    RMAP_TRY(fold_parts(context, &parts, rmap_detector_sums_columns(&ask), &choice, &state, err));
    if (state)
        st = rmap_detector_image_create(map, rmap_sweep_parts_with(state), &image, err);
    if (st == RMAP_OK && image && answer->of >= RMAP_SWEEP_OF_LEAST &&
        answer->of <= RMAP_SWEEP_OF_UD)
        st = rmap_detector_image_find_uniformity(image, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (is_spot)
        RMAP_TRY(rmap_detector_spot_find(context, &request, &ask, &choice, image, &spot, err));
    if (spot)
        put_of_spot(answer, spot, result);
    else if (image)
        put_of_image(answer, image, result);
    if (state)
        rmap_sweep_parts_values(state, result->value, part);
out:
    rmap_sweep_parts_kind.destroy(state);
    rmap_spot_destroy(spot);
    rmap_detector_image_destroy(image);
    rmap_which_destroy(which);
    return st;
}

static void put_statistic(const struct rmap_sweep_answer *answer,
                          const struct rmap_quantities *quantities,
                          const struct rmap_stats_group *group, const char *flux_unit,
                          struct rmap_sweep_result *result)
{
    const struct rmap_stats_moment_estimates *m = &group->of[0].moment;
    const struct rmap_stats_estimate of = answer->of == RMAP_SWEEP_THE_MEAN        ? m->mean
                                          : answer->of == RMAP_SWEEP_THE_DEVIATION ? m->deviation
                                          : answer->of == RMAP_SWEEP_THE_SKEWNESS  ? m->skewness
                                          : answer->of == RMAP_SWEEP_THE_KURTOSIS  ? m->kurtosis
                                                                                   : group->flux;
    put(result, of.value, of.standard_error,
        answer->of <= RMAP_SWEEP_THE_DEVIATION ? quantities->of[0].unit
        : answer->of == RMAP_SWEEP_THE_FLUX    ? flux_unit
                                               : "");
}

/* Collective. */
static enum rmap_status
ask_statistic(const struct rmap_context *context, const struct rmap_sweep_answer *answer,
              const struct rmap_map *map, const struct rmap_criterion *criterion,
              struct rmap_sweep_result *result, double *part, struct rmap_error *err)
{
    struct rmap_quantities *quantities = NULL;
    struct rmap_which *which = NULL;
    struct rmap_stats_setup setup;
    struct rmap_stats_answer found = {.stats = NULL};
    void *state = NULL;
    const struct rmap_scene *scene = rmap_map_scene(map);
    enum rmap_status st =
        rmap_quantities_create(map, &answer->number, 1, answer->detector, &quantities, err);
    if (st == RMAP_OK && answer->unit)
        st = rmap_quantity_set_unit(quantities, 0, answer->unit, err);
    if (st == RMAP_OK && quantities->of_registrations)
        st = choose(scene, &quantities->detector, criterion, &which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    rmap_stats_setup_init(&setup, quantities, RMAP_STATS_TOGETHER, RMAP_STATS_BUDGET_NBYTES);
    setup.all_rays = !criterion;
    const struct rmap_stats_request request = {
        .setup = &setup, .criterion = criterion, .which = which};
    RMAP_TRY(rmap_stats_run(context, &request, &found, err));
    if (found.stats)
        put_statistic(answer, quantities, &found.stats->group[0], rmap_flux_unit_name(scene),
                      result);
    const struct rmap_choice choice = {criterion, which};
    struct rmap_sweep_parts_ask parts = {.answer = answer, .map = map, .quantities = quantities};
    if (found.stats)
        parts.about[0] = found.stats->group[0].of[0].moment.mean.value;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(parts.about, 1, MPI_DOUBLE, 0, context->comm)));
    parts.about[0] = isfinite(parts.about[0]) ? parts.about[0] : 0.0;
    RMAP_TRY(fold_parts(context, &parts, 0, &choice, &state, err));
    if (state)
        rmap_sweep_parts_values(state, result->value, part);
out:
    rmap_sweep_parts_kind.destroy(state);
    rmap_stats_answer_fini(&found);
    rmap_which_destroy(which);
    rmap_quantities_destroy(quantities);
    return st;
}

/* Collective. */
static enum rmap_status
ask_count(const struct rmap_context *context, const struct rmap_sweep_answer *answer,
          const struct rmap_map *map, const struct rmap_criterion *criterion,
          struct rmap_sweep_result *result, double *part, struct rmap_error *err)
{
    struct rmap_sweep_parts_ask parts = {.answer = answer, .map = map};
    const struct rmap_choice choice = {criterion, NULL};
    double flux, error;
    void *state = NULL;
    enum rmap_status st = fold_parts(context, &parts, 0, &choice, &state, err);
    if (state) {
        const struct rmap_count *count = rmap_sweep_parts_count(state);
        const double k = (double)count->rays;
        rmap_count_flux(count, map, &flux, &error);
        if (answer->kind == RMAP_SWEEP_FLUX)
            put(result, flux, error, rmap_flux_unit_name(rmap_map_scene(map)));
        else /* binomial */
            put(result, k, sqrt(k * (1.0 - k / (double)parts.n_ray)), "");
        rmap_sweep_parts_values(state, result->value, part);
    }
    rmap_sweep_parts_kind.destroy(state);
    return st;
}

enum rmap_status rmap_sweep_check(const struct rmap_sweep *sweep, const struct rmap_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < sweep->n_answer && st == RMAP_OK; i++) {
        const struct rmap_sweep_answer *answer = &sweep->answer[i];
        struct rmap_criterion *criterion = NULL;
        if (answer->where)
            st = rmap_criterion_compile(answer->where, scene, &criterion, err);
        rmap_criterion_destroy(criterion);
        if (st != RMAP_OK)
            rmap_error_context(err, "%s:%d: answer '%s'", sweep->path, answer->line, answer->name);
    }
    return st;
}

enum rmap_status rmap_sweep_ask(const struct rmap_context *context, const struct rmap_sweep *sweep,
                                const struct rmap_map *map, struct rmap_sweep_result *result,
                                double *part, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion **criterion = rmap_alloc(sweep->n_answer, sizeof(void *));
    size_t i = 0;
    if (!criterion)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the answers");
    for (; i < sweep->n_answer && st == RMAP_OK; i++) {
        const struct rmap_sweep_answer *answer = &sweep->answer[i];
        const bool counts = answer->kind <= RMAP_SWEEP_RAYS;
        if (answer->where || counts)
            st = rmap_criterion_compile(answer->where ? answer->where : "all", rmap_map_scene(map),
                                        &criterion[i], err);
        if (st != RMAP_OK)
            rmap_error_context(err, "%s:%d: answer '%s'", sweep->path, answer->line, answer->name);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    for (i = 0; i < sweep->n_answer && st == RMAP_OK; i++) {
        const struct rmap_sweep_answer *answer = &sweep->answer[i];
        double *its = part + i * RMAP_SWEEP_PARTS;
        for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++)
            its[p] = (double)NAN;
        if (answer->kind <= RMAP_SWEEP_RAYS)
            st = ask_count(context, answer, map, criterion[i], &result[i], its, err);
        if (answer->kind == RMAP_SWEEP_DETECTOR)
            st = ask_detector(context, answer, map, criterion[i], &result[i], its, err);
        if (answer->kind == RMAP_SWEEP_STATISTIC)
            st = ask_statistic(context, answer, map, criterion[i], &result[i], its, err);
        if (st != RMAP_OK)
            rmap_error_context(err, "%s:%d: answer '%s'", sweep->path, answer->line, answer->name);
    }
out:
    for (i = 0; criterion && i < sweep->n_answer; i++)
        rmap_criterion_destroy(criterion[i]);
    rmap_free(criterion);
    return st;
}
