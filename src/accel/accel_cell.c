/* SPDX-License-Identifier: MIT
 *
 * Cells of true surfaces: where they end.
 */
#include "accel/accel_cell.h"

#include <stdlib.h>

#include "base/alloc.h"

/* Sine of the angle below which two surfaces go smoothly on into one another; and the same where
 * one of them is known by triangles alone. */
#define SMOOTH      1e-4
#define SMOOTH_FLAT 0.5
#define STRIP_FACTOR                                                                               \
    2 /* of the strip's width over how far the edge's middle is from the chord's                   \
       */

/* Distances within which a point is on either side of another surface for all that its numbers
 * say: then the order along the ray decides. As a share of coordinates. */
#define TIE 1e-13

/* Rays that run along smooth surfaces at smaller cosines than 1 / SLANT may slip through. */
#define SLANT 16

static double distance(const struct rmap_cell_edge *edge, struct rmap_vec3 p)
{
    return edge->plane[0] * p.x + edge->plane[1] * p.y + edge->plane[2] * p.z + edge->plane[3];
}

/* ---- building ---- */

static struct rmap_true_surface plane_of(const struct rmap_mesh *mesh, size_t triangle)
{
    struct rmap_true_surface plane = {.kind = RMAP_TRUE_PLANE};
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(mesh, triangle, corner);
    plane.at = corner[0];
    plane.axis = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    plane.axis = rmap_scale(plane.axis, 1 / rmap_length(plane.axis));
    rmap_basis(plane.axis, &plane.x, &plane.y);
    return plane;
}

struct named {
    const struct rmap_true_surface *surface;
    int32_t face;
};

static int compare(const void *left, const void *right)
{
    const struct named *a = left, *b = right;
    const struct rmap_true_surface *s = a->surface, *r = b->surface;
    const double p[] = {s->kind,   s->at.x,   s->at.y,   s->at.z,  s->axis.x,
                        s->axis.y, s->axis.z, s->radius, s->second},
                 q[] = {r->kind,   r->at.x,   r->at.y,   r->at.z,  r->axis.x,
                        r->axis.y, r->axis.z, r->radius, r->second};
    for (size_t i = 0; i < sizeof p / sizeof p[0]; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return a->face < b->face ? -1 : a->face > b->face;
}

/* Of faces that lie on one surface, as the decoder of compact maps has it, the first. */
static bool name_surfaces(struct rmap_cells *cells, int32_t *lead)
{
    const struct rmap_mesh *mesh = cells->mesh;
    struct named *order = rmap_alloc(mesh->n_face, sizeof(*order));
    for (size_t i = 0; order && i < mesh->n_face; i++) {
        cells->surface[i] = mesh->surface[i];
        order[i] = (struct named){&mesh->surface[i], (int32_t)i};
    }
    if (order)
        qsort(order, mesh->n_face, sizeof(*order), compare);
    for (size_t i = 0; order && i < mesh->n_face; i++) {
        bool same = i > 0 && rmap_true_same(order[i - 1].surface, order[i].surface);
        lead[order[i].face] = same ? lead[order[i - 1].face] : order[i].face;
    }
    rmap_free(order);
    return order != NULL;
}

static void set_surfaces(struct rmap_cells *cells, const int32_t *lead)
{
    const struct rmap_mesh *mesh = cells->mesh;
    int32_t next = (int32_t)mesh->n_face;
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        if (rmap_mesh_surface(mesh, i)) {
            cells->its[i] = lead[mesh->face[i]];
            continue;
        }
        cells->its[i] = next;
        cells->surface[next++] = plane_of(mesh, i);
    }
}

/* The triangle beyond an edge, which it runs through the other way, and the edge there; -1: none.
 */
static int64_t find_across(const struct rmap_cells *cells, const struct rmap_facets *facets,
                           size_t triangle, int k)
{
    const struct rmap_mesh *mesh = cells->mesh;
    uint32_t from = facets->same[mesh->triangle[triangle][k]];
    uint32_t to = facets->same[mesh->triangle[triangle][(k + 1) % 3]];
    for (uint32_t i = facets->first[from]; i < facets->first[from + 1]; i++) {
        size_t other = facets->fan[i];
        for (int j = 0; j < 3 && other != triangle; j++)
            if (facets->same[mesh->triangle[other][j]] == to &&
                facets->same[mesh->triangle[other][(j + 1) % 3]] == from)
                return (int64_t)(3 * other) + j;
    }
    return -1;
}

