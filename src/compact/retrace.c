/* SPDX-License-Identifier: MIT
 *
 * One ray after the other traced again, each along its path. Predictions and truth meet at every
 * number: what differs leads the ray on from the truth.
 */
#include "compact/step.h"

struct walk {
    const struct rmap_retrace *r;
    size_t ray, crossing, crossing_end; /* rows */
    struct rmap_vec3 position, direction;
    int32_t object; /* the leg starts on, or -1 */
    int channel;    /* at the end; -1: several */
    double path_length, optical_path;
    struct rmap_compact_light light;
};

static void offer_normal(struct rmap_lane *lane, size_t row, struct rmap_vec3 normal)
{
    int16_t value[3];
    rmap_step_normal(normal, value);
    (void)rmap_lane_offer(lane, 3 * row, 3, sizeof *value, value);
}

static void offer_double(struct rmap_lane *lane, size_t row, double predicted)
{
    double value = rmap_step_double(predicted);
    (void)rmap_lane_offer(lane, row, 1, sizeof value, &value);
}

/* The nearest to x of the numbers that round to the float f. */
static double between(double x, float f)
{
    uint32_t bits;
    float beside;
    memcpy(&bits, &f, sizeof bits);
    if (rmap_step_float(x) == f || f == 0.0f)
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
    rmap_step_float3(*point, value);
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
        rmap_step_float3(leg->direction, crossing.direction);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_cell], 2 * row, 2,
                              sizeof *crossing.cell, crossing.cell);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_relative], 2 * row, 2,
                              sizeof *crossing.relative, crossing.relative);
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_direction], 3 * row, 3,
                              sizeof *crossing.direction, crossing.direction);
        offer_double(&r->lane[RMAP_LANE_REGISTRATION_optical_path], row, crossing.optical_path);
    }
}

static void offer_colour(struct walk *walk, size_t row)
{
    const struct rmap_retrace *r = walk->r;
    size_t n = (size_t)r->model->n_channel;
    if (walk->light.changed)
        rmap_light_quantise(r->model->n_channel, &walk->light);
    if (!rmap_lane_offer(&r->lane[RMAP_LANE_SEGMENT_colour], row * n, n, sizeof(uint16_t),
                         walk->light.quantised))
        rmap_light_set(walk->light.quantised, r->model->n_channel, &walk->light);
}

/* Direction and colour behind the surface at the end of leg `segment`. */
static void meet(struct walk *walk, size_t row, uint32_t segment, struct rmap_vec3 normal)
{
    const struct rmap_retrace *r = walk->r;
    const struct rmap_compact_object *object = &r->model->object[r->object[row]];
    const struct rmap_medium *near = rmap_step_medium(r->model, r->medium[row]),
                             *far = rmap_step_medium(r->model, r->medium[row + 1]);
    uint32_t event = r->event[row];
    double cosine = rmap_dot(walk->direction, normal);
    bool front = cosine < 0.0;
    if (!front)
        normal = rmap_scale(normal, -1.0);
    const struct rmap_turning turning = {.seed = r->seed,
                                         .ray = r->id[walk->ray],
                                         .step = segment + 1,
                                         .event = event,
                                         .near = near,
                                         .far = far,
                                         .channel = walk->channel > 0 ? walk->channel : 0};
    walk->direction = rmap_step_turned(&turning, walk->direction, normal);
    if (!r->colour || !near || !(cosine == cosine))
        return;
    struct rmap_encounter encounter = {
        .surface = front ? object->front : object->back,
        .near = near,
        .far = rmap_medium_beyond(r->model, r->object[row], front, near),
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
    const struct rmap_medium *medium = rmap_step_medium(r->model, r->medium[row]);
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], walk->object,
                                walk->position, walk->direction, &facing);
    struct rmap_compact_leg leg = {.from = walk->position,
                                   .direction = walk->direction,
                                   .length = facing.t,
                                   .optical_from = walk->optical_path,
                                   .index = 1.0,
                                   .left = (r->event[row] & RMAP_EVENT_LEFT) != 0};
    bool absorbed = !met && (r->event[row] & RMAP_EVENT_ABSORB);
    if (!met)
        leg.length = rmap_step_distance_out(r->model->scene, walk->position, walk->direction);
    if (medium && r->colour)
        leg.index = medium->dispersive ? rmap_colour_sum(&walk->light.colour, medium->n)
                                       : medium->n[walk->light.colour.begin];
    bool single = rmap_colour_single(&walk->light.colour);
    if (medium && medium->absorbing && leg.length > 0.0 && (absorbed || !single)) {
        double travelled = rmap_light_absorb(medium, r->seed, r->id[walk->ray], segment + 1,
                                             leg.length, absorbed, &walk->light);
        leg.length = absorbed ? travelled : leg.length;
    }
    if (!met)
        facing.position = rmap_axpy(leg.length, walk->direction, walk->position);
    if (offer_point(r, &r->lane[RMAP_LANE_SEGMENT_position], row, &facing.position) == WRONG) {
        struct rmap_vec3 way = rmap_sub(facing.position, walk->position);
        leg.length = rmap_length(way);
        if (leg.length > 0.0)
            walk->direction = leg.direction = rmap_scale(way, 1.0 / leg.length);
    }
    leg.to = facing.position;
    offer_normal(&r->lane[RMAP_LANE_SEGMENT_normal], row, facing.normal);
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
    (void)offer_point(r, &r->lane[RMAP_LANE_RAY_start], walk->ray, &departure.position);
    offer_normal(&r->lane[RMAP_LANE_RAY_start_normal], walk->ray, departure.normal);
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
    offer_double(&r->lane[RMAP_LANE_RAY_path_length], walk->ray, walk->path_length);
    offer_double(&r->lane[RMAP_LANE_RAY_optical_path], walk->ray, walk->optical_path);
    if (r->stop[walk->ray] == RMAP_STOP_LEFT)
        way = walk->direction;
    rmap_step_float3(way, value);
    (void)rmap_lane_offer(&r->lane[RMAP_LANE_RAY_end_direction], 3 * walk->ray, 3, sizeof *value,
                          value);
}

struct rmap_retrace rmap_retrace_of(const struct rmap_compact_model *model, uint64_t seed,
                                    const struct rmap_portion *portion, const uint8_t *channel,
                                    struct rmap_lane *lane)
{
    return (struct rmap_retrace){.model = model,
                                 .seed = seed,
                                 .n_ray = portion->n_row[RMAP_TABLE_RAY],
                                 .id = portion->ray.id,
                                 .source = portion->ray.source,
                                 .stop = portion->ray.stop,
                                 .segment_count = portion->ray.segment_count,
                                 .registration_count = portion->ray.registration_count,
                                 .start_object = portion->ray.start_object,
                                 .channel = channel,
                                 .object = portion->segment.object,
                                 .primitive = portion->segment.primitive,
                                 .event = portion->segment.event,
                                 .medium = portion->segment.medium,
                                 .crossing_segment = portion->registration.segment,
                                 .crossing_detector = portion->registration.detector,
                                 .colour = true,
                                 .lane = lane};
}

void rmap_retrace(const struct rmap_retrace *retrace, size_t ray, size_t first_segment,
                  size_t first_registration)
{
    struct walk walk;
    uint32_t n = retrace->segment_count[ray];
    walk.r = retrace;
    walk.ray = ray;
    walk.crossing = first_registration;
    walk.crossing_end = first_registration + retrace->registration_count[ray];
    begin(&walk);
    for (uint32_t k = 0; k < n; k++)
        advance(&walk, first_segment + k, k, k + 1 == n);
    end(&walk);
}
