/* SPDX-License-Identifier: MIT
 *
 * Irradiance on objects as a file.
 */
#include "mpi/answer/irradiance_out.h"

#include <math.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_draw.h"
#include "analysis/page/irradiance_glb.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/polygons.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "mpi/answer/grid_out.h"
#include "mpi/answer/irradiance_uv_out.h"
#include "mpi/command/output.h"

static enum rmap_status choose_colours(const struct rmap_irradiance_image *image,
                                       const struct rmap_irradiance_out *out, const char *label,
                                       struct rmap_figure_cells *painted, struct rmap_error *err)
{
    const size_t n = image->cells->n_cell;
    const double *value = image->value[out->what];
    double peak = 0.0;
    for (size_t c = 0; c < n; c++)
        peak = fmax(peak, value[c]);
    const double top = rmap_value_scale_sure(value, image->standard_error[out->what], n, peak);
    *painted = (struct rmap_figure_cells){
        .cells = image->cells,
        .value = value,
        .side = image->side,
        .bar = {.label = label, .unit = image->unit},
        .caption = top < peak ? "; cells of few rays go beyond the scale" : ""};
    const enum rmap_status st =
        rmap_value_scale_choose(value, n, top, out->scale, &painted->bar.logarithmic, err);
    rmap_value_scale_find(value, n, top, painted->bar.logarithmic, painted->bar.range);
    return st;
}

