/* SPDX-License-Identifier: MIT
 *
 * A fixed number of rays are under way at a time. Each waits in the queue of what its next leg
 * takes; eight of a queue go together, and whoever arrives makes room for the next ray of the
 * portion. So the packs stay full however much the rays' lengths differ.
 */
#include "compact/wave.h"
#include "base/alloc.h"
#include "compact/detect.h"
#include "compact/retrace.h"
#include "compact/step.h"
#include "compact/wave_kernel.h"
#include "compact/wave_sum.h"

/* What waves know of an object beforehand. */

static bool alike(const double *value, int n)
{
    for (int i = 1; i < n; i++)
        if (value[i] != value[0])
            return false;
    return true;
}

/* Events at a side of a surface that weigh all channels alike (retrace_colour.c). */
static uint32_t grey_events(const struct rmap_scene *scene, const struct rmap_surface *surface)
{
    bool dispersive = false;
    int n = scene->channels.n;
    uint32_t grey = 0;
    for (size_t i = 0; i < scene->n_medium; i++)
        dispersive = dispersive || scene->medium[i].dispersive;
    if (surface->type == RMAP_SURFACE_FRESNEL)
        return dispersive || surface->coat == RMAP_COAT_REFLECTANCE ? 0 : UINT32_MAX;
    if (!(surface->type == RMAP_SURFACE_MIRROR && surface->is_metal) &&
        alike(surface->reflect_specular, n))
        grey |= RMAP_EVENT_REFLECT_SPECULAR;
    if (alike(surface->reflect_diffuse, n))
        grey |= RMAP_EVENT_REFLECT_DIFFUSE;
    if (alike(surface->transmit_diffuse, n))
        grey |= RMAP_EVENT_TRANSMIT_DIFFUSE;
    if (!dispersive && alike(surface->transmit_specular, n))
        grey |= RMAP_EVENT_TRANSMIT_SPECULAR;
    return grey;
}

void rmap_wave_set_flat(struct rmap_compact_object *object)
{
    struct rmap_vec3 normal = rmap_affine_transposed(&object->to_local, rmap_vec3(0.0, 0.0, 1.0));
    int16_t recorded[4] = {0};
    if (!object->rigid)
        normal = rmap_normalize(normal);
    rmap_step_normal(normal, recorded);
    object->flat[0] = normal.x;
    object->flat[1] = normal.y;
    object->flat[2] = normal.z;
    memcpy(&object->flat[3], recorded, sizeof recorded);
}

uint32_t rmap_wave_step(const struct rmap_compact_guide *guide, uint32_t kind, uint32_t event)
{
    uint32_t turn = kind > RMAP_WAVE_NOTHING ? (uint32_t)rmap_step_turn(event) : RMAP_TURN_NONE;
    uint32_t flags = (event & RMAP_EVENT_LEFT ? RMAP_WAVE_LEFT : 0) |
                     (event & guide->grey[0] ? RMAP_WAVE_GREY_BACK : 0) |
                     (event & guide->grey[1] ? RMAP_WAVE_GREY_FRONT : 0);
    return flags << 8 | (kind * RMAP_WAVE_TURNS + turn);
}

static void set_steps(struct rmap_compact_guide *guide)
{
    for (int k = 0; k < RMAP_GUIDE_STEPS; k++) {
        uint32_t event = k + 1 < RMAP_GUIDE_STEPS ? 1u << k : 0;
        guide->step[k] = (uint16_t)rmap_wave_step(guide, guide->wave, event);
    }
}

