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
    const struct rmap_wave_leg *leg;
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
    return medium->dispersive ? rmap_colour_sum(&light->colour, medium->n)
                              : medium->n[light->colour.begin];
}

static inline void note_colour(const struct rmap_compact_light *light, size_t n, uint16_t *out)
{
    if (n == 3) /* worth a copy of constant size */
        memcpy(out, light->quantised, 3 * sizeof *out);
    else
        memcpy(out, light->quantised, n * sizeof *out);
}

/* Registrations of a ray that has been summed up: their optical paths are distances from their
 * legs' starts yet. */
static void sum_crossings(const struct sum *sum, size_t crossing, size_t crossing_end)
{
    const struct rmap_wave_start *start = sum->run->wave->start;
    const uint32_t *segment = sum->run->r->crossing_segment;
    double *optical_path = sum->run->out->registration.optical_path;
    size_t leg = 0;
    for (; crossing < crossing_end; crossing++) {
        leg = segment[crossing] > leg ? segment[crossing] : leg;
        optical_path[crossing] =
            rmap_step_double(start[leg].optical_path + start[leg].index * optical_path[crossing]);
    }
}

/* One leg, at which the light may change. */
static void sum_leg(struct sum *sum, size_t row, struct rmap_compact_light *light)
{
    const struct rmap_retrace *r = sum->run->r;
    const struct rmap_wave_leg *leg = &sum->leg[row - sum->first];
    const struct rmap_medium *medium = rmap_step_medium(r->model, leg->medium);
    double index = index_of(light, medium);
    if (medium && medium->absorbing && leg->way.length > 0.0 && !rmap_colour_single(&light->colour))
        (void)rmap_light_absorb(medium, r->seed, r->id[sum->index], 0, leg->way.length, false,
                                light);
    if (light->changed)
        rmap_light_quantise(r->model->n_channel, light);
    size_t n = (size_t)r->model->n_channel;
    if (sum->run->out->colour)
        note_colour(light, n, sum->run->out->colour + n * row);
    sum->run->wave->start[row - sum->first] =
        (struct rmap_wave_start){.optical_path = sum->optical_path, .index = index};
    if (!(leg->flags & RMAP_WAVE_LEFT)) {
        sum->path_length += leg->way.length;
        sum->optical_path += index * leg->way.length;
    }
    if (row + 1 < sum->end && !rmap_colour_single(&light->colour))
        weigh_leg(sum, row, leg, light);
    if (light->changed && !(leg[1].flags & RMAP_WAVE_TINTS)) /* or else it changes once more */
        rmap_light_quantise(r->model->n_channel, light);
}

/* What holds on legs that leave the light as it is. */
struct steady {
    uint32_t any, tints; /* flags that it is taken to have; flags that it may not have */
    const double *index; /* by medium */
    double path_length, optical_path;
};

static inline bool leaves(const struct rmap_wave_leg *leg, const struct steady *s)
{
    uint32_t flags = leg->flags, grey = RMAP_WAVE_GREY_BACK << (leg->cosine < 0.0);
    return !((flags & s->tints) | (~(flags | s->any) & grey));
}

static inline void pass_leg(const struct rmap_wave_leg *leg, struct steady *s,
                            struct rmap_wave_start *start)
{
    double n = s->index[leg->medium], length = leg->way.length;
    length = leg->flags & RMAP_WAVE_LEFT ? 0.0 : length;
    start->optical_path = s->optical_path;
    start->index = n;
    s->path_length += length;
    s->optical_path += n * length;
}

/* Legs from `row` on up to the first at which the light may change; which one that is. colour: of
 * n channels each, or NULL. */
static inline size_t sum_steady(struct sum *sum, size_t row, const struct rmap_compact_light *light,
                                size_t n_channel, uint16_t *colour)
{
    const struct rmap_compact_model *model = sum->run->r->model;
    bool single = rmap_colour_single(&light->colour);
    struct steady s = {.any = single ? RMAP_WAVE_GREY_BACK | RMAP_WAVE_GREY_FRONT : 0,
                       .tints = single ? 0 : RMAP_WAVE_TINTS,
                       .index = model->index + (model->n_medium + 1) * (size_t)light->colour.begin,
                       .path_length = sum->path_length,
                       .optical_path = sum->optical_path};
    const struct rmap_wave_leg *leg = &sum->leg[row - sum->first];
    struct rmap_wave_start *start = &sum->run->wave->start[row - sum->first];
    size_t last = sum->end - 1;
    uint64_t four;
    memcpy(&four, light->quantised, sizeof four);
    for (; row < last && leaves(leg, &s); row++, leg++, start++) {
        pass_leg(leg, &s, start);
        if (colour && n_channel == 3) /* and one of the next row, which takes it back */
            memcpy(colour + 3 * row, &four, sizeof four);
        else if (colour)
            note_colour(light, n_channel, colour + n_channel * row);
    }
    if (row == last && leaves(leg, &s)) {
        pass_leg(leg, &s, start);
        if (colour)
            note_colour(light, n_channel, colour + n_channel * row);
        row++;
    }
    sum->path_length = s.path_length;
    sum->optical_path = s.optical_path;
    return row;
}

static size_t sum_along(struct sum *sum, size_t row, const struct rmap_compact_light *light)
{
    size_t n = (size_t)sum->run->r->model->n_channel;
    uint16_t *colour = sum->run->r->colour ? sum->run->out->colour : NULL;
    if (n == 3 && colour)
        return sum_steady(sum, row, light, 3, colour);
    return sum_steady(sum, row, light, n, colour);
}

/* As it leaves the source. */
static void begin_light(struct rmap_wave_run *run, size_t i, int departs)
{
    const struct rmap_retrace *r = run->r;
    if (r->colour) {
        rmap_light_begin(r->model, r->source[i], departs, &run->light);
        return;
    }
    run->light.colour.begin = 0;
    run->light.colour.end = 1;
    run->light.changed = false;
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
                      .leg = ray->leg - r->segment_count[i],
                      .channel = channel};
    begin_light(run, i, ray->departs);
    for (size_t row = sum.first; row < sum.end; row++) {
        row = run->light.changed ? row : sum_along(&sum, row, &run->light);
        if (row == sum.end)
            break;
        sum_leg(&sum, row, &run->light);
    }
    if (crossings)
        sum_crossings(&sum, ray->crossing_end - r->registration_count[i], ray->crossing);
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
