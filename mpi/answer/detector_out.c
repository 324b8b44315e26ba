/* SPDX-License-Identifier: MIT
 *
 * A detector's image as a file.
 */
#include "mpi/answer/detector_out.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/detector/lux_table.h"
#include "analysis/figure/figure_polar.h"
#include "analysis/figure/figure_spot.h"
#include "base/alloc.h"
#include "io/export/exr.h"
#include "io/export/npy.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "io/hdf5/grid_h5.h"
#include "mpi/command/output.h"

const char *const rmap_detector_suffixes[] = {".png", ".svg", ".csv", ".h5",  ".npy",
                                              ".npz", ".exr", ".ies", ".ldt", NULL};

bool rmap_detector_is_lamp_file(const char *path)
{
    return rmap_output_is(path, ".ies") || rmap_output_is(path, ".ldt");
}

static enum rmap_status write_csv(const struct rmap_detector_image *image, const char *criterion,
                                  void (*put)(const struct rmap_detector_image *image,
                                              const char *criterion, FILE *out),
                                  const char *path, struct rmap_error *err)
{
    struct rmap_whole_file whole = {0};
    enum rmap_status st = rmap_whole_file_open(&whole, path, err);
    if (st == RMAP_OK) {
        put(image, criterion, whole.file);
        st = rmap_whole_file_finish(&whole, err);
    }
    rmap_whole_file_fini(&whole);
    return st;
}

/* Upper row first, as pictures have them. */
static enum rmap_status write_exr(const struct rmap_detector_image *image, const char *criterion,
                                  const char *path, struct rmap_error *err)
{
    const size_t width = image->n[0], height = image->n[1];
    char comment[400];
    float *rgb = rmap_alloc(width * height, 3 * sizeof *rgb);
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (size_t j = 0; j < height; j++)
        for (size_t i = 0; i < width; i++)
            for (size_t k = 0; k < 3; k++) {
                const size_t c = i + (height - 1 - j) * width;
                rgb[3 * (i + j * width) + k] =
                    (float)(image->rgb ? image->rgb[3 * c + k] : image->value[c]);
            }
    const int n = snprintf(comment, sizeof comment, "%.80s: %s, %s; ", image->detector->name,
                           image->quantity, image->unit);
    rmap_which_caption(image->which, criterion, comment + n, sizeof comment - (size_t)n);
    const struct rmap_exr picture = {
        .size = {image->n[0], image->n[1]}, .rgb = rgb, .comment = comment};
    enum rmap_status st = rmap_exr_write(&picture, path, err);
    rmap_free(rgb);
    return st;
}

/* What an image has, as arrays. */
enum { ARRAYS_MAX = 10 + RMAP_COLOUR_NUMBERS };
struct arrays {
    struct rmap_grid_array array[ARRAYS_MAX];
    size_t n;
    double *x, *y, *z, *wavelength;
    double *colour; /* [RMAP_COLOUR_NUMBERS][h][w], or NULL */
};

static void add(struct arrays *arrays, const struct rmap_grid_array *array)
{
    if (array->data)
        arrays->array[arrays->n++] = *array;
}

/* A dataset for each of the numbers that say the colour of cells. */
static enum rmap_status list_colour(const struct rmap_detector_image *image, struct arrays *arrays,
                                    struct rmap_error *err)
{
    const size_t w = image->n[0], h = image->n[1];
    const struct rmap_detector_colour *colour = image->colour;
    if (!colour)
        return RMAP_OK;
    arrays->colour = rmap_alloc(w * h, RMAP_COLOUR_NUMBERS * sizeof(double));
    if (!arrays->colour)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the colour of an image");
    for (size_t k = 0; k < RMAP_COLOUR_NUMBERS; k++) {
        const char *name = rmap_colour_number[k];
        double *of = arrays->colour + k * w * h;
        for (size_t c = 0; c < w * h; c++)
            of[c] = rmap_colour_number_of(&colour->cell[c], (int)k);
        const char *unit = k < 6 ? colour->unit : strcmp(name, "CCT") == 0 ? "K" : "1";
        add(arrays, &(struct rmap_grid_array){name, unit, "CIE 1931, 2 degrees", 2, {h, w}, of});
    }
    return RMAP_OK;
}

