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

static enum rmap_status put_csv(const void *image, FILE *file, struct rmap_error *err)
{
    (void)err;
    rmap_irradiance_image_csv(image, file);
    return RMAP_OK;
}

/* Numbers of cells that are no doubles yet. */
struct numbers {
    double *place[3], *area, *object, *triangle; /* [n_cell] */
    double *corner_end, *corner;                 /* [n_cell], [n_corner][3] */
    size_t *end;
    char *names; /* of the objects, a line each */
};

static void fini(struct numbers *numbers)
{
    for (int k = 0; k < 3; k++)
        rmap_free(numbers->place[k]);
    rmap_free(numbers->area);
    rmap_free(numbers->object);
    rmap_free(numbers->triangle);
    rmap_free(numbers->corner_end);
    rmap_free(numbers->corner);
    rmap_free(numbers->end);
    rmap_free(numbers->names);
}

static enum rmap_status gather(const struct rmap_irradiance_cells *cells, struct numbers *of,
                               struct rmap_error *err)
{
    const size_t n = cells->n_cell;
    double **const column[] = {&of->place[0], &of->place[1], &of->place[2],  &of->area,
                               &of->object,   &of->triangle, &of->corner_end};
    bool good = true;
    size_t length = 1;
    for (size_t i = 0; i < sizeof column / sizeof *column; i++) {
        *column[i] = rmap_alloc(n + 1, sizeof **column[i]);
        good = good && *column[i];
    }
    for (size_t p = 0; p < cells->n_part; p++)
        length += strlen(cells->scene->object[cells->part[p].object].name) + 1;
    of->corner = rmap_alloc(3 * cells->n_corner + 1, sizeof *of->corner);
    of->end = rmap_alloc(n + 1, sizeof *of->end);
    of->names = rmap_alloc(length, 1);
    if (!good || !of->corner || !of->end || !of->names)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu cells", n);
    for (size_t c = 0; c < n; c++) {
        const struct rmap_irradiance_cell *cell = &cells->cell[c];
        const struct rmap_vec3 p = rmap_irradiance_cells_centre(cells, c);
        of->place[0][c] = p.x;
        of->place[1][c] = p.y;
        of->place[2][c] = p.z;
        of->area[c] = cell->area;
        of->object[c] = cell->part;
        of->triangle[c] = cell->triangle;
        of->end[c] = cell->corner + cell->n_corner;
        of->corner_end[c] = (double)of->end[c];
    }
    memcpy(of->corner, cells->corner, 3 * cells->n_corner * sizeof *of->corner);
    for (size_t p = 0, at = 0; p < cells->n_part; p++)
        at += (size_t)snprintf(of->names + at, length - at, "%s%s", p > 0 ? "\n" : "",
                               cells->scene->object[cells->part[p].object].name);
    return RMAP_OK;
}

static enum rmap_status write_numbers(const struct rmap_irradiance_image *image, const char *path,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_cells *cells = image->cells;
    const char *length = cells->scene->unit, *unit = image->unit;
    const size_t n = cells->n_cell;
    struct numbers of = {.area = NULL};
    char error[32];
    (void)snprintf(error, sizeof error, "%s_error", image->quantity);
    RMAP_TRY(gather(cells, &of, err));
    const struct rmap_grid_array array[] = {
        {image->quantity, unit, "flux that arrives, over the area", 1, {n}, image->value[0]},
        {error, unit, "standard error", 1, {n}, image->standard_error[0]},
        {"relative_error",
         "1",
         "standard error over value; NaN: none",
         1,
         {n},
         image->relative_error},
        {"absorbed", unit, "flux that is absorbed, over the area", 1, {n}, image->value[1]},
        {"absorbed_error", unit, "standard error", 1, {n}, image->standard_error[1]},
        {"area", length, "area of the cell, in this unit squared", 1, {n}, of.area},
        {"object", "1", "line of the attribute `objects`, from 0", 1, {n}, of.object},
        {"triangle", "1", "of the object's mesh; -1: of another shape", 1, {n}, of.triangle},
        {"x", length, "middle of the cell", 1, {n}, of.place[0]},
        {"y", length, "middle of the cell", 1, {n}, of.place[1]},
        {"z", length, "middle of the cell", 1, {n}, of.place[2]},
        {"corner_end", "1", "rows of `corner` up to the cell's last", 1, {n}, of.corner_end},
        {"corner", length, "corners, cell by cell", 2, {cells->n_corner, 3}, of.corner}};
    enum { ARRAYS = sizeof array / sizeof *array, OF_CELLS = 8 };
    const struct rmap_grid_text text[] = {
        {"criterion", image->criterion ? image->criterion : "all"}, {"objects", of.names}};
    const struct rmap_polygons polygons = {n, of.end, cells->corner, cells->scene->unit_m};
    st = rmap_output_is(path, ".vtp")
             ? rmap_polygons_write(&polygons, array, OF_CELLS, text, 2, path, err)
             : rmap_grid_write(array, ARRAYS, text, 2, path, err);
out:
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
    (void)snprintf(label, sizeof label, "%s%s", image->quantity,
                   out->what == RMAP_IRRADIANCE_ABSORBED ? " absorbed" : "");
    RMAP_TRY(choose_colours(image, out, label, &painted, err));
    st = body ? rmap_irradiance_glb_write(&painted, path, err)
              : write_picture(image, out, &painted, path, err);
out:
    return st;
}
