/* SPDX-License-Identifier: MIT
 *
 * How a scene is looked at: along an axis, cut by a plane, or from above at an angle, by parallel
 * projection, so that lengths can be measured; or by a camera, in perspective.
 */
#ifndef RMAP_FIGURE_VIEW_H
#define RMAP_FIGURE_VIEW_H

#include <stdbool.h>

#include "base/vec.h"
#include "io/export/svg.h"
#include "portion/portion.h"
#include "scene/scene.h"

enum rmap_view_kind {
    RMAP_VIEW_AUTO, /* 3d for scenes made of meshes, else the section that shows most */
    RMAP_VIEW_YZ,   /* z to the right, y upwards; where z is upright, the other way round */
    RMAP_VIEW_XZ,   /* z to the right, x upwards; where z is upright, the other way round */
    RMAP_VIEW_XY,   /* x to the right, y upwards */
    RMAP_VIEW_3D    /* parallel projection from above: z upwards for bodies, y for optics */
};

struct rmap_view {
    bool section;                       /* cut by the plane of depth 0 */
    struct rmap_vec3 right, up, toward; /* orthonormal; toward the eye */
    double offset;                      /* of the plane, along `toward` */
    char description[96];               /* "section at y = 0 mm" */
    bool perspective;                   /* then: */
    struct rmap_vec3 eye;
    double slope[2]; /* half the picture's width and height at distance 1 */
    double nearest;  /* distance from the eye that anything seen has at least */
};

/* What a camera sees, without what its lens blurs. */
void rmap_view_camera(const struct rmap_scene *scene, const struct rmap_camera *camera,
                      struct rmap_view *view);

/* Never AUTO. rays may be NULL; their mean direction helps to choose a section. */
enum rmap_view_kind rmap_view_resolve(const struct rmap_scene *scene, enum rmap_view_kind kind,
                                      const struct rmap_portion *rays);
/* Of that kind, resolved so. */
void rmap_view_choose(const struct rmap_scene *scene, enum rmap_view_kind kind,
                      const struct rmap_portion *rays, struct rmap_view *view);

/* Another eye for a view of solids: degrees about the upright axis (where it stands: from +x
 * towards +y for bodies, from -z towards +x for optics), and above the ground. */
void rmap_view_turn(const struct rmap_scene *scene, double azimuth_deg, double elevation_deg,
                    struct rmap_view *view);

/* Another place for a section, along its axis; the description says when no object is there. */
void rmap_view_move(const struct rmap_scene *scene, double place, struct rmap_view *view);

/* Whether the box about an object, or about any, has points on both sides of a section, or in it.
 */
bool rmap_view_meets(const struct rmap_scene *scene, const struct rmap_view *view, size_t object);
bool rmap_view_meets_objects(const struct rmap_scene *scene, const struct rmap_view *view);

/* Whether z points upwards: as in the pictures of the scene's first camera;
 * without cameras in scenes of bodies. Else y, optics along z. */
bool rmap_view_has_z_upright(const struct rmap_scene *scene);

/* Coordinates to the right and upwards, and height above the plane towards the eye. In perspective
 * slopes, and 1 / distance instead of the height: of points before the eye. */
struct rmap_vec3 rmap_view_project(const struct rmap_view *view, struct rmap_vec3 point);

/* The same in two steps: lengths along right, up and toward (from the eye in perspective), and what
 * becomes of them. */
struct rmap_vec3 rmap_view_place(const struct rmap_view *view, struct rmap_vec3 point);
struct rmap_vec3 rmap_view_flatten(const struct rmap_view *view, struct rmap_vec3 place);

/* Grows away from the eye: a distance for what project gives as height. */
double rmap_view_distance(const struct rmap_view *view, double height);

/* The part of a line that a camera sees, and a little around it. False: nothing. Without a camera
 * all is seen. */
bool rmap_view_clip(const struct rmap_view *view, struct rmap_vec3 *from, struct rmap_vec3 *to);
bool rmap_view_sees(const struct rmap_view *view, struct rmap_vec3 point);

/* What of the scene a picture shows, in view coordinates: objects, detectors, and sources near
 * them. */
struct rmap_view_box {
    double low[2], high[2];
};
#define RMAP_VIEW_BOX_EMPTY ((struct rmap_view_box){{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}})
void rmap_view_bounds(const struct rmap_scene *scene, const struct rmap_view *view,
                      struct rmap_view_box *box);

/* Widens a box by the one about an object. */
void rmap_view_cover_object(const struct rmap_scene *scene, const struct rmap_view *view,
                            size_t object, struct rmap_view_box *box);

/* View coordinates to pixels, the same scale both ways but in a stretched section. */
struct rmap_view_frame {
    const struct rmap_view *view;
    double x, y, width, height; /* plot area, pixels */
    double scale;               /* pixels per length unit to the right */
    double stretch;             /* of what is upwards, over that; 1 but in sections */
    double centre[2];           /* view coordinates of the area's centre */
};
void rmap_view_pixel(const struct rmap_view_frame *frame, const double coordinates[2],
                     double pixel[2]);

#endif
