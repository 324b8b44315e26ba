/* SPDX-License-Identifier: MIT
 *
 * A lamp as its maker measured it.
 */
#include "scene/lamp.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/search.h"
#include "formula/azimuth.h"
#include "formula/emit.h"

/* ---- intensity ---- */

static const double step_deg = 0.5;

static size_t steps_of(const double *polar_deg, size_t i)
{
    const double steps = ceil((polar_deg[i] - polar_deg[i - 1]) / step_deg - 1e-9);
    return steps > 1.0 ? (size_t)steps : 1;
}

/* Integral over the turns up to each azimuth, and around. */
static void add_up_row(const struct rmap_lamp *lamp, size_t row)
{
    const size_t n = lamp->n_around;
    const double *value = lamp->intensity + row * n;
    double *below = lamp->below + row * (n + 1);
    below[0] = 0.0;
    for (size_t k = 0; k < n; k++) {
        const double end = k + 1 < n ? lamp->turn[k + 1] : lamp->turn[0] + 1.0;
        below[k + 1] = below[k] + 0.5 * (value[k] + value[(k + 1) % n]) * (end - lamp->turn[k]);
    }
}

/* A row of the grid, or one between it and the row before. */
static void add_row(const double *candela, size_t n_polar, size_t i, double part, double most,
                    double degrees, struct rmap_lamp *lamp)
{
    const size_t row = lamp->mean.n++, n = lamp->n_around;
    for (size_t k = 0; k < n; k++) {
        const double *value = candela + k * n_polar + i;
        lamp->intensity[row * n + k] =
            (part > 0.0 ? value[0] + part * (value[-1] - value[0]) : value[0]) / most;
    }
    add_up_row(lamp, row);
    lamp->mean.knot[row] =
        (struct rmap_profile_knot){.one_minus_cos = rmap_one_minus_cos(degrees / 360.0),
                                   .intensity = lamp->below[row * (n + 1) + n]};
}

enum rmap_status rmap_lamp_init(const double *around_deg, size_t n_around, const double *polar_deg,
                                size_t n_polar, const double *candela, struct rmap_lamp *lamp,
                                struct rmap_error *err)
{
    size_t n_knot = 1;
    double most = 0.0;
    for (size_t i = 0; i < n_around * n_polar; i++)
        most = candela[i] > most ? candela[i] : most;
    for (size_t i = 1; i < n_polar; i++)
        n_knot += steps_of(polar_deg, i);
    if (n_around < 1 || n_polar < 2 || !(most > 0.0))
        return rmap_error_set(err, RMAP_INPUT, "it has no light");
    lamp->n_around = n_around;
    lamp->turn = rmap_alloc(n_around, sizeof *lamp->turn);
    lamp->mean.knot = rmap_alloc(n_knot, sizeof *lamp->mean.knot);
    lamp->intensity = rmap_alloc(n_knot * n_around, sizeof *lamp->intensity);
    lamp->below = rmap_alloc(n_knot * (n_around + 1), sizeof *lamp->below);
    if (!lamp->turn || !lamp->mean.knot || !lamp->intensity || !lamp->below)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a lamp");
    for (size_t k = 0; k < n_around; k++)
        lamp->turn[k] = around_deg[k] / 360.0;
    add_row(candela, n_polar, 0, 0.0, most, polar_deg[0], lamp);
    for (size_t i = 1; i < n_polar; i++) {
        const size_t n_step = steps_of(polar_deg, i);
        for (size_t s = n_step; s-- > 0;) {
            const double part = (double)s / (double)n_step;
            add_row(candela, n_polar, i, part, most,
                    polar_deg[i] - part * (polar_deg[i] - polar_deg[i - 1]), lamp);
        }
    }
    const double flux = rmap_profile_sum(&lamp->mean);
    if (!(flux > 0.0))
        return rmap_error_set(err, RMAP_INPUT, "it has no light");
    for (size_t i = 0; i < n_knot * n_around; i++)
        lamp->intensity[i] /= flux;
    for (size_t i = 0; i < n_knot * (n_around + 1); i++)
        lamp->below[i] /= flux;
    lamp->flux = flux * most;
    return RMAP_OK;
}

void rmap_lamp_enlarge(struct rmap_lamp *lamp, double times)
{
    for (int k = 0; k < 3; k++)
        lamp->size[k] *= times;
    for (int k = 0; k < 2; k++)
        lamp->side[k] *= times;
}

