/* SPDX-License-Identifier: MIT
 *
 * What is in a scene, for `raymap check`.
 */
#include "mpi/answer/scene_summary.h"

#include <math.h>

#include "base/grouped.h"
#include "io/export/json_number.h"
#include "mpi/answer/lamp_sheet_out.h"
#include "mpi/answer/medium_out.h"
#include "mpi/answer/steps_out.h"
#include "mpi/answer/surface_out.h"
#include "mpi/command/balance.h"
#include "mpi/parallel/progress.h"
#include "scene/bounds.h"
#include "scene/paraxial.h"

enum { SHOWN_MAX = 12 };

static struct rmap_bounds bounds(const struct rmap_scene *scene)
{
    struct rmap_bounds box = rmap_bounds_empty();
    for (size_t o = 0; o < scene->n_object; o++) {
        box.lower = rmap_least(box.lower, scene->object_bounds[o].lower);
        box.upper = rmap_greatest(box.upper, scene->object_bounds[o].upper);
    }
    return box;
}

/* Triangles of all instances together. */
static uint64_t triangles(const struct rmap_scene *scene)
{
    uint64_t n = 0;
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_geometry *geometry = &scene->geometry[scene->object[o].geometry];
        n += geometry->kind == RMAP_GEOMETRY_MESH ? geometry->mesh->n_triangle : 0;
    }
    return n;
}

static void print_names(FILE *out, const char *what, size_t n,
                        const char *(*name)(const void *, size_t), const struct rmap_scene *scene)
{
    fprintf(out, "  %-10s %5zu ", what, n);
    for (size_t i = 0; i < n && i < SHOWN_MAX; i++)
        fprintf(out, " %s", name(scene, i));
    fputs(n > SHOWN_MAX ? " ...\n" : "\n", out);
}

/* name_FIELD(scene, i): the name of the scene's i-th FIELD. */
#define NAME_OF(field)                                                                             \
    static const char *name_##field(const void *scene, size_t i)                                   \
    {                                                                                              \
        return ((const struct rmap_scene *)scene)->field[i].name;                                  \
    }
NAME_OF(medium)
NAME_OF(film)
NAME_OF(surface)
NAME_OF(geometry)
NAME_OF(object)
NAME_OF(group)
NAME_OF(source)
NAME_OF(detector)
NAME_OF(camera)
#undef NAME_OF

static const char *mode_text(const struct rmap_scene *scene)
{
    return scene->channels.mode == RMAP_COLOUR_RGB ? "rgb" : "spectral";
}

static void print_lamp(const struct rmap_scene *scene, const struct rmap_source *source, FILE *out)
{
    static const char *const body[] = {"a point", "a box", "a cylinder", "an ellipsoid"};
    const struct rmap_lamp *lamp = source->lamp;
    if (lamp->title[0])
        fprintf(out, ", '%s'", lamp->title);
    if (source->shape != RMAP_EMITTER_BODY)
        fprintf(out, ", from a mesh");
    else
        fprintf(out, ", from %s", body[lamp->body]);
    if (source->shape == RMAP_EMITTER_BODY && lamp->body != RMAP_LAMP_POINT)
        fprintf(out, " of %.4g x %.4g x %.4g %s", lamp->size[0], lamp->size[1], lamp->size[2],
                scene->unit);
    struct rmap_lamp_sheet sheet;
    rmap_lamp_sheet_of(scene, source, NULL, &sheet);
    fputs(", ", out);
    rmap_lamp_sheet_line(&sheet, out);
}

/* Its pole, what it is, and where its light comes in. */
static void print_sky(const struct rmap_scene *scene, const struct rmap_source *source, FILE *out)
{
    const struct rmap_sky *sky = source->sky;
    fprintf(out, "%s%s", sky->title[0] ? ", " : "", sky->title);
    if (sky->n_portal > 0)
        fprintf(out, ", through %s; light that meets none is left out",
                rmap_counted(sky->n_portal, "portal").text);
    else
        fprintf(out, ", by discs of radius %.4g %s", source->shape_size[0], scene->unit);
}