/* The plane through an edge and along a normal, which has `inside` on its positive side. */
static void set_plane(struct rmap_vec3 from, struct rmap_vec3 along, struct rmap_vec3 normal,
                      struct rmap_vec3 inside, double plane[4])
{
    struct rmap_vec3 n = rmap_cross(normal, along);
    double length = rmap_length(n);
    n = rmap_scale(n, length > 0 ? 1 / length : 0);
    if (rmap_dot(n, rmap_sub(inside, from)) < 0)
        n = rmap_scale(n, -1);
    plane[0] = n.x;
    plane[1] = n.y;
    plane[2] = n.z;
    plane[3] = -rmap_dot(n, from);
}

/* The point of both surfaces nearest to p, by Newton's steps; sine: of their angle there. */
static struct rmap_vec3 meeting_point(const struct rmap_true_surface *a,
                                      const struct rmap_true_surface *b, struct rmap_vec3 p,
                                      double *sine, double *miss)
{
    enum { STEPS = 12 };
    for (int i = 0;; i++) {
        struct rmap_vec3 m, n;
        double f = rmap_true_distance(a, p, &m), g = rmap_true_distance(b, p, &n);
        double c = rmap_dot(m, n), det = 1 - c * c;
        *sine = rmap_length(rmap_cross(m, n));
        *miss = fabs(f) + fabs(g);
        if (i == STEPS || !(det > 1e-12))
            return p;
        p = rmap_axpy(-(f - c * g) / det, m, rmap_axpy(-(g - c * f) / det, n, p));
    }
}

static struct rmap_vec3 third(const struct rmap_mesh *mesh, size_t triangle, int k)
{
    return rmap_vec3_of(mesh->vertex[mesh->triangle[triangle][(k + 2) % 3]]);
}

/* Both sides of one edge; its kind and strip are the same for both. */
struct seam {
    size_t triangle[2];
    int k[2];
    struct rmap_vec3 from, along, middle;
    double rounding;
};

static void set_sharp(struct rmap_cells *cells, const struct seam *seam, struct rmap_vec3 at,
                      double width)
{
    for (int i = 0; i < 2; i++) {
        struct rmap_cell_edge *edge = &cells->edge[seam->triangle[i]][seam->k[i]];
        struct rmap_vec3 own, other, inward;
        (void)rmap_true_distance(rmap_cell_surface(cells, (int32_t)seam->triangle[i]), at, &own);
        (void)rmap_true_distance(rmap_cell_surface(cells, (int32_t)seam->triangle[1 - i]), at,
                                 &other);
        set_plane(seam->from, seam->along, own, third(cells->mesh, seam->triangle[i], seam->k[i]),
                  edge->plane);
        inward = rmap_vec3(edge->plane[0], edge->plane[1], edge->plane[2]);
        edge->brink = RMAP_BRINK_SHARP;
        edge->width = width;
        edge->sign = rmap_dot(other, inward) < 0 ? -1 : 1;
    }
}

/* One plane for both sides. */
static void set_shared(struct rmap_cells *cells, const struct seam *seam, enum rmap_brink brink,
                       struct rmap_vec3 normal, double width)
{
    struct rmap_cell_edge *edge = &cells->edge[seam->triangle[0]][seam->k[0]],
                          *other = &cells->edge[seam->triangle[1]][seam->k[1]];
    set_plane(seam->from, seam->along, normal, third(cells->mesh, seam->triangle[0], seam->k[0]),
              edge->plane);
    for (int i = 0; i < 4; i++)
        other->plane[i] = -edge->plane[i];
    edge->brink = other->brink = (int8_t)brink;
    edge->width = other->width = width;
}

/* How far the ends of an edge are from a surface through it. */
static double ends_off(const struct seam *seam, const struct rmap_true_surface *surface)
{
    struct rmap_vec3 normal;
    return fabs(rmap_true_distance(surface, seam->from, &normal)) +
           fabs(rmap_true_distance(surface, rmap_add(seam->from, seam->along), &normal));
}

