/* SPDX-License-Identifier: MIT
 *
 * The page of `raymap draw -o x.html`: images of the detectors from every rank, the page from one.
 */
#include "mpi/answer/page_run.h"

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/image_scan.h"
#include "mpi/scan/path_run.h"

/* Detectors whose images are made; each costs a scan when there is a criterion. */
enum { MOST_IMAGES = 16 };

/* Where the sums kept during the trace do not do: receivers have none, and on a plane a ray may be
 * registered several times, which errors must know; reading the largest maps for that takes too
 * long. */
static const uint64_t SEGMENTS_SCANNED = 100000000;

static bool needs_scan(const struct rmap_page *page, int32_t detector)
{
    struct rmap_map_summary summary;
    if (page->overlay && (size_t)detector >= rmap_overlay_first(page->overlay))
        return true;
    rmap_map_summarise(page->map, &summary);
    return rmap_map_scene(page->map)->detector[detector].type == RMAP_DETECTOR_PLANE &&
           summary.n_row[RMAP_TABLE_SEGMENT] < SEGMENTS_SCANNED;
}

/* Collective. *image_ret: on rank 0. */
static enum rmap_status make_image(const struct rmap_context *context,
                                   const struct rmap_criterion *criterion,
                                   const struct rmap_page *page, int32_t detector,
                                   struct rmap_detector_image **image_ret, struct rmap_error *err)
{
    struct rmap_detector_sums sums = {0};
    const struct rmap_map *map = page->map;
    const struct rmap_index_set only = {.low = detector, .span = 1};
    struct rmap_which *which = NULL;
    struct rmap_detector_ask ask = {.map = map, .overlay = page->overlay, .detector = detector};
    rmap_detector_bins_own(rmap_scene_with(map, page->overlay), detector, &ask.bins);
    enum rmap_status st = rmap_detector_sums_init_as(&sums, &ask, err);
    if (st == RMAP_OK)
        st = rmap_page_which(page, &only, &which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (criterion || needs_scan(page, detector))
        RMAP_TRY(
            rmap_image_scan(context, map, &(struct rmap_choice){criterion, which}, &sums, err));
    else
        rmap_detector_sums_add_tally(&sums, rmap_map_tally(map));
    if (context->rank == 0)
        st = rmap_detector_image_create(map, &sums, image_ret, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_which_destroy(which);
    rmap_detector_sums_fini(&sums);
    return st;
}

/* Collective. Classes of the paths of all matching rays, on rank 0. */
static enum rmap_status find_paths(const struct rmap_context *context,
                                   const struct rmap_criterion *criterion,
                                   const struct rmap_page *page, struct rmap_path_keys **keys_ret,
                                   struct rmap_path_report **report_ret, struct rmap_error *err)
{
    struct rmap_path_request request = {.map = page->map,
                                        .overlay = page->overlay,
                                        .criterion = criterion,
                                        .view = {.level = page->level, .detector = -1},
                                        .top = RMAP_PAGE_MOST_CLASSES,
                                        .most_classes = RMAP_PATH_CLASSES_MOST};
    enum rmap_status st = rmap_path_keys_create(rmap_scene_with(page->map, page->overlay),
                                                &request.view, keys_ret, err);
    RMAP_TRY(rmap_agree(context, st, err));
    request.keys = *keys_ret;
    st = rmap_path_run(context, &request, report_ret, err);
out:
    return st;
}

enum rmap_status rmap_page_run(const struct rmap_context *context,
                               const struct rmap_criterion *criterion, struct rmap_page *page,
                               const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_image *image[MOST_IMAGES] = {NULL};
    struct rmap_path_keys *keys = NULL;
    struct rmap_path_report *report = NULL;
    size_t n = 0;
    if (page->parts & RMAP_PAGE_DETECTORS)
        n = rmap_scene_with(page->map, page->overlay)->n_detector;
    n = n < MOST_IMAGES ? n : MOST_IMAGES;
    for (size_t d = 0; d < n; d++)
        RMAP_TRY(make_image(context, criterion, page, (int32_t)d, &image[d], err));
    if (page->parts & RMAP_PAGE_RAYS)
        RMAP_TRY(find_paths(context, criterion, page, &keys, &report, err));
    page->paths = report;
    page->n_image = n;
    page->image = image;
    if (context->rank == 0)
        st = rmap_page_write(page, path, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    page->n_image = 0;
    page->image = NULL;
    page->paths = NULL;
    rmap_path_report_destroy(report);
    rmap_path_keys_destroy(keys);
    for (size_t d = 0; d < n; d++)
        rmap_detector_image_destroy(image[d]);
    return st;
}
