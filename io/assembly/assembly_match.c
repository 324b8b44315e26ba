/* SPDX-License-Identifier: MIT
 *
 * Which part of a revision is which part of the one before.
 */
#include "io/assembly/assembly_match.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"

/* A part by what it is looked for. */
struct key {
    uint64_t value;
    int32_t part;
};

struct matching {
    const struct rmap_assembly *before, *after;
    struct rmap_assembly_match *match;
    struct key *key[2]; /* of what is not matched yet, sorted by value */
    uint64_t *path[2];  /* [n_part] names from the root on */
    struct rmap_affine *world[2];
};

static const struct rmap_assembly *side_of(const struct matching *m, int side)
{
    return side ? m->after : m->before;
}

static int by_value(const void *a, const void *b)
{
    const struct key *x = a, *y = b;
    if (x->value != y->value)
        return x->value < y->value ? -1 : 1;
    return (x->part > y->part) - (x->part < y->part);
}

static uint64_t text_hash(const char *text)
{
    return XXH3_64bits(text, strlen(text));
}

static uint64_t id_of(const struct matching *m, int side, size_t i)
{
    return text_hash(side_of(m, side)->part[i].id);
}

static uint64_t path_of(const struct matching *m, int side, size_t i)
{
    return m->path[side][i];
}

static uint64_t shape_of(const struct matching *m, int side, size_t i)
{
    const struct rmap_assembly *a = side_of(m, side);
    return a->part[i].shape < 0 ? 0 : text_hash(a->shape[a->part[i].shape].hash);
}

static bool same_kind(const struct matching *m, int32_t from, int32_t to)
{
    return (m->before->part[from].shape < 0) == (m->after->part[to].shape < 0);
}

static bool same_name(const struct matching *m, int32_t from, int32_t to)
{
    return strcmp(m->before->part[from].name, m->after->part[to].name) == 0;
}

static bool same_shape(const struct matching *m, int32_t from, int32_t to)
{
    return m->before->part[from].shape >= 0 && m->after->part[to].shape >= 0 &&
           shape_of(m, 0, (size_t)from) == shape_of(m, 1, (size_t)to);
}

static void join(struct matching *m, int32_t from, int32_t to)
{
    m->match->from[to] = from;
    m->match->to[from] = to;
}

/* Those of one value on either side, [first, end) of m->key. */
struct run {
    size_t first[2], end[2];
};

static size_t collect(struct matching *m, int side,
                      uint64_t value(const struct matching *m, int side, size_t i))
{
    const int32_t *known = side ? m->match->from : m->match->to;
    size_t n = 0;
    for (size_t i = 0; i < side_of(m, side)->n_part; i++)
        if (known[i] < 0)
            m->key[side][n++] = (struct key){value(m, side, i), (int32_t)i};
    if (n > 0)
        qsort(m->key[side], n, sizeof *m->key[side], by_value);
    return n;
}

static void each_run(struct matching *m,
                     uint64_t value(const struct matching *m, int side, size_t i),
                     void visit(struct matching *m, const struct run *run))
{
    const size_t n[2] = {collect(m, 0, value), collect(m, 1, value)};
    struct run run = {0};
    while (run.first[0] < n[0] && run.first[1] < n[1]) {
        const uint64_t a = m->key[0][run.first[0]].value, b = m->key[1][run.first[1]].value;
        for (int side = 0; side < 2; side++) {
            run.end[side] = run.first[side];
            while (run.end[side] < n[side] && m->key[side][run.end[side]].value == (a < b ? a : b))
                run.end[side]++;
        }
        if (a == b)
            visit(m, &run);
        memcpy(run.first, run.end, sizeof run.first);
    }
}

/* ---- the rules ---- */

/* Ids stand once on each side. */
static void join_by_id(struct matching *m, const struct run *run)
{
    const int32_t from = m->key[0][run->first[0]].part, to = m->key[1][run->first[1]].part;
    if (same_kind(m, from, to) && (same_name(m, from, to) || same_shape(m, from, to)))
        join(m, from, to);
}

static void join_by_id_alone(struct matching *m, const struct run *run)
{
    const int32_t from = m->key[0][run->first[0]].part, to = m->key[1][run->first[1]].part;
    if (same_kind(m, from, to))
        join(m, from, to);
}

static void join_by_path(struct matching *m, const struct run *run)
{
    const int32_t from = m->key[0][run->first[0]].part, to = m->key[1][run->first[1]].part;
    if (run->end[0] - run->first[0] == 1 && run->end[1] - run->first[1] == 1 &&
        same_kind(m, from, to))
        join(m, from, to);
}

/* Of many alike (screws) each takes the nearest that is left; of very many in their order. */
static void join_nearest(struct matching *m, const struct run *run, double most)
{
    enum { MANY = 4000000 };
    const size_t n[2] = {run->end[0] - run->first[0], run->end[1] - run->first[1]};
    const bool many = n[0] > MANY / n[1];
    for (size_t k = run->first[1]; k < run->end[1]; k++) {
        const int32_t to = m->key[1][k].part;
        if (m->match->from[to] >= 0)
            continue;
        double least = most;
        int32_t nearest = -1;
        const size_t only = run->first[0] + (k - run->first[1]);
        for (size_t i = many ? only : run->first[0];
             i < (many && only < run->end[0] ? only + 1 : run->end[0]); i++) {
            const int32_t from = m->key[0][i].part;
            const double away = rmap_length(rmap_sub(m->world[0][from].t, m->world[1][to].t));
            if (m->match->to[from] < 0 && away < least) {
                least = away;
                nearest = from;
            }
        }
        if (nearest >= 0)
            join(m, nearest, to);
    }
}