static enum rmap_status write_picture(const struct rmap_irradiance_image *image,
                                      const struct rmap_irradiance_out *out,
                                      struct rmap_figure_cells *painted, const char *path,
                                      struct rmap_error *err)
{
    const struct rmap_irradiance_object *all = &image->object[image->cells->n_part];
    struct rmap_svg *svg = NULL;
    char caption[300];
    (void)snprintf(caption, sizeof caption, "mean %.4g ± %.2g %s, %s%s%s", all->mean,
                   all->mean_error, rmap_unit_text(image->unit).text,
                   rmap_counted(image->cells->n_cell, "cell").text,
                   painted->bar.logarithmic ? ", logarithmic scale" : "", painted->caption);
    painted->caption = caption;
    const struct rmap_figure_draw given = {.title = out->title,
                                           .criterion = image->criterion,
                                           .kind = RMAP_VIEW_3D,
                                           .eye = out->eye,
                                           .camera = out->camera,
                                           .painted = painted};
    enum rmap_status st = rmap_figure_draw(image->cells->scene, NULL, &given, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    return st;
}

static enum rmap_status write_texture(const struct rmap_irradiance_image *image,
                                      const struct rmap_irradiance_out *out, const char *path,
                                      struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    enum rmap_status st = rmap_irradiance_uv_figure(image, out, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    return st;
}

static enum rmap_status put_csv(const void *image, FILE *file, struct rmap_error *err)
{
    (void)err;
    rmap_irradiance_image_csv(image, file);
    return RMAP_OK;
}

/* Numbers of every facet: those of its cell, and its own. */
enum column {
    VALUE,
    ERROR,
    RELATIVE,
    ABSORBED,
    ABSORBED_ERROR,
    AREA,
    CELL,
    OBJECT,
    TRIANGLE,
    END,
    COLUMNS
};

struct numbers {
    double *column[COLUMNS], *corner; /* [n_facet] each; [n_corner][3] */
    size_t *end;                      /* [n_facet] */
    char *names;                      /* of the objects, a line each */
};

static void fini(struct numbers *numbers)
{
    for (int k = 0; k < COLUMNS; k++)
        rmap_free(numbers->column[k]);
    rmap_free(numbers->corner);
    rmap_free(numbers->end);
    rmap_free(numbers->names);
}

static enum rmap_status reserve(const struct rmap_irradiance_cells *cells, struct numbers *of,
                                struct rmap_error *err)
{
    bool good = true;
    size_t length = 1;
    for (int k = 0; k < COLUMNS; k++) {
        of->column[k] = rmap_alloc(cells->n_facet + 1, sizeof *of->column[k]);
        good = good && of->column[k];
    }
    for (size_t p = 0; p < cells->n_part; p++)
        length += strlen(cells->scene->object[cells->part[p].object].name) + 1;
    of->corner = rmap_alloc(3 * cells->n_corner + 1, sizeof *of->corner);
    of->end = rmap_alloc(cells->n_facet + 1, sizeof *of->end);
    of->names = rmap_alloc(length, 1);
    if (!good || !of->corner || !of->end || !of->names)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu cells", cells->n_cell);
    for (size_t p = 0, at = 0; p < cells->n_part; p++)
        at += (size_t)snprintf(of->names + at, length - at, "%s%s", p > 0 ? "\n" : "",
                               cells->scene->object[cells->part[p].object].name);
    return RMAP_OK;
}

static void fill(const struct rmap_irradiance_image *image, struct numbers *of)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    for (size_t f = 0; f < cells->n_facet; f++) {
        const struct rmap_irradiance_facet *facet = &cells->facet[f];
        const size_t c = facet->cell;
        of->end[f] = facet->corner + facet->n_corner;
        const double row[COLUMNS] = {[VALUE] = image->value[0][c],
                                     [ERROR] = image->standard_error[0][c],
                                     [RELATIVE] = image->relative_error[c],
                                     [ABSORBED] = image->value[1][c],
                                     [ABSORBED_ERROR] = image->standard_error[1][c],
                                     [AREA] = facet->area,
                                     [CELL] = (double)c,
                                     [OBJECT] = cells->cell[c].part,
                                     [TRIANGLE] = facet->triangle,
                                     [END] = (double)of->end[f]};
        for (int k = 0; k < COLUMNS; k++)
            of->column[k][f] = row[k];
    }
    for (size_t i = 0; i < cells->n_corner; i++) {
        of->corner[3 * i] = cells->corner[i].x;
        of->corner[3 * i + 1] = cells->corner[i].y;
        of->corner[3 * i + 2] = cells->corner[i].z;
    }
}

static enum rmap_status write_numbers(const struct rmap_irradiance_image *image, const char *path,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_cells *cells = image->cells;
    const char *length = cells->scene->unit, *unit = image->unit;
    struct numbers of = {.end = NULL};
    char error[32];
    (void)snprintf(error, sizeof error, "%s_error", image->quantity);
    const struct rmap_grid_array column[COLUMNS] = {
        [VALUE] = {image->quantity, unit, "flux that arrives, over the area"},
        [ERROR] = {error, unit, "standard error"},
        [RELATIVE] = {"relative_error", "1", "standard error over value; NaN: nothing arrives"},
        [ABSORBED] = {"absorbed", unit, "flux that is absorbed, over the area"},
        [ABSORBED_ERROR] = {"absorbed_error", unit, "standard error"},
        [AREA] = {"area", length, "of the facet, in this unit squared"},
        [CELL] = {"cell", "1", "facets of one cell have its value"},
        [OBJECT] = {"object", "1", "line of the text `objects`, from 0"},
        [TRIANGLE] = {"triangle", "1", "of the object's mesh; -1: of another shape"},
        [END] = {"corner_end", "1", "rows of `corner` up to the facet's last"}};
    enum { UV = RMAP_IRRADIANCE_UV_ARRAYS };
    struct rmap_grid_array all[UV + COLUMNS + 1], *array = all + UV, *first = array;
    struct rmap_irradiance_uv uv = {.name = {""}};
    RMAP_TRY(reserve(cells, &of, err));
    fill(image, &of);
    if (cells->uv[0] > 0) {
        first = all;
        RMAP_TRY(rmap_irradiance_uv_init(image, &uv, first, err));
    }
    for (int k = 0; k < COLUMNS; k++) {
        array[k] = column[k];
        array[k].rank = 1;
        array[k].dims[0] = cells->n_facet;
        array[k].data = of.column[k];
    }
    array[COLUMNS] = (struct rmap_grid_array){
        "corner", length, "corners, facet by facet", 2, {cells->n_corner, 3}, of.corner};
    const struct rmap_grid_text text[] = {
        {"criterion", image->criterion ? image->criterion : "all"}, {"objects", of.names}};
    const struct rmap_polygons polygons = {cells->n_facet, of.end, cells->corner,
                                           cells->scene->unit_m};
    st = rmap_output_is(path, ".vtp")
             ? rmap_polygons_write(&polygons, array, END, text, 2, path, err)
             : rmap_grid_write(first, (size_t)(array - first) + COLUMNS + 1, text, 2, path, err);
out:
    rmap_irradiance_uv_fini(&uv);
    fini(&of);
    return st;
}

enum rmap_status rmap_irradiance_write(const struct rmap_irradiance_image *image,
                                       const struct rmap_irradiance_out *out, const char *path,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_figure_cells painted;
    char label[64];
    const bool body = rmap_output_is(path, ".glb") || rmap_output_is(path, ".gltf");
    if (rmap_output_is(path, ".csv"))
        return rmap_whole_file_put(path, put_csv, image, err);
    if (!body && rmap_picture_kind(path) == RMAP_PICTURE_NONE)
        return write_numbers(image, path, err);
    if (!body && out->over_texture)
        return write_texture(image, out, path, err);
    (void)snprintf(label, sizeof label, "%s%s", image->quantity,
                   out->what == RMAP_IRRADIANCE_ABSORBED ? " absorbed" : "");
    RMAP_TRY(choose_colours(image, out, label, &painted, err));
    st = body ? rmap_irradiance_glb_write(&painted, path, err)
              : write_picture(image, out, &painted, path, err);
out:
    return st;
}
