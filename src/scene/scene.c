/* SPDX-License-Identifier: MIT
 *
 * A scene as the tracer sees it: resolved, checked, plain data.
 */
#include "scene/scene.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/rng.h"

enum rmap_status rmap_scene_create(struct rmap_scene **scene_ret, struct rmap_error *err)
{
    struct rmap_scene *scene = rmap_alloc(1, sizeof *scene);
    char *unit = rmap_strdup("mm");
    if (!scene || !unit) {
        rmap_free(scene);
        rmap_free(unit);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    }
    scene->unit = unit;
    scene->unit_m = 1e-3;
    scene->limit_steps = 10000;
    scene->simulation.record = true;
    *scene_ret = scene;
    return RMAP_OK;
}

void rmap_source_fini(struct rmap_source *source)
{
    rmap_free(source->name);
    rmap_free(source->triangle_cdf);
    rmap_free(source->list);
    rmap_file_rays_drop(source->rays);
    rmap_profile_fini(&source->profile);
    if (source->lamp)
        rmap_lamp_fini(source->lamp);
    rmap_free(source->lamp);
    rmap_steps_destroy(source->steps);
    if (source->volume)
        rmap_volume_fini(source->volume);
    rmap_free(source->volume);
    if (source->sky)
        rmap_sky_fini(source->sky);
    rmap_free(source->sky);
}

static void destroy_sources(struct rmap_scene *scene)
{
    for (size_t i = 0; scene->source && i < scene->n_source; i++)
        rmap_source_fini(&scene->source[i]);
    rmap_free(scene->source);
}

static void destroy_optics(struct rmap_scene *scene)
{
    for (size_t i = 0; scene->medium && i < scene->n_medium; i++) {
        rmap_free(scene->medium[i].name);
        rmap_free(scene->medium[i].description);
        rmap_field_destroy(scene->medium[i].field);
        rmap_free(scene->medium[i].scintillation);
        for (int k = 0; k < 2; k++)
            rmap_field_destroy(scene->medium[i].beside[k]);
        rmap_phase_fini(&scene->medium[i].phase);
        for (size_t k = 0; k < scene->medium[i].n_species; k++)
            rmap_free(scene->medium[i].species[k].name);
        rmap_free(scene->medium[i].species);
    }
    rmap_free(scene->medium);
    for (size_t i = 0; scene->surface && i < scene->n_surface; i++)
        rmap_free(scene->surface[i].name);
    rmap_free(scene->surface);
    for (size_t i = 0; scene->film && i < scene->n_film; i++) {
        rmap_free(scene->film[i].name);
        rmap_free(scene->film[i].layer);
        rmap_free(scene->film[i].angle);
        rmap_free(scene->film[i].share);
    }
    rmap_free(scene->film);
    for (size_t i = 0; scene->scatter && i < scene->n_scatter; i++)
        rmap_scatter_fini(&scene->scatter[i]);
    rmap_free(scene->scatter);
}

static void destroy_bodies(struct rmap_scene *scene)
{
    for (size_t i = 0; scene->geometry && i < scene->n_geometry; i++) {
        rmap_free(scene->geometry[i].name);
        rmap_mesh_destroy(scene->geometry[i].mesh);
        rmap_shape_release(&scene->geometry[i].shape);
    }
    rmap_free(scene->geometry);
    for (size_t i = 0; scene->object && i < scene->n_object; i++)
        rmap_free(scene->object[i].name);
    rmap_free(scene->object);
    for (size_t i = 0; scene->group && i < scene->n_group; i++)
        rmap_free(scene->group[i].name);
    rmap_free(scene->group);
    for (size_t i = 0; scene->detector && i < scene->n_detector; i++) {
        rmap_free(scene->detector[i].name);
        rmap_free(scene->detector[i].face);
        rmap_response_destroy(scene->detector[i].response);
    }
    rmap_free(scene->detector);
    for (size_t i = 0; scene->camera && i < scene->n_camera; i++)
        rmap_free(scene->camera[i].name);
    rmap_free(scene->camera);
}

static void destroy_derived(struct rmap_scene *scene)
{
    rmap_free(scene->gradient);
    rmap_free(scene->object_bounds);
    rmap_free(scene->schedule);
    rmap_free(scene->schedule_rank);
    rmap_free(scene->schedule_quota);
    rmap_free(scene->free_detector);
    rmap_free(scene->far_detector);
    rmap_free(scene->on_detector);
    rmap_free(scene->on_first);
}

void rmap_scene_destroy(struct rmap_scene *scene)
{
    if (!scene)
        return;
    destroy_sources(scene);
    destroy_optics(scene);
    destroy_bodies(scene);
    destroy_derived(scene);
    rmap_free(scene->simulation.name);
    rmap_free(scene->unit);
    rmap_free(scene);
}

