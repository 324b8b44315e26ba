/* SPDX-License-Identifier: MIT
 *
 * A measured BSDF: constant over patches of the hemisphere into which light goes.
 */
#include "scatter/table.h"

#include <math.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "base/search.h"
#include "formula/azimuth.h"

/* ---- patches ---- */

static size_t n_phi_of(const struct rmap_patches *patches, size_t ring)
{
    return patches->first[ring + 1] - patches->first[ring];
}

/* Projected solid angle; about the specular direction, solid angle. */
static double area_of(const struct rmap_scatter_table *table, size_t ring)
{
    const struct rmap_patches *patches = &table->out;
    return (table->about_specular ? 4.0 : 1.0) * RMAP_PI *
           (patches->sin2[ring + 1] - patches->sin2[ring]) / (double)n_phi_of(patches, ring);
}

/* Of (x, y) with the x axis, y >= 0. Draws and totals are portable; a BSDF need not be, and is
 * cheaper. */
static double angle_of(double x, double y, bool portable)
{
    return portable ? rmap_portable_angle(x, y) : atan2(y, x);
}

/* In turns, 0 to 1. */
static double azimuth_of(double x, double y, bool portable)
{
    double half = angle_of(x, y < 0.0 ? -y : y, portable) / (2.0 * RMAP_PI);
    return y < 0.0 && half > 0.0 ? 1.0 - half : half;
}

/* Its ring; n_ring beyond the last. */
static size_t ring_of(const struct rmap_patches *patches, double sin2)
{
    return sin2 < patches->sin2[patches->n_ring]
               ? rmap_first_above(patches->sin2 + 1, patches->n_ring, sin2)
               : patches->n_ring;
}

/* At an azimuth of (x, y); patches->n: beyond the last ring. */
static size_t patch_in(const struct rmap_patches *patches, double sin2, double x, double y,
                       bool portable)
{
    size_t ring = ring_of(patches, sin2);
    if (ring == patches->n_ring)
        return patches->n;
    size_t n = n_phi_of(patches, ring), k = (size_t)(azimuth_of(x, y, portable) * (double)n + 0.5);
    return patches->first[ring] + (k < n ? k : 0);
}

static size_t patch_of(const struct rmap_patches *patches, double x, double y, bool portable)
{
    return patch_in(patches, x * x + y * y, x, y, portable);
}

/* A point of a patch, 0 < u, v < 1. */
struct spot {
    double sin2, cosine, sine;
};
static struct spot spot_of(const struct rmap_patches *patches, size_t patch, double u, double v)
{
    const size_t ring = patches->ring[patch];
    struct spot spot;
    const double n = (double)n_phi_of(patches, ring),
                 turn = ((double)(patch - patches->first[ring]) - 0.5 + v) / n;
    spot.sin2 = patches->sin2[ring] + u * (patches->sin2[ring + 1] - patches->sin2[ring]);
    rmap_azimuth(turn < 0.0 ? turn + 1.0 : turn, &spot.cosine, &spot.sine);
    return spot;
}

/* ---- about the specular direction: light comes in the plane y = 0, towards x ---- */

/* The direction, towards the normal, and across. */
struct axes {
    struct rmap_vec3 along, up, across;
};

static struct axes axes_of(double sine, double side)
{
    const double z = sine < 1.0 ? sqrt(1.0 - sine * sine) : 0.0;
    struct axes axes = {.along = {sine, 0.0, side * z}, .up = {-z, 0.0, side * sine}};
    axes.across = rmap_cross(axes.along, axes.up);
    return axes;
}

static size_t patch_about(const struct rmap_patches *patches, const struct axes *axes,
                          struct rmap_vec3 out)
{
    return patch_in(patches, 0.5 * (1.0 - rmap_dot(out, axes->along)), rmap_dot(out, axes->up),
                    rmap_dot(out, axes->across), false);
}

static struct rmap_vec3 direction_about(const struct axes *axes, const struct spot *spot)
{
    const double half = spot->sin2 < 1.0 ? spot->sin2 : 1.0, away = 2.0 * sqrt(half * (1.0 - half));
    return rmap_axpy(
        1.0 - 2.0 * half, axes->along,
        rmap_axpy(away * spot->cosine, axes->up, rmap_scale(axes->across, away * spot->sine)));
}

/* ---- incidence ---- */

