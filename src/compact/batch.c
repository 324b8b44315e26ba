/* SPDX-License-Identifier: MIT
 *
 * A fixed number of rays are under way at a time. Each waits in the queue of what its next segment
 * takes; eight of a queue go together, and whoever arrives makes room for the next ray of the
 * portion. So the packs stay full however much the rays' lengths differ.
 */
#include "compact/batch.h"

#include "base/alloc.h"
#include "compact/batch_kernel.h"
#include "compact/batch_sum.h"
#include "compact/detect.h"
#include "compact/retrace.h"
#include "compact/step.h"

/* What batches do ray by ray: segments that are like no others, and registrations. */

static struct rmap_vec3 position_of(const struct rmap_batch_ray *ray)
{
    return rmap_vec3(ray->state[0], ray->state[1], ray->state[2]);
}

static struct rmap_vec3 direction_of(const struct rmap_batch_ray *ray)
{
    return rmap_vec3(ray->state[3], ray->state[4], ray->state[5]);
}

/* Light on a detector that does not lie where the segment ends. */
static void cross_on_the_way(const struct rmap_detector *detector, const struct rmap_batch_ray *ray,
                             const struct rmap_vec3 *to, double length,
                             struct rmap_crossing *crossing)
{
    const struct rmap_compact_segment segment = {.from = position_of(ray),
                                                 .to = *to,
                                                 .direction = direction_of(ray),
                                                 .length = length,
                                                 .index = 1.0};
    rmap_crossing_find(detector, &segment, crossing);
}

/* Registrations on the segment in hand; their optical and group paths are distances yet.
 * The ray is as at the segment's start. */
