/* SPDX-License-Identifier: MIT
 *
 * Fluence rate and absorbed power per volume in the voxels of a box, with standard errors.
 *
 * The fluence rate of a voxel is the sum over rays of flux times length of way in it, over its
 * volume: the flux that a small sphere there would catch over its cross-section (W/m2, lm/m2).
 */
#ifndef RMAP_VOXEL_IMAGE_H
#define RMAP_VOXEL_IMAGE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/detector_image.h"
#include "analysis/detector/voxel_sums.h"

struct rmap_voxel_part {
    const char *name, *unit, *description; /* "fluence_rate", "W/m2" */
    double *value, *standard_error;        /* [n[2]][n[1]][n[0]] */
    double mean, mean_error;               /* over the box */
    double total, total_error;             /* times its volume */
    const char *total_unit;                /* "W m", "W" */
    double peak;
    size_t peak_voxel;
};

struct rmap_voxel_image {
    const struct rmap_scene *scene; /* borrowed */
    struct rmap_voxel_grid grid;
    const char *criterion; /* borrowed; NULL: all rays */
    struct rmap_voxel_part part[RMAP_VOXEL_PARTS];
};

enum rmap_status rmap_voxel_image_create(const struct rmap_voxel_sums *sums,
                                         struct rmap_voxel_image **image_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_voxel_image_destroy(struct rmap_voxel_image *image); /* NULL is fine */

/* One layer of voxels, across axis 0, 1 or 2, as the image of a plane that lies in their middle, in
 * the world's frame. `detector` and the image are the caller's: rmap_voxel_slice_fini. */
struct rmap_voxel_slice {
    struct rmap_detector detector;
    struct rmap_detector_image image;
    char name[80];
};
enum rmap_status rmap_voxel_slice_init(const struct rmap_voxel_image *image,
                                       enum rmap_voxel_what part, int axis, uint32_t layer,
                                       struct rmap_voxel_slice *slice,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_voxel_slice_fini(struct rmap_voxel_slice *slice);

/* Lines of "# key: value", then i,j,k,x,y,z and value and error of each part. */
void rmap_voxel_image_csv(const struct rmap_voxel_image *image, FILE *out);

/* For people, and as a JSON object (new reference; NULL when memory is short). */
void rmap_voxel_image_print(const struct rmap_voxel_image *image, FILE *out);
json_t *rmap_voxel_image_json(const struct rmap_voxel_image *image);

#endif
