/* SPDX-License-Identifier: MIT
 *
 * What a ray notices of the difference between two scenes.
 */
#include "scene/scene_change.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "scene/scene_same.h"

struct finding {
    struct rmap_scene_pair pair;
    struct rmap_scene_change *change;
};

/* why: about the source of that name, where there is one. */
static void say_all(struct rmap_scene_change *change, const char *why, const char *name)
{
    if (!change->all[0])
        (void)snprintf(change->all, sizeof change->all, name ? "source '%s' %s" : "%s%s",
                       name ? name : "", why);
}

static bool same_name(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") == 0;
}

/* Objects are known by their ids, sorted. */
struct known {
    uint64_t id;
    int32_t object;
};

static int by_id(const void *a, const void *b)
{
    const struct known *first = a, *second = b;
    return first->id < second->id ? -1 : first->id > second->id;
}

static enum rmap_status match_objects(struct finding *self, struct rmap_error *err)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct known *known = rmap_alloc(new->n_object, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu objects", new->n_object);
    for (size_t i = 0; i < new->n_object; i++)
        known[i] = (struct known){new->object[i].id, (int32_t)i};
    qsort(known, new->n_object, sizeof *known, by_id);
    for (size_t i = 0; i < old->n_object; i++) {
        const struct known key = {.id = old->object[i].id};
        const struct known *found = bsearch(&key, known, new->n_object, sizeof key, by_id);
        self->change->object[i] = found ? found->object : -1;
    }
    rmap_free(known);
    return RMAP_OK;
}

static void match_names(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    for (size_t i = 0; i < old->n_medium; i++) {
        self->change->medium[i] = -1;
        for (size_t k = 0; k < new->n_medium; k++)
            if (same_name(old->medium[i].name, new->medium[k].name))
                self->change->medium[i] = (int32_t)k;
    }
    for (size_t i = 0; i < old->n_detector; i++) {
        self->change->detector[i] = -1;
        for (size_t k = 0; k < new->n_detector; k++)
            if (same_name(old->detector[i].name, new->detector[k].name))
                self->change->detector[i] = (int32_t)k;
    }
}

/* Of surfaces that coincide, and of detectors that are crossed at once, the number decides which
 * comes first. */
static bool in_order(const int32_t *to, size_t n, bool *renumbers)
{
    int32_t last = -1;
    for (size_t i = 0; i < n; i++) {
        *renumbers = *renumbers || to[i] != (int32_t)i;
        if (to[i] >= 0 && to[i] <= last)
            return false;
        last = to[i] >= 0 ? to[i] : last;
    }
    return true;
}

/* What every ray depends on. */
static void compare_frame(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    const size_t nbytes = (size_t) new->channels.n * sizeof(double);
    if (old->channels.mode != new->channels.mode || old->channels.n != new->channels.n ||
        memcmp(old->channels.wavelength_nm, new->channels.wavelength_nm, nbytes) != 0)
        say_all(change, "light is described by another spectrum", NULL);
    else if (rmap_scene_is_curved(old) || rmap_scene_is_curved(new))
        say_all(change, "it has gradient media, whose curved rays are not compared", NULL);
    else if (old->timed != new->timed)
        say_all(change, "times of arrival are kept in one of the two alone", NULL);
    else if (old->limit_steps != new->limit_steps ||
             memcmp(&old->limit_weight, &new->limit_weight, sizeof(double)) != 0)
        say_all(change, "limits differ", NULL);
    else if (old->fluoresces != new->fluoresces || old->accounting != new->accounting ||
             (new->fluoresces &&memcmp(old->worth, new->worth, nbytes) != 0))
        say_all(change, "light given back is counted otherwise", NULL);
    else if (!in_order(change->object, old->n_object, &change->renumbers))
        say_all(change, "its objects stand in another order", NULL);
    else if (!in_order(change->detector, old->n_detector, &change->renumbers))
        say_all(change, "its detectors stand in another order", NULL);
    for (size_t i = 0; i < old->n_medium; i++)
        change->renumbers = change->renumbers || change->medium[i] != (int32_t)i;
}

