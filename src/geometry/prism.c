/* SPDX-License-Identifier: MIT
 *
 * Straight prisms over a polygon as closed meshes. The corners are those of the mesh, in single
 * precision, so that what is found of the polygon holds of the mesh: differences of its coordinates
 * and their products are exact in double, unless magnitudes differ widely.
 */
#include "geometry/prism.h"

#include <math.h>
#include <stdbool.h>

#include "base/alloc.h"

struct point {
    double x, y;
};

/* Twice the area of the triangle; greater than 0: counter-clockwise. */
static double turn(struct point a, struct point b, struct point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool within_box(struct point a, struct point b, struct point p)
{
    return fmin(a.x, b.x) <= p.x && p.x <= fmax(a.x, b.x) && fmin(a.y, b.y) <= p.y &&
           p.y <= fmax(a.y, b.y);
}

/* Whether two segments have a point in common. */
static bool meet(struct point a, struct point b, struct point c, struct point d)
{
    double c_of = turn(a, b, c), d_of = turn(a, b, d), a_of = turn(c, d, a), b_of = turn(c, d, b);
    bool apart = (c_of > 0) == (d_of > 0) || (a_of > 0) == (b_of > 0);
    if (c_of != 0 && d_of != 0 && a_of != 0 && b_of != 0)
        return !apart;
    return (c_of == 0 && within_box(a, b, c)) || (d_of == 0 && within_box(a, b, d)) ||
           (a_of == 0 && within_box(c, d, a)) || (b_of == 0 && within_box(c, d, b)) || !apart;
}

static enum rmap_status check_polygon(const struct point *p, size_t n, struct rmap_error *err)
{
    for (size_t i = 0; i < n; i++) {
        struct point a = p[i], b = p[(i + 1) % n], c = p[(i + 2) % n];
        if (a.x == b.x && a.y == b.y)
            return rmap_error_set(err, RMAP_INPUT,
                                  "points %zu and %zu of the polygon are the same: leave one out",
                                  i + 1, (i + 1) % n + 1);
        double ahead = (b.x - a.x) * (c.x - b.x) + (b.y - a.y) * (c.y - b.y);
        if (turn(a, b, c) == 0 && ahead < 0)
            return rmap_error_set(err, RMAP_INPUT, "the polygon turns back on itself at point %zu",
                                  (i + 1) % n + 1);
    }
    for (size_t i = 0; i < n; i++)
        for (size_t k = i + 2; k < n && (i > 0 || k + 1 < n); k++)
            if (meet(p[i], p[(i + 1) % n], p[k], p[(k + 1) % n]))
                return rmap_error_set(err, RMAP_INPUT,
                                      "sides %zu and %zu of the polygon cross or touch: give its "
                                      "points in their order around it",
                                      i + 1, k + 1);
    return RMAP_OK;
}

/* An ear has an area and no other corner inside or on its edges, so that no triangle is flat and
 * the caps keep every corner that lies between two others. */
static bool is_ear(const struct point *p, const uint32_t *left, size_t n, size_t i)
{
    size_t before = (i + n - 1) % n, after = (i + 1) % n;
    struct point a = p[left[before]], b = p[left[i]], c = p[left[after]];
    if (!(turn(a, b, c) > 0))
        return false;
    for (size_t k = 0; k < n; k++) {
        if (k == before || k == i || k == after)
            continue;
        struct point q = p[left[k]];
        if (turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0)
            return false;
    }
    return true;
}

/* n - 2 triangles of a counter-clockwise polygon. False: rounding hides its ears. */
static bool cut_ears(const struct point *p, size_t n, uint32_t *left, uint32_t (*triangle)[3])
{
    size_t n_cut = 0;
    for (size_t i = 0; i < n; i++)
        left[i] = (uint32_t)i;
    for (size_t i = 0; n > 2;) {
        size_t tried = 0;
        while (tried < n && !is_ear(p, left, n, i)) {
            i = (i + 1) % n;
            tried++;
        }
        if (tried == n)
            return false;
        uint32_t *cut = triangle[n_cut++];
        cut[0] = left[(i + n - 1) % n];
        cut[1] = left[i];
        cut[2] = left[(i + 1) % n];
        n--;
        for (size_t k = i; k < n; k++)
            left[k] = left[k + 1];
        i %= n;
    }
    return true;
}

static void set_triangle(struct rmap_mesh *mesh, size_t t, size_t a, size_t b, size_t c,
                         size_t face)
{
    mesh->triangle[t][0] = (uint32_t)a;
    mesh->triangle[t][1] = (uint32_t)b;
    mesh->triangle[t][2] = (uint32_t)c;
    mesh->face[t] = (uint32_t)face;
}

/* p: counter-clockwise, and given the other way round if `turned`. */
static bool fill(struct rmap_mesh *mesh, const struct point *p, size_t n, float length, bool turned,
                 uint32_t *left)
{
    if (!cut_ears(p, n, left, mesh->triangle))
        return false;
    for (size_t i = 0; i < 2 * n; i++) {
        mesh->vertex[i][0] = (float)p[i % n].x;
        mesh->vertex[i][1] = (float)p[i % n].y;
        mesh->vertex[i][2] = i < n ? 0 : length;
    }
    for (size_t t = 0; t < n - 2; t++) {
        const uint32_t *cut = mesh->triangle[t];
        set_triangle(mesh, n - 2 + t, cut[0] + n, cut[1] + n, cut[2] + n, 1);
        set_triangle(mesh, t, cut[2], cut[1], cut[0], 0);
    }
    for (size_t k = 0, t = 2 * (n - 2); k < n; k++, t += 2) {
        size_t next = (k + 1) % n, face = 2 + (turned ? (2 * n - 2 - k) % n : k);
        set_triangle(mesh, t, k, next, next + n, face);
        set_triangle(mesh, t + 1, k, next + n, k + n, face);
    }
    return true;
}

enum rmap_status rmap_mesh_prism(const double (*corner)[2], size_t n, double length,
                                 struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *mesh = NULL;
    struct point *p = rmap_alloc(n, sizeof *p);
    uint32_t *left = rmap_alloc(n, sizeof *left);
    double area = 0, most = fabs(length);
    if (!p || !left) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a prism");
        goto out;
    }
    for (size_t i = 0; i < n; i++) {
        p[i] = (struct point){(double)(float)corner[i][0], (double)(float)corner[i][1]};
        most = fmax(most, fmax(fabs(corner[i][0]), fabs(corner[i][1])));
    }
    if (!(most < 1e30) || !(length > 1e-30)) {
        st = rmap_error_set(err, RMAP_INPUT, "a prism is at least 1e-30 long, and 1e30 at most");
        goto out;
    }
    RMAP_TRY(check_polygon(p, n, err));
    for (size_t i = 1; i + 1 < n; i++)
        area += turn(p[0], p[i], p[i + 1]);
    for (size_t i = 0; area < 0 && i < n / 2; i++) {
        struct point swap = p[i];
        p[i] = p[n - 1 - i];
        p[n - 1 - i] = swap;
    }
    RMAP_TRY(rmap_mesh_create(2 * n, 4 * n - 4, n + 2, &mesh, err));
    if (!fill(mesh, p, n, (float)length, area < 0, left)) {
        st = rmap_error_set(err, RMAP_INPUT,
                            "nothing is left of the polygon in single precision: its points lie "
                            "too near to each other");
        goto out;
    }
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_mesh_destroy(mesh);
    rmap_free(left);
    rmap_free(p);
    return st;
}