static enum rmap_status list_arrays(const struct rmap_detector_image *image, struct arrays *arrays,
                                    struct rmap_error *err)
{
    const size_t w = image->n[0], h = image->n[1], n_channel = image->n_channel;
    const bool area = !image->bins.directions;
    const char *at = rmap_detector_image_coordinate_unit(image);
    arrays->x = rmap_alloc(w * h, sizeof(double));
    arrays->y = rmap_alloc(w * h, sizeof(double));
    arrays->z = image->world ? rmap_alloc(w * h, sizeof(double)) : NULL;
    arrays->wavelength = rmap_alloc(n_channel + 1, sizeof(double));
    if (!arrays->x || !arrays->y || (image->world && !arrays->z) || !arrays->wavelength)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an image");
    for (size_t c = 0; c < w * h; c++)
        rmap_detector_image_centre(image, (uint32_t)(c % w), (uint32_t)(c / w), &arrays->x[c],
                                   &arrays->y[c]);
    for (size_t c = 0; c < w * h && image->world; c++) {
        const struct rmap_vec3 p = rmap_detector_image_place(image, arrays->x[c], arrays->y[c]);
        arrays->x[c] = p.x;
        arrays->y[c] = p.y;
        arrays->z[c] = p.z;
    }
    for (size_t k = 0; k < n_channel; k++)
        arrays->wavelength[k] = image->scene->channels.wavelength_nm[k];
    const struct rmap_grid_array list[] = {
        {"value", image->unit, "value per cell", 2, {h, w}, image->value},
        {"standard_error",
         image->unit,
         "standard error of value",
         2,
         {h, w},
         image->standard_error},
        {"rays", "1", "registrations, sum of weights", 2, {h, w}, image->rays},
        {area ? "x" : "theta", at, "centre of the cell", 2, {h, w}, arrays->x},
        {area ? "y" : "phi", at, "centre of the cell", 2, {h, w}, arrays->y},
        {"z", at, "centre of the cell, as x and y in the world", 2, {h, w}, arrays->z},
        {"rgb", image->unit, "linear sRGB", 3, {h, w, 3}, image->rgb},
        {"spectral", image->unit, "part of value per channel", 3, {n_channel, h, w}, image->cube},
        {"spectral_standard_error",
         image->unit,
         "standard error of spectral",
         3,
         {n_channel, h, w},
         image->cube_error},
        {"wavelength",
         "nm",
         "vacuum wavelength of the channel",
         1,
         {n_channel},
         n_channel ? arrays->wavelength : NULL}};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        add(arrays, &list[i]);
    return list_colour(image, arrays, err);
}

static enum rmap_status write_numpy(const struct rmap_detector_image *image,
                                    const struct arrays *arrays, const char *path,
                                    struct rmap_error *err)
{
    struct rmap_npy_array npy[ARRAYS_MAX];
    size_t value = 0;
    for (size_t i = 0; i < arrays->n; i++) {
        const struct rmap_grid_array *from = &arrays->array[i];
        npy[i] =
            (struct rmap_npy_array){.name = from->name, .rank = from->rank, .data = from->data};
        for (int k = 0; k < from->rank; k++)
            npy[i].dims[k] = from->dims[k];
        if (image->cube && from->data == image->cube)
            value = i;
    }
    return rmap_output_is(path, ".npy") ? rmap_npy_write(&npy[value], path, err)
                                        : rmap_npz_write(npy, arrays->n, path, err);
}

static enum rmap_status write_arrays(const struct rmap_detector_image *image, const char *criterion,
                                     const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct arrays arrays = {0};
    const struct rmap_grid_text text[] = {{"detector", image->detector->name},
                                          {"quantity", image->quantity},
                                          {"criterion", criterion ? criterion : "all"},
                                          {"which", image->which ? image->which->text : "all"}};
    RMAP_TRY(list_arrays(image, &arrays, err));
    if (rmap_output_is(path, ".h5"))
        st = rmap_grid_h5_write(path, arrays.array, arrays.n, text, 4, err);
    else
        st = write_numpy(image, &arrays, path, err);
out:
    rmap_free(arrays.x);
    rmap_free(arrays.y);
    rmap_free(arrays.z);
    rmap_free(arrays.wavelength);
    rmap_free(arrays.colour);
    return st;
}

