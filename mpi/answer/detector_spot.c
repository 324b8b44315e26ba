/* SPDX-License-Identifier: MIT */
#include "mpi/answer/detector_spot.h"

#include <math.h>

#include "analysis/detector/spot.h"
#include "analysis/table/figure_axes.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

enum { FREQUENCIES = 51, FINER = 8 };

/* A round number. */
static double round_above(double x)
{
    const double below = rmap_round_below(x);
    return x > 1.5 * below ? 2.0 * below : below;
}

/* Collective. A pass over the registrations; the spot on rank 0. */
static enum rmap_status sum_spot(const struct rmap_context *context, struct rmap_spot_ask *ask,
                                 const struct rmap_choice *choice, struct rmap_spot **spot,
                                 struct rmap_error *err)
{
    const struct rmap_fold fold = {.kind = &rmap_spot_sums_kind,
                                   .context = ask,
                                   .map = ask->map,
                                   .criterion = choice->criterion,
                                   .which = choice->which,
                                   .columns = rmap_spot_sums_columns(ask),
                                   .only_detector = 1 + ask->detector,
                                   .overlay = ask->overlay};
    void *state = NULL;
    enum rmap_status st = rmap_fold_run(context, &fold, &state, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_spot_create(state, spot, err);
    fold.kind->destroy(state);
    return rmap_agree(context, st, err);
}

/* Frequencies beyond it are finer than the places that are stored. */
static double finest(const struct rmap_detector *detector)
{
    return 0.25 * 65535.0 / fmax(detector->size[0], detector->size[1]);
}

/* A little stray light far out makes the RMS size many times that of the spot, and frequencies
 * that suit it show nothing: whether the contrast is still high at all of them, in one of the
 * directions, and there are others. */
static bool wants_finer(const struct rmap_spot *spot, const struct rmap_detector *detector)
{
    const size_t n = spot->n_frequency;
    const double next = FINER * spot->frequency_step * (double)(n - 1);
    double least[2] = {1.0, 1.0};
    for (size_t k = 0; k < 2 * n; k++)
        least[k / n] = fmin(least[k / n], spot->mtf[k].value);
    return fmax(least[0], least[1]) > 0.5 && next < finest(detector);
}

/* Collective. The lowest frequencies with a contrast of one half are those of the first passes that
 * have them, whatever frequencies are asked for: a curve of few points would pass them over. */
static enum rmap_status find_half(const struct rmap_context *context, struct rmap_spot_ask *ask,
                                  const struct rmap_choice *choice, bool may_go_on,
                                  struct rmap_spot **spot, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_estimate half[2] = {{(double)NAN, (double)NAN}, {(double)NAN, (double)NAN}};
    int finer = 0;
    do {
        rmap_spot_destroy(*spot);
        *spot = NULL;
        RMAP_TRY(sum_spot(context, ask, choice, spot, err));
        for (int d = 0; d < 2 && *spot; d++) {
            if (isnan(half[d].value))
                half[d] = (*spot)->half[d];
            (*spot)->half[d] = half[d];
        }
        finer =
            *spot && may_go_on &&
            wants_finer(*spot, &rmap_scene_with(ask->map, ask->overlay)->detector[ask->detector]);
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&finer, 1, MPI_INT, 0, context->comm)));
        ask->frequency_step *= FINER;
    } while (finer);
out:
    return st;
}

enum rmap_status rmap_detector_spot_find(const struct rmap_context *context,
                                         const struct rmap_detector_request *request,
                                         const struct rmap_detector_ask *image_ask,
                                         const struct rmap_choice *choice,
                                         const struct rmap_detector_image *image,
                                         struct rmap_spot **spot, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_spot_ask ask = {.map = image_ask->map,
                                .overlay = image_ask->overlay,
                                .detector = image_ask->detector,
                                .bins = image_ask->bins,
                                .n_frequency = request->mtf ? FREQUENCIES : 0,
                                .tangential_rad = 0.5 * RMAP_PI,
                                .moments_alone = request->moments_alone};
    double first[4] = {0.0, 0.0, 0.0, 0.0};
    struct rmap_spot *own = NULL;
    if (context->rank == 0 && isfinite(image->rms_radius)) {
        const double *centre = image->centroid, rms = image->rms_radius;
        first[0] = centre[0];
        first[1] = centre[1];
        first[2] = hypot(centre[0], centre[1]) > rms ? atan2(centre[1], centre[0]) : 0.5 * RMAP_PI;
        if (rms > 0.0) /* a Gaussian's MTF is 0.007 there */
            first[3] = fmin(round_above(0.5 * sqrt(2.0) / rms), finest(image->detector));
    }
    RMAP_TRY(RMAP_MPI(MPI_Bcast(first, 4, MPI_DOUBLE, 0, context->comm)));
    ask.centre[0] = first[0];
    ask.centre[1] = first[1];
    ask.tangential_rad =
        isnan(request->bins.rotate_deg) ? first[2] : ask.bins.rotate_rad + 0.5 * RMAP_PI;
    ask.frequency_step = (first[3] > 0.0 ? first[3] : 1.0) / (FREQUENCIES - 1);
    RMAP_TRY(find_half(context, &ask, choice, request->mtf && first[3] > 0.0, spot, err));
    if (request->frequency > 0.0) {
        ask.frequency_step = request->frequency / (FREQUENCIES - 1);
        RMAP_TRY(sum_spot(context, &ask, choice, &own, err));
    }
    for (int d = 0; d < 2 && own; d++)
        own->half[d] = (*spot)->half[d];
    if (own) {
        rmap_spot_destroy(*spot);
        *spot = own;
    }
    if (*spot)
        (*spot)->which = choice->which;
out:
    return st;
}
