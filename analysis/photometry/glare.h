/* SPDX-License-Identifier: MIT
 *
 * Discomfort glare of an observer by luminaires: the unified glare rating of CIE 117:1995,
 *
 *     UGR = 8 lg (0.25 / Lb sum of L^2 omega / p^2).
 *
 * Luminaires are the scene's lamps with a luminous opening and Lambertian areas; each is taken as a
 * whole, by the place of its middle: luminance L as it is seen from there, solid angle omega of
 * what nothing hides, Guth's position index p. Lb is E / pi of the indirect light on the observer's
 * eye.
 */
#ifndef RMAP_GLARE_H
#define RMAP_GLARE_H

#include <jansson.h>
#include <stdio.h>

#include "accel/accel.h"
#include "io/map/map_reader.h"

struct rmap_glare_view {
    struct rmap_vec3 at, look, up; /* look: unit; up: unit, across it */
};

/* Up is made perpendicular to the line of sight. RMAP_USAGE where that has no direction. */
enum rmap_status rmap_glare_view_init(struct rmap_vec3 at, struct rmap_vec3 look,
                                      struct rmap_vec3 up, struct rmap_glare_view *view,
                                      struct rmap_error *err) RMAP_MUST_USE;

enum rmap_glare_role {
    RMAP_GLARE_COUNTS,
    RMAP_GLARE_OFF,     /* no light: dimmed to nothing */
    RMAP_GLARE_TURNED,  /* sends no light that way */
    RMAP_GLARE_OUTSIDE, /* behind, or beyond the table of position indices */
    RMAP_GLARE_HIDDEN,
    RMAP_GLARE_UNKNOWN /* no luminous area whose luminance is known, such as a point */
};

struct rmap_glare_light {
    size_t source;
    enum rmap_glare_role role;
    double distance_m, aside, above; /* over the distance along the line of sight */
    double luminance, solid_angle;   /* cd/m2; sr, of what is seen */
    double visible;                  /* share of it that nothing hides */
    double position_index;
    double part; /* L^2 omega / p^2 */
};

struct rmap_glare {
    struct rmap_glare_view view;
    const struct rmap_scene *scene; /* borrowed */
    size_t n_light;
    struct rmap_glare_light *light;  /* of all sources but skies and suns */
    double sum;                      /* of the parts */
    double indirect, indirect_error; /* lx on the eye; NaN: not known */
    double registrations;            /* that this is of */
    double background;               /* Lb */
    double ugr, ugr_error;           /* NaN: no luminaire counts, or no background light */
};

/* The luminaires of a map, dimmed as it is; RMAP_INPUT where its sources are not in lm. Background
 * and UGR are still to come. glare_ret: rmap_glare_destroy. */
enum rmap_status rmap_glare_look(const struct rmap_map *map, const struct rmap_accel *accel,
                                 const struct rmap_glare_view *view, struct rmap_glare **glare_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Background luminance and its standard error (NaN: not known), and what follows. */
void rmap_glare_conclude(struct rmap_glare *glare, double background, double background_error);
void rmap_glare_destroy(struct rmap_glare *glare);

enum rmap_status rmap_glare_print(const struct rmap_glare *glare, FILE *out,
                                  struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_glare_json(const struct rmap_glare *glare);

#endif