static void batch_cross(struct rmap_batch_run *run, struct rmap_batch_ray *ray, struct rmap_vec3 to,
                        double length)
{
    const struct rmap_retrace *r = run->r;
    const struct rmap_scene *scene = r->model->scene;
    const struct rmap_registration_columns *out = &run->out->registration;
    struct rmap_crossing crossing = {.optical_path = 0.0};
    rmap_step_float3(direction_of(ray), crossing.direction);
    while (ray->crossing < ray->crossing_end && r->crossing_segment[ray->crossing] <= ray->step) {
        size_t row = ray->crossing++, its = (uint32_t)r->crossing_detector[row];
        uint16_t *cell = out->cell && !r->placed ? out->cell + 2 * row : crossing.cell;
        uint16_t *relative =
            out->relative && !r->placed ? out->relative + 2 * row : crossing.relative;
        double at[2] = {0.0, 0.0};
        crossing.optical_path = length;
        if (its >= r->model->n_detector) {
            run->batch->careful[ray->index] = 1;
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
        if (out->group_path)
            out->group_path[row] = crossing.optical_path;
    }
}

static struct rmap_turning turning_of(const struct rmap_retrace *r,
                                      const struct rmap_batch_ray *ray, struct rmap_vec3 position,
                                      double cosine)
{
    size_t row = ray->row;
    return (struct rmap_turning){.scene = r->model->scene,
                                 .object = r->object[row],
                                 .primitive = r->primitive[row],
                                 .position = position,
                                 .front = cosine < 0.0,
                                 .seed = r->seed,
                                 .ray = ray->id,
                                 .step = ray->step + 1,
                                 .event = r->event[row],
                                 .near = rmap_step_medium(r->model, r->medium[row]),
                                 .far = rmap_step_medium(r->model, r->medium[row + 1]),
                                 .channel = ray->channel};
}

static void set_off(struct rmap_batch_ray *ray, struct rmap_vec3 position,
                    struct rmap_vec3 direction)
{
    ray->state[0] = position.x;
    ray->state[1] = position.y;
    ray->state[2] = position.z;
    ray->state[3] = direction.x;
    ray->state[4] = direction.y;
    ray->state[5] = direction.z;
}

/* What the light is weighed with, with the sign of the side. */
static double met_cosine(const struct rmap_retrace *r, const struct rmap_turning *turning,
                         double cosine, struct rmap_vec3 direction, struct rmap_vec3 normal)
{
    if (!r->predicted.metals || !(cosine == cosine))
        return cosine;
    const double met = rmap_step_facet_cosine(turning, fabs(cosine), direction, normal);
    return cosine < 0.0 ? -met : met;
}

/* One segment, up to the next one. */
static void batch_advance_alone(struct rmap_batch_run *run, struct rmap_batch_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    struct rmap_facing facing = {.normal = {0.0, 0.0, 0.0}};
    struct rmap_vec3 position = position_of(ray), direction = direction_of(ray);
    size_t row = ray->row;
    const struct rmap_left left = {ray->step > 0 ? r->object[row - 1] : r->start_object[ray->index],
                                   ray->step > 0 ? r->primitive[row - 1] : -1};
    const bool goes_on = row + 1 < ray->end || r->reach == RMAP_REACH_DIRECTION;
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], &left, position,
                                direction, &facing);
    if (!met) {
        const struct rmap_medium *medium = rmap_step_medium(r->model, r->medium[row]);
        if (medium && (r->event[row] & rmap_step_inside(r->predicted.turbid)))
            run->batch->careful[ray->index] = 1;
        facing.t = rmap_step_distance_out(r->model->scene, position, direction);
        facing.position = rmap_axpy(facing.t, direction, position);
    }
    double cosine = rmap_dot(direction, facing.normal);
    ray->segment->way.length = facing.t;
    ray->segment->cosine = met ? cosine : (double)NAN;
    if (run->out->segment.position)
        rmap_step_float3(facing.position, run->out->segment.position + 3 * row);
    if (run->out->segment.normal)
        rmap_step_normal(facing.normal, run->out->segment.normal + 3 * row);
    if (ray->segment->flags & RMAP_BATCH_CROSSES)
        batch_cross(run, ray, facing.position, facing.t);
    if (met && goes_on) {
        const struct rmap_turning turning = turning_of(r, ray, facing.position, cosine);
        const struct rmap_vec3 normal =
            cosine < 0.0 ? facing.normal : rmap_scale(facing.normal, -1.0);
        ray->segment->cosine = met_cosine(r, &turning, cosine, direction, normal);
        direction = rmap_step_turned(&turning, direction, normal);
    }
    set_off(ray, facing.position, direction);
    /* what follows was taken to start on this object */
    if (!met && ray->segment->object < r->model->n_object && goes_on)
        run->batch->careful[ray->index] = 1;
}

#define LINE 64 /* bytes of a cache line */

/* So few that are left of a kind go alone. */
#define FEW 3

_Static_assert(sizeof(struct rmap_batch_ray) == 2 * LINE, "two cache lines");
_Static_assert((RMAP_BATCH_RAYS & (RMAP_BATCH_RAYS - 1)) == 0, "queues are rings");
_Static_assert(RMAP_CHANNEL_MAX <= INT16_MAX, "channels");

void rmap_batch_fini(struct rmap_batch *batch)
{
    rmap_free(batch->careful);
    rmap_free(batch->segment);
    rmap_free(batch->room);
    rmap_free(batch->queue);
    rmap_free(batch->start);
    *batch = (struct rmap_batch){0};
}

/* Slabs for r's rays; how many segments they take. *most_ret: segments of the longest ray. */
static size_t plan_slabs(struct rmap_batch *batch, const struct rmap_retrace *r, size_t *most_ret)
{
    size_t n_segment = 0, most = 0, together = 0, largest = 0;
    for (size_t i = 0; i < r->n_ray; i++) {
        size_t n = r->segment_count[i];
        together = i % RMAP_BATCH_AHEAD > 0 ? together + n : n;
        largest = together > largest ? together : largest;
        most = n > most ? n : most;
        n_segment += n;
    }
    size_t n_slab = (r->n_ray + RMAP_BATCH_AHEAD - 1) / RMAP_BATCH_AHEAD;
    n_slab = n_slab < RMAP_BATCH_SLABS ? n_slab : RMAP_BATCH_SLABS;
    bool even = n_slab * largest <= 2 * n_segment;
    batch->slab_segments = even ? largest : 0;
    batch->n_idle = even ? n_slab : 0;
    for (size_t k = 0; k < batch->n_idle; k++)
        batch->idle[k] = (uint16_t)(n_slab - 1 - k);
    batch->on_slab[0] = even ? 0 : SIZE_MAX;
    *most_ret = most;
    return even ? n_slab * largest : n_segment;
}

