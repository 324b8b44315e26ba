/* SPDX-License-Identifier: MIT
 *
 * What a surface of a scene makes of light, for `raymap check --surface`.
 */
#ifndef RMAP_SURFACE_OUT_H
#define RMAP_SURFACE_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/figure/figure_surface.h"

/* The sides with the surface that light of some medium meets on the first object that has it: */
struct rmap_surface_question {
    const struct rmap_scene *scene;
    const struct rmap_surface *surface;
    struct rmap_surface_side side[RMAP_SURFACE_SIDES_MAX];
    size_t n_side;
    int channel; /* in the middle */
};

/* RMAP_INPUT: the scene has no such surface, or no object with it. */
enum rmap_status rmap_surface_ask(const struct rmap_scene *scene, const char *name,
                                  struct rmap_surface_question *question,
                                  struct rmap_error *err) RMAP_MUST_USE;

void rmap_surface_print(const struct rmap_surface_question *question, FILE *out);
json_t *rmap_surface_json(const struct rmap_surface_question *question);
/* between: of rmap_scene_between, NULL: none. */
enum rmap_status rmap_surface_draw(const struct rmap_surface_question *question,
                                   const struct rmap_scene *between, const char *path,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The scene's films: their layers, and what they reflect straight on, where they are used first. */
void rmap_films_print(const struct rmap_scene *scene, FILE *out);
json_t *rmap_films_json(const struct rmap_scene *scene);

/* Its scatter models: how much each surface with one scatters at some angles, where it is used
 * first. */
void rmap_scatters_print(const struct rmap_scene *scene, FILE *out);
json_t *rmap_scatters_json(const struct rmap_scene *scene);

#endif
