/* SPDX-License-Identifier: MIT
 *
 * A segment through a gradient medium: the curve step by step until it meets a surface, ends inside
 * the medium, or leaves the scene.
 */
#include <float.h>
#include <math.h>

#include "base/rng.h"
#include "portion/curve_points.h"
#include "trace/curve_search.h"
#include "trace/walk.h"

/* A curved segment on its way. */
struct bend {
    struct rmap_walk *walk;
    struct rmap_arrival *arrival;
    const struct rmap_gradient *gradient;
    struct rmap_curve curve;
    struct rmap_curve_search search;
    struct rmap_curve_points points;
    double length, optical;  /* of the steps so far */
    struct rmap_clock clock; /* where the next step begins */
    double free_path;        /* the segment ends there inside the medium */
};

static bool is_rough(const struct rmap_walk *walk)
{
    return walk->rough && !walk->recorder;
}

/* A dispersive medium bends each wavelength apart: it is drawn before the segment. */
static void choose_wavelength(struct rmap_walk *walk)
{
    double u[4];
    rmap_rng(walk->draw.seed, walk->draw.ray, walk->draw.step, RMAP_RNG_MEDIUM, u);
    rmap_colour_collapse(&walk->colour, rmap_colour_pick(&walk->colour, NULL, u[3]));
}

/* False where the field has no value, within rounding, at the segment's start. */
static bool begin_curve(struct bend *bend, int channel)
{
    const struct rmap_walk *walk = bend->walk;
    const struct rmap_ray *ray = &walk->ray;
    double inside = 4.0 * bend->gradient->options.tolerance;
    bool begun =
        rmap_curve_begin(&bend->curve, bend->gradient, channel, ray->origin, ray->direction) ||
        rmap_curve_begin(&bend->curve, bend->gradient, channel,
                         rmap_axpy(inside, ray->direction, ray->origin), ray->direction);
    bend->curve.rough = is_rough(walk) && !(bend->free_path < HUGE_VAL);
    return begun;
}

/* Beyond the scene's bounding sphere. */
static bool is_outside(const struct bend *bend, struct rmap_vec3 p)
{
    const struct rmap_scene *scene = bend->walk->scene;
    struct rmap_vec3 from = rmap_sub(p, scene->centre);
    return rmap_dot(from, from) > scene->radius * scene->radius;
}

/* theta at which the step goes out through the scene's bounding sphere; 2: it ends inside. */
static double find_way_out(const struct bend *bend, const struct rmap_curve_step *step)
{
    double inside = 0.0, outside = 1.0;
    if (!is_outside(bend, step->to.r))
        return 2.0;
    if (is_outside(bend, step->from.r))
        return 0.0;
    for (int i = 0; i < 52; i++) {
        struct rmap_vec3 r, T;
        double middle = 0.5 * (inside + outside);
        rmap_curve_at(step, middle, &r, &T);
        if (is_outside(bend, r))
            outside = middle;
        else
            inside = middle;
    }
    return outside;
}

/* theta at which the step has this length, which is less than its own. */
static double find_length(const struct rmap_curve_step *step, double length)
{
    double low = 0.0, high = 1.0, theta = length / step->length;
    for (int i = 0; i < 60; i++) {
        struct rmap_vec3 r, T;
        double optical, here;
        rmap_curve_lengths(step, theta, &optical, &here);
        rmap_curve_at(step, theta, &r, &T);
        if (here < length)
            low = theta;
        else
            high = theta;
        double next = theta + (length - here) / (step->h * rmap_length(T));
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (fabs(next - theta) <= DBL_EPSILON)
            break;
        theta = next;
    }
    return theta;
}

/* What ends the segment on the run's last step if no surface does: shortens *time and sets *end. */
static bool find_end(const struct bend *bend, double *time, enum rmap_segment_end *end)
{
    const struct rmap_curve_run *run = &bend->search.run;
    const struct rmap_curve_step *step = &run->step[run->n - 1];
    double theta = 2.0, before = bend->length + run->length - step->length;
    if (before + step->length >= bend->free_path) {
        theta = find_length(step, bend->free_path - before);
        *end = RMAP_SEGMENT_SCATTERED; /* or absorbed */
    }
    double out = find_way_out(bend, step);
    if (out < theta) {
        theta = out;
        *end = RMAP_SEGMENT_LEFT;
    }
    if (theta < 1.0)
        *time = run->time[run->n - 1] + theta * step->h;
    return theta <= 1.0;
}

/* What the curve still has to go until a surface straight ahead of the run, with a margin; it may
 * turn away from one that is near. */
static double way_to_surface(const struct bend *bend)
{
    const double detour = 1.15, least = 0.05;
    double way = detour * bend->search.ahead - bend->search.run.length;
    return rmap_max(way, least * bend->gradient->size);
}

/* The steps of a run. True when something other than a surface ends the segment with it, at *time.
 */
static bool fill_run(struct bend *bend, double *time, enum rmap_segment_end *end)
{
    struct rmap_curve_run *run = &bend->search.run;
    bool due = false;
    for (*time = 0.0; !due; *time = run->time[run->n]) {
        double rest = bend->free_path - bend->length - run->length;
        double way = rmap_min(1.1 * rest, way_to_surface(bend));
        if (bend->curve.n_step == bend->gradient->options.max_steps) {
            *end = RMAP_SEGMENT_LIMIT;
            return true;
        }
        if (!rmap_curve_advance(&bend->curve, way, &run->step[run->n])) {
            *end = RMAP_SEGMENT_ERROR;
            return true;
        }
        due = rmap_curve_search_add(&bend->search);
        *time = run->time[run->n];
        if (find_end(bend, time, end))
            return true;
    }
    return false;
}

