/* SPDX-License-Identifier: MIT
 *
 * Rows of facets on analytic surfaces, on a chart of them: u goes around the axis, or along x, v
 * along the profile, or y, both from 0 to 1.
 */
#include "analysis/detector/irradiance_facets.h"

#include <math.h>

#include "base/alloc.h"
#include "geometry/sag.h"

/* Rows of a curved profile, and cells around an axis, at least: that bodies look round; and how
 * many cells of one row lie at a cell of the next, at most. */
enum { ROWS_MIN = 6, AROUND_MIN = 6, PROFILE_STEPS = 64, FINER_MAX = 16 };

/* At this share of the way from the bottom to the top. */
static double wall_height(const struct rmap_shape *shape, struct rmap_vec3 p, double v)
{
    const double bottom = rmap_sag_height(shape->sag[0], p.x, p.y).z,
                 top = shape->length + rmap_sag_height(shape->sag[1], p.x, p.y).z;
    return bottom + v * (top - bottom);
}

static struct rmap_vec3 chart(const struct rmap_shape *shape, double u, double v)
{
    double r = 0.0, z = 0.0;
    switch (shape->type) {
    case RMAP_SHAPE_RECTANGLE:
        return rmap_vec3((u - 0.5) * shape->size[0], (v - 0.5) * shape->size[1], 0.0);
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC: /* inwards, so that u, v and the normal are right-handed */
        r = shape->aperture + v * (shape->inner - shape->aperture);
        z = shape->type == RMAP_SHAPE_CONIC ? rmap_shape_sag(shape, r) : 0.0;
        z = isfinite(z) ? z : 0.0;
        break;
    case RMAP_SHAPE_TUBE:
        r = shape->radius + v * (shape->radius2 - shape->radius);
        z = v * shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        r = shape->radius * sin(RMAP_PI * v);
        z = -shape->radius * cos(RMAP_PI * v);
        break;
    case RMAP_SHAPE_SAG: { /* inwards, too */
        struct rmap_vec3 p = rmap_aperture_chart(&shape->outline, u, v);
        p.z = rmap_sag_height(shape->sag[0], p.x, p.y).z;
        return p;
    }
    case RMAP_SHAPE_WALL: {
        const double around = shape->outline.rectangle ? 0.25 * (shape->side + u - 0.5) : u;
        struct rmap_vec3 p = rmap_aperture_chart(&shape->outline, around - floor(around), 0.0);
        p.z = wall_height(shape, p, v);
        return p;
    }
    }
    return rmap_vec3(r * cos(2.0 * RMAP_PI * u), r * sin(2.0 * RMAP_PI * u), z);
}

static void find_on_chart(const struct rmap_shape *shape, struct rmap_vec3 p, double *u, double *v)
{
    const double r = sqrt(p.x * p.x + p.y * p.y);
    *u = atan2(p.y, p.x) / (2.0 * RMAP_PI);
    *u -= floor(*u);
    switch (shape->type) {
    case RMAP_SHAPE_RECTANGLE:
        *u = p.x / shape->size[0] + 0.5;
        *v = p.y / shape->size[1] + 0.5;
        break;
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        *v = (shape->aperture - r) / (shape->aperture - shape->inner);
        break;
    case RMAP_SHAPE_TUBE:
        *v = p.z / shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        *v = atan2(r, -p.z) / RMAP_PI;
        break;
    case RMAP_SHAPE_SAG:
        rmap_aperture_find(&shape->outline, p.x, p.y, u, v);
        break;
    case RMAP_SHAPE_WALL:
        rmap_aperture_find(&shape->outline, p.x, p.y, u, v);
        if (shape->outline.rectangle)
            *u = fmod(4.0 * *u + 4.5 - shape->side, 4.0);
        *v = (p.z - wall_height(shape, p, 0.0)) /
             (wall_height(shape, p, 1.0) - wall_height(shape, p, 0.0));
        break;
    }
}

/* A shape in its place. */
struct body {
    const struct rmap_shape *shape;
    const struct rmap_affine *to_world;
    double size; /* length of its profile */
};

static struct rmap_vec3 at(const struct body *body, double u, double v)
{
    return rmap_affine_point(body->to_world, chart(body->shape, u, v));
}

/* Length in the world of a line of constant u or v. */
static double line_length(const struct body *body, bool along_v, double other)
{
    double length = 0.0;
    struct rmap_vec3 from = {0, 0, 0};
    for (int k = 0; k <= PROFILE_STEPS; k++) {
        const double x = (double)k / PROFILE_STEPS;
        const struct rmap_vec3 to = along_v ? at(body, other, x) : at(body, x, other);
        length += k > 0 ? rmap_length(rmap_sub(to, from)) : 0.0;
        from = to;
    }
    return length;
}

/* Of the patch between two corners of the chart, by n x n plane pieces. */
static double pieces_area(const struct body *body, const double low[2], const double high[2], int n)
{
    double area = 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            struct rmap_vec3 p[4];
            for (int k = 0; k < 4; k++)
                p[k] = at(body, low[0] + (high[0] - low[0]) * (i + (k & 1)) / n,
                          low[1] + (high[1] - low[1]) * (j + (k >> 1)) / n);
            area += 0.5 * rmap_length(rmap_cross(rmap_sub(p[3], p[0]), rmap_sub(p[2], p[1])));
        }
    return area;
}

