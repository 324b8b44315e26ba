/* SPDX-License-Identifier: MIT
 *
 * Everything that happened along one ray, as a table or as JSON: read from a map (float columns,
 * 9 digits) or traced again (double, 17 digits).
 */
#ifndef RMAP_RAY_REPORT_H
#define RMAP_RAY_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/vec.h"
#include "io/map/map_reader.h"
#include "portion/event.h"
#include "portion/history.h"
#include "scene/scene.h"

/* The end of a segment. Undefined vectors and numbers are NaN, undefined indices -1. */
struct rmap_report_step {
    int32_t object, primitive, face;
    uint32_t events;
    int32_t medium;
    struct rmap_vec3 position, normal;
    struct rmap_vec3 direction;       /* of the segment */
    struct rmap_vec3 first_direction; /* of a curved segment traced again; undefined otherwise */
    double length;                    /* 0 for the segment that leaves the scene */
    size_t first_point, n_point;      /* of a curved segment, in the report's points; from a map its
                                         direction and length are those of the polyline through them */
    double optical_path;  /* from emission to here; NaN from a map, which keeps the sum */
    double incidence_deg; /* between the light and the normal; NaN where nothing is met */
    double reflectance;   /* specular, unpolarised, of the light that arrives: Fresnel's with its
                             coat, a mirror's or a mixture's; NaN of other surfaces */
    const double *colour; /* [n_channel] shares on arrival, in the report's own memory */
};

/* A point of a curved segment between its ends. From a map: the position alone, the others are NaN.
 */
struct rmap_report_point {
    struct rmap_vec3 position, direction;
    double length;       /* of the segment up to here */
    double optical_path; /* from emission to here */
};

struct rmap_report_registration {
    int32_t detector;
    uint32_t step; /* segment, from 0 */
    uint32_t cell[2];
    double x, y; /* PLANE: the scene's unit, from the centre; INTENSITY: theta, phi in degrees */
    double angle_deg;
    double optical_path;
    bool registered;
};

struct rmap_ray_report {
    const struct rmap_scene *scene; /* borrowed */
    int digits;                     /* significant ones: 9 or 17 */
    uint64_t ray;
    int32_t source;
    int stop;
    double flux; /* traced again: as if it were its source's only ray */
    double wavelength_nm, path_length, optical_path;
    struct rmap_vec3 start;
    int32_t start_object; /* -1: none */
    size_t n_step, n_registration;
    struct rmap_report_step *step;
    struct rmap_report_registration *registration;
    size_t n_point;
    struct rmap_report_point *point; /* of all curved segments, along the light */
    double *colour;                  /* [n_step][n_channel] */
};

/* Empty, with room for so many rows. */
enum rmap_status rmap_ray_report_create(const struct rmap_scene *scene, size_t n_step,
                                        size_t n_registration, size_t n_point,
                                        struct rmap_ray_report **report_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_report_destroy(struct rmap_ray_report *report); /* NULL is fine */

/* A ray of a map; the map outlives the report. RMAP_INPUT when it holds no such ray. */
enum rmap_status rmap_ray_report_read(const struct rmap_map *map, uint64_t ray,
                                      struct rmap_ray_report **report_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Row `row` of a portion of colour space `space` that has all columns; its rows of the other tables
 * begin at `segment` and `registration`. */
enum rmap_status rmap_ray_report_row(const struct rmap_map *map, size_t space,
                                     const struct rmap_portion *portion, size_t row, size_t segment,
                                     size_t registration, struct rmap_ray_report **report_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* A ray traced again, its history in double: all digits. Its flux is the source's flux times the
 * ray's weight, as if the source had emitted this ray alone: how many others share it, only a
 * map knows. The scene outlives the report. */
enum rmap_status rmap_ray_report_trace(const struct rmap_scene *scene,
                                       const struct rmap_history *history,
                                       struct rmap_ray_report **report_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Registrations of a step: [*first_ret, the number returned). Those of a ray stand in the order of
 * its steps. */
size_t rmap_ray_report_registrations(const struct rmap_ray_report *report, size_t step,
                                     size_t *first_ret);

/* Coordinates of a detector's relative (0..1) position, as in a registration's x and y. */
void rmap_detector_coordinates(const struct rmap_detector *detector, const double relative[2],
                               double *x, double *y);

#endif
