/* SPDX-License-Identifier: MIT
 *
 * Detectors on curved surfaces and on faces of meshes, drawn where they count light.
 */
#include "analysis/figure/detector_faces.h"

#include <stdlib.h>
#include <string.h>

#include "analysis/figure/figure_outline.h"
#include "base/alloc.h"

/* Faces that are further from the detector's plane than this part of its size are not in it. */
static const double FLAT = 1e-3;

static const double CREASE_COS = 0.9397; /* cos 20 degrees, as of solids */

static bool lies_on(const struct rmap_scene *scene, const struct rmap_detector *detector,
                    size_t object)
{
    int32_t group = scene->object[object].parent;
    while (group >= 0 && group != detector->on_group)
        group = scene->group[group].parent;
    return detector->on_object == (int32_t)object || (detector->on_group >= 0 && group >= 0);
}

/* What is drawn, and on what. */
struct faces {
    const struct rmap_detector *detector;
    const struct rmap_view_frame *frame;
    const struct rmap_mesh *mesh;
    const struct rmap_affine *to_world;
    struct rmap_outline line;
    struct rmap_vec3 first; /* point of the lines */
};

static struct rmap_vec3 vertex_of(const struct faces *self, uint32_t vertex)
{
    const float *v = self->mesh->vertex[vertex];
    return rmap_affine_point(self->to_world, rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
}

static bool counts(const struct faces *self, size_t triangle)
{
    return !self->detector->face || self->detector->face[self->mesh->face[triangle]];
}

/* Whether all faces lie in the detector's plane. */
static bool is_flat(const struct faces *self)
{
    const struct rmap_detector *detector = self->detector;
    const double most = FLAT * fmax(detector->size[0], detector->size[1]);
    for (size_t t = 0; t < self->mesh->n_triangle; t++)
        for (int k = 0; k < 3 && counts(self, t); k++) {
            const struct rmap_vec3 at = vertex_of(self, self->mesh->triangle[t][k]);
            if (fabs(rmap_dot(rmap_sub(at, detector->origin), detector->axis)) > most)
                return false;
        }
    return true;
}

/* Height above the k-th of the planes that end the detector's size. */
static double inside(const struct rmap_detector *detector, struct rmap_vec3 at, int k)
{
    const struct rmap_vec3 across = k < 2 ? detector->x : detector->y;
    const double along = rmap_dot(rmap_sub(at, detector->origin), across);
    return 0.5 * detector->size[k / 2] + (k % 2 ? along : -along);
}
enum { N_SIDE = 4 };

/* The part of a line that lies within the detector's size and is seen; not by the plane `but`, in
 * which it lies, or -1. */
static enum rmap_status add_line(struct faces *self, struct rmap_vec3 from, struct rmap_vec3 to,
                                 int but, struct rmap_error *err)
{
    const struct rmap_view *view = self->frame->view;
    const double slack = 1e-6 * fmax(self->detector->size[0], self->detector->size[1]);
    const struct rmap_vec3 along = rmap_sub(to, from);
    enum rmap_status st = RMAP_OK;
    double first = 0.0, last = 1.0;
    for (int k = 0; k < N_SIDE; k++) {
        const double u = inside(self->detector, from, k) + slack;
        const double v = inside(self->detector, to, k) + slack;
        if (k == but)
            continue;
        if (u < 0.0 && v < 0.0)
            return RMAP_OK;
        if (u < 0.0)
            first = fmax(first, u / (u - v));
        else if (v < 0.0)
            last = fmin(last, u / (u - v));
    }
    struct rmap_vec3 end[2] = {rmap_axpy(first, along, from), rmap_axpy(last, along, from)};
    if (first >= last || !rmap_view_clip(view, &end[0], &end[1]))
        return RMAP_OK;
    if (self->line.n_run == 0)
        self->first = end[0];
    RMAP_TRY(rmap_outline_begin(&self->line, err));
    for (int k = 0; k < 2; k++) {
        const struct rmap_vec3 p = rmap_view_project(view, end[k]);
        RMAP_TRY(rmap_outline_add(&self->line, p.x, p.y, err));
    }
out:
    return st;
}

struct edge {
    uint32_t end[2]; /* vertices, the smaller first */
    struct rmap_vec3 normal;
};

static int by_ends(const void *a, const void *b)
{
    return memcmp(((const struct edge *)a)->end, ((const struct edge *)b)->end,
                  sizeof((const struct edge *)a)->end);
}

/* Edges of one face alone, and those between two that are inclined to each other. edge: [3
 * n_triangle]. */
static enum rmap_status add_rims(struct faces *self, struct edge *edge, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    for (size_t t = 0; t < self->mesh->n_triangle; t++) {
        const uint32_t *v = self->mesh->triangle[t];
        const struct rmap_vec3 a = vertex_of(self, v[0]);
        const struct rmap_vec3 normal = rmap_normalize(
            rmap_cross(rmap_sub(vertex_of(self, v[1]), a), rmap_sub(vertex_of(self, v[2]), a)));
        for (int k = 0; k < 3 && counts(self, t); k++) {
            const uint32_t p = v[k], q = v[(k + 1) % 3];
            edge[n++] = (struct edge){{p < q ? p : q, p < q ? q : p}, normal};
        }
    }
    qsort(edge, n, sizeof *edge, by_ends);
    for (size_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && by_ends(&edge[i], &edge[next]) == 0;)
            next++;
        if (next - i != 2 || rmap_dot(edge[i].normal, edge[i + 1].normal) < CREASE_COS)
            RMAP_TRY(add_line(self, vertex_of(self, edge[i].end[0]),
                              vertex_of(self, edge[i].end[1]), -1, err));
    }
out:
    return st;
}

