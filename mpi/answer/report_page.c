/* SPDX-License-Identifier: MIT
 *
 * raymap report MAP --html: a page about a whole map.
 */
#include "mpi/answer/report_page.h"

#include <stdlib.h>
#include <string.h>

#include "analysis/figure/figure_draw.h"
#include "analysis/report/run_report.h"
#include "base/alloc.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/asked.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/map_name.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/energy_run.h"
#include "mpi/scan/image_scan.h"
#include "mpi/scan/path_run.h"
#include "mpi/scan/scan.h"

/* Rays of the scene's picture; segments of a map that is not read as a whole for a page, paths that
 * it lists, and rays that they are then estimated from. */
enum { DRAWN = 300, LARGE_SEGMENTS = 100000000, PATHS = 20, SAMPLED = 20000 };
enum { MOST_SAMPLED = 10000000 };

static const char *const suffixes[] = {".html", ".htm", NULL};

/* What a page is made of. */
struct page {
    struct rmap_map *map;
    struct rmap_criterion *all, *criterion; /* criterion: NULL for all rays */
    struct rmap_which *which;               /* as it chooses */
    struct rmap_detector_sums *image;       /* [n_image] of the rays that match; NULL: all rays */
    size_t n_image;
    struct rmap_portion *rays; /* on rank 0 */
    struct rmap_energy_scope scope;
    struct rmap_energy_sums *sums; /* on rank 0 */
    bool is_large;
    uint64_t n_sample;               /* rays that the paths of a large one are estimated from */
    struct rmap_report_paths *paths; /* on rank 0 */
};

/* Where the page goes: NULL is standard output. */
static enum rmap_status read_path(const struct rmap_context *context,
                                  const struct rmap_arguments *given, const char **path_ret,
                                  struct rmap_error *err)
{
    const char *path = rmap_argument(given, "output");
    if (given->n_operand == 2 && path)
        return rmap_error_set(err, RMAP_USAGE, "'%s' and -o '%s': the page goes to one of them",
                              given->operand[1], path);
    if (given->n_operand == 2)
        path = given->operand[1];
    *path_ret = path;
    if (!path && context->json)
        return rmap_error_set(err, RMAP_USAGE, "--json with --html needs -o OUT.html");
    if (!path)
        return RMAP_OK;
    return rmap_output_check(path, suffixes, rmap_argument(given, "force") != NULL, err);
}

/* Collective. */
static enum rmap_status count_paths(const struct rmap_context *context, struct page *page,
                                    struct rmap_error *err)
{
    struct rmap_path_request request = {.map = page->map,
                                        .criterion = page->criterion,
                                        .view = {.level = RMAP_PATH_SURFACE, .detector = -1},
                                        .sort = RMAP_PATH_BY_FLUX,
                                        .top = PATHS,
                                        .most_classes = RMAP_PATH_CLASSES_MOST};
    struct rmap_path_keys *keys = NULL;
    struct rmap_path_report *report = NULL;
    for (size_t d = rmap_map_scene(page->map)->n_detector; page->which && d > 0; d--)
        if (page->which->asked_on[d - 1]) { /* the first that is asked about */
            request.view.until_detector = true;
            request.view.detector = (int32_t)d - 1;
            request.which = page->which;
        }
    enum rmap_status st =
        rmap_path_keys_create(rmap_map_scene(page->map), &request.view, &keys, err);
    RMAP_TRY(rmap_agree(context, st, err));
    request.keys = keys;
    RMAP_TRY(rmap_path_run(context, &request, &report, err));
    if (report)
        st = rmap_report_paths_of(report, &page->paths, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_path_report_destroy(report);
    rmap_path_keys_destroy(keys);
    return st;
}

/* Collective. From the first rays alone. */
static enum rmap_status sample_paths(const struct rmap_context *context, struct page *page,
                                     struct rmap_error *err)
{
    struct rmap_portion *rays = NULL;
    enum rmap_status st =
        rmap_scan_collect(context, page->map, &(struct rmap_pick){.criterion = page->all},
                          page->n_sample, &rays, err);
    if (st == RMAP_OK && rays)
        st = rmap_report_paths_sampled(page->map, rays, PATHS, &page->paths, err);
    rmap_portion_destroy(rays);
    return rmap_agree(context, st, err);
}

/* Collective. What each of the first detectors saw of the rays that match. */
static enum rmap_status scan_images(const struct rmap_context *context, struct page *page,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = rmap_map_scene(page->map)->n_detector;
    const struct rmap_choice choice = {page->criterion, page->which};
    page->image = rmap_alloc(RMAP_REPORT_PICTURES, sizeof *page->image);
    if (!page->image)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for images");
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t d = 0; d < n && d < RMAP_REPORT_PICTURES; d++) {
        struct rmap_detector_sums *image = &page->image[page->n_image];
        st = rmap_detector_sums_init(image, page->map, (int32_t)d, false, err);
        page->n_image += st == RMAP_OK;
        RMAP_TRY(rmap_agree(context, st, err));
        RMAP_TRY(rmap_image_scan(context, page->map, &choice, image, err));
    }
out:
    return st;
}

/* Collective. Which rays the page is of. */
static enum rmap_status compile(const struct rmap_context *context, struct rmap_asked *asked,
                                struct page *page, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(page->map);
    const struct rmap_index_set every = {.span = (uint32_t)scene->n_detector};
    enum rmap_status st = rmap_criterion_compile("all", scene, &page->all, err);
    if (st == RMAP_OK && asked->n > 0)
        st = rmap_asked_compile(context, asked, 0, scene, &page->criterion, err);
    if (st == RMAP_OK && page->criterion)
        st = rmap_asked_which(context, NULL, asked, scene, &every, page->criterion, &page->which,
                              err);
    return rmap_agree(context, st, err);
}