struct rmap_vec3 rmap_source_place(const struct rmap_scene *scene, const struct rmap_source *source)
{
    const struct rmap_volume *volume = source->volume;
    if (source->n_list > 0)
        return source->list[0].origin;
    if (source->sky) /* its pole, halfway to where it begins */
        return rmap_affine_point(&source->frame, rmap_vec3(0, 0, 0.5 * source->shape_size[0]));
    if (!volume || volume->kind == RMAP_VOLUME_TRACK || volume->n_part == 0)
        return source->frame.t;
    return rmap_affine_point(&scene->object[volume->part[0]].to_world,
                             rmap_affine_point(&source->frame, rmap_vec3(0.5, 0.5, 0.5)));
}

struct rmap_vec3 rmap_source_half_size(const struct rmap_source *source)
{
    const double *size = source->shape_size;
    if (source->type == RMAP_SOURCE_BEAM) { /* no ray is drawn beyond 4.3 radii */
        const double turn = source->cone_rad / size[1],
                     half = 4.5 * size[0] * sqrt(1.0 + turn * turn);
        return rmap_vec3(half, half, 0.0);
    }
    switch (source->shape) {
    case RMAP_EMITTER_POINT:
    case RMAP_EMITTER_MESH:
    case RMAP_EMITTER_SKY:
        break;
    case RMAP_EMITTER_DISC:
        return rmap_vec3(size[0], size[0], 0.0);
    case RMAP_EMITTER_RECTANGLE:
        return rmap_vec3(0.5 * size[0], 0.5 * size[1], 0.0);
    case RMAP_EMITTER_BODY:
        size = source->lamp->size;
        return rmap_vec3(0.5 * size[0], 0.5 * size[1], 0.5 * size[2]);
    }
    return rmap_vec3(0.0, 0.0, 0.0);
}

bool rmap_scene_transmits(const struct rmap_scene *scene, int32_t surface_index)
{
    if (surface_index < 0)
        return false;
    const struct rmap_surface *surface = &scene->surface[surface_index];
    bool some = rmap_surface_look(surface) == RMAP_LOOK_REFRACTING || surface->scatter_transmit > 0;
    for (int i = 0; !some && i < scene->channels.n; i++)
        some |= surface->transmit_specular[i] > 0 || surface->transmit_diffuse[i] > 0;
    return some;
}

void rmap_geometry_bounds(const struct rmap_geometry *geometry, struct rmap_vec3 *lower,
                          struct rmap_vec3 *upper)
{
    if (geometry->kind == RMAP_GEOMETRY_SHAPE)
        rmap_shape_bounds(&geometry->shape, lower, upper);
    else
        rmap_mesh_bounds(geometry->mesh, lower, upper);
}

bool rmap_scene_group_within(const struct rmap_scene *scene, int32_t group, int32_t outer)
{
    while (group >= 0 && group != outer)
        group = scene->group[group].parent;
    return group >= 0;
}

bool rmap_scene_in_group(const struct rmap_scene *scene, int32_t object, int32_t group)
{
    return rmap_scene_group_within(scene, scene->object[object].parent, group);
}

bool rmap_detector_lies_at(const struct rmap_scene *scene, const struct rmap_detector *detector,
                           size_t object)
{
    if (detector->type != RMAP_DETECTOR_PLANE)
        return false;
    if (detector->on_object >= 0)
        return (size_t)detector->on_object == object;
    return detector->on_group >= 0 &&
           rmap_scene_in_group(scene, (int32_t)object, detector->on_group);
}

const char *rmap_flux_unit_name(const struct rmap_scene *scene)
{
    static const char *const name[] = {[RMAP_FLUX_W] = "W",
                                       [RMAP_FLUX_LM] = "lm",
                                       [RMAP_FLUX_PHOTON_RATE] = "photons/s",
                                       [RMAP_FLUX_PHOTONS] = "photons",
                                       [RMAP_FLUX_J] = "J"};
    return name[scene->flux_unit];
}

int32_t rmap_scene_source_of(const struct rmap_scene *scene, uint64_t ray, uint64_t *ordinal_ret)
{
    uint64_t period = ray / scene->schedule_len;
    size_t entry = (size_t)(ray % scene->schedule_len);
    int32_t source = scene->schedule[entry];
    if (ordinal_ret)
        *ordinal_ret = period * scene->schedule_quota[source] + scene->schedule_rank[entry];
    return source;
}

bool rmap_scene_has_surfaces(const struct rmap_scene *scene)
{
    bool has = false;
    for (size_t i = 0; i < scene->n_geometry; i++)
        has = has || (scene->geometry[i].mesh && scene->geometry[i].mesh->surface);
    return has;
}

