/* SPDX-License-Identifier: MIT
 *
 * Gradient media in place: a place for every frame in which a gradient medium stands.
 */
#include "scene/scene_gradient.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "gradient/curve.h"
#include "scene/bounds.h"

static bool is_gradient(const struct rmap_scene *scene, int32_t medium)
{
    return medium >= 0 && (size_t)medium < scene->n_medium && scene->medium[medium].field;
}

/* ---- one place for every frame ---- */

static void place_side(struct rmap_scene *scene, const struct rmap_object *object, int32_t medium,
                       int32_t *gradient)
{
    if (!is_gradient(scene, medium))
        *gradient = 0;
    if (!is_gradient(scene, medium) || *gradient > 0)
        return;
    scene->gradient[scene->n_gradient++] =
        (struct rmap_gradient){.medium = medium, .to_world = object->to_world};
    *gradient = (int32_t)scene->n_gradient;
}

static enum rmap_status place_sides(struct rmap_scene *scene, struct rmap_error *err)
{
    size_t n = scene->n_gradient;
    for (size_t o = 0; o < scene->n_object; o++)
        n += (size_t)is_gradient(scene, scene->object[o].medium_front) +
             (size_t)is_gradient(scene, scene->object[o].medium_back);
    void *grown = n ? rmap_realloc(scene->gradient, n, sizeof *scene->gradient) : NULL;
    if (n && !grown)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for gradient media");
    if (n)
        scene->gradient = grown;
    for (size_t o = 0; o < scene->n_object; o++) {
        struct rmap_object *object = &scene->object[o];
        place_side(scene, object, object->medium_front, &object->gradient_front);
        place_side(scene, object, object->medium_back, &object->gradient_back);
    }
    return RMAP_OK;
}

struct place {
    int32_t medium, old;
    double frame[12]; /* without negative zeros */
};

static int by_frame(const void *a, const void *b)
{
    const struct place *left = a, *right = b;
    if (left->medium != right->medium)
        return left->medium < right->medium ? -1 : 1;
    int order = memcmp(left->frame, right->frame, sizeof left->frame);
    return order ? order : (left->old > right->old) - (left->old < right->old);
}

static struct place place_of(const struct rmap_gradient *gradient, size_t old)
{
    const struct rmap_affine *frame = &gradient->to_world;
    const double t[3] = {frame->t.x, frame->t.y, frame->t.z};
    struct place place = {.medium = gradient->medium, .old = (int32_t)old};
    for (int i = 0; i < 12; i++) /* adding 0 makes -0 a plain 0 */
        place.frame[i] = (i < 9 ? frame->m[i / 3][i % 3] : t[i - 9]) + 0.0;
    return place;
}

/* first[i]: the first place that is the same as place i. */
static enum rmap_status find_equals(const struct rmap_scene *scene, int32_t *first,
                                    struct rmap_error *err)
{
    struct place *place = rmap_alloc(scene->n_gradient, sizeof *place);
    if (!place)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for gradient media");
    for (size_t i = 0; i < scene->n_gradient; i++)
        place[i] = place_of(&scene->gradient[i], i);
    qsort(place, scene->n_gradient, sizeof *place, by_frame);
    for (size_t i = 0; i < scene->n_gradient; i++) {
        bool same = i && place[i].medium == place[i - 1].medium &&
                    memcmp(place[i].frame, place[i - 1].frame, sizeof place[i].frame) == 0;
        first[place[i].old] = same ? first[place[i - 1].old] : place[i].old;
    }
    rmap_free(place);
    return RMAP_OK;
}

/* Every reference to a place: gradient numbers, which are 1 + index. */
static void refer(int32_t *gradient, const int32_t *first, const int32_t *index, bool *used)
{
    if (*gradient <= 0)
        return;
    int32_t at = first[*gradient - 1];
    used[at] = true;
    if (index)
        *gradient = 1 + index[at];
}

