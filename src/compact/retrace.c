/* SPDX-License-Identifier: MIT
 *
 * One ray after the other traced again, each along its path. Predictions and truth meet at every
 * number: what differs leads the ray on from the truth.
 */
#include "compact/retrace.h"
#include "base/portable.h"
#include "base/rng.h"
#include "compact/detect.h"
#include "compact/model.h"
#include "compact/retrace_colour.h"
#include "compact/step.h"
#include "formula/emit.h"
#include "formula/triangle.h"
#include "geometry/sag.h"
#include "trace/source.h"
#include "trace/turbid.h"

/* Where a segment crosses the detector that its path names (trace/detector.c has the physics). */

static void on_plane(const struct rmap_detector *detector,
                     const struct rmap_compact_segment *segment, double relative[2],
                     double *distance)
{
    struct rmap_vec3 point = segment->to;
    *distance = segment->length;
    if (!rmap_detect_lies_on(detector)) {
        double from = rmap_dot(rmap_sub(segment->from, detector->origin), detector->axis);
        double to = rmap_dot(rmap_sub(segment->to, detector->origin), detector->axis);
        *distance = segment->length * (from / (from - to));
        point = rmap_axpy(*distance, segment->direction, segment->from);
    }
    rmap_detect_point(detector, point, relative);
}

static void far_away(const struct rmap_detector *detector,
                     const struct rmap_compact_segment *segment, double relative[2])
{
    double c = rmap_dot(segment->direction, detector->axis);
    c = c > -1.0 ? c < 1.0 ? c : 1.0 : -1.0;
    double x = rmap_dot(segment->direction, detector->x),
           y = rmap_dot(segment->direction, detector->y);
    double phi = rmap_portable_angle(x, y < 0.0 ? -y : y);
    if (y < 0.0)
        phi = 2.0 * RMAP_PI - phi;
    relative[0] = rmap_portable_angle(c, sqrt((1.0 - c) * (1.0 + c))) / RMAP_PI;
    relative[1] = phi / (2.0 * RMAP_PI);
}

void rmap_crossing_find(const struct rmap_detector *detector,
                        const struct rmap_compact_segment *segment, struct rmap_crossing *crossing)
{
    double relative[2], distance = 0.0;
    if (detector->type == RMAP_DETECTOR_PLANE)
        on_plane(detector, segment, relative, &distance);
    else
        far_away(detector, segment, relative);
    rmap_detect_record(detector, relative, crossing->cell, crossing->relative);
    crossing->optical_path = segment->optical_from + segment->index * distance;
    crossing->group_path = segment->group_from + segment->group_index * distance;
}

/* Where a ray starts: the source's random numbers drawn again. */

void rmap_departure_find(const struct rmap_compact_model *model, uint64_t seed, uint64_t ray,
                         int32_t index, struct rmap_departure *departure)
{
    *departure = (struct rmap_departure){.direction = {0.0, 0.0, 1.0}, .channel = -1};
    if (index < 0 || (size_t)index >= model->n_source)
        return;
    const struct rmap_source *source = &model->scene->source[index];
    const struct rmap_compact_source *own = &model->source[index];
    departure->medium = source->medium;
    struct rmap_list_ray start;
    const bool started = rmap_source_start(model->scene, source, seed, ray, &start);
    departure->channel = rmap_source_channel(model->scene, source, seed, ray, start.channel);
    if (started) {
        departure->position = start.origin;
        departure->direction = start.direction;
        departure->delay_ns = start.delay_ns;
        return;
    }
    double place[4] = {0.5, 0.5, 0.5, 0.5}, way[4];
    struct rmap_vec3 normal = own->axis, x = own->tangent[0], y = own->tangent[1];
    if (source->shape != RMAP_EMITTER_POINT)
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
    departure->position = source->shape == RMAP_EMITTER_MESH
                              ? rmap_source_point(model->scene, source, place, &normal)
                              : rmap_source_flat_point(source, place);
    departure->direction = normal;
    if (rmap_source_is_parallel(source))
        return;
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
    if (source->type != RMAP_SOURCE_AREA) {
        departure->direction =
            rmap_normalize(rmap_affine_vector(&source->frame, rmap_source_about_z(source, way)));
        return;
    }
    departure->normal = normal;
    if (source->shape == RMAP_EMITTER_MESH)
        rmap_basis(normal, &x, &y);
    departure->direction = rmap_source_is_directed(source)
                               ? rmap_source_directed(source, normal, way)
                               : rmap_lambertian(normal, x, y, way[0], way[1]);
}

