/* SPDX-License-Identifier: MIT
 *
 * What differs between the images of a detector.
 */
#include "mpi/answer/compare_images.h"

#include "mpi/command/find_detector.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/image_scan.h"

/* -1: none. */
static enum rmap_status choose(const struct rmap_compare_samples *samples, const char *name,
                               bool may_be_none, int32_t detector[2], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(samples->map[0], samples->overlay[0]);
    detector[0] = detector[1] = -1;
    if (!name && scene->n_detector != 1) {
        if (!may_be_none)
            st = rmap_error_set(err, RMAP_USAGE,
                                "-o: say which detector's image (--detector NAME), or which number "
                                "(--of X); the scene has %zu detectors",
                                scene->n_detector);
        return st;
    }
    name = name ? name : scene->detector[0].name;
    for (int k = 0; k < 2 && st == RMAP_OK; k++)
        st = rmap_find_detector(rmap_scene_with(samples->map[k], samples->overlay[k]), name,
                                &detector[k], err);
    return st;
}

/* Collective. */
static enum rmap_status add_up(const struct rmap_context *context,
                               const struct rmap_compare_samples *samples, size_t sample,
                               const int32_t detector[2], struct rmap_detector_sums *sums,
                               struct rmap_error *err)
{
    const int k = rmap_compare_map_of(samples, sample);
    struct rmap_detector_ask ask = {
        .map = samples->map[k], .overlay = samples->overlay[k], .detector = detector[k]};
    rmap_detector_bins_own(rmap_scene_with(ask.map, ask.overlay), ask.detector, &ask.bins);
    enum rmap_status st = rmap_detector_sums_init_as(sums, &ask, err);
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t i = 0; i < samples->n_part; i++) {
        const struct rmap_compare_part *part = &samples->part[i];
        const struct rmap_choice choice = {part->criterion, part->which};
        if (part->sample == sample)
            RMAP_TRY(rmap_image_scan(context, ask.map, &choice, sums, err));
    }
out:
    return st;
}

enum rmap_status rmap_compare_images_run(const struct rmap_context *context,
                                         const struct rmap_compare_samples *samples,
                                         const char *name, bool may_be_none,
                                         const struct rmap_comparison *comparison,
                                         struct rmap_compare_bins **bins_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_sums sums[RMAP_COMPARE_SAMPLES] = {{.n_cell = 0}};
    const struct rmap_detector_sums *const all[] = {&sums[0], &sums[1],
                                                    samples->n > 2 ? &sums[2] : NULL};
    int32_t detector[2];
    st = choose(samples, name, may_be_none, detector, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (detector[0] < 0)
        return RMAP_OK;
    for (size_t i = 0; i < samples->n; i++)
        RMAP_TRY(add_up(context, samples, i, detector, &sums[i], err));
    if (context->rank == 0)
        st = rmap_compare_bins_of_images(comparison, all, bins_ret, err);
    st = rmap_agree(context, st, err);
out:
    for (size_t i = 0; i < RMAP_COMPARE_SAMPLES; i++)
        rmap_detector_sums_fini(&sums[i]);
    return st;
}
