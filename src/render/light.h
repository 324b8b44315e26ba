/* SPDX-License-Identifier: MIT
 *
 * The scene's sources as seen from where light arrives: by sampling them from a point (next-event
 * estimation), and by meeting their shining side along a segment.
 */
#ifndef RMAP_LIGHT_H
#define RMAP_LIGHT_H

#include "scene/scene.h"

struct rmap_light {
    const struct rmap_source *source; /* borrowed */
    struct rmap_affine to_local;      /* of its frame */
    double strength;                  /* AREA: radiance, flux unit / (m2 sr); POINT: intensity on
                                         the axis, per sr; LAMP: flux; COLLIMATED: irradiance, per m2 */
    double area;                      /* of an emitter, in scene units squared */
    struct rmap_vec3 normal;          /* of all but meshes: of the side that shines */
    struct rmap_vec3 centre;          /* MESH: of a sphere about it */
    double radius;
    double bulge; /* how far it may stand out beyond its triangles */
    double share; /* MANY lights: cumulative probability of being looked at */
};

/* Lights looked at from one point: all of them, or as many draws among more. */
#define RMAP_LIGHT_DRAWS 4

struct rmap_lights {
    const struct rmap_scene *scene; /* borrowed */
    size_t n;
    struct rmap_light *light;
    size_t n_area;     /* the first ones have an area: those that a segment can meet */
    size_t n_bent;     /* of them in gradient media: curved segments meet no others */
    size_t n_sky;      /* SKY and SUN, somewhere among the others */
    size_t n_unseen;   /* rmap_source_is_unseen */
    bool four_numbers; /* a draw takes more than two: a choice, a mesh, a lamp or a sky */
    double unit_m2;    /* a square of the scene's unit */
};

enum rmap_status rmap_lights_create(const struct rmap_scene *scene, struct rmap_lights **lights_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_lights_destroy(struct rmap_lights *lights);

/* Light that a point receives from one light: its direction from there (unit), how far it comes,
 * and the irradiance of a plane that faces it, times the light's colour on each channel. */
struct rmap_light_sample {
    const struct rmap_light *light;
    struct rmap_vec3 direction;
    double distance;
    double irradiance;            /* flux unit / m2 */
    const double *colour;         /* the source's, or its own */
    double own[RMAP_CHANNEL_MAX]; /* of a sky, as it is in this direction */
};

int rmap_lights_n_draw(const struct rmap_lights *lights);

/* Draw number `draw` in [0, rmap_lights_n_draw), by four numbers in (0, 1). Their sum over the
 * draws is, in the mean, all that arrives. False where this one gives nothing. */
bool rmap_lights_draw(const struct rmap_lights *lights, int draw, struct rmap_vec3 from,
                      const double u[4], struct rmap_light_sample *sample);

/* Where a straight way from a point in a unit direction next meets the shining side of an area
 * light: *distance in (after, length]. Lights hide nothing: there may be more beyond. */
struct rmap_way {
    struct rmap_vec3 from, direction;
    double after, length;
};
/* No area light lies between two points, nor a billionth of the way beyond the second. Quick; may
 * be false in vain. */
static inline bool rmap_lights_aside(const struct rmap_lights *lights, struct rmap_vec3 from,
                                     struct rmap_vec3 to)
{
    const double beyond = 1e-8;
    for (size_t l = 0; l < lights->n_area; l++) {
        const struct rmap_affine *map = &lights->light[l].to_local;
        const struct rmap_vec3 z = {map->m[2][0], map->m[2][1], map->m[2][2]};
        const enum rmap_emitter shape = lights->light[l].source->shape;
        if (shape == RMAP_EMITTER_MESH || shape == RMAP_EMITTER_BODY)
            return false;
        double begin = rmap_dot(z, from) + map->t.z, end = rmap_dot(z, to) + map->t.z;
        if (begin > 0.0 && !(end > beyond * begin)) /* from the shining side to the other */
            return false;
    }
    return true;
}

bool rmap_light_met(const struct rmap_lights *lights, const struct rmap_light *light,
                    const struct rmap_way *way, double *distance);
/* Radiance of what a way along a unit direction has met, flux unit / (m2 sr). */
double rmap_light_radiance(const struct rmap_lights *lights, const struct rmap_light *light,
                           struct rmap_vec3 direction);

#endif