static void print_light(const struct rmap_scene *scene, FILE *out)
{
    for (size_t s = 0; s < scene->n_source; s++) {
        fprintf(out, "    source %s: %.6g %s in '%s'", scene->source[s].name, scene->source[s].flux,
                scene->source[s].steps ? "photons" : rmap_flux_unit_name(scene),
                scene->medium[scene->source[s].medium].name);
        if (scene->source[s].sky)
            print_sky(scene, &scene->source[s], out);
        if (scene->source[s].type == RMAP_SOURCE_LAMP)
            print_lamp(scene, &scene->source[s], out);
        if (scene->source[s].steps)
            rmap_steps_print(scene->source[s].steps, out);
        fputc('\n', out);
    }
    for (size_t m = 0; m < scene->n_medium; m++)
        if (scene->medium[m].description)
            fprintf(out, "    medium %s: %s\n", scene->medium[m].name,
                    scene->medium[m].description);
}

/* The channel in the middle, for which first-order numbers are. */
static int middle_channel(const struct rmap_scene *scene)
{
    return scene->channels.n / 2;
}

/* Of dispersive media, on the channel in the middle. */
static void print_group_indices(const struct rmap_scene *scene, FILE *out)
{
    const int k = middle_channel(scene);
    for (size_t m = 0; m < scene->n_medium; m++)
        if (scene->medium[m].n_group[k] != scene->medium[m].n[k])
            fprintf(out, "    medium %s: n %.6f, group index %.6f at %g nm\n",
                    scene->medium[m].name, scene->medium[m].n[k], scene->medium[m].n_group[k],
                    scene->channels.wavelength_nm[k]);
}

static void print_absorption(const struct rmap_scene *scene, FILE *out)
{
    const int k = middle_channel(scene);
    for (size_t m = 0; m < scene->n_medium; m++) {
        const double mu = scene->medium[m].absorption[k];
        if (scene->medium[m].absorbing && mu > 0.0)
            fprintf(out, "    medium %s: absorption %.4g / %s%s, 1/e in %.4g %s\n",
                    scene->medium[m].name, mu, scene->unit,
                    scene->channels.mode == RMAP_COLOUR_SPECTRAL ? " in the middle" : " of green",
                    1.0 / mu, scene->unit);
    }
}

static const char *scheme_text(enum rmap_scheme scheme)
{
    switch (scheme) {
    case RMAP_SCHEME_SHARMA:
        return "sharma";
    case RMAP_SCHEME_SHARMA_FIXED:
        return "fixed";
    case RMAP_SCHEME_INTEGRATED:
        return "integrated";
    default:
        return "adaptive";
    }
}

/* Gradient media where they stand, and how light is traced through them. */
static void print_gradients(const struct rmap_scene *scene, FILE *out)
{
    for (size_t i = 0; i < scene->n_gradient && i < SHOWN_MAX; i++) {
        const struct rmap_gradient *g = &scene->gradient[i];
        const struct rmap_vec3 at = g->to_world.t;
        fprintf(out, "    gradient %s: frame at (%.6g, %.6g, %.6g), size %.6g %s, ",
                scene->medium[g->medium].name, at.x, at.y, at.z, g->size, scene->unit);
        fprintf(out, "%s, tolerance %.3g %s\n", scheme_text(g->options.scheme),
                g->options.tolerance, scene->unit);
    }
    if (scene->n_gradient > SHOWN_MAX)
        fprintf(out, "    ... and %zu other places of gradient media\n",
                scene->n_gradient - SHOWN_MAX);
}

static const char *const meridian_name[2] = {"x", "y"};

static void print_lens(const struct rmap_scene *scene, const struct rmap_paraxial *p, FILE *out)
{
    if (isinf(p->focal_length)) {
        fputs("no power\n", out);
        return;
    }
    fprintf(out, "EFL %.6g, BFL %.6g, f/%.4g, half field %.3g deg\n", p->focal_length,
            p->back_focus, p->f_number, p->field_deg);
    fprintf(out,
            "      entrance pupil %.5g wide, at %.5g from the first vertex; exit pupil %.5g wide, "
            "at %.5g from the last; stop: %s\n",
            p->entrance_diameter, p->entrance, p->exit_diameter, p->exit,
            scene->object[p->stop].name);
}

