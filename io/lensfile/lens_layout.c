/* SPDX-License-Identifier: MIT
 *
 * Places, roles and sizes of a prescription's surfaces.
 */
#include "io/lensfile/lens_layout.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lensfile/lens_plain.h"
#include "io/lensfile/lens_text.h"

/* Frames that agree to this are one: as files write degrees and lengths. */
static const double same_frame = 1e-9;

static void set_places(struct rmap_lens_plan *plan)
{
    const struct rmap_prescription *lens = plan->lens;
    struct rmap_affine frame = rmap_affine_identity();
    bool backwards = false;
    for (size_t i = 1; i < lens->n_surface; i++) {
        const struct rmap_lens_surface *surface = &lens->surface[i];
        struct rmap_lens_place *place = &plan->place[i];
        frame = rmap_affine_compose(&frame, &surface->before);
        place->to_world = frame;
        place->backwards = backwards;
        frame = rmap_affine_compose(&frame, &surface->after);
        frame.t = rmap_affine_point(&frame, rmap_vec3(0, 0, surface->thickness));
        backwards ^= surface->is_mirror;
    }
}

static bool is_same_shape(const struct rmap_lens_surface *a, const struct rmap_lens_surface *b)
{
    return a->curvature == b->curvature && a->conic == b->conic && a->n_asphere == b->n_asphere &&
           memcmp(a->asphere, b->asphere, sizeof a->asphere) == 0 &&
           memcmp(&a->figure, &b->figure, sizeof a->figure) == 0;
}

static bool is_same_frame(const struct rmap_affine *a, const struct rmap_affine *b)
{
    const double scale = 1 + rmap_length(a->t);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (fabs(a->m[i][j] - b->m[i][j]) > same_frame)
                return false;
    return rmap_length(rmap_sub(a->t, b->t)) <= same_frame * scale;
}

/* A surface that light meets again after a mirror. 0: none. */
static size_t met_before(const struct rmap_lens_plan *plan, size_t i)
{
    bool mirror = false;
    for (size_t k = i; k-- > 1;) {
        const struct rmap_lens_surface *surface = &plan->lens->surface[k];
        const enum rmap_lens_role role = plan->place[k].role;
        if (mirror && (role == RMAP_ROLE_REFRACTS || role == RMAP_ROLE_MIRROR) &&
            surface->is_mirror == plan->lens->surface[i].is_mirror &&
            is_same_shape(surface, &plan->lens->surface[i]) &&
            is_same_frame(&plan->place[k].to_world, &plan->place[i].to_world))
            return k;
        mirror = mirror || surface->is_mirror;
    }
    return 0;
}

static void set_roles(struct rmap_lens_plan *plan)
{
    struct rmap_prescription *lens = plan->lens;
    const size_t *behind = plan->media.behind;
    for (size_t i = 1; i < lens->n_surface; i++) {
        struct rmap_lens_surface *surface = &lens->surface[i];
        struct rmap_lens_place *place = &plan->place[i];
        const bool opening =
            surface->aperture.shape || surface->obscuration.shape || surface->n_arm > 0;
        if (i + 1 == lens->n_surface)
            place->role = RMAP_ROLE_IMAGE;
        else if (surface->is_break)
            place->role = RMAP_ROLE_NOTHING;
        else if (surface->is_mirror)
            place->role = RMAP_ROLE_MIRROR;
        else if (behind[i] != behind[i - 1])
            place->role = RMAP_ROLE_REFRACTS;
        else if (surface->is_stop || opening)
            place->role = RMAP_ROLE_HOLE;
        const bool stands = place->role == RMAP_ROLE_MIRROR || place->role == RMAP_ROLE_REFRACTS;
        if (stands && (place->again = met_before(plan, i)) != 0)
            place->role = RMAP_ROLE_AGAIN;
        for (size_t k = 1; k < i && place->role == RMAP_ROLE_MIRROR && !place->spot; k++)
            if (plan->place[k].role == RMAP_ROLE_REFRACTS &&
                is_same_shape(&lens->surface[k], surface) &&
                is_same_frame(&plan->place[k].to_world, &place->to_world)) {
                place->spot = true;
                rmap_lens_remark(surface, "a mirror on surface %d", lens->surface[k].number);
            }
    }
}