void rmap_wave_guide(const struct rmap_scene *scene, const struct rmap_compact_object *object,
                     struct rmap_compact_guide *guide)
{
    guide->grey[0] = grey_events(scene, object->back);
    guide->grey[1] = grey_events(scene, object->front);
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)&object->to_local;
    switch (object->kind) {
    case RMAP_FACING_FLAT:
        guide->wave = RMAP_WAVE_FLAT;
        break;
    case RMAP_FACING_QUADRIC:
        guide->wave = RMAP_WAVE_QUADRIC;
        guide->quadric = RMAP_WAVE_TURNS;
        break;
    case RMAP_FACING_ASPHERE:
        guide->wave = RMAP_WAVE_ALONE;
        break;
    case RMAP_FACING_MESH:
        guide->wave = object->corner ? RMAP_WAVE_MESH : RMAP_WAVE_ALONE;
        guide->n_primitive = object->mesh->n_triangle;
        if (object->corner) {
            guide->corner = (const float *)object->corner;
            guide->stride = sizeof *object->corner / sizeof(float);
        }
        break;
    }
    set_steps(guide);
}

void rmap_wave_guide_out(const struct rmap_compact_model *model, struct rmap_compact_guide *guide)
{
    guide->wave = model->absorbing ? RMAP_WAVE_ALONE : RMAP_WAVE_NOTHING;
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)model->object;
    set_steps(guide);
}

/* What waves do ray by ray: legs that are like no others, and registrations. */

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

/* wave.c: registrations on the leg in hand; their optical paths are distances yet. The ray
 * is as at the leg's start. */
