/* SPDX-License-Identifier: MIT
 *
 * Colours and lengths along a ray, once a wave knows its legs.
 */
#include "compact/step.h"
#include "compact/wave.h"

/* The ray in hand. */
struct sum {
    struct rmap_wave_run *run;
    size_t index, first, end; /* of the ray, of its legs */
    size_t crossing, crossing_end;
    int channel; /* that it ends with; -1: several */
    double path_length, optical_path;
};

static void weigh_leg(const struct sum *sum, size_t row, const struct rmap_wave_leg *leg,
                      struct rmap_compact_light *light)
{
    const struct rmap_retrace *r = sum->run->r;
    double cosine = leg->cosine, size = cosine < 0.0 ? -cosine : cosine;
    if (!(size >= 0.0)) /* nothing met */
        return;
    uint32_t object = leg->object;
    if (r->event[row] & r->model->guide[object].grey[cosine < 0.0])
        return;
    const struct rmap_medium *near = rmap_step_medium(r->model, leg->medium);
    if (!near)
        return;
    const struct rmap_compact_object *o = &r->model->object[object];
    const struct rmap_encounter encounter = {
        .surface = cosine < 0.0 ? o->front : o->back,
        .near = near,
        .far = rmap_medium_beyond(r->model, (int32_t)object, cosine < 0.0, near),
        .cosine = size <= 1.0 ? size : 1.0,
        .event = r->event[row],
        .channel = sum->channel};
    rmap_light_meet(&encounter, light);
}

static double index_of(const struct rmap_compact_light *light, const struct rmap_medium *medium)
{
    if (!medium)
        return 1.0;
    return medium->dispersive ? rmap_light_mean(light, medium->n) : medium->n[light->begin];
}

static inline void note_colour(const struct rmap_compact_light *light, size_t n, uint16_t *out)
{
    if (n == 3) /* worth a copy of constant size */
        memcpy(out, light->quantised, 3 * sizeof *out);
    else
        memcpy(out, light->quantised, n * sizeof *out);
}

/* Registrations on a leg: their optical paths are distances from its start yet. */
static void sum_crossings(struct sum *sum, size_t row, double index)
{
    const uint32_t *segment = sum->run->r->crossing_segment;
    double *optical_path = sum->run->out->registration.optical_path;
    for (; sum->crossing < sum->crossing_end && segment[sum->crossing] <= row - sum->first;
         sum->crossing++)
        optical_path[sum->crossing] =
            rmap_step_double(sum->optical_path + index * optical_path[sum->crossing]);
}

/* One leg, at which the light may change. */
static void sum_leg(struct sum *sum, size_t row, struct rmap_compact_light *light)
{
    const struct rmap_retrace *r = sum->run->r;
    const struct rmap_wave_leg *leg = &sum->run->wave->leg[row];
    const struct rmap_medium *medium = rmap_step_medium(r->model, leg->medium);
    double index = index_of(light, medium);
    if (medium && medium->absorbing && leg->way.length > 0.0 && light->end - light->begin > 1)
        (void)rmap_light_absorb(medium, r->seed, r->id[sum->index], 0, leg->way.length, false,
                                light);
    if (light->changed)
        rmap_light_quantise(r->model->n_channel, light);
    size_t n = (size_t)r->model->n_channel;
    if (sum->run->out->colour)
        note_colour(light, n, sum->run->out->colour + n * row);
    if (sum->crossing < sum->crossing_end)
        sum_crossings(sum, row, index);
    if (!(leg->flags & RMAP_WAVE_LEFT)) {
        sum->path_length += leg->way.length;
        sum->optical_path += index * leg->way.length;
    }
    if (row + 1 < sum->end && light->end - light->begin > 1)
        weigh_leg(sum, row, leg, light);
    if (light->changed && !(leg[1].flags & RMAP_WAVE_TINTS)) /* or else it changes once more */
        rmap_light_quantise(r->model->n_channel, light);
}

