/* SPDX-License-Identifier: MIT
 *
 * Pictures of a camera that become better while one looks: each has four times the samples of the
 * one before, so that all together cost a third more than the last.
 */
#include "mpi/serve/serve_render.h"

#include "mpi/serve/serve_command.h"

enum { SAMPLES = 64, MORE = 4 };

/* Rank 0. The picture on its way to who asked. */
static void tell(const struct rmap_serve *self, json_t *result, json_int_t samples)
{
    json_t *told =
        json_pack("{s:O?, s:s, s:I}", "id", json_object_get(self->request->message, "id"), "event",
                  "render", "samples", samples);
    (void)json_object_update(told, result);
    rmap_serve_tell(self->request, told);
}

enum rmap_status rmap_serve_render(struct rmap_serve *self, const json_t *message, json_t **result,
                                   struct rmap_error *err)
{
    const json_t *asked = json_object_get(message, "samples");
    const json_int_t all = asked ? json_integer_value(asked) : SAMPLES;
    const json_t *before = json_object_get(message, "rendered");
    const json_int_t next = before ? MORE * json_integer_value(before) : 1;
    const json_int_t n = next < all && next > 0 ? next : all;
    if (asked && (!json_is_integer(asked) || all < 1))
        return rmap_error_set(err, RMAP_USAGE, "'samples' is a whole number of paths per pixel");
    json_t *question = json_copy((json_t *)(uintptr_t)message);
    (void)json_object_set_new(question, "samples", json_integer(n));
    (void)json_object_del(question, "rendered");
    (void)json_object_del(question, "begun");
    const enum rmap_status st =
        rmap_serve_command_run(self, rmap_serve_command_find("render"), question, result, err);
    json_decref(question);
    if (st != RMAP_OK)
        return st;
    self->again = n < all;
    if (!self->again || self->context.rank != 0)
        return RMAP_OK;
    tell(self, *result, n);
    json_decref(*result);
    *result = NULL;
    (void)json_object_set_new(self->request->message, "rendered", json_integer(n));
    return RMAP_OK;
}
