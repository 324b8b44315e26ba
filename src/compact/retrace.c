/* SPDX-License-Identifier: MIT
 *
 * One ray after the other traced again, each along its path. Predictions and truth meet at every
 * number: what differs leads the ray on from the truth.
 */
#include "base/rng.h"
#include "compact/model.h"
#include "trace/azimuth.h"
#include "trace/event.h"

struct walk {
    const struct rmap_retrace *r;
    size_t ray, crossing, crossing_end; /* rows */
    struct rmap_vec3 position, direction;
    int32_t object; /* the leg starts on, or -1 */
    int channel;    /* at the end; -1: several */
    double path_length, optical_path;
    struct rmap_compact_light light;
};

static float to_float(double x)
{
    return x == x ? (float)x + 0.0f : (float)NAN;
}

static double to_double(double x)
{
    return x == x ? x + 0.0 : (double)NAN;
}

static void to_float3(struct rmap_vec3 v, float out[3])
{
    out[0] = to_float(v.x);
    out[1] = to_float(v.y);
    out[2] = to_float(v.z);
}

static int16_t quantise_cosine(double x)
{
    double bounded = x > -1.0 ? x < 1.0 ? x : 1.0 : -1.0; /* NaN: -1 */
    double scaled = 32767.0 * bounded;
    return (int16_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
}

static void offer_normal(struct rmap_lane *lane, size_t row, struct rmap_vec3 normal)
{
    int16_t value[3] = {quantise_cosine(normal.x), quantise_cosine(normal.y),
                        quantise_cosine(normal.z)};
    (void)rmap_lane_offer(lane, 3 * row, 3, sizeof *value, value);
}

static void offer_double(struct rmap_lane *lane, size_t row, double predicted)
{
    double value = to_double(predicted);
    (void)rmap_lane_offer(lane, row, 1, sizeof value, &value);
}

/* The nearest to x of the numbers that round to the float f. */
static double between(double x, float f)
{
    uint32_t bits;
    float beside;
    memcpy(&bits, &f, sizeof bits);
    if (to_float(x) == f || f == 0.0f)
        return f == 0.0f ? 0.0 : x;
    bits += (x > (double)f) == (f > 0.0f) ? 1 : UINT32_MAX; /* the next float towards x */
    memcpy(&beside, &bits, sizeof beside);
    return 0.5 * ((double)f + (double)beside);
}

/* Distances at which a prediction counts as failed, in radii of the scene. */
#define FAR 1e-6

enum verdict { RIGHT, NEAR, WRONG };

/* Offers a point; *point becomes the best guess at the double behind the true floats. */
static enum verdict offer_point(const struct rmap_retrace *r, struct rmap_lane *lane, size_t row,
                                struct rmap_vec3 *point)
{
    float value[3];
    to_float3(*point, value);
    if (rmap_lane_offer(lane, 3 * row, 3, sizeof *value, value))
        return RIGHT;
    struct rmap_vec3 truth = rmap_vec3((double)value[0], (double)value[1], (double)value[2]);
    struct rmap_vec3 off = rmap_sub(truth, *point);
    double limit = FAR * r->model->scene->radius, size = rmap_dot(truth, truth);
    if (!(size - size == 0.0)) /* the truth is no point */
        return NEAR;
    if (!(rmap_dot(off, off) <= limit * limit)) {
        *point = truth;
        return WRONG;
    }
    *point = rmap_vec3(between(point->x, value[0]), between(point->y, value[1]),
                       between(point->z, value[2]));
    return NEAR;
}

static double distance_out(const struct walk *walk)
{
    const struct rmap_scene *scene = walk->r->model->scene;
    struct rmap_vec3 from = rmap_sub(walk->position, scene->centre);
    double along = rmap_dot(from, walk->direction);
    double gap = scene->radius * scene->radius - rmap_dot(from, from);
    if (!(gap > 0.0))
        return 0.0;
    double root = sqrt(along * along + gap);
    return along > 0.0 ? gap / (root + along) : root - along;
}

static const struct rmap_medium *medium_of(const struct rmap_retrace *r, int32_t medium)
{
    bool known = medium >= 0 && (size_t)medium < r->model->n_medium;
    return known ? &r->model->scene->medium[medium] : NULL;
}

/* Registrations up to leg `segment` (from 0 within the ray). */
static void offer_crossings(struct walk *walk, uint32_t segment, const struct rmap_compact_leg *leg)
{
    const struct rmap_retrace *r = walk->r;
    for (; walk->crossing < walk->crossing_end; walk->crossing++) {
        size_t row = walk->crossing;
        if (r->crossing_segment[row] > segment)
            return;
        int32_t detector = r->crossing_detector[row];
        struct rmap_crossing crossing = {.optical_path = 0.0};
        if (detector >= 0 && (size_t)detector < r->model->n_detector)
            rmap_crossing_find(&r->model->scene->detector[detector], leg, &crossing);
        to_float3(leg->direction, crossing.direction);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_RMAP_REGISTRATION_cell], 2 * row, 2,
                              sizeof *crossing.cell, crossing.cell);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_RMAP_REGISTRATION_relative], 2 * row, 2,
                              sizeof *crossing.relative, crossing.relative);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_RMAP_REGISTRATION_direction], 3 * row, 3,
                              sizeof *crossing.direction, crossing.direction);
        offer_double(&r->lane[RMAP_LANE_RMAP_REGISTRATION_optical_path], row,
                     crossing.optical_path);
    }
}

