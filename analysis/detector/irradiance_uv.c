/* SPDX-License-Identifier: MIT
 *
 * Cells of objects by the texture coordinates of their meshes.
 */
#include <math.h>
#include <string.h>

#include "analysis/detector/irradiance_facets.h"
#include "base/alloc.h"

/* Corners so near a border, in cells, lie on it: texture coordinates are rounded to float. */
static const double ON_BORDER = 1e-4;

/* Of a triangle that four lines cut. */
enum { CORNERS_MAX = 3 + 4 + 1 };

/* Places on a triangle: shares of its corners. */
struct polygon {
    uint32_t n;
    double share[CORNERS_MAX][3];
};

/* Texture coordinates of the corners, in cells. */
struct chart {
    double at[2][3];
};

static bool read_chart(const struct rmap_irradiance_cells *self, const struct rmap_mesh *mesh,
                       size_t triangle, struct chart *chart)
{
    static const float none[6] = {0};
    const float *uv = mesh->uv[triangle];
    for (int k = 0; k < 6; k++) {
        const double at = (double)uv[k] * self->uv[k % 2];
        chart->at[k % 2][k / 2] = fabs(at - rint(at)) < ON_BORDER ? rint(at) : at;
    }
    return memcmp(uv, none, sizeof none) != 0;
}

static double along(const struct chart *chart, int axis, const double share[3])
{
    const double *at = chart->at[axis];
    return share[0] * at[0] + share[1] * at[1] + share[2] * at[2];
}

/* What lies at or beyond a line (sign 1) or before it (-1). */
static void clip(const struct chart *chart, int axis, double line, double sign,
                 const struct polygon *from, struct polygon *to)
{
    to->n = 0;
    for (uint32_t k = 0; k < from->n; k++) {
        const double *a = from->share[k], *b = from->share[(k + 1) % from->n];
        const double in = sign * (along(chart, axis, a) - line);
        const double next = sign * (along(chart, axis, b) - line);
        if (in >= 0.0 && to->n < CORNERS_MAX)
            memcpy(to->share[to->n++], a, sizeof *to->share);
        if (((in > 0.0 && next < 0.0) || (in < 0.0 && next > 0.0)) && to->n < CORNERS_MAX) {
            for (int i = 0; i < 3; i++)
                to->share[to->n][i] = (a[i] * next - b[i] * in) / (next - in);
            to->n++;
        }
    }
}

/* First and last cell that a polygon lies in. */
static void find_range(const struct chart *chart, int axis, const struct polygon *polygon,
                       double range[2])
{
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (uint32_t k = 0; k < polygon->n; k++) {
        const double at = along(chart, axis, polygon->share[k]);
        low = fmin(low, at);
        high = fmax(high, at);
    }
    range[0] = floor(low);
    range[1] = fmax(range[0], ceil(high) - 1.0);
}

static void clip_to(const struct chart *chart, int axis, double cell, const struct polygon *from,
                    struct polygon *to)
{
    struct polygon beyond;
    clip(chart, axis, cell, 1.0, from, &beyond);
    clip(chart, axis, cell + 1.0, -1.0, &beyond, to);
}

/* Textures repeat. */
static size_t cell_of(const struct rmap_irradiance_cells *self, double column, double row)
{
    const double at[2] = {column, row};
    size_t of[2];
    for (int k = 0; k < 2; k++)
        of[k] = (size_t)(at[k] - self->uv[k] * floor(at[k] / self->uv[k])) % self->uv[k];
    return of[1] * self->uv[0] + of[0];
}

/* What charts cover of a cell: how much, in cells, and which of 8 x 8 places in it. */
enum { PLACES = 8 };
struct cover {
    double area;
    uint64_t seen;
    bool twice; /* some place */
};

/* A triangle of the part in hand. */
struct cut {
    struct rmap_irradiance_cells *cells;
    struct chart chart;
    struct rmap_vec3 corner[3];
    double area, covers; /* it; and of the texture, in cells */
    struct cover *cover; /* [rows][columns] of the texture */
    int32_t triangle;
};

/* Neither on an edge nor so near that rounding decides; corners turn in either sense. */
static bool is_within(double corner[][2], uint32_t n, const double at[2])
{
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (uint32_t k = 0; k < n; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % n];
        const double edge[2] = {b[0] - a[0], b[1] - a[1]}, len = hypot(edge[0], edge[1]);
        const double off =
            len > 0.0 ? (edge[0] * (at[1] - a[1]) - edge[1] * (at[0] - a[0])) / len : (double)NAN;
        low = fmin(low, off);
        high = fmax(high, off);
    }
    return low > 10.0 * ON_BORDER || high < -10.0 * ON_BORDER;
}

