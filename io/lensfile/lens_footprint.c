/* SPDX-License-Identifier: MIT
 *
 * How far from their axes the fields' rays meet the surfaces, for files that do not say how large
 * these are: rays to the rim of the entrance pupil, narrowed by vignetting, surface by surface.
 */
#include <math.h>

#include "base/count.h"
#include "io/lensfile/lens_layout.h"

enum { RIM = 8 };

struct beam {
    const struct rmap_lens_plan *plan;
    struct rmap_vec3 origin, direction; /* in the world */
    double n;
};

static bool bend(struct rmap_vec3 *d, struct rmap_vec3 normal, double from, double to)
{
    double cosine = rmap_dot(*d, normal);
    if (cosine < 0) {
        normal = rmap_scale(normal, -1);
        cosine = -cosine;
    }
    const double ratio = from / to, square = 1 - ratio * ratio * (1 - cosine * cosine);
    if (square < 0)
        return false;
    *d = rmap_axpy(sqrt(square) - ratio * cosine, normal, rmap_scale(*d, ratio));
    return true;
}

/* Where a line meets a sag near its vertex's plane, by Newton's method: files of strangers have
 * shapes whose exact roots take long. False: nowhere that it finds. */
static bool meet_sag(const struct rmap_sag *sag, struct rmap_vec3 o, struct rmap_vec3 d,
                     struct rmap_shape_hit *hit)
{
    enum { STEPS = 40 };
    const double near = 1e-9 * (1 + rmap_length(o));
    double t = -o.z / d.z;
    for (int i = 0; i < STEPS; i++) {
        hit->point = rmap_axpy(t, d, o);
        const struct rmap_height h = rmap_sag_profile(sag, hit->point.x, hit->point.y);
        const double miss = hit->point.z - (sag->fresnel ? 0 : h.z);
        if (fabs(miss) <= near) {
            hit->normal = rmap_normalize(rmap_vec3(-h.x, -h.y, 1));
            return isfinite(hit->normal.z) && hypot(hit->point.x, hit->point.y) <= sag->far;
        }
        t -= miss / (sag->fresnel ? d.z : d.z - h.x * d.x - h.y * d.y);
    }
    return false;
}

/* On to surface i; its distance from that surface's axis. False: it misses. */
static bool advance(struct beam *beam, size_t i, double *radius)
{
    const struct rmap_lens_surface *surface = &beam->plan->lens->surface[i];
    const struct rmap_affine *to_world = &beam->plan->place[i].to_world;
    struct rmap_affine to_local;
    struct rmap_shape_hit hit;
    if (surface->is_break || !rmap_affine_invert(to_world, &to_local))
        return surface->is_break;
    const struct rmap_vec3 o = rmap_affine_point(&to_local, beam->origin);
    struct rmap_vec3 d = rmap_normalize(rmap_affine_vector(&to_local, beam->direction));
    const double scale = rmap_length(o) + beam->plan->order.entrance_diameter;
    const struct rmap_sag *sag = beam->plan->place[i].sag;
    struct rmap_shape shape = beam->plan->place[i].shape;
    shape.aperture = fmin(rmap_lens_reach(surface), 1e3 * scale);
    if (sag ? !meet_sag(sag, o, d, &hit)
            : !rmap_shape_intersect(&shape, o, d, false, -10 * scale, 1e4 * scale, &hit))
        return false;
    *radius = hypot(hit.point.x, hit.point.y);
    const double to = beam->plan->media.medium[beam->plan->media.behind[i]].index;
    if (surface->is_mirror)
        d = rmap_axpy(-2 * rmap_dot(d, hit.normal), hit.normal, d);
    else if (to != beam->n && !bend(&d, hit.normal, beam->n, to))
        return false;
    beam->n = to;
    beam->origin = rmap_affine_point(to_world, hit.point);
    beam->direction = rmap_affine_vector(to_world, d);
    return true;
}

/* A ray of a field (n_field: of the axis) to the place (px, py) in the entrance pupil, as shares of
 * its radius. */
static struct beam start(const struct rmap_lens_plan *plan, size_t f, double px, double py)
{
    static const struct rmap_lens_field axis = {.weight = 1};
    const struct rmap_lens_field *field = f < plan->lens->n_field ? &plan->lens->field[f] : &axis;
    const struct rmap_first_order *o = &plan->order;
    const double radius = 0.5 * o->entrance_diameter;
    double xy[2];
    rmap_lens_field_at(plan, field, xy);
    struct beam beam = {.plan = plan, .n = plan->media.medium[plan->media.behind[0]].index};
    const bool far_pupil = !isfinite(o->entrance);
    const double x = radius * px + plan->aim[f][0], y = radius * py + plan->aim[f][1];
    const struct rmap_vec3 pupil = rmap_vec3(x, y, far_pupil ? 0 : o->entrance);
    if (isfinite(o->object)) {
        beam.origin = rmap_vec3(xy[0], xy[1], -o->object);
        beam.direction = rmap_sub(pupil, beam.origin);
        if (far_pupil)
            beam.direction = rmap_vec3(x, y, o->object);
    } else {
        beam.direction = rmap_vec3(xy[0], xy[1], 1);
        beam.origin = pupil;
    }
    beam.direction = rmap_normalize(beam.direction);
    if (!isfinite(o->object)) /* from before everything */
        beam.origin =
            rmap_axpy(-(fabs(beam.origin.z) + o->entrance_diameter), beam.direction, beam.origin);
    return beam;
}