static void offer_colour(struct walk *walk, size_t row)
{
    const struct rmap_retrace *r = walk->r;
    size_t n = (size_t)r->model->n_channel;
    if (walk->light.changed)
        rmap_light_quantise(r->model->n_channel, &walk->light);
    if (!rmap_lane_offer(&r->lane[RMAP_LANE_RMAP_SEGMENT_colour], row * n, n, sizeof(uint16_t),
                         walk->light.quantised))
        rmap_light_set(walk->light.quantised, r->model->n_channel, &walk->light);
}

static struct rmap_vec3 diffused(struct rmap_vec3 normal, double u, double v)
{
    struct rmap_vec3 x, y;
    rmap_basis(normal, &x, &y);
    double r = sqrt(u), cosine, sine;
    rmap_azimuth(v, &cosine, &sine);
    struct rmap_vec3 plane = rmap_axpy(r * cosine, x, rmap_scale(y, r * sine));
    return rmap_axpy(sqrt(1.0 - u), normal, plane);
}

static struct rmap_vec3 reflected(struct rmap_vec3 direction, struct rmap_vec3 normal)
{
    double cosine = rmap_dot(direction, normal);
    return rmap_normalize(rmap_axpy(-2.0 * cosine, normal, direction));
}

static struct rmap_vec3 refracted(struct rmap_vec3 direction, struct rmap_vec3 normal, double n1,
                                  double n2)
{
    if (n1 == n2)
        return direction;
    double cosine = rmap_dot(direction, normal);
    struct rmap_vec3 tangent = rmap_scale(rmap_axpy(-cosine, normal, direction), n1 / n2);
    double cos2_t = 1.0 - rmap_dot(tangent, tangent);
    if (cos2_t <= 0.0)
        return reflected(direction, normal);
    return rmap_axpy(-sqrt(cos2_t), normal, tangent);
}

/* Direction and colour behind the surface at the end of leg `segment`. */
static void meet(struct walk *walk, size_t row, uint32_t segment, struct rmap_vec3 normal)
{
    const struct rmap_retrace *r = walk->r;
    const struct rmap_compact_object *object = &r->model->object[r->object[row]];
    const struct rmap_medium *near = medium_of(r, r->medium[row]),
                             *far = medium_of(r, r->medium[row + 1]);
    uint32_t event = r->event[row];
    double cosine = rmap_dot(walk->direction, normal);
    bool front = cosine < 0.0;
    if (!front)
        normal = rmap_scale(normal, -1.0);
    if (event & (RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE)) {
        double u[4];
        rmap_rng(r->seed, r->id[walk->ray], segment + 1, RMAP_RNG_SURFACE, u);
        bool through = event & RMAP_EVENT_TRANSMIT_DIFFUSE;
        walk->direction = diffused(through ? rmap_scale(normal, -1.0) : normal, u[2], u[3]);
    } else if (event & (RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_TOTAL_REFLECTION)) {
        walk->direction = reflected(walk->direction, normal);
    } else if ((event & RMAP_EVENT_TRANSMIT_SPECULAR) && near && far) {
        int channel = walk->channel > 0 ? walk->channel : 0;
        walk->direction = refracted(walk->direction, normal, near->n[channel], far->n[channel]);
    }
    if (!r->colour || !near || !far)
        return;
    struct rmap_encounter encounter = {.surface = front ? object->front : object->back,
                                       .near = near,
                                       .far = far,
                                       .cosine = cosine < 0.0 ? -cosine : cosine,
                                       .event = event,
                                       .channel = walk->channel};
    if (!(encounter.cosine <= 1.0))
        encounter.cosine = 1.0;
    rmap_light_meet(&encounter, &walk->light);
}