static enum rmap_status make_room(struct rmap_batch *batch, const struct rmap_retrace *r,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t most, n_segment = plan_slabs(batch, r, &most);
    RMAP_TRY(RMAP_RESERVE(batch->careful, batch->cap_careful, r->n_ray, err));
    /* one more: it is asked for its kind when the last one is done, to no end */
    RMAP_TRY(RMAP_RESERVE(batch->segment, batch->cap_segment, n_segment + 1, err));
    RMAP_TRY(RMAP_RESERVE(batch->start, batch->cap_start, most, err));
    RMAP_TRY(RMAP_RESERVE(batch->queue, batch->cap_queue, 1, err));
    RMAP_TRY(rmap_reserve(&batch->room, &batch->cap_room,
                          (RMAP_BATCH_RAYS + 1) * sizeof *batch->ray + LINE, 1, err));
    batch->ray = (void *)((uint8_t *)batch->room + (-(uintptr_t)batch->room & (LINE - 1)));
    memset(batch->careful, 0, r->n_ray);
    for (size_t k = 0; k <= RMAP_BATCH_QUEUES; k++)
        batch->queue->first[k] = batch->queue->end[k] = 0;
    for (size_t i = 0; i <= RMAP_BATCH_RAYS; i++)
        batch->ray[i].number = (uint16_t)i;
    batch->ray[RMAP_BATCH_RAYS].segment = &batch->nobodys;
    batch->segment[n_segment].queue = 0;
out:
    return st;
}

/* Will be read soon. Triangles lie anywhere in memory; waiting for them took a third of the time.
 */
#if defined(__GNUC__)
#define soon(address) __builtin_prefetch(address)
#else
#define soon(address) ((void)(address))
#endif

/* Behind those that wait in a queue already. */
static inline void join(struct rmap_batch_queues *queue, size_t which, uint16_t ray)
{
    queue->ray[which][queue->end[which]++ & (RMAP_BATCH_RAYS - 1)] = ray;
}

/* Lines a ray up for the segment in hand. */
static inline void line_up(const struct rmap_batch_run *run, const struct rmap_batch_ray *ray)
{
    soon(ray->segment->way.corner);
    join(run->batch->queue, ray->segment->queue, ray->number);
}

static inline uint32_t n_waiting(const struct rmap_batch_queues *queue, size_t which)
{
    return queue->end[which] - queue->first[which];
}

/* On the way none is added: rays with light given back are followed by themselves. */
static void set_delays(struct rmap_batch_run *run, const struct rmap_batch_ray *ray, double delay)
{
    const struct rmap_portion *out = run->out;
    if (out->ray.delay)
        out->ray.delay[ray->index] = delay;
    for (size_t k = ray->crossing; out->registration.delay && k < ray->crossing_end; k++)
        out->registration.delay[k] = delay;
}

/* Segments of ray i, whose registrations begin at `crossing`, that it is followed along. */
static size_t reach_of(const struct rmap_retrace *r, size_t i, size_t crossing)
{
    const size_t n = r->segment_count[i], n_crossing = r->registration_count[i];
    size_t last = 0;
    if (r->reach == RMAP_REACH_END || n == 0)
        return n;
    for (size_t k = crossing; k < crossing + n_crossing; k++)
        last = r->crossing_segment[k] > last ? r->crossing_segment[k] : last;
    last = last < n ? last : n - 1;
    return n_crossing == 0 ? 0 : last + (r->reach == RMAP_REACH_CROSSING);
}

