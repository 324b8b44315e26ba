/* SPDX-License-Identifier: MIT
 *
 * Index fields and others on a regular grid, from an HDF5 file of anybody's making.
 */
#include <hdf5.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"
#include "base/unit.h"
#include "io/file/input_file.h"
#include "io/hdf5/h5_inside.h"
#include "io/mesh/bundle.h"

/* An open file and dataset; what goes wrong is reported with both. */
struct source {
    const struct rmap_grid_file *file;
    const char *dataset;
    hid_t h5, set;
    struct rmap_error *err;
};

static enum rmap_status wrong(const struct source *from, const char *what)
{
    return rmap_error_set(from->err, RMAP_INPUT, "%s: dataset '%s' %s", from->file->path,
                          from->dataset, what);
}

/* ---- attributes ---- */

/* n numbers; left alone where there is no such attribute. */
static enum rmap_status get_numbers(const struct source *from, const char *name, double *value,
                                    int n, bool *found)
{
    char text[160];
    *found = H5Aexists(from->set, name) > 0;
    if (!*found)
        return RMAP_OK;
    hid_t attribute = H5Aopen(from->set, name, H5P_DEFAULT);
    hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    H5T_class_t kind = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
    bool good = (kind == H5T_FLOAT || kind == H5T_INTEGER) &&
                H5Sget_simple_extent_npoints(space) == n &&
                H5Aread(attribute, H5T_NATIVE_DOUBLE, value) >= 0;
    (void)H5Tclose(type);
    (void)H5Sclose(space);
    (void)H5Aclose(attribute);
    (void)snprintf(text, sizeof text, "has an attribute '%s' that is not %d numbers", name, n);
    return good ? RMAP_OK : wrong(from, text);
}

/* A word of less than 32 letters, empty where there is no such attribute. */
static enum rmap_status get_word(const struct source *from, const char *name, char word[32])
{
    char text[160];
    word[0] = 0;
    if (H5Aexists(from->set, name) <= 0)
        return RMAP_OK;
    hid_t attribute = H5Aopen(from->set, name, H5P_DEFAULT);
    hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute), memory = H5Tcopy(type);
    bool good =
        type >= 0 && H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1;
    if (good && H5Tis_variable_str(type)) {
        char *held = NULL;
        good = H5Aread(attribute, memory, (void *)&held) >= 0 && held && strlen(held) < 32;
        if (good)
            memcpy(word, held, strlen(held) + 1);
        (void)H5free_memory(held);
    } else if (good) {
        char held[33] = {0};
        good = H5Tset_size(memory, 32) >= 0 && H5Aread(attribute, memory, held) >= 0;
        memcpy(word, held, 32);
        word[31] = 0;
    }
    (void)H5Tclose(memory);
    (void)H5Tclose(type);
    (void)H5Sclose(space);
    (void)H5Aclose(attribute);
    (void)snprintf(text, sizeof text, "has an attribute '%s' that is no word", name);
    return good ? RMAP_OK : wrong(from, text);
}

/* ---- where it lies ---- */

struct frame {
    size_t n[3];    /* of x, y, z */
    int axis_of[3]; /* of the dataset's index k */
    double origin[3], spacing[3];
};

static enum rmap_status find_axes(const struct source *from, struct frame *frame)
{
    enum rmap_status st = RMAP_OK;
    char word[32] = "";
    const char *axes = from->file->axes;
    if (!axes) {
        RMAP_TRY(get_word(from, "axes", word));
        axes = word[0] ? word : "xyz";
    }
    bool seen[3] = {false, false, false};
    for (int k = 0; k < 3 && strlen(axes) == 3; k++) {
        frame->axis_of[k] = axes[k] - 'x';
        if (axes[k] >= 'x' && axes[k] <= 'z')
            seen[axes[k] - 'x'] = true;
    }
    if (!seen[0] || !seen[1] || !seen[2])
        st = rmap_error_set(from->err, RMAP_INPUT,
                            "%s: 'axes' names the dataset's indices in order, as xyz or zyx, not "
                            "'%s'",
                            from->file->path, axes);
out:
    return st;
}

