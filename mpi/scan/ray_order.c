/* SPDX-License-Identifier: MIT
 *
 * Messages of rays that are handed out one by one in the order of their ids, as far as no message
 * to come can hold a smaller one.
 */
#include "mpi/scan/ray_order.h"

#include "base/alloc.h"

struct rmap_held_rays {
    struct rmap_message *message;
    struct rmap_portion rays; /* a view of it */
    size_t row, segment, registration, space;
};

enum rmap_status rmap_ray_order_add(struct rmap_ray_order *self, size_t portion,
                                    struct rmap_message *message, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(self->held, self->cap_held, self->n_held + 1, err);
    if (st != RMAP_OK) {
        rmap_message_destroy(message);
        return st;
    }
    struct rmap_held_rays *held = &self->held[self->n_held++];
    *held = (struct rmap_held_rays){.message = message,
                                    .space = (size_t)rmap_map_portion(self->map, portion)->space};
    return rmap_message_view(message, &held->rays, err);
}

static uint64_t current(const struct rmap_held_rays *held)
{
    return held->rays.ray.id[held->row];
}

static void drop_held(struct rmap_ray_order *self, size_t i)
{
    rmap_message_destroy(self->held[i].message);
    self->held[i] = self->held[--self->n_held];
}

/* Hands out the rays of one sheaf with ids below `end`. */
static enum rmap_status hand_out(struct rmap_ray_order *self, struct rmap_held_rays *held,
                                 uint64_t end, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *rays = &held->rays;
    while (held->row < rays->n_row[RMAP_TABLE_RAY] && current(held) < end &&
           self->n < self->limit) {
        const struct rmap_streamed_ray ray = {rays, held->row, held->segment, held->registration,
                                              held->space};
        RMAP_TRY(self->sink->take(self->sink->context, &ray, err));
        held->segment += rays->ray.segment_count[held->row];
        held->registration += rays->ray.registration_count[held->row++];
        self->n++;
    }
out:
    return st;
}

enum rmap_status rmap_ray_order_hand_out(struct rmap_ray_order *self, uint64_t end,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (self->n_held > 0 && self->n < self->limit) {
        uint64_t least = UINT64_MAX, second = end;
        size_t at = 0;
        for (size_t i = 0; i < self->n_held; i++) {
            uint64_t id = current(&self->held[i]);
            if (id < least) {
                second = least < second ? least : second;
                least = id;
                at = i;
            } else if (id < second) {
                second = id;
            }
        }
        if (least >= end)
            break;
        /* An id that two rays claim is handed out twice, not for ever. */
        RMAP_TRY(hand_out(self, &self->held[at], second > least ? second : least + 1, err));
        if (self->held[at].row == self->held[at].rays.n_row[RMAP_TABLE_RAY])
            drop_held(self, at);
    }
out:
    return st;
}

void rmap_ray_order_fini(struct rmap_ray_order *self)
{
    while (self->n_held > 0)
        drop_held(self, self->n_held - 1);
    rmap_free(self->held);
    *self = (struct rmap_ray_order){0};
}
