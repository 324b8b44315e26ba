/* SPDX-License-Identifier: MIT
 *
 * Scatter models of surfaces: which light they scatter, and how much of it there is.
 */
#include "io/scene/scene_scatter.h"

#include <math.h>
#include <string.h>

#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_scatter_model.h"
#include "scene/scene.h"

/* The greatest share of a model of amount 1. */
static double worst_share(const struct rmap_scatter *its, int channel, double *degrees_ret)
{
    double worst = 0.0;
    for (int angle = 0; angle < 90; angle += 5) {
        const double radians = angle * RMAP_PI / 180.0;
        const struct rmap_scattering at = {.scatter = its,
                                           .channel = channel,
                                           .n1 = 1.0,
                                           .n2 = 1.0,
                                           .front = true,
                                           .in = rmap_vec3(sin(radians), 0.0, -cos(radians))};
        double share = rmap_lobe_total(&at);
        if (its->by_roughness)
            share *= cos(radians); /* of what is reflected */
        if (!(share > worst))
            continue;
        worst = share;
        *degrees_ret = angle;
    }
    return worst;
}

/* Absolute models scatter what they say; that must be there. left: of the arriving light, by
 * channel; what: "its reflectance". */
static void check_amount(struct rmap_reader *reader, const struct rmap_surface *surface,
                         const struct rmap_model_read *read, const double *left, const char *what)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    const struct rmap_scatter *its = read->its;
    if (reader->bundle->options.surface || rmap_scatter_is_facets(its) ||
        its->model == RMAP_SCATTER_CONTAMINATION ||
        (its->by_roughness && its->model == RMAP_SCATTER_HARVEY))
        return;
    double worst = 0.0, angle = 0.0;
    for (int i = 0; i < channels->n; i++) {
        if (i == 0 || its->by_wavelength)
            worst = worst_share(its, i, &angle);
        const double share = its->amount[i] * worst, most = its->by_roughness ? 1.0 : left[i];
        if (!(share > most + 1e-9))
            continue;
        rmap_reader_error(reader, read->node,
                          "surface '%.60s': %s scatters %.6g of the light at %g degrees and %g nm, "
                          "and %s is %.6g",
                          surface->name, rmap_scatter_name[its->model].name, share, angle,
                          channels->wavelength_nm[i], what, most);
        return;
    }
}

static bool fits(struct rmap_reader *reader, const struct rmap_model_read *read, bool is_fresnel)
{
    const enum rmap_scatter_model model = read->its->model;
    const bool needs = read->its->by_roughness || rmap_scatter_is_facets(read->its);
    if (is_fresnel && !needs) {
        rmap_reader_error(
            reader, read->node,
            "%s says how much it reflects, not how much passes: on a fresnel surface "
            "use harvey or k_correlation with a roughness, ggx, beckmann, slope_error "
            "or unified",
            rmap_scatter_name[model].name);
        return false;
    }
    return true;
}

/* The model read last goes beside what else scatters the same light. */
static void put_beside(struct rmap_scene *scene, int32_t *first)
{
    if (*first > 0)
        scene->scatter[*first - 1].next = (int32_t)scene->n_scatter;
    else
        *first = (int32_t)scene->n_scatter;
}

/* contamination: beside what else there is. */
static void read_contamination(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_surface *surface)
{
    static const char key[] = "contamination";
    struct rmap_scene *scene = reader->scene;
    const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, false);
    const bool facets = its && rmap_scatter_is_facets(its);
    struct rmap_model_read read;
    if (!rmap_yaml_get(node, key))
        return;
    if (facets) {
        rmap_reader_error(
            reader, rmap_yaml_get(node, key),
            "particles lie on smooth surfaces and on lobes, not on facets: use harvey "
            "or k_correlation beside them");
        return;
    }
    if (!rmap_reader_read_model(reader, node, key, false, &read))
        return;
    const bool passes = surface->type != RMAP_SURFACE_MIRROR;
    read.its->of_reflected = (int32_t)scene->n_surface - 1;
    read.its->of_transmitted = passes ? read.its->of_reflected : -1;
    read.its->refracts = surface->type == RMAP_SURFACE_FRESNEL;
    if (surface->type != RMAP_SURFACE_SCATTER)
        surface->reflect_is_total = surface->transmit_is_total = true;
    put_beside(scene, &surface->scatter_reflect);
    if (passes && surface->scatter_transmit != surface->scatter_reflect)
        put_beside(scene, &surface->scatter_transmit);
}