static void compare_light(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    bool same = old->n_source == new->n_source;
    if (change->all[0])
        return;
    for (size_t i = 0; same && i < new->n_source; i++)
        same = same_name(old->source[i].name, new->source[i].name);
    if (!same)
        say_all(change, "it has other sources", NULL);
    else if (old->schedule_len != new->schedule_len ||
             memcmp(old->schedule, new->schedule, new->schedule_len * sizeof *new->schedule) != 0)
        say_all(change, "its sources have other shares of the rays", NULL);
    for (size_t i = 0; same && i < new->n_source; i++)
        if (!rmap_same_source(&self->pair, i, i))
            say_all(change,
                    rmap_source_is_compared(&new->source[i])
                        ? "emits other rays"
                        : "is of a kind (volume, steps) that is not compared",
                    new->source[i].name ? new->source[i].name : "");
}

static void compare_media(struct finding *self)
{
    struct rmap_scene_change *change = self->change;
    for (size_t i = 0; i < self->pair.old->n_medium; i++)
        change->in[i] =
            change->medium[i] < 0 || !rmap_same_medium(&self->pair, (int32_t)i, change->medium[i]);
}

/* Beside both being there: does the search for surfaces see the same, and does light find it the
 * same? */
static void compare_object(struct finding *self, size_t i)
{
    const struct rmap_scene_pair *pair = &self->pair;
    struct rmap_scene_change *change = self->change;
    const int32_t to = change->object[i];
    if (to < 0) {
        change->met[i] = change->stood[i] = 1;
        return;
    }
    const struct rmap_object *a = &pair->old->object[i], *b = &pair->new->object[to];
    const bool placed = memcmp(&a->to_world, &b->to_world, sizeof a->to_world) == 0 &&
                        memcmp(&a->to_local, &b->to_local, sizeof a->to_local) == 0 &&
                        rmap_same_geometry(pair, a->geometry, b->geometry) &&
                        rmap_same_medium_number(pair, a->medium_front, b->medium_front) &&
                        rmap_same_medium_number(pair, a->medium_back, b->medium_back);
    change->stood[i] = change->stands[to] = !placed;
    change->met[i] = !placed || (a->medium_front >= 0 && change->in[a->medium_front]) ||
                     (a->medium_back >= 0 && change->in[a->medium_back]) ||
                     !rmap_same_medium_number(pair, a->medium_outside, b->medium_outside) ||
                     !rmap_same_surface(pair, a->surface_front, b->surface_front) ||
                     !rmap_same_surface(pair, a->surface_back, b->surface_back);
}

static void compare_objects(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    memset(change->stands, 1, new->n_object); /* those that nobody names are new */
    for (size_t i = 0; i < old->n_object; i++)
        compare_object(self, i);
}

static void compare_detectors(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    memset(change->watches, 1, new->n_detector);
    for (size_t i = 0; i < old->n_detector; i++) {
        const int32_t to = change->detector[i];
        const bool same = to >= 0 && rmap_same_detector(&old->detector[i], &new->detector[to]);
        change->noted[i] = !same;
        if (same)
            change->watches[to] = 0;
        change->leaving |= !same && old->detector[i].type == RMAP_DETECTOR_INTENSITY;
    }
    for (size_t i = 0; i < new->n_detector; i++)
        change->leaving |= change->watches[i] && new->detector[i].type == RMAP_DETECTOR_INTENSITY;
}

static bool same_faces(const struct rmap_scene *old, size_t object, const struct rmap_detector *a,
                       const struct rmap_detector *b)
{
    const struct rmap_mesh *mesh = old->geometry[old->object[object].geometry].mesh;
    return !a->face == !b->face &&
           (!a->face || (mesh && memcmp(a->face, b->face, mesh->n_face) == 0));
}

