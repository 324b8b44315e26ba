/* SPDX-License-Identifier: MIT
 *
 * Which surfaces make a lens: those in a row on one axis, without a mirror between them, that begin
 * and end in air (or at a mirror on glass). Others stand alone.
 */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "io/lensfile/lens_layout.h"
#include "io/lensfile/lens_text.h"

/* Surfaces [first, first + n) of `row`, in the order of light, that may become one lens. */
struct run {
    struct rmap_lens_plan *plan;
    size_t first, n;
    bool has_stop, refracts;
};

static bool is_coaxial(const struct rmap_affine *a, const struct rmap_affine *b, double *z)
{
    const double same = 1e-9;
    struct rmap_affine to_local;
    if (!rmap_affine_invert(a, &to_local))
        return false;
    const struct rmap_affine there = rmap_affine_compose(&to_local, b);
    double off = hypot(there.t.x, there.t.y) / (1 + fabs(there.t.z));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            off = fmax(off, fabs(there.m[i][j] - (i == j)));
    *z = there.t.z;
    return off <= same;
}

static struct rmap_lens_element *add_element(struct rmap_lens_plan *plan,
                                             enum rmap_lens_element_kind kind, size_t first,
                                             size_t n, const char *word)
{
    const struct rmap_element_row *row = &plan->row[first];
    const struct rmap_lens_surface *surface = &plan->lens->surface[row->surface];
    struct rmap_lens_element *element = &plan->element[plan->n_element];
    *element = (struct rmap_lens_element){
        .kind = kind, .first = first, .n = n, .to_world = plan->place[row->surface].to_world};
    (void)snprintf(element->name, sizeof element->name, "%s_%d", word, surface->number);
    /* A short comment of the file is a name; numbers keep it unique. */
    char name[sizeof element->name];
    size_t length = 0;
    for (const char *c = surface->comment; *c && length + 8 < sizeof name; c++)
        name[length++] = isalnum((unsigned char)*c) ? *c : '_';
    name[length] = 0;
    bool taken = length == 0 || length > 24 || !isalpha((unsigned char)name[0]) ||
                 kind == RMAP_ELEMENT_LENS || strcmp(name, "image") == 0 ||
                 strcmp(name, "sensor") == 0 || strncmp(name, "field_", 6) == 0;
    for (size_t i = 0; i < plan->n_element; i++)
        taken = taken || strcmp(plan->element[i].name, name) == 0;
    if (!taken)
        memcpy(element->name, name, sizeof name);
    plan->n_element++;
    return element;
}

/* Media before and behind a surface along its own z. */
static void media_of(const struct rmap_lens_plan *plan, size_t i, size_t *before, size_t *behind)
{
    const bool backwards = plan->place[i].backwards;
    const bool mirror = plan->lens->surface[i].is_mirror;
    const size_t arrives = plan->media.behind[i - 1], leaves = mirror ? 0 : plan->media.behind[i];
    *before = backwards ? leaves : arrives;
    *behind = backwards ? arrives : leaves;
}

static void add_alone(struct rmap_lens_plan *plan, size_t at)
{
    const size_t i = plan->row[at].surface;
    const enum rmap_lens_role role = plan->place[i].role;
    plan->row[at].z = 0;
    if (role == RMAP_ROLE_HOLE) {
        const struct rmap_lens_surface *s = &plan->lens->surface[i];
        if (s->is_stop || s->aperture.shape)
            (void)add_element(plan, RMAP_ELEMENT_PLATE, at, 1, s->is_stop ? "stop" : "aperture");
        return;
    }
    struct rmap_lens_element *element = add_element(
        plan, RMAP_ELEMENT_SURFACE, at, 1, role == RMAP_ROLE_MIRROR ? "mirror" : "surface");
    media_of(plan, i, &element->before, &plan->row[at].medium);
}

static void reverse(struct rmap_element_row *row, size_t n)
{
    for (size_t k = 0; k < n / 2; k++) {
        const struct rmap_element_row swap = row[k];
        row[k] = row[n - 1 - k];
        row[n - 1 - k] = swap;
    }
}

/* A body of glass with a mirror on its back that light comes back through, as a Mangin's, is bored:
 * its surfaces stand alone, with a hole each, and tubes between them close it. How many rows of the
 * run it has; 0: there is none. */
