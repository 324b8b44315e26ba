/* SPDX-License-Identifier: MIT
 *
 * Irradiance or illuminance on the cells of objects, with standard errors.
 */
#include "analysis/detector/irradiance_image.h"

#include <math.h>
#include <stdlib.h>

#include "analysis/detector/detector_image.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_number.h"

static const struct rmap_scene *scene_of(const struct rmap_irradiance_image *image)
{
    return image->cells->scene;
}

static enum rmap_status reserve(struct rmap_irradiance_image *image, struct rmap_error *err)
{
    const size_t n = image->cells->n_cell;
    bool good = true;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        image->value[k] = rmap_alloc(n + 1, sizeof(double));
        image->standard_error[k] = rmap_alloc(n + 1, sizeof(double));
        good = good && image->value[k] && image->standard_error[k];
    }
    image->relative_error = rmap_alloc(n + 1, sizeof(double));
    image->object = rmap_alloc(image->cells->n_part + 1, sizeof *image->object);
    return good && image->relative_error && image->object
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu cells", n);
}

/* size: m2 of the scene's unit squared; unit: W/m2 or lx of the image's. */
static void fill_cells(const struct rmap_irradiance_sums *sums, double size, double unit,
                       struct rmap_irradiance_image *image)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    for (size_t c = 0; c < cells->n_cell; c++)
        for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
            double flux, error;
            const double area = cells->cell[c].area * size * unit / sums->unit;
            rmap_cell_sums_flux(&sums->cell[k], sums->ask->map, c, &flux, &error);
            image->value[k][c] = area > 0.0 ? flux / area : 0.0;
            image->standard_error[k][c] = area > 0.0 ? error / area : 0.0;
        }
    for (size_t c = 0; c < cells->n_cell; c++) {
        image->n_empty += image->value[0][c] > 0.0 ? 0 : 1;
        image->relative_error[c] = image->value[0][c] > 0.0
                                       ? image->standard_error[0][c] / image->value[0][c]
                                       : (double)NAN;
    }
}

/* Of a part; n_part: of all. */
static void fill_object(const struct rmap_irradiance_sums *sums, size_t part, double size,
                        double unit, struct rmap_irradiance_image *image)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    const bool all = part == cells->n_part;
    struct rmap_irradiance_object *of = &image->object[part];
    const size_t first = all ? 0 : cells->part[part].first;
    const size_t n = all ? cells->n_cell : cells->part[part].n;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        rmap_cell_sums_flux(&sums->object[k], sums->ask->map, part, &of->flux[k],
                            &of->flux_error[k]);
        of->flux[k] *= sums->unit;
        of->flux_error[k] *= sums->unit;
    }
    of->least = of->greatest = first;
    for (size_t c = first; c < first + n; c++) {
        of->least = image->value[0][c] < image->value[0][of->least] ? c : of->least;
        of->greatest = image->value[0][c] > image->value[0][of->greatest] ? c : of->greatest;
    }
    for (size_t p = 0; p < cells->n_part; p++)
        of->area_m2 += all || p == part ? cells->part[p].area * size : 0.0;
    of->mean = of->area_m2 > 0.0 ? of->flux[0] / (of->area_m2 * unit) : 0.0;
    of->mean_error = of->area_m2 > 0.0 ? of->flux_error[0] / (of->area_m2 * unit) : 0.0;
}

