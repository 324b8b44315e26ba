/* SPDX-License-Identifier: MIT */
#include "map_analysis.h"

#include <string.h>

#include "analysis/figure/figure_draw.h"
#include "analysis/figure/figure_energy.h"
#include "analysis/paths/path_class.h"
#include "analysis/paths/path_count.h"
#include "analysis/query/fold.h"
#include "analysis/query/quantity.h"
#include "analysis/query/quantity_read.h"
#include "base/alloc.h"
#include "io/export/polydata.h"
#include "io/map/map_cursor.h"
#include "io/map/map_scan.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_rays.h"
#include "target.h"

/* Memory that cannot be had counts as a failure here: so small a map never needs much. */
enum rmap_status map_analysis_judge(enum rmap_status st, const struct rmap_error *err)
{
    if (st != RMAP_OK && st != RMAP_FORMAT && st != RMAP_INPUT) {
        (void)fprintf(stderr, "status %d: %s\n", (int)st, err->text);
        rmap_fuzz_demand(0, "a damaged map is told as such");
    }
    return st;
}

/* ---- folds ---- */

/* All portions added to a new state of a kind; NULL where the rows do not fit. */
static void *fold_all(const struct rmap_fold *fold)
{
    struct rmap_fold_scanner *scanner = NULL;
    struct rmap_error err = {0};
    void *state = NULL;
    rmap_fuzz_demand(rmap_fold_scanner_create(fold, &scanner, &err) == RMAP_OK &&
                         fold->kind->create(fold->context, &state, &err) == RMAP_OK,
                     "a fold begins");
    enum rmap_status st =
        rmap_fold_scanner_add(scanner, state, 0, rmap_map_n_portion(fold->map), &err);
    if (map_analysis_judge(st, &err) != RMAP_OK) {
        fold->kind->destroy(state);
        state = NULL;
    }
    rmap_fold_scanner_destroy(scanner);
    return state;
}

/* The energy of the map, from its tally or from its rays. */
static void balance(const struct rmap_map *map)
{
    const struct rmap_energy_scope scope = {.scene = rmap_map_scene(map), .ends = true};
    const struct rmap_fold fold = {.kind = &rmap_energy_kind,
                                   .context = &scope,
                                   .map = map,
                                   .columns = rmap_energy_columns(&scope)};
    struct rmap_energy_sums *sums = fold_all(&fold);
    struct rmap_energy *energy = NULL;
    struct rmap_svg *svg = NULL;
    struct rmap_error err = {0};
    if (!sums) {
        rmap_fuzz_demand(rmap_energy_sums_create(&scope, &sums, &err) == RMAP_OK, "memory");
        rmap_energy_sums_take_tally(sums, rmap_map_tally(map));
    }
    if (rmap_energy_create(map, "a map", NULL, sums, &energy, &err) == RMAP_OK) {
        json_decref(rmap_energy_json(energy));
        rmap_fuzz_demand(rmap_figure_energy(energy, &svg, &err) == RMAP_OK, "a picture of energy");
    }
    rmap_svg_destroy(svg);
    rmap_energy_destroy(energy);
    rmap_energy_sums_destroy(sums);
}

/* Few classes fit, so that there are more than are counted. */
static void count_paths(const struct rmap_map *map, const struct rmap_overlay *overlay)
{
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    const struct rmap_path_view view = {.level = RMAP_PATH_SURFACE};
    struct rmap_path_keys *keys = NULL;
    struct rmap_error err = {0};
    rmap_fuzz_demand(rmap_path_keys_create(scene, &view, &keys, &err) == RMAP_OK, "memory");
    struct rmap_path_counting counting = {.map = map,
                                          .overlay = overlay,
                                          .keys = keys,
                                          .detector = -1,
                                          .most_classes = 16,
                                          .most_cells = 64};
    const struct rmap_fold fold = {.kind = &rmap_path_count_kind,
                                   .context = &counting,
                                   .map = map,
                                   .overlay = overlay,
                                   .columns = rmap_path_count_columns(&counting)};
    void *state = fold_all(&fold);
    if (state)
        rmap_path_count_kind.destroy(state);
    rmap_path_keys_destroy(keys);
}

/* ---- portion by portion ---- */