enum rmap_status rmap_detector_far_field(const struct rmap_detector_image *image,
                                         struct rmap_lamp_file *file, struct rmap_error *err)
{
    enum { MUCH = 10 }; /* per cent */
    double moved = 0.0;
    const enum rmap_status st = rmap_far_field_fit(image, file, &moved, err);
    if (st == RMAP_OK && 100.0 * moved > MUCH)
        fprintf(stderr,
                "raymap: '%s': %.0f %% of the light changes more between neighbouring angles than "
                "straight lines between %u angles gamma and %u planes C show: the flux is right, "
                "beams come out too wide; ask for --cells %ux%u or more\n",
                image->detector->name, 100.0 * fmin(moved, 1.0), image->n[0] / 2 + 1,
                image->n[1] / 2, image->n[0], image->n[1] > 2 ? image->n[1] : 1);
    return st;
}

static enum rmap_status write_lamp(const struct rmap_detector_image *image, const char *criterion,
                                   const char *path, struct rmap_error *err)
{
    struct rmap_whole_file whole = {0};
    struct rmap_lamp_file file = {.n_around = 0};
    char title[400];
    struct rmap_lamp_words words = {.title = title, .lumens = image->flux};
    const int n = snprintf(title, sizeof title, "%.80s: ", image->detector->name);
    rmap_which_caption(image->which, criterion, title + n, sizeof title - (size_t)n);
    for (size_t c = 0; c < (size_t)image->n[0] * image->n[1]; c++)
        if (2 * (c % image->n[0]) < image->n[0])
            words.down_lm += image->value[c] * rmap_detector_bins_extent(&image->bins, c);
    enum rmap_status st = rmap_detector_far_field(image, &file, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    rmap_lamp_file_write(&file, rmap_output_is(path, ".ies") ? RMAP_LAMP_IES : RMAP_LAMP_EULUMDAT,
                         &words, whole.file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    rmap_lamp_file_fini(&file);
    return st;
}

enum rmap_status rmap_detector_write(const struct rmap_detector_image *image,
                                     const struct rmap_figure_detector *figure, const char *path,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    if (rmap_output_is(path, ".csv"))
        return write_csv(image, figure->criterion, rmap_detector_image_csv, path, err);
    if (rmap_output_is(path, ".exr"))
        return write_exr(image, figure->criterion, path, err);
    if (rmap_detector_is_lamp_file(path))
        return write_lamp(image, figure->criterion, path, err);
    if (rmap_picture_kind(path) == RMAP_PICTURE_NONE)
        return write_arrays(image, figure->criterion, path, err);
    RMAP_TRY(rmap_figure_detector(image, figure, &svg, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    return st;
}

enum rmap_status rmap_lux_table_write(const struct rmap_detector_image *image,
                                      const char *criterion, const char *path,
                                      struct rmap_error *err)
{
    return write_csv(image, criterion, rmap_lux_table_csv, path, err);
}

enum rmap_status rmap_polar_write(const struct rmap_detector_image *image, const char *criterion,
                                  const char *path, struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    enum rmap_status st = rmap_figure_polar(image, criterion, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    return st;
}

enum rmap_status rmap_spot_write(const struct rmap_spot *spot, const char *detector,
                                 const char *criterion, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    struct rmap_whole_file whole = {0};
    if (rmap_output_is(path, ".csv")) {
        RMAP_TRY(rmap_whole_file_open(&whole, path, err));
        rmap_spot_csv(spot, detector, criterion, whole.file);
        st = rmap_whole_file_finish(&whole, err);
    } else {
        RMAP_TRY(rmap_figure_spot(spot, detector, criterion, &svg, err));
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    }
out:
    rmap_whole_file_fini(&whole);
    rmap_svg_destroy(svg);
    return st;
}
