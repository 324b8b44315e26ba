/* SPDX-License-Identifier: MIT
 *
 * Discomfort glare of an observer by luminaires.
 */
#include "analysis/photometry/glare.h"

#include <math.h>

#include "analysis/photometry/position_index.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "io/map/map_dim.h"
#include "render/light.h"

enum { POINTS = 12, SURFACES_MOST = 64 }; /* along each side of what is looked at; on a way */

static const char *const role_word[] = {
    [RMAP_GLARE_COUNTS] = "counts",      [RMAP_GLARE_OFF] = "off",
    [RMAP_GLARE_TURNED] = "turned away", [RMAP_GLARE_OUTSIDE] = "out of view",
    [RMAP_GLARE_HIDDEN] = "hidden",      [RMAP_GLARE_UNKNOWN] = "no opening"};

enum rmap_status rmap_glare_view_init(struct rmap_vec3 at, struct rmap_vec3 look,
                                      struct rmap_vec3 up, struct rmap_glare_view *view,
                                      struct rmap_error *err)
{
    const double length = rmap_length(look);
    if (!(length > 0.0) || !isfinite(length))
        return rmap_error_set(err, RMAP_USAGE, "the line of sight has no direction");
    view->at = at;
    view->look = rmap_scale(look, 1.0 / length);
    const struct rmap_vec3 across = rmap_axpy(-rmap_dot(up, view->look), view->look, up);
    const double height = rmap_length(across);
    if (!(height > 1e-9 * rmap_length(up)))
        return rmap_error_set(err, RMAP_USAGE,
                              "who looks straight up or down has no up: say --up X,Y,Z");
    view->up = rmap_scale(across, 1.0 / height);
    return RMAP_OK;
}

struct looking {
    const struct rmap_scene *scene;
    const struct rmap_accel *accel;
    const struct rmap_lights *lights;
    const struct rmap_glare_view *view;
};

/* Nothing opaque stands between; what lets light through is taken for clear. */
static bool is_seen(const struct looking *self, struct rmap_vec3 point)
{
    const struct rmap_vec3 way = rmap_sub(point, self->view->at);
    const double length = rmap_length(way), end = length * (1.0 - 1e-6);
    struct rmap_ray ray = {.origin = self->view->at,
                           .direction = rmap_scale(way, 1.0 / length),
                           .medium = rmap_scene_surrounding_medium(self->scene)};
    struct rmap_hit hit;
    double gone = 0.0;
    for (int k = 0; k < SURFACES_MOST; k++) {
        if (gone >= end || !rmap_accel_next_within(self->accel, &ray, end - gone, &hit))
            return true;
        const struct rmap_object *object = &self->scene->object[hit.object];
        if (gone + hit.t < end && !rmap_scene_transmits(self->scene, object->surface_front) &&
            !rmap_scene_transmits(self->scene, object->surface_back))
            return false;
        gone += hit.t;
        ray.origin = hit.position;
        rmap_contact_pass(&ray.contact, &hit);
    }
    return false;
}

/* The share of a flat or curved opening that is seen, by a grid of its points. */
static double share_seen(const struct looking *self, const struct rmap_light *light,
                         struct rmap_vec3 towards)
{
    const struct rmap_source *source = light->source;
    const struct rmap_affine *frame = &source->frame;
    const struct rmap_vec3 back = rmap_affine_vector(&light->to_local, rmap_scale(towards, -1.0));
    size_t seen = 0;
    for (int i = 0; i < POINTS * POINTS; i++) {
        const double u[3] = {(i % POINTS + 0.5) / POINTS, ((double)(i / POINTS) + 0.5) / POINTS,
                             fmod(0.5 + i * 0.6180339887498949, 1.0)};
        const double *size = source->shape_size, r = size[0] * sqrt(u[0]);
        const struct rmap_vec3 point =
            source->shape == RMAP_EMITTER_BODY ? rmap_lamp_point(source->lamp, back, u)
            : source->shape == RMAP_EMITTER_DISC
                ? rmap_vec3(r * cos(2.0 * RMAP_PI * u[1]), r * sin(2.0 * RMAP_PI * u[1]), 0.0)
                : rmap_vec3(size[0] * (u[0] - 0.5), size[1] * (u[1] - 0.5), 0.0);
        seen += (size_t)is_seen(self, rmap_affine_point(frame, point));
    }
    return (double)seen / (POINTS * POINTS);
}

