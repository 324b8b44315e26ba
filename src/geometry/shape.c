/* SPDX-License-Identifier: MIT
 *
 * Analytic surfaces, each in its own frame, in double precision.
 */
#include "geometry/shape.h"

#include <stddef.h>
#include <string.h>

#include "base/alloc.h"
#include "geometry/shape_solve.h"

bool rmap_shape_intersect(const struct rmap_shape *shape, struct rmap_vec3 origin,
                          struct rmap_vec3 direction, bool on_surface, double t_min, double t_max,
                          struct rmap_shape_hit *hit)
{
    const struct rmap_shape_query query = {origin, direction, on_surface, t_min,
                                           t_max,  -HUGE_VAL, NULL};
    return rmap_shape_solve(shape, &query, hit);
}

struct rmap_vec3 rmap_shape_normal(const struct rmap_shape *shape, struct rmap_vec3 point)
{
    if (rmap_shape_model[shape->type].plane)
        return rmap_vec3(0, 0, 1);
    if (shape->type == RMAP_SHAPE_CONIC && shape->n_asphere > 0) {
        double slope = -2 * rmap_conic_slope(shape, point.x * point.x + point.y * point.y);
        return rmap_normalize(rmap_vec3(slope * point.x, slope * point.y, 1));
    }
    if (shape->type == RMAP_SHAPE_SAG) {
        const struct rmap_height at = rmap_sag_profile(shape->sag[0], point.x, point.y);
        return rmap_normalize(rmap_vec3(-at.x, -at.y, 1));
    }
    if (shape->type == RMAP_SHAPE_WALL)
        return rmap_wall_normal(shape, point);
    struct rmap_quadric f = rmap_quadric_of(shape);
    return rmap_quadric_normal_at(shape, &f, point);
}

/* Rounding of what the sag formula has under its root: a half sphere's aperture may be its
 * radius. */
#define RIM_ROUNDING 1e-14

/* What stands under that root: negative where the conic has ended. */
static double under_root(const struct rmap_shape *shape, double r)
{
    return 1 - (1 + shape->conic) * shape->curvature * shape->curvature * r * r;
}

double rmap_shape_sag(const struct rmap_shape *shape, double r)
{
    if (shape->type == RMAP_SHAPE_SAG)
        return rmap_sag_height(shape->sag[0], r, 0).z;
    return under_root(shape, r) < -RIM_ROUNDING ? (double)NAN : rmap_conic_sag(shape, r * r);
}

void rmap_shape_bounds(const struct rmap_shape *shape, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper)
{
    double r = shape->aperture, low = 0, high = 0;
    struct rmap_vec3 half;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
        if (shape->n_asphere > 0) {
            rmap_asphere_sag_range(shape, &low, &high);
        } else {
            double a = rmap_conic_sag(shape, shape->inner * shape->inner);
            double b = rmap_conic_sag(shape, r * r);
            low = fmin(a, b);
            high = fmax(a, b);
        }
        break;
    case RMAP_SHAPE_RECTANGLE:
        half = rmap_vec3(0.5 * shape->size[0], 0.5 * shape->size[1], 0);
        *lower = rmap_scale(half, -1);
        *upper = half;
        return;
    case RMAP_SHAPE_TUBE:
        r = fmax(shape->radius, shape->radius2);
        high = shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        r = shape->radius;
        low = -r;
        high = r;
        break;
    case RMAP_SHAPE_DISC:
        break;
    case RMAP_SHAPE_SAG:
    case RMAP_SHAPE_WALL:
        half = rmap_vec3(shape->outline.half[0], shape->outline.half[1], 0);
        *lower = rmap_vec3(shape->outline.at[0], shape->outline.at[1], shape->sag[0]->low);
        *upper = *lower;
        upper->z = shape->type == RMAP_SHAPE_SAG ? shape->sag[0]->high
                                                 : shape->length + shape->sag[1]->high;
        *lower = rmap_sub(*lower, half);
        *upper = rmap_add(*upper, half);
        if (shape->type == RMAP_SHAPE_WALL && shape->outline.rectangle) {
            double *low_side = shape->side % 2 ? &lower->y : &lower->x,
                   *high_side = shape->side % 2 ? &upper->y : &upper->x;
            *(shape->side < 2 ? low_side : high_side) = *(shape->side < 2 ? high_side : low_side);
        }
        return;
    }
    *lower = rmap_vec3(-r, -r, low);
    *upper = rmap_vec3(r, r, high);
}

static const char *check_rim(const struct rmap_shape *shape)
{
    if (!(shape->aperture > 0 && isfinite(shape->aperture)))
        return "aperture must be > 0 and finite";
    if (!(shape->inner >= 0 && shape->inner < shape->aperture))
        return "inner must be >= 0 and smaller than the aperture";
    return NULL;
}

static const char *check_conic(const struct rmap_shape *shape)
{
    if (!isfinite(shape->curvature))
        return "curvature must be finite (radius must not be tiny)";
    if (!isfinite(shape->conic))
        return "conic must be finite";
    if (shape->n_asphere < 0 || shape->n_asphere > RMAP_ASPHERE_MAX)
        return "asphere has too many terms (even powers 2 to 32)";
    for (int i = 0; i < shape->n_asphere; i++)
        if (!isfinite(shape->asphere[i]))
            return "asphere coefficients must be finite";
    const char *wrong = check_rim(shape);
    if (wrong)
        return wrong;
    double rest = under_root(shape, shape->aperture);
    if (rest < -RIM_ROUNDING || (rest < RIM_ROUNDING && shape->n_asphere > 0))
        return "aperture reaches beyond the end of the conic: (1 + conic) (aperture / radius)^2 "
               "must be at most 1 (below 1 for an asphere)";
    return isfinite(rmap_shape_sag(shape, shape->aperture)) ? NULL : "the sag is not finite";
}

