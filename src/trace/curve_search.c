/* SPDX-License-Identifier: MIT
 *
 * The first surface that a curve meets, one run of steps after the other.
 */
#include "trace/curve_search.h"

#include <float.h>
#include <math.h>

#include "base/wide.h"
#include "gradient/curve_step.h"

/* While its sag is less than this share of its length, a run is much like the line ahead, where the
 * next surface is known. */
#define STRAIGHT 0.1

/* A piece shorter than this share of its run is straight. */
#define SHORTEST 1e-12

/* Shares of the tolerance that the chord on which a segment ends may leave the curve by: steps are
 * mostly far better than the tolerance. Pictures do not show it. */
static const double chord_off = 1e-4, chord_off_in_pictures = 0.1;

struct point {
    double time;
    struct rmap_vec3 r, T;
};

/* The piece of the curve in hand. */
struct piece {
    struct point a, b;
    double sag; /* at most */
};

/* Of the run's pieces. */
struct measure {
    double sag;      /* at most, per square of a piece's time */
    double longest;  /* in time, by the sag that the medium allows */
    double shortest; /* in time: straight, whatever rounding makes of it */
};

static inline int step_at(const struct rmap_curve_run *run, double time)
{
    int i = 0;
    while (i < run->n - 1 && time > run->time[i + 1])
        i++;
    return i;
}

int rmap_curve_run_find(const struct rmap_curve_run *run, double time, double *theta)
{
    int i = step_at(run, time);
    *theta = (time - run->time[i]) / run->step[i].h;
    return i;
}

static double run_time(const struct rmap_curve_run *run)
{
    return run->time[run->n];
}

/* The ends of steps exactly as their neighbours have them. */
RMAP_COPIED void point_at(const struct rmap_curve_run *run, double time, struct point *p)
{
    int i = step_at(run, time);
    const struct rmap_curve_step *step = &run->step[i];
    p->time = time;
    if (time == run->time[i + 1]) {
        p->r = step->to.r;
        p->T = step->to.T;
        return;
    }
    double t = time - run->time[i];
    if (!step->rough)
        t = t / step->h * step->h; /* rounded as theta is */
    rmap_curve_dense(step, t, t / step->whole, &p->r, &p->T);
}

/* As point_at() has it: a coordinate of -0 becomes 0. */
RMAP_COPIED void begin_run(const struct rmap_curve_run *run, struct point *p)
{
    const struct rmap_curve_state *from = &run->step[0].from;
    const struct rmap_vec3 nothing = {0.0, 0.0, 0.0};
    p->time = 0.0;
    p->r = rmap_add(from->r, nothing);
    p->T = rmap_add(from->T, nothing);
}

void rmap_curve_search_begin(struct rmap_curve_search *search, const struct rmap_accel *accel,
                             const struct rmap_curve_options *options, bool rough,
                             const struct rmap_ray *ray, struct rmap_vec3 normal)
{
    search->accel = accel;
    search->options = options;
    search->rough = rough;
    search->decides = (rough ? chord_off_in_pictures : chord_off) * options->tolerance;
    search->ray.medium = ray->medium;
    search->ray.gradient = ray->gradient;
    search->ray.contact = ray->contact;
    search->normal = normal;
}

static bool starts_on_surface(const struct rmap_curve_search *search)
{
    return search->ray.contact.n > 0;
}

static void leave_surface(struct rmap_curve_search *search)
{
    rmap_contact_clear(&search->ray.contact);
}

bool rmap_curve_search_start(struct rmap_curve_search *search, const struct rmap_curve_state *state,
                             struct rmap_hit *hit)
{
    search->run.n = 0;
    search->run.time[0] = search->run.bend = search->run.pull = 0.0;
    search->run.length = 0.0;
    search->ray.origin = state->r;
    search->ray.direction = rmap_normalize(state->T);
    bool met = rmap_accel_next(search->accel, &search->ray, hit);
    search->ahead = met ? hit->t : HUGE_VAL;
    if (!met || hit->t > 0.0)
        return false;
    if (!starts_on_surface(search))
        hit->t = DBL_MIN; /* a point of its own, not the segment's start */
    return true;
}

bool rmap_curve_search_add(struct rmap_curve_search *search)
{
    struct rmap_curve_run *run = &search->run;
    const struct rmap_curve_step *step = &run->step[run->n++];
    run->time[run->n] = run->time[run->n - 1] + step->h;
    run->bend = rmap_max(run->bend, rmap_curve_bend(step));
    run->pull = rmap_max(run->pull, rmap_max(rmap_dot(step->from.D, step->from.D),
                                             rmap_dot(step->to.D, step->to.D)));
    run->length += step->length;
    double time = run_time(run), straight = rmap_max(search->options->sag, STRAIGHT * run->length);
    return run->n == RMAP_CURVE_RUN_MAX || run->length >= 0.9 * search->ahead ||
           0.125 * run->bend * time * time > straight;
}

/* Does a surface cross the line between two points? The contact counts where it starts the segment.
 * A mesh may be met a little behind `to`, within its tolerance: *share is then above 1. */
