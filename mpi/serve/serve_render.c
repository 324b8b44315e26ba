/* SPDX-License-Identifier: MIT
 *
 * Pictures of a camera that become better while one looks, in short steps, between which others are
 * answered.
 */
#include "mpi/serve/serve_render.h"

#include "base/count.h"
#include "mpi/serve/serve_command.h"

static const double step_s = 0.1;

/* Rank 0. The picture on its way to who asked. */
static void tell(const struct rmap_serve *self, json_t *result)
{
    json_t *told = json_pack("{s:O?, s:s}", "id", json_object_get(self->request->message, "id"),
                             "event", "render");
    (void)json_object_update(told, result);
    rmap_serve_tell(self->request, told);
}

/* The request's own, or one that nobody has; NULL: there is none. */
static struct rmap_at_hand_steps *find_steps(struct rmap_serve *self, const json_t *begun)
{
    struct rmap_at_hand_steps *found = NULL;
    for (size_t i = RMAP_COUNT(self->render); i-- > 0;)
        if (begun ? (size_t)json_integer_value(begun) == i : !self->render[i].state)
            found = &self->render[i];
    return found;
}

enum rmap_status rmap_serve_render(struct rmap_serve *self, const json_t *message, json_t **result,
                                   struct rmap_error *err)
{
    struct rmap_at_hand_steps *steps = find_steps(self, json_object_get(message, "begun"));
    self->again = !steps;
    if (!steps) /* others' pictures come first */
        return RMAP_OK;
    json_t *question = json_copy((json_t *)(uintptr_t)message);
    (void)json_object_del(question, "begun");
    steps->seconds = step_s;
    self->at_hand.steps = steps;
    const enum rmap_status st =
        rmap_serve_command_run(self, rmap_serve_command_find("render"), question, result, err);
    self->at_hand.steps = NULL;
    json_decref(question);
    if (st != RMAP_OK && steps->state) {
        steps->destroy(steps->state);
        steps->state = NULL;
    }
    self->again = steps->state != NULL;
    if (self->context.rank != 0)
        return st;
    self->request->state = steps->state;
    if (!self->again)
        return st;
    (void)json_object_set_new(self->request->message, "begun", json_integer(steps - self->render));
    if (*result)
        tell(self, *result);
    json_decref(*result);
    *result = NULL;
    return st;
}

void rmap_serve_render_fini(struct rmap_serve *self)
{
    for (size_t i = 0; i < RMAP_COUNT(self->render); i++)
        if (self->render[i].state)
            self->render[i].destroy(self->render[i].state);
}