enum { WAYS_MAX = 4 };
struct incidence {
    size_t n, row[WAYS_MAX];
    double weight[WAYS_MAX];
    double cosine, sine; /* of the plane of incidence, which outgoing azimuths are about */
    double specular;     /* sine of the specular direction */
    double theta;
};

static void add(struct incidence *its, size_t row, double weight)
{
    if (!(weight > 0.0))
        return;
    its->row[its->n] = row;
    its->weight[its->n++] = weight;
}

static const struct rmap_scatter_table *table_of(const struct rmap_scattering *at)
{
    return at->scatter->table;
}

static struct incidence incidence_of(const struct rmap_scattering *at, bool portable)
{
    const struct rmap_scatter_table *table = table_of(at);
    struct incidence its = {.cosine = 1.0, .sine = 0.0};
    const double x = at->in.x, y = at->in.y, sine = sqrt(x * x + y * y);
    its.specular = table->about_specular && at->passes ? sine * at->n1 / at->n2 : sine;
    its.specular = its.specular < 1.0 ? its.specular : 1.0;
    if (table->by_patch) {
        const size_t row = patch_of(&table->out, x, y, portable);
        if (row < table->n_in)
            add(&its, row, 1.0);
        return its;
    }
    const double z = table->about_specular ? sqrt(1.0 - its.specular * its.specular)
                     : at->in.z < 0.0      ? -at->in.z
                                           : 0.0,
                 theta = angle_of(z, table->about_specular ? its.specular : sine, portable);
    its.theta = theta;
    size_t k = rmap_first_above(table->theta, table->n_theta, theta);
    k -= k > 0 && table->theta[k] > theta;
    double t = 0.0;
    if (k + 1 < table->n_theta && theta > table->theta[k])
        t = (theta - table->theta[k]) / (table->theta[k + 1] - table->theta[k]);
    const size_t next = t > 0.0 ? k + 1 : k;
    if (sine > 0.0 && (table->n_turn == 1 || table->about_specular)) {
        its.cosine = x / sine;
        its.sine = y / sine;
    }
    if (table->n_turn == 1) {
        add(&its, k, 1.0 - t);
        add(&its, next, t);
        return its;
    }
    const double from_first = (sine > 0.0 ? azimuth_of(x, y, portable) : 0.0) - table->first_turn,
                 turn = (from_first < 0.0 ? from_first + 1.0 : from_first) * (double)table->n_turn;
    size_t a = (size_t)turn;
    const double s = turn - (double)a;
    a = a < table->n_turn ? a : 0;
    const size_t b = (a + 1) % table->n_turn;
    add(&its, k * table->n_turn + a, (1.0 - t) * (1.0 - s));
    add(&its, k * table->n_turn + b, (1.0 - t) * s);
    add(&its, next * table->n_turn + a, t * (1.0 - s));
    add(&its, next * table->n_turn + b, t * s);
    return its;
}

static const struct rmap_scatter_block *block_of(const struct rmap_scattering *at)
{
    return &table_of(at)->block[at->front];
}

static size_t row_of(const struct rmap_scattering *at, size_t row)
{
    const struct rmap_scatter_table *table = table_of(at);
    return (table->n_band > 1 ? (size_t)at->channel : 0) * table->n_in + row;
}

/* The range of incidence that row k of angles is used in. */
static void reach_of(const struct rmap_scatter_table *table, size_t k, double reach[2])
{
    reach[0] = k > 0 ? table->theta[k - 1] : 0.0;
    reach[1] = k + 1 < table->n_theta ? table->theta[k + 1] : 0.5 * RMAP_PI;
}

/* What row i sends above the horizon from this angle, by its table. */
static double fit_of(const struct rmap_scatter_table *table, const struct rmap_scatter_block *block,
                     size_t row, double theta)
{
    double reach[2];
    reach_of(table, row % table->n_in / table->n_turn, reach);
    double at = reach[1] > reach[0] ? (theta - reach[0]) / (reach[1] - reach[0]) : 0.0;
    at = (at < 0.0 ? 0.0 : at < 1.0 ? at : 1.0) * (RMAP_TABLE_FITS - 1);
    const size_t k = (size_t)at < RMAP_TABLE_FITS - 1 ? (size_t)at : RMAP_TABLE_FITS - 2;
    const double *fit = block->fit + row * RMAP_TABLE_FITS + k, t = at - (double)k;
    return fit[0] + t * (fit[1] - fit[0]);
}