/* Collective. The balance is the tally's; of a large map that is all. */
static enum rmap_status gather(const struct rmap_context *context, struct page *page,
                               struct rmap_error *err)
{
    struct rmap_map_summary summary;
    enum rmap_status st = RMAP_OK;
    const struct rmap_pick pick = {.criterion = page->criterion ? page->criterion : page->all};
    RMAP_TRY(rmap_scan_collect(context, page->map, &pick, DRAWN, &page->rays, err));
    if (page->rays)
        rmap_figure_draw_thin(page->rays);
    rmap_map_summarise(page->map, &summary);
    page->is_large = page->n_sample > 0 || summary.n_row[RMAP_TABLE_SEGMENT] > LARGE_SEGMENTS;
    if (page->criterion) { /* no tally knows of it: all is read */
        page->is_large = false;
        RMAP_TRY(scan_images(context, page, err));
    }
    if (page->n_sample == 0)
        page->n_sample = SAMPLED;
    if (!page->is_large) {
        RMAP_TRY(rmap_energy_run(context, page->map,
                                 &(struct rmap_choice){page->criterion, page->which}, &page->scope,
                                 &page->sums, err));
    } else if (context->rank == 0) {
        page->scope = (struct rmap_energy_scope){.scene = rmap_map_scene(page->map)};
        st = rmap_energy_sums_create(&page->scope, &page->sums, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(page->is_large ? sample_paths(context, page, err) : count_paths(context, page, err));
    if (page->is_large && page->sums) {
        rmap_energy_sums_take_tally(page->sums, rmap_map_tally(page->map));
        rmap_energy_sums_take_planes(page->sums, rmap_map_tally(page->map));
    }
out:
    return st;
}

/* On rank 0. In memory first: there is a whole page or none. */
static enum rmap_status write_page(const struct rmap_context *context,
                                   const struct rmap_run_report *report, const char *path,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *text = NULL;
    size_t nbytes = 0;
    FILE *page = open_memstream(&text, &nbytes);
    if (!page)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page");
    st = rmap_run_report_write(report, page, err);
    int failed = ferror(page);
    if ((fclose(page) != 0 || failed) && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page");
    if (st == RMAP_OK && path)
        st = rmap_whole_file_put_bytes(path, text, nbytes, err);
    else if (st == RMAP_OK)
        (void)fwrite(text, 1, nbytes, stdout); /* main sees to its errors */
    if (st == RMAP_OK && context->json)
        st = rmap_json_print(
            rmap_json_of_map(json_pack("{s:s, s:I}", "output", path, "bytes", (json_int_t)nbytes),
                             report->map),
            stdout, err);
    else if (st == RMAP_OK && path && !context->quiet)
        printf("%s: %.1f MB\n", path, 1e-6 * (double)nbytes);
    free(text);
    return st;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, struct page *page,
                             const char *name, const char *path, struct rmap_error *err)
{
    struct rmap_energy *energy = NULL;
    enum rmap_status st = rmap_map_compare_directory(page->map, err);
    if (st == RMAP_OK)
        st = rmap_energy_create(page->map, name,
                                page->criterion ? rmap_criterion_text(page->criterion) : NULL,
                                page->sums, &energy, err);
    if (st == RMAP_OK) {
        energy->which = page->which;
        const struct rmap_run_report report = {
            .map = page->map,
            .name = name,
            .energy = energy,
            .energy_note =
                page->is_large
                    ? "The map is large: standard errors of what planes registered would "
                      "take reading all of it (raymap report MAP --energy)."
                    : NULL,
            .rays = page->rays,
            .paths = page->paths,
            .image = page->image,
            .which = page->which};
        st = write_page(context, &report, path, err);
    }
    rmap_energy_destroy(energy);
    return st;
}

enum rmap_status rmap_report_page(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct page page = {0};
    struct rmap_asked asked = {0};
    const char *path = NULL, *where = rmap_argument(given, "where");
    char name[RMAP_MAP_NAME_LEN];
    rmap_map_name(given->operand[0], name);
    enum rmap_status st = read_path(context, given, &path, err);
    if (st == RMAP_OK)
        st = rmap_argument_count(given, "sample", &page.n_sample, err);
    if (st == RMAP_OK && rmap_argument(given, "sample") &&
        (page.n_sample < 1 || page.n_sample > MOST_SAMPLED))
        st = rmap_error_set(err, RMAP_USAGE, "--sample must lie between 1 and %d", MOST_SAMPLED);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &where, &asked, err));
    RMAP_TRY(rmap_load_map(context, given->operand[0], &page.map, err));
    RMAP_TRY(compile(context, &asked, &page, err));
    RMAP_TRY(gather(context, &page, err));
    if (context->rank == 0)
        st = show(context, &page, name, path, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_report_paths_destroy(page.paths);
    rmap_energy_sums_destroy(page.sums);
    rmap_portion_destroy(page.rays);
    for (size_t i = 0; i < page.n_image; i++)
        rmap_detector_sums_fini(&page.image[i]);
    rmap_free(page.image);
    rmap_which_destroy(page.which);
    rmap_criterion_destroy(page.criterion);
    rmap_criterion_destroy(page.all);
    rmap_asked_fini(&asked);
    rmap_map_close(page.map);
    return st;
}
