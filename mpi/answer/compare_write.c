/* SPDX-License-Identifier: MIT
 *
 * Files of `raymap compare`.
 */
#include "mpi/answer/compare_write.h"

#include "analysis/compare/compare_out.h"
#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_difference.h"
#include "base/alloc.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "mpi/answer/grid_out.h"
#include "mpi/command/json_out.h"
#include "mpi/command/output.h"

const char *const rmap_compare_suffixes[] = {".csv", ".json", ".h5", ".npz", ".png", ".svg", NULL};

static enum rmap_status print_json(const struct rmap_comparison *comparison,
                                   const struct rmap_compare_bins *const *bins, size_t n_bins,
                                   FILE *out, struct rmap_error *err)
{
    json_t *document = rmap_comparison_json(comparison), *list = json_array();
    for (size_t i = 0; i < n_bins; i++)
        (void)json_array_append_new(list, rmap_compare_bins_json(bins[i]));
    (void)json_object_set_new(document, "bins", list);
    return rmap_json_print(document, out, err);
}

static enum rmap_status write_text(const struct rmap_comparison *comparison,
                                   const struct rmap_compare_bins *const *bins, size_t n_bins,
                                   const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    if (rmap_output_is(path, ".json"))
        RMAP_TRY(print_json(comparison, bins, n_bins, whole.file, err));
    else
        rmap_compare_bins_csv(comparison, bins[0], whole.file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

static enum rmap_status write_arrays(const struct rmap_comparison *comparison,
                                     const struct rmap_compare_bins *bins, const char *path,
                                     struct rmap_error *err)
{
    const int rank = bins->is_image ? 2 : 1;
    const size_t slow = bins->is_image ? bins->n[1] : bins->n[0], fast = bins->n[0];
    const char *unit = bins->unit, *own = "of the same bin";
    const char *axis = *bins->axis_unit ? bins->axis_unit : "1";
    const struct rmap_grid_array across = {rmap_compare_bins_axis(bins, 0),
                                           axis,
                                           "middle of the cell",
                                           rank,
                                           {slow, fast},
                                           bins->place[0]};
    const struct rmap_grid_array edges = {"edges",          axis,      "edges of the bins", 1,
                                          {bins->n[0] + 1}, bins->edge};
    const struct rmap_grid_array array[] = {
        {"difference", unit, "first sample less second", rank, {slow, fast}, bins->difference},
        {"standard_error",
         unit,
         "of the difference, were both samples the same",
         rank,
         {slow, fast},
         bins->standard_error},
        {"z", "1", "difference over its standard error", rank, {slow, fast}, bins->z},
        {"a", unit, "first sample", rank, {slow, fast}, bins->value[0]},
        {"a_standard_error", unit, own, rank, {slow, fast}, bins->error[0]},
        {"b", unit, "second sample", rank, {slow, fast}, bins->value[1]},
        {"b_standard_error", unit, own, rank, {slow, fast}, bins->error[1]},
        bins->is_image ? across : edges,
        {rmap_compare_bins_axis(bins, 1),
         axis,
         "middle of the cell",
         rank,
         {slow, fast},
         bins->place[1]}};
    const struct rmap_grid_text text[] = {
        {"of", bins->name},
        {"quantity", bins->quantity},
        {"a", comparison->path[0]},
        {"a_criterion", comparison->criterion[0] ? comparison->criterion[0] : "all"},
        {"b", comparison->path[1]},
        {"b_criterion", comparison->criterion[1] ? comparison->criterion[1] : "all"},
        {"a_which", comparison->which[0] ? comparison->which[0]->text : "all"},
        {"b_which", comparison->which[1] ? comparison->which[1]->text : "all"}};
    const size_t n_array = sizeof array / sizeof *array - (bins->is_image ? 0 : 1);
    return rmap_grid_write(array, n_array, text, sizeof text / sizeof *text, path, err);
}

enum rmap_status rmap_compare_write(const struct rmap_comparison *comparison,
                                    const struct rmap_compare_bins *const *bins, size_t n_bins,
                                    const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    if (n_bins == 0 && !rmap_output_is(path, ".json"))
        return rmap_error_set(err, RMAP_INPUT,
                              "no ray of either sample has a value: there is nothing to write");
    if (rmap_output_is(path, ".csv") || rmap_output_is(path, ".json"))
        return write_text(comparison, bins, n_bins, path, err);
    if (rmap_picture_kind(path) == RMAP_PICTURE_NONE)
        return write_arrays(comparison, bins[0], path, err);
    RMAP_TRY(rmap_figure_difference(comparison, bins[0], &svg, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    return st;
}