static void wave_cross(struct rmap_wave_run *run, struct rmap_wave_ray *ray, struct rmap_vec3 to,
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

/* wave.c: one leg, up to the next one. */
static void wave_advance_alone(struct rmap_wave_run *run, struct rmap_wave_ray *ray)
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
        wave_cross(run, ray, facing.position, facing.t);
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

#define LINE 64 /* bytes of a cache line */

/* So few that are left of a kind go alone. */
#define FEW 3

_Static_assert(sizeof(struct rmap_wave_ray) == 2 * LINE, "two cache lines");
_Static_assert((RMAP_WAVE_RAYS & (RMAP_WAVE_RAYS - 1)) == 0, "queues are rings");
_Static_assert(RMAP_CHANNEL_MAX <= INT16_MAX, "channels");

void rmap_wave_fini(struct rmap_wave *wave)
{
    rmap_free(wave->careful);
    rmap_free(wave->leg);
    rmap_free(wave->room);
    rmap_free(wave->queue);
    rmap_free(wave->start);
    *wave = (struct rmap_wave){0};
}

/* Shelves for r's rays; how many legs they take. *most_ret: legs of the longest ray. */
static size_t plan_shelves(struct rmap_wave *wave, const struct rmap_retrace *r, size_t *most_ret)
{
    size_t n_leg = 0, most = 0, together = 0, largest = 0;
    for (size_t i = 0; i < r->n_ray; i++) {
        size_t n = r->segment_count[i];
        together = i % RMAP_WAVE_AHEAD > 0 ? together + n : n;
        largest = together > largest ? together : largest;
        most = n > most ? n : most;
        n_leg += n;
    }
    size_t n_shelf = (r->n_ray + RMAP_WAVE_AHEAD - 1) / RMAP_WAVE_AHEAD;
    n_shelf = n_shelf < RMAP_WAVE_SHELVES ? n_shelf : RMAP_WAVE_SHELVES;
    bool even = n_shelf * largest <= 2 * n_leg;
    wave->shelf_legs = even ? largest : 0;
    wave->n_idle = even ? n_shelf : 0;
    for (size_t k = 0; k < wave->n_idle; k++)
        wave->idle[k] = (uint16_t)(n_shelf - 1 - k);
    wave->on_shelf[0] = even ? 0 : SIZE_MAX;
    *most_ret = most;
    return even ? n_shelf * largest : n_leg;
}

static enum rmap_status make_room(struct rmap_wave *wave, const struct rmap_retrace *r,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t most, n_leg = plan_shelves(wave, r, &most);
    RMAP_TRY(RMAP_RESERVE(wave->careful, wave->cap_careful, r->n_ray, err));
    /* one more: it is asked for its kind when the last one is done, to no end */
    RMAP_TRY(RMAP_RESERVE(wave->leg, wave->cap_leg, n_leg + 1, err));
    RMAP_TRY(RMAP_RESERVE(wave->start, wave->cap_start, most, err));
    RMAP_TRY(RMAP_RESERVE(wave->queue, wave->cap_queue, 1, err));
    RMAP_TRY(rmap_reserve(&wave->room, &wave->cap_room,
                          (RMAP_WAVE_RAYS + 1) * sizeof *wave->ray + LINE, 1, err));
    wave->ray = (void *)((uint8_t *)wave->room + (-(uintptr_t)wave->room & (LINE - 1)));
    memset(wave->careful, 0, r->n_ray);
    for (size_t k = 0; k <= RMAP_WAVE_QUEUES; k++)
        wave->queue->first[k] = wave->queue->end[k] = 0;
    for (size_t i = 0; i <= RMAP_WAVE_RAYS; i++)
        wave->ray[i].number = (uint16_t)i;
    wave->ray[RMAP_WAVE_RAYS].leg = &wave->nobodys;
    wave->leg[n_leg].queue = 0;
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
static inline void join(struct rmap_wave_queues *queue, size_t which, uint16_t ray)
{
    queue->ray[which][queue->end[which]++ & (RMAP_WAVE_RAYS - 1)] = ray;
}

/* Lines a ray up for the leg in hand. */
static inline void line_up(const struct rmap_wave_run *run, const struct rmap_wave_ray *ray)
{
    soon(ray->leg->way.corner);
    join(run->wave->queue, ray->leg->queue, ray->number);
}

static inline uint32_t n_waiting(const struct rmap_wave_queues *queue, size_t which)
{
    return queue->end[which] - queue->first[which];
}

static void set_out(struct rmap_wave_run *run, struct rmap_wave_ray *ray)
{
    const struct rmap_retrace *r = run->r;
    if (run->ray == run->ready)
        rmap_wave_ready(run);
    size_t i = run->ray++;
    int channel = r->channel[i] > 0 ? r->channel[i] - 1 : 0;
    const struct rmap_departure *departure = &run->departure[i % RMAP_WAVE_AHEAD];
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
    ray->leg = run->leg;
    ray->shelf = run->shelf;
    ray->row = run->row;
    ray->end = run->row + r->segment_count[i];
    ray->crossing = run->crossing;
    ray->crossing_end = run->crossing + (r->crossing_segment ? r->registration_count[i] : 0);
    ray->id = r->id[i];
    ray->index = (uint32_t)i;
    ray->step = 0;
    ray->departs = (int16_t)departure->channel;
    ray->channel = (int16_t)(channel < r->model->n_channel ? channel : 0);
    run->row = ray->end;
    run->leg += r->segment_count[i];
    run->crossing = ray->crossing_end;
}

static inline void leave_shelf(struct rmap_wave *wave, const struct rmap_wave_ray *ray)
{
    wave->idle[wave->n_idle] = ray->shelf;
    wave->n_idle += --wave->on_shelf[ray->shelf] == 0;
}

/* At the end of its legs. */
static void arrive(struct rmap_wave_run *run, struct rmap_wave_ray *ray)
{
    rmap_wave_sum(run, ray);
    leave_shelf(run->wave, ray);
}

/* The next rays of the portion, up to one that has a leg: false when there is none. */
static bool replace(struct rmap_wave_run *run, struct rmap_wave_ray *ray)
{
    while (run->ray < run->r->n_ray) {
        set_out(run, ray);
        if (ray->row < ray->end)
            return true;
        arrive(run, ray);
    }
    return false;
}

/* A ray whose leg is done goes on, or to those that have arrived. No branches. */
static inline void go_on(const struct rmap_wave_run *run, struct rmap_wave_ray *ray)
{
    const struct rmap_wave_leg *next = ++ray->leg;
    bool more = ++ray->row < ray->end;
    ray->step++;
    soon(next + 1);
    soon(next->way.corner);
    join(run->wave->queue, more ? next->queue : RMAP_WAVE_QUEUES, ray->number);
}

/* Those that have arrived make room for others. */
static inline void welcome(struct rmap_wave_run *run)
{
    struct rmap_wave_queues *queue = run->wave->queue;
    while (n_waiting(queue, RMAP_WAVE_QUEUES) > 0) {
        uint32_t at = queue->first[RMAP_WAVE_QUEUES]++ & (RMAP_WAVE_RAYS - 1);
        struct rmap_wave_ray *ray = &run->wave->ray[queue->ray[RMAP_WAVE_QUEUES][at]];
        arrive(run, ray);
        if (replace(run, ray))
            line_up(run, ray);
    }
}

static void load_turns(const struct rmap_retrace *r, enum rmap_turn turn,
                       struct rmap_wave_pack *pack)
{
    size_t n = r->model->n_medium;
    for (int i = 0; i < RMAP_WAVE_WIDTH && turn == RMAP_TURN_REFRACT; i++) {
        const struct rmap_wave_ray *ray = pack->ray[i];
        const double *by_channel = r->model->index + (size_t)ray->channel * (n + 1);
        size_t near = ray->leg[0].medium, far = ray->leg[1].medium;
        bool known = near < n && far < n;
        pack->n1[i] = known ? by_channel[near] : 1.0;
        pack->n2[i] = known ? by_channel[far] : 1.0;
    }
    for (int i = 0; i < RMAP_WAVE_WIDTH && turn == RMAP_TURN_DIFFUSE; i++) {
        const struct rmap_wave_ray *ray = pack->ray[i];
        pack->random[0][i] = (uint32_t)ray->id;
        pack->random[1][i] = (uint32_t)(ray->id >> 32);
        pack->random[2][i] = ray->step + 1;
        pack->random[3][i] = RMAP_RNG_SURFACE;
        pack->through[i] = r->event[ray->row] & RMAP_EVENT_TRANSMIT_DIFFUSE ? 1.0 : 0.0;
    }
}

static void meet(const struct rmap_compact_model *model, enum rmap_wave_kind kind,
                 struct rmap_wave_pack *pack)
{
    switch (kind) {
    case RMAP_WAVE_FLAT:
        rmap_wave_meet_flats(pack);
        break;
    case RMAP_WAVE_MESH:
        rmap_wave_meet_meshes(pack);
        break;
    case RMAP_WAVE_QUADRIC:
    case RMAP_WAVE_OWN_QUADRIC:
        rmap_wave_meet_quadrics(kind == RMAP_WAVE_OWN_QUADRIC, -model->epsilon, pack);
        break;
    default:
        rmap_wave_meet_nothing(model->scene, pack);
    }
}

/* One leg of the first n rays of a queue, at most RMAP_WAVE_WIDTH; inline: most packs are full. */
static inline void advance_some(struct rmap_wave_run *run, size_t which, size_t n)
{
    const struct rmap_retrace *r = run->r;
    struct rmap_wave_queues *queue = run->wave->queue;
    const uint16_t *waiting = queue->ray[which];
    enum rmap_wave_kind kind = (enum rmap_wave_kind)(which / RMAP_WAVE_TURNS);
    enum rmap_turn turn = (enum rmap_turn)(which % RMAP_WAVE_TURNS);
    struct rmap_wave_pack pack;
    struct rmap_wave_ray *to[RMAP_WAVE_WIDTH];
    size_t row[RMAP_WAVE_WIDTH], crosses[RMAP_WAVE_WIDTH + 1], n_cross = 0;
    double odd = 0.0;
    for (size_t i = 0; i < RMAP_WAVE_WIDTH; i++) {
        size_t at = waiting[(queue->first[which] + (i < n ? i : 0)) & (RMAP_WAVE_RAYS - 1)];
        pack.ray[i] = &run->wave->ray[at];
        to[i] = &run->wave->ray[i < n ? at : RMAP_WAVE_RAYS];
        row[i] = to[i]->row;
        const struct rmap_wave_leg *leg = pack.ray[i]->leg;
        pack.corner[i] = leg->way.corner;
        pack.object[i] = &r->model->object[leg->object];
        crosses[n_cross] = i;
        n_cross += i < n && (leg->flags & RMAP_WAVE_CROSSES);
    }
    queue->first[which] += (uint32_t)n;
    rmap_wave_load(&pack);
    load_turns(r, turn, &pack);
    meet(r->model, kind, &pack);
    if (n == RMAP_WAVE_WIDTH && turn != RMAP_TURN_NONE)
        rmap_wave_note_on(&pack, row, run->out->segment.position, run->out->segment.normal);
    else
        rmap_wave_note(&pack, row, n, run->out->segment.position, run->out->segment.normal);
    for (size_t k = 0; k < n_cross; k++) {
        size_t i = crosses[k];
        wave_cross(run, to[i], rmap_vec3(pack.px[i], pack.py[i], pack.pz[i]), pack.t[i]);
    }
    if (turn != RMAP_TURN_NONE)
        rmap_wave_turn(turn, r->seed, &pack);
    rmap_wave_store(&pack, to);
    for (size_t i = 0; i < RMAP_WAVE_WIDTH; i++)
        odd += pack.odd[i];
    for (size_t i = 0; odd != 0.0 && i < n; i++)
        if (pack.odd[i] != 0.0)
            run->wave->careful[to[i]->index] = 1;
    for (size_t i = 0; i < n; i++)
        go_on(run, to[i]);
    welcome(run);
}

static void advance_pack(struct rmap_wave_run *run, size_t which, size_t n)
{
    if (n == RMAP_WAVE_WIDTH)
        advance_some(run, which, RMAP_WAVE_WIDTH);
    else
        advance_some(run, which, n);
}

static void advance_alone(struct rmap_wave_run *run, size_t which)
{
    struct rmap_wave_queues *queue = run->wave->queue;
    uint32_t at = queue->first[which]++ & (RMAP_WAVE_RAYS - 1);
    struct rmap_wave_ray *ray = &run->wave->ray[queue->ray[which][at]];
    wave_advance_alone(run, ray);
    go_on(run, ray);
    welcome(run);
}

/* All full packs that there are; false when there was none. */
static bool advance_full(struct rmap_wave_run *run)
{
    const struct rmap_wave_queues *queue = run->wave->queue;
    bool some = false;
    for (size_t k = 0; k < RMAP_WAVE_QUEUES; k++) {
        bool alone = k / RMAP_WAVE_TURNS == RMAP_WAVE_ALONE;
        some = some || n_waiting(queue, k) >= RMAP_WAVE_WIDTH || (alone && n_waiting(queue, k) > 0);
        while (alone && n_waiting(queue, k) > 0)
            advance_alone(run, k);
        while (n_waiting(queue, k) >= RMAP_WAVE_WIDTH)
            advance_pack(run, k, RMAP_WAVE_WIDTH);
    }
    return some;
}

enum rmap_status rmap_wave_run(struct rmap_wave *wave, const struct rmap_retrace *r,
                               struct rmap_portion *predicted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_wave_run run = {.wave = wave, .r = r, .out = predicted};
    RMAP_TRY(make_room(wave, r, err));
    for (size_t i = 0; i < RMAP_WAVE_RAYS; i++)
        if (replace(&run, &wave->ray[i]))
            line_up(&run, &wave->ray[i]);
    for (;;) {
        size_t most = 0;
        while (advance_full(&run))
            ;
        for (size_t k = 0; k < RMAP_WAVE_QUEUES; k++)
            most = n_waiting(wave->queue, k) > n_waiting(wave->queue, most) ? k : most;
        uint32_t n = n_waiting(wave->queue, most);
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
