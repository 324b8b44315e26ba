/* SPDX-License-Identifier: MIT
 *
 * Stored segments as light that detectors watch.
 */
#include <math.h>

#include "analysis/overlay/overlay_segment.h"
#include "trace/luminescence.h"

/* The refractive index along a straight segment, n or n_group of its medium: of the mean over its
 * colour, as traced. */
static double index_of(const struct rmap_overlay_ray *ray, size_t row, const double *index)
{
    const struct rmap_portion *portion = ray->portion;
    const struct rmap_medium *medium = &ray->scene->medium[portion->segment.medium[row]];
    const int n = ray->scene->channels.n; /* rays of another colour space may have more beside */
    double sum = 0.0, whole = 0.0;
    if (!medium->dispersive || !portion->colour)
        return index[0];
    const uint16_t *share = portion->colour + row * (size_t)portion->n_channel;
    for (int c = 0; c < portion->n_channel && c < n; c++) {
        sum += share[c] * index[c];
        whole += share[c];
    }
    return whole > 0.0 ? sum / whole : index[0];
}

/* Distance to the sphere from inside; 0 from outside. */
static double distance_out(const struct rmap_scene *scene, struct rmap_vec3 origin,
                           struct rmap_vec3 direction)
{
    struct rmap_vec3 from = rmap_sub(origin, scene->centre);
    double along = rmap_dot(from, direction);
    double gap = scene->radius * scene->radius - rmap_dot(from, from);
    return gap > 0.0 ? sqrt(along * along + gap) - along : 0.0;
}

double rmap_overlay_delay(const struct rmap_overlay_ray *ray, uint32_t segment)
{
    const struct rmap_portion *portion = ray->portion;
    const size_t row = ray->segment + segment;
    if (!(portion->segment.event[row] & RMAP_EVENT_FLUORESCE))
        return 0.0;
    const int16_t medium = portion->segment.medium[row];
    const int channel = rmap_portion_channel(portion, row), n_channel = ray->scene->channels.n;
    const struct rmap_draw draw = {ray->scene->seed, portion->ray.id[ray->row], segment + 1};
    struct rmap_reemission back;
    const bool known = medium >= 0 && (size_t)medium < ray->scene->n_medium && channel < n_channel;
    return known && rmap_reemit(&ray->scene->medium[medium], n_channel, &draw, channel, &back)
               ? back.delay_ns
               : 0.0;
}

double rmap_overlay_emission_delay(const struct rmap_overlay_ray *ray)
{
    double delay = ray->portion->ray.delay ? ray->portion->ray.delay[ray->row] : 0.0;
    for (uint32_t k = 0; k < ray->n_segment && ray->scene->fluoresces; k++)
        delay -= rmap_overlay_delay(ray, k);
    return delay;
}

void rmap_overlay_segment(const struct rmap_scene *within, struct rmap_overlay_ray *ray,
                          uint32_t segment, struct rmap_vec3 from, double optical,
                          struct rmap_segment *out)
{
    const struct rmap_portion *portion = ray->portion;
    size_t row = ray->segment + segment;
    const uint32_t event = portion->segment.event[row];
    struct rmap_vec3 to = rmap_vec3_of(portion->segment.position + 3 * row);
    *out = (struct rmap_segment){.from = from,
                                 .to = to,
                                 .optical_from = optical,
                                 .segment = segment,
                                 .clock = ray->scene->timed ? &ray->clock : NULL};
    struct rmap_vec3 end = rmap_vec3_of(portion->ray.end_direction + 3 * ray->row);
    bool leaves = event & RMAP_EVENT_LEFT && !(event & RMAP_EVENT_GRADIENT);
    if (leaves && rmap_dot(end, end) > 0.0) {
        out->direction = rmap_normalize(end);
        out->length = distance_out(within, from, out->direction);
        out->to = rmap_axpy(out->length, out->direction, from);
    } else {
        struct rmap_vec3 way = rmap_sub(to, from);
        out->length = rmap_length(way);
        if (out->length > 0.0)
            out->direction = rmap_scale(way, 1.0 / out->length);
    }
    if (!(event & RMAP_EVENT_GRADIENT)) {
        const struct rmap_medium *medium = &ray->scene->medium[portion->segment.medium[row]];
        out->index = index_of(ray, row, medium->n);
        ray->clock.group_index = index_of(ray, row, medium->n_group);
    }
}

/* ---- curves ---- */

/* The gradient medium in place that the segment runs through: beside what it ends or starts on. */
static const struct rmap_gradient *gradient_of(const struct rmap_overlay_ray *ray, uint32_t segment)
{
    const struct rmap_scene *scene = ray->scene;
    const struct rmap_portion *portion = ray->portion;
    const size_t row = ray->segment + segment;
    const int32_t medium = portion->segment.medium[row];
    if (scene->n_gradient ==
        0) /* what only a damaged map says; where segments start was not read */
        return NULL;
    const int32_t beside[2] = {portion->segment.object[row],
                               segment > 0 ? portion->segment.object[row - 1]
                                           : portion->ray.start_object[ray->row]};
    for (int i = 0; i < 2; i++) {
        if (beside[i] < 0 || (size_t)beside[i] >= scene->n_object)
            continue;
        const struct rmap_object *object = &scene->object[beside[i]];
        const int32_t side[2] = {object->gradient_front, object->gradient_back};
        for (int k = 0; k < 2; k++)
            if (side[k] > 0 && scene->gradient[side[k] - 1].medium == medium)
                return &scene->gradient[side[k] - 1];
    }
    for (size_t g = 0; g < scene->n_gradient; g++)
        if (scene->gradient[g].medium == medium)
            return &scene->gradient[g];
    return NULL;
}