static void set_seam(struct rmap_cells *cells, const struct seam *seam)
{
    const int32_t a = cells->its[seam->triangle[0]], b = cells->its[seam->triangle[1]];
    const bool plain = !rmap_cell_is_true(cells, (int32_t)seam->triangle[0]) ||
                       !rmap_cell_is_true(cells, (int32_t)seam->triangle[1]);
    const struct rmap_true_surface *first = &cells->surface[a < b ? a : b],
                                   *second = &cells->surface[a < b ? b : a];
    struct rmap_vec3 normal, other;
    double off = fabs(rmap_true_distance(first, seam->middle, &normal)), sine = 0, miss = 0;
    cells->edge[seam->triangle[0]][seam->k[0]].across = b;
    cells->edge[seam->triangle[1]][seam->k[1]].across = a;
    if (a == b) {
        set_shared(cells, seam, RMAP_BRINK_SAME, normal, seam->rounding);
        return;
    }
    struct rmap_vec3 at = meeting_point(first, second, seam->middle, &sine, &miss);
    double rounding = seam->rounding + ends_off(seam, first) + ends_off(seam, second);
    double bow = rmap_length(rmap_sub(at, seam->middle));
    if (!plain || rmap_cell_is_true(cells, (int32_t)seam->triangle[0]) ||
        rmap_cell_is_true(cells, (int32_t)seam->triangle[1])) {
        if (sine > (plain ? SMOOTH_FLAT : SMOOTH) && miss <= seam->rounding &&
            bow <= rmap_length(seam->along)) {
            set_sharp(cells, seam, at, STRIP_FACTOR * bow + rounding);
            return;
        }
        off = rmap_greater(off, fabs(rmap_true_distance(second, seam->middle, &other)));
        set_shared(cells, seam, RMAP_BRINK_SMOOTH, normal, STRIP_FACTOR * off + rounding);
        return;
    }
    set_shared(cells, seam, RMAP_BRINK_FLAT, normal, 0);
}

static void set_open(struct rmap_cells *cells, const struct seam *seam)
{
    struct rmap_cell_edge *edge = &cells->edge[seam->triangle[0]][seam->k[0]];
    struct rmap_vec3 normal;
    (void)rmap_true_distance(rmap_cell_surface(cells, (int32_t)seam->triangle[0]), seam->middle,
                             &normal);
    set_plane(seam->from, seam->along, normal, third(cells->mesh, seam->triangle[0], seam->k[0]),
              edge->plane);
    edge->across = -1;
    edge->brink = RMAP_BRINK_OPEN;
}

static void set_edges(struct rmap_cells *cells, const struct rmap_facets *facets, double rounding)
{
    const struct rmap_mesh *mesh = cells->mesh;
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++) {
            int64_t across = find_across(cells, facets, i, k);
            struct rmap_vec3 from = rmap_vec3_of(mesh->vertex[mesh->triangle[i][k]]);
            struct rmap_vec3 to = rmap_vec3_of(mesh->vertex[mesh->triangle[i][(k + 1) % 3]]);
            struct seam seam = {.triangle = {i},
                                .k = {k},
                                .from = from,
                                .along = rmap_sub(to, from),
                                .middle = rmap_scale(rmap_add(from, to), 0.5),
                                .rounding = rounding};
            if (across < 0) {
                set_open(cells, &seam);
                continue;
            }
            seam.triangle[1] = (size_t)(across / 3);
            seam.k[1] = (int)(across % 3);
            if (seam.triangle[1] > i ||
                find_across(cells, facets, seam.triangle[1], seam.k[1]) != (int64_t)(3 * i) + k)
                set_seam(cells, &seam);
        }
}

