/* SPDX-License-Identifier: MIT
 *
 * raymap draw: a picture of the scene with rays of the map.
 */
#include <stdio.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_draw.h"
#include "analysis/page/scene_glb.h"
#include "base/alloc.h"
#include "io/export/raster.h"
#include "io/map/map_json.h"
#include "mpi/answer/draw_film.h"
#include "mpi/answer/draw_pick.h"
#include "mpi/answer/draw_polydata.h"
#include "mpi/answer/draw_request.h"
#include "mpi/answer/page_run.h"
#include "mpi/command/asked_each.h"
#include "mpi/command/balance.h"
#include "mpi/command/find_camera.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/map_name.h"
#include "mpi/command/overlay_load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/overlay_pick.h"
#include "mpi/scan/scan.h"
#include "mpi/trace/scene_as_map.h"

enum { RAYS_DEFAULT = 20000 };

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION...",
     "rays that match, such as 'registered(sensor)' (default: all); given again, rays that match "
     "any, each in its colour"},
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    RMAP_SCENE_RAYS_OPTION(20000),
    {"output", 'o', "OUT",
     "OUT.svg or OUT.png: a picture; OUT.html: a page to explore, OUT.json: the data of one; "
     "OUT.vtp: polylines for ParaView; OUT.glb, OUT.gltf: a glTF scene"},
    {"limit", 'l', "N",
     "draw the N matching rays with the smallest ids, of several criteria in colours each its "
     "share "
     "(default 300, fewer of very many segments; in a page 2000)"},
    {"view", 'v', "VIEW",
     "section yz, xz or xy, or 3d (default: 3d for scenes of meshes, else the section along the "
     "rays)",
     .words = "yz xz xy 3d"},
    {"cut", 0, "PLACE",
     "where the section's plane lies along its axis (default: the axis of most "
     "surfaces)"},
    {"near", 0, "DISTANCE",
     "in a section the rays that stay so near its plane, of the first hundred times --limit that "
     "match"},
    {"stretch", 0, "X",
     "draw lengths upwards in a section X times as long (default 1; so that it fills the picture "
     "of a "
     "section more than 20 times longer one way)"},
    {"eye", 0, "AZIMUTH,ELEVATION", "where a 3d view is seen from, degrees (default -62,28)"},
    {"camera", 0, "NAME", "as this camera of the scene sees it, in perspective"},
    {"color", 0, "MODE",
     "natural: the colour of the light (default); path: classes of paths; criterion: several "
     "--where, or all of --criteria; order: of ghosts and scatter",
     .words = "natural path criterion order"},
    {"by", 0, "LEVEL",
     "whose names tell paths apart: surface, object or group (default: object for --color path, "
     "surface in a page; a picture's paths are coarser where most have a ray each)",
     .words = "surface object group"},
    {"time", 0, "FROM:TO:STEP",
     "a film of the light on its way, of a map with arrival times: for each step (ns, or with a "
     "unit behind) the light that is under way, and what was registered by then; OUT-0001.png and "
     "so on (or .svg), or OUT.apng, which browsers play"},
    {"parts", 0, "LIST",
     "of OUT.json: scene, rays, detectors, those that are listed with commas between (default: "
     "all)"},
    {"opacity", 0, "X", "of the strongest ray, above 0 to 1 (default: by the number of rays)"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

/* What is drawn, and out of what. */
struct drawing {
    const struct rmap_context *context;
    struct rmap_draw_request request;
    struct rmap_map *map;
    struct rmap_overlay *overlay;   /* receivers; NULL: none */
    const struct rmap_scene *scene; /* with them */
    struct rmap_asked asked;
    struct rmap_asked_each each;
    struct rmap_count *count;        /* [n_count] of any, then of each where they are several */
    struct rmap_criterion **counted; /* [n_count] those */
    size_t n_count;
    uint64_t *id; /* [n_id] of the rays to draw, where receivers or several criteria pick them */
    size_t n_id;
    struct rmap_portion *rays; /* rank 0 */
    struct rmap_overlay_view *view;
    const struct rmap_portion *seen; /* the rays with what receivers registered */
    struct rmap_ray_paint *paint;
    bool misses; /* the section meets no object */
    struct rmap_near_plane near;
};

/* Whether each criterion gets its share of the rays. */
static bool is_shared(const struct drawing *self)
{
    return self->request.paint == RMAP_PAINT_CRITERION && self->each.n > 1;
}

/* On rank 0. */
static enum rmap_status draw_picture(struct drawing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_draw_request *request = &self->request;
    struct rmap_svg *svg = NULL;
    char title[RMAP_MAP_NAME_LEN];
    rmap_map_name(request->map_path, title);
    const struct rmap_camera *camera = NULL;
    if (request->camera)
        RMAP_TRY(rmap_find_camera(rmap_map_scene(self->map), request->map_path, request->camera,
                                  &camera, err));
    struct rmap_figure_draw given = {.title = title,
                                     .criterion = self->each.text,
                                     .n_matched = self->count[0].rays,
                                     .kind = request->kind,
                                     .eye = request->has_eye ? request->eye : NULL,
                                     .camera = camera,
                                     .cut = request->has_cut ? &request->cut : NULL,
                                     .stretch = request->stretch,
                                     .near = request->near > 0.0 ? &self->near : NULL,
                                     .misses_ret = &self->misses,
                                     .paint = self->paint,
                                     .opacity = request->opacity,
                                     .map = self->map};
    if (request->n_frame > 0) {
        st = rmap_draw_film(request, self->scene, self->seen, &given, err);
        goto out;
    }
    RMAP_TRY(rmap_figure_draw(self->scene, self->rays, &given, &svg, err));
    RMAP_TRY(rmap_picture_write(svg, request->output_path, RMAP_FIGURE_SCALE, err));
out:
    rmap_svg_destroy(svg);
    return st;
}

/* On rank 0. */
static enum rmap_status paint_rays(struct drawing *self, struct rmap_error *err)
{
    const struct rmap_paint_request given = {
        .kind = self->request.paint,
        .level = self->request.has_level ? &self->request.level : NULL,
        .scene = self->scene,
        .rays = self->seen,
        .flux_per_weight = rmap_map_flux_per_weight(self->map),
        .criterion = (const struct rmap_criterion *const *)self->each.of,
        .n_criterion = self->each.n};
    const enum rmap_status st = rmap_ray_paint_create(&given, &self->paint, err);
    for (size_t k = 0; st == RMAP_OK && k < self->paint->n_group && k + 1 < self->n_count; k++)
        self->paint->group[k].matching = self->count[k + 1].rays;
    if (st == RMAP_OK)
        self->paint->dealt =
            is_shared(self) && self->rays->n_row[RMAP_TABLE_RAY] < self->count[0].rays;
    return st;
}

/* On rank 0. */
static enum rmap_status draw(struct drawing *self, struct rmap_error *err)
{
    enum rmap_status st = paint_rays(self, err);
    if (st != RMAP_OK)
        return st;
    switch (self->request.format) {
    case RMAP_DRAW_POLYDATA:
        return rmap_draw_polydata(self->map, self->rays, self->paint, self->request.output_path,
                                  err);
    case RMAP_DRAW_GLTF:
        return rmap_scene_glb_write(self->map, self->rays, self->paint, self->request.output_path,
                                    err);
    default:
        return draw_picture(self, err);
    }
}

/* Collective. */
static enum rmap_status write_page(const struct drawing *self, struct rmap_error *err)
{
    char title[RMAP_MAP_NAME_LEN];
    double error;
    rmap_map_name(self->request.map_path, title);
    struct rmap_page page = {.title = title,
                             .criterion = self->each.text,
                             .any = self->each.text ? self->each.any : NULL,
                             .map = self->map,
                             .overlay = self->overlay,
                             .rays = self->seen,
                             .n_matched = self->count[0].rays,
                             .kind = self->request.kind,
                             .paint = self->request.paint,
                             .is_data = self->request.is_data,
                             .parts = self->request.parts,
                             .level =
                                 self->request.has_level ? self->request.level : RMAP_PATH_SURFACE};
    if (self->request.paint == RMAP_PAINT_CRITERION) {
        page.where = (const struct rmap_criterion *const *)self->each.of;
        page.n_where = self->each.n;
    }
    rmap_count_flux(&self->count[0], self->map, &page.flux_matched, &error);
    return rmap_page_run(self->context, self->each.text ? self->each.any : NULL, &page,
                         self->request.output_path, err);
}

/* On rank 0. */
static enum rmap_status tell(const struct drawing *self, struct rmap_error *err)
{
    const uint64_t n_drawn = self->rays->n_row[RMAP_TABLE_RAY], n_matched = self->count[0].rays;
    const char *path = self->request.output_path;
    if (self->context->json) {
        json_t *rays =
            json_pack("{s:I, s:I}", "matched", (json_int_t)n_matched, "drawn", (json_int_t)n_drawn);
        if (self->request.near > 0.0 && rays) {
            json_object_set_new(rays, "looked_at", json_integer((json_int_t)self->near.looked));
            json_object_set_new(rays, "near", json_integer((json_int_t)self->near.near));
        }
        json_t *json = json_pack("{s:s, s:s, s:o}", "output", path, "criterion",
                                 self->each.text ? self->each.text : "all", "rays", rays);
        if (self->request.n_frame > 0 && json)
            json_object_set_new(json, "pictures", json_integer(self->request.n_frame));
        return rmap_json_print(rmap_json_of_map(json, self->map), stdout, err);
    }
    if (self->context->quiet)
        return RMAP_OK;
    if (self->request.n_frame > 0)
        printf("%u pictures: ", self->request.n_frame);
    printf("%s: %llu of %llu matching rays drawn\n", path, (unsigned long long)n_drawn,
           (unsigned long long)n_matched);
    if (self->request.near > 0.0)
        printf("%llu of the first %llu stay within %g %s of the section\n",
               (unsigned long long)self->near.near, (unsigned long long)self->near.looked,
               self->request.near, self->scene->unit);
    else if (self->request.thin && n_drawn < self->request.limit && n_drawn < n_matched)
        fprintf(
            stderr,
            "they have many segments: drawn are so many rays as make up %d, or by --limit N more\n",
            RMAP_FIGURE_STROKES);
    if (self->misses)
        fprintf(stderr, "there is no object at --cut %g: the rays alone are drawn\n",
                self->request.cut);
    return RMAP_OK;
}

static enum rmap_status compile(struct drawing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = self->scene;
    if (self->request.paint == RMAP_PAINT_CRITERION)
        rmap_asked_take_file(&self->asked);
    RMAP_TRY(rmap_asked_each_compile(self->context, &self->asked, scene, &self->each, err));
    if (self->request.paint == RMAP_PAINT_CRITERION && self->each.n == 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "--color criterion wants criteria: --where, once or more often, or "
                              "--criteria FILE");
    if (self->request.format == RMAP_DRAW_PAGE && self->each.n > RMAP_PAGE_MOST_WHERE)
        return rmap_error_set(err, RMAP_USAGE, "a page switches between %d criteria at most",
                              RMAP_PAGE_MOST_WHERE);
    self->count = rmap_alloc(self->each.n + 1, sizeof *self->count);
    self->counted = rmap_alloc(self->each.n + 1, sizeof(void *));
    if (!self->count || !self->counted)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for criteria");
    for (size_t k = 0; k < (self->each.n > 1 ? self->each.n + 1 : 1); k++, self->n_count++) {
        self->counted[k] = k == 0 ? self->each.any : self->each.of[k - 1];
        RMAP_TRY(rmap_count_init(&self->count[k], scene->n_source, err));
    }
out:
    return st;
}

/* Collective. How many rays match. */
static enum rmap_status count(struct drawing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->overlay)
        return rmap_scan_map(self->context, self->map, self->counted, self->n_count,
                             RMAP_DEAL_SHARES, self->count, err);
    for (size_t k = 0; k < self->n_count; k++) {
        const struct rmap_overlay_question question = {self->map, self->overlay, self->counted[k]};
        RMAP_TRY(rmap_overlay_count_run(self->context, &question, &self->count[k], err));
    }
out:
    return st;
}