void rmap_lamp_fini(struct rmap_lamp *lamp)
{
    rmap_profile_fini(&lamp->mean);
    rmap_free(lamp->turn);
    rmap_free(lamp->intensity);
    rmap_free(lamp->below);
    *lamp = (struct rmap_lamp){.n_around = 0};
}

/* Between two rows. */
struct between {
    const double *value[2], *below[2];
    double part;
};

static struct between between_rows(const struct rmap_lamp *lamp, double w)
{
    const size_t row = rmap_profile_find(&lamp->mean, w), n = lamp->n_around;
    const struct rmap_profile_knot *knot = &lamp->mean.knot[row];
    const double part =
        (w - knot[0].one_minus_cos) / (knot[1].one_minus_cos - knot[0].one_minus_cos);
    return (struct between){
        {lamp->intensity + row * n, lamp->intensity + (row + 1) * n},
        {lamp->below + row * (n + 1), lamp->below + (row + 1) * (n + 1)},
        part < 0.0   ? 0.0
        : part < 1.0 ? part
                     : 1.0,
    };
}

static double mixed(const double *const of[2], double part, size_t k)
{
    return of[0][k] + part * (of[1][k] - of[0][k]);
}

/* The azimuth, in turns, below which the share u of this polar angle's light lies. */
static double draw_turn(const struct rmap_lamp *lamp, const struct between *rows, double u)
{
    const size_t n = lamp->n_around;
    const double level = u * mixed(rows->below, rows->part, n);
    size_t low = 0, high = n;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (mixed(rows->below, rows->part, middle) > level)
            high = middle;
        else
            low = middle;
    }
    const double width =
        (low + 1 < n ? lamp->turn[low + 1] : lamp->turn[0] + 1.0) - lamp->turn[low];
    const double from = mixed(rows->value, rows->part, low),
                 to = mixed(rows->value, rows->part, (low + 1) % n),
                 rest = level - mixed(rows->below, rows->part, low),
                 square = from * from + 2.0 * (to - from) / width * rest,
                 divisor = from + sqrt(square > 0.0 ? square : 0.0),
                 t = divisor > 0.0 ? 2.0 * rest / divisor : 0.0,
                 turn = lamp->turn[low] + (t < width ? t : width);
    return turn < 1.0 ? turn : turn - 1.0;
}

static struct rmap_vec3 from_axes(const struct rmap_lamp *lamp, struct rmap_vec3 v)
{
    return rmap_axpy(v.x, lamp->axis[0],
                     rmap_axpy(v.y, lamp->axis[1], rmap_scale(lamp->axis[2], v.z)));
}

struct rmap_vec3 rmap_lamp_draw(const struct rmap_lamp *lamp, const double u[2])
{
    const double w = rmap_profile_draw(&lamp->mean, u[0]);
    const struct between rows = between_rows(lamp, w);
    return rmap_normalize(from_axes(lamp, rmap_about_z(w, draw_turn(lamp, &rows, u[1]))));
}

double rmap_lamp_intensity(const struct rmap_lamp *lamp, struct rmap_vec3 direction)
{
    const size_t n = lamp->n_around;
    const double x = rmap_dot(direction, lamp->axis[0]), y = rmap_dot(direction, lamp->axis[1]),
                 z = rmap_dot(direction, lamp->axis[2]),
                 /* keeps its digits near the axis */
        w = z > 0.0 ? (x * x + y * y) / (1.0 + z) : 1.0 - z;
    if (w < lamp->mean.knot[0].one_minus_cos || w > lamp->mean.knot[lamp->mean.n - 1].one_minus_cos)
        return 0.0;
    const struct between rows = between_rows(lamp, w);
    double turn = atan2(y, x) / (2.0 * RMAP_PI);
    turn = turn < lamp->turn[0] ? turn + 1.0 : turn;
    size_t k = rmap_first_above(lamp->turn, n, turn);
    k = k > 0 && lamp->turn[k] > turn ? k - 1 : n - 1;
    const double end = k + 1 < n ? lamp->turn[k + 1] : lamp->turn[0] + 1.0,
                 part = (turn - lamp->turn[k]) / (end - lamp->turn[k]),
                 from = mixed(rows.value, rows.part, k),
                 to = mixed(rows.value, rows.part, (k + 1) % n);
    return from + (part < 1.0 ? part : 1.0) * (to - from);
}

