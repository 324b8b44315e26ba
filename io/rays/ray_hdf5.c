/* SPDX-License-Identifier: MIT
 *
 * Rays from an HDF5 file of anybody's making, or from a query's tables.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/hdf5/h5_inside.h"
#include "io/rays/ray_reader.h"

enum { BLOCK = 65536, COLUMN_SETS = 12, FILTERS = 2 };

/* A dataset and where its numbers go: one column, or three that follow each other. */
struct dataset {
    hid_t set;
    struct rmap_ray_meaning is;
    int width;
};

struct hdf5 {
    hid_t file;
    struct dataset column[COLUMN_SETS];
    size_t n_column;
    uint64_t n;
    double unit_m;
    bool wide, steps, flux_said;
    enum rmap_flux_unit flux_unit;
    hid_t filter[FILTERS];  /* of a query's table: detector, registered; < 0: all rows */
    double wanted[FILTERS]; /* the number there */
    struct rmap_error *err;
};

static enum rmap_status wrong(const struct hdf5 *self, const char *name, const char *what)
{
    return rmap_error_set(self->err, RMAP_INPUT, "dataset '%.60s' %s", name, what);
}

/* The attribute `unit` or `units` of at most 15 letters; empty: there is none. */
static void get_unit(hid_t set, char unit[16])
{
    static const char *const name[] = {"unit", "units"};
    unit[0] = 0;
    for (size_t i = 0; i < 2 && !unit[0]; i++) {
        if (H5Aexists(set, name[i]) <= 0)
            continue;
        hid_t attribute = H5Aopen(set, name[i], H5P_DEFAULT), type = H5Aget_type(attribute),
              space = H5Aget_space(attribute);
        if (type >= 0 && H5Tget_class(type) == H5T_STRING &&
            H5Sget_simple_extent_npoints(space) == 1) {
            char *text = NULL;
            if (H5Tis_variable_str(type) && H5Aread(attribute, type, (void *)&text) >= 0 && text)
                (void)snprintf(unit, 16, "%.15s", text);
            (void)H5free_memory(text);
            hid_t fixed = H5Tcopy(H5T_C_S1);
            if (!text && H5Tset_size(fixed, 16) >= 0 &&
                H5Tset_cset(fixed, H5Tget_cset(type)) >= 0 && /* else HDF5 has no conversion */
                H5Aread(attribute, fixed, unit) < 0)
                unit[0] = 0;
            unit[15] = 0;
            (void)H5Tclose(fixed);
        }
        (void)H5Tclose(type);
        (void)H5Sclose(space);
        (void)H5Aclose(attribute);
    }
}

/* Its rows are those of the others, each of `width` numbers. */
static enum rmap_status check_extent(struct hdf5 *self, const char *name, hid_t set, int width)
{
    hsize_t dims[2] = {0, 1};
    hid_t space = H5Dget_space(set), type = H5Dget_type(set);
    const int rank = H5Sget_simple_extent_ndims(space);
    const H5T_class_t kind = H5Tget_class(type);
    const bool fits =
        rank == (width > 1 ? 2 : 1) && H5Sget_simple_extent_dims(space, dims, NULL) > 0;
    if (kind == H5T_FLOAT && H5Tget_size(type) > 4)
        self->wide = true;
    (void)H5Sclose(space);
    (void)H5Tclose(type);
    if (!fits || dims[1] != (hsize_t)width || (kind != H5T_FLOAT && kind != H5T_INTEGER))
        return wrong(self, name,
                     width > 1 ? "is no table of numbers, three of each ray"
                               : "is no list of numbers, one of each ray");
    if (self->n_column == 0)
        self->n = dims[0];
    return dims[0] == self->n ? RMAP_OK : wrong(self, name, "has other rows than the rest");
}