const char *rmap_shape_check(const struct rmap_shape *shape)
{
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
        return check_conic(shape);
    case RMAP_SHAPE_DISC:
        return check_rim(shape);
    case RMAP_SHAPE_RECTANGLE:
        if (!(shape->size[0] > 0 && shape->size[1] > 0 && isfinite(shape->size[0]) &&
              isfinite(shape->size[1])))
            return "size must be two finite numbers > 0";
        return NULL;
    case RMAP_SHAPE_TUBE:
        if (!(shape->radius >= 0 && shape->radius2 >= 0 && isfinite(shape->radius) &&
              isfinite(shape->radius2)) ||
            (shape->radius == 0 && shape->radius2 == 0))
            return "radius and radius2 must be finite, >= 0 and not both 0";
        return shape->length > 0 && isfinite(shape->length) ? NULL
                                                            : "length must be > 0 and finite";
    case RMAP_SHAPE_SPHERE:
        return shape->radius > 0 && isfinite(shape->radius) ? NULL
                                                            : "radius must be > 0 and finite";
    case RMAP_SHAPE_SAG:
    case RMAP_SHAPE_WALL:
        return rmap_aperture_check(&shape->outline);
    }
    return "unknown shape";
}

/* ---- sags ---- */

static void set_outline(struct rmap_shape *shape, const struct rmap_aperture *outline)
{
    shape->outline = *outline;
    shape->aperture = rmap_aperture_far(outline);
    shape->inner = rmap_aperture_is_circle(outline) ? outline->inner : 0;
}

const char *rmap_shape_of_sag(struct rmap_shape *shape, struct rmap_sag *sag,
                              const struct rmap_aperture *outline)
{
    const char *wrong = rmap_aperture_check(outline);
    *shape = (struct rmap_shape){.type = RMAP_SHAPE_SAG, .sag = {sag, NULL}};
    set_outline(shape, outline);
    return wrong ? wrong : rmap_sag_finish(sag, outline);
}

const char *rmap_shape_of_wall(struct rmap_shape *shape, struct rmap_sag *bottom,
                               struct rmap_sag *top, double length,
                               const struct rmap_aperture *outline, int side)
{
    struct rmap_aperture rim = *outline;
    rim.inner = 0;
    *shape = (struct rmap_shape){
        .type = RMAP_SHAPE_WALL, .sag = {bottom, top}, .length = length, .side = side};
    set_outline(shape, &rim);
    const char *wrong = rmap_sag_finish(bottom, &rim);
    return wrong ? wrong : rmap_sag_finish(top, &rim);
}

struct rmap_aperture rmap_shape_outline(const struct rmap_shape *shape)
{
    if (shape->type == RMAP_SHAPE_SAG || shape->type == RMAP_SHAPE_WALL)
        return shape->outline;
    return (struct rmap_aperture){.half = {shape->aperture, shape->aperture},
                                  .inner = shape->inner};
}

void rmap_shape_as_sag(const struct rmap_shape *shape, struct rmap_sag *sag)
{
    if (shape->type == RMAP_SHAPE_SAG) {
        *sag = *shape->sag[0];
        return;
    }
    *sag = (struct rmap_sag){.base = RMAP_SAG_CONIC,
                             .curvature = {shape->curvature, shape->curvature},
                             .conic = {shape->conic, shape->conic},
                             .n_power = 2 * shape->n_asphere};
    for (int i = 0; i < shape->n_asphere; i++)
        sag->power[2 * i + 1] = shape->asphere[i];
}

bool rmap_shape_own(struct rmap_shape *shape)
{
    struct rmap_sag *own[2] = {NULL, NULL};
    bool good = true;
    for (int k = 0; k < 2; k++)
        if (shape->sag[k]) {
            own[k] = rmap_alloc(1, sizeof *own[k]);
            good = good && own[k];
            if (own[k])
                memcpy(own[k], shape->sag[k], sizeof *own[k]);
        }
    memcpy(shape->sag, own, sizeof own);
    return good;
}

void rmap_shape_release(struct rmap_shape *shape)
{
    for (int k = 0; k < 2; k++)
        rmap_free(shape->sag[k]);
}

double rmap_shape_height(const struct rmap_shape *shape, double x, double y)
{
    return shape->type == RMAP_SHAPE_SAG ? rmap_sag_height(shape->sag[0], x, y).z
                                         : rmap_conic_sag(shape, x * x + y * y);
}

bool rmap_shape_is_flat(const struct rmap_shape *shape)
{
    return shape->type == RMAP_SHAPE_SAG ? rmap_sag_is_plane(shape->sag[0])
                                         : shape->curvature == 0 && shape->n_asphere == 0;
}

bool rmap_shape_vertex(const struct rmap_shape *shape, double curvature[3])
{
    if (shape->type == RMAP_SHAPE_CONIC) {
        curvature[0] = curvature[2] =
            shape->curvature + (shape->n_asphere > 0 ? 2.0 * shape->asphere[0] : 0.0);
        curvature[1] = 0.0;
    }
    return shape->type == RMAP_SHAPE_CONIC ||
           (shape->type == RMAP_SHAPE_SAG && rmap_sag_vertex(shape->sag[0], curvature));
}

bool rmap_shape_is_revolved(const struct rmap_shape *shape)
{
    return shape->type != RMAP_SHAPE_SAG ||
           ((shape->sag[0]->fresnel || rmap_sag_is_revolved(shape->sag[0])) &&
            rmap_aperture_is_circle(&shape->outline));
}
