/* SPDX-License-Identifier: MIT
 *
 * A scene with rays as glTF: bodies with materials by what their surfaces do, in metres, y
 * upwards; rays as lines, a node for each group of their paint.
 */
#include "analysis/page/scene_glb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "analysis/figure/figure_rays.h"
#include "analysis/figure/object_colour.h"
#include "analysis/figure/scene_mesh.h"
#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "io/export/glb.h"
#include "io/file/whole_file.h"
#include "portion/event.h"

/* A segment that leaves the scene, as a part of its radius. */
static const double LEAVING = 0.25;

struct build {
    const struct rmap_map *map;
    const struct rmap_scene *scene;
    const struct rmap_portion *rays;
    const struct rmap_ray_paint *paint;
    struct rmap_glb *glb;
    double (*colour)[3];          /* [n_object] linear RGB */
    size_t *material;             /* [n_surface] 1 + its index; 0: none yet */
    struct rmap_glb_shape *shape; /* [n_geometry] */
    size_t *last;                 /* [n_geometry] 1 + object that has it last; 0: none yet */
    struct made {
        size_t mesh, before; /* before: 1 + object that has the geometry before this one */
    } * made;                /* [n_object] */
};

/* That of the surface, in the colour of what it throws back. */
static enum rmap_status material_of(struct build *self, size_t object, size_t *index_ret,
                                    struct rmap_error *err)
{
    static const struct rmap_glb_material like[RMAP_LOOK_COUNT] = {
        [RMAP_LOOK_REFRACTING] = {"", {0.75, 0.87, 0.95, 0.3}, 0.0, 0.05},
        [RMAP_LOOK_MIRROR] = {"", {0.0, 0.0, 0.0, 1.0}, 1.0, 0.1},
        [RMAP_LOOK_OTHER] = {"", {0.0, 0.0, 0.0, 1.0}, 0.0, 0.9}};
    const size_t surface = (size_t)self->scene->object[object].surface_front;
    const enum rmap_look look = rmap_object_look(self->scene, object);
    struct rmap_glb_material its = like[look];
    size_t *known = &self->material[surface];
    enum rmap_status st = RMAP_OK;
    its.name = self->scene->surface[surface].name;
    for (int k = 0; k < 3 && look != RMAP_LOOK_REFRACTING; k++)
        its.colour[k] = self->colour[object][k];
    if (*known == 0) {
        st = rmap_glb_add_material(self->glb, &its, known, err);
        *known += st == RMAP_OK;
    }
    *index_ret = *known > 0 ? *known - 1 : 0;
    return st;
}

/* What glTF allows for: rotation, scales along the body's axes, mirroring. */
static bool is_plain(const struct rmap_affine *a)
{
    const struct rmap_vec3 x = rmap_affine_vector(a, rmap_vec3(1, 0, 0));
    const struct rmap_vec3 y = rmap_affine_vector(a, rmap_vec3(0, 1, 0));
    const struct rmap_vec3 z = rmap_affine_vector(a, rmap_vec3(0, 0, 1));
    const double most = 1e-6 * fmax(rmap_dot(x, x), fmax(rmap_dot(y, y), rmap_dot(z, z)));
    return fabs(rmap_dot(x, y)) <= most && fabs(rmap_dot(y, z)) <= most &&
           fabs(rmap_dot(z, x)) <= most;
}

static void matrix_of(const struct rmap_affine *a, double matrix[16])
{
    for (int k = 0; k < 4; k++) {
        const struct rmap_vec3 column =
            k == 3 ? a->t : rmap_affine_vector(a, rmap_vec3(k == 0, k == 1, k == 2));
        matrix[4 * k] = column.x;
        matrix[4 * k + 1] = column.y;
        matrix[4 * k + 2] = column.z;
        matrix[4 * k + 3] = k == 3;
    }
}

