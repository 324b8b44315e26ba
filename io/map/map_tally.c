/* SPDX-License-Identifier: MIT
 *
 * The energy balance and the detectors' images in the index: /tally/... and /detector/NAME/...
 */
#include "io/map/map_tally.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"

/* The sums per source: [n_source] or [n_source][n]. */
struct balance {
    const char *path;
    double *value;
    size_t n; /* 0: no second dimension */
    const char *description;
};

enum { N_BALANCE = 6 };

static void list_balance(const struct rmap_tally *tally, struct balance *balance)
{
    const struct rmap_scene *scene = tally->scene;
    const struct balance all[N_BALANCE] = {
        {"/tally/emitted", tally->emitted, 0, "rays emitted, per source"},
        {"/tally/absorbed_object", tally->absorbed_object, scene->n_object,
         "weight absorbed, per source and object"},
        {"/tally/absorbed_medium", tally->absorbed_medium, scene->n_medium,
         "weight absorbed, per source and medium"},
        {"/tally/left", tally->left, 0, "weight that left the scene, per source"},
        {"/tally/limit", tally->limit, 0, "weight stopped by a limit, per source"},
        {"/tally/error", tally->error, 0, "weight stopped by an error, per source"},
    };
    memcpy(balance, all, sizeof all);
}

static bool has_row(const struct balance *balance)
{
    return strcmp(balance->path, "/tally/absorbed_object") == 0 ||
           strcmp(balance->path, "/tally/absorbed_medium") == 0;
}

/* "/detector/NAME", or its index where the name cannot be a link's; rmap_free. */
static char *detector_path(const struct rmap_scene *scene, size_t detector, const char *item)
{
    const char *name = scene->detector[detector].name;
    if (!name || !*name || strchr(name, '/') || strcmp(name, ".") == 0)
        return rmap_path_format("/detector/%zu%s", detector, item);
    return rmap_path_format("/detector/%s%s", name, item);
}

static enum rmap_status put_detector(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     size_t index, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector *detector = &scene->detector[index];
    bool plane = detector->type == RMAP_DETECTOR_PLANE;
    const uint32_t number = (uint32_t)index;
    const double frame[4][3] = {{detector->origin.x, detector->origin.y, detector->origin.z},
                                {detector->x.x, detector->x.y, detector->x.z},
                                {detector->y.x, detector->y.y, detector->y.z},
                                {detector->axis.x, detector->axis.y, detector->axis.z}};
    const double area = detector->size[0] * detector->size[1] /
                        ((double)detector->cells[0] * (double)detector->cells[1]);
    RMAP_TRY(rmap_h5_group(h5, path, err));
    RMAP_TRY(rmap_h5_put_text(h5, path, "name", detector->name ? detector->name : "", err));
    RMAP_TRY(rmap_h5_put(h5, path, "index", RMAP_U32, 1, &number, err));
    RMAP_TRY(rmap_h5_put_text(h5, path, "type", plane ? "plane" : "intensity", err));
    RMAP_TRY(rmap_h5_put(h5, path, "size", RMAP_F64, 2, detector->size, err));
    RMAP_TRY(rmap_h5_put_text(h5, path, "size_units", plane ? scene->unit : "rad", err));
    RMAP_TRY(rmap_h5_put(h5, path, "cells", RMAP_U32, 2, detector->cells, err));
    if (plane)
        RMAP_TRY(rmap_h5_put(h5, path, "cell_area", RMAP_F64, 1, &area, err));
    RMAP_TRY(rmap_h5_put(h5, path, "origin", RMAP_F64, 3, frame[0], err));
    RMAP_TRY(rmap_h5_put(h5, path, "x", RMAP_F64, 3, frame[1], err));
    RMAP_TRY(rmap_h5_put(h5, path, "y", RMAP_F64, 3, frame[2], err));
    RMAP_TRY(rmap_h5_put(h5, path, "axis", RMAP_F64, 3, frame[3], err));
out:
    return st;
}

static enum rmap_status write_image(struct rmap_h5 *h5, const struct rmap_tally *tally,
                                    size_t index, const char *item, const double *value,
                                    const char *description, struct rmap_error *err)
{
    const struct rmap_detector *detector = &tally->scene->detector[index];
    char *path = detector_path(tally->scene, index, item);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    struct rmap_h5_array array = {path,
                                  RMAP_F64,
                                  3,
                                  {tally->scene->n_source, detector->cells[1], detector->cells[0]},
                                  rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
                                  description};
    enum rmap_status st = rmap_h5_write(h5, &array, value, err);
    rmap_free(path);
    return st;
}

/* Where there is any: maps whose weights are 32 at most have none, nor have those before it was
 * kept. */
static const double *rest_of(const struct rmap_tally *tally, size_t index)
{
    const size_t first = tally->image_offset[index], end = tally->image_offset[index + 1];
    for (size_t i = first; tally->image_squared_rest && i < end; i++)
        if (tally->image_squared_rest[i] > 0.0)
            return tally->image_squared_rest + first;
    return NULL;
}