/* scatter: of what is reflected, and passes. */
static void read_on_boundary(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct rmap_surface *surface)
{
    const bool is_fresnel = surface->type == RMAP_SURFACE_FRESNEL;
    struct rmap_model_read read;
    if (!rmap_yaml_get(node, "scatter") ||
        !rmap_reader_read_model(reader, node, "scatter", false, &read))
        return;
    if (!fits(reader, &read, is_fresnel))
        return;
    if (rmap_scatter_is_shape_alone(read.its->model) && !read.has_tis) {
        if (surface->is_metal) {
            rmap_reader_error(reader, read.node,
                              "'tis' is missing: the share of the light that is scattered");
            return;
        }
        rmap_scatter_set_amount(read.its, reader->scene->channels.n, surface->reflect_specular);
    }
    read.its->refracts = is_fresnel;
    surface->reflect_is_total = surface->transmit_is_total = true;
    surface->scatter_reflect = (int32_t)reader->scene->n_scatter;
    read.its->of_reflected = (int32_t)reader->scene->n_surface - 1;
    read.its->of_transmitted = is_fresnel ? read.its->of_reflected : -1;
    if (is_fresnel)
        surface->scatter_transmit = surface->scatter_reflect;
    double all[RMAP_CHANNEL_MAX];
    for (int i = 0; i < reader->scene->channels.n; i++)
        all[i] = surface->is_metal ? 1.0 : surface->reflect_specular[i];
    check_amount(reader, surface, &read, all, "its reflectance");
}

/* reflect: with reflectance or specular; transmit: with transmittance or transmit_specular. */
static void read_way(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool passes,
                     struct rmap_surface *surface)
{
    static const char *const word[2][3] = {{"reflect", "reflectance", "specular"},
                                           {"transmit", "transmittance", "transmit_specular"}};
    const char *key = word[passes][0], *whole = word[passes][1], *rest = word[passes][2];
    double *specular = passes ? surface->transmit_specular : surface->reflect_specular;
    const bool total = rmap_yaml_get(node, whole), left = rmap_yaml_get(node, rest);
    const size_t before = reader->diagnostics->n_error;
    struct rmap_model_read read;
    if (total && left)
        rmap_reader_error(reader, rmap_yaml_get(node, rest),
                          "a surface has '%s' in all, or '%s' beside its model, not both", whole,
                          rest);
    rmap_reader_quantity(reader, node, total ? whole : rest, RMAP_OPTIONAL, &rmap_range_share,
                         specular);
    if (!rmap_yaml_get(node, key) || !rmap_reader_read_model(reader, node, key, passes, &read))
        return;
    const enum rmap_scatter_model model = read.its->model;
    const bool relative = read.its->by_roughness || rmap_scatter_is_facets(read.its);
    if (passes && (relative || model == RMAP_SCATTER_RETRO))
        rmap_reader_error(reader, read.node,
                          "'%s' is a model of reflected light; what passes a rough boundary is "
                          "asked of type fresnel with 'scatter'",
                          rmap_scatter_name[model].name);
    if (relative && left)
        rmap_reader_error(reader, read.node, "%s scatters a part of the whole: say '%s'",
                          rmap_scatter_name[model].name, whole);
    if (relative && !total && model != RMAP_SCATTER_UNIFIED)
        rmap_reader_error(reader, node, "'%s' is missing", whole);
    const bool takes_all = rmap_scatter_is_shape_alone(model) && !read.has_tis;
    if (takes_all && !total)
        rmap_reader_error(reader, read.node,
                          "how much of the light? Say '%s', all of which it scatters, or its 'tis'",
                          whole);
    if (reader->diagnostics->n_error != before)
        return;
    double most[RMAP_CHANNEL_MAX];
    for (int i = 0; i < reader->scene->channels.n; i++) {
        if (relative && !total)
            specular[i] = 1.0;
        most[i] = total ? specular[i] : 1.0 - specular[i];
    }
    if (read.relative && !total) {
        rmap_reader_error(reader, read.node, "'relative' is of what is %s: say '%s'",
                          passes ? "let pass" : "reflected", whole);
        return;
    }
    for (int i = 0; read.relative && i < reader->scene->channels.n; i++)
        read.its->amount[i] = specular[i];
    if (takes_all) {
        rmap_scatter_set_amount(read.its, reader->scene->channels.n, specular);
        for (int i = 0; i < reader->scene->channels.n; i++)
            specular[i] = 0.0;
    }
    read.its->refracts = passes;
    read.its->of_reflected = passes ? -1 : (int32_t)reader->scene->n_surface - 1;
    read.its->of_transmitted = passes ? (int32_t)reader->scene->n_surface - 1 : -1;
    *(passes ? &surface->transmit_is_total : &surface->reflect_is_total) = total && !takes_all;
    *(passes ? &surface->scatter_transmit : &surface->scatter_reflect) =
        (int32_t)reader->scene->n_scatter;
    check_amount(reader, surface, &read, most,
                 total ? passes ? "its transmittance" : "its reflectance"
                       : "what is left beside the specular share");
}

