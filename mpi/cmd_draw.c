/* SPDX-License-Identifier: MIT
 *
 * raymap draw: a picture of the scene with rays of the map.
 */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "analysis/figure_detector.h"
#include "analysis/figure_draw.h"
#include "io/raster.h"
#include "mpi/agree.h"
#include "mpi/asked.h"
#include "mpi/json_out.h"
#include "mpi/load.h"
#include "mpi/output.h"
#include "mpi/page_run.h"
#include "mpi/scan.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "rays that match, such as 'registered(sensor)' (default: all)"},
    RMAP_ASKED_OPTIONS,
    {"output", 'o', "OUT", "the picture: OUT.svg or OUT.png; or OUT.html, a page to explore"},
    {"limit", 'l', "N",
     "draw the N matching rays with the smallest ids (default 300; in a page 2000)"},
    {"view", 'v', "VIEW",
     "section yz, xz or xy, or 3d (default: 3d for scenes of meshes, else the section along the "
     "rays)"},
    {"color", 0, "MODE", "natural: lines in the colour of their light (default)"},
    {"force", 'f', NULL, "replace OUT"},
    {NULL}};

static const char *const suffixes[] = {".svg", ".png", ".html", NULL};
enum { DEFAULT_LIMIT = 300, LARGEST_LIMIT = 1000000 };

struct request {
    const char *map_path, *output_path, *where;
    uint64_t limit;
    enum rmap_view_kind kind;
    bool is_page;
};

static enum rmap_status read_view(const char *text, enum rmap_view_kind *kind,
                                  struct rmap_error *err)
{
    static const char *const word[] = {"auto", "yz", "xz", "xy", "3d"};
    for (size_t i = 0; i < sizeof word / sizeof *word; i++)
        if (!text || strcmp(text, word[i]) == 0) {
            *kind = (enum rmap_view_kind)i;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_USAGE, "--view '%s': say yz, xz, xy or 3d", text);
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *color = rmap_argument(given, "color");
    *request = (struct request){.map_path = given->operand[0],
                                .output_path = rmap_argument(given, "output"),
                                .where = rmap_argument(given, "where"),
                                .limit = DEFAULT_LIMIT};
    if (!request->output_path)
        return rmap_error_set(err, RMAP_USAGE, "say where to: -o OUT.svg or -o OUT.png");
    if (color && strcmp(color, "natural") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--color '%s': this version draws natural colours",
                              color);
    RMAP_TRY(read_view(rmap_argument(given, "view"), &request->kind, err));
    const char *suffix = strrchr(request->output_path, '.');
    request->is_page = suffix && strcasecmp(suffix, ".html") == 0;
    if (request->is_page)
        request->limit = RMAP_PAGE_DEFAULT_RAYS;
    RMAP_TRY(rmap_argument_count(given, "limit", &request->limit, err));
    int largest = request->is_page ? RMAP_PAGE_MOST_RAYS : LARGEST_LIMIT;
    if (request->limit < 1 || request->limit > (uint64_t)largest)
        return rmap_error_set(err, RMAP_USAGE, "--limit must lie between 1 and %d", largest);
    RMAP_TRY(rmap_output_check(request->output_path, suffixes,
                               rmap_argument(given, "force") != NULL, err));
out:
    return st;
}

/* "lens.raymap" of "out/lens.raymap/". */
static void title_of(const char *path, char *title, size_t size)
{
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/')
        end--;
    size_t begin = end;
    while (begin > 0 && path[begin - 1] != '/')
        begin--;
    (void)snprintf(title, size, "%.*s", (int)(end - begin), path + begin);
}