static void print_lenses(const struct rmap_scene *scene, FILE *out)
{
    const int channel = middle_channel(scene);
    struct rmap_paraxial p[2];
    char light[32] = "";
    size_t n = 0;
    if (scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        (void)snprintf(light, sizeof light, " at %.6g nm", scene->channels.wavelength_nm[channel]);
    for (size_t g = 0; g < scene->n_group && n < SHOWN_MAX; g++) {
        const int n_meridian = rmap_paraxial_of(scene, (int32_t)g, channel, p);
        if (n_meridian > 0 && n++ == 0)
            fprintf(out, "  lenses, first order%s, %s\n", light, scene->unit);
        for (int k = 0; k < n_meridian; k++) {
            fprintf(out, "    %s%s%s: ", scene->group[g].name, n_meridian > 1 ? ", along " : "",
                    n_meridian > 1 ? meridian_name[k] : "");
            print_lens(scene, &p[k], out);
        }
    }
}

void rmap_scene_summary_print(const struct rmap_scene *scene, FILE *out)
{
    const struct rmap_channels *channels = &scene->channels;
    char count[RMAP_GROUPED_LEN];
    fprintf(out, "  units      %s\n  light      %s, %s", scene->unit, mode_text(scene),
            rmap_counted((uint64_t)channels->n, "channel").text);
    if (channels->mode == RMAP_COLOUR_SPECTRAL)
        fprintf(out, ", %.6g to %.6g nm", channels->wavelength_nm[0],
                channels->wavelength_nm[channels->n - 1]);
    fputc('\n', out);
    print_names(out, "media", scene->n_medium, name_medium, scene);
    if (scene->n_film > 0)
        print_names(out, "films", scene->n_film, name_film, scene);
    print_names(out, "surfaces", scene->n_surface, name_surface, scene);
    print_names(out, "geometries", scene->n_geometry, name_geometry, scene);
    print_names(out, "objects", scene->n_object, name_object, scene);
    print_names(out, "groups", scene->n_group, name_group, scene);
    print_names(out, "sources", scene->n_source, name_source, scene);
    print_names(out, "detectors", scene->n_detector, name_detector, scene);
    if (scene->n_camera > 0)
        print_names(out, "cameras", scene->n_camera, name_camera, scene);
    print_light(scene, out);
    print_group_indices(scene, out);
    print_absorption(scene, out);
    rmap_films_print(scene, out);
    rmap_scatters_print(scene, out);
    rmap_turbid_print(scene, out);
    print_lenses(scene, out);
    print_gradients(scene, out);
    fprintf(out, "  triangles  %s in all instances\n", rmap_grouped(triangles(scene), count));
    if (scene->n_object > 0) {
        struct rmap_bounds box = bounds(scene);
        fprintf(out, "  box        (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) %s\n", box.lower.x,
                box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z, scene->unit);
    }
}

static json_t *names_json(const struct rmap_scene *scene, size_t n,
                          const char *(*name)(const void *, size_t))
{
    json_t *list = json_array();
    for (size_t i = 0; i < n; i++)
        (void)json_array_append_new(list, json_string(name(scene, i)));
    return list;
}

static json_t *light_json(const struct rmap_scene *scene)
{
    json_t *wavelengths = json_array();
    for (int c = 0; c < scene->channels.n && scene->channels.mode == RMAP_COLOUR_SPECTRAL; c++)
        (void)json_array_append_new(wavelengths, json_real(scene->channels.wavelength_nm[c]));
    return json_pack("{s:s, s:i, s:o}", "mode", mode_text(scene), "channels", scene->channels.n,
                     "wavelengths", wavelengths);
}

/* meridian: NULL: all are alike. */
static json_t *lens_json(const struct rmap_scene *scene, size_t group, int channel,
                         const struct rmap_paraxial *p, const char *meridian)
{
    json_t *json = json_pack(
        "{s:s, s:o, s:I, s:o, s:o, s:o, s:s, s:{s:o, s:o}, s:{s:o, s:o}, s:o, s:o}", "name",
        scene->group[group].name, "wavelength",
        scene->channels.mode == RMAP_COLOUR_SPECTRAL
            ? json_real(scene->channels.wavelength_nm[channel])
            : json_null(),
        "surfaces", (json_int_t)p->n_surface, "focal_length", rmap_json_number(p->focal_length),
        "back_focus", rmap_json_number(p->back_focus), "front_focus",
        rmap_json_number(p->front_focus), "stop", scene->object[p->stop].name, "entrance_pupil",
        "from_first_vertex", rmap_json_number(p->entrance), "diameter",
        rmap_json_number(p->entrance_diameter), "exit_pupil", "from_last_vertex",
        rmap_json_number(p->exit), "diameter", rmap_json_number(p->exit_diameter), "f_number",
        rmap_json_number(p->f_number), "half_field", rmap_json_number(p->field_deg));
    if (meridian)
        (void)json_object_set_new(json, "meridian", json_string(meridian));
    return json;
}

static json_t *lenses_json(const struct rmap_scene *scene)
{
    const int channel = middle_channel(scene);
    struct rmap_paraxial p[2];
    json_t *list = json_array();
    for (size_t g = 0; g < scene->n_group; g++) {
        const int n = rmap_paraxial_of(scene, (int32_t)g, channel, p);
        for (int k = 0; k < n; k++)
            (void)json_array_append_new(
                list, lens_json(scene, g, channel, &p[k], n > 1 ? meridian_name[k] : NULL));
    }
    return list;
}

/* Of all media, by the wavelengths of the scene's light. */
static json_t *indices_json(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t m = 0; m < scene->n_medium; m++) {
        json_t *n = json_array(), *group = json_array();
        for (int i = 0; i < scene->channels.n; i++) {
            (void)json_array_append_new(n, rmap_json_number(scene->medium[m].n[i]));
            (void)json_array_append_new(group, rmap_json_number(scene->medium[m].n_group[i]));
        }
        (void)json_array_append_new(list,
                                    json_pack("{s:s, s:o, s:o}", "medium", scene->medium[m].name,
                                              "n", n, "group_index", group));
    }
    return list;
}