RMAP_COPIED bool meets(struct rmap_curve_search *search, struct rmap_vec3 from, struct rmap_vec3 to,
                       struct rmap_hit *hit, double *share)
{
    struct rmap_vec3 way = rmap_sub(to, from);
    double square = rmap_dot(way, way), length = sqrt(square);
    if (!(length > 0.0))
        return false;
    /* the quotient need not wait for the root; the last bit shows it */
    double inverse = search->rough ? length * (1.0 / square) : 1.0 / length;
    search->ray.origin = from;
    search->ray.direction = rmap_scale(way, inverse);
    if (!rmap_accel_next_within(search->accel, &search->ray, length, hit))
        return false;
    *share = hit->t / length;
    return true;
}

/* The same from a point inside the curve's way, in space. */
RMAP_COPIED bool meets_in_space(struct rmap_curve_search *search, struct rmap_vec3 from,
                                struct rmap_vec3 to)
{
    struct rmap_hit hit;
    double share;
    if (!starts_on_surface(search))
        return meets(search, from, to, &hit, &share);
    struct rmap_contact contact = search->ray.contact;
    leave_surface(search);
    bool met = meets(search, from, to, &hit, &share);
    search->ray.contact = contact;
    return met;
}

/* Where the tangents at both ends meet: middle of their nearest points. False where the piece is
 * no arc that turns one way. */
RMAP_COPIED bool corner_of(const struct piece *piece, struct rmap_vec3 *corner)
{
    struct rmap_vec3 w = rmap_sub(piece->b.r, piece->a.r), a = piece->a.T, b = piece->b.T;
    double aa = rmap_dot(a, a), bb = rmap_dot(b, b), ab = rmap_dot(a, b);
    double wa = rmap_dot(w, a), wb = rmap_dot(w, b), det = aa * bb - ab * ab;
    double u = (wa * bb - wb * ab) / det, v = (wb * aa - wa * ab) / det;
    if (!(u > 0.0 && v > 0.0 && u * u * aa + v * v * bb < 4.0 * rmap_dot(w, w)))
        return false;
    *corner = rmap_scale(rmap_add(rmap_axpy(u, a, piece->a.r), rmap_axpy(-v, b, piece->b.r)), 0.5);
    return true;
}

/* What lies straight ahead of the run's start is known. */
RMAP_COPIED bool tangent_is_clear(struct rmap_curve_search *search, const struct piece *piece,
                                  struct rmap_vec3 corner)
{
    struct rmap_hit hit;
    double share;
    if (piece->a.time == 0.0)
        return rmap_length(rmap_sub(corner, piece->a.r)) < search->ahead;
    return !meets(search, piece->a.r, corner, &hit, &share);
}

/* Is there nothing between the chord, which is clear, and the curve? */
RMAP_COPIED bool polygon_is_clear(struct rmap_curve_search *search, const struct piece *piece)
{
    struct rmap_vec3 corner[2];
    int n = 1;
    if (!corner_of(piece, &corner[0])) { /* Bezier's polygon of a cubic */
        double third = (piece->b.time - piece->a.time) / 3.0;
        corner[0] = rmap_axpy(third, piece->a.T, piece->a.r);
        corner[1] = rmap_axpy(-third, piece->b.T, piece->b.r);
        n = 2;
    }
    return tangent_is_clear(search, piece, corner[0]) &&
           !(n == 2 && meets_in_space(search, corner[0], corner[1])) &&
           !meets_in_space(search, corner[n - 1], piece->b.r);
}

/* When the curve crosses the tangent plane of the surface that its chord met, near `time`: by
 * Newton's steps, until the next one would be less than `enough` off the plane. Behind the piece
 * where the chord met it there. */
RMAP_COPIED double cross_plane(const struct rmap_curve_run *run, const struct piece *piece,
                               const struct rmap_hit *hit, double time, double enough)
{
    const double latest = rmap_max(piece->b.time, time + (time - piece->b.time));
    for (int i = 0; i < 3; i++) {
        struct point p;
        point_at(run, time, &p);
        double rate = rmap_dot(p.T, hit->normal);
        double step = rmap_dot(rmap_sub(p.r, hit->position), hit->normal) / rate;
        double next = time - step;
        if (!(next > piece->a.time && next < latest))
            break;
        time = next;
        double square = step * step; /* the next: half of D square, and D may be greater inside */
        if (square * square * run->pull < enough * enough)
            break;
    }
    return time;
}

/* The surface may leave the plane where the curve meets it by sag^2 / (2 R cosine^2), along the
 * curve; R: as long as the chord. This as a share of the chord; *off: how far off the plane. */
RMAP_COPIED double astray(const struct piece *piece, const struct rmap_hit *hit, double *off)
{
    struct rmap_vec3 chord = rmap_sub(piece->b.r, piece->a.r);
    double square = rmap_dot(chord, chord), depth = fabs(rmap_dot(chord, hit->normal));
    double inverse = 1.0 / depth; /* 1 / (L cosine) */
    double share = piece->sag * piece->sag * inverse * inverse * inverse * sqrt(square);
    *off = share * depth;
    return share;
}