/* Its triangles: area as it is seen, in the scene's unit, and the share that nothing hides. */
static double mesh_seen(const struct looking *self, const struct rmap_source *source,
                        double *visible)
{
    const struct rmap_mesh *mesh = self->scene->geometry[source->shape_geometry].mesh;
    double all = 0.0, seen = 0.0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        rmap_mesh_corners(mesh, t, corner);
        for (int k = 0; k < 3; k++)
            corner[k] = rmap_affine_point(&source->frame, corner[k]);
        const struct rmap_vec3 middle =
            rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3.0);
        const struct rmap_vec3 way = rmap_sub(middle, self->view->at);
        const double area =
            -0.5 / rmap_length(way) *
            rmap_dot(rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0])),
                     way);
        all += fmax(area, 0.0);
        seen += area > 0.0 && is_seen(self, middle) ? area : 0.0;
    }
    *visible = all > 0.0 ? seen / all : 0.0;
    return all;
}

/* Square units that are seen of it in this direction; 0: its luminance is not known. */
static double area_seen(const struct looking *self, const struct rmap_light *light,
                        struct rmap_vec3 towards, double *visible)
{
    const struct rmap_source *source = light->source;
    if (source->shape == RMAP_EMITTER_MESH)
        return mesh_seen(self, source, visible);
    *visible = share_seen(self, light, towards);
    if (source->shape != RMAP_EMITTER_BODY)
        return light->area * fmax(-rmap_dot(light->normal, towards), 0.0);
    return rmap_lamp_seen_area(source->lamp,
                               rmap_affine_vector(&light->to_local, rmap_scale(towards, -1.0)));
}

/* NULL: no area whose luminance is known. */
static const struct rmap_light *find_light(const struct rmap_lights *lights,
                                           const struct rmap_source *source)
{
    for (size_t l = 0; l < lights->n; l++) {
        const struct rmap_light *light = &lights->light[l];
        if (light->source != source)
            continue;
        const bool area = source->type == RMAP_SOURCE_AREA && !rmap_source_is_directed(source);
        const bool body = source->type == RMAP_SOURCE_LAMP && source->shape == RMAP_EMITTER_BODY &&
                          source->lamp->body != RMAP_LAMP_POINT;
        return area || body ? light : NULL;
    }
    return NULL;
}

static void look_at(const struct looking *self, const struct rmap_map *map,
                    struct rmap_glare_light *to)
{
    const struct rmap_source *source = &self->scene->source[to->source];
    const struct rmap_light *light = find_light(self->lights, source);
    const struct rmap_glare_view *view = self->view;
    const struct rmap_vec3 middle = light && source->shape == RMAP_EMITTER_MESH
                                        ? light->centre
                                        : rmap_source_place(self->scene, source);
    const struct rmap_vec3 way = rmap_sub(middle, view->at);
    const double distance = rmap_length(way), along = rmap_dot(way, view->look),
                 unit_m = self->scene->unit_m;
    to->distance_m = distance * unit_m;
    to->aside = fabs(rmap_dot(way, rmap_cross(view->look, view->up))) / along;
    to->above = fabs(rmap_dot(way, view->up)) / along;
    to->role = RMAP_GLARE_UNKNOWN;
    if (!light)
        return;
    to->role = RMAP_GLARE_OFF;
    if (!(rmap_map_dimmed(map, to->source) > 0.0))
        return;
    to->role = RMAP_GLARE_OUTSIDE;
    to->position_index = along > 0.0 ? rmap_position_index(to->aside, to->above) : 0.0;
    if (!(to->position_index > 0.0))
        return;
    const struct rmap_vec3 towards = rmap_scale(way, 1.0 / distance);
    const double area = area_seen(self, light, towards, &to->visible);
    to->luminance = area > 0.0 ? rmap_light_radiance(self->lights, light, towards) *
                                     rmap_map_dimmed(map, to->source)
                               : 0.0;
    to->role = RMAP_GLARE_TURNED;
    if (!(to->luminance > 0.0))
        return;
    to->solid_angle = to->visible * area / (distance * distance);
    to->role = to->visible > 0.0 ? RMAP_GLARE_COUNTS : RMAP_GLARE_HIDDEN;
    to->part =
        to->luminance * to->luminance * to->solid_angle / (to->position_index * to->position_index);
}

