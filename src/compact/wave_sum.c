/* SPDX-License-Identifier: MIT
 *
 * Colours and lengths along each ray, once a wave knows its legs.
 */
#include "compact/step.h"
#include "compact/wave.h"

static void weigh_leg(const struct rmap_retrace *r, const struct rmap_wave_leg *leg, int channel,
                      struct rmap_compact_light *light)
{
    double cosine = leg->cosine, size = cosine < 0.0 ? -cosine : cosine;
    if (!(size >= 0.0)) /* nothing met */
        return;
    if (leg->event & r->model->guide[leg->object].grey[cosine < 0.0])
        return;
    const struct rmap_medium *near = rmap_step_medium(r->model, leg->medium);
    if (!near)
        return;
    const struct rmap_compact_object *o = &r->model->object[leg->object];
    const struct rmap_encounter encounter = {
        .surface = cosine < 0.0 ? o->front : o->back,
        .near = near,
        .far = rmap_medium_beyond(r->model, leg->object, cosine < 0.0, near),
        .cosine = size <= 1.0 ? size : 1.0,
        .event = leg->event,
        .channel = channel};
    rmap_light_meet(&encounter, light);
}

static double index_of(const struct rmap_compact_light *light, const struct rmap_medium *medium)
{
    if (!medium)
        return 1.0;
    return medium->dispersive ? rmap_light_mean(light, medium->n) : medium->n[light->begin];
}

/* Colours and lengths of ray i. light: its beginning. */
static void sum_up(struct rmap_wave *wave, const struct rmap_retrace *r, size_t i, size_t crossing,
                   struct rmap_compact_light *light, struct rmap_portion *out)
{
    const struct rmap_wave_ray *ray = &wave->ray[i];
    size_t n = (size_t)r->model->n_channel;
    double path_length = 0.0, optical_path = 0.0;
    const struct rmap_wave_leg *leg = ray->leg - (ray->row - ray->first);
    for (size_t row = ray->first; row < ray->end; row++, leg++) {
        double index = 1.0;
        if (out->segment.position)
            memcpy(out->segment.position + 3 * row, leg->position, sizeof leg->position);
        if (out->segment.normal)
            memcpy(out->segment.normal + 3 * row, leg->normal, sizeof leg->normal);
        if (r->colour) {
            const struct rmap_medium *medium = rmap_step_medium(r->model, leg->medium);
            index = index_of(light, medium);
            if (medium && medium->absorbing && leg->length > 0.0 && light->end - light->begin > 1)
                (void)rmap_light_absorb(medium, r->seed, r->id[i], 0, leg->length, false, light);
            if (light->changed)
                rmap_light_quantise(r->model->n_channel, light);
            if (out->colour && n == 3) /* worth a copy of constant size */
                memcpy(out->colour + row * 3, light->quantised, 3 * sizeof *out->colour);
            else if (out->colour)
                memcpy(out->colour + row * n, light->quantised, n * sizeof *out->colour);
        }
        for (; out->registration.optical_path && r->crossing_segment && crossing < ray->crossing &&
               r->crossing_segment[crossing] <= row - ray->first;
             crossing++)
            out->registration.optical_path[crossing] =
                rmap_step_double(optical_path + index * out->registration.optical_path[crossing]);
        if (!(leg->event & RMAP_EVENT_LEFT)) {
            path_length += leg->length;
            optical_path += index * leg->length;
        }
        if (r->colour && row + 1 < ray->end && light->end - light->begin > 1)
            weigh_leg(r, leg, (int)r->channel[i] - 1, light);
    }
    if (out->ray.path_length)
        out->ray.path_length[i] = rmap_step_double(path_length);
    if (out->ray.optical_path)
        out->ray.optical_path[i] = rmap_step_double(optical_path);
}

void rmap_wave_sum(struct rmap_wave *wave, const struct rmap_retrace *r,
                   struct rmap_wave_range *range, struct rmap_portion *out)
{
    struct rmap_compact_light light;
    size_t crossing = range->crossing;
    for (size_t i = range->first; i < range->end; i++) {
        const struct rmap_wave_ray *ray = &wave->ray[i];
        if (r->colour)
            rmap_light_begin(r->model, r->source[i], ray->departs, &light);
        sum_up(wave, r, i, crossing, &light, out);
        if (r->crossing_segment && ray->crossing < ray->crossing_end)
            wave->careful[i] = 1;
        crossing = range->crossing = ray->crossing_end;
        range->row = ray->end;
        if (out->ray.end_direction) {
            struct rmap_vec3 way = {0.0, 0.0, 0.0};
            if (r->stop[i] == RMAP_STOP_LEFT)
                way = ray->direction;
            rmap_step_float3(way, out->ray.end_direction + 3 * i);
        }
    }
}
