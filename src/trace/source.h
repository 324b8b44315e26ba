/* SPDX-License-Identifier: MIT
 *
 * Emission: where a ray begins, in which direction, of which colour.
 */
#ifndef RMAP_SOURCE_H
#define RMAP_SOURCE_H

#include "portion/recorder.h"
#include "scene/scene.h"
#include "trace/colour.h"

/* Emits ray id `ray`: fills *colour and *emission (whose colour points at colour->share).
 * A list of rays gives its row (running number of the source's ray modulo the list's length), a
 * file of them as rmap_file_rays_row says, steps of particles a photon of theirs. Point sources are
 * isotropic, uniform in a cone, ~ cos^power or by a table about the frame's z, collimated ones
 * parallel to it or uniform in a cone, their angular diameter; area sources are Lambertian on the
 * side of their normal, uniform over their area. */
void rmap_source_emit(const struct rmap_scene *scene, uint64_t seed, uint64_t ray,
                      struct rmap_colour *colour, struct rmap_emission *emission);

/* Channel of a ray of a scene whose rays have one each: drawn from the source's colour. */
int rmap_source_channel(const struct rmap_source *source, int n_channel, uint64_t seed,
                        uint64_t ray);

/* RAYS: its ordinal-th ray, in the world. */
void rmap_source_row(const struct rmap_scene *scene, const struct rmap_source *source,
                     uint64_t ordinal, struct rmap_list_ray *row);

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

/* LAMP: a direction of its light, and the place that it leaves from, by numbers in (0, 1). */
struct rmap_vec3 rmap_source_lamp(const struct rmap_scene *scene, const struct rmap_source *source,
                                  const double place[4], const double way[2],
                                  struct rmap_vec3 *position);

/* STEPS: the photon that is this ray. */
void rmap_source_photon(const struct rmap_scene *scene, const struct rmap_source *source,
                        uint64_t seed, uint64_t ray, struct rmap_photon *photon);

/* BEAM: start and direction. Part of the compact encoding, as is the next. */
void rmap_source_beam(const struct rmap_source *source, const double u[4],
                      struct rmap_vec3 *position, struct rmap_vec3 *direction);

/* AREA that rmap_source_is_directed: a direction of its light, from where `normal` is. */
struct rmap_vec3 rmap_source_directed(const struct rmap_source *source, struct rmap_vec3 normal,
                                      const double u[2]);

/* A direction of its light in its frame, about z, by two numbers in (0, 1). */
struct rmap_vec3 rmap_source_about_axis(const struct rmap_source *source, const double u[2]);

#endif
