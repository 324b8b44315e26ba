/* SPDX-License-Identifier: MIT
 *
 * Shapes of a revision that are old ones in another frame.
 */
#include <math.h>
#include <string.h>

#include "io/assembly/assembly_match.h"

enum { PARTS_TRIED = 16 }; /* of a shape that has any number: one that did not move will do */

/* Of faces that are told apart numbers would be of others in the old one. */
static bool is_plain(const struct rmap_assembly_shape *s)
{
    const struct rmap_assembly_face *first = s->face;
    bool plain = s->n_face > 0;
    for (size_t f = 0; f < s->n_face && plain; f++) {
        const struct rmap_assembly_face *face = &s->face[f];
        plain = (!face->name || !face->name[0]) && (!face->material || !face->material[0]) &&
                face->colour.given == first->colour.given &&
                memcmp(face->colour.rgb, first->colour.rgb, sizeof first->colour.rgb) == 0 &&
                isfinite(face->middle[0]);
    }
    return plain;
}

static struct rmap_vec3 middle_in(const struct rmap_assembly_shape *s, size_t face,
                                  const struct rmap_affine *world)
{
    const double *at = s->face[face].middle;
    return rmap_affine_point(world, rmap_vec3(at[0], at[1], at[2]));
}

/* Whether each face's middle is one of the other's, of as many faces. */
static bool covers(const struct rmap_assembly_shape *a, const struct rmap_affine *world_a,
                   const struct rmap_assembly_shape *b, const struct rmap_affine *world_b,
                   double tolerance)
{
    bool all = true;
    for (size_t f = 0; f < a->n_face && all; f++) {
        const struct rmap_vec3 at = middle_in(a, f, world_a);
        all = false;
        for (size_t k = 0; k < b->n_face && !all; k++) /* most have the same number */
            all = rmap_length(rmap_sub(middle_in(b, (f + k) % b->n_face, world_b), at)) < tolerance;
    }
    return all;
}

/* Two bodies of one form that stand in the same place. */
static bool coincide(const struct rmap_assembly_shape *a, const struct rmap_affine *world_a,
                     const struct rmap_assembly_shape *b, const struct rmap_affine *world_b)
{
    double size = 0;
    for (int k = 0; k < 3; k++)
        size = hypot(size, a->upper[k] - a->lower[k]);
    const double tolerance = 1e-7 * size + 1e-12 * rmap_length(world_a->t);
    return covers(a, world_a, b, world_b, tolerance) && covers(b, world_b, a, world_a, tolerance);
}

/* How the new shape's frame lies in the old one's, by a part of it that did not move. */
static bool find_frame(const struct rmap_assembly *before, int32_t old,
                       const struct rmap_assembly *after, int32_t new, struct rmap_affine *frame)
{
    size_t tried = 0;
    for (size_t j = 0; j < after->n_part && tried < PARTS_TRIED; j++) {
        if (after->part[j].shape != new)
            continue;
        const struct rmap_affine there = rmap_assembly_world(after, j);
        tried++;
        for (size_t i = 0; i < before->n_part; i++) {
            struct rmap_affine back;
            if (before->part[i].shape != old)
                continue;
            const struct rmap_affine here = rmap_assembly_world(before, i);
            if (!coincide(&before->shape[old], &here, &after->shape[new], &there) ||
                !rmap_affine_invert(&here, &back))
                continue;
            *frame = rmap_affine_compose(&back, &there);
            return true;
        }
    }
    return false;
}

static void take_frame(const struct rmap_assembly_shape *old, struct rmap_assembly *after,
                       int32_t new, const struct rmap_affine *frame)
{
    struct rmap_assembly_shape *shape = &after->shape[new];
    struct rmap_affine back;
    if (!rmap_affine_invert(frame, &back))
        return;
    for (size_t i = 0; i < after->n_part; i++)
        if (after->part[i].shape == new)
            after->part[i].place = rmap_affine_compose(&after->part[i].place, &back);
    for (size_t f = 0; f < shape->n_face; f++)
        memcpy(shape->face[f].middle, old->face[f].middle, sizeof old->face[f].middle);
    memcpy(shape->hash, old->hash, sizeof old->hash);
    memcpy(shape->lower, old->lower, sizeof old->lower);
    memcpy(shape->upper, old->upper, sizeof old->upper);
    shape->chord = old->chord;
}

/* near: where it is looked for first, as most stand where they stood. */
static bool has_hash(const struct rmap_assembly *a, const char *hash, size_t near)
{
    bool has = false;
    for (size_t i = 0; i < a->n_shape && !has; i++)
        has = strcmp(a->shape[(near + i) % a->n_shape].hash, hash) == 0;
    return has;
}

void rmap_assembly_keep_frames(const struct rmap_assembly *before, struct rmap_assembly *after)
{
    struct rmap_affine frame;
    if (fabs(before->chord - after->chord) > 1e-9 * before->chord ||
        fabs(before->angle - after->angle) > 1e-9 * before->angle)
        return; /* all meshes are made anew */
    for (size_t new = 0; new < after->n_shape; new ++) {
        const struct rmap_assembly_shape *shape = &after->shape[new];
        if (!shape->form[0] || !shape->closed || !is_plain(shape) ||
            has_hash(before, shape->hash, new))
            continue;
        for (size_t old = 0; old < before->n_shape; old++) {
            const struct rmap_assembly_shape *its = &before->shape[old];
            /* A damaged one (no digest) is to be made again, of what is there now. */
            if (strcmp(its->form, shape->form) != 0 || its->n_face != shape->n_face ||
                !its->digest || !is_plain(its) || has_hash(after, its->hash, old) ||
                !find_frame(before, (int32_t)old, after, (int32_t) new, &frame))
                continue;
            take_frame(its, after, (int32_t) new, &frame);
            break;
        }
    }
}