/* Rays that are looked at for each that is drawn, where few run near a plane. */
enum { LOOK_AT = 100 };

/* On rank 0. */
static enum rmap_status keep_near(struct drawing *self, struct rmap_error *err)
{
    struct rmap_draw_request *request = &self->request;
    self->near = (struct rmap_near_plane){.distance = request->near, .most = request->limit};
    return rmap_figure_draw_near(self->scene, &request->kind,
                                 request->has_cut ? &request->cut : NULL, &self->near, &self->rays,
                                 err);
}

/* Collective. The rays to draw. */
static enum rmap_status collect(struct drawing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    struct rmap_pick pick = {.criterion = self->each.any};
    const bool shared = is_shared(self);
    const uint64_t most =
        self->request.near > 0.0 ? LOOK_AT * self->request.limit : self->request.limit;
    if (shared || self->overlay) {
        const struct rmap_criterion *const any = self->each.any;
        const struct rmap_draw_question question = {
            .map = self->map,
            .overlay = self->overlay,
            .any = any,
            .criterion = shared ? (const struct rmap_criterion *const *)self->each.of : &any,
            .matching = shared ? self->count + 1 : self->count,
            .n_criterion = shared ? self->each.n : 1,
            .most = most};
        RMAP_TRY(rmap_draw_pick(context, &question, &self->id, &self->n_id, err));
        pick = (struct rmap_pick){.id = self->id, .n_id = self->n_id};
    }
    RMAP_TRY(rmap_scan_collect(context, self->map, &pick, most, &self->rays, err));
    if (self->rays && self->request.near > 0.0)
        st = keep_near(self, err);
    if (st == RMAP_OK && self->rays && self->request.thin)
        rmap_figure_draw_thin(self->rays);
    self->seen = self->rays;
    if (st == RMAP_OK && self->overlay && self->rays) {
        st = rmap_overlay_view_create(self->overlay, &self->view, err);
        if (st == RMAP_OK)
            st = rmap_overlay_view_extend(self->view, self->rays, RMAP_OVERLAY_EACH_SPACE,
                                          &self->seen, err);
    }
    st = rmap_agree(context, st, err);
out:
    return st;
}

