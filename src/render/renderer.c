/* SPDX-License-Identifier: MIT
 *
 * Pictures: light traced backward, from a camera to the sources (Kajiya 1986,
 * doi:10.1145/15922.15902), through the same segments and by the same decisions as forward rays
 * take.
 */
#include "render/renderer.h"

#include "base/alloc.h"
#include "optics/spectrum.h"

void rmap_render_counts_add(struct rmap_render_counts *counts,
                            const struct rmap_render_counts *more)
{
    counts->n_path += more->n_path;
    counts->n_segment += more->n_segment;
    counts->n_look += more->n_look;
    counts->n_limit += more->n_limit;
    counts->n_error += more->n_error;
}

static bool any(const double *share, int n)
{
    bool some = false;
    for (int i = 0; i < n; i++)
        some = some || share[i] > 0.0;
    return some;
}

static void find_scatterers(const struct rmap_scene *scene, bool *scatters)
{
    for (size_t s = 0; s < scene->n_surface; s++) {
        const struct rmap_surface *surface = &scene->surface[s];
        scatters[s] = any(surface->reflect_diffuse, scene->channels.n) ||
                      any(surface->transmit_diffuse, scene->channels.n) ||
                      rmap_surface_scatters(surface);
    }
}

/* Channels that no light has are left out. */
static void find_lit(const struct rmap_scene *scene, bool lit[RMAP_CHANNEL_MAX])
{
    bool some = false;
    for (int i = 0; i < scene->channels.n; i++) {
        lit[i] = scene->background[i] > 0.0;
        for (size_t s = 0; s < scene->n_source; s++)
            lit[i] = lit[i] || (!rmap_source_is_unseen(&scene->source[s]) &&
                                scene->source[s].colour[i] > 0.0);
        some = some || lit[i];
    }
    for (int i = 0; i < scene->channels.n && !some; i++)
        lit[i] = true;
}

/* Channels are followed as often as eyes ask for them, and all of them now and then. Where nothing
 * is visible, the picture is the plain sum in grey. */
static void choose_colours(struct rmap_renderer *renderer)
{
    const double least = 0.02;
    const struct rmap_channels *channels = &renderer->scene->channels;
    bool lit[RMAP_CHANNEL_MAX];
    double watt[RMAP_CHANNEL_MAX][3], weight[RMAP_CHANNEL_MAX], largest = 0.0, sum = 0.0;
    find_lit(renderer->scene, lit);
    rmap_channel_colours(channels, renderer->scene->flux_unit == RMAP_FLUX_LM, renderer->rgb);
    rmap_channel_colours(channels, 0, watt);
    for (int i = 0; i < channels->n; i++) {
        weight[i] = lit[i] ? watt[i][0] + watt[i][1] + watt[i][2] : 0.0;
        largest = fmax(largest, weight[i]);
    }
    for (int i = 0; i < channels->n; i++) {
        weight[i] = lit[i] ? fmax(weight[i], largest > 0.0 ? least * largest : 1.0) : 0.0;
        sum += weight[i];
    }
    for (int i = 0; i < channels->n; i++) {
        double *rgb = renderer->rgb[i];
        const double xyz[3] = {rgb[0], rgb[1], rgb[2]};
        renderer->share[i] = weight[i] / sum;
        if (channels->mode == RMAP_COLOUR_SPECTRAL)
            rmap_xyz_to_rgb(xyz, rgb);
        for (int k = 0; k < 3; k++)
            rgb[k] = !lit[i] ? 0.0 : (largest > 0.0 ? rgb[k] : 1.0) / renderer->share[i];
    }
}

enum rmap_status rmap_renderer_create(const struct rmap_scene *scene,
                                      const struct rmap_accel *accel,
                                      const struct rmap_camera *camera, const uint32_t size[2],
                                      uint64_t seed, struct rmap_renderer **renderer_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_renderer *renderer = rmap_alloc(1, sizeof *renderer);
    bool *scatters = rmap_alloc(scene->n_surface, sizeof *scatters);
    if (!renderer || !scatters) {
        rmap_free(renderer);
        rmap_free(scatters);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    }
    *renderer = (struct rmap_renderer){.scene = scene,
                                       .accel = accel,
                                       .camera = camera,
                                       .size = {size[0], size[1]},
                                       .seed = seed,
                                       .scatters = scatters};
    RMAP_TRY(rmap_lights_create(scene, &renderer->lights, err));
    find_scatterers(scene, scatters);
    choose_colours(renderer);
    *renderer_ret = renderer;
    renderer = NULL;
out:
    rmap_renderer_destroy(renderer);
    return st;
}

void rmap_renderer_destroy(struct rmap_renderer *renderer)
{
    if (!renderer)
        return;
    rmap_lights_destroy(renderer->lights);
    rmap_free(renderer->scatters);
    rmap_free(renderer);
}