static enum rmap_status find_extent(const struct source *from, struct frame *frame)
{
    hsize_t dims[H5S_MAX_RANK];
    hid_t space = H5Dget_space(from->set);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank == 3)
        (void)H5Sget_simple_extent_dims(space, dims, NULL);
    (void)H5Sclose(space);
    if (rank != 3)
        return rmap_error_set(from->err, RMAP_INPUT,
                              "%s: dataset '%s' has %d dimension%s, a grid has 3", from->file->path,
                              from->dataset, rank, rank == 1 ? "" : "s");
    for (int k = 0; k < 3; k++)
        frame->n[frame->axis_of[k]] = (size_t)dims[k];
    return RMAP_OK;
}

/* Metres of the unit in which the attributes are. */
static enum rmap_status find_unit(const struct source *from, double *factor)
{
    enum rmap_status st = RMAP_OK;
    char word[32];
    double unit_m = from->file->length_unit_m;
    if (!(unit_m > 0)) {
        RMAP_TRY(get_word(from, "length_unit", word));
        const struct rmap_written_unit *unit = rmap_unit_of_scene(word, RMAP_DIMENSION_LENGTH);
        unit_m = unit ? unit->size : word[0] ? 0 : from->file->unit_m;
        if (!(unit_m > 0))
            RMAP_TRY(rmap_error_set(from->err, RMAP_INPUT,
                                    "%s: unknown length_unit '%s'; known: nm, um, mm, cm, m, in",
                                    from->file->path, word));
    }
    *factor = unit_m / from->file->unit_m;
out:
    return st;
}

/* What the scene says, else the attribute of either name. */
static enum rmap_status find_vector(const struct source *from, const double said[3],
                                    const char *name, const char *other, double value[3],
                                    bool *found)
{
    enum rmap_status st = RMAP_OK;
    *found = !isnan(said[0]);
    for (int i = 0; i < 3; i++)
        value[i] = said[i];
    if (!*found)
        RMAP_TRY(get_numbers(from, name, value, 3, found));
    if (!*found && other)
        RMAP_TRY(get_numbers(from, other, value, 3, found));
out:
    return st;
}

static enum rmap_status place(const struct source *from, struct frame *frame)
{
    enum rmap_status st = RMAP_OK;
    double lower[3], upper[3], spacing[3], factor = 1;
    bool has_lower = false, has_upper = false, has_spacing = false;
    RMAP_TRY(find_axes(from, frame));
    RMAP_TRY(find_extent(from, frame));
    RMAP_TRY(find_unit(from, &factor));
    RMAP_TRY(find_vector(from, from->file->lower, "origin", "lower", lower, &has_lower));
    RMAP_TRY(find_vector(from, from->file->spacing, "spacing", NULL, spacing, &has_spacing));
    if (!has_spacing || !isnan(from->file->upper[0]))
        RMAP_TRY(find_vector(from, from->file->upper, "upper", NULL, upper, &has_upper));
    if (!has_lower || (!has_spacing && !has_upper))
        RMAP_TRY(wrong(from, "does not say where it lies, nor does the scene: give 'origin' and "
                             "'spacing', or 'lower' and 'upper'"));
    for (int i = 0; i < 3; i++) {
        frame->origin[i] = factor * lower[i];
        frame->spacing[i] =
            factor * (has_upper ? (upper[i] - lower[i]) / ((double)frame->n[i] - 1) : spacing[i]);
    }
out:
    return st;
}

/* ---- numbers ---- */

