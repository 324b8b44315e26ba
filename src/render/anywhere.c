/* SPDX-License-Identifier: MIT
 *
 * Ways that light goes and paths drawn backwards would miss.
 */
#include "render/anywhere.h"

#include "base/rng.h"
#include "formula/turn.h"
#include "trace/scattering.h"

struct rmap_scatter_side rmap_walk_side_met(const struct rmap_walk *walk,
                                            const struct rmap_hit *hit, bool front,
                                            struct rmap_vec3 normal)
{
    const struct rmap_scene *scene = walk->scene;
    const struct rmap_object *object = &scene->object[hit->object];
    int32_t near = front ? object->medium_front : object->medium_back;
    int32_t far = front ? object->medium_back : object->medium_front;
    struct rmap_scatter_side side = {
        .scene = scene,
        .object = object,
        .front = front,
        .position = hit->position,
        .primitive = hit->primitive,
        .surface = &scene->surface[front ? object->surface_front : object->surface_back],
        .near = near == RMAP_MEDIUM_ANY ? walk->ray.medium : near,
        .far = far == RMAP_MEDIUM_ANY ? walk->ray.medium : far,
        .normal = normal};
    rmap_scatter_frame(&side);
    return side;
}

void rmap_walk_side_on_channel(int channel, struct rmap_scatter_side *side)
{
    side->channel = channel;
    side->n1 = side->scene->medium[side->near].n[channel];
    side->n2 = side->scene->medium[side->far].n[channel];
}

static bool is_one_way(const struct rmap_scatter *its, bool between_media)
{
    return its &&
           (rmap_scatter_is_table(its) || (its->model == RMAP_SCATTER_UNIFIED && between_media));
}

void rmap_anywhere_find(const struct rmap_walk *walk, const struct rmap_hit *hit, bool front,
                        struct rmap_anywhere *any)
{
    const struct rmap_scene *scene = walk->scene;
    const struct rmap_object *object = &scene->object[hit->object];
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const bool between = surface->type == RMAP_SURFACE_FRESNEL;
    *any = (struct rmap_anywhere){.share = 0.0};
    if (!rmap_surface_scatters(surface) || object->gradient_front != 0 ||
        object->gradient_back != 0)
        return;
    for (int way = 0; way < 2; way++)
        any->may[way] = is_one_way(rmap_surface_scatter(scene, surface, way == 1), between);
    any->share = any->may[0] || any->may[1] ? 0.25 : 0.0;
}

/* Per steradian and cosine; of the model's own directions there is a share less. */
static double any_density(const struct rmap_anywhere *any, bool passes)
{
    return any->may[passes] ? any->share / ((any->may[0] + any->may[1]) * RMAP_PI) : 0.0;
}

bool rmap_anywhere_go(const struct rmap_walk *walk, const struct rmap_arrival *arrival, bool front,
                      const struct rmap_anywhere *any, struct rmap_decision *decision)
{
    const struct rmap_object *object = &walk->scene->object[arrival->hit.object];
    const struct rmap_vec3 normal =
        front ? arrival->hit.normal : rmap_scale(arrival->hit.normal, -1.0);
    double u[4];
    if (!(any->share > 0.0))
        return false;
    rmap_rng(walk->draw.seed, walk->draw.ray, walk->draw.step, RMAP_RNG_ANYWHERE, u);
    if (!(u[0] < any->share))
        return false;
    const bool passes = any->may[1] && (!any->may[0] || u[0] < 0.5 * any->share);
    const int32_t far = front ? object->medium_back : object->medium_front;
    const struct rmap_scatter_side side = rmap_walk_side_met(walk, &arrival->hit, front, normal);
    const struct rmap_scatter *its = rmap_surface_scatter(side.scene, side.surface, passes);
    decision->events = passes ? RMAP_EVENT_TRANSMIT_DIFFUSE : RMAP_EVENT_REFLECT_DIFFUSE;
    decision->turned = !passes;
    decision->medium = passes && far != RMAP_MEDIUM_ANY ? far : walk->ray.medium;
    decision->gradient = 0;
    decision->direction = rmap_diffused(passes ? rmap_scale(normal, -1.0) : normal, u[1], u[2]);
    decision->collapse = -1;
    decision->predicted = decision->sharp = false;
    decision->weigh = NULL;
    if (!rmap_colour_single(&walk->colour) && rmap_scatter_by_channel(&side, its))
        decision->collapse = rmap_colour_pick(&walk->colour, NULL, u[3]);
    return true;
}

double rmap_anywhere_way_back(const struct rmap_walk *walk, const struct rmap_hit *hit,
                              struct rmap_vec3 in, const struct rmap_anywhere *any,
                              const struct rmap_decision *decision)
{
    const bool front = rmap_dot(in, hit->normal) < 0.0,
               passes = decision->events & RMAP_EVENT_TRANSMIT_DIFFUSE;
    const int channel = decision->collapse >= 0 ? decision->collapse : walk->colour.begin;
    const struct rmap_vec3 normal = front ? hit->normal : rmap_scale(hit->normal, -1.0);
    struct rmap_scatter_side here = rmap_walk_side_met(walk, hit, front, normal), there = here;
    if (!rmap_surface_scatters(here.surface) || decision->sharp)
        return 1.0 / (1.0 - any->share);
    if (passes)
        there = rmap_walk_side_met(walk, hit, !front, rmap_scale(normal, -1.0));
    rmap_walk_side_on_channel(channel, &here);
    rmap_walk_side_on_channel(channel, &there);
    const double drawn = (1.0 - any->share) * rmap_scatter_bsdf(&here, in, decision->direction) +
                         any_density(any, passes);
    const double back =
        rmap_scatter_bsdf(&there, rmap_scale(decision->direction, -1.0), rmap_scale(in, -1.0));
    return drawn > 0.0 ? back / drawn : 0.0;
}
