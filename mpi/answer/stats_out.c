/* SPDX-License-Identifier: MIT
 *
 * Statistics as files.
 */
#include "mpi/answer/stats_out.h"

#include <stdio.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_stats.h"
#include "base/alloc.h"
#include "io/export/npy.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "io/hdf5/grid_h5.h"
#include "mpi/command/json_out.h"
#include "mpi/command/output.h"

const char *const rmap_stats_suffixes[] = {".csv", ".json", ".h5",  ".npz",
                                           ".npy", ".png",  ".svg", NULL};

static enum rmap_status write_text(const struct rmap_stats *stats,
                                   const struct rmap_stats_labels *labels, const char *path,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    if (rmap_output_is(path, ".csv"))
        rmap_stats_csv(stats, labels, whole.file);
    else
        RMAP_TRY(rmap_json_print(rmap_stats_json(stats, labels), whole.file, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

/* What there is, as arrays. Of several groups: one after the other along the first axis. */
enum { ARRAYS_MAX = 9, N_MOMENT = 5 };
struct arrays {
    struct rmap_grid_array array[ARRAYS_MAX];
    size_t n, n_shown;
    double *memory[ARRAYS_MAX];
    size_t n_memory;
};

static void arrays_fini(struct arrays *arrays)
{
    for (size_t i = 0; i < arrays->n_memory; i++)
        rmap_free(arrays->memory[i]);
}

static double *take_memory(struct arrays *arrays, size_t n)
{
    double *memory = rmap_alloc(n + 1, sizeof *memory);
    arrays->memory[arrays->n_memory++] = memory;
    return memory;
}

static enum rmap_status out_of_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file of statistics");
}

/* flux, standard_error and rays of every bin. */
static enum rmap_status add_cells(const struct rmap_stats *stats, struct arrays *arrays,
                                  struct rmap_error *err)
{
    const struct rmap_bins *bins = stats->plan->bins;
    const bool two = stats->setup->quantities->n == 2, grouped = stats->group[0].name != NULL;
    const size_t n = stats->plan->n_cell;
    double *flux = take_memory(arrays, arrays->n_shown * n);
    double *error = take_memory(arrays, arrays->n_shown * n);
    double *rays = take_memory(arrays, arrays->n_shown * n);
    if (!flux || !error || !rays)
        return out_of_memory(err);
    for (size_t g = 0, at = 0; g < stats->n_group; g++)
        for (size_t c = 0; rmap_stats_shows(stats, g) && c < n; c++, at++) {
            flux[at] = stats->group[g].cell[c].value;
            error[at] = stats->group[g].cell[c].standard_error;
            rays[at] = stats->group[g].cell_rays[c];
        }
    const char *unit = rmap_stats_flux_unit(stats);
    struct rmap_grid_array list[] = {
        {.name = "flux", .unit = unit, .description = "flux in the bin", .data = flux},
        {.name = "standard_error", .unit = unit, .description = "of flux", .data = error},
        {.name = "rays", .unit = "1", .description = "rays with a value in the bin", .data = rays}};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        if (grouped)
            list[i].dims[list[i].rank++] = arrays->n_shown;
        if (two)
            list[i].dims[list[i].rank++] = bins[1].n;
        list[i].dims[list[i].rank++] = bins[0].n;
        arrays->array[arrays->n++] = list[i];
    }
    return RMAP_OK;
}

/* Edges, moments and quantiles of one quantity. */
static enum rmap_status add_quantity(const struct rmap_stats *stats, size_t i,
                                     struct arrays *arrays, struct rmap_error *err)
{
    static const char *const name[3][3] = {{"edges", "moments", "quantiles"},
                                           {"x_edges", "x_moments", "x_quantiles"},
                                           {"y_edges", "y_moments", "y_quantiles"}};
    const char *const *own = name[stats->setup->quantities->n == 1 ? 0 : 1 + i];
    const char *unit = stats->setup->quantities->of[i].unit;
    const size_t n_quantile = stats->n_quantile, n_shown = arrays->n_shown;
    double *moments = take_memory(arrays, n_shown * N_MOMENT * 2);
    double *quantiles = take_memory(arrays, n_shown * n_quantile * 3);
    if (!moments || !quantiles)
        return out_of_memory(err);
    double *to = moments, *into = quantiles;
    for (size_t g = 0; g < stats->n_group; g++) {
        const struct rmap_stats_summary *of = &stats->group[g].of[i];
        const struct rmap_stats_estimate list[N_MOMENT] = {
            stats->group[g].flux, of->moment.mean, of->moment.deviation, of->moment.skewness,
            of->moment.kurtosis};
        if (!rmap_stats_shows(stats, g))
            continue;
        for (size_t k = 0; k < N_MOMENT; k++) {
            *to++ = list[k].value;
            *to++ = list[k].standard_error;
        }
        for (size_t k = 0; k < n_quantile; k++) {
            *into++ = stats->p[k];
            *into++ = of->quantile[k].value;
            *into++ = of->quantile[k].standard_error;
        }
    }
    const struct rmap_bins *bins = &stats->plan->bins[i];
    unit = *unit ? unit : "1";
    arrays->array[arrays->n++] =
        (struct rmap_grid_array){own[0], unit, "edges of the bins", 1, {bins->n + 1}, bins->edge};
    arrays->array[arrays->n++] = (struct rmap_grid_array){
        own[1],
        unit,
        "flux, mean, standard deviation, skewness, kurtosis: value and standard error; flux in its "
        "own unit, the last two without",
        3,
        {n_shown, N_MOMENT, 2},
        moments};
    if (n_quantile > 0)
        arrays->array[arrays->n++] = (struct rmap_grid_array){
            own[2],   unit, "share of flux, value, standard error", 3, {n_shown, n_quantile, 3},
            quantiles};
    return RMAP_OK;
}

static enum rmap_status write_numpy(const struct arrays *arrays, const char *path,
                                    struct rmap_error *err)
{
    struct rmap_npy_array npy[ARRAYS_MAX];
    for (size_t i = 0; i < arrays->n; i++) {
        const struct rmap_grid_array *from = &arrays->array[i];
        npy[i] =
            (struct rmap_npy_array){.name = from->name, .rank = from->rank, .data = from->data};
        for (int k = 0; k < from->rank; k++)
            npy[i].dims[k] = from->dims[k];
    }
    return rmap_output_is(path, ".npy") ? rmap_npy_write(&npy[0], path, err)
                                        : rmap_npz_write(npy, arrays->n, path, err);
}

static enum rmap_status write_h5(const struct rmap_stats *stats,
                                 const struct rmap_stats_labels *labels,
                                 const struct arrays *arrays, const char *path,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t nbytes = 1;
    for (size_t g = 0; g < stats->n_group; g++)
        nbytes += stats->group[g].name ? strlen(stats->group[g].name) + 1 : 0;
    char *groups = rmap_alloc(nbytes, 1), of[2][128] = {"", ""};
    if (!groups)
        return out_of_memory(err);
    size_t at = 0;
    for (size_t g = 0; g < stats->n_group && stats->group[g].name; g++)
        if (rmap_stats_shows(stats, g)) {
            at += (size_t)snprintf(groups + at, nbytes - at, "%s%s", at > 0 ? "\n" : "",
                                   stats->group[g].name);
        }
    for (size_t i = 0; i < stats->setup->quantities->n; i++)
        rmap_stats_name(stats, i, of[i], sizeof of[i]);
    const bool two = stats->setup->quantities->n == 2;
    const struct rmap_grid_text text[] = {
        {"criterion", labels->criterion ? labels->criterion : "all"},
        {"which", labels->which ? labels->which->text : "all"},
        {two ? "x" : "of", of[0]},
        {two ? "y" : "groups", two ? of[1] : groups},
        {"groups", groups}};
    st = rmap_grid_h5_write(path, arrays->array, arrays->n, text, two ? 5 : 4, err);
    rmap_free(groups);
    return st;
}

static enum rmap_status write_arrays(const struct rmap_stats *stats,
                                     const struct rmap_stats_labels *labels, const char *path,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct arrays arrays = {0};
    for (size_t g = 0; g < stats->n_group; g++)
        arrays.n_shown += rmap_stats_shows(stats, g);
    RMAP_TRY(add_cells(stats, &arrays, err));
    for (size_t i = 0; i < stats->setup->quantities->n; i++)
        RMAP_TRY(add_quantity(stats, i, &arrays, err));
    if (rmap_output_is(path, ".h5"))
        st = write_h5(stats, labels, &arrays, path, err);
    else
        st = write_numpy(&arrays, path, err);
out:
    arrays_fini(&arrays);
    return st;
}

enum rmap_status rmap_stats_write(const struct rmap_stats *stats,
                                  const struct rmap_stats_labels *labels, const char *path,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    if (rmap_output_is(path, ".csv") || rmap_output_is(path, ".json"))
        return write_text(stats, labels, path, err);
    if (rmap_picture_kind(path) == RMAP_PICTURE_NONE)
        return write_arrays(stats, labels, path, err);
    RMAP_TRY(rmap_figure_stats(stats, labels, &svg, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    return st;
}