enum rmap_status rmap_glare_look(const struct rmap_map *map, const struct rmap_accel *accel,
                                 const struct rmap_glare_view *view, struct rmap_glare **glare_ret,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_lights *lights = NULL;
    struct rmap_glare *glare = rmap_alloc(1, sizeof *glare);
    if (scene->flux_unit != RMAP_FLUX_LM)
        RMAP_TRY(
            rmap_error_set(err, RMAP_INPUT,
                           "glare is of luminances, and the sources are in %s: give their flux "
                           "in lm, and trace anew",
                           rmap_flux_unit_name(scene)));
    if (glare)
        glare->light = rmap_alloc(scene->n_source + 1, sizeof *glare->light);
    if (!glare || !glare->light)
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", scene->n_source));
    RMAP_TRY(rmap_lights_create(scene, &lights, err));
    glare->view = *view;
    glare->scene = scene;
    const struct looking self = {scene, accel, lights, &glare->view};
    for (size_t s = 0; s < scene->n_source; s++) {
        const enum rmap_source_type type = scene->source[s].type;
        if (type == RMAP_SOURCE_SKY || type == RMAP_SOURCE_SUN)
            continue;
        struct rmap_glare_light *to = &glare->light[glare->n_light++];
        *to = (struct rmap_glare_light){.source = s};
        look_at(&self, map, to);
        glare->sum += to->part;
    }
    glare->indirect = glare->indirect_error = (double)NAN;
    *glare_ret = glare;
    glare = NULL;
out:
    rmap_lights_destroy(lights);
    rmap_glare_destroy(glare);
    return st;
}

void rmap_glare_conclude(struct rmap_glare *glare, double background, double background_error)
{
    const bool known = background > 0.0 && glare->sum > 0.0;
    glare->background = background;
    glare->ugr = known ? 8.0 * log10(0.25 / background * glare->sum) : (double)NAN;
    glare->ugr_error = known ? 8.0 / log(10.0) * background_error / background : (double)NAN;
}

void rmap_glare_destroy(struct rmap_glare *glare)
{
    if (glare)
        rmap_free(glare->light);
    rmap_free(glare);
}

static void print_estimate(const char *name, double value, double error, const char *unit,
                           FILE *out)
{
    fprintf(out, "%-14s %.4g", name, value);
    if (isfinite(error))
        fprintf(out, " +- %.2g", error);
    fprintf(out, "%s", unit);
}

