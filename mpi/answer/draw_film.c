/* SPDX-License-Identifier: MIT
 *
 * `raymap draw --time`: pictures of the light under way, step by step.
 */
#include "mpi/answer/draw_film.h"

#include "analysis/figure/figure_detector.h"
#include "io/export/animation.h"
#include "io/export/raster.h"

/* Pictures a second. */
enum { RATE = 12 };

static enum rmap_status draw_frame(const struct rmap_draw_request *request,
                                   const struct rmap_scene *scene, const struct rmap_portion *rays,
                                   const struct rmap_figure_draw *figure, uint32_t frame,
                                   struct rmap_animation *animation, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    char path[RMAP_FRAME_PATH_LEN];
    RMAP_TRY(rmap_figure_draw(scene, rays, figure, &svg, err));
    if (animation) {
        st = rmap_animation_add(animation, svg, RMAP_FIGURE_SCALE, err);
        goto out;
    }
    RMAP_TRY(rmap_frame_path(request->output_path, frame, path, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    return st;
}

enum rmap_status rmap_draw_film(const struct rmap_draw_request *request,
                                const struct rmap_scene *scene, const struct rmap_portion *rays,
                                const struct rmap_figure_draw *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_light_times *times = NULL;
    struct rmap_animation *animation = NULL;
    struct rmap_figure_bodies bodies = {0};
    struct rmap_figure_draw figure = *given;
    figure.bodies = &bodies;
    RMAP_TRY(rmap_light_times_create(given->map, rays, &times, err));
    if (request->animated)
        RMAP_TRY(
            rmap_animation_create(request->output_path, request->n_frame, RATE, &animation, err));
    for (uint32_t k = 0; k < request->n_frame; k++) {
        const struct rmap_time_window window = {.times = times,
                                                .from = request->time[0] + k * request->time[2],
                                                .until =
                                                    request->time[0] + (k + 1) * request->time[2]};
        figure.window = &window;
        RMAP_TRY(draw_frame(request, scene, rays, &figure, k, animation, err));
    }
    if (animation)
        st = rmap_animation_finish(animation, err);
out:
    rmap_animation_destroy(animation);
    rmap_light_times_destroy(times);
    rmap_figure_bodies_fini(&bodies);
    return st;
}