bool rmap_lens_is_outline(const struct rmap_lens_opening *opening)
{
    return opening->shape == RMAP_OPENING_RECTANGLE || opening->shape == RMAP_OPENING_ELLIPSE ||
           (opening->shape && (opening->centre[0] != 0 || opening->centre[1] != 0));
}

/* Apertures that files give beside semi-diameters. */
static void set_openings(struct rmap_lens_plan *plan, size_t i)
{
    struct rmap_lens_surface *s = &plan->lens->surface[i];
    struct rmap_lens_place *place = &plan->place[i];
    const struct rmap_lens_opening *a = &s->aperture, *o = &s->obscuration;
    const bool mirror = place->role == RMAP_ROLE_MIRROR;
    if (rmap_lens_is_outline(a)) /* the circle about the vertex that holds it */
        place->semi = hypot(a->centre[0], a->centre[1]) + (a->shape == RMAP_OPENING_RECTANGLE
                                                               ? hypot(a->half[0], a->half[1])
                                                               : fmax(a->half[0], a->half[1]));
    else if (a->shape)
        place->semi = place->role == RMAP_ROLE_HOLE ? a->half[0] : fmin(place->semi, a->half[0]);
    place->computed = place->computed && !a->shape;
    if (mirror)
        place->hole = fmax(a->inner, rmap_lens_is_outline(o) ? 0 : o->half[0]);
    else if (a->inner > 0 && !o->shape) { /* a plate in its middle */
        s->obscuration = *a;
        s->obscuration.half[0] = s->obscuration.half[1] = a->inner;
        s->obscuration.inner = 0;
    }
    if (place->hole >= place->semi)
        place->hole = 0;
}

/* The way from surface i (0: from far before surface 1) to the next, where it crosses the plane of
 * a mirror: how far from the mirror's axis, and how wide light is there. False: it does not. */
static bool crosses(const struct rmap_lens_plan *plan, const struct rmap_affine *to_local, size_t i,
                    double *aside, double *radius)
{
    const struct rmap_vec3 end = plan->place[i + 1].to_world.t;
    const struct rmap_vec3 begin =
        i ? plan->place[i].to_world.t
          : rmap_vec3(end.x, end.y, -1e6 * plan->order.entrance_diameter);
    const struct rmap_vec3 a = rmap_affine_point(to_local, begin),
                           b = rmap_affine_point(to_local, end);
    const double t = a.z / (a.z - b.z);
    if (!(a.z * b.z < 0))
        return false;
    *aside = hypot(a.x * (1 - t) + b.x * t, a.y * (1 - t) + b.y * t);
    *radius = i ? plan->place[i].semi * (1 - t) + plan->place[i + 1].semi * t
                : 0.5 * plan->order.entrance_diameter;
    return true;
}

/* Light that goes through a mirror on its way, as it comes back in a Cassegrain telescope, goes
 * through a hole that files need not have; or is hidden by it, aside. */
static void set_holes(struct rmap_lens_plan *plan)
{
    const size_t n = plan->lens->n_surface;
    for (size_t m = 1; m < n; m++) {
        struct rmap_lens_place *mirror = &plan->place[m];
        struct rmap_lens_surface *surface = &plan->lens->surface[m];
        struct rmap_affine to_local;
        double aside = 0, radius = 0;
        bool told = false;
        if (mirror->role != RMAP_ROLE_MIRROR || mirror->hole > 0 ||
            !rmap_affine_invert(&mirror->to_world, &to_local))
            continue;
        for (size_t i = 0; i + 1 < n; i++) {
            if (i == m || i + 1 == m || (i == 0 && isfinite(plan->order.object)) ||
                !crosses(plan, &to_local, i, &aside, &radius) || !(radius > 0) ||
                aside > mirror->semi)
                continue;
            if (1.05 * radius < mirror->semi && aside < 0.01 * mirror->semi && i > m) {
                mirror->hole = fmax(mirror->hole, 1.05 * radius);
                rmap_lens_remark(surface,
                                 "the file has no hole in it: this one lets the light through that "
                                 "goes on to surface %zu",
                                 i + 1);
            } else if (aside >= 0.01 * mirror->semi && !told &&
                       !rmap_lens_is_outline(&surface->aperture)) {
                told = true;
                rmap_lens_lost(
                    plan->lens, surface->line, surface,
                    "the whole mirror stands there, in the way of the light that goes on "
                    "to surface %zu: give it the aperture that is used",
                    i + 1);
            }
        }
    }
}