static void refer_all(struct rmap_scene *scene, const int32_t *first, const int32_t *index,
                      bool *used)
{
    for (size_t o = 0; o < scene->n_object; o++) {
        refer(&scene->object[o].gradient_front, first, index, used);
        refer(&scene->object[o].gradient_back, first, index, used);
    }
    for (size_t s = 0; s < scene->n_source; s++)
        refer(&scene->source[s].gradient, first, index, used);
    for (size_t c = 0; c < scene->n_camera; c++)
        refer(&scene->camera[c].gradient, first, index, used);
}

static enum rmap_status merge_places(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = scene->n_gradient, kept = 0;
    int32_t *first = rmap_alloc(n, sizeof *first), *index = rmap_alloc(n, sizeof *index);
    bool *used = rmap_alloc(n, sizeof *used);
    if (!first || !index || !used) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for gradient media");
        goto out;
    }
    RMAP_TRY(find_equals(scene, first, err));
    refer_all(scene, first, NULL, used);
    for (size_t i = 0; i < n; i++) {
        if (!used[i])
            continue;
        index[i] = (int32_t)kept;
        scene->gradient[kept++] = scene->gradient[i];
    }
    refer_all(scene, first, index, used);
    scene->n_gradient = kept;
out:
    rmap_free(first);
    rmap_free(index);
    rmap_free(used);
    return st;
}

/* ---- what a place implies ---- */

/* Longest diagonal in the world of a box in some frame. */
static double diagonal(const struct rmap_bounds *box, const struct rmap_affine *to_world)
{
    struct rmap_vec3 d = rmap_sub(box->upper, box->lower);
    double longest = 0;
    for (int k = 0; k < 4; k++) {
        struct rmap_vec3 across = rmap_vec3(d.x, k & 1 ? -d.y : d.y, k & 2 ? -d.z : d.z);
        longest = rmap_max(longest, rmap_length(rmap_affine_vector(to_world, across)));
    }
    return longest;
}

/* Sizes: diagonals of the boxes about the objects that bound each, in the frame of the first of
 * them, so that they do not depend on how the body is turned; the scene's for media that only
 * sources stand in. */
static enum rmap_status measure(struct rmap_scene *scene, struct rmap_error *err)
{
    struct rmap_bounds *box = rmap_alloc(scene->n_gradient, sizeof *box);
    const struct rmap_object **first = rmap_alloc(scene->n_gradient, sizeof *first);
    enum rmap_status st = RMAP_OK;
    if (!box || !first) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for gradient media");
        goto out;
    }
    for (size_t i = 0; i < scene->n_gradient; i++)
        box[i] = rmap_bounds_empty();
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        const int32_t side[2] = {object->gradient_front, object->gradient_back};
        for (int k = 0; k < 2; k++) {
            if (side[k] <= 0)
                continue;
            const struct rmap_object **frame = &first[side[k] - 1];
            *frame = *frame ? *frame : object;
            struct rmap_affine to_frame =
                rmap_affine_compose(&(*frame)->to_local, &object->to_world);
            rmap_bounds_include_geometry(&box[side[k] - 1], &scene->geometry[object->geometry],
                                         &to_frame);
        }
    }
    for (size_t i = 0; i < scene->n_gradient; i++) {
        double size = first[i] ? diagonal(&box[i], &first[i]->to_world) : 0;
        scene->gradient[i].size = size > 0 && isfinite(size) ? size : 2 * scene->radius;
    }
out:
    rmap_free(box);
    rmap_free(first);
    return st;
}

static double or_else(double given, double chosen)
{
    return given > 0 ? given : chosen;
}

