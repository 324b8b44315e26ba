/* SPDX-License-Identifier: MIT
 *
 * Colours and lengths along a ray, once a batch knows its segments.
 */
#include "compact/batch_sum.h"
#include "base/wide.h"
#include "compact/batch.h"
#include "compact/batch_guide.h"
#include "compact/batch_kernel.h"
#include "compact/retrace.h"
#include "compact/retrace_colour.h"
#include "compact/step.h"
#include "trace/turbid.h"

/* The ray in hand. */
struct sum {
    struct rmap_batch_run *run;
    size_t index, first, end; /* of the ray, of its segments */
    const struct rmap_batch_segment *segment;
    int channel; /* that it ends with; -1: several */
    double path_length, optical_path;
};

static void weigh_segment(const struct sum *sum, size_t row,
                          const struct rmap_batch_segment *segment,
                          struct rmap_compact_light *light)
{
    const struct rmap_retrace *r = sum->run->r;
    double cosine = segment->cosine, size = cosine < 0.0 ? -cosine : cosine;
    if (!(size >= 0.0)) /* nothing met */
        return;
    uint32_t object = segment->object;
    if (r->event[row] & r->model->guide[object].grey[cosine < 0.0])
        return;
    const struct rmap_medium *near = rmap_step_medium(r->model, segment->medium);
    if (!near)
        return;
    const struct rmap_compact_object *o = &r->model->object[object];
    const struct rmap_encounter encounter = {
        .scene = r->model->scene,
        .object = (int32_t)object,
        .front = cosine < 0.0,
        .surface = cosine < 0.0 ? o->front : o->back,
        .predicted = &r->predicted,
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
 * segments' starts yet. */
static void sum_crossings(const struct sum *sum, size_t crossing, size_t crossing_end,
                          double *optical_path)
{
    const struct rmap_batch_start *start = sum->run->batch->start;
    const uint32_t *crossed = sum->run->r->crossing_segment;
    size_t segment = 0;
    for (; crossing < crossing_end; crossing++) {
        segment = crossed[crossing] > segment ? crossed[crossing] : segment;
        optical_path[crossing] = rmap_step_double(start[segment].optical_path +
                                                  start[segment].index * optical_path[crossing]);
    }
}

/* One segment, at which the light may change. */
static void sum_segment(struct sum *sum, size_t row, struct rmap_compact_light *light)
{
    const struct rmap_retrace *r = sum->run->r;
    const struct rmap_batch_segment *segment = &sum->segment[row - sum->first];
    const struct rmap_medium *medium = rmap_step_medium(r->model, segment->medium);
    double index = index_of(light, medium);
    if (medium && rmap_medium_participates(medium) && segment->way.length > 0.0 &&
        !rmap_colour_single(&light->colour))
        (void)rmap_light_travel(&(struct rmap_inside){.medium = medium,
                                                      .turbid = r->predicted.turbid,
                                                      .length = segment->way.length},
                                light);
    if (light->changed)
        rmap_light_quantise(r->model->n_channel, light);
    size_t n = (size_t)r->model->n_channel;
    if (sum->run->out->colour)
        note_colour(light, n, sum->run->out->colour + n * row);
    sum->run->batch->start[row - sum->first] =
        (struct rmap_batch_start){.optical_path = sum->optical_path, .index = index};
    if (!(segment->flags & RMAP_BATCH_LEFT)) {
        sum->path_length += segment->way.length;
        sum->optical_path += index * segment->way.length;
    }
    if (row + 1 < sum->end && !rmap_colour_single(&light->colour))
        weigh_segment(sum, row, segment, light);
    if (light->changed && !(segment[1].flags & RMAP_BATCH_TINTS)) /* or else it changes once more */
        rmap_light_quantise(r->model->n_channel, light);
}

/* What holds on segments that leave the light as it is. */
struct steady {
    uint32_t any, tints; /* flags that it is taken to have; flags that it may not have */
    const double *index; /* by medium */
    double path_length, optical_path;
};

static inline bool leaves(const struct rmap_batch_segment *segment, const struct steady *s)
{
    uint32_t flags = segment->flags, grey = RMAP_BATCH_GREY_BACK << (segment->cosine < 0.0);
    return !((flags & s->tints) | (~(flags | s->any) & grey));
}

static inline void pass_segment(const struct rmap_batch_segment *segment, struct steady *s,
                                struct rmap_batch_start *start)
{
    double n = s->index[segment->medium], length = segment->way.length;
    length = segment->flags & RMAP_BATCH_LEFT ? 0.0 : length;
    start->optical_path = s->optical_path;
    start->index = n;
    s->path_length += length;
    s->optical_path += n * length;
}

/* Segments from `row` on up to the first at which the light may change; which one that is. colour:
 * of n channels each, or NULL. */
static inline size_t sum_steady(struct sum *sum, size_t row, const struct rmap_compact_light *light,
                                size_t n_channel, uint16_t *colour)
{
    const struct rmap_compact_model *model = sum->run->r->model;
    bool single = rmap_colour_single(&light->colour);
    struct steady s = {.any = single ? RMAP_BATCH_GREY_BACK | RMAP_BATCH_GREY_FRONT : 0,
                       .tints = single ? 0 : RMAP_BATCH_TINTS,
                       .index = model->index + (model->n_medium + 1) * (size_t)light->colour.begin,
                       .path_length = sum->path_length,
                       .optical_path = sum->optical_path};
    const struct rmap_batch_segment *segment = &sum->segment[row - sum->first];
    struct rmap_batch_start *start = &sum->run->batch->start[row - sum->first];
    size_t last = sum->end - 1;
    uint64_t four;
    memcpy(&four, light->quantised, sizeof four);
    for (; row < last && leaves(segment, &s); row++, segment++, start++) {
        pass_segment(segment, &s, start);
        if (colour && n_channel == 3) /* and one of the next row, which takes it back */
            memcpy(colour + 3 * row, &four, sizeof four);
        else if (colour)
            note_colour(light, n_channel, colour + n_channel * row);
    }
    if (row == last && leaves(segment, &s)) {
        pass_segment(segment, &s, start);
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

/* Of a ray that has one channel, where groups have indices of their own. */
static double sum_own_group(const struct sum *sum, size_t crossing, size_t crossing_end, double *at)
{
    const struct rmap_batch_run *run = sum->run;
    const struct rmap_compact_model *model = run->r->model;
    const uint32_t *crossed = run->r->crossing_segment;
    const double *index = model->group + (model->n_medium + 1) * (size_t)run->light.colour.begin;
    const size_t n = sum->end - sum->first;
    double group_path = 0.0;
    for (size_t k = 0; k < n; k++) {
        const struct rmap_batch_segment *segment = &sum->segment[k];
        const double n_group = index[segment->medium];
        for (; at && crossing < crossing_end && (crossed[crossing] <= k || k + 1 == n); crossing++)
            at[crossing] = rmap_step_double(group_path + n_group * at[crossing]);
        if (!(segment->flags & RMAP_BATCH_LEFT))
            group_path += n_group * segment->way.length;
    }
    return group_path;
}

/* Group paths of a ray that has been summed up; those of its registrations are distances yet. */
static void sum_group(const struct sum *sum, size_t crossing, size_t crossing_end)
{
    struct rmap_portion *out = sum->run->out;
    double *at = out->registration.group_path, group_path = sum->optical_path;
    if (sum->run->r->model->group)
        group_path = sum_own_group(sum, crossing, crossing_end, at);
    else if (at)
        sum_crossings(sum, crossing, crossing_end, at);
    if (out->ray.group_path)
        out->ray.group_path[sum->index] = rmap_step_double(group_path);
}

/* As it leaves the source. */
static void begin_light(struct rmap_batch_run *run, size_t i, int departs)
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

void rmap_batch_sum(struct rmap_batch_run *run, const struct rmap_batch_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    const struct rmap_ray_columns *out = &run->out->ray;
    size_t i = ray->index;
    const size_t crossing =
        ray->crossing_end - (r->crossing_segment ? r->registration_count[i] : 0);
    int channel = r->channel[i] <= r->model->n_channel ? (int)r->channel[i] - 1 : -1;
    struct sum sum = {.run = run,
                      .index = i,
                      .first = ray->end - ray->step,
                      .end = ray->end,
                      .segment = ray->segment - ray->step,
                      .channel = channel};
    begin_light(run, i, ray->departs);
    for (size_t row = sum.first; row < sum.end; row++) {
        row = run->light.changed ? row : sum_along(&sum, row, &run->light);
        if (row == sum.end)
            break;
        sum_segment(&sum, row, &run->light);
    }
    if (run->out->registration.optical_path)
        sum_crossings(&sum, crossing, ray->crossing, run->out->registration.optical_path);
    if (r->model->group && !rmap_colour_single(&run->light.colour))
        run->batch->careful[i] = 1; /* of no map that this program writes */
    else if (out->group_path || run->out->registration.group_path)
        sum_group(&sum, crossing, ray->crossing);
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

/* Rays that are about to set out in a batch: where they depart, and what each of their segments
 * takes.
 */

#if defined(__GNUC__)
static inline uint32_t first_bit(uint32_t x) /* x > 0 */
{
    return (uint32_t)__builtin_ctz(x);
}
#define soon(address) __builtin_prefetch(address, 1)
#else
static inline uint32_t first_bit(uint32_t x)
{
    uint32_t k = 0;
    while (!(x >> k & 1))
        k++;
    return k;
}
#define soon(address) ((void)(address))
#endif

/* What segments follow from, in registers. */
struct segments {
    const int32_t *object, *primitive;
    const uint32_t *event;
    const int16_t *medium;
    const struct rmap_compact_guide *guide;
    const uint16_t *tint;
    size_t n_object, n_medium;
};

/* The segment of a row that starts on the object `from`, has one event and is not the last. No
 * branches: what a ray meets is anybody's guess. True: its triangle is not there. */
static inline bool set_segment(const struct segments *l, size_t row, int32_t from,
                               struct rmap_batch_segment *segment)
{
    size_t object = (uint32_t)l->object[row], primitive = (uint32_t)l->primitive[row];
    size_t medium = (uint16_t)l->medium[row];
    uint32_t event = l->event[row], same = (uint32_t)0 - (l->object[row] == from);
    object = object < l->n_object ? object : l->n_object;
    medium = medium < l->n_medium ? medium : l->n_medium;
    const struct rmap_compact_guide *guide = &l->guide[object];
    uint32_t step = guide->step[first_bit(event | 1u << (RMAP_GUIDE_STEPS - 1))];
    segment->way.corner = guide->corner + guide->stride * primitive;
    segment->object = (uint32_t)object;
    segment->medium = (uint16_t)medium;
    segment->step = (uint16_t)(step + (guide->quadric & same) + l->tint[medium]);
    return primitive >= guide->n_primitive;
}

/* Has any row several events, or one that no guide knows? */
RMAP_WIDE static bool any_odd(const uint32_t *event, size_t n)
{
    uint32_t odd = 0;
    for (size_t i = 0; i < n; i++)
        odd |= (event[i] & (event[i] - 1)) | event[i] >> (RMAP_GUIDE_STEPS - 1);
    return odd != 0;
}

/* With several events, or a triangle that is not there. */
static void set_odd_segment(const struct segments *l, size_t row, int32_t from,
                            struct rmap_batch_segment *segment)
{
    const struct rmap_compact_guide *guide = &l->guide[segment->object];
    bool there = (uint32_t)l->primitive[row] < guide->n_primitive;
    uint32_t own = there && l->object[row] == from ? guide->quadric : 0;
    uint32_t step =
        own + rmap_batch_step(guide, there ? guide->batch : RMAP_BATCH_ALONE, l->event[row]);
    segment->way.corner = there ? segment->way.corner : guide->corner;
    segment->step = (uint16_t)(step | l->tint[segment->medium]);
}

/* Segments of rows [first, end). */
static void set_segments(const struct rmap_retrace *r, size_t first, size_t end,
                         struct rmap_batch_segment *to)
{
    const struct segments l = {.object = r->object,
                               .primitive = r->primitive,
                               .event = r->event,
                               .medium = r->medium,
                               .guide = r->model->guide,
                               .tint = r->model->tint,
                               .n_object = r->model->n_object,
                               .n_medium = r->model->n_medium};
    int32_t from = -1;
    bool odd = any_odd(r->event + first, end - first);
    for (size_t k = first; k < end; k++) {
        odd |= set_segment(&l, k, from, &to[k - first]);
        from = l.object[k];
    }
    for (size_t k = first; odd && k < end; k++)
        if (set_segment(&l, k, k > first ? l.object[k - 1] : -1, &to[k - first]) ||
            any_odd(l.event + k, 1))
            set_odd_segment(&l, k, k > first ? l.object[k - 1] : -1, &to[k - first]);
}

/* Of the ray that is made ready next. */
static void mark_crossings(struct rmap_batch_run *run, struct rmap_batch_segment *segment, size_t n)
{
    const uint32_t *crossed = run->r->crossing_segment + run->ready_crossing;
    size_t n_crossing = run->r->registration_count[run->ready];
    for (size_t k = 0; k < n_crossing; k++)
        if (crossed[k] < n)
            segment[crossed[k]].flags |= RMAP_BATCH_CROSSES;
    run->ready_crossing += n_crossing;
}

/* A quadric of a ray's first segment may be the one that the ray starts on. */
static void set_first(const struct rmap_retrace *r, size_t ray, struct rmap_batch_segment *segment)
{
    uint32_t kind = segment->queue / RMAP_BATCH_TURNS, turn = segment->queue % RMAP_BATCH_TURNS;
    bool own = r->start_object[ray] >= 0 && (uint32_t)r->start_object[ray] == segment->object;
    if (kind != RMAP_BATCH_QUADRIC && kind != RMAP_BATCH_OWN_QUADRIC)
        return;
    kind = own ? RMAP_BATCH_OWN_QUADRIC : RMAP_BATCH_QUADRIC;
    segment->queue = (uint8_t)(kind * RMAP_BATCH_TURNS + turn);
}

/* A slab for n rays. */
static void open_slab(struct rmap_batch_run *run, size_t n)
{
    struct rmap_batch *batch = run->batch;
    if (batch->slab_segments == 0) {
        run->segment = batch->segment + run->ready_row;
        return;
    }
    run->slab = batch->idle[--batch->n_idle];
    run->segment = batch->segment + run->slab * batch->slab_segments;
    batch->on_slab[run->slab] = n;
}

/* Rows that will be written here and there, brought nearer in one go: rays go on in no order that
 * a processor foresees. */
RMAP_COPIED void expect(const void *column, size_t row_nbytes, size_t first, size_t end)
{
    enum { LINE = 64 };
    const uint8_t *at = (const uint8_t *)column + first * row_nbytes;
    for (size_t k = 0; column && k < (end - first) * row_nbytes; k += LINE)
        soon(at + k);
}

RMAP_COPIED void expect_rows(const struct rmap_portion *out, size_t first, size_t end)
{
    const struct rmap_segment_columns *segment = &out->segment;
    expect(segment->position, 3 * sizeof *segment->position, first, end);
    expect(segment->normal, 3 * sizeof *segment->normal, first, end);
    expect(out->colour, (size_t)out->n_channel * sizeof *out->colour, first, end);
}

void rmap_batch_ready(struct rmap_batch_run *run)
{
    const struct rmap_retrace *r = run->r;
    size_t row = run->ready_row, end = row;
    size_t last =
        run->ready + RMAP_BATCH_AHEAD < r->n_ray ? run->ready + RMAP_BATCH_AHEAD : r->n_ray;
    open_slab(run, last - run->ready);
    struct rmap_batch_segment *segment = run->segment;
    rmap_batch_depart(r, run->ready, last, run->departure);
    for (size_t i = run->ready; i < last; i++)
        end += r->segment_count[i];
    set_segments(r, row, end, segment);
    for (; run->ready < last; run->ready++) {
        size_t n = r->segment_count[run->ready];
        if (n > 0)
            set_first(r, run->ready, segment);
        if (r->crossing_segment)
            mark_crossings(run, segment, n);
        segment += n;
        if (n == 0)
            continue;
        segment[-1].queue &= (uint8_t) ~(RMAP_BATCH_TURNS - 1);
        segment[-1].flags |= RMAP_BATCH_GREY_BACK | RMAP_BATCH_GREY_FRONT;
    }
    run->ready_row = end;
    expect_rows(run->out, row, end);
}