/* A skewed body has points of its own, where it stands. */
static enum rmap_status add_skewed(struct build *self, size_t object, const struct rmap_mesh *mesh,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_object *given = &self->scene->object[object];
    struct rmap_glb_shape shape;
    size_t index = 0, material = 0;
    float(*point)[3] = rmap_alloc(mesh->n_vertex + 1, sizeof *point);
    if (!point)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a glTF scene");
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        const struct rmap_vec3 p = rmap_affine_point(
            &given->to_world, rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
        point[i][0] = (float)p.x;
        point[i][1] = (float)p.y;
        point[i][2] = (float)p.z;
    }
    RMAP_TRY(rmap_glb_add_shape(self->glb, (const float(*)[3])point, mesh->n_vertex,
                                (const uint32_t(*)[3])mesh->triangle, mesh->n_triangle, &shape,
                                err));
    RMAP_TRY(material_of(self, object, &material, err));
    RMAP_TRY(rmap_glb_add_mesh(self->glb, given->name, &shape, material, &index, err));
    st = rmap_glb_place(self->glb, given->name, index, NULL, err);
out:
    rmap_free(point);
    return st;
}

static enum rmap_status add_object(struct build *self, size_t object, const struct rmap_mesh *mesh,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_object *given = &self->scene->object[object];
    const size_t geometry = (size_t)given->geometry;
    size_t like = self->last[geometry], material = 0; /* of one surface: one mesh */
    double matrix[16];
    if (mesh->n_triangle == 0)
        return RMAP_OK;
    if (!is_plain(&given->to_world))
        return add_skewed(self, object, mesh, err);
    if (like == 0)
        RMAP_TRY(rmap_glb_add_shape(self->glb, (const float(*)[3])mesh->vertex, mesh->n_vertex,
                                    (const uint32_t(*)[3])mesh->triangle, mesh->n_triangle,
                                    &self->shape[geometry], err));
    while (like > 0 && self->scene->object[like - 1].surface_front != given->surface_front)
        like = self->made[like - 1].before;
    if (like == 0) {
        RMAP_TRY(material_of(self, object, &material, err));
        RMAP_TRY(rmap_glb_add_mesh(self->glb, given->name, &self->shape[geometry], material,
                                   &self->made[object].mesh, err));
        self->made[object].before = self->last[geometry];
        self->last[geometry] = like = object + 1;
    }
    matrix_of(&given->to_world, matrix);
    st = rmap_glb_place(self->glb, given->name, self->made[like - 1].mesh, matrix, err);
out:
    return st;
}

static enum rmap_status add_objects(struct build *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh **mesh = NULL;
    self->shape = rmap_alloc(self->scene->n_geometry + 1, sizeof *self->shape);
    self->last = rmap_alloc(self->scene->n_geometry + 1, sizeof *self->last);
    self->made = rmap_alloc(self->scene->n_object + 1, sizeof *self->made);
    self->material = rmap_alloc(self->scene->n_surface + 1, sizeof *self->material);
    self->colour = rmap_object_colours(self->scene);
    if (!self->shape || !self->last || !self->made || !self->material || !self->colour)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a glTF scene"));
    RMAP_TRY(rmap_scene_meshes_create(self->scene, &mesh, err));
    for (size_t o = 0; o < self->scene->n_object; o++)
        RMAP_TRY(add_object(self, o, mesh[self->scene->object[o].geometry], err));
out:
    rmap_scene_meshes_destroy(mesh, self->scene->n_geometry);
    return st;
}

/* ---- rays ---- */

struct lines {
    float (*point)[3];
    uint8_t (*colour)[4];
    size_t n, cap, colour_cap; /* points */
};

static enum rmap_status add_line(struct lines *lines, const float from[3], const float to[3],
                                 const uint8_t rgba[4], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *block = lines->point;
    st = rmap_reserve(&block, &lines->cap, lines->n + 2, sizeof *lines->point, err);
    lines->point = block;
    RMAP_TRY(st);
    block = lines->colour;
    st = rmap_reserve(&block, &lines->colour_cap, lines->n + 2, sizeof *lines->colour, err);
    lines->colour = block;
    RMAP_TRY(st);
    for (size_t k = 0; k < 2; k++) {
        memcpy(lines->point[lines->n + k], k ? to : from, sizeof *lines->point);
        memcpy(lines->colour[lines->n + k], rgba, sizeof *lines->colour);
    }
    lines->n += 2;
out:
    return st;
}

/* Linear light of an sRGB byte (IEC 61966-2-1), as a byte. */
static uint8_t linear_byte(unsigned value)
{
    return (uint8_t)(255.0 * rmap_srgb_linear(value) + 0.5);
}