/* Detectors that lie on an object: whoever meets it is another ray if one of them is. */
static void compare_lying(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    for (size_t i = 0; i < old->n_object; i++) {
        const size_t first = old->on_first[i], n = old->on_first[i + 1] - first;
        if (change->met[i])
            continue;
        const size_t to = new->on_first[change->object[i]];
        bool same = new->on_first[change->object[i] + 1] - to == n;
        for (size_t k = 0; same && k < n; k++) {
            const int32_t d = old->on_detector[first + k], e = new->on_detector[to + k];
            same = change->detector[d] == e && !change->noted[d] &&
                   same_faces(old, i, &old->detector[d], &new->detector[e]);
        }
        change->met[i] = !same;
    }
}

/* Planes free in space see whoever passes; those on objects whoever meets these. One that became
 * the other is another one. */
static void settle_detectors(struct finding *self)
{
    const struct rmap_scene *old = self->pair.old, *new = self->pair.new;
    struct rmap_scene_change *change = self->change;
    for (size_t i = 0; i < old->n_detector; i++) {
        const int32_t to = change->detector[i];
        const struct rmap_detector *a = &old->detector[i], *b = to < 0 ? NULL : &new->detector[to];
        if (b && (a->on_object >= 0 || a->on_group >= 0) != (b->on_object >= 0 || b->on_group >= 0))
            change->noted[i] = change->watches[to] = 1;
    }
    for (size_t i = 0; i < new->n_detector; i++)
        if (new->detector[i].on_object >= 0 || new->detector[i].on_group >= 0 ||
            new->detector[i].type == RMAP_DETECTOR_INTENSITY)
            change->watches[i] = 0;
}

static enum rmap_status reserve(const struct rmap_scene *old, const struct rmap_scene *new,
                                struct rmap_scene_change *change, struct rmap_error *err)
{
    change->object = rmap_alloc(old->n_object, sizeof *change->object);
    change->medium = rmap_alloc(old->n_medium, sizeof *change->medium);
    change->detector = rmap_alloc(old->n_detector, sizeof *change->detector);
    change->met = rmap_alloc(old->n_object, 1);
    change->in = rmap_alloc(old->n_medium, 1);
    change->noted = rmap_alloc(old->n_detector, 1);
    change->stood = rmap_alloc(old->n_object, 1);
    change->stands = rmap_alloc(new->n_object, 1);
    change->watches = rmap_alloc(new->n_detector, 1);
    if (change->object && change->medium && change->detector && change->met && change->in &&
        change->noted && change->stood && change->stands && change->watches)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory to compare two scenes");
}

enum rmap_status rmap_scene_change_find(const struct rmap_scene *old, const struct rmap_scene *new,
                                        struct rmap_scene_change *change, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct finding self = {.pair = {.old = old, .new = new}, .change = change};
    *change = (struct rmap_scene_change){.leaving = false};
    RMAP_TRY(reserve(old, new, change, err));
    self.pair.medium = change->medium;
    RMAP_TRY(match_objects(&self, err));
    match_names(&self);
    compare_frame(&self);
    compare_light(&self);
    if (change->all[0])
        goto out;
    change->same_sphere =
        memcmp(&old->centre, &new->centre, sizeof old->centre) == 0 && old->radius == new->radius;
    change->leaving = !change->same_sphere;
    compare_media(&self);
    compare_objects(&self);
    compare_detectors(&self);
    compare_lying(&self);
    settle_detectors(&self);
out:
    return st;
}

void rmap_scene_change_settle(const struct rmap_scene *old, struct rmap_scene_change *change)
{
    for (size_t i = 0; i < old->n_object; i++) {
        const int32_t to = change->object[i];
        if (!change->stood[i] && !(to >= 0 && change->stands[to]))
            continue;
        change->met[i] = change->stood[i] = 1;
        if (to >= 0)
            change->stands[to] = 1;
    }
}

void rmap_scene_change_fini(struct rmap_scene_change *change)
{
    rmap_free(change->object);
    rmap_free(change->medium);
    rmap_free(change->detector);
    rmap_free(change->met);
    rmap_free(change->in);
    rmap_free(change->noted);
    rmap_free(change->stood);
    rmap_free(change->stands);
    rmap_free(change->watches);
    *change = (struct rmap_scene_change){.leaving = false};
}