/* Where a plane cuts the faces: the k-th end of the detector's size, or with -1 the view's. */
static enum rmap_status add_cut(struct faces *self, int side, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t t = 0; t < self->mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3], cut[3];
        double height[3];
        int n = 0;
        for (int k = 0; k < 3 && counts(self, t); k++) {
            corner[k] = vertex_of(self, self->mesh->triangle[t][k]);
            height[k] = side < 0 ? rmap_view_place(self->frame->view, corner[k]).z
                                 : inside(self->detector, corner[k], side);
        }
        for (int k = 0; k < 3 && counts(self, t); k++) {
            const int next = (k + 1) % 3;
            if ((height[k] < 0.0) != (height[next] < 0.0))
                cut[n++] = rmap_axpy(height[k] / (height[k] - height[next]),
                                     rmap_sub(corner[next], corner[k]), corner[k]);
        }
        if (n == 2)
            RMAP_TRY(add_line(self, cut[0], cut[1], side, err));
    }
out:
    return st;
}

static enum rmap_status add_outlines(struct faces *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct edge *edge = rmap_alloc(3 * self->mesh->n_triangle + 1, sizeof *edge);
    if (!edge)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    RMAP_TRY(add_rims(self, edge, err));
    for (int k = 0; k < N_SIDE; k++)
        RMAP_TRY(add_cut(self, k, err));
out:
    rmap_free(edge);
    return st;
}

enum rmap_status rmap_detector_faces_draw(const struct rmap_scene *scene,
                                          struct rmap_mesh *const *mesh,
                                          const struct rmap_view_frame *frame, size_t index,
                                          const struct rmap_svg_style *style, struct rmap_svg *svg,
                                          bool *flat_ret, struct rmap_vec3 *at,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct faces self = {.detector = &scene->detector[index],
                         .frame = frame,
                         .first = {(double)NAN, (double)NAN, (double)NAN}};
    *flat_ret = true;
    for (size_t o = 0; o < scene->n_object; o++) {
        if (!lies_on(scene, self.detector, o))
            continue;
        self.mesh = mesh[scene->object[o].geometry];
        self.to_world = &scene->object[o].to_world;
        if (is_flat(&self))
            continue;
        *flat_ret = false;
        RMAP_TRY(frame->view->section ? add_cut(&self, -1, err) : add_outlines(&self, err));
    }
    *flat_ret = *flat_ret || (self.line.n_run == 0 && !frame->view->section);
    if (!*flat_ret) {
        *at = self.first;
        st = rmap_outline_draw(&self.line, 0, self.line.n_run, frame, svg, style, err);
    }
out:
    rmap_outline_fini(&self.line);
    return st;
}