/* One leg. last: of the ray. */
static void advance(struct walk *walk, size_t row, uint32_t segment, bool last)
{
    const struct rmap_retrace *r = walk->r;
    struct rmap_facing facing = {.normal = {0.0, 0.0, 0.0}};
    const struct rmap_medium *medium = medium_of(r, r->medium[row]);
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], walk->object,
                                walk->position, walk->direction, &facing);
    struct rmap_compact_leg leg = {.from = walk->position,
                                   .direction = walk->direction,
                                   .length = facing.t,
                                   .optical_from = walk->optical_path,
                                   .index = 1.0,
                                   .left = (r->event[row] & RMAP_EVENT_LEFT) != 0};
    if (!met)
        leg.length = distance_out(walk);
    if (medium && r->colour)
        leg.index = medium->dispersive ? rmap_light_mean(&walk->light, medium->n)
                                       : medium->n[walk->light.begin];
    if (medium && medium->absorbing && leg.length > 0.0)
        leg.length = rmap_light_absorb(medium, r->seed, r->id[walk->ray], segment + 1, leg.length,
                                       &walk->light);
    if (!met) {
        facing.position = rmap_axpy(leg.length, walk->direction, walk->position);
    } else if (leg.length < facing.t) {
        leg.length = facing.t; /* the path says that it got through */
    }
    if (offer_point(r, &r->lane[RMAP_LANE_RMAP_SEGMENT_position], row, &facing.position) == WRONG) {
        struct rmap_vec3 way = rmap_sub(facing.position, walk->position);
        leg.length = rmap_length(way);
        if (leg.length > 0.0)
            walk->direction = leg.direction = rmap_scale(way, 1.0 / leg.length);
    }
    leg.to = facing.position;
    offer_normal(&r->lane[RMAP_LANE_RMAP_SEGMENT_normal], row, facing.normal);
    if (r->colour)
        offer_colour(walk, row);
    if (r->crossing_segment)
        offer_crossings(walk, segment, &leg);
    if (!leg.left) {
        walk->path_length += leg.length;
        walk->optical_path += leg.index * leg.length;
    }
    if (met && !last)
        meet(walk, row, segment, facing.normal);
    walk->position = facing.position;
    walk->object = met ? r->object[row] : -1;
}

static void begin(struct walk *walk)
{
    const struct rmap_retrace *r = walk->r;
    struct rmap_departure departure;
    rmap_departure_find(r->model, r->seed, r->id[walk->ray], r->source[walk->ray], &departure);
    (void)offer_point(r, &r->lane[RMAP_LANE_RMAP_RAY_start], walk->ray, &departure.position);
    offer_normal(&r->lane[RMAP_LANE_RMAP_RAY_start_normal], walk->ray, departure.normal);
    walk->position = departure.position;
    walk->direction = departure.direction;
    walk->object = r->start_object[walk->ray];
    walk->path_length = walk->optical_path = 0.0;
    walk->channel = (int)r->channel[walk->ray] - 1;
    if (walk->channel >= r->model->n_channel)
        walk->channel = -1;
    rmap_light_begin(r->model, r->source[walk->ray], departure.channel, &walk->light);
}

static void end(struct walk *walk)
{
    const struct rmap_retrace *r = walk->r;
    struct rmap_vec3 way = {0.0, 0.0, 0.0};
    float value[3];
    if (r->crossing_segment) {
        const struct rmap_compact_leg none = {.index = 1.0};
        offer_crossings(walk, UINT32_MAX, &none);
    }
    offer_double(&r->lane[RMAP_LANE_RMAP_RAY_path_length], walk->ray, walk->path_length);
    offer_double(&r->lane[RMAP_LANE_RMAP_RAY_optical_path], walk->ray, walk->optical_path);
    if (r->stop[walk->ray] == RMAP_STOP_LEFT)
        way = walk->direction;
    to_float3(way, value);
    (void)rmap_lane_offer(&r->lane[RMAP_LANE_RMAP_RAY_end_direction], 3 * walk->ray, 3,
                          sizeof *value, value);
}

void rmap_retrace(const struct rmap_retrace *retrace)
{
    struct walk walk;
    size_t row = 0;
    walk.r = retrace;
    walk.crossing = walk.crossing_end = 0;
    for (size_t i = 0; i < retrace->n_ray; i++) {
        uint32_t n = retrace->segment_count[i];
        walk.ray = i;
        walk.crossing_end += retrace->registration_count[i];
        begin(&walk);
        for (uint32_t k = 0; k < n; k++)
            advance(&walk, row++, k, k + 1 == n);
        end(&walk);
    }
}
