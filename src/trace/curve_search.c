/* SPDX-License-Identifier: MIT */
#include "trace/curve_search.h"

#include <float.h>
#include <math.h>

/* The chord that decides leaves the curve by this share of the tolerance at most. */
#define DECIDES 0.1

/* A piece shorter than this share of its step is straight, whatever rounding makes of its sag. */
#define SHORTEST 1e-12

struct point {
    double theta;
    struct rmap_vec3 r, T;
};

/* The piece of the curve in hand. */
struct piece {
    struct point a, b;
    double sag;
};

static struct point point_at(const struct rmap_curve_step *step, double theta)
{
    struct point p = {.theta = theta};
    rmap_curve_at(step, theta, &p.r, &p.T);
    return p;
}

void rmap_curve_search_begin(struct rmap_curve_search *search, const struct rmap_accel *accel,
                             const struct rmap_curve_options *options, const struct rmap_ray *ray,
                             struct rmap_vec3 normal)
{
    search->accel = accel;
    search->options = options;
    search->ray = *ray;
    search->normal = normal;
}

static bool starts_on_surface(const struct rmap_curve_search *search)
{
    return search->ray.contact.n > 0;
}

static void leave_surface(struct rmap_curve_search *search)
{
    search->ray.contact = (struct rmap_contact){0};
}

/* Does a surface cross the line between two points? The contact counts where it starts the leg. */
static bool meets(struct rmap_curve_search *search, struct rmap_vec3 from, struct rmap_vec3 to,
                  struct rmap_hit *hit, double *share)
{
    struct rmap_vec3 way = rmap_sub(to, from);
    double length = rmap_length(way);
    if (!(length > 0.0))
        return false;
    search->ray.origin = from;
    search->ray.direction = rmap_scale(way, 1.0 / length);
    if (!rmap_accel_next_within(search->accel, &search->ray, length, hit))
        return false;
    *share = fmin(hit->t / length, 1.0);
    return true;
}

/* The same from a point inside the curve's way, in space. */
static bool meets_in_space(struct rmap_curve_search *search, struct rmap_vec3 from,
                           struct rmap_vec3 to)
{
    struct rmap_contact contact = search->ray.contact;
    struct rmap_hit hit;
    double share;
    leave_surface(search);
    bool met = meets(search, from, to, &hit, &share);
    search->ray.contact = contact;
    return met;
}

/* Where the tangents at both ends meet: middle of their nearest points. False where the piece is
 * no arc that turns one way. */
static bool corner_of(const struct piece *piece, struct rmap_vec3 *corner)
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

/* Is there nothing between the chord, which is clear, and the curve? */
static bool polygon_is_clear(struct rmap_curve_search *search, const struct rmap_curve_step *step,
                             const struct piece *piece)
{
    struct rmap_hit hit;
    struct rmap_vec3 corner[2];
    double share;
    int n = 1;
    if (!corner_of(piece, &corner[0])) { /* Bezier's polygon of a cubic */
        double third = step->h * (piece->b.theta - piece->a.theta) / 3.0;
        corner[0] = rmap_axpy(third, piece->a.T, piece->a.r);
        corner[1] = rmap_axpy(-third, piece->b.T, piece->b.r);
        n = 2;
    }
    return !meets(search, piece->a.r, corner[0], &hit, &share) &&
           !(n == 2 && meets_in_space(search, corner[0], corner[1])) &&
           !meets_in_space(search, corner[n - 1], piece->b.r);
}

/* Where the curve crosses the tangent plane of the surface that its chord met, near `theta`. */
static double cross_plane(const struct rmap_curve_step *step, const struct piece *piece,
                          const struct rmap_hit *hit, double theta)
{
    for (int i = 0; i < 3; i++) {
        struct point p = point_at(step, theta);
        double rate = step->h * rmap_dot(p.T, hit->normal);
        double next = theta - rmap_dot(rmap_sub(p.r, hit->position), hit->normal) / rate;
        if (!(next > piece->a.theta && next < piece->b.theta))
            break;
        theta = next;
    }
    return theta;
}

/* Half the length, in theta, of a piece about `theta` that should hold the crossing and, if it can
 * be, is short enough to decide. `wider`: after failures. */
