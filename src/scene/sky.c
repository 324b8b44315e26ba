/* SPDX-License-Identifier: MIT
 *
 * Light from infinitely far away, as a source.
 */
#include "scene/sky.h"

#include <string.h>

#include "base/alloc.h"
#include "base/search.h"
#include "formula/azimuth.h"
#include "formula/emit.h"
#include "scene/scene.h"

enum rmap_status rmap_sky_init(struct rmap_sky *sky, size_t n_row, size_t n_around, bool coloured,
                               struct rmap_error *err)
{
    const size_t n = n_row * n_around;
    sky->n_row = n_row;
    sky->n_around = n_around;
    sky->edge = rmap_alloc(n_row + 1, sizeof *sky->edge);
    sky->radiance = rmap_alloc(n, sizeof *sky->radiance);
    sky->below = rmap_alloc(n, sizeof *sky->below);
    sky->band = coloured ? rmap_alloc(3 * n, sizeof *sky->band) : NULL;
    if (!sky->edge || !sky->radiance || !sky->below || (coloured && !sky->band))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sky of %zu cells", n);
    return RMAP_OK;
}

void rmap_sky_fini(struct rmap_sky *sky)
{
    rmap_free(sky->edge);
    rmap_free(sky->radiance);
    rmap_free(sky->band);
    rmap_free(sky->below);
    rmap_free(sky->portal);
    *sky = (struct rmap_sky){.n_row = 0};
}

void rmap_sky_even_rows(struct rmap_sky *sky, size_t first, double from_deg, size_t last,
                        double to_deg)
{
    for (size_t r = first; r <= last; r++) {
        const double part = (double)(r - first) / (double)(last - first);
        sky->edge[r] = rmap_one_minus_cos((from_deg + part * (to_deg - from_deg)) / 360.0);
    }
}

/* ---- cells ---- */

/* Sine of a polar angle by 1 - cos of it. */
static double sine_of(double w)
{
    const double square = w * (2.0 - w);
    return square > 0.0 ? sqrt(square) : 0.0;
}

/* The integral of the direction over the cells of a row, at azimuth 0 and without its turn: across
 * the pole by two points of Gauss, along it. */
static void integrate_row(const struct rmap_sky *sky, size_t row, double *across, double *along)
{
    static const double point = 0.21132486540518711775;
    const double from = sky->edge[row], wide = sky->edge[row + 1] - from;
    *along = wide * (1.0 - from - 0.5 * wide);
    *across = 0.5 * wide * (sine_of(from + point * wide) + sine_of(from + (1.0 - point) * wide));
}

/* The integrals over azimuth of cos and sin for column k of n. */
static void integrate_column(size_t k, size_t n, double *x, double *y)
{
    double c[2], s[2];
    rmap_azimuth((double)k / (double)n, &c[0], &s[0]);
    rmap_azimuth((double)(k + 1) / (double)n, &c[1], &s[1]);
    *x = n > 1 ? s[1] - s[0] : 0.0;
    *y = n > 1 ? c[0] - c[1] : 0.0;
}

static double solid_angle(const struct rmap_sky *sky, size_t row)
{
    return 2.0 * RMAP_PI / (double)sky->n_around * (sky->edge[row + 1] - sky->edge[row]);
}

double rmap_sky_irradiance(const struct rmap_sky *sky)
{
    double sum = 0.0, across, along;
    for (size_t r = 0; r < sky->n_row; r++) {
        integrate_row(sky, r, &across, &along);
        double row = 0.0;
        for (size_t k = 0; k < sky->n_around && along > 0.0; k++)
            row += sky->radiance[r * sky->n_around + k];
        sum += row * along;
    }
    return sum * 2.0 * RMAP_PI / (double)sky->n_around;
}

static struct rmap_vec3 portal_area(const struct rmap_sky_portal *portal)
{
    return rmap_cross(portal->side[0], portal->side[1]);
}

