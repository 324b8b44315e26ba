/* SPDX-License-Identifier: MIT
 *
 * The prefilter: scenes of few analytic surfaces are searched without a tree. Every shape lies in a
 * shell about its axis, low <= z <= high, inner <= r <= outer; eight shells at a time are held
 * against the float ray, and what is left is solved in double, nearest first. All shells are
 * wider than the float error, so nothing that Embree would propose is lost.
 */
#include <math.h>
#include <string.h>

#include "accel/accel_build.h"
#include "accel/accel_internal.h"
#include "accel/accel_prefilter.h"
#include "accel/accel_triangle.h"

/* In roundings of the longest coordinate: those of the ray's transform and of a point along it,
 * some 10 in all. */
#define SHELL_ERRORS 64

/* Stands for a direction's component of 0: over the length of a scene it leads nowhere. */
#define LEAST_RATE 1e-18F

/* Surfaces with parallel frames that are worth a row of their own. */
#define LEAST_ROW 4

enum { WIDE = RMAP_PREFILTER_WIDE };

static inline float lesser(float a, float b)
{
    return a < b ? a : b;
}

static inline float greater(float a, float b)
{
    return a > b ? a : b;
}

static double largest_row(const struct rmap_affine *a)
{
    double largest = 0;
    for (int r = 0; r < 3; r++)
        largest = fmax(largest, sqrt(a->m[r][0] * a->m[r][0] + a->m[r][1] * a->m[r][1] +
                                     a->m[r][2] * a->m[r][2]));
    return largest;
}

static bool is_held(const struct rmap_accel_object *object)
{
    return object->shape && !object->ball;
}

static bool parallel(const struct rmap_accel_object *a, const struct rmap_accel_object *b)
{
    return memcmp(a->to_local.m, b->to_local.m, sizeof(a->to_local.m)) == 0;
}

/* A shape that stands in the largest set of parallel ones; NULL: that set is too small. */
static const struct rmap_accel_object *find_row(const struct rmap_accel *accel)
{
    const struct rmap_accel_object *best = NULL;
    int most = LEAST_ROW - 1;
    for (size_t i = 0; i < accel->n_object; i++) {
        const struct rmap_accel_object *one = &accel->object[i];
        int n = 0;
        for (size_t k = 0; is_held(one) && k < accel->n_object; k++)
            n += is_held(&accel->object[k]) && parallel(one, &accel->object[k]);
        if (n > most) {
            most = n;
            best = one;
        }
    }
    return best;
}

/* Wider than the float error of the ray in the frame of the object, which lies `at`. */
static double shell_pad(const struct rmap_accel *accel, const struct rmap_accel_object *object,
                        struct rmap_vec3 at)
{
    double rate = largest_row(&object->to_local);
    double longest = 2 * (accel->radius + accel->reach) * rate + rmap_length(at);
    return SHELL_ERRORS * RMAP_FLOAT_EPS * longest + object->tolerance * rate;
}

static float lower_end(const struct rmap_accel *accel, int32_t index)
{
    const struct rmap_accel_object *object = &accel->object[index];
    struct rmap_vec3 at = rmap_affine_point(&object->to_local, accel->centre);
    return (float)(object->lower.z - at.z - shell_pad(accel, object, at));
}

static void set_shell(struct rmap_prefilter *prefilter, int slot, const struct rmap_accel *accel,
                      int32_t index)
{
    const struct rmap_accel_object *object = &accel->object[index];
    struct rmap_prefilter_group *group = &prefilter->group[slot / WIDE];
    int lane = slot % WIDE;
    struct rmap_vec3 at = rmap_affine_point(&object->to_local, accel->centre);
    double pad = shell_pad(accel, object, at), radius[2];
    rmap_shell_radii(object->shape, radius);
    double hole = rmap_greater(radius[0] - pad, 0), rim = radius[1] + pad;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            group->turn[r][c][lane] = (float)object->to_local.m[r][c];
    group->place_x[lane] = (float)at.x;
    group->place_y[lane] = (float)at.y;
    group->low[lane] = lower_end(accel, index);
    group->high[lane] = (float)(object->upper.z - at.z + pad);
    group->inner2[lane] = (float)(hole * hole);
    group->outer2[lane] = (float)(rim * rim);
    group->half_x[lane] = (float)(rmap_greater(object->upper.x, -object->lower.x) + pad);
    group->half_y[lane] = (float)(rmap_greater(object->upper.y, -object->lower.y) + pad);
    prefilter->object[slot] = index;
    prefilter->flat[slot] = rmap_shape_model[object->shape->type].plane;
}