/* RMAP_OK also where there is none of that name; *found says so. */
static enum rmap_status add_dataset(struct hdf5 *self, const char *name, const char *as,
                                    const char *unit_given, int width, bool *found)
{
    char unit[16];
    struct dataset *column = &self->column[self->n_column];
    *found = H5Lexists(self->file, name, H5P_DEFAULT) > 0;
    if (!*found)
        return RMAP_OK;
    *column = (struct dataset){.set = rmap_h5_dataset(self->file, name), .width = width};
    if (column->set < 0)
        return wrong(self, name, "is none of the file's own (links to others are not followed)");
    enum rmap_status st = check_extent(self, name, column->set, width);
    self->n_column++;
    get_unit(column->set, unit);
    if (st == RMAP_OK)
        st = rmap_ray_meaning_of(as, unit_given ? unit_given : unit, self->steps, &column->is,
                                 self->err);
    if (st != RMAP_OK)
        return st;
    if (column->is.column == RMAP_RAY_POWER) {
        self->flux_said = column->is.said;
        self->flux_unit = column->is.flux_unit;
    }
    if (column->is.column <= RMAP_RAY_Z) {
        if (column->is.column != RMAP_RAY_X && column->is.factor != self->unit_m)
            return wrong(self, name, "has another unit than x");
        self->unit_m = column->is.factor;
        column->is.factor = 1.0;
    }
    if (column->is.column == RMAP_RAY_LENGTH) {
        if (column->is.factor != self->unit_m)
            return wrong(self, name, "has another unit than x");
        column->is.factor = 1.0;
    }
    return RMAP_OK;
}

/* ---- a query's tables ---- */

static enum rmap_status find_detector(struct hdf5 *self, const char *wanted)
{
    enum rmap_status st = RMAP_OK;
    hid_t names = rmap_h5_dataset(self->file, "/name/detector"),
          type = names < 0 ? H5I_INVALID_HID : H5Dget_type(names),
          space = names < 0 ? H5I_INVALID_HID : H5Dget_space(names);
    const hssize_t n = space < 0 ? 0 : H5Sget_simple_extent_npoints(space);
    const size_t width = type < 0 ? 0 : H5Tget_size(type);
    char *text = NULL;
    if (n < 1 || n > 1000000 || width < 1 || width > 65536 || H5Tget_class(type) != H5T_STRING ||
        H5Tis_variable_str(type))
        RMAP_TRY(rmap_error_set(self->err, RMAP_INPUT, "it has no names of detectors"));
    if (n > 1 && !wanted)
        RMAP_TRY(rmap_error_set(self->err, RMAP_INPUT,
                                "it has rays of %lld detectors: name one with 'detector:'",
                                (long long)n));
    text = rmap_alloc((size_t)n * width + 1, 1);
    if (!text || H5Dread(names, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0)
        RMAP_TRY(rmap_error_set(self->err, RMAP_SYSTEM, "its names of detectors cannot be read"));
    self->wanted[0] = wanted ? -1.0 : 0.0;
    for (hssize_t i = 0; wanted && i < n; i++)
        if (strncmp(text + (size_t)i * width, wanted, width) == 0 && strlen(wanted) <= width)
            self->wanted[0] = (double)i;
    if (self->wanted[0] < 0.0)
        st = rmap_error_set(self->err, RMAP_INPUT, "it has no detector '%.60s'", wanted);
out:
    rmap_free(text);
    (void)H5Sclose(space);
    (void)H5Tclose(type);
    (void)H5Dclose(names);
    return st;
}

static enum rmap_status open_table(struct hdf5 *self, const char *detector)
{
    static const struct {
        const char *name, *as, *unit;
    } want[] = {
        {"/registration/world_x", "x", NULL},    {"/registration/world_y", "y", NULL},
        {"/registration/world_z", "z", NULL},    {"/registration/direction_x", "dx", ""},
        {"/registration/direction_y", "dy", ""}, {"/registration/direction_z", "dz", ""},
        {"/registration/flux", "flux", NULL},    {"/registration/wavelength", "wavelength", NULL},
        {"/registration/time", "time", NULL},    {"/registration/event", "event", NULL}};
    static const char *const filter[FILTERS] = {"/registration/detector",
                                                "/registration/registered"};
    enum rmap_status st = RMAP_OK;
    bool found = false;
    RMAP_TRY(find_detector(self, detector));
    for (size_t i = 0; i < sizeof want / sizeof *want; i++) {
        RMAP_TRY(add_dataset(self, want[i].name, want[i].as, want[i].unit, 1, &found));
        if (!found && i < 7)
            RMAP_TRY(wrong(self, want[i].name,
                           "is missing: a query's table with the columns "
                           "registration has it"));
    }
    self->wanted[1] = 1.0;
    for (int k = 0; k < FILTERS; k++) {
        self->filter[k] = rmap_h5_dataset(self->file, filter[k]);
        if (self->filter[k] < 0)
            RMAP_TRY(wrong(self, filter[k], "is missing"));
        RMAP_TRY(check_extent(self, filter[k], self->filter[k], 1));
    }
out:
    return st;
}

/* ---- anybody's ---- */

static enum rmap_status open_lists(struct hdf5 *self)
{
    static const struct {
        const char *name, *as;
    } whole[] = {{"position", "x"}, {"direction", "dx"}},
      part[] = {{"x", "x"},
                {"y", "y"},
                {"z", "z"},
                {"dx", "dx"},
                {"dy", "dy"},
                {"dz", "dz"},
                {"wavelength", "wavelength"},
                {"energy", "energy"},
                {"time", "time"},
                {"weight", "weight"},
                {"event", "event"}},
      of_step[] = {{"length", "length"}, {"energy", "energy"}, {"time", "time"},
                   {"event", "event"},   {"charge", "charge"}, {"beta", "beta"}};
    enum rmap_status st = RMAP_OK;
    bool found = false, has[2] = {false, false};
    for (size_t i = 0; i < 2; i++)
        RMAP_TRY(add_dataset(self, whole[i].name, whole[i].as, NULL, 3, &has[i]));
    for (size_t i = 0; i < (self->steps ? 6 : sizeof part / sizeof *part); i++) {
        if (i < 6 && has[i / 3])
            continue;
        if (self->n_column == COLUMN_SETS)
            break;
        RMAP_TRY(add_dataset(self, part[i].name, part[i].as, NULL, 1, &found));
        if (!found && i < 6)
            RMAP_TRY(wrong(self, i < 3 ? "position" : "direction",
                           i < 3 ? "(or x, y, z) is missing" : "(or dx, dy, dz) is missing"));
    }
    for (size_t i = 0; self->steps && i < sizeof of_step / sizeof *of_step; i++) {
        RMAP_TRY(add_dataset(self, of_step[i].name, of_step[i].as, NULL, 1, &found));
        if (!found && i < 2)
            RMAP_TRY(wrong(self, of_step[i].name, "is missing: steps have a length and an energy"));
    }
out:
    return st;
}

/* ---- rows ---- */

static enum rmap_status take_block(struct hdf5 *self, hid_t set, int width, uint64_t first,
                                   size_t n, double *to)
{
    const hsize_t start[2] = {first, 0}, count[2] = {n, (hsize_t)width}, all = n * (size_t)width;
    hid_t space = H5Dget_space(set), memory = H5Screate_simple(1, &all, NULL);
    const bool good = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                      H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, to) >= 0;
    (void)H5Sclose(memory);
    (void)H5Sclose(space);
    return good ? RMAP_OK
                : rmap_error_set(self->err, RMAP_INPUT, "its rays cannot be read: it is damaged");
}