/* The same colour in rows [row, end) of n channels each. */
static void fill_colour(const struct rmap_compact_light *light, size_t n, size_t row, size_t end,
                        uint16_t *colour)
{
    uint64_t four;
    uint16_t *out = colour + n * row;
    memcpy(&four, light->quantised, sizeof four);
    for (; n == 3 && row + 1 < end; row++, out += 3) /* of which the next row takes one back */
        memcpy(out, &four, sizeof four);
    for (; row < end; row++, out += n)
        note_colour(light, n, out);
}

/* Legs from `row` on up to the first at which the light may change; which one that is. */
static size_t sum_steady(struct sum *sum, size_t row, const struct rmap_compact_light *light)
{
    const struct rmap_compact_model *model = sum->run->r->model;
    size_t first = row, end = sum->end;
    bool single = light->end - light->begin == 1;
    uint32_t any = single ? RMAP_WAVE_GREY_BACK | RMAP_WAVE_GREY_FRONT : 0;
    uint32_t tints = single ? 0 : RMAP_WAVE_TINTS;
    const double *index = model->index + (model->n_medium + 1) * (size_t)light->begin;
    double path_length = sum->path_length, optical_path = sum->optical_path;
    const struct rmap_wave_leg *leg = &sum->run->wave->leg[row];
    for (; row < end; row++, leg++) {
        uint32_t flags = leg->flags;
        uint32_t grey = RMAP_WAVE_GREY_BACK << (leg->cosine < 0.0);
        if ((flags & tints) || !((flags | any) & grey))
            break;
        double n = index[leg->medium], length = flags & RMAP_WAVE_LEFT ? 0.0 : leg->way.length;
        if (flags & RMAP_WAVE_CROSSES) {
            sum->optical_path = optical_path;
            sum_crossings(sum, row, n);
        }
        path_length += length;
        optical_path += n * length;
    }
    sum->path_length = path_length;
    sum->optical_path = optical_path;
    if (sum->run->r->colour && sum->run->out->colour)
        fill_colour(light, (size_t)model->n_channel, first, row, sum->run->out->colour);
    return row;
}

/* Most rays leave the light as the one before had it. */
static void begin_light(struct rmap_wave_run *run, size_t i, int departs)
{
    const struct rmap_retrace *r = run->r;
    if (run->light_source >= 0 && run->light_source == r->source[i] &&
        run->light_departs == departs)
        return;
    run->light_source = r->source[i];
    run->light_departs = departs;
    run->light.begin = 0;
    run->light.end = 1;
    run->light.changed = false;
    if (r->colour)
        rmap_light_begin(r->model, r->source[i], departs, &run->light);
}

void rmap_wave_sum(struct rmap_wave_run *run, const struct rmap_wave_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    const struct rmap_ray_columns *out = &run->out->ray;
    size_t i = ray->index;
    bool crossings = run->out->registration.optical_path && r->crossing_segment;
    int channel = r->channel[i] <= r->model->n_channel ? (int)r->channel[i] - 1 : -1;
    struct sum sum = {.run = run,
                      .index = i,
                      .first = ray->end - r->segment_count[i],
                      .end = ray->end,
                      .crossing_end = crossings ? ray->crossing : 0,
                      .channel = channel};
    if (crossings)
        sum.crossing = ray->crossing_end - r->registration_count[i];
    begin_light(run, i, ray->departs);
    for (size_t row = sum.first; row < sum.end; row++) {
        row = run->light.changed ? row : sum_steady(&sum, row, &run->light);
        if (row == sum.end)
            break;
        sum_leg(&sum, row, &run->light);
        run->light_source = -1;
    }
    if (ray->crossing < ray->crossing_end)
        run->wave->careful[i] = 1;
    if (out->path_length)
        out->path_length[i] = rmap_step_double(sum.path_length);
    if (out->optical_path)
        out->optical_path[i] = rmap_step_double(sum.optical_path);
    if (out->end_direction) {
        struct rmap_vec3 way = {0.0, 0.0, 0.0};
        if (r->stop[i] == RMAP_STOP_LEFT)
            way = rmap_vec3(ray->state[3], ray->state[4], ray->state[5]);
        rmap_step_float3(way, out->end_direction + 3 * i);
    }
}