/* The row, sorted by its lower ends. */
static void build_row(struct rmap_accel *accel, const struct rmap_accel_object *first)
{
    struct rmap_prefilter *prefilter = &accel->prefilter;
    int32_t row[RMAP_PREFILTER_SLOTS];
    for (int32_t i = 0; i < (int32_t)accel->n_object; i++) {
        if (!is_held(&accel->object[i]) || !parallel(first, &accel->object[i]))
            continue;
        int at = prefilter->n_row++;
        for (; at > 0 && lower_end(accel, row[at - 1]) > lower_end(accel, i); at--)
            row[at] = row[at - 1];
        row[at] = i;
    }
    for (int k = 0; k < prefilter->n_row; k++) {
        struct rmap_prefilter_group *group = &prefilter->group[k / WIDE];
        set_shell(prefilter, k, accel, row[k]);
        prefilter->row |= UINT64_C(1) << k;
        float high = group->high[k % WIDE];
        if (k % WIDE == 0) {
            group->lowest = group->low[0];
            group->highest = high;
            group->highest_before = k > 0 ? group[-1].highest_before : high;
        }
        group->highest = greater(group->highest, high);
        group->highest_before = greater(group->highest_before, high);
    }
}

void rmap_prefilter_build(struct rmap_accel *accel)
{
    struct rmap_prefilter *prefilter = &accel->prefilter;
    double longest = 2 * (accel->radius + accel->reach);
    const struct rmap_accel_object *first = find_row(accel);
    prefilter->longest = (float)(longest * (1 + 1e-6));
    prefilter->rounding = (float)(16 * RMAP_FLOAT_EPS * longest);
    if (first)
        build_row(accel, first);
    prefilter->n_slot = (prefilter->n_row + WIDE - 1) / WIDE * WIDE;
    for (int32_t i = 0; i < (int32_t)accel->n_object; i++) {
        if (!is_held(&accel->object[i]) || (first && parallel(first, &accel->object[i])))
            continue;
        prefilter->others |= UINT64_C(1) << prefilter->n_slot;
        set_shell(prefilter, prefilter->n_slot++, accel, i);
    }
}

static inline float rate_of(float component)
{
    return 1 / (fabsf(component) > LEAST_RATE ? component : LEAST_RATE);
}

static inline float per_square(float x, float y)
{
    return 1 / (x * x + y * y + 1e-36F);
}

/* A float ray in the frame of a shape, but for the frame's place along its axis. */
struct line {
    float p[3], v[3];
    float rate, per_across2; /* 1 / v[2]; 1 / (v[0]^2 + v[1]^2) */
};

/* Does the line pass through the shell of lane k, and where does that begin? */
static inline int meets(const struct rmap_prefilter_group *g, int k, const struct line *l,
                        float longest, float rounding, float *near)
{
    float px = l->p[0] + g->place_x[k], py = l->p[1] + g->place_y[k];
    float a = (g->low[k] - l->p[2]) * l->rate, b = (g->high[k] - l->p[2]) * l->rate;
    float from = greater(lesser(a, b) - rounding, 0);
    float to = lesser(greater(a, b) + rounding, longest);
    float x0 = px + from * l->v[0], x1 = px + to * l->v[0];
    float y0 = py + from * l->v[1], y1 = py + to * l->v[1];
    float middle = -(px * l->v[0] + py * l->v[1]) * l->per_across2;
    middle = lesser(greater(middle, from), to);
    float xm = px + middle * l->v[0], ym = py + middle * l->v[1];
    float farthest = greater(x0 * x0 + y0 * y0, x1 * x1 + y1 * y1);
    *near = from;
    return (from <= to) & (farthest >= g->inner2[k]) & (xm * xm + ym * ym <= g->outer2[k]) &
           (lesser(x0, x1) <= g->half_x[k]) & (greater(x0, x1) >= -g->half_x[k]) &
           (lesser(y0, y1) <= g->half_y[k]) & (greater(y0, y1) >= -g->half_y[k]);
}

static inline void turn(const struct rmap_prefilter_group *g, int k, const float o[3],
                        const float d[3], struct line *l)
{
#pragma GCC unroll 3
    for (int r = 0; r < 3; r++) {
        l->p[r] = g->turn[r][0][k] * o[0] + g->turn[r][1][k] * o[1] + g->turn[r][2][k] * o[2];
        l->v[r] = g->turn[r][0][k] * d[0] + g->turn[r][1][k] * d[1] + g->turn[r][2][k] * d[2];
    }
    l->rate = rate_of(l->v[2]);
    l->per_across2 = per_square(l->v[0], l->v[1]);
}