static bool is_wanted(const struct hdf5 *self, double *const *filter, size_t i)
{
    for (int k = 0; k < FILTERS; k++)
        if (self->filter[k] >= 0 && filter[k][i] != self->wanted[k])
            return false;
    return true;
}

static enum rmap_status put_rows(struct hdf5 *self, double *const block[COLUMN_SETS + FILTERS],
                                 size_t n, struct rmap_file_rays *set, size_t *row)
{
    double value[RMAP_RAY_COLUMNS] = {[RMAP_RAY_CHARGE] = 1.0, [RMAP_RAY_BETA] = 1.0};
    for (size_t i = 0; i < n; i++) {
        if (!is_wanted(self, block + COLUMN_SETS, i))
            continue;
        for (size_t c = 0; c < self->n_column; c++)
            for (int k = 0; k < self->column[c].width; k++) {
                const struct rmap_ray_meaning *is = &self->column[c].is;
                const double x = block[c][i * (size_t)self->column[c].width + (size_t)k];
                value[(int)is->column + k] = is->inverse ? is->factor / x : x * is->factor;
            }
        const double event = value[RMAP_RAY_EVENT];
        if (!rmap_ray_event_good(event) && !(self->filter[0] >= 0 && isnan(event)))
            return rmap_error_set(self->err, RMAP_INPUT,
                                  "row %zu: its event is %g, no whole number from 0", *row + 1,
                                  event);
        rmap_file_rays_put(set, (*row)++, value);
    }
    return RMAP_OK;
}

/* The k-th dataset, columns before filters, and how many numbers of it a row has; < 0: none. */
static hid_t dataset_at(const struct hdf5 *self, size_t k, int *width)
{
    *width = k < self->n_column ? self->column[k].width : 1;
    return k < self->n_column ? self->column[k].set
           : k >= COLUMN_SETS ? self->filter[k - COLUMN_SETS]
                              : H5I_INVALID_HID;
}

