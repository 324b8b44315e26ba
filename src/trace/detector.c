/* SPDX-License-Identifier: MIT
 *
 * Virtual detectors, which watch and never disturb the light.
 */
#include "trace/detector.h"

#include <math.h>

static uint32_t cell_of(double relative, uint32_t cells)
{
    double cell = floor(relative * (double)cells);
    if (!(cell > 0.0))
        return 0;
    return cell < (double)cells ? (uint32_t)cell : cells - 1;
}

/* Angle limit, counted from the normal of the side that the light meets. */
static bool accepts_angle(const struct rmap_detector *detector, double cosine)
{
    if (detector->max_angle_rad >= 0.5 * RMAP_PI) /* no angle is greater */
        return true;
    double angle_rad = rmap_angle_of(cosine);
    return fmin(angle_rad, RMAP_PI - angle_rad) <= detector->max_angle_rad;
}

static bool accepts(const struct rmap_detector *detector, double cosine)
{
    if (detector->side == RMAP_SIDE_FRONT && !(cosine > 0.0))
        return false;
    if (detector->side == RMAP_SIDE_BACK && !(cosine < 0.0))
        return false;
    return accepts_angle(detector, cosine);
}

static void place(const struct rmap_detector *detector, struct rmap_registration *registration)
{
    for (int k = 0; k < 2; k++)
        registration->cell[k] = cell_of(registration->relative[k], detector->cells[k]);
}

/* Light at a point of a segment. */
struct passage {
    struct rmap_vec3 point, direction;
    double optical_path, group_path, delay_ns;
    uint32_t segment;
};

/* Registers light at a point of the detector's plane, if it lies within its area. */
static void register_plane(const struct rmap_scene *scene, int32_t index,
                           const struct passage *light, struct rmap_recorder *recorder)
{
    const struct rmap_detector *detector = &scene->detector[index];
    struct rmap_vec3 offset = rmap_sub(light->point, detector->origin);
    double x = rmap_dot(offset, detector->x), y = rmap_dot(offset, detector->y);
    if (!(fabs(x) <= 0.5 * detector->size[0] && fabs(y) <= 0.5 * detector->size[1]))
        return;
    double cosine = -rmap_dot(light->direction, detector->axis);
    struct rmap_registration registration = {
        .detector = index,
        .segment = light->segment,
        .relative = {x / detector->size[0] + 0.5, y / detector->size[1] + 0.5},
        .position = rmap_axpy(x, detector->x, rmap_axpy(y, detector->y, detector->origin)),
        .direction = light->direction,
        .cosine = cosine,
        .optical_path = light->optical_path,
        .group_path = light->group_path,
        .delay_ns = light->delay_ns};
    registration.registered = accepts(detector, cosine);
    place(detector, &registration);
    recorder->registration(recorder, &registration);
}

static double height(const struct rmap_detector *detector, struct rmap_vec3 p)
{
    return rmap_dot(rmap_sub(p, detector->origin), detector->axis);
}

static bool crosses(double from, double to)
{
    return (from > 0.0 && to <= 0.0) || (from < 0.0 && to >= 0.0);
}

struct crossing {
    double along; /* distance from the start, or theta of a curve */
    int32_t detector;
};

static bool before(struct crossing a, struct crossing b)
{
    return a.along < b.along || (a.along == b.along && a.detector < b.detector);
}

#define SORTED_MAX 16

/* The nearest crossings after `last`, sorted. */
struct sorted {
    struct crossing last, c[SORTED_MAX];
    int n;
};

static void sort_in(struct sorted *sorted, struct crossing c)
{
    if (!before(sorted->last, c))
        return;
    if (sorted->n == SORTED_MAX && !before(c, sorted->c[SORTED_MAX - 1]))
        return;
    int at = sorted->n < SORTED_MAX ? sorted->n++ : SORTED_MAX - 1;
    for (; at > 0 && before(c, sorted->c[at - 1]); at--)
        sorted->c[at] = sorted->c[at - 1];
    sorted->c[at] = c;
}

/* The straight segment, or the step of a curve, that detectors watch. */
struct watched {
    const struct rmap_segment *segment;
    const struct rmap_segment_piece *piece; /* NULL: a straight segment */
};

static void find_straight(const struct rmap_detector *detector, int32_t index,
                          const struct rmap_segment *segment, struct sorted *sorted)
{
    double from = height(detector, segment->from), to = height(detector, segment->to);
    if (crosses(from, to))
        sort_in(sorted, (struct crossing){segment->length * (from / (from - to)), index});
}

/* An interval of theta, and the curve's height over the detector at its ends. */
struct interval {
    double a, b, from, to;
};

/* The root in an interval at whose ends the heights differ in sign: Newton's steps, or halving
 * where they lead out of the bracket. */