/* Bits of the shells that the ray meets, and where along it each begins. */
RMAP_WIDEST
static uint32_t sift(const struct rmap_prefilter_group *g, const float o[restrict 3],
                     const float d[restrict 3], float longest, float rounding,
                     float near[restrict WIDE])
{
    uint32_t bits = 0;
    for (int k = 0; k < WIDE; k++) {
        struct line line;
        turn(g, k, o, d, &line);
        bits |= meets(g, k, &line, longest, rounding, &near[k]) ? 1U << k : 0;
    }
    return bits;
}

/* The same in a row, whose frames share the line. */
RMAP_WIDEST
static uint32_t sift_row(const struct rmap_prefilter_group *g, const struct line *restrict of_row,
                         float longest, float rounding, float near[restrict WIDE])
{
    const struct line line = *of_row;
    uint32_t bits = 0;
    for (int k = 0; k < WIDE; k++)
        bits |= meets(g, k, &line, longest, rounding, &near[k]) ? 1U << k : 0;
    return bits;
}

static void consider(struct rmap_query *query, int slot)
{
    const struct rmap_prefilter *prefilter = &query->accel->prefilter;
    int32_t object = prefilter->object[slot];
    if (!(prefilter->flat[slot] && object == query->start.object)) /* met once at most */
        (void)rmap_consider_shape(query, object);
}

/* The surfaces of one group of the row that the ray may meet, nearest first as far as they do not
 * overlap. */
static void search_group(struct rmap_query *query, int first, const struct line *line, double shift)
{
    const struct rmap_prefilter *prefilter = &query->accel->prefilter;
    float near[WIDE];
    uint32_t left = sift_row(&prefilter->group[first / WIDE], line, prefilter->longest,
                             prefilter->rounding, near);
    left &= (uint32_t)(prefilter->row >> first);
    while (left) {
        int k = line->rate > 0 ? __builtin_ctz(left) : 31 - __builtin_clz(left);
        left &= ~(1U << k);
        if (near[k] <= rmap_far_end(query, shift))
            consider(query, first + k);
    }
}

/* Along the row one group after the other, from those that the ray has left behind to those that
 * begin beyond the nearest surface. */
static void search_row(struct rmap_query *query, const float origin[3], const float direction[3],
                       double shift)
{
    const struct rmap_prefilter *prefilter = &query->accel->prefilter;
    int n = (prefilter->n_row + WIDE - 1) / WIDE;
    struct line line;
    turn(&prefilter->group[0], 0, origin, direction, &line);
    bool upward = line.rate > 0;
    for (int i = 0; i < n; i++) {
        const struct rmap_prefilter_group *group = &prefilter->group[upward ? i : n - 1 - i];
        float enter = upward ? group->lowest : group->highest_before;
        float leave = upward ? group->highest : group->lowest;
        if ((enter - line.p[2]) * line.rate - prefilter->rounding > rmap_far_end(query, shift))
            return;
        if ((leave - line.p[2]) * line.rate + prefilter->rounding < 0)
            continue;
        search_group(query, (int)(group - prefilter->group) * WIDE, &line, shift);
    }
}

/* The nearest of the surfaces left, taken out; -1: none begins before `far`. */
static int take_nearest(uint64_t *left, const float *near, float far)
{
    int nearest = -1;
    for (uint64_t rest = *left; rest; rest &= rest - 1) {
        int k = __builtin_ctzll(rest);
        if (near[k] <= far) {
            far = near[k];
            nearest = k;
        }
    }
    if (nearest >= 0)
        *left &= ~(UINT64_C(1) << nearest);
    return nearest;
}

static void search_others(struct rmap_query *query, const float origin[3], const float direction[3],
                          double shift)
{
    const struct rmap_prefilter *prefilter = &query->accel->prefilter;
    float near[RMAP_PREFILTER_SLOTS];
    uint64_t left = 0;
    int k;
    for (int i = (prefilter->n_row + WIDE - 1) / WIDE * WIDE; i < prefilter->n_slot; i += WIDE)
        left |= (uint64_t)sift(&prefilter->group[i / WIDE], origin, direction, prefilter->longest,
                               prefilter->rounding, &near[i])
                << i;
    left &= prefilter->others;
    while ((k = take_nearest(&left, near, rmap_far_end(query, shift))) >= 0)
        consider(query, k);
}

void rmap_prefilter_search(struct rmap_query *query, const float origin[3],
                           const float direction[3], double shift)
{
    if (query->accel->prefilter.row)
        search_row(query, origin, direction, shift);
    if (query->accel->prefilter.others)
        search_others(query, origin, direction, shift);
}