static enum rmap_status run(struct drawing *self, const struct rmap_arguments *given,
                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    RMAP_TRY(rmap_load_map_or_scene(context, given, self->request.map_path, RAYS_DEFAULT,
                                    &self->map, err));
    RMAP_TRY(rmap_overlay_load(context, given, self->map, &self->overlay, err));
    self->scene = rmap_scene_with(self->map, self->overlay);
    if (self->request.n_frame > 0)
        st = rmap_light_times_check(self->map, err);
    if (st == RMAP_OK)
        st = compile(self, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(count(self, err));
    RMAP_TRY(collect(self, err));
    if (self->request.format == RMAP_DRAW_PAGE)
        RMAP_TRY(write_page(self, err));
    else if (context->rank == 0)
        st = draw(self, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = tell(self, err);
    st = rmap_agree(context, st, err);
out:
    return st;
}

static enum rmap_status run_draw(const struct rmap_context *context,
                                 const struct rmap_arguments *given, struct rmap_error *err)
{
    struct drawing self = {.context = context};
    enum rmap_status st = rmap_draw_request_read(given, &self.request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (self.request.n_where > 0 && rmap_argument(given, "zemax"))
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE, "give --where or --zemax, not both"));
    RMAP_TRY(rmap_asked_load(context, given, (const char *const *)self.request.where,
                             self.request.n_where, &self.asked, err));
    st = run(&self, given, err);
out:
    rmap_ray_paint_destroy(self.paint);
    for (size_t k = 0; k < self.n_count; k++)
        rmap_count_fini(&self.count[k]);
    rmap_free(self.count);
    rmap_free(self.counted);
    rmap_overlay_view_destroy(self.view);
    rmap_free(self.id);
    rmap_portion_destroy(self.rays);
    rmap_asked_each_fini(&self.each);
    rmap_asked_fini(&self.asked);
    rmap_overlay_destroy(self.overlay);
    rmap_map_close(self.map);
    rmap_draw_request_fini(&self.request);
    return st;
}

const struct rmap_command rmap_command_draw = {
    .name = "draw",
    .summary = "a picture of the scene with rays of the map",
    .operands = "MAP|SCENE [--where CRITERION] -o OUT",
    .help = "Draws the scene, cut by a plane or seen from above, with the rays that match in the\n"
            "colour of their light, as\n\n"
            "  raymap draw lens.raymap --where 'registered(sensor)' --limit 60 -o rays.png\n\n"
            "Rays are projected on the plane of a section. OUT.svg has lines and text, OUT.png is\n"
            "the same picture in pixels. With no matching ray the scene is drawn alone. In a view\n"
            "from above what bodies hide of a ray is faint; glass hides nothing.\n\n"
            "  raymap draw lens.raymap --where 'registered(sensor)' --color order -o rays.svg\n\n"
            "gives each order of ghosts its colour; rays of more flux are more opaque.\n\n"
            "  raymap draw lens/scene.yaml -o lens.svg\n\n"
            "traces rays of a scene into memory for the picture.\n\n"
            "  raymap draw bar.raymap --time 0:10:0.1 -o film.apng\n\n"
            "is a film of the light on its way.\n\n"
            "  raymap draw lens.raymap --where 'registered(sensor)' -o lens.html\n\n"
            "writes one page that any browser opens, without a network: the scene and the rays in\n"
            "three dimensions, light on its way, every ray's report, classes of paths, and images\n"
            "of detectors on which a region is drawn to get its criterion.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_draw,
};