static enum rmap_status take_rows(struct hdf5 *self, struct rmap_file_rays *set)
{
    enum rmap_status st = RMAP_OK;
    double *block[COLUMN_SETS + FILTERS] = {NULL};
    size_t row = 0;
    int width = 1;
    for (size_t c = 0; c < COLUMN_SETS + FILTERS; c++) {
        if (dataset_at(self, c, &width) < 0)
            continue;
        block[c] = rmap_alloc_unset((size_t)BLOCK * (size_t)width, sizeof **block);
        if (!block[c])
            RMAP_TRY(rmap_error_set(self->err, RMAP_SYSTEM, "out of memory for rays"));
    }
    for (uint64_t at = 0; at < self->n; at += BLOCK) {
        const size_t n = self->n - at < BLOCK ? (size_t)(self->n - at) : BLOCK;
        for (size_t c = 0; c < COLUMN_SETS + FILTERS; c++) {
            const hid_t of = dataset_at(self, c, &width);
            if (of >= 0)
                RMAP_TRY(take_block(self, of, width, at, n, block[c]));
        }
        RMAP_TRY(put_rows(self, block, n, set, &row));
    }
    if (row == 0)
        RMAP_TRY(rmap_error_set(self->err, RMAP_INPUT, "it has no rays of that detector"));
    set->n = row;
out:
    for (size_t c = 0; c < COLUMN_SETS + FILTERS; c++)
        rmap_free(block[c]);
    return st;
}

static enum rmap_status read_rays(struct hdf5 *self, const char *detector,
                                  struct rmap_file_rays **set_ret)
{
    enum rmap_status st = RMAP_OK;
    bool has[RMAP_RAY_COLUMNS] = {false};
    const bool table = !self->steps && H5Lexists(self->file, "/registration", H5P_DEFAULT) > 0;
    if (detector && !table)
        RMAP_TRY(rmap_error_set(self->err, RMAP_INPUT,
                                "'detector' is for what a query wrote: it has no group "
                                "'registration'"));
    RMAP_TRY(table ? open_table(self, detector) : open_lists(self));
    for (size_t c = 0; c < self->n_column; c++)
        has[self->column[c].is.column] = true;
    if (self->n > SIZE_MAX / 64)
        RMAP_TRY(rmap_error_set(self->err, RMAP_INPUT, "it has too many rays"));
    RMAP_TRY(rmap_file_rays_create((size_t)self->n, self->wide, set_ret, self->err));
    RMAP_TRY(rmap_file_rays_columns(*set_ret, has, self->err));
    RMAP_TRY(take_rows(self, *set_ret));
    (*set_ret)->unit_m = self->unit_m;
    (*set_ret)->flux_unit = self->flux_unit;
    (*set_ret)->loose = table || !self->wide ? RMAP_FILE_RAYS_LOOSE : 0.0;
    if ((*set_ret)->below)
        st = rmap_file_rays_weigh(*set_ret, self->err);
    if (!table && !self->flux_said)
        (*set_ret)->flux = (double)NAN;
out:
    return st;
}

enum rmap_status rmap_ray_hdf5_read(const char *path, const struct rmap_ray_wanted *wanted,
                                    struct rmap_file_rays **set_ret, struct rmap_error *err)
{
    struct hdf5 self = {
        .steps = wanted->steps, .filter = {H5I_INVALID_HID, H5I_INVALID_HID}, .err = err};
    struct rmap_file_rays *set = NULL;
    H5E_auto2_t told = NULL;
    void *told_to = NULL;
    (void)H5Eget_auto2(H5E_DEFAULT, &told, &told_to);
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    self.file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    enum rmap_status st = self.file < 0 ? rmap_error_set(err, RMAP_INPUT, "it is no HDF5 file")
                                        : read_rays(&self, wanted->detector, &set);
    for (size_t c = 0; c < self.n_column; c++)
        (void)H5Dclose(self.column[c].set);
    for (int k = 0; k < FILTERS; k++)
        (void)H5Dclose(self.filter[k]);
    (void)H5Fclose(self.file);
    (void)H5Eset_auto2(H5E_DEFAULT, told, told_to);
    if (st == RMAP_OK)
        *set_ret = set;
    else
        rmap_file_rays_drop(set);
    return st;
}