static void set_out(struct rmap_batch_run *run, struct rmap_batch_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    if (run->ray == run->ready)
        rmap_batch_ready(run);
    size_t i = run->ray++;
    int channel = r->channel[i] > 0 ? r->channel[i] - 1 : 0;
    const struct rmap_departure *departure = &run->departure[i % RMAP_BATCH_AHEAD];
    if (run->out->ray.start)
        rmap_step_float3(departure->position, run->out->ray.start + 3 * i);
    if (run->out->ray.start_normal)
        rmap_step_normal(departure->normal, run->out->ray.start_normal + 3 * i);
    /* written one by one: read in pairs, they would wait for one another */
    ray->state[0] = departure->position.x;
    ray->state[1] = departure->position.y;
    ray->state[2] = departure->position.z;
    ray->state[3] = departure->direction.x;
    ray->state[4] = departure->direction.y;
    ray->state[5] = departure->direction.z;
    ray->segment = run->segment;
    ray->slab = run->slab;
    ray->row = run->row;
    ray->end = run->row + reach_of(r, i, run->crossing);
    ray->crossing = run->crossing;
    ray->crossing_end = run->crossing + (r->crossing_segment ? r->registration_count[i] : 0);
    ray->id = r->id[i];
    ray->index = (uint32_t)i;
    ray->step = 0;
    ray->departs = (int16_t)departure->channel;
    set_delays(run, ray, rmap_step_double(departure->delay_ns));
    ray->channel = (int16_t)(channel < r->model->n_channel ? channel : 0);
    run->row += r->segment_count[i];
    run->segment += r->segment_count[i];
    run->crossing = ray->crossing_end;
}

static inline void leave_slab(struct rmap_batch *batch, const struct rmap_batch_ray *ray)
{
    batch->idle[batch->n_idle] = ray->slab;
    batch->n_idle += --batch->on_slab[ray->slab] == 0;
}

/* At the end of its segments. */
static void arrive(struct rmap_batch_run *run, struct rmap_batch_ray *ray)
{
    const bool ahead = run->r->reach == RMAP_REACH_DIRECTION;
    if (ahead) /* on the segment that it would go along next */
        batch_cross(run, ray, position_of(ray), 0.0);
    if (ray->crossing < ray->crossing_end)
        run->batch->careful[ray->index] = 1;
    if (!ahead)
        rmap_batch_sum(run, ray);
    leave_slab(run->batch, ray);
}

/* The next rays of the portion, up to one that has a segment: false when there is none. */
static bool replace(struct rmap_batch_run *run, struct rmap_batch_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    while (run->ray < r->n_ray) {
        set_out(run, ray);
        const bool passed_over = r->passed_over && r->passed_over[ray->index];
        if (ray->row < ray->end && !passed_over)
            return true;
        if (passed_over)
            leave_slab(run->batch, ray);
        else
            arrive(run, ray);
    }
    return false;
}

/* A ray whose segment is done goes on, or to those that have arrived. No branches. */
static inline void go_on(const struct rmap_batch_run *run, struct rmap_batch_ray *ray)
{
    const struct rmap_batch_segment *next = ++ray->segment;
    bool more = ++ray->row < ray->end;
    ray->step++;
    soon(next + 1);
    soon(next->way.corner);
    join(run->batch->queue, more ? next->queue : RMAP_BATCH_QUEUES, ray->number);
}

/* Those that have arrived make room for others. */
static inline void welcome(struct rmap_batch_run *run)
{
    struct rmap_batch_queues *queue = run->batch->queue;
    while (n_waiting(queue, RMAP_BATCH_QUEUES) > 0) {
        uint32_t at = queue->first[RMAP_BATCH_QUEUES]++ & (RMAP_BATCH_RAYS - 1);
        struct rmap_batch_ray *ray = &run->batch->ray[queue->ray[RMAP_BATCH_QUEUES][at]];
        arrive(run, ray);
        if (replace(run, ray))
            line_up(run, ray);
    }
}