/* Of the sphere, or of what is seen of the portals, for light of a direction in the world; of any
 * length, by which it is multiplied. */
static double seen_area(const struct rmap_sky *sky, struct rmap_vec3 direction)
{
    double sum = 0.0;
    for (size_t p = 0; p < sky->n_portal; p++)
        sum += fabs(rmap_dot(portal_area(&sky->portal[p]), direction));
    return sum;
}

double rmap_sky_gather(const struct rmap_source *source)
{
    struct rmap_sky *sky = source->sky;
    const size_t n = sky->n_around;
    const double disc = RMAP_PI * source->shape_size[0] * source->shape_size[0];
    double sum = 0.0, across, along, x, y;
    for (size_t r = 0; r < sky->n_row; r++) {
        const double steradian = solid_angle(sky, r);
        integrate_row(sky, r, &across, &along);
        for (size_t k = 0; k < n; k++) {
            double area = disc * steradian;
            if (sky->n_portal > 0 && sky->radiance[r * n + k] > 0.0) {
                integrate_column(k, n, &x, &y);
                area = seen_area(sky,
                                 rmap_affine_vector(&source->frame,
                                                    rmap_vec3(across * x, across * y,
                                                              along * 2.0 * RMAP_PI / (double)n)));
            }
            sum += sky->radiance[r * n + k] * area;
            sky->below[r * n + k] = sum;
        }
    }
    for (size_t i = 0; i < sky->n_row * n && sum > 0.0; i++)
        sky->below[i] /= sum;
    return sum;
}

static struct rmap_vec3 in_cell(const struct rmap_source *source, size_t cell, double u, double v)
{
    const struct rmap_sky *sky = source->sky;
    const size_t row = cell / sky->n_around, k = cell % sky->n_around;
    const double w = sky->edge[row] + u * (sky->edge[row + 1] - sky->edge[row]);
    return rmap_normalize(rmap_affine_vector(
        &source->frame, rmap_about_z(w, ((double)k + v) / (double)sky->n_around)));
}

/* ---- rays ---- */

static struct rmap_vec3 on_portal(const struct rmap_sky_portal *portal, double u, double v)
{
    return rmap_axpy(u - 0.5, portal->side[0], rmap_axpy(v - 0.5, portal->side[1], portal->centre));
}

/* The way from a point back to the sphere, or on to it. */
static double way_out(const struct rmap_source *source, struct rmap_vec3 point,
                      struct rmap_vec3 direction)
{
    const double radius = source->shape_size[0];
    const struct rmap_vec3 from = rmap_sub(point, source->frame.t);
    const double along = rmap_dot(from, direction),
                 square = along * along + radius * radius - rmap_dot(from, from);
    return (square > 0.0 ? sqrt(square) : 0.0) - along;
}

/* A line through a portal: how far along the direction, which may be behind. */
static bool meets_portal(const struct rmap_sky_portal *portal, struct rmap_vec3 point,
                         struct rmap_vec3 direction, double *along)
{
    const struct rmap_vec3 area = portal_area(portal);
    const double slope = rmap_dot(area, direction);
    if (slope == 0.0)
        return false;
    *along = rmap_dot(area, rmap_sub(portal->centre, point)) / slope;
    const struct rmap_vec3 at = rmap_sub(rmap_axpy(*along, direction, point), portal->centre);
    const double square = rmap_dot(area, area),
                 u = rmap_dot(rmap_cross(at, portal->side[1]), area) / square,
                 v = rmap_dot(rmap_cross(portal->side[0], at), area) / square;
    return fabs(u) < 0.5 && fabs(v) < 0.5;
}

/* Does light come through another portal before it comes through this one? Of portals in one place
 * the first has it. */