struct analyst {
    const struct rmap_map *map;
    unsigned pick;
    struct rmap_overlay *overlay;
    struct rmap_overlay_view *view;
    struct rmap_quantities *quantities[2]; /* of rays, of registrations */
    struct rmap_readings readings;
};

static void begin(struct analyst *self)
{
    static const char text[] =
        "detectors:\n"
        "  - {name: behind, type: plane, size: [30, 30], cells: [9, 9], at: [0, 0, 40], side: "
        "both}\n"
        "  - {name: holder, type: plane, on: housing.film_holder, size: 20, cells: 4, side: both, "
        "at: "
        "[0, 0, 60]}\n"
        "  - {name: round, type: intensity, cells: [9, 18], axis: [0, 0, 1]}\n";
    static const char *const of[2][2] = {{"path_length", "ghost_order"}, {"x(film)", "angle(*)"}};
    struct rmap_diagnostics diagnostics;
    struct rmap_error err = {0};
    const struct rmap_receivers receivers = {"receivers.yaml", text, strlen(text), &diagnostics};
    rmap_diagnostics_init(&diagnostics, receivers.path);
    enum rmap_status st = rmap_overlay_create(self->map, &receivers, &self->overlay, &err);
    if (map_analysis_judge(st, &err) == RMAP_OK)
        rmap_fuzz_demand(rmap_overlay_view_create(self->overlay, &self->view, &err) == RMAP_OK,
                         "memory");
    rmap_diagnostics_fini(&diagnostics);
    for (int k = 0; k < 2; k++) {
        st = rmap_quantities_create_over(self->map, self->overlay, of[k], 2, NULL,
                                         &self->quantities[k], &err);
        (void)map_analysis_judge(st, &err);
    }
}

static void end(struct analyst *self)
{
    for (int k = 0; k < 2; k++)
        rmap_quantities_destroy(self->quantities[k]);
    rmap_readings_fini(&self->readings);
    rmap_overlay_view_destroy(self->view);
    rmap_overlay_destroy(self->overlay);
}

static void name_paths(const struct rmap_scene *scene, const struct rmap_portion *rays,
                       const double *flux)
{
    const struct rmap_path_view view = {.level = RMAP_PATH_OBJECT, .collapsed = true};
    struct rmap_path_classes *classes = NULL;
    struct rmap_error err = {0};
    enum rmap_status st = rmap_path_classes_create(scene, &view, rays, flux, &classes, &err);
    if (map_analysis_judge(st, &err) != RMAP_OK)
        return;
    for (size_t k = 0; k < classes->n && k < 3; k++) {
        char *text = NULL;
        rmap_fuzz_demand(rmap_path_class_label(classes, k, 300, &text, &err) == RMAP_OK, "a label");
        rmap_free(text);
        text = NULL;
        rmap_fuzz_demand(rmap_path_class_criterion(classes, k, &text, &err) == RMAP_OK,
                         "a criterion");
        rmap_free(text);
    }
    rmap_path_classes_destroy(classes);
}

static void write_lines(const struct rmap_scene *scene, const struct rmap_portion *rays)
{
    const struct rmap_polydata_terms terms = {"W", NULL, 0};
    const struct rmap_polydata_ray given = {1.0, -1};
    struct rmap_polydata *data = NULL;
    struct rmap_error err = {0};
    FILE *out = fopen("/dev/null", "wb");
    rmap_fuzz_demand(out && rmap_polydata_begin(out, scene, &terms, &data, &err) == RMAP_OK,
                     "polylines begin");
    for (size_t i = 0, segment = 0; i < rays->n_row[RMAP_TABLE_RAY];
         segment += rays->ray.segment_count[i++])
        rmap_fuzz_demand(rmap_polydata_add(data, rays, i, segment, &given, &err) == RMAP_OK,
                         "polylines");
    rmap_polydata_finish(data);
    rmap_polydata_destroy(data);
    (void)fclose(out);
}