static int ascending(const void *a, const void *b)
{
    const double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

static enum rmap_status find_usual_error(struct rmap_irradiance_image *image,
                                         struct rmap_error *err)
{
    size_t n = 0;
    double *known = rmap_alloc(image->cells->n_cell + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    for (size_t c = 0; c < image->cells->n_cell; c++)
        if (isfinite(image->relative_error[c]))
            known[n++] = image->relative_error[c];
    qsort(known, n, sizeof *known, ascending);
    image->usual_error = n > 0 ? known[n / 2] : (double)NAN;
    rmap_free(known);
    return RMAP_OK;
}

enum rmap_status rmap_irradiance_image_create(const struct rmap_irradiance_sums *sums,
                                              const char *unit,
                                              struct rmap_irradiance_image **image_ret,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_ask *ask = sums->ask;
    const struct rmap_scene *scene = ask->cells->scene;
    const enum rmap_flux_unit flux = ask->luminous ? RMAP_FLUX_LM : scene->flux_unit;
    const double size = scene->unit_m * scene->unit_m;
    const struct rmap_image_unit *its = NULL;
    struct rmap_irradiance_image *image = rmap_alloc(1, sizeof *image);
    if (!image)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    image->cells = ask->cells;
    image->side = ask->side;
    RMAP_TRY(rmap_image_unit_find(RMAP_PER_AREA, flux, unit, &its, err));
    image->quantity = flux == RMAP_FLUX_LM ? "illuminance" : "irradiance";
    image->unit = its->name;
    image->flux_unit = rmap_image_unit_usual(RMAP_PER_CELL, flux)->name;
    RMAP_TRY(reserve(image, err));
    fill_cells(sums, size, its->size, image);
    for (size_t p = 0; p <= image->cells->n_part; p++)
        fill_object(sums, p, size, its->size, image);
    RMAP_TRY(find_usual_error(image, err));
    RMAP_TRY(rmap_uniformity_find(image->value[0], image->standard_error[0], image->cells->n_cell,
                                  image->object[image->cells->n_part].mean, &image->uniformity,
                                  err));
    *image_ret = image;
    image = NULL;
out:
    rmap_irradiance_image_destroy(image);
    return st;
}

void rmap_irradiance_image_destroy(struct rmap_irradiance_image *image)
{
    if (!image)
        return;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        rmap_free(image->value[k]);
        rmap_free(image->standard_error[k]);
    }
    rmap_free(image->relative_error);
    rmap_free(image->object);
    rmap_free(image);
}

/* ---- text ---- */

static const char *asked(const struct rmap_irradiance_image *image)
{
    return image->criterion ? image->criterion : "all";
}

static const char *side_word(const struct rmap_irradiance_image *image)
{
    static const char *const word[] = {
        [RMAP_SIDE_FRONT] = "front", [RMAP_SIDE_BACK] = "back", [RMAP_SIDE_BOTH] = "both"};
    return word[image->side];
}

static const char *name_of(const struct rmap_irradiance_image *image, size_t part)
{
    return scene_of(image)->object[image->cells->part[part].object].name;
}

void rmap_irradiance_image_csv(const struct rmap_irradiance_image *image, FILE *out)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    fprintf(out, "# criterion: %s\n# side: %s\n# length unit: %s\n# %s: %s\n# absorbed: %s\n",
            asked(image), side_word(image), scene_of(image)->unit, image->quantity, image->unit,
            image->unit);
    fprintf(out,
            "object,cell,triangle,x,y,z,area,%s,%s_error,relative_error,absorbed,"
            "absorbed_error%s\n",
            image->quantity, image->quantity, cells->uv[0] > 0 ? ",column,row" : "");
    for (size_t c = 0; c < cells->n_cell; c++) {
        const struct rmap_irradiance_cell *cell = &cells->cell[c];
        const struct rmap_vec3 p = cells->cell[c].centre;
        rmap_csv_put_first(name_of(image, cell->part), out);
        fprintf(out, ",%zu,", c);
        if (cell->triangle >= 0)
            fprintf(out, "%d", (int)cell->triangle);
        fprintf(out, ",%.10g,%.10g,%.10g,%.10g", p.x, p.y, p.z, cell->area);
        rmap_csv_put_estimate(image->value[0][c], image->standard_error[0][c], out);
        fprintf(out, isfinite(image->relative_error[c]) ? ",%.7g" : ",", image->relative_error[c]);
        rmap_csv_put_estimate(image->value[1][c], image->standard_error[1][c], out);
        if (cells->uv[0] > 0)
            fprintf(out, ",%u,%u", cell->uv % cells->uv[0], cell->uv / cells->uv[0]);
        fputc('\n', out);
    }
}

static enum rmap_status print_objects(const struct rmap_irradiance_image *image, FILE *out,
                                      struct rmap_error *err)
{
    struct rmap_text_table table;
    enum { COLUMNS = 7 };
    const char *const head[COLUMNS] = {"object", "cells",    "area/m2", "mean",
                                       "least",  "greatest", "absorbed"};
    rmap_text_table_init(&table, COLUMNS);
    for (int k = 0; k < COLUMNS; k++)
        rmap_text_table_add(&table, "%s", head[k]);
    for (size_t p = 0; p < image->cells->n_part; p++) {
        const struct rmap_irradiance_object *of = &image->object[p];
        rmap_text_table_add(&table, "%s", name_of(image, p));
        rmap_text_table_add(&table, "%zu", image->cells->part[p].n);
        rmap_text_table_add(&table, "%.5g", of->area_m2);
        rmap_text_table_add(&table, "%.5g +- %.2g %s", of->mean, of->mean_error, image->unit);
        rmap_text_table_add(&table, "%.4g", image->value[0][of->least]);
        rmap_text_table_add(&table, "%.4g", image->value[0][of->greatest]);
        rmap_text_table_add(&table, "%.5g %s", of->flux[1], image->flux_unit);
    }
    const enum rmap_status st = rmap_text_table_print(&table, "lrrrrrr", out, err);
    rmap_text_table_fini(&table);
    return st;
}