/* Those that stand where they stood first: a new part does not take their place. */
static void join_by_shape(struct matching *m, const struct run *run)
{
    const double at_one_place = 1e-6;
    if (m->before->part[m->key[0][run->first[0]].part].shape < 0)
        return;
    join_nearest(m, run, at_one_place);
    join_nearest(m, run, HUGE_VAL);
}

/* ---- what became of a part ---- */

static bool is_apart(const struct rmap_affine *a, const struct rmap_affine *b)
{
    const double *x = &a->m[0][0], *y = &b->m[0][0];
    double turned = 0;
    for (int k = 0; k < 9; k++)
        turned = fmax(turned, fabs(x[k] - y[k]));
    const double size = fmax(1, fmax(rmap_length(a->t), rmap_length(b->t)));
    return turned > 1e-9 || rmap_length(rmap_sub(a->t, b->t)) > 1e-9 * size;
}

static bool other_colour(const struct rmap_assembly_colour *a, const struct rmap_assembly_colour *b)
{
    bool other = a->given != b->given;
    for (int k = 0; k < 3; k++)
        other |= fabs(a->rgb[k] - b->rgb[k]) > 1e-3;
    return other;
}

static bool other_looks(const struct matching *m, int32_t from, int32_t to)
{
    const struct rmap_assembly_part *x = &m->before->part[from], *y = &m->after->part[to];
    bool other = other_colour(&x->colour, &y->colour) ||
                 strcmp(x->material ? x->material : "", y->material ? y->material : "") != 0;
    if (x->shape < 0 || y->shape < 0)
        return other;
    const struct rmap_assembly_shape *s = &m->before->shape[x->shape],
                                     *t = &m->after->shape[y->shape];
    for (size_t f = 0; !other && s->n_face == t->n_face && f < s->n_face; f++)
        other = other_colour(&s->face[f].colour, &t->face[f].colour) ||
                strcmp(s->face[f].material ? s->face[f].material : "",
                       t->face[f].material ? t->face[f].material : "") != 0;
    return other;
}

static unsigned change_of(const struct matching *m, int32_t from, int32_t to)
{
    const struct rmap_assembly_part *x = &m->before->part[from], *y = &m->after->part[to];
    const bool same_parent =
        x->parent < 0 ? y->parent < 0 : y->parent >= 0 && m->match->from[y->parent] == x->parent;
    unsigned change = 0;
    if (same_parent ? is_apart(&x->place, &y->place)
                    : is_apart(&m->world[0][from], &m->world[1][to]))
        change |= RMAP_PART_MOVED;
    if (x->shape >= 0 && !same_shape(m, from, to))
        change |= RMAP_PART_RESHAPED;
    if (!same_name(m, from, to))
        change |= RMAP_PART_RENAMED;
    if (other_looks(m, from, to))
        change |= RMAP_PART_RECOLOURED;
    return change;
}

/* ---- the whole ---- */

static enum rmap_status begin(struct matching *m, struct rmap_error *err)
{
    const size_t n[2] = {m->before->n_part, m->after->n_part};
    bool good = true;
    for (int side = 0; side < 2; side++) {
        m->key[side] = rmap_alloc(n[side], sizeof *m->key[side]);
        m->path[side] = rmap_alloc(n[side], sizeof *m->path[side]);
        m->world[side] = rmap_alloc(n[side], sizeof *m->world[side]);
        good &= m->key[side] && m->path[side] && m->world[side];
    }
    m->match->from = rmap_alloc(n[1], sizeof *m->match->from);
    m->match->change = rmap_alloc(n[1], sizeof *m->match->change);
    m->match->to = rmap_alloc(n[0], sizeof *m->match->to);
    m->match->kept = rmap_alloc(m->after->n_shape, sizeof *m->match->kept);
    if (!good || !m->match->from || !m->match->change || !m->match->to || !m->match->kept)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", n[0] + n[1]);
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < n[side]; i++) {
            const struct rmap_assembly_part *part = &side_of(m, side)->part[i];
            const struct {
                uint64_t above, name;
            } path = {part->parent < 0 ? 0 : m->path[side][part->parent], text_hash(part->name)};
            m->path[side][i] = XXH3_64bits(&path, sizeof path);
            m->world[side][i] =
                part->parent < 0 ? part->place
                                 : rmap_affine_compose(&m->world[side][part->parent], &part->place);
        }
    for (size_t i = 0; i < n[0]; i++)
        m->match->to[i] = -1;
    for (size_t i = 0; i < n[1]; i++)
        m->match->from[i] = -1;
    return RMAP_OK;
}

enum rmap_status rmap_assembly_match(const struct rmap_assembly *before,
                                     const struct rmap_assembly *after,
                                     struct rmap_assembly_match *match, struct rmap_error *err)
{
    struct matching m = {.before = before, .after = after, .match = match};
    const enum rmap_status st = begin(&m, err);
    if (st == RMAP_OK) {
        each_run(&m, id_of, join_by_id);
        each_run(&m, path_of, join_by_path);
        each_run(&m, shape_of, join_by_shape);
        each_run(&m, id_of, join_by_id_alone);
        for (size_t i = 0; i < after->n_part; i++)
            if (match->from[i] >= 0)
                match->change[i] = change_of(&m, match->from[i], (int32_t)i);
    }
    for (int side = 0; side < 2; side++) {
        rmap_free(m.key[side]);
        rmap_free(m.path[side]);
        rmap_free(m.world[side]);
    }
    return st;
}

void rmap_assembly_match_fini(struct rmap_assembly_match *match)
{
    rmap_free(match->from);
    rmap_free(match->change);
    rmap_free(match->to);
    rmap_free(match->kept);
    *match = (struct rmap_assembly_match){0};
}
