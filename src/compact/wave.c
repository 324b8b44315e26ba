/* SPDX-License-Identifier: MIT */
#include "compact/wave.h"

#include "base/alloc.h"
#include "compact/step.h"

/* So many rays are followed at a time: their numbers stay in the processor's cache. */
#define WAVE_RAYS 512

/* Legs of one kind are brought together by so many bits of it. */
#define KEY_BITS  9
#define KEYS      (1u << KEY_BITS)
#define KEY(kind) ((kind) & (KEYS - 1))

/* So few in a run, or at all, are followed one by one, unsorted. */
#define FEW 3

void rmap_wave_fini(struct rmap_wave *wave)
{
    rmap_free(wave->ray);
    rmap_free(wave->alive);
    rmap_free(wave->sorted);
    rmap_free(wave->now);
    rmap_free(wave->leg);
    rmap_free(wave->careful);
    *wave = (struct rmap_wave){0};
}

/* Legs of the rays of a range. */
static size_t count_legs(const struct rmap_retrace *r, const struct rmap_wave_range *range)
{
    size_t n = 0;
    for (size_t i = range->first; i < range->end; i++)
        n += r->segment_count[i];
    return n;
}

static enum rmap_status make_room(struct rmap_wave *wave, size_t n_ray, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
#define ROOM(field, n)                                                                             \
    RMAP_TRY(rmap_reserve((void **)&wave->field, &wave->cap_##field, n, sizeof *wave->field, err))
    ROOM(ray, n_ray);
    ROOM(alive, n_ray);
    ROOM(sorted, n_ray);
    ROOM(careful, n_ray);
    ROOM(now, n_ray);
#undef ROOM
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

/* As rmap_step_turn, without branches: what comes next is anybody's guess. */
static uint32_t turn_of(uint32_t event)
{
    uint32_t turn = event & RMAP_EVENT_TRANSMIT_SPECULAR ? RMAP_TURN_REFRACT : RMAP_TURN_NONE;
    turn = event & (RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_TOTAL_REFLECTION) ? RMAP_TURN_REFLECT
                                                                               : turn;
    return event & (RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE) ? RMAP_TURN_DIFFUSE
                                                                              : turn;
}

/* Kind of a leg without its turn. from: object that it starts on. */
static uint32_t kind_of(const struct rmap_compact_model *model, int32_t primitive, int32_t from,
                        struct rmap_wave_leg *leg)
{
    leg->corner = NULL;
    if (leg->object < 0 || (size_t)leg->object >= model->n_object)
        return 0;
    const struct rmap_compact_guide *guide = &model->guide[leg->object];
    if (guide->wave != RMAP_WAVE_MESH)
        return guide->wave ? guide->wave | (leg->object == from ? RMAP_WAVE_OWN : 0) : 0;
    if (primitive < 0 || (size_t)primitive >= guide->n_triangle)
        return 0;
    leg->corner = guide->corner[primitive];
    return RMAP_WAVE_MESH;
}

static void set_legs(const struct rmap_retrace *r, const struct rmap_wave_ray *ray)
{
    int32_t from = ray->object;
    struct rmap_wave_leg *leg = ray->leg;
    for (size_t row = ray->row; row < ray->end; row++, leg++) {
        leg->object = r->object[row];
        leg->event = r->event[row];
        leg->medium = r->medium[row];
        uint32_t kind = kind_of(r->model, r->primitive[row], from, leg);
        uint32_t turn = row + 1 < ray->end ? turn_of(leg->event) : RMAP_TURN_NONE;
        leg->kind = kind ? kind | turn << RMAP_WAVE_TURN : 0;
        from = leg->object;
    }
}

static void begin(struct rmap_wave *wave, const struct rmap_retrace *r,
                  const struct rmap_wave_range *range, struct rmap_portion *out)
{
    size_t row = range->row, crossing = range->crossing;
    for (size_t i = range->first; i < range->end; i++) {
        struct rmap_wave_ray *ray = &wave->ray[i];
        struct rmap_departure departure;
        rmap_departure_find(r->model, r->seed, r->id[i], r->source[i], &departure);
        wave->careful[i] = 0;
        if (out->ray.start)
            rmap_step_float3(departure.position, out->ray.start + 3 * i);
        if (out->ray.start_normal)
            rmap_step_normal(departure.normal, out->ray.start_normal + 3 * i);
        *ray = (struct rmap_wave_ray){.position = departure.position,
                                      .direction = departure.direction,
                                      .leg = wave->leg + (row - range->row),
                                      .first = row,
                                      .row = row,
                                      .end = row + r->segment_count[i],
                                      .crossing = crossing,
                                      .crossing_end = crossing + r->registration_count[i],
                                      .object = r->start_object[i],
                                      .departs = departure.channel,
                                      .channel = r->channel[i] > 0 ? r->channel[i] - 1 : 0};
        if (ray->channel >= r->model->n_channel)
            ray->channel = 0;
        row = ray->end;
        crossing = ray->crossing_end;
        set_legs(r, ray);
        wave->now[i] = ray->row < ray->end ? ray->leg->kind : RMAP_WAVE_END;
        if (ray->row < ray->end && ray->leg->corner)
            soon(ray->leg->corner);
    }
}

/* Registrations on the leg in hand; their optical paths are distances yet. */
static void cross(struct rmap_wave *wave, const struct rmap_retrace *r, uint32_t index,
                  struct rmap_vec3 to, double length, struct rmap_portion *out)
{
    struct rmap_wave_ray *ray = &wave->ray[index];
    const struct rmap_compact_leg leg = {.from = ray->position,
                                         .to = to,
                                         .direction = ray->direction,
                                         .length = length,
                                         .index = 1.0};
    while (ray->crossing < ray->crossing_end &&
           r->crossing_segment[ray->crossing] <= ray->row - ray->first) {
        size_t row = ray->crossing++;
        int32_t detector = r->crossing_detector[row];
        struct rmap_crossing crossing = {.optical_path = 0.0};
        if (detector < 0 || (size_t)detector >= r->model->n_detector)
            wave->careful[index] = 1;
        else
            rmap_crossing_find(&r->model->scene->detector[detector], &leg, &crossing);
        rmap_step_float3(ray->direction, crossing.direction);
        if (out->registration.cell)
            memcpy(out->registration.cell + 2 * row, crossing.cell, sizeof crossing.cell);
        if (out->registration.relative)
            memcpy(out->registration.relative + 2 * row, crossing.relative,
                   sizeof crossing.relative);
        if (out->registration.direction)
            memcpy(out->registration.direction + 3 * row, crossing.direction,
                   sizeof crossing.direction);
        if (out->registration.optical_path)
            out->registration.optical_path[row] = crossing.optical_path;
    }
}

static struct rmap_turning turning_of(const struct rmap_retrace *r, const struct rmap_wave_ray *ray,
                                      uint32_t index)
{
    size_t row = ray->row;
    return (struct rmap_turning){.seed = r->seed,
                                 .ray = r->id[index],
                                 .step = (uint32_t)(row - ray->first) + 1,
                                 .event = r->event[row],
                                 .near = rmap_step_medium(r->model, r->medium[row]),
                                 .far = rmap_step_medium(r->model, r->medium[row + 1]),
                                 .channel = ray->channel};
}

static void next_leg(struct rmap_wave *wave, uint32_t index)
{
    struct rmap_wave_ray *ray = &wave->ray[index];
    ray->row++;
    ray->leg++;
    wave->now[index] = RMAP_WAVE_END;
    if (ray->row < ray->end) {
        wave->now[index] = ray->leg->kind;
        if (ray->leg->corner)
            soon(ray->leg->corner);
    }
}

/* One leg of one ray. */
static void advance_one(struct rmap_wave *wave, const struct rmap_retrace *r, uint32_t index,
                        struct rmap_portion *out)
{
    struct rmap_wave_ray *ray = &wave->ray[index];
    struct rmap_facing facing = {.normal = {0.0, 0.0, 0.0}};
    size_t row = ray->row;
    bool met = rmap_facing_find(r->model, r->object[row], r->primitive[row], ray->object,
                                ray->position, ray->direction, &facing);
    if (!met) {
        const struct rmap_medium *medium = rmap_step_medium(r->model, r->medium[row]);
        if (medium && medium->absorbing && (r->event[row] & RMAP_EVENT_ABSORB))
            wave->careful[index] = 1;
        facing.t = rmap_step_distance_out(r->model->scene, ray->position, ray->direction);
        facing.position = rmap_axpy(facing.t, ray->direction, ray->position);
    }
    double cosine = rmap_dot(ray->direction, facing.normal);
    ray->leg->length = facing.t;
    ray->leg->cosine = met ? cosine : (double)NAN;
    rmap_step_float3(facing.position, ray->leg->position);
    rmap_step_normal(facing.normal, ray->leg->normal);
    if (r->crossing_segment && ray->crossing < ray->crossing_end)
        cross(wave, r, index, facing.position, facing.t, out);
    if (met && row + 1 < ray->end) {
        const struct rmap_turning turning = turning_of(r, ray, index);
        ray->direction =
            rmap_step_turned(&turning, ray->direction,
                             cosine < 0.0 ? facing.normal : rmap_scale(facing.normal, -1.0));
    }
    ray->position = facing.position;
    ray->object = met ? r->object[row] : -1;
    next_leg(wave, index);
}

static void load_turn(const struct rmap_retrace *r, const struct rmap_wave_ray *ray, uint32_t index,
                      enum rmap_turn turn, size_t i, struct rmap_wave_pack *pack)
{
    size_t n = r->model->n_medium;
    const struct rmap_wave_leg *leg = ray->leg;
    if (turn == RMAP_TURN_REFRACT) {
        const double *by_channel = r->model->index + (size_t)ray->channel * n;
        size_t near = (size_t)(uint16_t)leg[0].medium, far = (size_t)(uint16_t)leg[1].medium;
        bool known = near < n && far < n && leg[0].medium >= 0 && leg[1].medium >= 0;
        pack->n1[i] = known ? by_channel[near] : 1.0;
        pack->n2[i] = known ? by_channel[far] : 1.0;
    } else {
        uint64_t id = r->id[index];
        pack->random[0][i] = (uint32_t)id;
        pack->random[1][i] = (uint32_t)(id >> 32);
        pack->random[2][i] = (uint32_t)(ray->row - ray->first) + 1;
        pack->random[3][i] = RMAP_RNG_SURFACE;
        pack->through[i] = leg->event & RMAP_EVENT_TRANSMIT_DIFFUSE ? 1.0 : 0.0;
    }
}

static void load(const struct rmap_wave *wave, const struct rmap_retrace *r, const uint32_t *index,
                 size_t n, enum rmap_turn turn, struct rmap_wave_pack *pack)
{
    for (size_t i = 0; i < RMAP_WAVE_WIDTH; i++) {
        uint32_t at = index[i < n ? i : 0];
        const struct rmap_wave_ray *ray = &wave->ray[at];
        pack->px[i] = ray->position.x;
        pack->py[i] = ray->position.y;
        pack->pz[i] = ray->position.z;
        pack->dx[i] = ray->direction.x;
        pack->dy[i] = ray->direction.y;
        pack->dz[i] = ray->direction.z;
        pack->corner[i] = ray->leg->corner;
        pack->object[i] = &r->model->object[ray->leg->object];
        if (turn == RMAP_TURN_REFRACT || turn == RMAP_TURN_DIFFUSE)
            load_turn(r, ray, at, turn, i, pack);
    }
}

/* Notes the ends of the legs in hand. */
static void note(struct rmap_wave *wave, const struct rmap_retrace *r, const uint32_t *index,
                 size_t n, const struct rmap_wave_pack *pack, struct rmap_portion *out)
{
    for (size_t i = 0; i < n; i++) {
        const struct rmap_wave_ray *ray = &wave->ray[index[i]];
        struct rmap_wave_leg *leg = ray->leg;
        leg->length = pack->t[i];
        leg->cosine = pack->cosine[i];
        for (int k = 0; k < 3; k++) {
            leg->position[k] = pack->position[k][i];
            leg->normal[k] = pack->normal[k][i];
        }
        if (r->crossing_segment && ray->crossing < ray->crossing_end)
            cross(wave, r, index[i], rmap_vec3(pack->px[i], pack->py[i], pack->pz[i]), pack->t[i],
                  out);
    }
}

/* One leg of up to RMAP_WAVE_WIDTH rays, of one kind. */
static void advance_pack(struct rmap_wave *wave, const struct rmap_retrace *r,
                         const uint32_t *index, size_t n, struct rmap_portion *out)
{
    struct rmap_wave_pack pack;
    uint32_t kind = wave->now[index[0]];
    enum rmap_turn turn = (enum rmap_turn)(kind >> RMAP_WAVE_TURN & 3);
    load(wave, r, index, n, turn, &pack);
    if (kind >= RMAP_WAVE_MESH)
        rmap_wave_meet_meshes(&pack);
    else
        rmap_wave_meet_shape(pack.object[0], kind & RMAP_WAVE_OWN, -r->model->epsilon, &pack);
    note(wave, r, index, n, &pack, out);
    if (turn != RMAP_TURN_NONE)
        rmap_wave_turn(turn, r->seed, &pack);
    for (size_t i = 0; i < n; i++) {
        struct rmap_wave_ray *ray = &wave->ray[index[i]];
        ray->position = rmap_vec3(pack.px[i], pack.py[i], pack.pz[i]);
        ray->direction = rmap_vec3(pack.dx[i], pack.dy[i], pack.dz[i]);
        ray->object = ray->leg->object;
        next_leg(wave, index[i]);
        if (pack.odd[i] != 0.0)
            wave->careful[index[i]] = 1;
    }
}

/* Brings legs of one key together. Stable, so that all is a function of the portion alone. */
static void sort(struct rmap_wave *wave, size_t n)
{
    uint32_t first[KEYS + 1] = {0};
    for (size_t i = 0; i < n; i++)
        first[KEY(wave->now[wave->alive[i]]) + 1]++;
    for (uint32_t k = 0; k < KEYS; k++)
        first[k + 1] += first[k];
    for (size_t i = 0; i < n; i++)
        wave->sorted[first[KEY(wave->now[wave->alive[i]])]++] = wave->alive[i];
}

static void advance_all(struct rmap_wave *wave, const struct rmap_retrace *r, const uint32_t *index,
                        size_t n, struct rmap_portion *out)
{
    for (size_t i = 0; i < n;) {
        uint32_t kind = wave->now[index[i]];
        size_t run = 1;
        while (kind > 0 && run < RMAP_WAVE_WIDTH && i + run < n &&
               wave->now[index[i + run]] == kind)
            run++;
        if (run >= FEW)
            advance_pack(wave, r, index + i, run, out);
        else
            for (size_t k = 0; k < run; k++)
                advance_one(wave, r, index[i + k], out);
        i += run;
    }
}

static void follow(struct rmap_wave *wave, const struct rmap_retrace *r,
                   const struct rmap_wave_range *range, struct rmap_portion *out)
{
    size_t n = 0;
    for (size_t i = range->first; i < range->end; i++)
        if (r->segment_count[i] > 0)
            wave->alive[n++] = (uint32_t)i;
    while (n > 0) {
        size_t left = 0;
        bool many = n > 8 * FEW;
        if (many)
            sort(wave, n);
        advance_all(wave, r, many ? wave->sorted : wave->alive, n, out);
        for (size_t i = 0; i < n; i++) {
            uint32_t index = wave->alive[i];
            wave->alive[left] = index;
            left += wave->now[index] != RMAP_WAVE_END;
        }
        n = left;
    }
}

enum rmap_status rmap_wave_run(struct rmap_wave *wave, const struct rmap_retrace *r,
                               struct rmap_portion *predicted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(make_room(wave, r->n_ray, err));
    struct rmap_wave_range range = {0, 0, 0, 0};
    for (; range.first < r->n_ray; range.first = range.end) {
        range.end = r->n_ray - range.first > WAVE_RAYS ? range.first + WAVE_RAYS : r->n_ray;
        RMAP_TRY(rmap_reserve((void **)&wave->leg, &wave->cap_leg, count_legs(r, &range),
                              sizeof *wave->leg, err));
        begin(wave, r, &range, predicted);
        follow(wave, r, &range, predicted);
        rmap_wave_sum(wave, r, &range, predicted);
    }
out:
    return st;
}