static void follow(struct rmap_lens_plan *plan, struct beam beam, bool axial)
{
    const struct rmap_prescription *lens = plan->lens;
    double radius = 0;
    for (size_t i = 1; i < lens->n_surface; i++) {
        if (!advance(&beam, i, &radius))
            return;
        if (lens->surface[i].is_break || lens->surface[i].semi > 0)
            continue;
        if (!lens->surface[i].is_stop || axial)
            plan->place[i].semi = fmax(plan->place[i].semi, radius);
    }
}

/* Where a field's middle ray meets the stop, from the stop's axis. */
static bool meet_stop(const struct rmap_lens_plan *plan, size_t f, size_t stop, double xy[2])
{
    struct beam beam = start(plan, f, 0, 0);
    struct rmap_affine to_local;
    double radius = 0;
    for (size_t i = 1; i <= stop; i++)
        if (!advance(&beam, i, &radius))
            return false;
    if (!rmap_affine_invert(&plan->place[stop].to_world, &to_local))
        return false;
    const struct rmap_vec3 at = rmap_affine_point(&to_local, beam.origin);
    xy[0] = at.x;
    xy[1] = at.y;
    return true;
}

/* The middle rays of fields go through the middle of the stop, as CODE V and OSLO have it, and
 * Zemax where it aims rays: along the axis they do, so it is for lenses that are decentred before
 * it. */
static void aim(struct rmap_lens_plan *plan, size_t f, size_t stop)
{
    enum { STEPS = 10 };
    const double h = 1e-4 * plan->order.entrance_diameter;
    double *at = plan->aim[f], here[2], there[2], slope[2][2];
    for (int i = 0; i < STEPS; i++) {
        if (!meet_stop(plan, f, stop, here))
            break;
        if (hypot(here[0], here[1]) < 1e-9 * plan->order.entrance_diameter)
            return;
        for (int k = 0; k < 2; k++) {
            at[k] += h;
            const bool met = meet_stop(plan, f, stop, there);
            at[k] -= h;
            for (int j = 0; j < 2; j++)
                slope[j][k] = met ? (there[j] - here[j]) / h : 0;
        }
        const double det = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
        const double step[2] = {(slope[1][1] * here[0] - slope[0][1] * here[1]) / det,
                                (slope[0][0] * here[1] - slope[1][0] * here[0]) / det};
        if (!isfinite(step[0]) || !isfinite(step[1]))
            break;
        at[0] -= step[0];
        at[1] -= step[1];
    }
    at[0] = at[1] = 0; /* no such ray */
}

static void aim_all(struct rmap_lens_plan *plan)
{
    const struct rmap_prescription *lens = plan->lens;
    size_t stop = 1;
    bool decentred = false;
    for (size_t i = lens->n_surface - 1; i-- > 1;)
        stop = lens->surface[i].is_stop ? i : stop;
    for (size_t i = 1; i <= stop; i++)
        decentred = decentred || plan->place[i].to_world.t.x != 0 ||
                    plan->place[i].to_world.t.y != 0 || plan->place[i].to_world.m[2][2] != 1;
    for (size_t f = 0; decentred && lens->aims_at_stop && f <= lens->n_field; f++)
        aim(plan, f, stop);
}

/* The stop is as large as the beam of the axis; a margin of 1 % keeps others from their rims. */
void rmap_lens_footprints(struct rmap_lens_plan *plan)
{
    const struct rmap_prescription *lens = plan->lens;
    const double margin = 1.01;
    aim_all(plan);
    for (size_t f = 0; f <= lens->n_field; f++) {
        const bool axial = f == lens->n_field;
        for (int k = 0; k < RIM; k++) {
            const double angle = 2 * RMAP_PI * k / RIM;
            double p[2] = {cos(angle), sin(angle)};
            for (int j = 0; j < 2 && !axial; j++) {
                const double *cut = j ? lens->field[f].vy : lens->field[f].vx;
                p[j] *= 1 - fmin(fmax(cut[p[j] > 0], 0), 1);
            }
            follow(plan, start(plan, f, p[0], p[1]), axial);
        }
    }
    double last = 0.5 * plan->order.entrance_diameter;
    for (size_t i = 1; i < lens->n_surface; i++) {
        struct rmap_lens_place *place = &plan->place[i];
        place->computed = !(lens->surface[i].semi > 0);
        if (lens->surface[i].semi > 0)
            place->semi = lens->surface[i].semi;
        else if (place->semi > 0)
            place->semi *= lens->surface[i].is_stop ? 1 + 1e-6 : margin; /* written with 7 digits */
        else if (i + 1 < lens->n_surface)                                /* no ray got there */
            place->semi = last;
        if (!lens->surface[i].is_break)
            last = place->semi;
    }
}