/* ---- body ---- */

static const struct rmap_vec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* So that a cylinder's axis becomes z; and back with 4 - along, 2 being no turn. */
static struct rmap_vec3 turned(struct rmap_vec3 v, int along)
{
    const double at[3] = {v.x, v.y, v.z};
    return rmap_vec3(at[(along + 1) % 3], at[(along + 2) % 3], at[along % 3]);
}

/* Its size with its axis along z. */
static void upright(const struct rmap_lamp *lamp, double size[3])
{
    for (int k = 0; k < 3; k++)
        size[k] = lamp->size[(lamp->along + 1 + k) % 3];
}

/* Of a cylinder's side, that of a box as wide as it looks from there. */
static double seen_side(const double size[3], struct rmap_vec3 d)
{
    const double across = d.x * size[1], along = d.y * size[0];
    return size[2] * sqrt(across * across + along * along);
}

/* Areas of a box's faces, by the axis that they look along. */
static void areas_of(const struct rmap_lamp *lamp, double area[3])
{
    const double *s = lamp->size;
    area[0] = s[1] * lamp->side[0];
    area[1] = s[0] * lamp->side[1];
    area[2] = s[0] * s[1];
}

double rmap_lamp_seen_area(const struct rmap_lamp *lamp, struct rmap_vec3 d)
{
    const double *s = lamp->size;
    double area[3], size[3];
    struct rmap_vec3 way;
    switch (lamp->body) {
    case RMAP_LAMP_POINT:
        break;
    case RMAP_LAMP_BOX:
        areas_of(lamp, area);
        return area[0] * fabs(d.x) + area[1] * fabs(d.y) + area[2] * fabs(d.z);
    case RMAP_LAMP_CYLINDER:
        upright(lamp, size);
        way = turned(d, lamp->along);
        return seen_side(size, way) + 0.25 * RMAP_PI * size[0] * size[1] * fabs(way.z);
    case RMAP_LAMP_ELLIPSOID:
        way = rmap_vec3(s[1] * s[2] * d.x, s[0] * s[2] * d.y, s[0] * s[1] * d.z);
        return 0.25 * RMAP_PI * sqrt(rmap_dot(way, way));
    }
    return 0.0;
}

/* A face of the box, the one that looks to `side` along an axis. */
static struct rmap_vec3 on_face(const struct rmap_lamp *lamp, int axis, double side, double u,
                                double v)
{
    const double *size = lamp->size;
    double at[3];
    at[axis] = 0.5 * side * size[axis];
    at[(axis + 1) % 3] = (u - 0.5) * size[(axis + 1) % 3];
    at[(axis + 2) % 3] = (v - 0.5) * size[(axis + 2) % 3];
    if (axis < 2)
        at[2] = 0.5 * size[2] - (axis == 0 ? v : u) * lamp->side[axis];
    return rmap_vec3(at[0], at[1], at[2]);
}

static double side_of(double x)
{
    return x < 0.0 ? -1.0 : 1.0;
}

static struct rmap_vec3 anywhere_in(const double size[3], const double u[3])
{
    return rmap_vec3((u[0] - 0.5) * size[0], (u[1] - 0.5) * size[1], (u[2] - 0.5) * size[2]);
}

static struct rmap_vec3 point_of_box(const struct rmap_lamp *lamp, struct rmap_vec3 d,
                                     const double u[3])
{
    const double along[3] = {d.x, d.y, d.z};
    double part[3];
    areas_of(lamp, part);
    for (int k = 0; k < 3; k++)
        part[k] *= fabs(along[k]);
    double level = u[2] * (part[0] + part[1] + part[2]);
    if (!(part[0] + part[1] + part[2] > 0.0)) /* a line, or a plane edge on */
        return anywhere_in(lamp->size, u);
    int axis = 0;
    while (axis < 2 && !(level < part[axis]))
        level -= part[axis++];
    return on_face(lamp, axis, side_of(along[axis]), u[0], u[1]);
}

static struct rmap_vec3 stretched(struct rmap_vec3 v, const double size[3])
{
    return rmap_vec3(0.5 * size[0] * v.x, 0.5 * size[1] * v.y, 0.5 * size[2] * v.z);
}

