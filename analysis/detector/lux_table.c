/* SPDX-License-Identifier: MIT
 *
 * An image of a plane as lighting programs hand it in.
 */
#include "analysis/detector/lux_table.h"

#include <math.h>
#include <string.h>

#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

static const double spacing_most_m = 10.0;

void rmap_lux_grid_find(const double size_m[2], struct rmap_lux_grid *grid)
{
    const int longer = size_m[0] >= size_m[1] ? 0 : 1;
    const int along = size_m[longer] >= 2.0 * size_m[1 - longer] ? 1 - longer : longer;
    const double d = size_m[along];
    const double p = fmin(0.2 * pow(5.0, log10(d)), spacing_most_m);
    const double n = fmax(rint(d / p), 1.0);
    *grid = (struct rmap_lux_grid){.d_m = d, .most_m = p};
    grid->n[along] = (uint32_t)fmin(n, RMAP_DETECTOR_CELLS_MAX);
    grid->n[1 - along] =
        (uint32_t)fmin(fmax(rint(size_m[1 - along] / (d / n)), 1.0), RMAP_DETECTOR_CELLS_MAX);
}

static void size_of(const struct rmap_detector_bins *bins, double size_m[2])
{
    for (int k = 0; k < 2; k++)
        size_m[k] =
            (bins->stored ? bins->detector->size[k] : bins->high[k] - bins->low[k]) * bins->unit_m;
}

void rmap_lux_grid_bins(struct rmap_detector_bins *bins)
{
    struct rmap_lux_grid grid;
    double size_m[2];
    size_of(bins, size_m);
    rmap_lux_grid_find(size_m, &grid);
    memcpy(bins->n, grid.n, sizeof bins->n);
    bins->stored = false;
}

/* Of column (axis 0) or row k, along its axis: on the detector, in the axes of its cells, or in the
 * world. */
static double place_of(const struct rmap_detector_image *image, int axis, uint32_t k)
{
    const struct rmap_detector_bins *bins = &image->bins;
    const struct rmap_detector *detector = bins->detector;
    const double part = (k + 0.5) / image->n[axis];
    const double at = bins->stored ? (part - 0.5) * detector->size[axis]
                                   : bins->low[axis] + part * (bins->high[axis] - bins->low[axis]);
    if (!image->world || bins->rotate_rad != 0.0 || rmap_detector_along(detector, axis) < 0)
        return at;
    const double zero = rmap_detector_from_world(detector, axis, 0.0);
    return rmap_detector_from_world(detector, axis, 1.0) > zero ? at - zero : zero - at;
}

static const char *name_of(const struct rmap_detector_image *image, int axis)
{
    static const char *const world[] = {"x", "y", "z"};
    static const char *const own[2][2] = {{"x", "y"}, {"x'", "y'"}};
    const bool turned = image->bins.rotate_rad != 0.0;
    const int along = rmap_detector_along(image->detector, axis);
    return image->world && !turned && along >= 0 ? world[along] : own[turned][axis];
}

static double value_at(const struct rmap_detector_image *image, uint32_t i, uint32_t row)
{
    return image->value[i + (size_t)(image->n[1] - 1 - row) * image->n[0]];
}

void rmap_lux_text(double value, char text[32])
{
    (void)snprintf(text, 32, value >= 100.0 && value < 1e6 ? "%.0f" : "%.3g", value);
}

static void describe_grid(const struct rmap_detector_image *image, struct rmap_lux_grid *grid,
                          double spacing_m[2])
{
    double size_m[2];
    size_of(&image->bins, size_m);
    rmap_lux_grid_find(size_m, grid);
    for (int k = 0; k < 2; k++)
        spacing_m[k] = size_m[k] / image->n[k];
}

