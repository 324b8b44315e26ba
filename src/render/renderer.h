/* SPDX-License-Identifier: MIT
 *
 * Pictures: light traced backward, from a camera to the sources (Kajiya 1986,
 * doi:10.1145/15922.15902), through the same segments and by the same decisions as forward rays
 * take.
 *
 * A path is analog, as rays are: one outcome at each event, drawn with its probability. It carries
 * shares per channel; a channel's share times the path's probability is the product of that
 * channel's probabilities, so share / first share is what the path transports on the channel.
 * Along a path the radiance divided by the square of the index is conserved (Nicodemus 1963,
 * doi:10.1119/1.1969512).
 *
 * Where a surface or a medium scatters, each light is looked at straight through the uniform
 * medium (next-event estimation). Light that a path runs into counts exactly where it could not
 * have been looked at so: before anything has scattered, or once the path has met a surface, or
 * bent, since. So area lights and the background are complete, in the mean; points and beams are
 * lit by as far as nothing refracts or reflects on the way.
 *
 * A sample is a pure function of (scene, camera, size, seed, pixel, sample number).
 */
#ifndef RMAP_RENDERER_H
#define RMAP_RENDERER_H

#include "accel/accel.h"
#include "render/light.h"
#include "scene/scene.h"

struct rmap_renderer {
    const struct rmap_scene *scene;   /* borrowed */
    const struct rmap_accel *accel;   /* borrowed */
    const struct rmap_camera *camera; /* borrowed */
    uint32_t size[2];
    uint64_t seed;
    double clamp; /* most luminance that a path gets of a light that it runs into after it has
                     scattered; 0: as it comes. What is cut off is a bias, and told */
    struct rmap_lights *lights;
    bool *scatters;                  /* [n_surface]: light that arrives may go anywhere */
    double share[RMAP_CHANNEL_MAX];  /* of a path where it begins, by what eyes see */
    double rgb[RMAP_CHANNEL_MAX][3]; /* linear RGB of unit radiance, divided by that share */
};

/* size: pixels to the right and down. */
enum rmap_status rmap_renderer_create(const struct rmap_scene *scene,
                                      const struct rmap_accel *accel,
                                      const struct rmap_camera *camera, const uint32_t size[2],
                                      uint64_t seed, struct rmap_renderer **renderer_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_renderer_destroy(struct rmap_renderer *renderer);

struct rmap_render_counts {
    uint64_t n_path, n_segment, n_look; /* looks at a light */
    uint64_t n_limit, n_error;          /* paths that ended so; they keep what they had found */
};

void rmap_render_counts_add(struct rmap_render_counts *counts,
                            const struct rmap_render_counts *more);

/* One path: linear RGB (IEC 61966-2-1 primaries), its luminance in cd/m2 for sources in lm, else
 * in W/(m2 sr) weighted by V(lambda) (RGB mode: of the components as they are); rgb[3]: 1 where an
 * area light itself was seen, before anything scattered, else 0; rgb[4]: luminance cut off.
 * Thread-safe; counts are added to.
 */
void rmap_render_sample(const struct rmap_renderer *renderer, uint32_t x, uint32_t y,
                        uint64_t sample, struct rmap_render_counts *counts, double rgb[5]);

#endif