static void load_turns(const struct rmap_retrace *r, enum rmap_turn turn,
                       struct rmap_batch_pack *pack)
{
    size_t n = r->model->n_medium;
    for (int i = 0; i < RMAP_BATCH_WIDTH && turn == RMAP_TURN_REFRACT; i++) {
        const struct rmap_batch_ray *ray = pack->ray[i];
        const double *by_channel = r->model->index + (size_t)ray->channel * (n + 1);
        size_t near = ray->segment[0].medium, far = ray->segment[1].medium;
        bool known = near < n && far < n;
        pack->n1[i] = known ? by_channel[near] : 1.0;
        pack->n2[i] = known ? by_channel[far] : 1.0;
    }
    for (int i = 0; i < RMAP_BATCH_WIDTH && turn == RMAP_TURN_DIFFUSE; i++) {
        const struct rmap_batch_ray *ray = pack->ray[i];
        pack->random[0][i] = (uint32_t)ray->id;
        pack->random[1][i] = (uint32_t)(ray->id >> 32);
        pack->random[2][i] = ray->step + 1;
        pack->random[3][i] = RMAP_RNG_SURFACE;
        pack->through[i] = r->event[ray->row] & RMAP_EVENT_TRANSMIT_DIFFUSE ? 1.0 : 0.0;
    }
}

/* One by one: scatter models have loops of their own. */
static void scatter_pack(const struct rmap_retrace *r, size_t n, struct rmap_batch_pack *pack)
{
    for (size_t i = 0; i < n; i++) {
        const struct rmap_turning turning = turning_of(
            r, pack->ray[i], rmap_vec3(pack->px[i], pack->py[i], pack->pz[i]), pack->cosine[i]);
        const double side = pack->cosine[i] < 0.0 ? 1.0 : -1.0;
        const struct rmap_vec3 in = {pack->dx[i], pack->dy[i], pack->dz[i]},
                               normal = {pack->nx[i] * side, pack->ny[i] * side,
                                         pack->nz[i] * side};
        const struct rmap_vec3 out = rmap_step_turned(&turning, in, normal);
        pack->cosine[i] = met_cosine(r, &turning, pack->cosine[i], in, normal);
        pack->dx[i] = out.x;
        pack->dy[i] = out.y;
        pack->dz[i] = out.z;
    }
}

static void meet(const struct rmap_compact_model *model, enum rmap_batch_kind kind,
                 struct rmap_batch_pack *pack)
{
    switch (kind) {
    case RMAP_BATCH_FLAT:
        rmap_batch_meet_flats(pack);
        break;
    case RMAP_BATCH_MESH:
        rmap_batch_meet_meshes(pack);
        break;
    case RMAP_BATCH_QUADRIC:
    case RMAP_BATCH_OWN_QUADRIC:
        rmap_batch_meet_quadrics(kind == RMAP_BATCH_OWN_QUADRIC, -model->epsilon, pack);
        break;
    default:
        rmap_batch_meet_nothing(model->scene, pack);
    }
}

/* One segment of the first n rays of a queue, at most RMAP_BATCH_WIDTH; inline: most packs are
 * full. */