/* On rank 0. */
static enum rmap_status draw_picture(const struct request *request, const struct rmap_map *map,
                                     const struct rmap_portion *rays, uint64_t n_matched,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    char title[256];
    title_of(request->map_path, title, sizeof title);
    struct rmap_figure_draw options_given = {.title = title,
                                             .criterion = request->where,
                                             .n_matched = n_matched,
                                             .kind = request->kind,
                                             .map = map};
    RMAP_TRY(rmap_figure_draw(rmap_map_scene(map), rays, &options_given, &svg, err));
    RMAP_TRY(rmap_picture_write(svg, request->output_path, RMAP_FIGURE_SCALE, err));
out:
    rmap_svg_destroy(svg);
    return st;
}

/* Collective. rays: on rank 0. */
static enum rmap_status write_page(const struct rmap_context *context,
                                   const struct request *request, const struct rmap_map *map,
                                   const struct rmap_criterion *criterion,
                                   const struct rmap_portion *rays, const struct rmap_count *all,
                                   struct rmap_error *err)
{
    char title[256];
    double error;
    title_of(request->map_path, title, sizeof title);
    struct rmap_page page = {.title = title,
                             .criterion = request->where,
                             .map = map,
                             .rays = rays,
                             .n_matched = all->rays,
                             .kind = request->kind};
    rmap_count_flux(all, map, &page.flux_matched, &error);
    return rmap_page_run(context, request->where ? criterion : NULL, &page, request->output_path,
                         err);
}

/* On rank 0. */
static enum rmap_status tell(const struct rmap_context *context, const struct request *request,
                             uint64_t n_drawn, uint64_t n_matched, struct rmap_error *err)
{
    if (context->json)
        return rmap_json_print(json_pack("{s:s, s:s, s:{s:I, s:I}}", "output", request->output_path,
                                         "criterion", request->where ? request->where : "all",
                                         "rays", "matched", (json_int_t)n_matched, "drawn",
                                         (json_int_t)n_drawn),
                               stdout, err);
    printf("%s: %llu of %llu matching rays drawn\n", request->output_path,
           (unsigned long long)n_drawn, (unsigned long long)n_matched);
    return RMAP_OK;
}

static enum rmap_status run_draw(const struct rmap_context *context,
                                 const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_portion *rays = NULL;
    struct rmap_count all = {0};
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    const struct rmap_scene *scene = rmap_map_scene(map);
    st = asked.n > 0 ? rmap_asked_compile(context, &asked, 0, scene, &criterion, err)
                     : rmap_criterion_compile("all", scene, &criterion, err);
    if (asked.n > 0 && criterion)
        request.where = rmap_criterion_text(criterion);
    if (st == RMAP_OK)
        st = rmap_count_init(&all, scene->n_source, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_scan_map(context, map, &criterion, 1, RMAP_DEAL_SHARES, &all, err));
    RMAP_TRY(rmap_scan_collect(context, map, criterion, request.limit, &rays, err));
    if (request.is_page)
        RMAP_TRY(write_page(context, &request, map, criterion, rays, &all, err));
    else if (context->rank == 0)
        st = draw_picture(&request, map, rays, all.rays, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = tell(context, &request, rays->n_row[RMAP_TABLE_RAY], all.rays, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_count_fini(&all);
    rmap_portion_destroy(rays);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_draw = {
    .name = "draw",
    .summary = "a picture of the scene with rays of the map",
    .operands = "MAP [--where CRITERION] -o OUT",
    .help = "Draws the scene, cut by a plane or seen from above, with the rays that match in the\n"
            "colour of their light, as\n\n"
            "  raymap draw lens.raymap --where 'registered(sensor)' --limit 60 -o rays.png\n\n"
            "Rays are projected on the plane of a section. OUT.svg has lines and text, OUT.png is\n"
            "the same picture in pixels. With no matching ray the scene is drawn alone.\n\n"
            "  raymap draw lens.raymap --where 'registered(sensor)' -o lens.html\n\n"
            "writes one page that any browser opens, without a network: the scene and the rays in\n"
            "three dimensions, light on its way, every ray's report, classes of paths, and images\n"
            "of detectors on which a region is drawn to get its criterion.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_draw,
};