static double root(const struct rmap_detector *detector, const struct rmap_curve_step *step,
                   struct interval at)
{
    struct rmap_vec3 r, T;
    double theta = at.a + (at.b - at.a) * (at.from / (at.from - at.to));
    for (int i = 0; i < 60; i++) {
        rmap_curve_at(step, theta, &r, &T);
        double h = height(detector, r), rate = step->h * rmap_dot(T, detector->axis);
        if (h == 0.0)
            break;
        if (crosses(at.from, h))
            at.b = theta;
        else
            at.a = theta;
        double next = theta - h / rate;
        if (!(next > at.a && next < at.b))
            next = 0.5 * (at.a + at.b);
        if (fabs(next - theta) <= 1e-15)
            break;
        theta = next;
    }
    return theta;
}

#define HALVINGS_MAX 48

/* How far the height may lie from a straight line through the interval's ends. A curve within the
 * plane has none, however much it bends. */
static double height_sag(const struct rmap_detector *detector, const struct rmap_curve_step *step,
                         const struct interval *at)
{
    enum { PARTS = 4 };
    double sag = 0.0;
    for (int i = 1; i < PARTS; i++) {
        const double share = (double)i / PARTS;
        struct rmap_vec3 r, T;
        rmap_curve_at(step, at->a + share * (at->b - at->a), &r, &T);
        sag = fmax(sag, fabs(height(detector, r) - (at->from + share * (at->to - at->from))));
    }
    return 1.05 * sag;
}

/* A piece of a curve that is searched for crossings with one detector. */
struct search {
    const struct rmap_detector *detector;
    const struct rmap_curve_step *step;
    int32_t index;
    double tolerance; /* not below what heights are rounded by */
    struct sorted *sorted;
};

/* Whether the curve stays on its side between two ends that do. Without the tolerance halving would
 * not end where a curve runs in the detector's plane. */
static bool stays(const struct search *search, const struct interval *at)
{
    const double nearest = fmin(fabs(at->from), fabs(at->to));
    double sag = rmap_curve_sag(search->step, at->a, at->b);
    if (nearest > sag || sag <= search->tolerance)
        return true;
    sag = height_sag(search->detector, search->step, at);
    return nearest > sag || sag <= search->tolerance;
}

/* All crossings in an interval: none where both ends lie on one side, farther off than the sag; one
 * where the curve runs to the other side at both ends; else of both halves. */
static void find_curved(const struct search *search, struct interval at, int depth)
{
    struct rmap_vec3 r, T[2];
    if (!crosses(at.from, at.to)) {
        if (stays(search, &at))
            return;
    } else {
        rmap_curve_at(search->step, at.a, &r, &T[0]);
        rmap_curve_at(search->step, at.b, &r, &T[1]);
        double way = at.to - at.from;
        if (depth == HALVINGS_MAX || (rmap_dot(T[0], search->detector->axis) * way > 0.0 &&
                                      rmap_dot(T[1], search->detector->axis) * way > 0.0)) {
            sort_in(search->sorted,
                    (struct crossing){root(search->detector, search->step, at), search->index});
            return;
        }
    }
    if (depth == HALVINGS_MAX)
        return;
    double middle = 0.5 * (at.a + at.b);
    rmap_curve_at(search->step, middle, &r, &T[0]);
    double h = height(search->detector, r);
    find_curved(search, (struct interval){at.a, middle, at.from, h}, depth + 1);
    find_curved(search, (struct interval){middle, at.b, h, at.to}, depth + 1);
}

#define ROUNDING 1e-14 /* of a height, in its point's coordinates */

static double tolerance_of(const struct rmap_detector *detector,
                           const struct rmap_segment_piece *piece)
{
    const double scale =
        rmap_length(piece->from) + rmap_length(piece->to) + rmap_length(detector->origin);
    return fmax(piece->tolerance, ROUNDING * scale);
}

/* Between two points on one side a curve must be longer than its way to the plane and back. */
static bool is_far(const struct interval *at, double length)
{
    return !crosses(at->from, at->to) && fabs(at->from) + fabs(at->to) > 1.001 * length;
}

static void find(const struct rmap_scene *scene, int32_t index, const struct watched *light,
                 struct sorted *sorted)
{
    const struct rmap_detector *detector = &scene->detector[index];
    const struct rmap_segment_piece *piece = light->piece;
    if (!piece) {
        find_straight(detector, index, light->segment, sorted);
        return;
    }
    struct interval at = {0.0, 1.0, height(detector, piece->from), height(detector, piece->to)};
    const struct search search = {detector, piece->step, index, tolerance_of(detector, piece),
                                  sorted};
    if (!is_far(&at, piece->step->length))
        find_curved(&search, at, 0);
}

