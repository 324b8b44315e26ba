/* SPDX-License-Identifier: MIT
 *
 * Irradiance over the textures of objects: arrays and a picture.
 */
#include "mpi/answer/irradiance_uv_out.h"

#include <math.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/table/figure_axes.h"
#include "base/alloc.h"

void rmap_irradiance_uv_fini(struct rmap_irradiance_uv *uv)
{
    for (int k = 0; k < RMAP_IRRADIANCE_UV_ARRAYS; k++)
        rmap_free(uv->data[k]);
}

enum rmap_status rmap_irradiance_uv_init(const struct rmap_irradiance_image *image,
                                         struct rmap_irradiance_uv *uv,
                                         struct rmap_grid_array *array, struct rmap_error *err)
{
    enum { N = RMAP_IRRADIANCE_UV_ARRAYS };
    const struct rmap_irradiance_cells *cells = image->cells;
    const size_t n = (size_t)cells->uv[0] * cells->uv[1] * cells->n_part;
    static const char nothing[] = "NaN: nothing of the surface";
    (void)snprintf(uv->name[0], sizeof uv->name[0], "%s_uv", image->quantity);
    (void)snprintf(uv->name[1], sizeof uv->name[1], "%s_uv_error", image->quantity);
    const struct rmap_grid_array made[N] = {
        {uv->name[0], image->unit, "of each object, rows of its texture, v upwards"},
        {uv->name[1], image->unit, "standard error"},
        {"absorbed_uv", image->unit, nothing},
        {"absorbed_uv_error", image->unit, "standard error"},
        {"area_uv", cells->scene->unit, "of the surface in the cell, in this unit squared"}};
    for (int k = 0; k < N; k++) {
        uv->data[k] = rmap_alloc(n, sizeof *uv->data[k]);
        if (!uv->data[k])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu cells", n);
        array[k] = made[k];
        array[k].rank = 3;
        array[k].dims[0] = cells->n_part;
        array[k].dims[1] = cells->uv[1];
        array[k].dims[2] = cells->uv[0];
        array[k].data = uv->data[k];
    }
    for (size_t i = 0; i < n; i++) {
        const uint32_t c = cells->uv_cell[i];
        const bool none = c == UINT32_MAX;
        const double row[N] = {none ? (double)NAN : image->value[0][c],
                               none ? (double)NAN : image->standard_error[0][c],
                               none ? (double)NAN : image->value[1][c],
                               none ? (double)NAN : image->standard_error[1][c],
                               none ? 0.0 : cells->cell[c].area};
        for (int k = 0; k < N; k++)
            uv->data[k][i] = row[k];
    }
    return RMAP_OK;
}

enum rmap_status rmap_irradiance_uv_figure(const struct rmap_irradiance_image *image,
                                           const struct rmap_irradiance_out *out,
                                           struct rmap_svg **svg_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_cells *cells = image->cells;
    const struct rmap_irradiance_object *all = &image->object[cells->n_part];
    const size_t n = (size_t)cells->uv[0] * cells->uv[1];
    char sums[200], quantity[64], name[100];
    struct rmap_detector detector = {.type = RMAP_DETECTOR_PLANE, .name = name};
    struct rmap_detector_image flat = {.scene = cells->scene,
                                       .detector = &detector,
                                       .bins = {.detector = &detector, .high = {1, 1}},
                                       .quantity = quantity,
                                       .unit = image->unit};
    uint8_t *there = rmap_alloc(n, 1);
    (void)snprintf(name, sizeof name, "%.90s", cells->scene->object[cells->part[0].object].name);
    (void)snprintf(quantity, sizeof quantity, "%s%s", image->quantity,
                   out->what == RMAP_IRRADIANCE_ABSORBED ? " absorbed" : "");
    (void)snprintf(sums, sizeof sums, "mean %.4g ± %.2g %s, %u x %u cells over the texture",
                   all->mean, all->mean_error, rmap_unit_text(image->unit).text, cells->uv[0],
                   cells->uv[1]);
    flat.value = rmap_alloc(n, sizeof *flat.value);
    flat.standard_error = rmap_alloc(n, sizeof *flat.standard_error);
    if (!there || !flat.value || !flat.standard_error)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture"));
    for (int k = 0; k < 2; k++)
        flat.bins.n[k] = flat.n[k] = cells->uv[k];
    for (size_t i = 0; i < n; i++) {
        const uint32_t c = cells->uv_cell[i];
        there[i] = c != UINT32_MAX;
        flat.value[i] = there[i] ? image->value[out->what][c] : 0.0;
        flat.standard_error[i] = there[i] ? image->standard_error[out->what][c] : 0.0;
        flat.peak = fmax(flat.peak, flat.value[i]);
    }
    /* slivers of surface have few rays: as on bodies, what is sure is the top */
    flat.peak = rmap_value_scale_sure(flat.value, flat.standard_error, n, flat.peak);
    const struct rmap_figure_detector figure = {.criterion = image->criterion,
                                                .sums = sums,
                                                .scale = out->scale,
                                                .there = there,
                                                .uv = true};
    st = rmap_figure_detector(&flat, &figure, svg_ret, err);
out:
    rmap_free(there);
    rmap_free(flat.value);
    rmap_free(flat.standard_error);
    return st;
}