static bool comes_by_another(const struct rmap_source *source, size_t index, struct rmap_vec3 point,
                             struct rmap_vec3 direction)
{
    const struct rmap_sky *sky = source->sky;
    const double touch = 1e-9 * source->shape_size[0];
    bool other = false;
    for (size_t p = 0; p < sky->n_portal && !other; p++) {
        double along;
        other = p != index && meets_portal(&sky->portal[p], point, direction, &along) &&
                !(along > touch || (along >= -touch && p > index));
    }
    return other;
}

/* The portal that a share u of the light of this direction leads to. */
static size_t pick_portal(const struct rmap_sky *sky, struct rmap_vec3 direction, double u)
{
    double level = u * seen_area(sky, direction);
    size_t p = 0;
    for (; p + 1 < sky->n_portal; p++) {
        const double area = fabs(rmap_dot(portal_area(&sky->portal[p]), direction));
        if (level < area)
            break;
        level -= area;
    }
    return p;
}

/* Bands are float: a number near 1 may lie beyond them all, and belongs to the last that has light.
 */
static int pick_channel(const struct rmap_sky *sky, size_t cell, double u)
{
    static const double below_1 = 1.0 - 0x1p-53;
    const float *band = sky->band + 3 * cell;
    int b = 0, c = 0;
    for (; b < 2 && u >= (double)band[b]; b++)
        u -= (double)band[b];
    u = u < (double)band[b] ? u / (double)band[b] : below_1;
    while (b > 0 && !(band[b] > 0.0F))
        b--;
    while (c + 1 < RMAP_CHANNEL_MAX && !(sky->mix[b][c] > u))
        c++;
    return c;
}

struct rmap_vec3 rmap_sky_draw(const struct rmap_source *source, const double place[4],
                               const double way[4], struct rmap_vec3 *position, int *channel)
{
    const struct rmap_sky *sky = source->sky;
    const double radius = source->shape_size[0];
    const size_t cell = rmap_first_above(sky->below, sky->n_row * sky->n_around, way[0]);
    const struct rmap_vec3 direction = rmap_scale(in_cell(source, cell, way[1], way[2]), -1.0);
    *channel = sky->band ? pick_channel(sky, cell, way[3]) : -1;
    if (sky->n_portal == 0) {
        struct rmap_vec3 x, y;
        const struct rmap_vec3 p = rmap_disc_point(radius, place[0], place[1]);
        rmap_basis(direction, &x, &y);
        *position =
            rmap_axpy(p.x, x, rmap_axpy(p.y, y, rmap_axpy(-radius, direction, source->frame.t)));
        return direction;
    }
    const size_t p = pick_portal(sky, direction, place[2]);
    const struct rmap_vec3 point = on_portal(&sky->portal[p], place[0], place[1]),
                           back = rmap_scale(direction, -1.0);
    *position = comes_by_another(source, p, point, direction)
                    ? rmap_axpy(way_out(source, point, direction), direction, point)
                    : rmap_axpy(way_out(source, point, back), back, point);
    return direction;
}

/* ---- seen from the scene ---- */

/* The cell in a direction; the number of cells: none. */
static size_t find_cell(const struct rmap_source *source, struct rmap_vec3 towards)
{
    const struct rmap_sky *sky = source->sky;
    const struct rmap_vec3 local = rmap_affine_transposed(&source->frame, towards);
    const double w =
        local.z > 0.0 ? (local.x * local.x + local.y * local.y) / (1.0 + local.z) : 1.0 - local.z;
    if (!(w < sky->edge[sky->n_row]))
        return sky->n_row * sky->n_around;
    const size_t row = rmap_first_above(sky->edge + 1, sky->n_row, w);
    const double turn = atan2(local.y, local.x) / (2.0 * RMAP_PI);
    const size_t k = (size_t)((turn < 0.0 ? turn + 1.0 : turn) * (double)sky->n_around);
    return row * sky->n_around + (k < sky->n_around ? k : sky->n_around - 1);
}