/* A few spheres before the prefilter: a ball needs no frame of its own, and a ray that begins and
 * ends deep inside one does not meet its surface, as most chords of a curve in a gradient sphere do
 * not. Outer radii are wider than the float error and inner ones smaller, so nothing that Embree
 * would propose is lost. */

/* In roundings of the longest coordinate, as in accel_prefilter.c. */
#define BALL_ERRORS 64

static bool is_ball(const struct rmap_accel_object *object)
{
    return object->shape && object->shape->type == RMAP_SHAPE_SPHERE && object->rigid;
}

static void add_ball(struct rmap_accel *accel, int32_t index, double tolerance)
{
    const struct rmap_accel_object *object = &accel->object[index];
    struct rmap_spheres *spheres = &accel->spheres;
    struct rmap_vec3 at = rmap_sub(object->to_world.t, accel->centre);
    double longest = 2 * (accel->radius + accel->reach) + rmap_length(at);
    double pad = BALL_ERRORS * RMAP_FLOAT_EPS * longest + object->tolerance + tolerance;
    double outer = object->shape->radius + pad, inner = object->shape->radius - pad;
    int k = spheres->n++;
    spheres->x[k] = (float)at.x;
    spheres->y[k] = (float)at.y;
    spheres->z[k] = (float)at.z;
    spheres->outer2[k] = (float)(outer * outer);
    spheres->inner2[k] = inner > 0 ? (float)(inner * inner) : 0;
    spheres->object[k] = index;
}

void rmap_spheres_build(struct rmap_accel *accel)
{
    struct rmap_spheres *spheres = &accel->spheres;
    double tolerance = 0; /* any surface may be the one that a ray starts from */
    int n = 0;
    for (size_t i = 0; i < accel->n_object; i++) {
        accel->object[i].ball = false;
        n += is_ball(&accel->object[i]);
        tolerance = rmap_greater(tolerance, accel->object[i].tolerance);
    }
    for (int k = 0; k < WIDE; k++)
        spheres->outer2[k] = -1;
    for (size_t i = 0; n <= WIDE && i < accel->n_object; i++)
        if (is_ball(&accel->object[i])) {
            accel->object[i].ball = true;
            add_ball(accel, (int32_t)i, tolerance);
        }
}

/* Bits of the spheres whose surface the ray may meet before `far`, and where it enters each. */
RMAP_WIDEST
static uint32_t sift_spheres(const struct rmap_spheres *spheres, const float o[restrict 3],
                             const float d[restrict 3], float far, float near[restrict WIDE])
{
    uint32_t bits = 0;
    for (int k = 0; k < WIDE; k++) {
        float x = spheres->x[k] - o[0], y = spheres->y[k] - o[1], z = spheres->z[k] - o[2];
        float along = x * d[0] + y * d[1] + z * d[2];
        float ax = x - along * d[0], ay = y - along * d[1], az = z - along * d[2];
        float ex = x - far * d[0], ey = y - far * d[1], ez = z - far * d[2];
        float across2 = ax * ax + ay * ay + az * az;
        float half = sqrtf(across2 < spheres->outer2[k] ? spheres->outer2[k] - across2 : 0);
        int inside = (x * x + y * y + z * z < spheres->inner2[k]) &
                     (ex * ex + ey * ey + ez * ez < spheres->inner2[k]);
        near[k] = along - half;
        bits |= (across2 <= spheres->outer2[k]) & (along + half >= 0) & (near[k] <= far) & !inside
                    ? 1U << k
                    : 0;
    }
    return bits;
}

void rmap_spheres_search(struct rmap_query *query, const float origin[3], const float direction[3],
                         double shift)
{
    const struct rmap_spheres *spheres = &query->accel->spheres;
    float near[WIDE];
    uint32_t left = sift_spheres(spheres, origin, direction, rmap_far_end(query, shift), near);
    while (left) {
        int nearest = -1;
        float far = rmap_far_end(query, shift);
        for (uint32_t rest = left; rest; rest &= rest - 1) {
            int k = __builtin_ctz(rest);
            if (near[k] <= far) {
                far = near[k];
                nearest = k;
            }
        }
        if (nearest < 0)
            return;
        left &= ~(1U << nearest);
        (void)rmap_consider_shape(query, spheres->object[nearest]);
    }
}

/* The clearance: a box without shapes, in a scene whose shapes stand around everything else. A
 * segment within it needs no look at them. */

struct box {
    double lower[3], upper[3];
};

static double volume(const struct box *box)
{
    double product = 1;
    for (int k = 0; k < 3; k++)
        product *= rmap_greater(box->upper[k] - box->lower[k], 0);
    return product;
}