double rmap_table_shape(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    const struct rmap_scatter_table *table = table_of(at);
    const struct rmap_scatter_block *block = block_of(at);
    const struct incidence its = incidence_of(at, false);
    const struct rmap_vec3 turned = {out.x * its.cosine + out.y * its.sine,
                                     out.y * its.cosine - out.x * its.sine, out.z};
    if (!block->value)
        return 0.0;
    size_t patch;
    if (table->about_specular) { /* each row's lobe is moved to the specular direction */
        const struct axes axes = axes_of(its.specular, at->passes ? -1.0 : 1.0);
        patch = patch_about(&table->out, &axes, turned);
    } else {
        patch = patch_of(&table->out, turned.x, turned.y, false);
    }
    double sum = 0.0;
    for (size_t i = 0; patch < table->out.n && i < its.n; i++)
        sum += its.weight[i] * block->value[row_of(at, its.row[i]) * table->out.n + patch];
    return sum;
}

/* What row i of the incidence scatters, of light at this angle. */
static double part_of(const struct rmap_scattering *at, const struct incidence *its, size_t i)
{
    const struct rmap_scatter_table *table = table_of(at);
    const struct rmap_scatter_block *block = block_of(at);
    const size_t row = row_of(at, its->row[i]);
    return its->weight[i] *
           (table->about_specular ? fit_of(table, block, row, its->theta) : block->total[row]);
}

static double total_of(const struct rmap_scattering *at, const struct incidence *its)
{
    double sum = 0.0;
    for (size_t i = 0; block_of(at)->value && i < its->n; i++)
        sum += part_of(at, its, i);
    return sum;
}

double rmap_table_total(const struct rmap_scattering *at)
{
    const struct incidence its = incidence_of(at, true);
    return total_of(at, &its);
}

/* By solid angle, kept by the cosine. */
static struct rmap_vec3 draw_about(const struct rmap_scattering *at, const struct incidence *its,
                                   const double *below, const struct rmap_draw *draw)
{
    const struct rmap_patches *patches = &table_of(at)->out;
    const double side = at->passes ? -1.0 : 1.0, whole = below[patches->n - 1];
    const struct axes axes = axes_of(its->specular, side);
    double u[4];
    for (int k = 1; k < RMAP_TRIES_MAX; k++) {
        rmap_rng(draw->seed, draw->ray, draw->step, (enum rmap_rng_slot)(RMAP_RNG_LOBE + k), u);
        const struct spot spot =
            spot_of(patches, rmap_first_above(below, patches->n, u[0] * whole), u[1], u[2]);
        const struct rmap_vec3 out = direction_about(&axes, &spot);
        if (u[3] < side * out.z)
            return out;
    }
    return axes.along;
}

struct rmap_vec3 rmap_table_draw(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    const struct rmap_scatter_table *table = table_of(at);
    const struct rmap_scatter_block *block = block_of(at);
    const struct rmap_patches *patches = &table->out;
    const struct incidence its = incidence_of(at, true);
    const double side = at->passes ? -1.0 : 1.0;
    double u[4];
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_LOBE, u);
    double level = u[0] * total_of(at, &its);
    if (!block->value || its.n == 0)
        return rmap_vec3(at->in.x, at->in.y, -side * at->in.z);
    size_t i = 0;
    for (; i + 1 < its.n; i++) {
        const double part = part_of(at, &its, i);
        if (level < part)
            break;
        level -= part;
    }
    const double *below = block->below + row_of(at, its.row[i]) * patches->n;
    struct rmap_vec3 out;
    if (table->about_specular) {
        out = draw_about(at, &its, below, draw);
    } else {
        const size_t patch = rmap_first_above(below, patches->n, level / its.weight[i]);
        const struct spot spot = spot_of(patches, patch, u[1], u[2]);
        const double s = sqrt(spot.sin2);
        out = rmap_vec3(s * spot.cosine, s * spot.sine,
                        side * sqrt(spot.sin2 < 1.0 ? 1.0 - spot.sin2 : 0.0));
    }
    return rmap_vec3(out.x * its.cosine - out.y * its.sine, out.x * its.sine + out.y * its.cosine,
                     out.z);
}