static enum rmap_status write_detector(struct rmap_h5 *h5, const struct rmap_tally *tally,
                                       size_t index, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *path = detector_path(tally->scene, index, "");
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    const double *rest = rest_of(tally, index);
    size_t first = tally->image_offset[index];
    RMAP_TRY(put_detector(h5, tally->scene, index, path, err));
    RMAP_TRY(write_image(h5, tally, index, "/image", tally->image + first,
                         "sum of weights [source][y][x], least y first; times source flux / "
                         "source's rays: flux per cell",
                         err));
    RMAP_TRY(write_image(h5, tally, index, "/image_squared", tally->image_squared + first,
                         rest ? "sum of squared weights [source][y][x], of each up to 1024"
                              : "sum of squared weights [source][y][x]",
                         err));
    if (rest)
        RMAP_TRY(write_image(h5, tally, index, "/image_squared_rest", rest,
                             "sum of what squared weights are above 1024 [source][y][x]", err));
out:
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_tally_write(struct rmap_h5 *h5, const struct rmap_tally *tally,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct balance balance[N_BALANCE];
    list_balance(tally, balance);
    RMAP_TRY(rmap_h5_group(h5, "/tally", err));
    RMAP_TRY(rmap_h5_put(h5, "/tally", "segments", RMAP_F64, 1, tally->segments, err));
    RMAP_TRY(
        rmap_h5_put(h5, "/tally", "first_error_ray", RMAP_U64, 1, &tally->first_error_ray, err));
    for (int i = 0; i < N_BALANCE; i++) {
        struct rmap_h5_array array = {balance[i].path,
                                      RMAP_F64,
                                      has_row(&balance[i]) ? 2 : 1,
                                      {tally->scene->n_source, balance[i].n},
                                      rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
                                      balance[i].description};
        RMAP_TRY(rmap_h5_write(h5, &array, balance[i].value, err));
    }
    RMAP_TRY(rmap_h5_group(h5, "/detector", err));
    for (size_t d = 0; d < tally->scene->n_detector; d++)
        RMAP_TRY(write_detector(h5, tally, d, err));
out:
    return st;
}

/* Reads a dataset of just this shape into value. */
static enum rmap_status read_values(struct rmap_h5 *h5, const char *path, int rank,
                                    const hsize_t *dims, double *value, struct rmap_error *err)
{
    size_t row_nbytes = sizeof *value;
    for (int k = 1; k < rank; k++)
        row_nbytes *= (size_t)dims[k];
    return rmap_h5_read_rows(h5, path, RMAP_F64, rank, dims, value, row_nbytes, err);
}

static enum rmap_status read_image(struct rmap_h5 *h5, const struct rmap_tally *tally, size_t index,
                                   const char *item, double *value, struct rmap_error *err)
{
    const struct rmap_detector *detector = &tally->scene->detector[index];
    const hsize_t dims[3] = {tally->scene->n_source, detector->cells[1], detector->cells[0]};
    char *path = detector_path(tally->scene, index, item);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = read_values(h5, path, 3, dims, value, err);
    rmap_free(path);
    return st;
}

static enum rmap_status read_rest(struct rmap_h5 *h5, const struct rmap_tally *tally, size_t index,
                                  struct rmap_error *err)
{
    if (!tally->image_squared_rest)
        return RMAP_OK;
    char *path = detector_path(tally->scene, index, "/image_squared_rest");
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    const bool there = rmap_h5_has(h5, path);
    rmap_free(path);
    return there ? read_image(h5, tally, index, "/image_squared_rest",
                              tally->image_squared_rest + tally->image_offset[index], err)
                 : RMAP_OK;
}

static enum rmap_status read_all(struct rmap_h5 *h5, struct rmap_tally *tally,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct balance balance[N_BALANCE];
    list_balance(tally, balance);
    RMAP_TRY(rmap_h5_get(h5, "/tally", "segments", RMAP_F64, 1, tally->segments, err));
    RMAP_TRY(
        rmap_h5_get(h5, "/tally", "first_error_ray", RMAP_U64, 1, &tally->first_error_ray, err));
    for (int i = 0; i < N_BALANCE; i++) {
        const hsize_t dims[3] = {tally->scene->n_source, balance[i].n, 0};
        RMAP_TRY(read_values(h5, balance[i].path, has_row(&balance[i]) ? 2 : 1, dims,
                             balance[i].value, err));
    }
    for (size_t d = 0; d < tally->scene->n_detector; d++) {
        size_t first = tally->image_offset[d];
        RMAP_TRY(read_image(h5, tally, d, "/image", tally->image + first, err));
        RMAP_TRY(read_image(h5, tally, d, "/image_squared", tally->image_squared + first, err));
        RMAP_TRY(read_rest(h5, tally, d, err));
    }
out:
    return st;
}

enum rmap_status rmap_map_tally_read(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     struct rmap_tally **tally_ret, struct rmap_error *err)
{
    struct rmap_tally *tally = NULL;
    enum rmap_status st = rmap_tally_create(scene, &tally, err);
    if (st == RMAP_OK)
        st = read_all(h5, tally, err);
    if (st == RMAP_OK)
        *tally_ret = tally;
    else
        rmap_tally_destroy(tally);
    return st;
}