static struct passage on_straight(const struct rmap_segment *segment, struct rmap_vec3 point,
                                  double along)
{
    struct passage passage = {.point = point,
                              .direction = segment->direction,
                              .optical_path = segment->optical_from + segment->index * along,
                              .segment = segment->segment};
    if (segment->clock) {
        passage.group_path = segment->clock->group_path + segment->clock->group_index * along;
        passage.delay_ns = segment->clock->delay_ns;
    }
    return passage;
}

static struct passage passage_at(const struct watched *light, double along)
{
    const struct rmap_segment *segment = light->segment;
    const struct rmap_segment_piece *piece = light->piece;
    if (!piece)
        return on_straight(segment, rmap_axpy(along, segment->direction, segment->from), along);
    struct passage passage = {.segment = piece->segment};
    double length;
    rmap_curve_at(piece->step, along, &passage.point, &passage.direction);
    passage.direction = rmap_normalize(passage.direction);
    rmap_curve_lengths(piece->step, along, &passage.optical_path, &length);
    passage.optical_path += piece->optical_from;
    if (piece->clock) {
        passage.delay_ns = piece->clock->delay_ns;
        passage.group_path = piece->clock->group_path +
                             rmap_curve_group(piece->gradient, piece->channel, piece->step, along);
    }
    return passage;
}

static void detect(const struct rmap_scene *scene, const struct watched *light,
                   struct rmap_recorder *recorder)
{
    struct sorted sorted = {.last = {-1.0, -1}};
    do {
        sorted.n = 0;
        for (size_t k = 0; k < scene->n_free_detector; k++)
            find(scene, scene->free_detector[k], light, &sorted);
        for (int i = 0; i < sorted.n; i++) {
            struct passage passage = passage_at(light, sorted.c[i].along);
            register_plane(scene, sorted.c[i].detector, &passage, recorder);
        }
        if (sorted.n > 0)
            sorted.last = sorted.c[sorted.n - 1];
    } while (sorted.n == SORTED_MAX);
}

void rmap_detect_free(const struct rmap_scene *scene, const struct rmap_segment *segment,
                      struct rmap_recorder *recorder)
{
    if (scene->n_free_detector > 0)
        detect(scene, &(struct watched){.segment = segment}, recorder);
}

void rmap_detect_curve(const struct rmap_scene *scene, const struct rmap_segment_piece *piece,
                       struct rmap_recorder *recorder)
{
    if (scene->n_free_detector > 0)
        detect(scene, &(struct watched){.piece = piece}, recorder);
}

static bool has_face(const struct rmap_scene *scene, const struct rmap_detector *detector,
                     int32_t object, int32_t primitive)
{
    if (!detector->face)
        return true;
    const struct rmap_mesh *mesh = scene->geometry[scene->object[object].geometry].mesh;
    return (uint32_t)primitive < mesh->n_triangle && detector->face[mesh->face[primitive]];
}

void rmap_detect_on(const struct rmap_scene *scene, const struct rmap_segment *segment,
                    int32_t object, int32_t primitive, struct rmap_recorder *recorder)
{
    if (scene->on_first[object] == scene->on_first[object + 1])
        return;
    const struct passage light = on_straight(segment, segment->to, segment->length);
    for (size_t k = scene->on_first[object]; k < scene->on_first[object + 1]; k++)
        if (has_face(scene, &scene->detector[scene->on_detector[k]], object, primitive))
            register_plane(scene, scene->on_detector[k], &light, recorder);
}

void rmap_detect_far(const struct rmap_scene *scene, const struct rmap_segment *segment,
                     struct rmap_recorder *recorder)
{
    for (size_t k = 0; k < scene->n_far_detector; k++) {
        int32_t index = scene->far_detector[k];
        const struct rmap_detector *detector = &scene->detector[index];
        double cosine = rmap_dot(segment->direction, detector->axis), theta = rmap_angle_of(cosine);
        double phi = atan2(rmap_dot(segment->direction, detector->y),
                           rmap_dot(segment->direction, detector->x));
        if (phi < 0.0)
            phi += 2.0 * RMAP_PI;
        struct rmap_registration registration = {
            .detector = index,
            .segment = segment->segment,
            .relative = {theta / RMAP_PI, phi / (2.0 * RMAP_PI)},
            .position = segment->to,
            .direction = segment->direction,
            .cosine = cosine,
            .optical_path = segment->optical_from,
            .group_path = segment->clock ? segment->clock->group_path : 0.0,
            .delay_ns = segment->clock ? segment->clock->delay_ns : 0.0};
        registration.registered = accepts_angle(detector, cosine);
        place(detector, &registration);
        recorder->registration(recorder, &registration);
    }
}