/* The direction as it is seen where the body is round, with a radius of 1. */
static struct rmap_vec3 shrunk(struct rmap_vec3 d, const double size[3])
{
    const struct rmap_vec3 v = {d.x * size[1] * size[2], d.y * size[0] * size[2],
                                d.z * size[0] * size[1]};
    return rmap_dot(v, v) > 0.0 ? rmap_normalize(v) : d;
}

static struct rmap_vec3 point_of_cylinder(const double size[3], struct rmap_vec3 d,
                                          const double u[3])
{
    const double caps = 0.25 * RMAP_PI * size[0] * size[1] * fabs(d.z), side = seen_side(size, d);
    if (!(u[2] * (caps + side) >= caps)) {
        const struct rmap_vec3 p = rmap_disc_point(1.0, u[0], u[1]);
        return stretched(rmap_vec3(p.x, p.y, side_of(d.z)), size);
    }
    const double x = d.x * size[1], y = d.y * size[0], length = sqrt(x * x + y * y),
                 t = 2.0 * u[0] - 1.0, depth = sqrt((1.0 - t) * (1.0 + t));
    const double cx = length > 0.0 ? x / length : 1.0, cy = length > 0.0 ? y / length : 0.0;
    return stretched(rmap_vec3(depth * cx - t * cy, depth * cy + t * cx, 2.0 * u[1] - 1.0), size);
}

static struct rmap_vec3 point_of_ellipsoid(const double size[3], struct rmap_vec3 d,
                                           const double u[3])
{
    struct rmap_vec3 x, y;
    const struct rmap_vec3 axis = shrunk(d, size), p = rmap_disc_point(1.0, u[0], u[1]);
    const double square = p.x * p.x + p.y * p.y;
    rmap_basis(axis, &x, &y);
    return stretched(
        rmap_axpy(p.x, x,
                  rmap_axpy(p.y, y, rmap_scale(axis, square < 1.0 ? sqrt(1.0 - square) : 0.0))),
        size);
}

struct rmap_vec3 rmap_lamp_point(const struct rmap_lamp *lamp, struct rmap_vec3 direction,
                                 const double u[3])
{
    double size[3];
    switch (lamp->body) {
    case RMAP_LAMP_POINT:
        break;
    case RMAP_LAMP_BOX:
        return point_of_box(lamp, direction, u);
    case RMAP_LAMP_CYLINDER:
        upright(lamp, size);
        return turned(point_of_cylinder(size, turned(direction, lamp->along), u), 4 - lamp->along);
    case RMAP_LAMP_ELLIPSOID:
        return point_of_ellipsoid(lamp->size, direction, u);
    }
    return rmap_vec3(0.0, 0.0, 0.0);
}

static struct rmap_vec3 surface_of_box(const struct rmap_lamp *lamp, const double u[3],
                                       struct rmap_vec3 *facing)
{
    double part[3];
    areas_of(lamp, part);
    const double sum = part[0] + part[1] + part[2], side = u[2] < 0.5 ? -1.0 : 1.0;
    double level = (u[2] < 0.5 ? 2.0 * u[2] : 2.0 * u[2] - 1.0) * sum;
    int axis = 0;
    while (axis < 2 && !(level < part[axis]))
        level -= part[axis++];
    *facing = rmap_scale(unit[axis], side * 2.0 * sum);
    return sum > 0.0 ? on_face(lamp, axis, side, u[0], u[1]) : anywhere_in(lamp->size, u);
}

/* Half of the draws go to the caps where there is a side. */
static struct rmap_vec3 surface_of_cylinder(const double size[3], const double u[3],
                                            struct rmap_vec3 *facing)
{
    const double share = size[2] > 0.0 ? 0.5 : 1.0, side = u[2] < 0.5 * share ? -1.0 : 1.0;
    double c, s;
    if (u[2] < share) {
        const struct rmap_vec3 p = rmap_disc_point(1.0, u[0], u[1]);
        *facing = rmap_scale(unit[2], side * 0.25 * RMAP_PI * size[0] * size[1] * 2.0 / share);
        return stretched(rmap_vec3(p.x, p.y, side), size);
    }
    rmap_azimuth(u[0], &c, &s);
    *facing = rmap_scale(rmap_vec3(size[1] * c, size[0] * s, 0.0), RMAP_PI * size[2] / share);
    return stretched(rmap_vec3(c, s, 2.0 * u[1] - 1.0), size);
}