bool rmap_scene_has_uv(const struct rmap_scene *scene)
{
    bool has = false;
    for (size_t i = 0; i < scene->n_geometry; i++)
        has = has || (scene->geometry[i].mesh && scene->geometry[i].mesh->uv);
    return has;
}

bool rmap_scene_is_turbid(const struct rmap_scene *scene)
{
    for (size_t i = 0; i < scene->n_medium; i++)
        if (scene->medium[i].scattering_at_all || scene->medium[i].n_species > 0)
            return true;
    return false;
}

bool rmap_scene_is_curved(const struct rmap_scene *scene)
{
    bool curved = scene->n_gradient > 0;
    for (size_t i = 0; i < scene->n_medium; i++)
        curved = curved || scene->medium[i].field;
    return curved;
}

uint64_t rmap_scene_n_photon(const struct rmap_scene *scene)
{
    const struct rmap_steps *steps = scene->n_source == 1 ? scene->source[0].steps : NULL;
    return steps ? rmap_steps_n_counted(steps) : 0;
}

struct rmap_steps_medium rmap_source_steps_medium(const struct rmap_scene *scene,
                                                  const struct rmap_source *source)
{
    const struct rmap_medium *medium = &scene->medium[source->medium];
    return (struct rmap_steps_medium){medium->n, medium->scintillation, &scene->channels,
                                      scene->unit_m};
}

const struct rmap_track_step *rmap_scene_track_step(const struct rmap_scene *scene, uint64_t seed,
                                                    uint64_t ray)
{
    uint64_t ordinal = 0;
    double u[4] = {0.0};
    enum rmap_photon_kind kind;
    const struct rmap_source *source = &scene->source[rmap_scene_source_of(scene, ray, &ordinal)];
    if (source->type != RMAP_SOURCE_STEPS)
        return NULL;
    if (!source->steps->counted)
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, u);
    return &source->steps->step[rmap_steps_find(source->steps, ordinal, u[0], &kind)];
}

bool rmap_scene_keeps_curves(const struct rmap_scene *scene)
{
    return scene->timed || rmap_scene_is_curved(scene);
}

int32_t rmap_scene_surrounding_medium(const struct rmap_scene *scene)
{
    static const char *const name[] = {"air", "vacuum"};
    int32_t most = -1;
    size_t n_most = 0;
    for (size_t k = 0; k < 2; k++)
        for (size_t m = 0; m < scene->n_medium; m++)
            if (strcmp(scene->medium[m].name, name[k]) == 0)
                return (int32_t)m;
    size_t *count = rmap_alloc(scene->n_medium + 1, sizeof *count);
    for (size_t i = 0; count && i < scene->n_object; i++)
        if (scene->object[i].medium_front >= 0)
            count[scene->object[i].medium_front]++;
    for (size_t m = 0; count && m < scene->n_medium; m++)
        if (count[m] > n_most) {
            n_most = count[m];
            most = (int32_t)m;
        }
    rmap_free(count);
    return most;
}

bool rmap_source_has_spectrum(const struct rmap_source *source)
{
    bool all = source->n_list > 0;
    if (source->rays && source->rays->n_other == 0)
        return true;
    for (size_t i = 0; i < source->n_list; i++)
        all = all && source->list[i].channel >= 0;
    return all || source->spectrum_given;
}

int rmap_detector_along(const struct rmap_detector *detector, int axis)
{
    const struct rmap_vec3 along = axis == 0 ? detector->x : detector->y;
    const double part[] = {along.x, along.y, along.z};
    for (int k = 0; k < 3 && detector->type == RMAP_DETECTOR_PLANE; k++)
        if (fabs(part[k]) > 1.0 - 1e-12)
            return k;
    return -1;
}

double rmap_detector_from_world(const struct rmap_detector *detector, int axis, double value)
{
    const int k = rmap_detector_along(detector, axis);
    const struct rmap_vec3 along = axis == 0 ? detector->x : detector->y;
    const double part[] = {along.x, along.y, along.z};
    const double from[] = {detector->origin.x, detector->origin.y, detector->origin.z};
    return (value - from[k]) * part[k];
}

bool rmap_scene_has_rough_metals(const struct rmap_scene *scene)
{
    bool any = false;
    for (size_t i = 0; i < scene->n_surface && scene->channels.n > 1; i++) {
        const struct rmap_surface *its = &scene->surface[i];
        any = any ||
              ((its->is_metal || its->type == RMAP_SURFACE_FRESNEL) && rmap_surface_scatters(its));
    }
    return any;
}

bool rmap_scene_has_tinting_films(const struct rmap_scene *scene)
{
    bool any = false;
    for (size_t i = 0; i < scene->n_surface && scene->channels.n > 1; i++)
        any = any || scene->surface[i].coat == RMAP_COAT_FILM;
    return any;
}