/* From the dataset's order into that of x, y, z. */
static void sort(const struct frame *frame, const double *from, struct rmap_grid *grid,
                 size_t *n_hole)
{
    size_t extent[3], stride[3];
    const size_t of_axis[3] = {frame->n[1] * frame->n[2], frame->n[2], 1};
    for (int k = 0; k < 3; k++) {
        extent[k] = frame->n[frame->axis_of[k]];
        stride[k] = of_axis[frame->axis_of[k]];
    }
    for (size_t i = 0; i < extent[0]; i++)
        for (size_t j = 0; j < extent[1]; j++)
            for (size_t k = 0; k < extent[2]; k++) {
                double value = *from++;
                grid->value[i * stride[0] + j * stride[1] + k * stride[2]] =
                    isfinite(value) ? value : (double)NAN;
                *n_hole += isfinite(value) ? 0 : 1;
            }
}

static enum rmap_status read_numbers(const struct source *from, const struct frame *frame,
                                     struct rmap_grid *grid, size_t *n_hole)
{
    enum rmap_status st = RMAP_OK;
    hid_t type = H5Dget_type(from->set);
    H5T_class_t kind = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
    double *value = NULL;
    (void)H5Tclose(type);
    if (kind != H5T_FLOAT && kind != H5T_INTEGER)
        return wrong(from, "holds no numbers");
    value = rmap_alloc(rmap_grid_count(grid), sizeof *value);
    if (!value)
        return rmap_error_set(from->err, RMAP_SYSTEM, "out of memory for a grid of %s",
                              from->file->path);
    if (H5Dread(from->set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) < 0)
        st = wrong(from, "cannot be read: the file is damaged");
    else
        sort(frame, value, grid, n_hole);
    rmap_free(value);
    if (st == RMAP_OK && *n_hole == rmap_grid_count(grid))
        st = wrong(from, "holds no finite number");
    return st;
}

static enum rmap_status open_dataset(struct source *from)
{
    const char *trouble = rmap_input_file_trouble(from->file->path);
    if (trouble)
        return rmap_error_set(from->err, RMAP_INPUT, "%s cannot be opened as an HDF5 file: %s",
                              from->file->path, trouble);
    from->h5 = H5Fopen(from->file->path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (from->h5 < 0)
        return rmap_error_set(from->err, RMAP_INPUT,
                              "%s cannot be opened as an HDF5 file: check its name and that it is "
                              "one",
                              from->file->path);
    from->set = rmap_h5_dataset(from->h5, from->dataset);
    if (from->set < 0)
        return rmap_error_set(from->err, RMAP_INPUT,
                              "%s has no dataset '%s' of its own (links to other files are not "
                              "followed, nor libraries loaded for filters): name it with "
                              "'dataset:'",
                              from->file->path, from->dataset);
    return RMAP_OK;
}

enum rmap_status rmap_grid_read(const struct rmap_grid_file *file, struct rmap_grid **grid_ret,
                                size_t *n_hole_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct source from = {file, file->dataset ? file->dataset : "n", H5I_INVALID_HID,
                          H5I_INVALID_HID, err};
    struct frame frame;
    struct rmap_grid *grid = NULL;
    struct rmap_error why = {0};
    size_t n_hole = 0;
    H5E_auto2_t told = NULL;
    void *told_to = NULL;
    (void)H5Eget_auto2(H5E_DEFAULT, &told, &told_to);
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    RMAP_TRY(open_dataset(&from));
    RMAP_TRY(place(&from, &frame));
    st = rmap_grid_create(frame.n, rmap_vec3(frame.origin[0], frame.origin[1], frame.origin[2]),
                          rmap_vec3(frame.spacing[0], frame.spacing[1], frame.spacing[2]), &grid,
                          &why);
    if (st != RMAP_OK) {
        st = rmap_error_set(err, st, "%s: dataset '%s': %s", file->path, from.dataset, why.text);
        goto out;
    }
    RMAP_TRY(read_numbers(&from, &frame, grid, &n_hole));
    *grid_ret = grid;
    *n_hole_ret = n_hole;
    grid = NULL;
out:
    rmap_grid_drop(grid);
    (void)H5Dclose(from.set);
    (void)H5Fclose(from.h5);
    (void)H5Eset_auto2(H5E_DEFAULT, told, told_to);
    return st;
}