static struct rmap_curve_options resolve(const struct rmap_curve_options *said, double size)
{
    return (struct rmap_curve_options){
        .scheme = said->scheme,
        .tolerance = or_else(said->tolerance, 1e-9 * size),
        .sag = or_else(said->sag, 1e-2 * size),
        .polyline = or_else(said->polyline, 1e-3 * size),
        .step_min = or_else(said->step_min, 1e-4 * size),
        .step_max = or_else(said->step_max, 1e-2 * size),
        .step = or_else(said->step, 1e-2 * size),
        .amplitude = or_else(said->amplitude, 1 / size),
        .max_steps = said->max_steps ? said->max_steps : 1000000,
    };
}

/* Below the first share rounding rules, beyond the second nothing is followed any more. */
static const double tolerance_least = 1e-15, tolerance_most = 0.1;

static enum rmap_status check_options(const struct rmap_gradient *gradient,
                                      const struct rmap_medium *medium, struct rmap_error *err)
{
    double least = tolerance_least * gradient->size, most = tolerance_most * gradient->size;
    const struct {
        const char *key;
        double value, most;
    } length[] = {{"tolerance", gradient->options.tolerance, most},
                  {"sag", gradient->options.sag, gradient->size},
                  {"polyline", gradient->options.polyline, gradient->size}};
    for (int i = 0; i < 3; i++)
        if (!(length[i].value >= least && length[i].value <= length[i].most))
            return rmap_error_set(err, RMAP_INPUT,
                                  "'%s' of medium '%s' is %g: what it fills is %g across, so it "
                                  "must be %.3g to %.3g",
                                  length[i].key, medium->name ? medium->name : "", length[i].value,
                                  gradient->size, least, length[i].most);
    return RMAP_OK;
}

static enum rmap_status fill_in(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(measure(scene, err));
    for (size_t i = 0; i < scene->n_gradient; i++) {
        struct rmap_gradient *gradient = &scene->gradient[i];
        const struct rmap_medium *medium = &scene->medium[gradient->medium];
        gradient->field = medium->field;
        gradient->beside = medium->beside[0] && medium->beside[1] ? medium->beside : NULL;
        gradient->options = resolve(&medium->curve, gradient->size);
        if (!rmap_affine_invert(&gradient->to_world, &gradient->to_local))
            return rmap_error_set(err, RMAP_INPUT,
                                  "medium '%s' stands in a frame that is singular (a scale of 0?)",
                                  medium->name ? medium->name : "");
        RMAP_TRY(check_options(gradient, medium, err));
        rmap_curve_prepare(gradient);
    }
out:
    return st;
}

/* What stands in a medium of one place stands there. */
static enum rmap_status place_inside(struct rmap_scene *scene, const char *name, int32_t medium,
                                     int32_t *gradient, struct rmap_error *err)
{
    size_t n = 0;
    if (!is_gradient(scene, medium) || *gradient > 0)
        return RMAP_OK;
    for (size_t i = 0; i < scene->n_gradient; i++) {
        if (scene->gradient[i].medium != medium)
            continue;
        *gradient = (int32_t)(1 + i);
        n++;
    }
    if (n == 1)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT, "'%s' stands in medium '%s', which stands in %s: %s",
                          name ? name : "",
                          scene->medium[medium].name ? scene->medium[medium].name : "",
                          n ? "several places" : "no place",
                          n ? "say which, with 'within:' and the name of an object"
                            : "fill a body with it, or give the medium 'frame: world'");
}

static enum rmap_status place_insides(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t s = 0; s < scene->n_source; s++)
        RMAP_TRY(place_inside(scene, scene->source[s].name, scene->source[s].medium,
                              &scene->source[s].gradient, err));
    for (size_t c = 0; c < scene->n_camera; c++)
        RMAP_TRY(place_inside(scene, scene->camera[c].name, scene->camera[c].medium,
                              &scene->camera[c].gradient, err));
out:
    return st;
}

enum rmap_status rmap_scene_place_gradients(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(place_sides(scene, err));
    if (scene->n_gradient) {
        RMAP_TRY(merge_places(scene, err));
        RMAP_TRY(fill_in(scene, err));
    }
    RMAP_TRY(place_insides(scene, err));
out:
    return st;
}