/* A curved segment being followed from point to point. */
struct path {
    const struct rmap_gradient *gradient; /* NULL: chords */
    int channel;
    double index; /* where the field has no value */
};

static struct rmap_curve_state state_at(const struct path *path, struct rmap_vec3 p)
{
    struct rmap_curve_state state = {.r = p, .n = path->index};
    struct rmap_vec3 slope;
    double n;
    if (path->gradient && path->gradient->field &&
        rmap_gradient_at(path->gradient, path->channel, p, &n, &slope)) {
        state.n = n;
        state.D = rmap_scale(slope, n);
    }
    return state;
}

static void put(double four[4], struct rmap_vec3 v)
{
    four[0] = v.x;
    four[1] = v.y;
    four[2] = v.z;
}

/* What d2r/dt2 is on the way from a to b: a parabola in t through D at the ends and `middle`.
 * T at the ends follows. */
static void bend(const struct rmap_curve_state *a, const struct rmap_curve_state *b,
                 struct rmap_vec3 middle, double h, struct rmap_curve_step *step)
{
    const struct rmap_vec3 mean = rmap_scale(rmap_sub(b->r, a->r), 1.0 / h);
    const struct rmap_vec3 rise =
        rmap_axpy(4.0, middle, rmap_axpy(-3.0, a->D, rmap_scale(b->D, -1.0)));
    const struct rmap_vec3 turn = rmap_scale(rmap_axpy(-2.0, middle, rmap_add(a->D, b->D)), 2.0);
    *step = (struct rmap_curve_step){.from = *a, .to = *b, .h = h, .whole = h};
    step->from.T = rmap_axpy(-h / 6.0, rmap_axpy(2.0, middle, a->D), mean);
    step->to.T = rmap_axpy(h / 6.0, rmap_axpy(2.0, middle, b->D), mean);
    put(step->bend[0], rmap_scale(a->D, 1.0 / 2.0));
    put(step->bend[1], rmap_scale(rise, 1.0 / 6.0));
    put(step->bend[2], rmap_scale(turn, 1.0 / 12.0));
    put(step->turn[0], a->D);
    put(step->turn[1], rmap_scale(rise, 1.0 / 2.0));
    put(step->turn[2], rmap_scale(turn, 1.0 / 3.0));
}

/* The curve between two points that obeys the ray equation at both and halfway, in the time that
 * light of speed |dr/dt| = n needs. false: no way between them. */
static bool join(const struct path *path, const struct rmap_curve_state *a,
                 const struct rmap_curve_state *b, struct rmap_curve_step *step)
{
    enum { ROUNDS = 4 };
    struct rmap_curve_state middle = {.D = rmap_scale(rmap_add(a->D, b->D), 0.5)};
    double h = 2.0 * rmap_length(rmap_sub(b->r, a->r)) / (a->n + b->n);
    for (int i = 0; i < ROUNDS; i++) {
        struct rmap_vec3 T;
        if (!(h > 0.0) || !isfinite(h))
            return false;
        bend(a, b, middle.D, h, step);
        h *= 0.5 * (rmap_length(step->from.T) / a->n + rmap_length(step->to.T) / b->n);
        rmap_curve_at(step, 0.5, &middle.r, &T);
        middle = state_at(path, middle.r);
    }
    bend(a, b, middle.D, h, step);
    rmap_curve_lengths(step, 1.0, &step->optical, &step->length);
    return h > 0.0 && isfinite(h);
}

void rmap_overlay_curve(const struct rmap_scene *scene, struct rmap_overlay_ray *ray,
                        struct rmap_segment *out, struct rmap_recorder *recorder)
{
    const struct rmap_portion *portion = ray->portion;
    const size_t row = ray->segment + out->segment;
    struct path path = {.gradient = gradient_of(ray, out->segment),
                        .channel = rmap_portion_channel(portion, row),
                        .index = ray->scene->medium[portion->segment.medium[row]].n[0]};
    struct rmap_curve_state from = state_at(&path, out->from);
    while (ray->curve < ray->curve_end && portion->curve.segment[ray->curve] < out->segment)
        ray->curve++;
    for (bool last = false; !last;) {
        last = ray->curve >= ray->curve_end || portion->curve.segment[ray->curve] != out->segment;
        struct rmap_vec3 p =
            last ? out->to : rmap_vec3_of(portion->curve.position + 3 * ray->curve++);
        struct rmap_curve_state to = state_at(&path, p);
        struct rmap_curve_step step;
        if (!join(&path, &from, &to, &step))
            continue;
        const struct rmap_segment_piece piece = {
            .step = &step,
            .from = from.r,
            .to = to.r,
            .optical_from = out->optical_from,
            .tolerance = path.gradient ? path.gradient->options.tolerance : 0.0,
            .segment = out->segment,
            .clock = out->clock,
            .gradient = path.gradient,
            .channel = path.channel};
        if (scene)
            rmap_detect_curve(scene, &piece, recorder);
        out->optical_from += step.optical;
        if (out->clock)
            ray->clock.group_path += path.gradient
                                         ? rmap_curve_group(path.gradient, path.channel, &step, 1.0)
                                         : step.optical;
        out->direction = rmap_normalize(step.to.T);
        from = to;
    }
    out->index = 0.0;
    ray->clock.group_index = 0.0;
}