static void draw(const struct rmap_map *map, const struct rmap_portion *rays,
                 enum rmap_view_kind kind, enum rmap_paint_kind colours)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_ray_paint *paint = NULL;
    struct rmap_svg *svg = NULL;
    struct rmap_error err = {0};
    const struct rmap_paint_request request = {.kind = colours,
                                               .scene = scene,
                                               .rays = rays,
                                               .flux_per_weight = rmap_map_flux_per_weight(map)};
    enum rmap_status st = rmap_ray_paint_create(&request, &paint, &err);
    const struct rmap_figure_draw given = {.title = "t", .kind = kind, .paint = paint, .map = map};
    if (map_analysis_judge(st, &err) == RMAP_OK)
        (void)map_analysis_judge(rmap_figure_draw(scene, rays, &given, &svg, &err), &err);
    rmap_svg_destroy(svg);
    rmap_ray_paint_destroy(paint);
}

static void read_numbers(struct analyst *self, const struct rmap_portion *rays, size_t index)
{
    const struct rmap_matched all = {
        .portion = rays, .n_match = rays->n_row[RMAP_TABLE_RAY], .index = index};
    for (int k = 0; k < 2; k++) {
        struct rmap_error err = {0};
        if (self->quantities[k])
            (void)map_analysis_judge(
                rmap_quantities_read(self->quantities[k], &all, &self->readings, &err), &err);
    }
}

static void read_portion(struct analyst *self, const struct rmap_portion *stored, size_t index)
{
    const struct rmap_portion *rays = stored;
    struct rmap_error err = {0};
    if (self->view &&
        map_analysis_judge(rmap_overlay_view_extend(self->view, stored, 0, &rays, &err), &err) !=
            RMAP_OK)
        return;
    read_numbers(self, rays, index);
    name_paths(rmap_scene_with(self->map, self->overlay), rays,
               rmap_map_flux_per_weight(self->map));
    write_lines(rmap_map_scene(self->map), stored);
    if (index > 0)
        return;
    draw(self->map, stored, RMAP_VIEW_YZ, RMAP_PAINT_PATH);
    if (self->pick % 32 == 0)
        draw(self->map, stored, RMAP_VIEW_3D, RMAP_PAINT_ORDER);
}

void map_analysis(const struct rmap_map *map, unsigned pick)
{
    struct analyst self = {.map = map, .pick = pick};
    struct rmap_cursor *cursor = NULL;
    struct rmap_error err = {0};
    balance(map);
    begin(&self);
    if (pick % 4 == 0)
        count_paths(map, pick % 8 == 0 ? self.overlay : NULL);
    rmap_fuzz_demand(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err) == RMAP_OK,
                     "a cursor");
    for (size_t i = 0; i < rmap_map_n_portion(map) && i < 4; i++) {
        const struct rmap_portion *portion = NULL;
        if (map_analysis_judge(rmap_cursor_read(cursor, i, &portion, &err), &err) == RMAP_OK)
            read_portion(&self, portion, i);
    }
    rmap_cursor_destroy(cursor);
    end(&self);
}

/* ---- verifying ---- */

static void verify_all(struct rmap_verification *self, struct rmap_findings *findings)
{
    struct rmap_chunk_verifier *chunks = NULL;
    struct rmap_cursor *cursor = NULL;
    struct rmap_error err = {0};
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < self->claimed->n_piece && i < 8; i++)
        RMAP_TRY(rmap_verify_piece(self, i, findings, &err));
    RMAP_TRY(rmap_chunk_verifier_create(self, &chunks, &err));
    for (size_t i = 0; i < self->content->n_chunk && i < 200; i++)
        RMAP_TRY(rmap_verify_chunk(chunks, i, findings, &err));
    if (!self->map)
        goto out;
    RMAP_TRY(rmap_cursor_create(self->map, RMAP_COLUMNS_ALL, &cursor, &err));
    for (size_t i = 0; i < rmap_map_n_portion(self->map) && i < 8; i++)
        RMAP_TRY(rmap_verify_portion(self, cursor, i, NULL, findings, &err));
    st = rmap_verify_sums(self, NULL, findings, &err);
out:
    rmap_fuzz_demand(st == RMAP_OK, "what is wrong is a finding");
    rmap_cursor_destroy(cursor);
    rmap_chunk_verifier_destroy(chunks);
}

void map_analysis_verify(const char *path)
{
    struct rmap_verification *verification = NULL;
    struct rmap_findings findings = {0};
    struct rmap_error err = {0};
    if (map_analysis_judge(rmap_verification_open(path, &verification, &findings, &err), &err) ==
        RMAP_OK)
        verify_all(verification, &findings);
    rmap_verification_close(verification);
    rmap_findings_fini(&findings);
}