/* Half the time of a piece that should hold the crossing and, if it can be, is short enough to
 * decide. */
RMAP_COPIED double half_window(const struct rmap_curve_search *search, const struct piece *piece,
                               double share)
{
    double span = piece->b.time - piece->a.time;
    double decides = 0.45 * span * sqrt(search->decides / piece->sag);
    return rmap_min(rmap_max(decides, share * span), 0.5 * span);
}

RMAP_COPIED bool same_side(const struct rmap_curve_search *search, const struct piece *piece)
{
    double chord = rmap_dot(rmap_sub(piece->b.r, piece->a.r), search->normal);
    double tangent = rmap_dot(piece->a.T, search->normal);
    return tangent == 0.0 || chord * tangent > 0.0;
}

/* The piece up to `end`, or a shorter one whose sag the medium allows; one that starts the segment
 * on a surface leaves it to the side to which the curve does. */
RMAP_COPIED void set_piece(struct rmap_curve_search *search, const struct measure *of,
                           struct piece *piece, double end)
{
    const struct rmap_curve_run *run = &search->run;
    double span = rmap_min(end - piece->a.time, rmap_max(of->longest, of->shortest));
    double time = span < end - piece->a.time ? piece->a.time + span : end;
    for (;; time = piece->a.time + span) {
        point_at(run, time, &piece->b);
        if (!starts_on_surface(search) || same_side(search, piece))
            break;
        if (!(span > of->shortest)) {
            leave_surface(search); /* along it within rounding: its media tell where the light is */
            break;
        }
        span *= 0.25;
    }
    piece->sag = of->sag * span * span;
}

/* Is the time at a place on a chord that of the curve there, but for what its sag may be, too? */
RMAP_COPIED bool reads_time(const struct rmap_curve_search *search, double span)
{
    double most = 8.0 * search->decides, square = span * span;
    return search->run.pull * square * square <= most * most;
}

enum outcome { CLEAR, MET, UNDECIDED };

/* When pieces are to end: the one in hand, and the one after it once that is clear. */
struct aim {
    double next, after;
    double wider; /* of the window about the crossing, after failures */
};

RMAP_COPIED enum outcome evaluator(struct rmap_curve_search *search, const struct measure *of,
                                   const struct piece *piece, struct aim *aim, struct rmap_hit *hit)
{
    double share = 0.0, from = piece->a.time, span = piece->b.time - from;
    bool decides = piece->sag <= search->decides || span <= of->shortest;
    aim->next = from + 0.5 * span;
    if (!meets(search, piece->a.r, piece->b.r, hit, &share))
        return decides || polygon_is_clear(search, piece) ? CLEAR : UNDECIDED;
    if (hit->t == 0.0) {
        aim->next = from;
        return MET;
    }
    double time = from + share * span, enough = 0.01 * search->options->tolerance, off = 0.0;
    double share_astray = decides ? 0.0 : astray(piece, hit, &off);
    if (!(decides && search->rough && reads_time(search, span)))
        time = cross_plane(&search->run, piece, hit, time, rmap_max(enough, 0.05 * off));
    if (decides) {
        aim->next = time;
        return MET;
    }
    double half = half_window(search, piece, share_astray * aim->wider);
    aim->wider *= 4.0;
    if (time - half > from + 0.5 * half) {
        aim->next = rmap_min(time - half, from + 0.9 * span);
        aim->after = time + half;
    } else {
        aim->next = rmap_min(time + half, from + 0.75 * span);
    }
    return UNDECIDED;
}

RMAP_COPIED struct measure measure_of(const struct rmap_curve_search *search)
{
    double bend = 0.125 * search->run.bend;
    return (struct measure){bend, sqrt(search->options->sag / bend), /* bend 0: infinite */
                            SHORTEST * run_time(&search->run)};
}

RMAP_WIDE
bool rmap_curve_search_run(struct rmap_curve_search *search, double *time, struct rmap_hit *hit)
{
    double end = *time;
    struct piece piece;
    struct aim aim = {.next = end, .after = 0.0, .wider = 1.0};
    const struct measure of = measure_of(search);
    begin_run(&search->run, &piece.a);
    while (piece.a.time < end) {
        set_piece(search, &of, &piece, aim.next);
        double span = piece.b.time - piece.a.time;
        switch (evaluator(search, &of, &piece, &aim, hit)) {
        case MET:
            *time = aim.next;
            if (!starts_on_surface(search))
                hit->t = rmap_max(hit->t, DBL_MIN);
            return true;
        case UNDECIDED:
            break;
        case CLEAR:
            leave_surface(search);
            piece.a = piece.b;
            aim.next = aim.after > piece.a.time ? aim.after : piece.a.time + 2.0 * span;
            aim.next = rmap_min(aim.next, end);
            aim.after = 0.0;
            aim.wider = 1.0;
            break;
        }
    }
    return false;
}