/* About Embree's origin, wider than the float error. */
static struct box box_of(const struct rmap_accel *accel, const struct rmap_accel_object *object)
{
    struct rmap_vec3 low, high;
    double pad = 2 * accel->reach + object->tolerance;
    rmap_accel_bounds(object, &low, &high);
    low = rmap_sub(low, accel->centre);
    high = rmap_sub(high, accel->centre);
    return (struct box){{low.x - pad, low.y - pad, low.z - pad},
                        {high.x + pad, high.y + pad, high.z + pad}};
}

static struct box cut(struct box room, const struct box *off, int side)
{
    int k = side / 2;
    if (side % 2)
        room.upper[k] = rmap_lesser(room.upper[k], off->lower[k]);
    else
        room.lower[k] = rmap_greater(room.lower[k], off->upper[k]);
    return room;
}

static bool overlap(const struct box *a, const struct box *b)
{
    bool apart = false;
    for (int k = 0; k < 3; k++)
        apart |= a->upper[k] <= b->lower[k] || b->upper[k] <= a->lower[k];
    return !apart;
}

/* Does nothing but this one, which no ray meets twice in a row, stand beyond the side? */
static bool ends_alone(const struct rmap_accel *accel, const struct box *room, int side,
                       size_t owner)
{
    enum rmap_shape_type type = accel->object[owner].shape->type;
    struct box beyond = *room, own = box_of(accel, &accel->object[owner]);
    int k = side / 2;
    beyond.lower[k] = side % 2 ? room->upper[k] : own.lower[k];
    beyond.upper[k] = side % 2 ? own.upper[k] : room->lower[k];
    for (size_t i = 0; i < accel->n_object; i++) {
        if (i == owner || !accel->object[i].shape)
            continue;
        struct box other = box_of(accel, &accel->object[i]);
        if (overlap(&beyond, &other))
            return false;
    }
    return rmap_shape_model[type].plane;
}

static void set_clearance(struct rmap_clearance *clearance, const struct box *room)
{
    for (int k = 0; k < 3; k++) {
        clearance->box.lower[k] = (float)room->lower[k];
        clearance->box.upper[k] = (float)room->upper[k];
    }
    for (int side = 0; side <= 6; side++) {
        struct rmap_box3f *open = &clearance->begin[side];
        *open = clearance->box;
        if (side < 6 && side % 2)
            open->upper[side / 2] = HUGE_VALF;
        else if (side < 6)
            open->lower[side / 2] = -HUGE_VALF;
    }
}

void rmap_clearance_build(struct rmap_accel *accel)
{
    struct box room;
    size_t owner[6];
    for (int k = 0; k < 3; k++) {
        room.lower[k] = -accel->radius;
        room.upper[k] = accel->radius;
    }
    for (int side = 0; side < 6; side++)
        owner[side] = accel->n_object;
    for (size_t i = 0; i < accel->n_object; i++) {
        accel->object[i].side = 6;
        if (!accel->object[i].shape)
            continue;
        struct box off = box_of(accel, &accel->object[i]), best = room;
        double most = -1;
        int through = 0;
        for (int side = 0; side < 6 && overlap(&room, &off); side++) {
            struct box rest = cut(room, &off, side);
            if (volume(&rest) > most) {
                most = volume(&rest);
                best = rest;
                through = side;
            }
        }
        if (most >= 0) {
            room = best;
            owner[through] = i;
        }
    }
    for (int side = 0; side < 6; side++)
        if (owner[side] < accel->n_object && ends_alone(accel, &room, side, owner[side]))
            accel->object[owner[side]].side = side;
    set_clearance(&accel->clearance, &room);
}

static inline bool within(const struct rmap_box3f *box, const float p[3])
{
    return (p[0] > box->lower[0]) & (p[1] > box->lower[1]) & (p[2] > box->lower[2]) &
           (p[0] < box->upper[0]) & (p[1] < box->upper[1]) & (p[2] < box->upper[2]);
}

bool rmap_clearance_holds(const struct rmap_query *query, const float origin[3],
                          const float direction[3], double shift)
{
    const struct rmap_clearance *clearance = &query->accel->clearance;
    int32_t start = query->start.object;
    if (!(query->limit < HUGE_VAL))
        return false;
    float far = rmap_far_end(query, shift);
    const float end[3] = {origin[0] + far * direction[0], origin[1] + far * direction[1],
                          origin[2] + far * direction[2]};
    int side = start < 0 ? 6 : query->accel->object[start].side;
    return within(&clearance->box, end) && within(&clearance->begin[side], origin);
}
