/* SPDX-License-Identifier: MIT
 *
 * Analytic surfaces, each in its own frame, in double precision.
 *
 *   CONIC      z = c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)) + sum a_i r^i, inner <= r <= aperture;
 *              normal towards +z. A plane cap has c = 0. (ISO 10110-12 sag formula.)
 *   DISC       z = 0, inner <= r <= radius; normal +z. inner > 0: an annulus.
 *   RECTANGLE  z = 0, |x| <= size[0] / 2, |y| <= size[1] / 2; normal +z.
 *   TUBE       cylinder or cone: radius at z = 0, radius2 at z = length, open ends; normal outward.
 *   SPHERE     radius about the origin; normal outward.
 */
#ifndef RMAP_SHAPE_H
#define RMAP_SHAPE_H

#include <stdbool.h>

#include "base/vec.h"

/* Columns: symbol; plane; with a normal at its vertex, as caps of lenses have; of revolution about
 * z; closed, with an inside. What must be computed for each stands in switches without default. */
#define RMAP_SHAPE_TABLE(X)                                                                        \
    X(CONIC, false, true, true, false)                                                             \
    X(DISC, true, true, true, false)                                                               \
    X(RECTANGLE, true, true, false, false)                                                         \
    X(TUBE, false, false, true, false)                                                             \
    X(SPHERE, false, false, true, true)

enum rmap_shape_type {
#define RMAP_SHAPE_ENUM(symbol, plane, cap, revolved, closed) RMAP_SHAPE_##symbol,
    RMAP_SHAPE_TABLE(RMAP_SHAPE_ENUM)
#undef RMAP_SHAPE_ENUM
};

struct rmap_shape_model {
    bool plane, cap, revolved, closed;
};

static const struct rmap_shape_model rmap_shape_model[] = {
#define RMAP_SHAPE_ROW(symbol, plane, cap, revolved, closed) {plane, cap, revolved, closed},
    RMAP_SHAPE_TABLE(RMAP_SHAPE_ROW)
#undef RMAP_SHAPE_ROW
};

#define RMAP_ASPHERE_MAX 16 /* even powers r^2 ... r^32 */

struct rmap_shape {
    enum rmap_shape_type type;
    double curvature, conic;          /* CONIC */
    double asphere[RMAP_ASPHERE_MAX]; /* CONIC: coefficient of r^(2 i + 2) */
    int n_asphere;                    /* CONIC: entries in use; 0: a pure conic */
    double aperture, inner;           /* CONIC, DISC: outer and hole radius */
    double size[2];                   /* RECTANGLE */
    double radius, radius2, length;   /* TUBE, SPHERE (radius) */
};

struct rmap_shape_hit {
    double t;                /* in units of the direction's length */
    struct rmap_vec3 point;  /* on the surface, local */
    struct rmap_vec3 normal; /* unit, local, unflipped */
    bool predicted;          /* as in struct rmap_hit */
};

/* Nearest hit with t_min < t < t_max of origin + t direction (direction of any length).
 * on_surface: the origin lies on this very surface to rounding; that root is dropped
 * analytically (quadrics) or deflated (aspheres), so the other side is still found. */
bool rmap_shape_intersect(const struct rmap_shape *shape, struct rmap_vec3 origin,
                          struct rmap_vec3 direction, bool on_surface, double t_min, double t_max,
                          struct rmap_shape_hit *hit);

/* Sag of a CONIC at radius r; NaN where the conic ends before r. */
double rmap_shape_sag(const struct rmap_shape *shape, double r);

/* Axis-aligned bounds in the local frame. */
void rmap_shape_bounds(const struct rmap_shape *shape, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper);

/* NULL when the numbers make a surface, else what is wrong with them ("radius must be > 0"). */
const char *rmap_shape_check(const struct rmap_shape *shape);

#endif