static size_t bored_rows(const struct run *run)
{
    const struct rmap_lens_plan *plan = run->plan;
    const struct rmap_element_row *row = &plan->row[run->first];
    const size_t last = run->n > 0 ? row[run->n - 1].surface : 0;
    size_t k = run->n;
    if (run->n < 2 || !plan->lens->surface[last].is_mirror || !(plan->place[last].hole > 0) ||
        plan->place[last].backwards)
        return 0;
    for (k--; k > 0 && plan->media.behind[row[k - 1].surface] != 0; k--)
        continue;
    return run->n - k;
}

/* Between the first and the last of n rows. */
static void add_tube(struct rmap_lens_plan *plan, enum rmap_lens_element_kind kind, size_t first,
                     size_t n)
{
    struct rmap_lens_element *tube =
        add_element(plan, kind, first, n, kind == RMAP_ELEMENT_BORE ? "bore" : "edge");
    (void)is_coaxial(&plan->place[plan->row[first].surface].to_world,
                     &plan->place[plan->row[first + n - 1].surface].to_world, &tube->gap);
}

static void add_bored(struct run *run)
{
    struct rmap_lens_plan *plan = run->plan;
    const size_t n = run->n, first = run->first;
    const double hole = plan->place[plan->row[first + n - 1].surface].hole;
    for (size_t k = 0; k < n; k++) {
        plan->place[plan->row[first + k].surface].hole = hole;
        add_alone(plan, first + k);
    }
    for (size_t k = 0; k + 1 < 2 * n - 1; k++)
        add_tube(plan, k % 2 ? RMAP_ELEMENT_BORE : RMAP_ELEMENT_EDGE, first + k / 2, 2);
}

/* Glass that goes on to the image, as an eye's: what stands alone has edges, so that no light gets
 * in beside it. */
static void add_edges(const struct run *run)
{
    struct rmap_lens_plan *plan = run->plan;
    size_t last = run->n; /* that refracts */
    for (size_t k = 0; k < run->n; k++) {
        const size_t i = plan->row[run->first + k].surface;
        const struct rmap_lens_surface *s = &plan->lens->surface[i];
        if (plan->place[i].role != RMAP_ROLE_REFRACTS)
            continue;
        if (!rmap_lens_is_revolved(s) || rmap_lens_is_outline(&s->aperture))
            return;
        if (last < k && plan->media.behind[plan->row[run->first + last].surface] != 0)
            add_tube(plan, RMAP_ELEMENT_EDGE, run->first + last, k - last + 1);
        last = k;
    }
}

/* Nothing that does anything stands between it and the image, and light goes along z. */
static bool is_before_image(const struct rmap_lens_plan *plan, size_t i)
{
    if (plan->place[i].backwards)
        return false;
    for (i++; i + 1 < plan->lens->n_surface; i++)
        if (plan->place[i].role != RMAP_ROLE_NOTHING)
            return false;
    return true;
}

static void end_run(struct run *run)
{
    struct rmap_lens_plan *plan = run->plan;
    const size_t n_bored = bored_rows(run);
    if (n_bored > 0) {
        run->n -= n_bored;
        for (size_t k = 0; k < run->n; k++)
            run->refracts |=
                plan->place[plan->row[run->first + k].surface].role == RMAP_ROLE_REFRACTS;
        end_run(run);
        run->n = n_bored;
        add_bored(run);
        run->first += n_bored;
        run->n = 0;
        run->has_stop = run->refracts = false;
        return;
    }
    struct rmap_element_row *row = &plan->row[run->first];
    const size_t n = run->n;
    if (n == 0)
        return;
    const size_t begin = row[0].surface, end = row[n - 1].surface;
    const bool from_air = plan->media.behind[begin - 1] == 0;
    const bool in_air =
        from_air && (plan->lens->surface[end].is_mirror || plan->media.behind[end] == 0);
    if (!run->refracts || !in_air) {
        for (size_t k = 0; k < n; k++)
            add_alone(plan, run->first + k);
        const bool to_image = run->refracts && from_air && is_before_image(plan, end);
        if (to_image)
            add_edges(run);
        for (size_t k = 0; run->refracts && !to_image && k < n; k++)
            rmap_lens_remark(&plan->lens->surface[row[k].surface],
                             "not closed to a body by its neighbours: it has no edge");
    } else {
        if (plan->place[begin].backwards)
            reverse(row, n);
        struct rmap_lens_element *element =
            add_element(plan, RMAP_ELEMENT_LENS, run->first, n, "lens");
        for (size_t k = 0; k < n; k++) {
            size_t before = 0;
            (void)is_coaxial(&element->to_world, &plan->place[row[k].surface].to_world, &row[k].z);
            media_of(plan, row[k].surface, &before, &row[k].medium);
            if (k == 0)
                element->before = before;
        }
    }
    run->first += n;
    run->n = 0;
    run->has_stop = run->refracts = false;
}

