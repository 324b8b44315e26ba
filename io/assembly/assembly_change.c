/* SPDX-License-Identifier: MIT
 *
 * What became of a part in a revision.
 */
#include <math.h>
#include <string.h>

#include "io/assembly/assembly_match.h"
#include "io/assembly/match_side.h"

struct pair {
    const struct rmap_assembly *before, *after;
    int32_t from, to;
};

bool rmap_assembly_is_apart(const struct rmap_affine *a, const struct rmap_affine *b)
{
    const double *x = &a->m[0][0], *y = &b->m[0][0];
    double turned = 0;
    for (int k = 0; k < 9; k++)
        turned = fmax(turned, fabs(x[k] - y[k]));
    const double size = fmax(1, fmax(rmap_length(a->t), rmap_length(b->t)));
    return turned > 1e-9 || rmap_length(rmap_sub(a->t, b->t)) > 1e-9 * size;
}

/* ---- motion ---- */

/* Its columns' lengths; what is left of it is a turn, or a mirrored one. */
static void split(const struct rmap_affine *a, double length[3], struct rmap_affine *turn)
{
    *turn = *a;
    for (int j = 0; j < 3; j++) {
        length[j] = hypot(hypot(a->m[0][j], a->m[1][j]), a->m[2][j]);
        for (int i = 0; i < 3 && length[j] > 0; i++)
            turn->m[i][j] /= length[j];
    }
}

static unsigned motion_between(const struct rmap_affine *from, const struct rmap_affine *to,
                               struct rmap_part_motion *motion)
{
    struct rmap_affine turn[2];
    double length[2][3], apart = 0, chord = 0;
    split(from, length[0], &turn[0]);
    split(to, length[1], &turn[1]);
    bool scaled = false;
    for (int j = 0; j < 3; j++)
        scaled |= fabs(length[1][j] - length[0][j]) > 1e-9 * length[0][j];
    const bool mirrored = rmap_affine_determinant(&turn[0]) * rmap_affine_determinant(&turn[1]) < 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            apart = fmax(apart, fabs(turn[1].m[i][j] - turn[0].m[i][j]));
            chord = hypot(chord, turn[1].m[i][j] - turn[0].m[i][j]);
        }
    const double size = fmax(1, fmax(rmap_length(from->t), rmap_length(to->t)));
    motion->distance = rmap_length(rmap_sub(to->t, from->t));
    if (motion->distance <= 1e-9 * size)
        motion->distance = 0;
    motion->turn = 0;
    if (apart > 1e-9 && !mirrored) /* |R' - R| = sqrt(8) sin(angle / 2) */
        motion->turn = 2 * asin(fmin(chord / sqrt(8), 1)) * 180 / RMAP_PI;
    const double volume[2] = {rmap_affine_determinant(from), rmap_affine_determinant(to)};
    motion->scale = (scaled || mirrored) && fabs(volume[0]) > 0 ? cbrt(volume[1] / volume[0]) : 1;
    return (motion->distance > 0 || (apart > 1e-9 && !mirrored) ? RMAP_PART_MOVED : 0) |
           (scaled || mirrored ? RMAP_PART_SCALED : 0);
}

/* ---- looks ---- */

static bool other_colour(const struct rmap_assembly_colour *a, const struct rmap_assembly_colour *b)
{
    bool other = a->given != b->given;
    for (int k = 0; k < 3; k++)
        other |= fabs(a->rgb[k] - b->rgb[k]) > 1e-3;
    return other;
}

static bool other_text(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") != 0;
}

/* A face's own, or its part's. */
static const struct rmap_assembly_colour *colour_of(const struct rmap_assembly_part *part,
                                                    const struct rmap_assembly_face *face)
{
    return face->colour.given ? &face->colour : &part->colour;
}

static const char *material_of(const struct rmap_assembly_part *part,
                               const struct rmap_assembly_face *face)
{
    return face->material && face->material[0] ? face->material : part->material;
}