static enum rmap_status print_lights(const struct rmap_glare *glare, FILE *out,
                                     struct rmap_error *err)
{
    static const char *const head[] = {"luminaire",        "distance, m", "T/R",  "H/R",        "p",
                                       "luminance, cd/m2", "sr",          "seen", "of the sum", ""};
    enum { COLUMNS = sizeof head / sizeof *head };
    struct rmap_text_table table;
    rmap_text_table_init(&table, COLUMNS);
    for (size_t k = 0; k < COLUMNS; k++)
        rmap_text_table_add(&table, "%s", head[k]);
    for (size_t l = 0; l < glare->n_light; l++) {
        const struct rmap_glare_light *of = &glare->light[l];
        const bool counts = of->role == RMAP_GLARE_COUNTS;
        rmap_text_table_add(&table, "%s", glare->scene->source[of->source].name);
        rmap_text_table_add(&table, "%.3f", of->distance_m);
        const double number[] = {of->aside, of->above, of->position_index, of->luminance,
                                 of->solid_angle};
        for (int k = 0; k < 5; k++)
            rmap_text_table_add(&table, counts ? "%.4g" : "", number[k]);
        rmap_text_table_add(&table, counts ? "%.0f %%" : "", 100.0 * of->visible);
        rmap_text_table_add(&table, counts ? "%.1f %%" : "", 100.0 * of->part / glare->sum);
        rmap_text_table_add(&table, "%s", counts ? "" : role_word[of->role]);
    }
    const enum rmap_status st = rmap_text_table_print(&table, "lrrrrrrrrl", out, err);
    rmap_text_table_fini(&table);
    return st;
}

enum rmap_status rmap_glare_print(const struct rmap_glare *glare, FILE *out, struct rmap_error *err)
{
    const struct rmap_glare_view *view = &glare->view;
    fprintf(out, "%-14s at (%.6g, %.6g, %.6g) %s, looks along (%.4g, %.4g, %.4g)\n", "observer",
            view->at.x, view->at.y, view->at.z, glare->scene->unit, view->look.x, view->look.y,
            view->look.z);
    if (isfinite(glare->indirect)) {
        print_estimate("indirect", glare->indirect, glare->indirect_error, " lx on the eye", out);
        fprintf(out, ", of %.0f registrations\n", glare->registrations);
    }
    print_estimate("background", glare->background, glare->indirect_error / RMAP_PI, " cd/m2\n",
                   out);
    if (isfinite(glare->ugr))
        print_estimate("UGR", glare->ugr, glare->ugr_error, "\n", out);
    else
        fprintf(out, "%-14s none: %s\n", "UGR",
                glare->sum > 0.0 ? "no indirect light comes to the eye; more rays, a larger --eye, "
                                   "or --background"
                                 : "no luminaire counts");
    fputc('\n', out);
    return print_lights(glare, out, err);
}

static json_t *vector(struct rmap_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

json_t *rmap_glare_json(const struct rmap_glare *glare)
{
    json_t *list = json_array();
    for (size_t l = 0; l < glare->n_light; l++) {
        const struct rmap_glare_light *of = &glare->light[l];
        json_t *light =
            json_pack("{s:s, s:s, s:o}", "source", glare->scene->source[of->source].name, "role",
                      role_word[of->role], "distance", rmap_json_number(of->distance_m));
        if (light && of->role == RMAP_GLARE_COUNTS) {
            const char *const key[] = {
                "aside", "above", "position_index", "luminance", "solid_angle", "visible", "part"};
            const double number[] = {of->aside,     of->above,       of->position_index,
                                     of->luminance, of->solid_angle, of->visible,
                                     of->part};
            for (size_t k = 0; k < sizeof key / sizeof *key; k++)
                (void)json_object_set_new(light, key[k], rmap_json_number(number[k]));
        }
        (void)json_array_append_new(list, light);
    }
    return json_pack(
        "{s:{s:o, s:o, s:o}, s:{s:o, s:o, s:s}, s:o, s:{s:o, s:o}, s:o, s:o}", "observer", "at",
        vector(glare->view.at), "direction", vector(glare->view.look), "up", vector(glare->view.up),
        "indirect", "value", rmap_json_number(glare->indirect), "standard_error",
        rmap_json_number(glare->indirect_error), "unit", "lx", "background",
        rmap_json_number(glare->background), "ugr", "value", rmap_json_number(glare->ugr),
        "standard_error", rmap_json_number(glare->ugr_error), "sum", rmap_json_number(glare->sum),
        "luminaires", list);
}