static double half_window(const struct rmap_curve_search *search, const struct piece *piece,
                          const struct rmap_hit *hit, double wider)
{
    double width = piece->b.theta - piece->a.theta;
    double decides = 0.4 * width * sqrt(DECIDES * search->options->tolerance / piece->sag);
    struct rmap_vec3 chord = rmap_sub(piece->b.r, piece->a.r);
    double length = rmap_length(chord);
    double cosine = fabs(rmap_dot(chord, hit->normal)) / length;
    /* The surface may leave its plane by sag^2 / (2 R cosine^2); R: as long as the chord. */
    double astray = piece->sag * piece->sag / (length * length * cosine * cosine * cosine);
    return fmin(fmax(decides, astray * width * wider), 0.5 * width);
}

static bool same_side(const struct rmap_curve_search *search, const struct piece *piece)
{
    double chord = rmap_dot(rmap_sub(piece->b.r, piece->a.r), search->normal);
    double tangent = rmap_dot(piece->a.T, search->normal);
    return tangent == 0.0 || chord * tangent > 0.0;
}

/* The piece from a.theta to `end`, or a shorter one whose sag the medium allows; one that starts
 * the leg on a surface leaves it to the side to which the curve does. */
static void set_piece(struct rmap_curve_search *search, const struct rmap_curve_step *step,
                      struct piece *piece, double end)
{
    double shortest = piece->a.theta + SHORTEST;
    for (;;) {
        piece->b = point_at(step, end);
        piece->sag = rmap_curve_sag(step, piece->a.theta, end);
        double share = search->options->sag / piece->sag;
        double width = end - piece->a.theta;
        bool aside = starts_on_surface(search) && !same_side(search, piece);
        if (end <= shortest || (share >= 1.0 && !aside))
            break;
        end = piece->a.theta + width * fmin(0.5, 0.9 * sqrt(share));
    }
    if (starts_on_surface(search) && !same_side(search, piece))
        leave_surface(search); /* along it within rounding: its media tell where the light is */
}

enum verdict { CLEAR, MET, UNDECIDED };

/* Where pieces are to end: the one in hand, and the one after it once that is clear. */
struct aim {
    double next, after;
    double wider; /* of the window about the crossing, after failures */
};

static enum verdict judge(struct rmap_curve_search *search, const struct rmap_curve_step *step,
                          const struct piece *piece, struct aim *aim, struct rmap_hit *hit)
{
    double share = 0.0, from = piece->a.theta, width = piece->b.theta - from;
    bool decides = piece->sag <= DECIDES * search->options->tolerance || width <= SHORTEST;
    aim->next = from + 0.5 * width;
    if (!meets(search, piece->a.r, piece->b.r, hit, &share))
        return decides || polygon_is_clear(search, step, piece) ? CLEAR : UNDECIDED;
    if (hit->t == 0.0) {
        aim->next = from;
        return MET;
    }
    double theta = cross_plane(step, piece, hit, from + share * width);
    if (decides) {
        aim->next = theta;
        return MET;
    }
    double half = half_window(search, piece, hit, aim->wider);
    aim->wider *= 4.0;
    if (theta - half > from + 0.5 * half) {
        aim->next = fmin(theta - half, from + 0.9 * width);
        aim->after = theta + half;
    } else {
        aim->next = fmin(theta + half, from + 0.75 * width);
    }
    return UNDECIDED;
}

bool rmap_curve_search_step(struct rmap_curve_search *search, const struct rmap_curve_step *step,
                            double end, double *theta, struct rmap_hit *hit)
{
    struct piece piece = {.a = point_at(step, 0.0)};
    struct aim aim = {.next = end, .after = 0.0, .wider = 1.0};
    while (piece.a.theta < end) {
        set_piece(search, step, &piece, aim.next);
        double width = piece.b.theta - piece.a.theta;
        switch (judge(search, step, &piece, &aim, hit)) {
        case MET:
            *theta = aim.next;
            if (!starts_on_surface(search))
                hit->t = fmax(hit->t, DBL_MIN);
            return true;
        case UNDECIDED:
            break;
        case CLEAR:
            leave_surface(search);
            piece.a = piece.b;
            aim.next = aim.after > piece.a.theta ? aim.after : piece.a.theta + 2.0 * width;
            aim.next = fmin(aim.next, end);
            aim.after = 0.0;
            aim.wider = 1.0;
            break;
        }
    }
    return false;
}
