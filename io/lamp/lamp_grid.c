/* SPDX-License-Identifier: MIT
 *
 * The grid of a lamp's intensities, and its symmetries.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lamp/lamp_reader.h"

/* Angles that differ by less are one; over this angle light ends where the grid does. Files give
 * three decimals of a degree at most. */
static const double near_deg = 1e-6;

static const size_t no_row = (size_t)-1;

/* Where a row of the file stands in the turn. */
struct image {
    double deg;
    size_t row; /* or no_row: dark */
};

enum rmap_status rmap_lamp_grid(struct rmap_lamp_file *file, size_t n_around, size_t n_polar,
                                struct rmap_error *err)
{
    file->n_around = n_around;
    file->n_polar = n_polar;
    file->around_deg = rmap_alloc(n_around, sizeof *file->around_deg);
    file->polar_deg = rmap_alloc(n_polar, sizeof *file->polar_deg);
    file->candela = rmap_alloc(n_around, n_polar * sizeof *file->candela);
    return file->around_deg && file->polar_deg && file->candela
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a lamp");
}

static void release(struct rmap_lamp_file *grid)
{
    rmap_free(grid->around_deg);
    rmap_free(grid->polar_deg);
    rmap_free(grid->candela);
}

/* The new grid takes the old one's place in the file, or is released. */
static enum rmap_status replace(struct rmap_lamp_file *file, struct rmap_lamp_file *grid,
                                enum rmap_status st)
{
    release(st == RMAP_OK ? file : grid);
    if (st != RMAP_OK)
        return st;
    file->n_around = grid->n_around;
    file->n_polar = grid->n_polar;
    file->around_deg = grid->around_deg;
    file->polar_deg = grid->polar_deg;
    file->candela = grid->candela;
    return RMAP_OK;
}

enum rmap_status rmap_lamp_mirror_polar(struct rmap_lamp_file *file, struct rmap_error *err)
{
    struct rmap_lamp_file whole = {0};
    const size_t n = file->n_polar;
    const enum rmap_status st = rmap_lamp_grid(&whole, file->n_around, 2 * n - 1, err);
    for (size_t p = 0; st == RMAP_OK && p < whole.n_polar; p++) {
        const size_t from = p < n ? n - 1 - p : p - (n - 1);
        whole.polar_deg[p] = p < n ? 180.0 - file->polar_deg[from] : file->polar_deg[from];
        for (size_t a = 0; a < file->n_around; a++)
            whole.candela[a * whole.n_polar + p] = file->candela[a * n + from];
    }
    if (st == RMAP_OK)
        memcpy(whole.around_deg, file->around_deg, file->n_around * sizeof *file->around_deg);
    return replace(file, &whole, st);
}

bool rmap_lamp_is_whole_turn(const double *around_deg, size_t n)
{
    double step = 0.0;
    for (size_t i = 1; i < n; i++)
        step = fmax(step, around_deg[i] - around_deg[i - 1]);
    return 360.0 - (around_deg[n - 1] - around_deg[0]) <= step + near_deg;
}

static double in_turn(double deg)
{
    const double in = fmod(fmod(deg, 360.0) + 360.0, 360.0);
    return 360.0 - in < near_deg ? 0.0 : in;
}

static int by_angle(const void *a, const void *b)
{
    const struct image *x = a, *y = b;
    if (x->deg != y->deg)
        return x->deg < y->deg ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* Rows and their mirror images, in order, each angle once. */
static size_t list_images(const struct rmap_lamp_file *file, unsigned turn, struct image *image)
{
    size_t n = 0, n_kept = 0;
    for (size_t row = 0; row < file->n_around; row++) {
        const double deg = file->around_deg[row];
        image[n++] = (struct image){in_turn(deg), row};
        if (turn & RMAP_LAMP_MIRROR_0)
            image[n++] = (struct image){in_turn(-deg), row};
        if (turn & RMAP_LAMP_MIRROR_90)
            image[n++] = (struct image){in_turn(180.0 - deg), row};
        if (turn & RMAP_LAMP_MIRROR_0 && turn & RMAP_LAMP_MIRROR_90)
            image[n++] = (struct image){in_turn(180.0 + deg), row};
    }
    const double high = file->around_deg[file->n_around - 1],
                 low = turn & RMAP_LAMP_MIRROR_0 ? -high : file->around_deg[0];
    if (turn & RMAP_LAMP_DARK && high - low < 360.0 - 4.0 * near_deg) {
        image[n++] = (struct image){in_turn(low - 2.0 * near_deg), no_row};
        image[n++] = (struct image){in_turn(high + 2.0 * near_deg), no_row};
    }
    qsort(image, n, sizeof *image, by_angle);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || image[i].deg - image[n_kept - 1].deg > near_deg)
            image[n_kept++] = image[i];
    return n_kept;
}

enum rmap_status rmap_lamp_write_out(struct rmap_lamp_file *file, unsigned turn,
                                     struct rmap_error *err)
{
    struct rmap_lamp_file whole = {0};
    enum rmap_status st = RMAP_OK;
    const size_t n_polar = file->n_polar;
    struct image *image = rmap_alloc(file->n_around + 1, 4 * sizeof *image);
    if (!image)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a lamp");
    const size_t n = list_images(file, turn, image);
    RMAP_TRY(rmap_lamp_grid(&whole, n, n_polar, err));
    memcpy(whole.polar_deg, file->polar_deg, n_polar * sizeof *whole.polar_deg);
    for (size_t a = 0; a < n; a++) {
        whole.around_deg[a] = image[a].deg;
        if (image[a].row != no_row)
            memcpy(whole.candela + a * n_polar, file->candela + image[a].row * n_polar,
                   n_polar * sizeof *whole.candela);
    }
out:
    rmap_free(image);
    return replace(file, &whole, st);
}