static inline void advance_some(struct rmap_batch_run *run, size_t which, size_t n)
{
    const struct rmap_retrace *r = run->r;
    struct rmap_batch_queues *queue = run->batch->queue;
    const uint16_t *waiting = queue->ray[which];
    enum rmap_batch_kind kind = (enum rmap_batch_kind)(which / RMAP_BATCH_TURNS);
    enum rmap_turn turn = (enum rmap_turn)(which % RMAP_BATCH_TURNS);
    struct rmap_batch_pack pack;
    struct rmap_batch_ray *to[RMAP_BATCH_WIDTH];
    size_t row[RMAP_BATCH_WIDTH], crosses[RMAP_BATCH_WIDTH + 1], n_cross = 0;
    double odd = 0.0;
    for (size_t i = 0; i < RMAP_BATCH_WIDTH; i++) {
        size_t at = waiting[(queue->first[which] + (i < n ? i : 0)) & (RMAP_BATCH_RAYS - 1)];
        pack.ray[i] = &run->batch->ray[at];
        to[i] = &run->batch->ray[i < n ? at : RMAP_BATCH_RAYS];
        row[i] = to[i]->row;
        const struct rmap_batch_segment *segment = pack.ray[i]->segment;
        pack.corner[i] = segment->way.corner;
        pack.object[i] = &r->model->object[segment->object];
        crosses[n_cross] = i;
        n_cross += i < n && (segment->flags & RMAP_BATCH_CROSSES);
    }
    queue->first[which] += (uint32_t)n;
    rmap_batch_load(&pack);
    load_turns(r, turn, &pack);
    meet(r->model, kind, &pack);
    if (n == RMAP_BATCH_WIDTH && turn != RMAP_TURN_NONE)
        rmap_batch_note_on(&pack, row, run->out->segment.position, run->out->segment.normal);
    else
        rmap_batch_note(&pack, row, n, run->out->segment.position, run->out->segment.normal);
    for (size_t k = 0; k < n_cross; k++) {
        size_t i = crosses[k];
        batch_cross(run, to[i], rmap_vec3(pack.px[i], pack.py[i], pack.pz[i]), pack.t[i]);
    }
    if (turn == RMAP_TURN_SCATTER)
        scatter_pack(r, n, &pack);
    else if (turn != RMAP_TURN_NONE)
        rmap_batch_turn(turn, r->seed, &pack);
    rmap_batch_store(&pack, to);
    for (size_t i = 0; i < RMAP_BATCH_WIDTH; i++)
        odd += pack.odd[i];
    for (size_t i = 0; odd != 0.0 && i < n; i++)
        if (pack.odd[i] != 0.0)
            run->batch->careful[to[i]->index] = 1;
    for (size_t i = 0; i < n; i++)
        go_on(run, to[i]);
    welcome(run);
}

static void advance_pack(struct rmap_batch_run *run, size_t which, size_t n)
{
    if (n == RMAP_BATCH_WIDTH)
        advance_some(run, which, RMAP_BATCH_WIDTH);
    else
        advance_some(run, which, n);
}

static void advance_alone(struct rmap_batch_run *run, size_t which)
{
    struct rmap_batch_queues *queue = run->batch->queue;
    uint32_t at = queue->first[which]++ & (RMAP_BATCH_RAYS - 1);
    struct rmap_batch_ray *ray = &run->batch->ray[queue->ray[which][at]];
    batch_advance_alone(run, ray);
    go_on(run, ray);
    welcome(run);
}

/* All full packs that there are; false when there was none. */
static bool advance_full(struct rmap_batch_run *run)
{
    const struct rmap_batch_queues *queue = run->batch->queue;
    bool some = false;
    for (size_t k = 0; k < RMAP_BATCH_QUEUES; k++) {
        bool alone = k / RMAP_BATCH_TURNS == RMAP_BATCH_ALONE;
        some =
            some || n_waiting(queue, k) >= RMAP_BATCH_WIDTH || (alone && n_waiting(queue, k) > 0);
        while (alone && n_waiting(queue, k) > 0)
            advance_alone(run, k);
        while (n_waiting(queue, k) >= RMAP_BATCH_WIDTH)
            advance_pack(run, k, RMAP_BATCH_WIDTH);
    }
    return some;
}

enum rmap_status rmap_batch_run(struct rmap_batch *batch, const struct rmap_retrace *r,
                                struct rmap_portion *predicted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_batch_run run = {.batch = batch, .r = r, .out = predicted};
    RMAP_TRY(make_room(batch, r, err));
    for (size_t i = 0; i < RMAP_BATCH_RAYS; i++)
        if (replace(&run, &batch->ray[i]))
            line_up(&run, &batch->ray[i]);
    for (;;) {
        size_t most = 0;
        while (advance_full(&run))
            ;
        for (size_t k = 0; k < RMAP_BATCH_QUEUES; k++)
            most = n_waiting(batch->queue, k) > n_waiting(batch->queue, most) ? k : most;
        uint32_t n = n_waiting(batch->queue, most);
        if (n == 0)
            break;
        if (n < FEW)
            advance_alone(&run, most);
        else
            advance_pack(&run, most, n);
    }
out:
    return st;
}