enum rmap_status rmap_lux_table_print(const struct rmap_detector_image *image, FILE *out,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_uniformity *of = image->uniformity;
    struct rmap_lux_grid grid;
    double spacing_m[2];
    char text[32], average[32], least[32], greatest[32];
    char *alignment = rmap_alloc((size_t)image->n[0] + 2, 1);
    struct rmap_text_table table;
    rmap_text_table_init(&table, (size_t)image->n[0] + 1);
    if (!alignment)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    memset(alignment, 'r', (size_t)image->n[0] + 1);
    rmap_text_table_add(&table, "%s \\ %s", name_of(image, 1), name_of(image, 0));
    for (uint32_t i = 0; i < image->n[0]; i++)
        rmap_text_table_add(&table, "%.4g", place_of(image, 0, i));
    for (uint32_t row = 0; row < image->n[1]; row++) {
        rmap_text_table_add(&table, "%.4g", place_of(image, 1, image->n[1] - 1 - row));
        for (uint32_t i = 0; i < image->n[0]; i++) {
            rmap_lux_text(value_at(image, i, row), text);
            rmap_text_table_add(&table, "%s", text);
        }
    }
    describe_grid(image, &grid, spacing_m);
    fprintf(out, "\n%s, %s; places in %s\n\n", image->quantity, image->unit, image->scene->unit);
    RMAP_TRY(rmap_text_table_print(&table, alignment, out, err));
    rmap_lux_text(image->mean, average);
    rmap_lux_text(of->least.value, least);
    rmap_lux_text(of->greatest.value, greatest);
    fprintf(out, "\naverage %s, minimum %s, maximum %s %s; U0 %.2f, Ud %.2f\n", average, least,
            greatest, image->unit, of->u0.value, of->ud.value);
    fprintf(out, "grid %u x %u points, %.3g x %.3g m apart", image->n[0], image->n[1], spacing_m[0],
            spacing_m[1]);
    fprintf(out, "; EN 12464-1: at most p = %.3g m for d = %.3g m, %u x %u points\n", grid.most_m,
            grid.d_m, grid.n[0], grid.n[1]);
out:
    rmap_text_table_fini(&table);
    rmap_free(alignment);
    return st;
}

void rmap_lux_table_csv(const struct rmap_detector_image *image, const char *criterion, FILE *out)
{
    const struct rmap_uniformity *of = image->uniformity;
    struct rmap_lux_grid grid;
    double spacing_m[2];
    describe_grid(image, &grid, spacing_m);
    fprintf(out, "# detector: %s\n# quantity: %s, %s\n# criterion: %s\n", image->detector->name,
            image->quantity, image->unit, criterion ? criterion : "all");
    rmap_which_csv(image->which, out);
    if (image->dimmed[0])
        fprintf(out, "# dimmed: %s\n", image->dimmed);
    fprintf(out, "# average: %.6g\n# minimum: %.6g\n# maximum: %.6g\n# U0: %.4g\n# Ud: %.4g\n",
            image->mean, of->least.value, of->greatest.value, of->u0.value, of->ud.value);
    fprintf(out, "# spacing: %.6g x %.6g m\n# spacing by EN 12464-1, at most: %.6g m\n",
            spacing_m[0], spacing_m[1], grid.most_m);
    fprintf(out, "%s (down) and %s (across) in %s", name_of(image, 1), name_of(image, 0),
            image->scene->unit);
    for (uint32_t i = 0; i < image->n[0]; i++)
        fprintf(out, ",%.8g", place_of(image, 0, i));
    for (uint32_t row = 0; row < image->n[1]; row++) {
        fprintf(out, "\n%.8g", place_of(image, 1, image->n[1] - 1 - row));
        for (uint32_t i = 0; i < image->n[0]; i++)
            fprintf(out, ",%.8g", value_at(image, i, row));
    }
    fputc('\n', out);
}

void rmap_lux_table_json(const struct rmap_detector_image *image, json_t *document)
{
    struct rmap_lux_grid grid;
    double spacing_m[2];
    json_t *rows = json_array(), *place[2] = {json_array(), json_array()};
    for (int axis = 0; axis < 2; axis++)
        for (uint32_t k = 0; k < image->n[axis]; k++)
            (void)json_array_append_new(
                place[axis],
                rmap_json_number(place_of(image, axis, axis ? image->n[1] - 1 - k : k)));
    for (uint32_t row = 0; row < image->n[1]; row++) {
        json_t *list = json_array();
        for (uint32_t i = 0; i < image->n[0]; i++)
            (void)json_array_append_new(list, rmap_json_number(value_at(image, i, row)));
        (void)json_array_append_new(rows, list);
    }
    describe_grid(image, &grid, spacing_m);
    (void)json_object_set_new(document, "table",
                              json_pack("{s:s, s:s, s:o, s:o, s:o}", "across", name_of(image, 0),
                                        "down", name_of(image, 1), "x", place[0], "y", place[1],
                                        "value", rows));
    (void)json_object_set_new(document, "grid",
                              json_pack("{s:[f, f], s:f, s:f, s:[i, i]}", "spacing", spacing_m[0],
                                        spacing_m[1], "d", grid.d_m, "p", grid.most_m, "points",
                                        (int)grid.n[0], (int)grid.n[1]));
}