static double cell_colour(const struct rmap_source *source, size_t cell, int n_channel,
                          double *colour)
{
    const struct rmap_sky *sky = source->sky;
    if (!sky->band)
        memcpy(colour, source->colour, (size_t)n_channel * sizeof *colour);
    for (int c = 0; c < n_channel && sky->band; c++) {
        colour[c] = 0.0;
        for (int b = 0; b < 3; b++)
            colour[c] += (double)sky->band[3 * cell + (size_t)b] *
                         (sky->mix[b][c] - (c > 0 ? sky->mix[b][c - 1] : 0.0));
    }
    return sky->radiance[cell];
}

double rmap_sky_seen(const struct rmap_source *source, struct rmap_vec3 towards, int n_channel,
                     double *colour)
{
    const size_t cell = find_cell(source, towards);
    return cell < source->sky->n_row * source->sky->n_around
               ? cell_colour(source, cell, n_channel, colour)
               : 0.0;
}

/* Points of portals, by their areas. */
static void look_through(const struct rmap_source *source, struct rmap_vec3 from, const double u[4],
                         int n_channel, double *colour, struct rmap_sky_look *look)
{
    const struct rmap_sky *sky = source->sky;
    double sum = 0.0;
    size_t p = 0;
    for (size_t i = 0; i < sky->n_portal; i++)
        sum += rmap_length(portal_area(&sky->portal[i]));
    double level = u[2] * sum;
    for (; p + 1 < sky->n_portal; p++) {
        const double own = rmap_length(portal_area(&sky->portal[p]));
        if (level < own)
            break;
        level -= own;
    }
    const struct rmap_vec3 area = portal_area(&sky->portal[p]),
                           point = on_portal(&sky->portal[p], u[0], u[1]),
                           away = rmap_sub(point, from);
    const double distance = rmap_length(away);
    if (!(distance > 0.0))
        return;
    look->towards = rmap_scale(away, 1.0 / distance);
    if (comes_by_another(source, p, point, rmap_scale(look->towards, -1.0)))
        return;
    const double part = fabs(rmap_dot(area, look->towards)) / rmap_length(area);
    look->distance = way_out(source, from, look->towards);
    look->irradiance = rmap_sky_seen(source, look->towards, n_channel, colour) * part * sum /
                       (distance * distance);
}

static bool comes_by_portal(const struct rmap_source *source, struct rmap_vec3 from,
                            struct rmap_vec3 towards)
{
    double along;
    for (size_t p = 0; p < source->sky->n_portal; p++)
        if (meets_portal(&source->sky->portal[p], from, towards, &along) && along > 0.0)
            return true;
    return false;
}

void rmap_sky_look(const struct rmap_source *source, struct rmap_vec3 from, const double u[4],
                   int n_channel, double *colour, struct rmap_sky_look *look)
{
    const struct rmap_sky *sky = source->sky;
    *look = (struct rmap_sky_look){.irradiance = 0.0};
    const bool is_small = source->type == RMAP_SOURCE_SUN; /* few points of a portal look at it */
    if (sky->n_portal > 0 && !is_small) {
        look_through(source, from, u, n_channel, colour, look);
        return;
    }
    /* Without portals `below` goes by radiance and solid angle: discs are as large from all sides.
     */
    const size_t cell = rmap_first_above(sky->below, sky->n_row * sky->n_around, u[0]);
    const double share = sky->below[cell] - (cell > 0 ? sky->below[cell - 1] : 0.0);
    if (!(share > 0.0))
        return;
    look->towards = in_cell(source, cell, u[2], u[1]);
    if (sky->n_portal > 0 && !comes_by_portal(source, from, look->towards))
        return;
    look->distance =
        source->shape_size[0] - rmap_dot(rmap_sub(from, source->frame.t), look->towards);
    look->irradiance = cell_colour(source, cell, n_channel, colour) *
                       solid_angle(sky, cell / sky->n_around) / share;
}