/* The point where a segment meets the surface that its path names. The steps are the tracer's, so
 * that the doubles come out the same; but they are part of the format, and stay as they are when
 * the tracer's change. */

/* In the object's frame. */
struct local {
    struct rmap_vec3 origin, direction, point, normal;
    double t;
};

static void flat(struct local *l)
{
    l->t = -l->origin.z / l->direction.z;
    l->point =
        rmap_vec3(l->origin.x + l->t * l->direction.x, l->origin.y + l->t * l->direction.y, 0);
    l->normal = rmap_vec3(0, 0, 1);
}

/* own: the segment starts on it. */
static bool meet_quadric(const struct rmap_compact_object *o, bool own, double behind,
                         struct local *l)
{
    if (own) {
        l->t = rmap_quadric_other(&o->quadric.form, l->origin, l->direction);
        l->point = rmap_axpy(l->t, l->direction, l->origin);
        return true;
    }
    const struct rmap_quadric_roots roots =
        rmap_quadric_meet(&o->quadric.form, l->origin, l->direction);
    l->t = rmap_quadric_choose(&o->quadric, behind, &roots, l->direction, &l->point);
    return roots.missed == 0.0;
}

/* Newton's method on z - sag(x^2 + y^2) along the segment, from the conic's point on. */
#define ASPHERE_STEPS 8

static void descend_asphere(const struct rmap_shape *shape, struct local *l)
{
    double c = shape->curvature, t = l->t, slope = 0;
    for (int k = 0; k < ASPHERE_STEPS; k++) {
        struct rmap_vec3 p = rmap_axpy(t, l->direction, l->origin);
        double s = p.x * p.x + p.y * p.y, rest = 1 - (1 + shape->conic) * c * c * s;
        double root = sqrt(rest > 0 ? rest : 0), poly = 0, rate = 0;
        for (int i = shape->n_asphere - 1; i >= 0; i--) {
            poly = (poly + shape->asphere[i]) * s;
            rate = rate * s + (i + 1) * shape->asphere[i];
        }
        slope = root > 0 ? c / (2 * root) + rate : rate;
        double g = p.z - (c * s / (1 + root) + poly);
        double g_rate = l->direction.z - 2 * slope * (p.x * l->direction.x + p.y * l->direction.y);
        l->point = p;
        l->t = t;
        if (k + 1 < ASPHERE_STEPS && g_rate != 0)
            t -= g / g_rate;
    }
    l->normal = rmap_normalize(rmap_vec3(-2 * slope * l->point.x, -2 * slope * l->point.y, 1));
}

/* The same from the plane of the vertex, or from the start where that is on it. */
#define SAG_STEPS 12

static void descend_sag(const struct rmap_shape *shape, bool own, struct local *l)
{
    struct rmap_height at = {0, 0, 0};
    double t = own || l->direction.z == 0 ? 0 : -l->origin.z / l->direction.z;
    for (int k = 0; k < SAG_STEPS; k++) {
        l->t = t;
        l->point = rmap_axpy(t, l->direction, l->origin);
        at = rmap_sag_height(shape->sag[0], l->point.x, l->point.y);
        const double rate = l->direction.z - at.x * l->direction.x - at.y * l->direction.y;
        if (k + 1 < SAG_STEPS && rate != 0)
            t -= (l->point.z - at.z) / rate;
    }
    at = rmap_sag_profile(shape->sag[0], l->point.x, l->point.y);
    l->normal = rmap_normalize(rmap_vec3(-at.x, -at.y, 1));
}

/* The first root ahead. */
static bool meet_wall(const struct rmap_shape *shape, bool own, double behind, struct local *l)
{
    double t[2];
    const int n = rmap_wall_roots(shape, own, l->origin, l->direction, t);
    if (n == 0)
        return false;
    l->t = t[0] > behind ? t[0] : t[n - 1];
    l->point = rmap_axpy(l->t, l->direction, l->origin);
    l->normal = shape->outline.rectangle
                    ? rmap_side_outward(shape->side)
                    : rmap_aperture_outward(&shape->outline, l->point.x, l->point.y);
    return true;
}