double rmap_table_asymmetry(const struct rmap_scatter *scatter, int channel, bool passes,
                            bool front)
{
    enum { PAIRS = 20000 };
    struct rmap_scattering there = {.scatter = scatter,
                                    .channel = channel,
                                    .passes = passes,
                                    .front = front,
                                    .n1 = 1.0,
                                    .n2 = 1.0},
                           back = there;
    double difference = 0.0, sum = 0.0;
    back.front = passes ? !front : front;
    if (!block_of(&there)->value || !block_of(&back)->value)
        return (double)NAN;
    for (uint64_t i = 0; i < PAIRS; i++) {
        double u[4], c[2], s[2];
        rmap_rng(1, i, 0, RMAP_RNG_LOBE, u);
        rmap_azimuth(u[1], &c[0], &s[0]);
        rmap_azimuth(u[3], &c[1], &s[1]);
        const double r[2] = {sqrt(u[0]), sqrt(u[2])}, z[2] = {sqrt(1 - u[0]), sqrt(1 - u[2])};
        const struct rmap_vec3 a = {r[0] * c[0], r[0] * s[0], 0}, b = {r[1] * c[1], r[1] * s[1], 0};
        there.in = rmap_vec3(a.x, a.y, -z[0]);
        back.in = rmap_vec3(-b.x, -b.y, -z[1]);
        const double f = rmap_table_shape(&there, rmap_vec3(b.x, b.y, z[1])),
                     g = rmap_table_shape(&back, rmap_vec3(-a.x, -a.y, z[0]));
        difference += fabs(f - g);
        sum += 0.5 * (f + g);
    }
    return sum > 0.0 ? difference / sum : 0.0;
}

/* ---- made ---- */

void rmap_scatter_table_destroy(struct rmap_scatter_table *table)
{
    if (!table)
        return;
    for (int side = 0; side < 2; side++) {
        rmap_free(table->block[side].value);
        rmap_free(table->block[side].below);
        rmap_free(table->block[side].total);
        rmap_free(table->block[side].fit);
    }
    rmap_free(table->out.sin2);
    rmap_free(table->out.first);
    rmap_free(table->out.ring);
    rmap_free(table->theta);
    rmap_free(table);
}

static double sin2_of(double degrees)
{
    double cosine, sine;
    rmap_azimuth(degrees / 360.0, &cosine, &sine);
    return sine * sine;
}

enum rmap_status rmap_scatter_table_create(const struct rmap_scatter_table_shape *shape,
                                           struct rmap_scatter_table **table_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scatter_table *table = rmap_alloc(1, sizeof *table);
    if (!table)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
    table->out.n_ring = shape->n_ring;
    table->out.sin2 = rmap_alloc(shape->n_ring + 1, sizeof *table->out.sin2);
    table->out.first = rmap_alloc(shape->n_ring + 1, sizeof *table->out.first);
    table->theta = rmap_alloc(shape->n_theta + 1, sizeof *table->theta);
    if (!table->out.sin2 || !table->out.first || !table->theta) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
        goto out;
    }
    for (size_t i = 0; i <= shape->n_ring; i++)
        table->out.sin2[i] = sin2_of((shape->about_specular ? 0.5 : 1.0) * shape->ring_deg[i]);
    for (size_t i = 0; i < shape->n_ring; i++)
        table->out.first[i + 1] =
            table->out.first[i] + (shape->n_phi ? shape->n_phi[i] : shape->n_phi_each);
    table->out.n = table->out.first[shape->n_ring];
    table->out.ring = rmap_alloc(table->out.n, sizeof *table->out.ring);
    if (!table->out.ring) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
        goto out;
    }
    for (size_t i = 0; i < shape->n_ring; i++)
        for (size_t k = table->out.first[i]; k < table->out.first[i + 1]; k++)
            table->out.ring[k] = i;
    table->about_specular = shape->about_specular;
    table->by_patch = shape->n_theta == 0;
    table->n_theta = shape->n_theta;
    table->n_turn = shape->n_turn;
    table->first_turn = shape->first_turn;
    for (size_t i = 0; i < shape->n_theta; i++)
        table->theta[i] = shape->theta_deg[i] * (RMAP_PI / 180.0);
    table->n_in = table->by_patch ? table->out.n : shape->n_theta * shape->n_turn;
    table->n_band = shape->n_band;
    for (int side = 0; side < 2; side++) {
        struct rmap_scatter_block *block = &table->block[side];
        const size_t rows = table->n_band * table->n_in;
        if (!shape->side[side])
            continue;
        block->value = rmap_alloc(rows * table->out.n, sizeof *block->value);
        block->below = rmap_alloc(rows * table->out.n, sizeof *block->below);
        block->total = rmap_alloc(rows, sizeof *block->total);
        block->fit =
            rmap_alloc(shape->about_specular ? rows * RMAP_TABLE_FITS : 1, sizeof *block->fit);
        if (!block->value || !block->below || !block->total || !block->fit) {
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
            goto out;
        }
    }
    *table_ret = table;
    table = NULL;