static json_t *gradients_json(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_gradient; i++) {
        const struct rmap_gradient *g = &scene->gradient[i];
        const struct rmap_vec3 at = g->to_world.t;
        (void)json_array_append_new(
            list, json_pack("{s:s, s:s, s:[f,f,f], s:f, s:s, s:f, s:f, s:f}", "medium",
                            scene->medium[g->medium].name, "model", g->field->ops->model, "at",
                            at.x, at.y, at.z, "size", g->size, "scheme",
                            scheme_text(g->options.scheme), "tolerance", g->options.tolerance,
                            "sag", g->options.sag, "polyline", g->options.polyline));
    }
    return list;
}

/* NULL: the scene has no lamps. */
static json_t *lamps_json(const struct rmap_scene *scene)
{
    json_t *list = NULL;
    for (size_t s = 0; s < scene->n_source; s++) {
        struct rmap_lamp_sheet sheet;
        if (!scene->source[s].lamp)
            continue;
        rmap_lamp_sheet_of(scene, &scene->source[s], NULL, &sheet);
        json_t *lamp = rmap_lamp_sheet_json(&sheet, false);
        if (lamp)
            (void)json_object_set_new(lamp, "source", json_string(scene->source[s].name));
        list = list ? list : json_array();
        (void)json_array_append_new(list, lamp);
    }
    return list;
}

json_t *rmap_scene_summary_json(const struct rmap_scene *scene)
{
    struct rmap_bounds box = bounds(scene);
    json_t *extent = json_null();
    if (scene->n_object > 0)
        extent = json_pack("[[f,f,f],[f,f,f]]", box.lower.x, box.lower.y, box.lower.z, box.upper.x,
                           box.upper.y, box.upper.z);
    return json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, "
        "s:I, s:o, s:o, s:o*, s:o*}",
        "units", scene->unit, "light", light_json(scene), "media",
        names_json(scene, scene->n_medium, name_medium), "turbid", rmap_turbid_json(scene),
        "gradients", gradients_json(scene), "films", rmap_films_json(scene), "scatter",
        rmap_scatters_json(scene), "surfaces", names_json(scene, scene->n_surface, name_surface),
        "geometries", names_json(scene, scene->n_geometry, name_geometry), "objects",
        names_json(scene, scene->n_object, name_object), "groups",
        names_json(scene, scene->n_group, name_group), "sources",
        names_json(scene, scene->n_source, name_source), "detectors",
        names_json(scene, scene->n_detector, name_detector), "cameras",
        names_json(scene, scene->n_camera, name_camera), "lenses", lenses_json(scene), "triangles",
        (json_int_t)triangles(scene), "box", extent, "indices", indices_json(scene), "steps",
        rmap_steps_json(scene), "lamps", lamps_json(scene));
}