/* Places off the lines and diagonals on which regular meshes have edges. */
static void look_at_places(const struct chart *chart, const struct polygon *piece,
                           const double cell[2], struct cover *cover)
{
    static const double offset[2] = {0.37, 0.61};
    double corner[CORNERS_MAX][2];
    int first[2] = {PLACES, PLACES}, last[2] = {-1, -1};
    for (uint32_t k = 0; k < piece->n; k++)
        for (int axis = 0; axis < 2; axis++) {
            corner[k][axis] = PLACES * (along(chart, axis, piece->share[k]) - cell[axis]);
            first[axis] = (int)fmin(first[axis], ceil(corner[k][axis] - offset[axis]));
            last[axis] = (int)fmax(last[axis], floor(corner[k][axis] - offset[axis]));
        }
    for (int j = first[1]; j <= last[1]; j++)
        for (int i = first[0]; i <= last[0]; i++) {
            const uint64_t place = (uint64_t)1 << (j * PLACES + i);
            if (!is_within(corner, piece->n, (const double[]){i + offset[0], j + offset[1]}))
                continue;
            cover->twice = cover->twice || (cover->seen & place);
            cover->seen |= place;
        }
}

static enum rmap_status add_piece(const struct cut *cut, const struct polygon *piece,
                                  const double at[2], struct rmap_error *err)
{
    const size_t cell = cell_of(cut->cells, at[0], at[1]);
    struct rmap_vec3 corner[CORNERS_MAX];
    double part = 0.0; /* of the triangle */
    for (uint32_t k = 0; k < piece->n; k++) {
        const double *a = piece->share[k], *b = piece->share[(k + 1) % piece->n];
        part += a[1] * b[2] - a[2] * b[1];
        corner[k] = rmap_scale(cut->corner[0], a[0]);
        for (int i = 1; i < 3; i++)
            corner[k] = rmap_axpy(a[i], cut->corner[i], corner[k]);
    }
    if (piece->n < 3 || !(part > 0.0))
        return RMAP_OK;
    cut->cover[cell].area += part * cut->covers;
    look_at_places(&cut->chart, piece, at, &cut->cover[cell]);
    return rmap_irradiance_add_facet(cut->cells,
                                     &(struct rmap_irradiance_facet){.area = part * cut->area,
                                                                     .n_corner = piece->n,
                                                                     .cell = (uint32_t)cell,
                                                                     .triangle = cut->triangle},
                                     corner, err);
}

static enum rmap_status cut_triangle(const struct cut *cut, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct polygon whole = {3, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    double column[2], row[2];
    find_range(&cut->chart, 0, &whole, column);
    for (double u = column[0]; u <= column[1]; u++) {
        struct polygon strip, piece;
        clip_to(&cut->chart, 0, u, &whole, &strip);
        if (strip.n < 3)
            continue;
        find_range(&cut->chart, 1, &strip, row);
        for (double v = row[0]; v <= row[1]; v++) {
            clip_to(&cut->chart, 1, v, &strip, &piece);
            RMAP_TRY(add_piece(cut, &piece, (const double[]){u, v}, err));
        }
    }
out:
    return st;
}

enum rmap_status rmap_irradiance_cut_uv(struct rmap_irradiance_cells *self,
                                        const struct rmap_irradiance_choice *choice,
                                        const struct rmap_object *object,
                                        const struct rmap_mesh *mesh, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t first = self->n_node, n_cell = (size_t)self->uv[0] * self->uv[1];
    struct cut cut = {.cells = self, .cover = NULL};
    if (!mesh || !mesh->uv)
        return rmap_error_set(err, RMAP_INPUT,
                              mesh ? "'%.60s' has no texture coordinates in this map: say `uv: "
                                     "true` in its geometry, which keeps those of its file, and "
                                     "trace again"
                                   : "'%.60s' is no mesh of a file: only such have texture "
                                     "coordinates; --cells LENGTH cuts any shape",
                              object->name);
    cut.cover = rmap_alloc(n_cell, sizeof *cut.cover);
    if (!cut.cover)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells"));
    RMAP_TRY(RMAP_RESERVE(self->node, self->cap_node, first + mesh->n_triangle + 1, err));
    self->n_node += mesh->n_triangle + 1;
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        const bool wanted = rmap_irradiance_has_face(choice, mesh, i);
        const bool textured = read_chart(self, mesh, i, &cut.chart);
        const double *u = cut.chart.at[0], *v = cut.chart.at[1];
        self->node[first + i] = (struct rmap_irradiance_node){
            (uint32_t)self->n_facet,
            wanted && textured ? RMAP_IRRADIANCE_LEAF : RMAP_IRRADIANCE_NONE};
        self->n_without += wanted && !textured;
        if (!wanted || !textured)
            continue;
        rmap_irradiance_corners(object, mesh, i, cut.corner);
        cut.area = 0.5 * rmap_length(rmap_cross(rmap_sub(cut.corner[1], cut.corner[0]),
                                                rmap_sub(cut.corner[2], cut.corner[0])));
        cut.covers = 0.5 * fabs((u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]));
        cut.triangle = (int32_t)i;
        RMAP_TRY(cut_triangle(&cut, err));
    }
    self->node[first + mesh->n_triangle] =
        (struct rmap_irradiance_node){(uint32_t)self->n_facet, RMAP_IRRADIANCE_NONE};
    for (size_t c = 0; c < n_cell; c++)
        self->n_twice += cut.cover[c].twice || cut.cover[c].area > 1.0 + 10.0 * ON_BORDER;