/* On the surface of its face. own: the segment starts on this one. */
static bool meet_true(const struct rmap_true_surface *surface, const struct rmap_vec3 corner[3],
                      bool own, double behind, struct local *l)
{
    struct rmap_true_meeting met;
    struct rmap_vec3 middle =
        rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3);
    rmap_true_meet(surface, l->origin, l->direction, own, &met);
    int i = rmap_true_choose(&met, behind, middle);
    if (i < 0)
        return false;
    l->t = met.t[i];
    l->point = met.point[i];
    l->normal = rmap_true_normal(
        surface, l->point,
        rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0])));
    return true;
}

/* from: the triangle of the same object that the segment starts on, or -1. */
static bool meet_triangle(const struct rmap_compact_object *o, int32_t primitive, int32_t from,
                          double behind, struct local *l)
{
    if (primitive < 0 || (size_t)primitive >= o->mesh->n_triangle)
        return false;
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(o->mesh, (size_t)primitive, corner);
    const struct rmap_true_surface *surface = rmap_mesh_surface(o->mesh, (size_t)primitive);
    if (surface) {
        bool own = from >= 0 && (size_t)from < o->mesh->n_triangle &&
                   rmap_true_same(&o->mesh->surface[o->mesh->face[from]], surface);
        return meet_true(surface, corner, own, behind, l);
    }
    l->t = rmap_triangle_meet(corner[0], corner[1], corner[2], l->origin, l->direction, &l->point,
                              &l->normal);
    return true;
}

bool rmap_facing_find(const struct rmap_compact_model *model, int32_t object, int32_t primitive,
                      const struct rmap_left *left, struct rmap_vec3 origin,
                      struct rmap_vec3 direction, struct rmap_facing *facing)
{
    if (object < 0 || (size_t)object >= model->n_object)
        return false;
    const struct rmap_compact_object *o = &model->object[object];
    struct local l = {.origin = rmap_affine_point(&o->to_local, origin),
                      .direction = rmap_affine_vector(&o->to_local, direction)};
    bool own = left->object == object;
    switch (o->kind) {
    case RMAP_FACING_FLAT:
        flat(&l);
        break;
    case RMAP_FACING_QUADRIC:
        if (!meet_quadric(o, own, -model->epsilon, &l))
            return false;
        l.normal = rmap_quadric_unit_normal(&o->quadric, l.point);
        break;
    case RMAP_FACING_ASPHERE:
        if (!meet_quadric(o, own, -model->epsilon, &l))
            return false;
        descend_asphere(o->shape, &l);
        break;
    case RMAP_FACING_SAG:
        descend_sag(o->shape, own, &l);
        break;
    case RMAP_FACING_WALL:
        if (!meet_wall(o->shape, own, -model->epsilon, &l))
            return false;
        break;
    case RMAP_FACING_MESH:
        if (!meet_triangle(o, primitive, own ? left->primitive : -1, -model->epsilon, &l))
            return false;
        break;
    }
    facing->t = l.t > 0 ? l.t : 0;
    facing->position = rmap_affine_point(&o->to_world, l.point);
    facing->normal = rmap_affine_transposed(&o->to_local, l.normal);
    if (!o->rigid || o->kind == RMAP_FACING_MESH)
        facing->normal = rmap_normalize(facing->normal);
    return true;
}