static void set_box(struct rmap_cells *cells, size_t i, double wider)
{
    struct rmap_vec3 corner[3];
    double by = wider + rmap_mesh_bulge(cells->mesh, i), strip = 0;
    rmap_mesh_corners(cells->mesh, i, corner);
    for (int k = 0; k < 3; k++) {
        const struct rmap_cell_edge *edge = &cells->edge[i][k];
        bool smooth = edge->brink == RMAP_BRINK_SMOOTH;
        strip = rmap_greater(strip, edge->width * (smooth ? SLANT : 2));
    }
    struct rmap_vec3 low = rmap_least(corner[0], rmap_least(corner[1], corner[2]));
    struct rmap_vec3 high = rmap_greatest(corner[0], rmap_greatest(corner[1], corner[2]));
    by += strip;
    const double box[6] = {low.x - by,  low.y - by,  low.z - by,
                           high.x + by, high.y + by, high.z + by};
    for (int k = 0; k < 6; k++)
        cells->box[i][k] = (float)box[k];
}

/* Edges at which a surface ends and that have a corner in common with the triangle; `to`: NULL,
 * they are counted. */
static uint32_t list_near(const struct rmap_cells *cells, const struct rmap_facets *facets,
                          size_t triangle, uint32_t *to)
{
    uint32_t n = 0;
    for (int c = 0; c < 3; c++) {
        uint32_t vertex = facets->same[cells->mesh->triangle[triangle][c]];
        for (uint32_t i = facets->first[vertex]; i < facets->first[vertex + 1]; i++) {
            uint32_t other = facets->fan[i];
            if (other == triangle || cells->its[other] != cells->its[triangle])
                continue;
            for (int k = 0; k < 3; k++) {
                const struct rmap_cell_edge *edge = &cells->edge[other][k];
                bool ends = facets->same[cells->mesh->triangle[other][k]] == vertex ||
                            facets->same[cells->mesh->triangle[other][(k + 1) % 3]] == vertex;
                if (!ends || (edge->brink != RMAP_BRINK_SHARP && edge->brink != RMAP_BRINK_SMOOTH))
                    continue;
                if (to)
                    to[n] = 3 * other + (uint32_t)k;
                n++;
            }
        }
    }
    return n;
}

static bool set_near(struct rmap_cells *cells, const struct rmap_facets *facets)
{
    const size_t n = cells->mesh->n_triangle;
    size_t most = 0;
    for (size_t i = 0; i < n; i++) {
        cells->first[i] = (uint32_t)most;
        most += list_near(cells, facets, i, NULL);
    }
    cells->first[n] = (uint32_t)most;
    cells->near = most < UINT32_MAX ? rmap_alloc(most + 1, sizeof(*cells->near)) : NULL;
    for (size_t i = 0; cells->near && i < n; i++)
        (void)list_near(cells, facets, i, cells->near + cells->first[i]);
    return cells->near != NULL;
}

enum rmap_status rmap_cells_build(const struct rmap_mesh *mesh, const struct rmap_facets *facets,
                                  double wider, struct rmap_cells **cells_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = mesh->n_triangle + mesh->n_triangle_beyond;
    struct rmap_vec3 low, high;
    int32_t *lead = rmap_alloc(mesh->n_face + mesh->n_face_beyond, sizeof(*lead));
    struct rmap_cells *cells = rmap_alloc(1, sizeof(*cells));
    if (!cells || !lead)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles", n));
    cells->whole = rmap_mesh_with_beyond(mesh);
    cells->mesh = mesh = &cells->whole;
    cells->surface = rmap_alloc(mesh->n_face + n, sizeof(*cells->surface));
    cells->its = rmap_alloc(n, sizeof(*cells->its));
    cells->edge = rmap_alloc(n, sizeof(*cells->edge));
    cells->box = rmap_alloc(n, sizeof(*cells->box));
    cells->first = rmap_alloc(n + 1, sizeof(*cells->first));
    if (!cells->surface || !cells->its || !cells->edge || !cells->box || !cells->first)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles", n));
    rmap_mesh_bounds(mesh, &low, &high);
    high = rmap_greatest(rmap_scale(low, -1),
                         rmap_greatest(rmap_scale(high, -1), rmap_greatest(low, high)));
    if (!name_surfaces(cells, lead))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles", n));
    set_surfaces(cells, lead);
    set_edges(cells, facets, 8 * RMAP_FLOAT_EPS * rmap_length(high));
    if (!set_near(cells, facets))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles", n));
    for (size_t i = 0; i < n; i++)
        set_box(cells, i, wider);
    *cells_ret = cells;
    cells = NULL;
out:
    rmap_free(lead);
    rmap_cells_destroy(cells);
    return st;
}