static void segment_colour(const struct build *self, const struct rmap_scene *scene, size_t ray,
                           size_t segment, uint8_t rgba[4])
{
    char ink[8];
    unsigned rgb = 0;
    if (self->paint->of_ray) {
        memcpy(ink, self->paint->group[self->paint->of_ray[ray]].ink, sizeof ink);
    } else {
        const int n_channel = self->rays->n_channel;
        const uint16_t *colour = self->rays->colour + segment * (size_t)n_channel;
        double share[RMAP_CHANNEL_MAX];
        for (int c = 0; c < scene->channels.n; c++)
            share[c] = c < n_channel ? colour[c] / 65535.0 : 0.0;
        rmap_ray_ink(scene, share, ink);
    }
    (void)sscanf(ink + 1, "%x", &rgb);
    for (int k = 0; k < 3; k++)
        rgba[k] = linear_byte(rgb >> (16 - 8 * k) & 255);
    rgba[3] = 255;
}

static enum rmap_status add_ray(const struct build *self, size_t ray, size_t segment,
                                struct lines *lines, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *rays = self->rays;
    const uint64_t id = rays->ray.id[ray];
    const struct rmap_scene *scene =
        rmap_map_scene_of(self->map, rmap_map_space_of_ray(self->map, id));
    const double leaving = LEAVING * scene->radius;
    size_t point = 0;
    const size_t n_point = rmap_portion_curve_of(rays, id, &point), end = point + n_point;
    const float *from = rays->ray.start + 3 * ray;
    for (size_t i = segment; i < segment + rays->ray.segment_count[ray]; i++) {
        uint8_t rgba[4];
        const float *to = rays->segment.position + 3 * i;
        float out[3];
        segment_colour(self, scene, ray, i, rgba);
        for (; point < end && rays->curve.segment[point] == i - segment; point++) {
            RMAP_TRY(add_line(lines, from, rays->curve.position + 3 * point, rgba, err));
            from = rays->curve.position + 3 * point;
        }
        if ((rays->segment.event[i] & (RMAP_EVENT_LEFT | RMAP_EVENT_GRADIENT)) == RMAP_EVENT_LEFT) {
            for (int k = 0; k < 3; k++)
                out[k] = (float)((double)from[k] +
                                 leaving * (double)rays->ray.end_direction[3 * ray + (size_t)k]);
            to = out;
        }
        RMAP_TRY(add_line(lines, from, to, rgba, err));
        from = rays->segment.position + 3 * i;
    }
out:
    return st;
}

/* Rays of a group, or all of them, in a node of their own. */
static enum rmap_status add_rays(struct build *self, size_t group, const char *name,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct lines lines = {0};
    size_t mesh = 0;
    for (size_t i = 0, segment = 0; i < self->rays->n_row[RMAP_TABLE_RAY];
         segment += self->rays->ray.segment_count[i++])
        if (!self->paint->of_ray || self->paint->of_ray[i] == group)
            RMAP_TRY(add_ray(self, i, segment, &lines, err));
    if (lines.n > 0) {
        RMAP_TRY(rmap_glb_add_lines(self->glb, name, (const float(*)[3])lines.point,
                                    (const uint8_t(*)[4])lines.colour, lines.n / 2, &mesh, err));
        st = rmap_glb_place(self->glb, name, mesh, NULL, err);
    }
out:
    rmap_free(lines.point);
    rmap_free(lines.colour);
    return st;
}

enum rmap_status rmap_scene_glb_write(const struct rmap_map *map, const struct rmap_portion *rays,
                                      const struct rmap_ray_paint *paint, const char *path,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    struct build self = {.map = map, .scene = rmap_map_scene(map), .rays = rays, .paint = paint};
    RMAP_TRY(
        rmap_glb_create(self.scene->unit_m, rmap_view_has_z_upright(self.scene), &self.glb, err));
    RMAP_TRY(add_objects(&self, err));
    for (size_t k = 0; k < paint->n_group; k++)
        RMAP_TRY(add_rays(&self, k, paint->group[k].label, err));
    if (paint->n_group == 0)
        RMAP_TRY(add_rays(&self, 0, "rays", err));
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    const char *suffix = strrchr(path, '.');
    RMAP_TRY(suffix && strcasecmp(suffix, ".gltf") == 0
                 ? rmap_gltf_write(self.glb, whole.file, err)
                 : rmap_glb_write(self.glb, whole.file, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    rmap_glb_destroy(self.glb);
    rmap_free(self.shape);
    rmap_free(self.last);
    rmap_free(self.made);
    rmap_free(self.material);
    rmap_free(self.colour);
    return st;
}
