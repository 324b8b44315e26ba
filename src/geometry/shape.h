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
 *   SAG        z = sag(x, y) over an outline (sag.h); normal of its profile, towards +z.
 *   WALL       over an ellipse, or one side of a rectangle, from one sag to another: the edge of a
 *              body between two such surfaces; normal outward.
 */
#ifndef RMAP_SHAPE_H
#define RMAP_SHAPE_H

#include <stdbool.h>

#include "base/vec.h"
#include "geometry/aperture.h"

/* Columns: symbol; plane; with a normal at its vertex, as caps of lenses have; of revolution about
 * z; closed, with an inside. What must be computed for each stands in switches without default. */
#define RMAP_SHAPE_TABLE(X)                                                                        \
    X(CONIC, false, true, true, false)                                                             \
    X(DISC, true, true, true, false)                                                               \
    X(RECTANGLE, true, true, false, false)                                                         \
    X(TUBE, false, false, true, false)                                                             \
    X(SPHERE, false, false, true, true)                                                            \
    X(SAG, false, true, false, false)                                                              \
    X(WALL, false, false, false, false)

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
    double radius, radius2, length;   /* TUBE, SPHERE (radius); WALL: from sag[0] to sag[1] */
    struct rmap_aperture outline;     /* SAG, WALL */
    int side;                         /* WALL, of a rectangle: 0 to 3 for +x, +y, -x, -y */
    struct rmap_sag *sag[2];          /* SAG: one; WALL: bottom and top. See rmap_shape_own. */
};
struct rmap_sag;

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

/* A SAG, or a WALL whose ends stand `length` apart; the sags stay the caller's. NULL, or what is
 * wrong with the numbers. */
const char *rmap_shape_of_sag(struct rmap_shape *shape, struct rmap_sag *sag,
                              const struct rmap_aperture *outline);
const char *rmap_shape_of_wall(struct rmap_shape *shape, struct rmap_sag *bottom,
                               struct rmap_sag *top, double length,
                               const struct rmap_aperture *outline, int side);

/* Where a line meets the plane or the cylinder that a WALL is part of, in order; how many. Of one
 * that starts on it the other root. */
int rmap_wall_roots(const struct rmap_shape *shape, bool on_surface, struct rmap_vec3 p,
                    struct rmap_vec3 d, double t[2]);

/* The outline of a CONIC or SAG; what both have as a sag. */
struct rmap_aperture rmap_shape_outline(const struct rmap_shape *shape);
void rmap_shape_as_sag(const struct rmap_shape *shape, struct rmap_sag *sag);

/* Puts copies of its own in place of a shape's sags, false for want of memory; and releases them.
 */
bool rmap_shape_own(struct rmap_shape *shape);
void rmap_shape_release(struct rmap_shape *shape);

/* Height of a CONIC or SAG above (x, y). */
double rmap_shape_height(const struct rmap_shape *shape, double x, double y);

/* A CONIC or SAG that is flat, in shape and in effect; and one that is the same when turned about
 * z. */
bool rmap_shape_is_flat(const struct rmap_shape *shape);
bool rmap_shape_is_revolved(const struct rmap_shape *shape);

/* Second derivatives xx, xy, yy of a CONIC or SAG at its vertex; false: the surface is another, or
 * inclined there. */
bool rmap_shape_vertex(const struct rmap_shape *shape, double curvature[3]);

/* Sag of a CONIC or SAG at radius r (of a SAG: along x); NaN where the conic ends before r. */
double rmap_shape_sag(const struct rmap_shape *shape, double r);

/* Axis-aligned bounds in the local frame. */
void rmap_shape_bounds(const struct rmap_shape *shape, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper);

/* NULL when the numbers make a surface, else what is wrong with them ("radius must be > 0"). */
const char *rmap_shape_check(const struct rmap_shape *shape);

#endif