enum rmap_status rmap_irradiance_image_print(const struct rmap_irradiance_image *image, FILE *out,
                                             struct rmap_error *err)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    const struct rmap_irradiance_object *all = &image->object[cells->n_part];
    const struct rmap_uniformity *even = &image->uniformity;
    char n_cell[RMAP_GROUPED_LEN];
    fprintf(out, "%-14s %s on %s, %.6g m2, %s", "cells", rmap_grouped(cells->n_cell, n_cell),
            rmap_counted(cells->n_part, "object").text, all->area_m2,
            image->side == RMAP_SIDE_BOTH ? "both sides" : side_word(image));
    if (isfinite(cells->length))
        fprintf(out, ", about %.4g %s long", cells->length, scene_of(image)->unit);
    if (cells->uv[0] > 0)
        fprintf(out, ", of %u x %u over the texture", cells->uv[0], cells->uv[1]);
    fprintf(out, "\n%-14s %s\n", "rays", asked(image));
    fprintf(out, "%-14s %.6g +- %.2g %s arrive, %.6g +- %.2g %s are absorbed\n", "flux",
            all->flux[0], all->flux_error[0], image->flux_unit, all->flux[1], all->flux_error[1],
            image->flux_unit);
    fprintf(out, "%-14s mean %.6g +- %.2g %s\n", image->quantity, all->mean, all->mean_error,
            image->unit);
    if (!(all->mean > 0.0))
        return RMAP_OK;
    const struct rmap_vec3 p = cells->cell[all->greatest].centre;
    rmap_biased_print("least", &even->least, image->unit, out);
    rmap_biased_print("greatest", &even->greatest, image->unit, out);
    fprintf(out, "%-14s (%.6g, %.6g, %.6g) %s on %s\n", "it lies at", p.x, p.y, p.z,
            scene_of(image)->unit, name_of(image, cells->cell[all->greatest].part));
    rmap_biased_print("U0", &even->u0, "least / mean", out);
    if (isfinite(image->usual_error))
        fprintf(out, "%-14s %.2g %% of a cell's value (median)\n", "error",
                100.0 * image->usual_error);
    if (image->n_empty > 0)
        fprintf(out,
                "%-14s %zu of %zu cells: what is least there, more rays or longer --cells tell\n",
                "empty", image->n_empty, cells->n_cell);
    return cells->n_part > 1 ? print_objects(image, out, err) : RMAP_OK;
}

static json_t *estimate(double value, double error)
{
    return json_pack("{s:o, s:o}", "value", rmap_json_number(value), "standard_error",
                     rmap_json_number(error));
}

static json_t *object_json(const struct rmap_irradiance_image *image, size_t part)
{
    const struct rmap_irradiance_object *of = &image->object[part];
    return json_pack("{s:s, s:I, s:o, s:o, s:o, s:o, s:o, s:o}", "object", name_of(image, part),
                     "cells", (json_int_t)image->cells->part[part].n, "area_m2",
                     rmap_json_number(of->area_m2), "mean", estimate(of->mean, of->mean_error),
                     "least", rmap_json_number(image->value[0][of->least]), "greatest",
                     rmap_json_number(image->value[0][of->greatest]), "flux",
                     estimate(of->flux[0], of->flux_error[0]), "absorbed",
                     estimate(of->flux[1], of->flux_error[1]));
}

static json_t *peak_json(const struct rmap_irradiance_image *image)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    const size_t c = image->object[cells->n_part].greatest;
    const struct rmap_vec3 p = cells->cell[c].centre;
    if (!(image->value[0][c] > 0.0))
        return json_null();
    return json_pack("{s:o, s:o, s:[f, f, f], s:s, s:I}", "value",
                     rmap_json_number(image->value[0][c]), "standard_error",
                     rmap_json_number(image->standard_error[0][c]), "at", p.x, p.y, p.z, "object",
                     name_of(image, cells->cell[c].part), "cell", (json_int_t)c);
}

json_t *rmap_irradiance_image_json(const struct rmap_irradiance_image *image)
{
    const struct rmap_irradiance_cells *cells = image->cells;
    const struct rmap_irradiance_object *all = &image->object[cells->n_part];
    json_t *objects = json_array();
    for (size_t p = 0; p < cells->n_part; p++)
        (void)json_array_append_new(objects, object_json(image, p));
    json_t *document = json_pack(
        "{s:s, s:s, s:s, s:s, s:I, s:o, s:s, s:o, s:o, s:o, s:o, s:s, s:o, s:I, s:o}", "criterion",
        asked(image), "side", side_word(image), "quantity", image->quantity, "unit", image->unit,
        "cells", (json_int_t)cells->n_cell, "length", rmap_json_number(cells->length),
        "length_unit", scene_of(image)->unit, "area_m2", rmap_json_number(all->area_m2), "mean",
        estimate(all->mean, all->mean_error), "flux", estimate(all->flux[0], all->flux_error[0]),
        "absorbed", estimate(all->flux[1], all->flux_error[1]), "flux_unit", image->flux_unit,
        "peak", peak_json(image), "empty", (json_int_t)image->n_empty, "median_relative_error",
        rmap_json_number(image->usual_error));
    if (!document) {
        json_decref(objects);
        return NULL;
    }
    rmap_uniformity_describe(&image->uniformity, document);
    (void)json_object_set_new(document, "objects", objects);
    if (cells->uv[0] > 0)
        (void)json_object_set_new(
            document, "uv",
            json_pack("{s:I, s:I, s:I, s:I}", "columns", (json_int_t)cells->uv[0], "rows",
                      (json_int_t)cells->uv[1], "covered_twice", (json_int_t)cells->n_twice,
                      "triangles_without", (json_int_t)cells->n_without));
    return document;
}