out:
    rmap_scatter_table_destroy(table);
    return st;
}

/* Integral of a row's lobe, about a specular direction, times the cosine above the horizon: by
 * points of each patch. */
static double above_horizon(const struct rmap_scatter_table *table, const double *value,
                            double theta, double side)
{
    enum { PARTS = 4 };
    double cosine, sine, sum = 0.0;
    rmap_azimuth(theta / (2.0 * RMAP_PI), &cosine, &sine);
    const struct axes axes = axes_of(sine, side);
    for (size_t ring = 0; ring < table->out.n_ring; ring++)
        for (size_t k = table->out.first[ring]; k < table->out.first[ring + 1]; k++) {
            double mean = 0.0;
            for (int i = 0; value[k] > 0.0 && i < PARTS * PARTS; i++) {
                const struct spot spot =
                    spot_of(&table->out, k, (i % PARTS + 0.5) / PARTS, (i / PARTS + 0.5) / PARTS);
                const double up = side * direction_about(&axes, &spot).z;
                mean += up > 0.0 ? up : 0.0;
            }
            sum += value[k] * area_of(table, ring) * mean / (PARTS * PARTS);
        }
    return sum;
}

static void fit_row(const struct rmap_scatter_table *table, struct rmap_scatter_block *block,
                    size_t row, double side)
{
    const double *value = block->value + row * table->out.n;
    const size_t k = row % table->n_in / table->n_turn;
    double reach[2];
    reach_of(table, k, reach);
    for (int i = 0; i < RMAP_TABLE_FITS; i++)
        block->fit[row * RMAP_TABLE_FITS + (size_t)i] = above_horizon(
            table, value, reach[0] + (reach[1] - reach[0]) * i / (RMAP_TABLE_FITS - 1), side);
    block->total[row] = fit_of(table, block, row, table->theta[k]);
}

static void most_fit(const struct rmap_scatter_table *table, const struct rmap_scatter_block *block,
                     size_t row, double *most, double *theta_deg)
{
    double reach[2];
    reach_of(table, row % table->n_in / table->n_turn, reach);
    for (int i = 0; i < RMAP_TABLE_FITS; i++) {
        const double fit = block->fit[row * RMAP_TABLE_FITS + (size_t)i];
        if (!(fit > *most))
            continue;
        *most = fit;
        *theta_deg =
            (reach[0] + (reach[1] - reach[0]) * i / (RMAP_TABLE_FITS - 1)) * (180.0 / RMAP_PI);
    }
}

double rmap_scatter_table_finish(struct rmap_scatter_table *table, bool passes,
                                 double *theta_deg_ret)
{
    double most = 0.0;
    *theta_deg_ret = 0.0;
    for (int side = 0; side < 2; side++) {
        struct rmap_scatter_block *block = &table->block[side];
        for (size_t row = 0; block->value && row < table->n_band * table->n_in; row++) {
            double sum = 0.0;
            for (size_t ring = 0; ring < table->out.n_ring; ring++)
                for (size_t k = table->out.first[ring]; k < table->out.first[ring + 1]; k++) {
                    const size_t cell = row * table->out.n + k;
                    sum += block->value[cell] * area_of(table, ring);
                    block->below[cell] = sum;
                }
            block->total[row] = sum;
            if (table->about_specular) {
                fit_row(table, block, row, passes ? -1.0 : 1.0);
                most_fit(table, block, row, &most, theta_deg_ret);
            }
            if (!(block->total[row] > most))
                continue;
            most = block->total[row];
            const size_t in = row % table->n_in;
            if (table->by_patch) {
                const size_t ring = table->out.ring[in];
                *theta_deg_ret =
                    asin(sqrt(0.5 * (table->out.sin2[ring] + table->out.sin2[ring + 1]))) *
                    (180.0 / RMAP_PI);
            } else {
                *theta_deg_ret = table->theta[in / table->n_turn] * (180.0 / RMAP_PI);
            }
        }
    }
    return most;
}