/* Whether surface i goes on with the run. */
static bool continues(const struct run *run, size_t i)
{
    const struct rmap_lens_plan *plan = run->plan;
    double z = 0;
    if (run->n == 0)
        return true;
    const size_t last = plan->row[run->first + run->n - 1].surface;
    const struct rmap_lens_place *a = &plan->place[last], *b = &plan->place[i];
    return a->backwards == b->backwards && is_coaxial(&a->to_world, &b->to_world, &z) &&
           (b->backwards ? z <= 0 : z >= 0);
}

static bool is_plain_stop(const struct rmap_lens_surface *s)
{
    return s->is_stop && s->curvature == 0 && s->n_asphere == 0 && s->figure.n_term == 0 &&
           !s->figure.is_biconic && !s->figure.is_toroid && !rmap_lens_is_outline(&s->aperture);
}

static void take(struct run *run, size_t i)
{
    struct rmap_lens_plan *plan = run->plan;
    const struct rmap_lens_surface *surface = &plan->lens->surface[i];
    const enum rmap_lens_role role = plan->place[i].role;
    const bool on_glass = plan->media.behind[i - 1] != 0;
    const bool alone = (role == RMAP_ROLE_HOLE && (run->has_stop || !is_plain_stop(surface))) ||
                       (role == RMAP_ROLE_MIRROR && !(on_glass && run->refracts));
    if (alone || !continues(run, i))
        end_run(run);
    plan->row[run->first + run->n] = (struct rmap_element_row){.surface = i};
    run->n++;
    if (alone) {
        add_alone(plan, run->first);
        run->first++;
        run->n = 0;
        return;
    }
    run->has_stop |= surface->is_stop;
    run->refracts |= role == RMAP_ROLE_REFRACTS;
    if (role == RMAP_ROLE_MIRROR)
        end_run(run);
}

/* What lies over surfaces: plates in the light's way and their holders. */
static void add_over(struct rmap_lens_plan *plan, size_t i)
{
    const struct rmap_lens_surface *s = &plan->lens->surface[i];
    const struct rmap_lens_place *place = &plan->place[i];
    const bool is_hole = place->role == RMAP_ROLE_MIRROR && !rmap_lens_is_outline(&s->obscuration);
    if (s->obscuration.shape && !is_hole) {
        plan->row[plan->n_row] = (struct rmap_element_row){.surface = i};
        (void)add_element(plan, RMAP_ELEMENT_OBSCURATION, plan->n_row++, 1, "obscuration");
    }
    if (s->n_arm > 0) {
        plan->row[plan->n_row] = (struct rmap_element_row){.surface = i};
        (void)add_element(plan, RMAP_ELEMENT_SPIDER, plan->n_row++, 1, "spider");
    }
}

void rmap_lens_elements(struct rmap_lens_plan *plan)
{
    struct run run = {.plan = plan};
    for (size_t i = 1; i + 1 < plan->lens->n_surface; i++)
        switch (plan->place[i].role) {
        case RMAP_ROLE_NOTHING:
        case RMAP_ROLE_IMAGE:
            break;
        case RMAP_ROLE_AGAIN:
            end_run(&run);
            break;
        case RMAP_ROLE_REFRACTS:
        case RMAP_ROLE_MIRROR:
        case RMAP_ROLE_HOLE:
            take(&run, i);
            break;
        }
    end_run(&run);
    plan->n_row = run.first;
    for (size_t i = 1; i + 1 < plan->lens->n_surface; i++)
        if (plan->place[i].role == RMAP_ROLE_REFRACTS || plan->place[i].role == RMAP_ROLE_MIRROR ||
            plan->place[i].role == RMAP_ROLE_HOLE)
            add_over(plan, i);
    struct rmap_lens_element *only = NULL;
    size_t n_lens = 0;
    for (size_t e = 0; e < plan->n_element; e++)
        if (plan->element[e].kind == RMAP_ELEMENT_LENS) {
            only = &plan->element[e];
            (void)snprintf(only->name, sizeof only->name, "lens_%zu", ++n_lens);
        }
    if (n_lens == 1)
        (void)snprintf(only->name, sizeof only->name, "lens");
}