static void set_image(struct rmap_lens_plan *plan)
{
    const size_t last = plan->lens->n_surface - 1;
    const double beam = 0.02 * plan->order.entrance_diameter;
    plan->image_half = fmax(1.2 * plan->place[last].semi, beam);
}

/* ---- what shapes and neighbours allow ---- */

static void limit(struct rmap_lens_plan *plan, size_t i, double semi, const char *why)
{
    struct rmap_lens_place *place = &plan->place[i];
    struct rmap_lens_surface *surface = &plan->lens->surface[i];
    const double rounded = 1 - 1e-5; /* what is computed is written with six digits */
    if (!(place->semi > semi))
        return;
    semi *= rounded;
    if (place->computed)
        rmap_lens_remark(surface, "as wide as %s", why);
    else
        rmap_lens_lost(plan->lens, surface->line, surface,
                       "its semi-diameter %.6g is more than %s: %.6g stands there", place->semi,
                       why, semi);
    place->semi = semi;
}

/* Whether b lies behind a all around at radius r. */
static bool is_behind(const struct rmap_shape *a, const struct rmap_shape *b, double gap, double r)
{
    enum { AROUND = 16 };
    for (int i = 0; i < AROUND; i++) {
        const double angle = 2 * RMAP_PI * i / AROUND, x = r * cos(angle), y = r * sin(angle);
        if (!(rmap_shape_height(a, x, y) <= gap + rmap_shape_height(b, x, y)))
            return false;
    }
    return true;
}