void rmap_cells_destroy(struct rmap_cells *cells)
{
    if (!cells)
        return;
    rmap_free(cells->surface);
    rmap_free(cells->its);
    rmap_free(cells->edge);
    rmap_free(cells->box);
    rmap_free(cells->first);
    rmap_free(cells->near);
    rmap_free(cells);
}

/* ---- asking ---- */

/* Points where the ray meets a surface of the mesh, its start among them where it lies there. */
static void meet_all(const struct rmap_query *query, const struct rmap_cells *cells,
                     int32_t surface, struct rmap_true_meeting *met)
{
    const struct rmap_local_ray *local = &query->local;
    bool own = query->start.object == local->object && query->start.surface == surface;
    rmap_true_meet(&cells->surface[surface], local->origin, local->direction, own, met);
    if (own && met->n < RMAP_TRUE_ROOTS) {
        met->t[met->n] = 0;
        met->point[met->n++] = local->origin;
    }
}

/* The one at the least distance along the ray, of those where it goes the same way through the
 * surface as at the normal of another; along NULL: of all. -1: none. */
static int nearest_along(const struct rmap_query *query, const struct rmap_true_surface *surface,
                         const struct rmap_true_meeting *met, double t,
                         const struct rmap_vec3 *along)
{
    const struct rmap_vec3 d = query->local.direction;
    int best = -1;
    for (int i = 0; i < met->n; i++) {
        struct rmap_vec3 n = {0, 0, 0};
        if (along)
            (void)rmap_true_distance(surface, met->point[i], &n);
        if (along && rmap_dot(n, d) * rmap_dot(*along, d) * rmap_dot(n, *along) < 0)
            continue;
        if (best < 0 || fabs(met->t[i] - t) < fabs(met->t[best] - t))
            best = i;
    }
    return best;
}

/* Is the point on the side of the other surface where this one is? */
static bool on_side(const struct rmap_query *query, const struct rmap_cells *cells, int32_t surface,
                    const struct rmap_cell_edge *edge, double t, struct rmap_vec3 point)
{
    const struct rmap_true_surface *other = &cells->surface[edge->across];
    struct rmap_vec3 normal;
    struct rmap_true_meeting met;
    double off = edge->sign * rmap_true_distance(other, point, &normal);
    double size = fabs(point.x) + fabs(point.y) + fabs(point.z) + fabs(query->local.origin.x) +
                  fabs(query->local.origin.y) + fabs(query->local.origin.z);
    if (fabs(off) > TIE * size)
        return off > 0;
    meet_all(query, cells, edge->across, &met);
    int i = nearest_along(query, other, &met, t, NULL);
    if (i < 0)
        return off > 0;
    if (met.t[i] == t)
        return surface < edge->across;
    return (edge->sign * rmap_dot(normal, query->local.direction) > 0) == (t > met.t[i]);
}

/* The same where one goes on into the other. */
static bool divides(const struct rmap_query *query, const struct rmap_cells *cells, int32_t surface,
                    const struct rmap_cell_edge *edge, double t, struct rmap_vec3 point)
{
    const double inside = distance(edge, point);
    struct rmap_true_meeting met;
    struct rmap_vec3 normal;
    if (surface < edge->across)
        return inside >= 0;
    (void)rmap_true_distance(&cells->surface[surface], point, &normal);
    meet_all(query, cells, edge->across, &met);
    int i = nearest_along(query, &cells->surface[edge->across], &met, t, &normal);
    double first = i < 0 ? HUGE_VAL : distance(edge, met.point[i]);
    return fabs(first) <= 2 * SLANT * edge->width ? first > 0 : inside > 0;
}

/* Is p beside the edge, which has these ends? */
static bool beside(const struct rmap_cells *cells, uint32_t which, struct rmap_vec3 p)
{
    const uint32_t *corner = cells->mesh->triangle[which / 3];
    double width = cells->edge[which / 3][which % 3].width;
    struct rmap_vec3 from = rmap_vec3_of(cells->mesh->vertex[corner[which % 3]]);
    struct rmap_vec3 along =
        rmap_sub(rmap_vec3_of(cells->mesh->vertex[corner[(which % 3 + 1) % 3]]), from);
    double length = rmap_length(along), at = rmap_dot(rmap_sub(p, from), along) / length;
    return at >= -width && at <= length + width;
}