/* The step as far as the segment goes; `to`: its end, on the surface if it met one. */
static void travel(struct bend *bend, const struct rmap_curve_step *step, struct rmap_vec3 from,
                   struct rmap_vec3 to)
{
    struct rmap_walk *walk = bend->walk;
    uint32_t segment = bend->arrival->segment.segment;
    if (walk->recorder) {
        const struct rmap_segment_piece piece = {.step = step,
                                                 .from = from,
                                                 .to = to,
                                                 .optical_from = walk->optical_path + bend->optical,
                                                 .tolerance = bend->gradient->options.tolerance,
                                                 .segment = segment,
                                                 .clock = walk->scene->timed ? &bend->clock : NULL,
                                                 .gradient = bend->gradient,
                                                 .channel = bend->curve.channel};
        rmap_curve_points_add(&bend->points, step, segment, bend->length, piece.optical_from);
        rmap_detect_curve(walk->scene, &piece, walk->recorder);
    }
    bend->length += step->length;
    bend->optical += step->optical;
    if (walk->scene->timed)
        bend->clock.group_path += rmap_curve_group(bend->gradient, bend->curve.channel, step, 1.0);
    bend->arrival->segment.to = to;
}

/* The run up to a time; `surface`: it ends on the surface of the arrival's hit. */
static void travel_run(struct bend *bend, double time, bool surface)
{
    struct rmap_curve_run *run = &bend->search.run;
    double theta;
    if (run->n == 0)
        return;
    int last = rmap_curve_run_find(run, time, &theta);
    for (int i = 0; i <= last; i++) {
        struct rmap_curve_step *step = &run->step[i];
        struct rmap_vec3 from = bend->arrival->segment.to;
        if (i == last && time != run->time[i + 1]) /* behind it: a mesh within its tolerance */
            (void)rmap_curve_cut(&bend->curve, step, theta);
        travel(bend, step, from, i == last && surface ? bend->arrival->hit.position : step->to.r);
    }
    bend->arrival->segment.direction = rmap_normalize(run->step[last].to.T);
}

static enum rmap_segment_end follow(struct bend *bend)
{
    struct rmap_hit *hit = &bend->arrival->hit;
    for (;;) {
        enum rmap_segment_end end = RMAP_SEGMENT_ERROR;
        double time;
        if (rmap_curve_search_start(&bend->search, &bend->curve.state, hit))
            return RMAP_SEGMENT_SURFACE;
        bool ends = fill_run(bend, &time, &end);
        bool met = rmap_curve_search_run(&bend->search, &time, hit);
        travel_run(bend, time, met);
        if (met)
            return RMAP_SEGMENT_SURFACE;
        if (ends)
            return end;
    }
}

static void begin(struct bend *bend, struct rmap_walk *walk, struct rmap_arrival *arrival)
{
    const struct rmap_gradient *gradient = &walk->scene->gradient[walk->ray.gradient - 1];
    bend->walk = walk;
    bend->arrival = arrival;
    bend->gradient = gradient;
    bend->length = bend->optical = 0.0;
    bend->clock = walk->clock;
    bend->free_path = HUGE_VAL;
    arrival->events = RMAP_EVENT_GRADIENT;
    walk->predicted = false;
    struct rmap_segment *segment = &arrival->segment;
    segment->from = segment->to = walk->ray.origin;
    segment->direction = arrival->first_direction = walk->ray.direction;
    segment->optical_from = walk->optical_path;
    segment->length = segment->index = 0.0;
    segment->clock = walk->scene->timed ? &walk->clock : NULL;
    segment->segment = walk->draw.step++;
    rmap_curve_search_begin(&bend->search, walk->accel, &gradient->options, is_rough(walk),
                            &walk->ray, walk->start_normal);
    rmap_curve_points_begin(&bend->points, walk->recorder, gradient->options.polyline);
}

void rmap_walk_curve(struct rmap_walk *walk, struct rmap_arrival *arrival)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    struct rmap_segment *segment = &arrival->segment;
    struct rmap_free_path path;
    struct bend bend;
    begin(&bend, walk, arrival);
    if (medium->dispersive && !rmap_colour_single(&walk->colour))
        choose_wavelength(walk);
    if (rmap_medium_participates(medium)) {
        rmap_free_path_draw(medium, &walk->draw, &walk->colour, &path);
        bend.free_path = path.length;
    }
    arrival->end = begin_curve(&bend, walk->colour.begin) ? follow(&bend) : RMAP_SEGMENT_ERROR;
    segment->length = bend.length;
    walk->ray.direction = segment->direction;
    if (arrival->end == RMAP_SEGMENT_SURFACE && arrival->hit.t > 0.0)
        arrival->hit.t = rmap_max(bend.length, DBL_MIN); /* of the segment, not of its last chord */
    if (rmap_medium_participates(medium)) {
        bool ended = arrival->end == RMAP_SEGMENT_SCATTERED;
        uint32_t event = rmap_walk_inside(walk, medium, &path, bend.length, ended, arrival);
        if (ended)
            arrival->end = rmap_segment_end_of(event);
    }
    if (arrival->end == RMAP_SEGMENT_LEFT)
        return;
    walk->path_length += bend.length;
    walk->optical_path += bend.optical;
    walk->clock = bend.clock;
    segment->optical_from = walk->optical_path;
}