/* The largest radius up to r at which b lies behind a. */
static double apart(const struct rmap_shape *a, const struct rmap_shape *b, double gap, double r)
{
    double low = 0, high = r;
    if (is_behind(a, b, gap, r))
        return r;
    for (int i = 0; i < 60; i++) {
        const double middle = 0.5 * (low + high);
        if (is_behind(a, b, gap, middle))
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* How far b must go back to lie behind a all over radius r. */
static double overlap(const struct rmap_shape *a, const struct rmap_shape *b, double gap, double r)
{
    enum { AROUND = 16, INWARD = 16 };
    double most = 0;
    for (int i = 0; i < AROUND * (INWARD + 1); i++) {
        const double angle = 2 * RMAP_PI * (i % AROUND) / AROUND,
                     at = r * (double)(i / AROUND) / INWARD;
        const double x = at * cos(angle), y = at * sin(angle);
        most = fmax(most, rmap_shape_height(a, x, y) - rmap_shape_height(b, x, y) - gap);
    }
    return most;
}

static void fit_pair(struct rmap_lens_plan *plan, const struct rmap_element_row *a,
                     const struct rmap_element_row *b, double gap)
{
    struct rmap_lens_place *pa = &plan->place[a->surface], *pb = &plan->place[b->surface];
    const double r = fmin(pa->semi, pb->semi), enough = 1e-3;
    if (pa->role == RMAP_ROLE_HOLE || pb->role == RMAP_ROLE_HOLE ||
        rmap_lens_is_outline(&plan->lens->surface[a->surface].aperture) ||
        rmap_lens_is_outline(&plan->lens->surface[b->surface].aperture))
        return;
    struct rmap_shape sa = pa->shape, sb = pb->shape;
    sa.aperture = sa.type == RMAP_SHAPE_CONIC ? r : sa.aperture;
    sb.aperture = sb.type == RMAP_SHAPE_CONIC ? r : sb.aperture;
    const double most = apart(&sa, &sb, gap, r);
    if (most <= enough * r && r > 0) {
        plan->crossing.surface = a->surface < b->surface ? a->surface : b->surface;
        plan->crossing.by = overlap(&sa, &sb, gap, r);
    } else if (most < r) {
        limit(plan, a->surface, most, "the next surface allows");
        limit(plan, b->surface, most, "the surface before it allows");
    }
}

/* Between rims that are no circles about the axis, or on surfaces that are none of revolution, the
 * edge of a body is straight: both rims are alike. */
static void unite_rims(struct rmap_lens_plan *plan, const struct rmap_element_row *a,
                       const struct rmap_element_row *b, bool to_less)
{
    struct rmap_lens_surface *s[2] = {&plan->lens->surface[a->surface],
                                      &plan->lens->surface[b->surface]};
    struct rmap_lens_place *p[2] = {&plan->place[a->surface], &plan->place[b->surface]};
    const bool outline[2] = {rmap_lens_is_outline(&s[0]->aperture),
                             rmap_lens_is_outline(&s[1]->aperture)};
    if (outline[0] != outline[1]) {
        const int from = outline[1];
        s[!from]->aperture = s[from]->aperture;
        p[!from]->semi = p[from]->semi;
        rmap_lens_remark(s[!from], "its rim is that of surface %d, with which it makes a body",
                         s[from]->number);
    } else if (outline[0] && memcmp(&s[0]->aperture, &s[1]->aperture, sizeof s[0]->aperture) != 0) {
        rmap_lens_lost(
            plan->lens, s[1]->line, s[1],
            "its aperture is another than that of surface %d, with which it makes a body: "
            "that one stands there",
            s[0]->number);
        s[1]->aperture = s[0]->aperture;
        p[1]->semi = p[0]->semi;
    } else if (!outline[0] && p[0]->semi != p[1]->semi &&
               !(rmap_lens_is_revolved(s[0]) && rmap_lens_is_revolved(s[1]))) {
        const double most = fmax(p[0]->semi, p[1]->semi);
        const int from = to_less ? p[1]->semi < p[0]->semi
                         : p[1]->semi == most && most <= rmap_lens_reach(s[0]) ? 1
                         : p[0]->semi == most && most <= rmap_lens_reach(s[1])
                             ? 0
                             : p[1]->semi < p[0]->semi;
        p[!from]->semi = p[from]->semi;
        p[!from]->computed = p[from]->computed;
        rmap_lens_remark(s[!from], "its rim is that of surface %d, with which it makes a body",
                         s[from]->number);
    }
}

static void fit(struct rmap_lens_plan *plan)
{
    for (size_t e = 0; e < plan->n_element; e++) {
        const struct rmap_element_row *row = &plan->row[plan->element[e].first];
        for (size_t k = 0; plan->element[e].kind == RMAP_ELEMENT_LENS && k + 1 < plan->element[e].n;
             k++)
            if (row[k].medium != 0)
                unite_rims(plan, &row[k], &row[k + 1], false);
    }
    for (size_t i = 1; i < plan->lens->n_surface; i++)
        if ((plan->place[i].role == RMAP_ROLE_REFRACTS ||
             plan->place[i].role == RMAP_ROLE_MIRROR) &&
            !rmap_lens_is_outline(&plan->lens->surface[i].aperture))
            limit(plan, i, rmap_lens_reach(&plan->lens->surface[i]), "its sphere or conic reaches");
    for (size_t e = 0; e < plan->n_element; e++) {
        const struct rmap_lens_element *element = &plan->element[e];
        const struct rmap_element_row *row = &plan->row[element->first];
        if (element->kind == RMAP_ELEMENT_EDGE && !plan->crossing.surface)
            fit_pair(plan, row, row + element->n - 1, element->gap);
        for (size_t k = 0;
             element->kind == RMAP_ELEMENT_LENS && k + 1 < element->n && !plan->crossing.surface;
             k++)
            fit_pair(plan, &row[k], &row[k + 1], row[k + 1].z - row[k].z);
        for (size_t k = 0; plan->element[e].kind == RMAP_ELEMENT_LENS && k + 1 < plan->element[e].n;
             k++)
            if (row[k].medium != 0)
                unite_rims(plan, &row[k], &row[k + 1], true);
    }
}

static enum rmap_status make(struct rmap_prescription *lens, struct rmap_lens_plan *plan,
                             struct rmap_error *err)
{
    enum rmap_status st = rmap_lens_media_make(lens, &plan->media, err);
    if (st == RMAP_OK && rmap_lens_limit_light(lens, &plan->media)) {
        rmap_lens_media_fini(&plan->media); /* indices are at the primary wavelength */
        st = rmap_lens_media_make(lens, &plan->media, err);
    }
    if (st != RMAP_OK)
        return st;
    plan->place = rmap_alloc(lens->n_surface, sizeof *plan->place);
    plan->row = rmap_alloc(3 * lens->n_surface, sizeof *plan->row);
    plan->element = rmap_alloc(5 * lens->n_surface, sizeof *plan->element);
    if (!plan->place || !plan->row || !plan->element)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the places of a lens");
    set_places(plan);
    set_roles(plan);
    for (size_t i = 1; i < lens->n_surface; i++)
        plan->widest = fmax(plan->widest, lens->surface[i].semi);
    if (!(plan->widest > 0))
        plan->widest =
            lens->pupil == RMAP_PUPIL_DIAMETER && lens->pupil_value > 0 ? lens->pupil_value : 10;
    st = rmap_lens_shapes(plan, err);
    if (st != RMAP_OK)
        return st;
    rmap_lens_first_order(plan);
    rmap_lens_footprints(plan);
    for (size_t i = 1; i < lens->n_surface; i++) {
        set_openings(plan, i);
        struct rmap_lens_place *place = &plan->place[i];
        if (place->role == RMAP_ROLE_AGAIN)
            plan->place[place->again].semi = fmax(plan->place[place->again].semi, place->semi);
    }
    set_holes(plan);
    set_image(plan);
    rmap_lens_elements(plan);
    fit(plan);
    if (plan->n_element == 0)
        return rmap_error_set(err, RMAP_INPUT, "nothing in it refracts, mirrors or stops light");
    return RMAP_OK;
}

enum rmap_status rmap_lens_plan_make(struct rmap_prescription *lens, struct rmap_lens_plan *plan,
                                     struct rmap_error *err)
{
    enum { AGAIN_MAX = 64 };
    struct rmap_lens_kept kept = {.surface = NULL};
    *plan = (struct rmap_lens_plan){.lens = lens};
    enum rmap_status st = rmap_lens_keep(lens, &kept, err);
    if (st == RMAP_OK)
        st = make(lens, plan, err);
    for (int i = 0; i < AGAIN_MAX && st == RMAP_OK && plan->crossing.surface; i++) {
        const size_t at = plan->crossing.surface;
        const double by = plan->place[at].backwards != lens->surface[at].is_mirror
                              ? -plan->crossing.by
                              : plan->crossing.by;
        rmap_lens_plan_fini(plan);
        plan->lens = lens;
        rmap_lens_put_back(lens, &kept);
        struct rmap_lens_surface *s = &lens->surface[at];
        const double thickness = (s->thickness + by) * (1 + 1e-6);
        rmap_lens_lost(lens, s->line, s,
                       "with its thickness %.6g it and the next surface cross: %.6g stands there",
                       s->thickness, thickness);
        s->thickness = thickness;
        st = rmap_lens_keep(lens, &kept, err);
        if (st == RMAP_OK)
            st = make(lens, plan, err);
    }
    rmap_lens_kept_fini(&kept);
    return st;
}

void rmap_lens_plan_fini(struct rmap_lens_plan *plan)
{
    rmap_lens_media_fini(&plan->media);
    for (size_t i = 1; plan->place && i < plan->lens->n_surface; i++)
        rmap_free(plan->place[i].sag);
    rmap_free(plan->place);
    rmap_free(plan->row);
    rmap_free(plan->element);
    *plan = (struct rmap_lens_plan){0};
}
