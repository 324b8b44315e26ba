/* SPDX-License-Identifier: MIT
 *
 * What waves do ray by ray: legs that are like no others, and registrations.
 */
#include "compact/detect.h"
#include "compact/step.h"
#include "compact/wave.h"

static struct rmap_vec3 position_of(const struct rmap_wave_ray *ray)
{
    return rmap_vec3(ray->state[0], ray->state[1], ray->state[2]);
}

static struct rmap_vec3 direction_of(const struct rmap_wave_ray *ray)
{
    return rmap_vec3(ray->state[3], ray->state[4], ray->state[5]);
}

/* Light on a detector that does not lie where the leg ends. */
static void cross_on_the_way(const struct rmap_detector *detector, const struct rmap_wave_ray *ray,
                             const struct rmap_vec3 *to, double length,
                             struct rmap_crossing *crossing)
{
    const struct rmap_compact_leg leg = {.from = position_of(ray),
                                         .to = *to,
                                         .direction = direction_of(ray),
                                         .length = length,
                                         .index = 1.0};
    rmap_crossing_find(detector, &leg, crossing);
}

void rmap_wave_cross(struct rmap_wave_run *run, struct rmap_wave_ray *ray, struct rmap_vec3 to,
                     double length)
{
    const struct rmap_retrace *r = run->r;
    const struct rmap_scene *scene = r->model->scene;
    const struct rmap_registration_columns *out = &run->out->registration;
    struct rmap_crossing crossing = {.optical_path = 0.0};
    rmap_step_float3(direction_of(ray), crossing.direction);
    while (ray->crossing < ray->crossing_end && r->crossing_segment[ray->crossing] <= ray->step) {
        size_t row = ray->crossing++, its = (uint32_t)r->crossing_detector[row];
        uint16_t *cell = out->cell ? out->cell + 2 * row : crossing.cell;
        uint16_t *relative = out->relative ? out->relative + 2 * row : crossing.relative;
        double at[2] = {0.0, 0.0};
        crossing.optical_path = length;
        if (its >= r->model->n_detector) {
            run->wave->careful[ray->index] = 1;
            memset(cell, 0, sizeof crossing.cell);
            memset(relative, 0, sizeof crossing.relative);
        } else if (rmap_detect_lies_on(&scene->detector[its])) {
            rmap_detect_point(&scene->detector[its], to, at);
            rmap_detect_record(&scene->detector[its], at, cell, relative);
        } else {
            cross_on_the_way(&scene->detector[its], ray, &to, length, &crossing);
            memcpy(cell, crossing.cell, sizeof crossing.cell);
            memcpy(relative, crossing.relative, sizeof crossing.relative);
        }
        if (out->direction)
            memcpy(out->direction + 3 * row, crossing.direction, sizeof crossing.direction);
        if (out->optical_path)
            out->optical_path[row] = crossing.optical_path;
    }
}

static struct rmap_turning turning_of(const struct rmap_retrace *r, const struct rmap_wave_ray *ray)
{
    size_t row = ray->row;
    return (struct rmap_turning){.seed = r->seed,
                                 .ray = ray->id,
                                 .step = ray->step + 1,
                                 .event = r->event[row],
                                 .near = rmap_step_medium(r->model, r->medium[row]),
                                 .far = rmap_step_medium(r->model, r->medium[row + 1]),
                                 .channel = ray->channel};
}

static void set_off(struct rmap_wave_ray *ray, struct rmap_vec3 position,
                    struct rmap_vec3 direction)
{
    ray->state[0] = position.x;
    ray->state[1] = position.y;
    ray->state[2] = position.z;
    ray->state[3] = direction.x;
    ray->state[4] = direction.y;
    ray->state[5] = direction.z;
}

void rmap_wave_advance_alone(struct rmap_wave_run *run, struct rmap_wave_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    struct rmap_facing facing = {.normal = {0.0, 0.0, 0.0}};
    struct rmap_vec3 position = position_of(ray), direction = direction_of(ray);
    size_t row = ray->row;
    int32_t from = ray->step > 0 ? r->object[row - 1] : r->start_object[ray->index];
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], from, position,
                                direction, &facing);
    if (!met) {
        const struct rmap_medium *medium = rmap_step_medium(r->model, r->medium[row]);
        if (medium && medium->absorbing && (r->event[row] & RMAP_EVENT_ABSORB))
            run->wave->careful[ray->index] = 1;
        facing.t = rmap_step_distance_out(r->model->scene, position, direction);
        facing.position = rmap_axpy(facing.t, direction, position);
    }
    double cosine = rmap_dot(direction, facing.normal);
    ray->leg->way.length = facing.t;
    ray->leg->cosine = met ? cosine : (double)NAN;
    if (run->out->segment.position)
        rmap_step_float3(facing.position, run->out->segment.position + 3 * row);
    if (run->out->segment.normal)
        rmap_step_normal(facing.normal, run->out->segment.normal + 3 * row);
    if (ray->leg->flags & RMAP_WAVE_CROSSES)
        rmap_wave_cross(run, ray, facing.position, facing.t);
    if (met && row + 1 < ray->end) {
        const struct rmap_turning turning = turning_of(r, ray);
        direction = rmap_step_turned(
            &turning, direction, cosine < 0.0 ? facing.normal : rmap_scale(facing.normal, -1.0));
    }
    set_off(ray, facing.position, direction);
    /* what follows was taken to start on this object */
    if (!met && ray->leg->object < r->model->n_object && row + 1 < ray->end)
        run->wave->careful[ray->index] = 1;
}
