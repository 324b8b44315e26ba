/* SPDX-License-Identifier: MIT
 *
 * The clearing: a box without shapes, in a scene whose shapes stand around everything else. A leg
 * within it needs no look at them.
 */
#include <math.h>

#include "accel/accel_internal.h"

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
    return type == RMAP_SHAPE_DISC || type == RMAP_SHAPE_RECTANGLE;
}

static void set_clearing(struct rmap_clearing *clearing, const struct box *room)
{
    for (int k = 0; k < 3; k++) {
        clearing->box.lower[k] = (float)room->lower[k];
        clearing->box.upper[k] = (float)room->upper[k];
    }
    for (int side = 0; side <= 6; side++) {
        struct rmap_box3f *open = &clearing->begin[side];
        *open = clearing->box;
        if (side < 6 && side % 2)
            open->upper[side / 2] = HUGE_VALF;
        else if (side < 6)
            open->lower[side / 2] = -HUGE_VALF;
    }
}

void rmap_clearing_build(struct rmap_accel *accel)
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
    set_clearing(&accel->clearing, &room);
}

static inline bool within(const struct rmap_box3f *box, const float p[3])
{
    return (p[0] > box->lower[0]) & (p[1] > box->lower[1]) & (p[2] > box->lower[2]) &
           (p[0] < box->upper[0]) & (p[1] < box->upper[1]) & (p[2] < box->upper[2]);
}

bool rmap_clearing_holds(const struct rmap_query *query, const float origin[3],
                         const float direction[3], double shift)
{
    const struct rmap_clearing *clearing = &query->accel->clearing;
    int32_t start = query->start.object;
    if (!(query->limit < HUGE_VAL))
        return false;
    float far = rmap_far_end(query, shift);
    const float end[3] = {origin[0] + far * direction[0], origin[1] + far * direction[1],
                          origin[2] + far * direction[2]};
    int side = start < 0 ? 6 : query->accel->object[start].side;
    return within(&clearing->box, end) && within(&clearing->begin[side], origin);
}
