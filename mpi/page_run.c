/* SPDX-License-Identifier: MIT */
#include "mpi/page_run.h"

#include "base/alloc.h"
#include "mpi/agree.h"
#include "mpi/image_scan.h"

/* Detectors whose images are made; each costs a scan when there is a criterion. */
enum { MOST_IMAGES = 16 };

/* Collective. *image_ret: on rank 0. */
static enum rmap_status make_image(const struct rmap_context *context,
                                   const struct rmap_criterion *criterion,
                                   const struct rmap_map *map, int32_t detector,
                                   struct rmap_detector_image **image_ret, struct rmap_error *err)
{
    struct rmap_detector_sums sums = {0};
    enum rmap_status st = rmap_detector_sums_init(&sums, map, detector, false, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (criterion)
        RMAP_TRY(rmap_image_scan(context, map, criterion, &sums, err));
    else
        rmap_detector_sums_add_tally(&sums, rmap_map_tally(map));
    if (context->rank == 0)
        st = rmap_detector_image_create(map, &sums, image_ret, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_detector_sums_fini(&sums);
    return st;
}

enum rmap_status rmap_page_run(const struct rmap_context *context,
                               const struct rmap_criterion *criterion, struct rmap_page *page,
                               const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_image *image[MOST_IMAGES] = {NULL};
    size_t n = rmap_map_scene(page->map)->n_detector;
    n = n < MOST_IMAGES ? n : MOST_IMAGES;
    for (size_t d = 0; d < n; d++)
        RMAP_TRY(make_image(context, criterion, page->map, (int32_t)d, &image[d], err));
    page->n_image = n;
    page->image = image;
    if (context->rank == 0)
        st = rmap_page_write(page, path, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    page->n_image = 0;
    page->image = NULL;
    for (size_t d = 0; d < n; d++)
        rmap_detector_image_destroy(image[d]);
    return st;
}