out:
    rmap_free(cut.cover);
    return st;
}

size_t rmap_irradiance_find_by_uv(const struct rmap_irradiance_cells *self, size_t part,
                                  const struct rmap_mesh *mesh, size_t triangle,
                                  const double share[3])
{
    const struct rmap_irradiance_node *node = &self->node[self->part[part].look_up + triangle];
    const struct polygon whole = {3, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const double sum = fmax(share[0], 0.0) + fmax(share[1], 0.0) + fmax(share[2], 0.0);
    double at[2], within[3];
    struct chart chart;
    if (node->edge == RMAP_IRRADIANCE_NONE || !(sum > 0.0))
        return SIZE_MAX;
    (void)read_chart(self, mesh, triangle, &chart);
    for (int k = 0; k < 3; k++)
        within[k] = fmax(share[k], 0.0) / sum;
    for (int axis = 0; axis < 2; axis++) {
        double range[2];
        find_range(&chart, axis, &whole, range);
        at[axis] = fmin(fmax(floor(along(&chart, axis, within)), range[0]), range[1]);
    }
    const uint32_t cell =
        self->uv_cell[part * self->uv[0] * self->uv[1] + cell_of(self, at[0], at[1])];
    if (cell != UINT32_MAX || node[1].at == node->at)
        return cell != UINT32_MAX ? cell : SIZE_MAX;
    /* Beyond a slanted border by rounding: the piece whose middle is nearest. */
    size_t nearest = node->at;
    double least = (double)INFINITY;
    for (size_t f = node->at; f < node[1].at; f++) {
        const uint32_t place = self->cell[self->facet[f].cell].uv;
        const double u = (double)(place % self->uv[0]) - at[0],
                     v = (double)(place / self->uv[0]) - at[1];
        if (u * u + v * v < least) {
            least = u * u + v * v;
            nearest = f;
        }
    }
    return self->facet[nearest].cell;
}

enum rmap_status rmap_irradiance_index_uv(struct rmap_irradiance_cells *self,
                                          struct rmap_error *err)
{
    const size_t n = (size_t)self->uv[0] * self->uv[1];
    if (self->n_part * n > 4 * (size_t)RMAP_IRRADIANCE_CELLS_MAX)
        return rmap_error_set(
            err, RMAP_USAGE,
            "textures of %u x %u cells of %zu objects are too many: ask for fewer "
            "of them, or fewer objects",
            self->uv[0], self->uv[1], self->n_part);
    self->uv_cell = rmap_alloc(self->n_part * n, sizeof *self->uv_cell);
    if (!self->uv_cell)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    memset(self->uv_cell, 0xff, self->n_part * n * sizeof *self->uv_cell);
    for (size_t c = 0; c < self->n_cell; c++)
        self->uv_cell[self->cell[c].part * n + self->cell[c].uv] = (uint32_t)c;
    return RMAP_OK;
}