/* Both ways together. */
static void check_sum(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct rmap_surface *surface)
{
    const struct rmap_scene *scene = reader->scene;
    double worst[2] = {0.0, 0.0}, angle[2] = {0.0, 0.0};
    for (int i = 0; i < scene->channels.n; i++) {
        double sum = 0.0;
        for (int way = 0; way < 2; way++) {
            const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, way == 1);
            const bool total = way ? surface->transmit_is_total : surface->reflect_is_total;
            sum += way ? surface->transmit_specular[i] : surface->reflect_specular[i];
            if (!its || total || rmap_scatter_is_facets(its))
                continue;
            if (i == 0 || its->by_wavelength)
                worst[way] = worst_share(its, i, &angle[way]);
            sum += its->amount[i] * worst[way];
        }
        if (!(sum > 1.0 + 1e-9))
            continue;
        rmap_reader_error(
            reader, node,
            "surface '%.60s' reflects and lets pass %.9g of the light, at %g nm, most of it "
            "at %g and %g degrees: more than 1 is no surface",
            surface->name, sum, scene->channels.wavelength_nm[i], angle[0], angle[1]);
        return;
    }
}

void rmap_reader_read_scatter(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_surface *surface)
{
    const size_t before = reader->diagnostics->n_error;
    const char *asked = reader->bundle->options.surface;
    int frame = 0;
    if (asked && strcmp(asked, surface->name) != 0)
        return;
    (void)rmap_reader_choice(reader, node, "frame", RMAP_OPTIONAL, "object uv", &frame);
    surface->frame_uv = frame == 1;
    if (surface->type != RMAP_SURFACE_SCATTER) {
        read_on_boundary(reader, node, surface);
        read_contamination(reader, node, surface);
        return;
    }
    if (!rmap_yaml_get(node, "reflect") && !rmap_yaml_get(node, "transmit")) {
        rmap_reader_error(reader, node,
                          "a scattering surface has a model, as in 'reflect: {model: abg, ...}'");
        return;
    }
    read_way(reader, node, false, surface);
    read_way(reader, node, true, surface);
    if (!asked && reader->diagnostics->n_error == before)
        check_sum(reader, node, surface);
    read_contamination(reader, node, surface);
}

/* ---- on objects ---- */

static bool holds_particles(const struct rmap_scene *scene, const struct rmap_surface *surface)
{
    const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, false);
    while (its && its->next > 0)
        its = &scene->scatter[its->next - 1];
    return its && its->model == RMAP_SCATTER_CONTAMINATION;
}

static void check_side(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const struct rmap_object *object, int32_t surface_index)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_surface *surface = surface_index < 0 ? NULL : &scene->surface[surface_index];
    const bool front = object->medium_front == object->medium_outside,
               back = object->medium_back == object->medium_outside;
    if (!surface)
        return;
    if (surface->type == RMAP_SURFACE_FRESNEL && front == back && holds_particles(scene, surface))
        rmap_reader_error(reader, at,
                          "%s of '%.60s' %s the medium around it: particles of surface '%.60s' "
                          "lie on one side, where an object meets what is around it",
                          front ? "both sides" : "neither side", object->name, front ? "are" : "is",
                          surface->name);
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    if (surface->frame_uv && geometry->kind == RMAP_GEOMETRY_MESH &&
        (!geometry->mesh || !geometry->mesh->tangent))
        rmap_reader_error(reader, at,
                          "surface '%.60s' has 'frame: uv', and the mesh of '%.60s' has no texture "
                          "coordinates: say 'frame: object', or take a mesh file that has them "
                          "(OBJ, glTF or PLY)",
                          surface->name, object->name);
}

void rmap_reader_check_scatter(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                               const struct rmap_object *object)
{
    check_side(reader, at, object, object->surface_front);
    if (object->surface_back != object->surface_front)
        check_side(reader, at, object, object->surface_back);
}