static bool other_looks(const struct pair *pair)
{
    const struct rmap_assembly_part *x = &pair->before->part[pair->from],
                                    *y = &pair->after->part[pair->to];
    bool other = other_colour(&x->colour, &y->colour) || other_text(x->material, y->material);
    if (x->shape < 0 || y->shape < 0)
        return other;
    const struct rmap_assembly_shape *s = &pair->before->shape[x->shape],
                                     *t = &pair->after->shape[y->shape];
    for (size_t f = 0; !other && s->n_face == t->n_face && f < s->n_face; f++)
        other = other_colour(colour_of(x, &s->face[f]), colour_of(y, &t->face[f])) ||
                other_text(material_of(x, &s->face[f]), material_of(y, &t->face[f]));
    return other;
}

/* How much larger it is in all directions alike; 1: it is not, or is not another size. */
static double size_ratio(const struct rmap_assembly_shape *from,
                         const struct rmap_assembly_shape *to)
{
    const double same = 1e-6;
    double least = HUGE_VAL, most = 0;
    for (int k = 0; k < 3; k++) {
        const double a = from->upper[k] - from->lower[k], b = to->upper[k] - to->lower[k];
        if (a > 0 || b > 0) {
            least = fmin(least, a > 0 ? b / a : 0);
            most = fmax(most, a > 0 ? b / a : HUGE_VAL);
        }
    }
    const bool alike = least > 0 && isfinite(most) && most - least <= same * most &&
                       from->n_face == to->n_face && from->closed == to->closed;
    return alike && fabs(most - 1) > same ? most : 1;
}

/* ---- the whole ---- */

static unsigned change_of(const struct pair *pair, const struct rmap_assembly_match *match,
                          struct rmap_part_motion *motion)
{
    const struct rmap_assembly_part *x = &pair->before->part[pair->from],
                                    *y = &pair->after->part[pair->to];
    const bool same_parent =
        x->parent < 0 ? y->parent < 0 : y->parent >= 0 && match->from[y->parent] == x->parent;
    struct rmap_affine from = x->place, to = y->place;
    if (!same_parent) {
        from = rmap_assembly_world(pair->before, (size_t)pair->from);
        to = rmap_assembly_world(pair->after, (size_t)pair->to);
    }
    unsigned change = motion_between(&from, &to, motion);
    if (!same_parent) {
        change |= RMAP_PART_REGROUPED;
    } else if (motion->distance > 0 && y->parent >= 0) {
        const struct rmap_affine above = rmap_assembly_world(pair->after, (size_t)y->parent);
        motion->distance *= cbrt(fabs(rmap_affine_determinant(&above)));
    }
    if (x->shape >= 0 &&
        strcmp(pair->before->shape[x->shape].hash, pair->after->shape[y->shape].hash) != 0)
        change |= RMAP_PART_RESHAPED;
    const double ratio = change & RMAP_PART_RESHAPED ? size_ratio(&pair->before->shape[x->shape],
                                                                  &pair->after->shape[y->shape])
                                                     : 1;
    if (ratio < 1 || ratio > 1) {
        motion->scale *= ratio;
        change |= RMAP_PART_SCALED;
    }
    if (strcmp(x->name, y->name) != 0 &&
        !(rmap_assembly_is_numbered(pair->before, (size_t)pair->from) &&
          rmap_assembly_is_numbered(pair->after, (size_t)pair->to)))
        change |= RMAP_PART_RENAMED;
    if (other_looks(pair))
        change |= RMAP_PART_RECOLOURED;
    return change;
}

void rmap_assembly_find_changes(const struct rmap_assembly *before,
                                const struct rmap_assembly *after,
                                struct rmap_assembly_match *match)
{
    for (size_t i = 0; i < after->n_part; i++) {
        const struct pair pair = {before, after, match->from[i], (int32_t)i};
        match->motion[i] = (struct rmap_part_motion){.scale = 1};
        match->change[i] = pair.from < 0 ? 0 : change_of(&pair, match, &match->motion[i]);
    }
}
