/* SPDX-License-Identifier: MIT
 *
 * Emission: where a ray begins, in which direction, of which colour, and when.
 */
#ifndef RMAP_SOURCE_H
#define RMAP_SOURCE_H

#include "portion/recorder.h"
#include "scene/scene.h"
#include "trace/colour.h"

/* Emits ray id `ray`: fills *colour and *emission (whose colour points at colour->share).
 * A list of rays gives its row (running number of the source's ray modulo the list's length), a
 * file of them as rmap_file_rays_row says, steps of particles a photon of theirs, a volume any
 * direction from a place of it; lamps and skies as their headers say. Point sources are isotropic,
 * uniform in a cone, ~ cos^power or by a table about the frame's z, collimated ones parallel to it
 * or uniform in a cone, their angular diameter; area sources shine on the side of their normal,
 * uniformly over their area, by Lambert's law unless rmap_source_is_directed. */
void rmap_source_emit(const struct rmap_scene *scene, uint64_t seed, uint64_t ray,
                      struct rmap_colour *colour, struct rmap_emission *emission);

/* The channel that a ray starts with: its own, where its source says it (else -1); in a scene whose
 * rays have one each one drawn from the source's colour; -1: all of the colour. */
int rmap_source_channel(const struct rmap_scene *scene, const struct rmap_source *source,
                        uint64_t seed, uint64_t ray, int own);

/* A ray as its source has it, by operations that are the same everywhere, so that the decoder of
 * compact maps finds it, too: origin, direction and, where they are the source's to say, channel
 * (else -1) and delay in a timed scene. False of POINT, COLLIMATED and AREA, which are drawn apart.
 */
bool rmap_source_start(const struct rmap_scene *scene, const struct rmap_source *source,
                       uint64_t seed, uint64_t ray, struct rmap_list_ray *start);

/* A point of the source's emitter, uniform over it, by three numbers in (0, 1); *normal: unit, of
 * the side that shines. */
struct rmap_vec3 rmap_source_point(const struct rmap_scene *scene, const struct rmap_source *source,
                                   const double u[4], struct rmap_vec3 *normal);

/* The same of an emitter that is no mesh, and its normal everywhere. */
struct rmap_vec3 rmap_source_flat_point(const struct rmap_source *source, const double u[4]);
struct rmap_vec3 rmap_source_flat_normal(const struct rmap_source *source);

/* A collimated source all of whose light has one direction. */
static inline bool rmap_source_is_parallel(const struct rmap_source *source)
{
    return source->type == RMAP_SOURCE_COLLIMATED &&
           source->distribution == RMAP_DISTRIBUTION_ISOTROPIC;
}

/* STEPS: the photon that is this ray. */
void rmap_source_photon(const struct rmap_scene *scene, const struct rmap_source *source,
                        uint64_t seed, uint64_t ray, struct rmap_photon *photon);

/* AREA that rmap_source_is_directed: a direction of its light, from where `normal` is. */
struct rmap_vec3 rmap_source_directed(const struct rmap_source *source, struct rmap_vec3 normal,
                                      const double u[2]);

/* CONE: 1 - cos of its half opening, by operations that are the same everywhere; 0 where that is no
 * angle, as in a damaged map. */
double rmap_source_cone(const struct rmap_source *source);

/* A direction of its light in its frame, about z, by two numbers in (0, 1): as the decoder has it,
 * and as the tracer of POINT and COLLIMATED does, by the library's functions. */
struct rmap_vec3 rmap_source_about_z(const struct rmap_source *source, const double u[2]);
struct rmap_vec3 rmap_source_about_axis(const struct rmap_source *source, const double u[2]);

#endif