struct walk {
    const struct rmap_retrace *r;
    size_t ray, crossing, crossing_end; /* rows */
    struct rmap_vec3 position, direction;
    struct rmap_left left;
    int channel; /* at the end; -1: several */
    double path_length, optical_path, group_path;
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

enum outcome { RIGHT, NEAR, WRONG };

/* Offers a point; *point becomes the best guess at the double behind the true floats. */
static enum outcome offer_point(const struct rmap_retrace *r, struct rmap_lane *lane, size_t row,
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

/* Registrations up to this number of segment (from 0 within the ray). */
static void offer_crossings(struct walk *walk, uint32_t number,
                            const struct rmap_compact_segment *segment)
{
    const struct rmap_retrace *r = walk->r;
    for (; walk->crossing < walk->crossing_end; walk->crossing++) {
        size_t row = walk->crossing;
        if (r->crossing_segment[row] > number)
            return;
        int32_t detector = r->crossing_detector[row];
        struct rmap_crossing crossing = {.optical_path = 0.0};
        if (detector >= 0 && (size_t)detector < r->model->n_detector)
            rmap_crossing_find(&r->model->scene->detector[detector], segment, &crossing);
        rmap_step_float3(segment->direction, crossing.direction);
        if (!r->placed) {
            (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_cell], 2 * row, 2,
                                  sizeof *crossing.cell, crossing.cell);
            (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_relative], 2 * row, 2,
                                  sizeof *crossing.relative, crossing.relative);
        }
        (void)rmap_lane_offer(&r->lane[RMAP_LANE_REGISTRATION_direction], 3 * row, 3,
                              sizeof *crossing.direction, crossing.direction);
        offer_double(&r->lane[RMAP_LANE_REGISTRATION_optical_path], row, crossing.optical_path);
        if (!r->model->scene->timed)
            continue;
        offer_double(&r->lane[RMAP_LANE_REGISTRATION_group_path], row, crossing.group_path);
        offer_double(&r->lane[RMAP_LANE_REGISTRATION_delay], row, walk->light.delay_ns);
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

/* Direction and colour behind the surface at the end of segment `segment`. */
static void meet(struct walk *walk, size_t row, uint32_t segment, const struct rmap_facing *facing)
{
    const struct rmap_retrace *r = walk->r;
    const struct rmap_compact_object *object = &r->model->object[r->object[row]];
    const struct rmap_medium *near = rmap_step_medium(r->model, r->medium[row]),
                             *far = rmap_step_medium(r->model, r->medium[row + 1]);
    uint32_t event = r->event[row];
    double cosine = rmap_dot(walk->direction, facing->normal);
    bool front = cosine < 0.0;
    struct rmap_vec3 normal = front ? facing->normal : rmap_scale(facing->normal, -1.0);
    const struct rmap_turning turning = {.scene = r->model->scene,
                                         .object = r->object[row],
                                         .primitive = r->primitive[row],
                                         .position = facing->position,
                                         .front = front,
                                         .seed = r->seed,
                                         .ray = r->id[walk->ray],
                                         .step = segment + 1,
                                         .event = event,
                                         .near = near,
                                         .far = far,
                                         .channel = walk->channel > 0 ? walk->channel : 0};
    double met = front ? -cosine : cosine;
    if (r->predicted.metals && r->colour && !rmap_colour_single(&walk->light.colour))
        met = rmap_step_facet_cosine(&turning, met, walk->direction, normal);
    walk->direction = rmap_step_turned(&turning, walk->direction, normal);
    if (!r->colour || !near || !(cosine == cosine))
        return;
    struct rmap_encounter encounter = {
        .scene = r->model->scene,
        .object = r->object[row],
        .front = front,
        .surface = front ? object->front : object->back,
        .predicted = &r->predicted,
        .near = near,
        .far = rmap_medium_beyond(r->model, r->object[row], front, near),
        .cosine = met,
        .event = event,
        .channel = walk->channel};
    if (!(encounter.cosine <= 1.0))
        encounter.cosine = 1.0;
    rmap_light_meet(&encounter, &walk->light);
}

static double index_of(const struct rmap_medium *medium, const struct rmap_colour *colour,
                       const double *n)
{
    return medium->dispersive ? rmap_colour_sum(colour, n) : n[colour->begin];
}

/* One segment. last: of the ray. */
static void advance(struct walk *walk, size_t row, uint32_t number, bool last)
{
    const struct rmap_retrace *r = walk->r;
    struct rmap_facing facing = {.normal = {0.0, 0.0, 0.0}};
    const struct rmap_medium *medium = rmap_step_medium(r->model, r->medium[row]);
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], &walk->left,
                                walk->position, walk->direction, &facing);
    struct rmap_compact_segment segment = {.from = walk->position,
                                           .direction = walk->direction,
                                           .length = facing.t,
                                           .optical_from = walk->optical_path,
                                           .index = 1.0,
                                           .group_from = walk->group_path,
                                           .group_index = 1.0,
                                           .left = (r->event[row] & RMAP_EVENT_LEFT) != 0};
    struct rmap_inside inside = {
        .medium = medium,
        .turbid = r->predicted.turbid,
        .draw = {r->seed, r->id[walk->ray], number + 1},
        .event = met ? 0 : r->event[row] & rmap_step_inside(r->predicted.turbid)};
    if (!met)
        segment.length = rmap_step_distance_out(r->model->scene, walk->position, walk->direction);
    if (medium && r->colour) {
        segment.index = index_of(medium, &walk->light.colour, medium->n);
        if (r->model->scene->timed)
            segment.group_index = index_of(medium, &walk->light.colour, medium->n_group);
    }
    bool single = rmap_colour_single(&walk->light.colour);
    if (medium && rmap_medium_participates(medium) && segment.length > 0.0 &&
        (inside.event || !single)) {
        inside.length = segment.length;
        const double travelled = rmap_light_travel(&inside, &walk->light);
        segment.length = inside.event ? travelled : segment.length;
    }
    if (!met)
        facing.position = rmap_axpy(segment.length, walk->direction, walk->position);
    if (offer_point(r, &r->lane[RMAP_LANE_SEGMENT_position], row, &facing.position) == WRONG) {
        struct rmap_vec3 way = rmap_sub(facing.position, walk->position);
        segment.length = rmap_length(way);
        if (segment.length > 0.0)
            walk->direction = segment.direction = rmap_scale(way, 1.0 / segment.length);
    }
    segment.to = facing.position;
    offer_normal(&r->lane[RMAP_LANE_SEGMENT_normal], row, facing.normal);
    if (r->colour)
        offer_colour(walk, row);
    if (r->crossing_segment)
        offer_crossings(walk, number, &segment);
    if (!segment.left) {
        walk->path_length += segment.length;
        walk->optical_path += segment.index * segment.length;
        walk->group_path += segment.group_index * segment.length;
    }
    if (met && !last)
        meet(walk, row, number, &facing);
    else if (!last && medium && (inside.event & ~(uint32_t)RMAP_EVENT_ABSORB) &&
             rmap_light_go_on(&inside, r->model->n_channel, &walk->light, &walk->direction) &&
             r->model->scene->fluoresces)
        walk->channel = walk->light.colour.begin;
    walk->position = facing.position;
    walk->left =
        met ? (struct rmap_left){r->object[row], r->primitive[row]} : (struct rmap_left){-1, -1};
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
    walk->left = (struct rmap_left){r->start_object[walk->ray], -1};
    walk->path_length = walk->optical_path = walk->group_path = 0.0;
    walk->light.delay_ns = departure.delay_ns;
    walk->channel = (int)r->channel[walk->ray] - 1;
    if (walk->channel >= r->model->n_channel)
        walk->channel = -1;
    rmap_light_begin(r->model, r->source[walk->ray], departure.channel, &walk->light);
    if (r->model->scene->fluoresces)
        walk->channel = walk->light.colour.begin;
}