/* Their error falls with the square of n, and its first term is taken out (Richardson 1911). */
static double patch_area(const struct body *body, const double low[2], const double high[2])
{
    return (4.0 * pieces_area(body, low, high, 4) - pieces_area(body, low, high, 2)) / 3.0;
}

/* Corners along a row's border; n: cells of the finer of the rows there. At a pole it is one. */
static uint32_t put_border(const struct body *body, double from, double to, double v, uint32_t n,
                           struct rmap_vec3 *corner)
{
    const uint32_t parts = (uint32_t)rint(fabs(to - from) * n);
    for (uint32_t k = 0; k <= parts; k++)
        corner[k] = at(body, from + (to - from) * k / parts, v);
    const bool pole = !(rmap_length(rmap_sub(corner[parts], corner[0])) > 1e-9 * body->size);
    return pole ? 1 : parts + 1;
}

/* As many around as keep cells short: rows next to each other differ by powers of two. */
static uint32_t cells_across(const struct rmap_irradiance_cells *self, const struct body *body,
                             const double v[2])
{
    const double longest = fmax(line_length(body, false, v[0]), line_length(body, false, v[1]));
    const double wanted = fmin(ceil(longest / self->shape_length), RMAP_IRRADIANCE_CELLS_MAX);
    uint32_t n = AROUND_MIN;
    if (body->shape->type == RMAP_SHAPE_RECTANGLE)
        return wanted > 1.0 ? (uint32_t)wanted : 1;
    while (n < wanted)
        n *= 2;
    return n;
}

/* Of a cell, along both borders: a finer neighbour's corners are its own too, so that nothing
 * gapes. */
static enum rmap_status add_patch(struct rmap_irradiance_cells *self, const struct body *body,
                                  const double low[2], const double high[2],
                                  const uint32_t border[2], struct rmap_error *err)
{
    struct rmap_vec3 corner[2 * (FINER_MAX + 1)];
    uint32_t n = put_border(body, low[0], high[0], low[1], border[0], corner);
    n += put_border(body, high[0], low[0], high[1], border[1], corner + n);
    return rmap_irradiance_add_facet(
        self,
        &(struct rmap_irradiance_facet){
            .area = patch_area(body, low, high), .n_corner = n, .triangle = -1},
        corner, err);
}

static enum rmap_status cut_row(struct rmap_irradiance_cells *self, const struct body *body,
                                size_t row, const double v[2], const uint32_t border[2],
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t n = self->row[row].n;
    self->row[row].first = self->n_facet;
    for (uint32_t j = 0; j < n && st == RMAP_OK; j++) {
        const double low[2] = {(double)j / n, v[0]}, high[2] = {(j + 1.0) / n, v[1]};
        st = add_patch(self, body, low, high, border, err);
    }
    return st;
}

enum rmap_status rmap_irradiance_cut_shape(struct rmap_irradiance_cells *self,
                                           const struct rmap_object *object,
                                           const struct rmap_shape *shape, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct body body = {.shape = shape, .to_world = &object->to_world};
    const struct rmap_shape_model *model = &rmap_shape_model[shape->type];
    const bool curved =
        shape->type == RMAP_SHAPE_CONIC || shape->type == RMAP_SHAPE_SAG || model->closed;
    body.size = fmax(line_length(&body, true, 0.0), line_length(&body, true, 0.25));
    const double wanted =
        fmin(ceil(body.size / self->shape_length), (double)RMAP_IRRADIANCE_CELLS_MAX);
    const size_t n = (size_t)fmax(wanted, curved ? ROWS_MIN : 1), first = self->n_row;
    uint64_t n_cell = 0;
    RMAP_TRY(RMAP_RESERVE(self->row, self->cap_row, first + n, err));
    self->n_row += n;
    self->part[self->n_part - 1].n_row = n;
    for (size_t i = 0; i < n; i++) {
        const double v[2] = {(double)i / (double)n, (double)(i + 1) / (double)n};
        self->row[first + i].n = cells_across(self, &body, v);
        n_cell += self->row[first + i].n;
        if (n_cell > RMAP_IRRADIANCE_CELLS_MAX)
            RMAP_TRY(rmap_irradiance_too_many(self, err));
    }
    for (size_t i = 0; i < n; i++) {
        const double v[2] = {(double)i / (double)n, (double)(i + 1) / (double)n};
        uint32_t border[2] = {self->row[first + i].n, self->row[first + i].n};
        for (int k = 0; k < 2; k++)
            if (k == 0 ? i > 0 : i + 1 < n) {
                const uint32_t beside = self->row[k == 0 ? first + i - 1 : first + i + 1].n;
                if (beside > border[k] && beside <= FINER_MAX * border[k])
                    border[k] = beside;
            }
        RMAP_TRY(cut_row(self, &body, first + i, v, border, err));
    }
out:
    return st;
}

static size_t step(double x, size_t n)
{
    return (size_t)fmin(fmax(floor(x * (double)n), 0.0), (double)(n - 1));
}

size_t rmap_irradiance_find_on_shape(const struct rmap_irradiance_cells *self,
                                     const struct rmap_irradiance_part *part,
                                     const struct rmap_object *object,
                                     const struct rmap_shape *shape, struct rmap_vec3 place)
{
    double u = 0.0, v = 0.0;
    find_on_chart(shape, rmap_affine_point(&object->to_local, place), &u, &v);
    const struct rmap_irradiance_row *row = &self->row[part->look_up + step(v, part->n_row)];
    return row->first + step(u, row->n);
}