struct rmap_vec3 rmap_lamp_surface(const struct rmap_lamp *lamp, const double u[3],
                                   struct rmap_vec3 *facing)
{
    struct rmap_vec3 p = rmap_vec3(0.0, 0.0, 0.0);
    const double *s = lamp->size;
    double size[3];
    *facing = p;
    switch (lamp->body) {
    case RMAP_LAMP_POINT:
        break;
    case RMAP_LAMP_BOX:
        return surface_of_box(lamp, u, facing);
    case RMAP_LAMP_CYLINDER:
        upright(lamp, size);
        p = surface_of_cylinder(size, u, facing);
        *facing = turned(*facing, 4 - lamp->along);
        return turned(p, 4 - lamp->along);
    case RMAP_LAMP_ELLIPSOID:
        p = rmap_about_z(2.0 * u[0], u[1]);
        *facing =
            rmap_scale(rmap_vec3(s[1] * s[2] * p.x, s[0] * s[2] * p.y, s[0] * s[1] * p.z), RMAP_PI);
        return stretched(p, s);
    }
    return p;
}

/* The pair of planes across one axis: the distances between which a way is between them. */
static void between_planes(double from, double along, double half, double *in, double *out)
{
    if (along == 0.0) {
        *out = fabs(from) <= half ? *out : -1.0;
        return;
    }
    const double first = (-half * side_of(along) - from) / along,
                 last = (half * side_of(along) - from) / along;
    *in = first > *in ? first : *in;
    *out = last < *out ? last : *out;
}

/* Only what looks along x and y begins at the top and may end before the bottom. */
static double enter_box(const struct rmap_lamp *lamp, struct rmap_vec3 from, struct rmap_vec3 way)
{
    const double start[3] = {from.x, from.y, from.z}, along[3] = {way.x, way.y, way.z};
    double in = -HUGE_VAL, out = HUGE_VAL;
    int face = 2;
    for (int k = 0; k < 3; k++) {
        const double before = in;
        between_planes(start[k], along[k], 0.5 * lamp->size[k], &in, &out);
        face = in > before ? k : face;
    }
    if (!(in <= out))
        return -1.0;
    const double below_top = 0.5 * lamp->size[2] - (from.z + in * way.z);
    return face == 2 || below_top <= lamp->side[face] ? in : -1.0;
}

/* Of what is round with a radius of 1: the quadric a t^2 + 2 b t + c = 0. */
static void between_roots(double a, double b, double c, double *in, double *out)
{
    const double root = b * b - a * c;
    if (!(root >= 0.0) || (a == 0.0 && c > 0.0)) {
        *out = *in - 1.0;
        return;
    }
    if (a == 0.0)
        return;
    const double first = (-b - sqrt(root)) / a, last = (-b + sqrt(root)) / a;
    *in = first > *in ? first : *in;
    *out = last < *out ? last : *out;
}

static double enter_round(const double size[3], bool is_cylinder, struct rmap_vec3 from,
                          struct rmap_vec3 way)
{
    const struct rmap_vec3 f = {2.0 * from.x / size[0], 2.0 * from.y / size[1],
                                is_cylinder ? 0.0 : 2.0 * from.z / size[2]},
                           w = {2.0 * way.x / size[0], 2.0 * way.y / size[1],
                                is_cylinder ? 0.0 : 2.0 * way.z / size[2]};
    double in = -HUGE_VAL, out = HUGE_VAL;
    if (is_cylinder)
        between_planes(from.z, way.z, 0.5 * size[2], &in, &out);
    between_roots(rmap_dot(w, w), rmap_dot(f, w), rmap_dot(f, f) - 1.0, &in, &out);
    return in <= out ? in : -1.0;
}

double rmap_lamp_entered(const struct rmap_lamp *lamp, struct rmap_vec3 from,
                         struct rmap_vec3 direction)
{
    double size[3];
    switch (lamp->body) {
    case RMAP_LAMP_POINT:
        break;
    case RMAP_LAMP_BOX:
        return enter_box(lamp, from, direction);
    case RMAP_LAMP_CYLINDER:
        upright(lamp, size);
        return enter_round(size, true, turned(from, lamp->along), turned(direction, lamp->along));
    case RMAP_LAMP_ELLIPSOID:
        return enter_round(lamp->size, false, from, direction);
    }
    return -1.0;
}