static void end(struct walk *walk)
{
    const struct rmap_retrace *r = walk->r;
    struct rmap_vec3 way = {0.0, 0.0, 0.0};
    float value[3];
    if (r->crossing_segment) {
        const struct rmap_compact_segment none = {.index = 1.0};
        offer_crossings(walk, UINT32_MAX, &none);
    }
    offer_double(&r->lane[RMAP_LANE_RAY_path_length], walk->ray, walk->path_length);
    offer_double(&r->lane[RMAP_LANE_RAY_optical_path], walk->ray, walk->optical_path);
    if (r->model->scene->timed) {
        offer_double(&r->lane[RMAP_LANE_RAY_group_path], walk->ray, walk->group_path);
        offer_double(&r->lane[RMAP_LANE_RAY_delay], walk->ray, walk->light.delay_ns);
    }
    if (r->stop[walk->ray] == RMAP_STOP_LEFT)
        way = walk->direction;
    rmap_step_float3(way, value);
    (void)rmap_lane_offer(&r->lane[RMAP_LANE_RAY_end_direction], 3 * walk->ray, 3, sizeof *value,
                          value);
}

struct rmap_retrace rmap_retrace_of(const struct rmap_compact_model *model,
                                    const struct rmap_lane_header *header,
                                    const struct rmap_portion *portion, const uint8_t *channel,
                                    struct rmap_lane *lane)
{
    return (struct rmap_retrace){.model = model,
                                 .seed = header->seed,
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
                                 .placed = header->placed,
                                 .predicted = header->predicted,
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