/* By how much farther aside a line meets two surfaces that lie behind one another, at most SLANT.
 */
static double slant(const struct rmap_query *query, const struct rmap_true_surface *surface,
                    struct rmap_vec3 point)
{
    struct rmap_vec3 normal, d = query->local.direction;
    (void)rmap_true_distance(surface, point, &normal);
    double cosine = fabs(rmap_dot(normal, d)) / rmap_length(d);
    return SLANT * cosine > 1 ? 1 / cosine : SLANT;
}

bool rmap_cell_holds(const struct rmap_query *query, int32_t object, int32_t primitive, double t,
                     struct rmap_vec3 point)
{
    const struct rmap_cells *cells = query->accel->object[object].cells;
    const float *box = cells->box[primitive];
    const int32_t surface = cells->its[primitive];
    if (!(point.x >= (double)box[0] && point.y >= (double)box[1] && point.z >= (double)box[2] &&
          point.x <= (double)box[3] && point.y <= (double)box[4] && point.z <= (double)box[5]))
        return false;
    for (int k = 0; k < 3; k++) {
        const struct rmap_cell_edge *edge = &cells->edge[primitive][k];
        double inside = distance(edge, point), width = edge->width;
        if (edge->brink == RMAP_BRINK_SMOOTH && fabs(inside) <= SLANT * width)
            width *= slant(query, &cells->surface[surface], point);
        if (inside > width || edge->brink == RMAP_BRINK_FLAT)
            continue;
        if (inside < -width ||
            (edge->brink == RMAP_BRINK_SHARP && !on_side(query, cells, surface, edge, t, point)) ||
            (edge->brink == RMAP_BRINK_SMOOTH && !divides(query, cells, surface, edge, t, point)))
            return false;
    }
    for (uint32_t i = cells->first[primitive]; i < cells->first[primitive + 1]; i++) {
        const uint32_t which = cells->near[i];
        const struct rmap_cell_edge *edge = &cells->edge[which / 3][which % 3];
        if (edge->brink == RMAP_BRINK_SHARP && fabs(distance(edge, point)) <= edge->width &&
            beside(cells, which, point) && !on_side(query, cells, surface, edge, t, point))
            return false;
    }
    return true;
}

static bool follows(const struct rmap_cell_edge *edge, int32_t surface, struct rmap_vec3 p,
                    double *width)
{
    if (edge->brink != RMAP_BRINK_SMOOTH || edge->across != surface ||
        fabs(distance(edge, p)) > SLANT * edge->width)
        return false;
    *width = edge->width;
    return true;
}

bool rmap_cell_is_start(const struct rmap_query *query, int32_t object, int32_t primitive,
                        struct rmap_vec3 point, struct rmap_vec3 normal)
{
    const struct rmap_cells *cells = query->accel->object[object].cells;
    const struct rmap_local_ray *local = &query->local;
    const int32_t from = query->start.surface;
    bool smooth = false;
    double width = 0;
    if (query->start.object != object || from < 0)
        return false;
    for (int k = 0; k < 3 && !smooth; k++)
        smooth = follows(&cells->edge[primitive][k], from, local->origin, &width);
    for (uint32_t i = cells->first[primitive]; i < cells->first[primitive + 1] && !smooth; i++)
        smooth = follows(&cells->edge[cells->near[i] / 3][cells->near[i] % 3], from, local->origin,
                         &width);
    if (!smooth || rmap_length(rmap_sub(point, local->origin)) > 2 * SLANT * width)
        return false;
    struct rmap_vec3 leaving;
    (void)rmap_true_distance(&cells->surface[from], local->origin, &leaving);
    if (rmap_dot(leaving, normal) < 0)
        leaving = rmap_scale(leaving, -1);
    return rmap_dot(leaving, local->direction) * rmap_dot(normal, local->direction) > 0;
}
