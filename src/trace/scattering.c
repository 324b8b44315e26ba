/* SPDX-License-Identifier: MIT
 *
 * Light at a surface that has a scatter model.
 */
#include "trace/scattering.h"

#include <math.h>

#include "base/portable.h"
#include "formula/emit.h"
#include "formula/turn.h"
#include "optics/fresnel.h"
#include "scatter/dust.h"
#include "trace/interact.h"

struct rmap_coat_shares rmap_smooth_shares(const struct rmap_scatter_side *side, double cos_i)
{
    const struct rmap_surface *surface = side->surface;
    struct rmap_coat_shares its = {.reflected = surface->reflect_specular[side->channel],
                                   .passed = surface->transmit_specular[side->channel]};
    if (surface->type == RMAP_SURFACE_FRESNEL && surface->coat == RMAP_COAT_FILM)
        return rmap_thin_film_coat(side->scene, side->object, side->front, side->channel, side->n1,
                                   side->n2, cos_i);
    if (surface->type == RMAP_SURFACE_FRESNEL) {
        its.reflected =
            rmap_coated_reflectance(surface, side->channel, side->n1, side->n2, cos_i, &its.total);
        its.passed = 1.0 - its.reflected;
    } else if (surface->is_metal) {
        const int i = side->channel;
        its.reflected = side->portable && surface->coat != RMAP_COAT_FILM
                            ? rmap_fresnel_metal_portable(side->n1, surface->metal_n[i],
                                                          surface->metal_k[i], cos_i)
                            : rmap_metal_coat(side->scene, surface, i, side->n1, cos_i);
    }
    return its;
}

static struct rmap_scattering local(const struct rmap_scatter_side *side, bool passes,
                                    struct rmap_vec3 in)
{
    return (struct rmap_scattering){.scatter =
                                        rmap_surface_scatter(side->scene, side->surface, passes),
                                    .channel = side->channel,
                                    .passes = passes,
                                    .front = side->front,
                                    .n1 = side->n1,
                                    .n2 = side->n2,
                                    .in = in};
}

static double sine_of(double cosine)
{
    return sqrt((1.0 - cosine) * (1.0 + cosine));
}

static double cosine_beyond(const struct rmap_scatter_side *side, double cos_i)
{
    const double sine = sine_of(cos_i) * side->n1 / side->n2;
    return sine < 1.0 ? sine_of(sine) : 0.0;
}

/* ---- lobes ---- */

/* The model beside it; NULL: none. */
static const struct rmap_scatter *another(const struct rmap_scatter_side *side,
                                          const struct rmap_scatter *its)
{
    return its->next > 0 ? &side->scene->scatter[its->next - 1] : NULL;
}

/* Particles lie on the side of a boundary that is around the object; on a mirror or a sheet, where
 * light comes from. */
static bool lie_beyond(const struct rmap_scatter_side *side)
{
    const int32_t own = side->front ? side->object->medium_front : side->object->medium_back;
    return side->surface->type == RMAP_SURFACE_FRESNEL && own != side->object->medium_outside;
}

/* What particles take out of light that crosses them so many times. */
static double crossed(const struct rmap_scatter_side *side, const struct rmap_scatter *particles,
                      double cos_1, double times)
{
    const double cosine = lie_beyond(side) ? cosine_beyond(side, cos_1) : cos_1;
    return rmap_portable_one_minus_exp(times * particles->shape[RMAP_SHAPE_EXTINCT][side->channel] /
                                       (cosine > 1e-9 ? cosine : 1e-9));
}

/* The same, of light that is reflected, or passes: twice on the way to a mirror and back. */
static double lost_to(const struct rmap_scatter_side *side, const struct rmap_scatter *particles,
                      double cos_1, bool passes)
{
    if (!passes && lie_beyond(side))
        return 0.0;
    return crossed(side, particles, cos_1, passes ? 1.0 : 2.0);
}

static double albedo(const struct rmap_scatter *particles, int channel)
{
    return particles->shape[RMAP_SHAPE_SCATTERED][channel] /
           particles->shape[RMAP_SHAPE_EXTINCT][channel];
}

/* What particles leave of the light that the other model scatters; a paint scatters what they send
 * on to it, too. */
static double uncrossed(const struct rmap_scatter_side *side, const struct rmap_scattering *at)
{
    const struct rmap_scatter *its = at->scatter;
    const double cosine = -at->in.z;
    while (its && its->model != RMAP_SCATTER_CONTAMINATION)
        its = another(side, its);
    if (!its)
        return 1.0;
    const double lost = lost_to(side, its, cosine, at->passes);
    return side->surface->type != RMAP_SURFACE_SCATTER
               ? 1.0 - lost
               : 1.0 - lost * (1.0 - albedo(its, at->channel) *
                                         rmap_dust_onward(its, at->channel, cosine));
}

/* Asks a model. Of particles: what they take of the light that is to pass, or to be reflected; what
 * they send back of it, and of light that the surface would have kept. A mirror keeps none. */
static void ask(const struct rmap_scatter_side *side, const struct rmap_scatter *model,
                const struct rmap_coat_shares *smooth, struct rmap_scattering *at)
{
    at->scatter = model;
    if (!model || model->model != RMAP_SCATTER_CONTAMINATION)
        return;
    const double cos_1 = -at->in.z;
    at->beyond = lie_beyond(side);
    at->ahead = at->back =
        (at->passes ? smooth->passed : smooth->reflected) * lost_to(side, model, cos_1, at->passes);
    if (at->passes || side->surface->type == RMAP_SURFACE_MIRROR)
        return;
    const double rest = at->beyond ? smooth->passed : 1.0 - smooth->reflected;
    at->back += rest * crossed(side, model, cos_1, 1.0);
}

/* What a lobe takes of the arriving light, where `smooth` would be reflected, and pass. */
static double lobe_share(const struct rmap_scatter_side *side, const struct rmap_scattering *at,
                         const struct rmap_coat_shares *smooth, double total)
{
    const double whole = at->passes ? smooth->passed : smooth->reflected;
    if (at->scatter->model == RMAP_SCATTER_CONTAMINATION)
        return total * at->scatter->shape[RMAP_SHAPE_SCATTERED][at->channel] /
               at->scatter->shape[RMAP_SHAPE_EXTINCT][at->channel];
    const double cos_1 = -at->in.z,
                 roughness = at->scatter->shape[RMAP_SHAPE_ROUGHNESS][at->channel];
    double share = at->scatter->amount[at->channel] * total;
    if (at->scatter->by_roughness) {
        const double cos_2 = cosine_beyond(side, cos_1), n1 = at->n1, n2 = at->n2;
        const double step = n1 * cos_1 - n2 * cos_2;
        if (at->scatter->model == RMAP_SCATTER_HARVEY)
            share = whole * rmap_rough_share(roughness, at->passes, n1, cos_1, n2, cos_2);
        else if (at->passes)
            share *= whole * 0.25 * step * step * n2 * n2;
        else
            share *= whole * n1 * n1 * n1 * n1 * cos_1;
    }
    const bool of_it =
        at->scatter->by_roughness || side->surface->type != RMAP_SURFACE_SCATTER ||
        (at->passes ? side->surface->transmit_is_total : side->surface->reflect_is_total);
    share = of_it && share > whole ? whole : share;
    return share * uncrossed(side, at);
}

static double lobe_total(const struct rmap_scatter_side *side, const struct rmap_scattering *at)
{
    return rmap_scatter_total(at, side->near, side->far);
}

/* Of what is reflected, or passes: what is scattered, and what is left. */
static void lobe_shares_of(const struct rmap_scatter_side *side, struct rmap_vec3 in, bool passes,
                           const struct rmap_coat_shares *smooth, double *diffuse, double *specular)
{
    const bool of_it =
        side->surface->type != RMAP_SURFACE_SCATTER ||
        (passes ? side->surface->transmit_is_total : side->surface->reflect_is_total);
    struct rmap_scattering at = local(side, passes, in);
    *specular = passes ? smooth->passed : smooth->reflected;
    *diffuse = 0.0;
    for (const struct rmap_scatter *its = at.scatter; its; its = another(side, its)) {
        ask(side, its, smooth, &at);
        const double share = lobe_share(side, &at, smooth, lobe_total(side, &at));
        *diffuse += share;
        if (its->model == RMAP_SCATTER_CONTAMINATION)
            *specular -= at.ahead;
        else if (of_it)
            *specular -= share;
    }
    *specular = *specular > 0.0 ? *specular : 0.0;
}

static struct rmap_surface_shares lobe_shares(const struct rmap_scatter_side *side,
                                              struct rmap_vec3 in)
{
    const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -in.z);
    struct rmap_surface_shares its = {.missing = 0.0};
    lobe_shares_of(side, in, false, &smooth, &its.reflect_diffuse, &its.reflect_specular);
    lobe_shares_of(side, in, true, &smooth, &its.transmit_diffuse, &its.transmit_specular);
    return its;
}

/* ---- facets ---- */

static void shares_at_facet(const void *self, double cosine, double share[2])
{
    const struct rmap_coat_shares its = rmap_smooth_shares(self, cosine);
    share[0] = its.reflected;
    share[1] = its.passed;
}

static const double *shape_of(const struct rmap_scattering *at, int k)
{
    return &at->scatter->shape[k][at->channel];
}

static double spike_of(const struct rmap_scattering *at)
{
    return at->scatter->model == RMAP_SCATTER_UNIFIED ? *shape_of(at, RMAP_SHAPE_SPIKE) : 0.0;
}

static struct rmap_surface_shares facet_shares(const struct rmap_scatter_side *side,
                                               struct rmap_vec3 in)
{
    struct rmap_surface_shares its = {.reflect_specular = 0.0};
    const struct rmap_scattering at = local(side, false, in);
    const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -in.z);
    const double spike = spike_of(&at);
    const double lobe =
        at.scatter->model == RMAP_SCATTER_UNIFIED ? *shape_of(&at, RMAP_SHAPE_LOBE) : 1.0;
    double total[3];
    rmap_facet_total(&at, shares_at_facet, side, total);
    const double other = 1.0 - spike - lobe; /* back and Lambert */
    its.reflect_specular = spike * smooth.reflected;
    its.transmit_specular = spike * smooth.passed;
    its.reflect_diffuse = lobe * total[0] + other * smooth.reflected;
    its.transmit_diffuse = lobe * total[1] + other * smooth.passed;
    its.missing = lobe * total[2];
    return its;
}

void rmap_facet_meet(const struct rmap_scatter_side *side, struct rmap_vec3 direction,
                     const struct rmap_draw *draw, struct rmap_facet *facet)
{
    const double cosine = rmap_dot(direction, side->normal);
    struct rmap_vec3 in = {rmap_dot(direction, side->x), rmap_dot(direction, side->y),
                           cosine < 0.0 ? cosine : 0.0};
    const struct rmap_scattering at = local(side, false, in);
    double u[4];
    *facet = (struct rmap_facet){.part = RMAP_PART_LOBE, .in = in};
    if (at.scatter->model == RMAP_SCATTER_UNIFIED) {
        const double spike = *shape_of(&at, RMAP_SHAPE_SPIKE),
                     lobe = spike + *shape_of(&at, RMAP_SHAPE_LOBE);
        rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_LOBE, u);
        facet->part = u[0] < spike                                    ? RMAP_PART_SPIKE
                      : u[0] < lobe                                   ? RMAP_PART_LOBE
                      : u[0] < lobe + *shape_of(&at, RMAP_SHAPE_BACK) ? RMAP_PART_BACK
                                                                      : RMAP_PART_LAMBERT;
    }
    facet->normal =
        facet->part == RMAP_PART_SPIKE ? rmap_vec3(0.0, 0.0, 1.0) : rmap_facet_draw(&at, draw);
    facet->cos_i = facet->part == RMAP_PART_LOBE ? -rmap_dot(in, facet->normal) : -in.z;
    facet->cos_i = facet->cos_i < 0.0 ? 0.0 : facet->cos_i < 1.0 ? facet->cos_i : 1.0;
}

static struct rmap_vec3 to_world(const struct rmap_scatter_side *side, struct rmap_vec3 v)
{
    return rmap_in_frame(v, side->x, side->y, side->normal);
}

double rmap_facet_leave(const struct rmap_scatter_side *side, const struct rmap_facet *facet,
                        bool passes, const struct rmap_draw *draw, struct rmap_vec3 *out)
{
    const struct rmap_scattering at = local(side, passes, facet->in);
    struct rmap_vec3 to = rmap_scale(facet->in, -1.0);
    double u[4];
    if (passes && !rmap_facet_refracted(&at, facet->normal, &to))
        return 0.0;
    if (!passes && facet->part == RMAP_PART_LAMBERT) {
        rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_LOBE, u);
        *out = rmap_diffused(side->normal, u[2], u[3]);
        return 1.0;
    }
    if (!passes && facet->part != RMAP_PART_BACK)
        to = rmap_facet_reflected(facet->in, facet->normal);
    if (passes ? !(to.z < 0.0) : !(to.z > 0.0))
        return 0.0;
    *out = to_world(side, to);
    return facet->part == RMAP_PART_BACK ? 1.0 : rmap_facet_unhindered(&at, to);
}

/* ---- both ---- */

static bool is_of_facets(const struct rmap_scatter_side *side)
{
    const struct rmap_scatter *its = rmap_surface_scatter(side->scene, side->surface, false);
    return its && rmap_scatter_is_facets(its);
}

struct rmap_surface_shares rmap_scatter_shares(const struct rmap_scatter_side *side,
                                               struct rmap_vec3 in)
{
    return is_of_facets(side) ? facet_shares(side, in) : lobe_shares(side, in);
}

double rmap_scatter_reflectance(const struct rmap_scatter_side *side, struct rmap_vec3 in)
{
    if (!is_of_facets(side))
        return lobe_shares(side, in).reflect_specular;
    const struct rmap_scattering at = local(side, false, in);
    return spike_of(&at) * rmap_smooth_shares(side, -in.z).reflected;
}

bool rmap_scatter_by_facet(const struct rmap_scatter_side *side)
{
    return (side->surface->is_metal || side->surface->type == RMAP_SURFACE_FRESNEL) &&
           is_of_facets(side);
}

bool rmap_scatter_shares_follow(const struct rmap_scatter_side *side, bool passes)
{
    const struct rmap_surface *surface = side->surface;
    const bool bare_metal = surface->is_metal && surface->coat != RMAP_COAT_FILM;
    if (!side->portable && (bare_metal || rmap_scatter_by_facet(side)))
        return false;
    for (const struct rmap_scatter *its = rmap_surface_scatter(side->scene, surface, passes); its;
         its = another(side, its))
        if (rmap_scatter_is_table(its) ||
            (its->model == RMAP_SCATTER_CONTAMINATION && lie_beyond(side)))
            return false;
    return true;
}

/* In the object's frame; 0 where there is none. */
static struct rmap_vec3 along_u(const struct rmap_scatter_side *side)
{
    const struct rmap_geometry *geometry = &side->scene->geometry[side->object->geometry];
    if (geometry->kind == RMAP_GEOMETRY_MESH) {
        const struct rmap_mesh *mesh = geometry->mesh;
        if (!mesh->tangent || side->primitive < 0 || (size_t)side->primitive >= mesh->n_triangle)
            return rmap_vec3(0.0, 0.0, 0.0);
        const float *u = mesh->tangent[side->primitive];
        return rmap_vec3((double)u[0], (double)u[1], (double)u[2]);
    }
    if (!rmap_shape_model[geometry->shape.type].revolved)
        return rmap_vec3(1.0, 0.0, 0.0);
    const struct rmap_vec3 at = rmap_affine_point(&side->object->to_local, side->position);
    return rmap_vec3(-at.y, at.x, 0.0);
}

void rmap_scatter_frame(struct rmap_scatter_side *side)
{
    bool matters = false;
    for (int way = 0; way < 2; way++) {
        const struct rmap_scatter *its = rmap_surface_scatter(side->scene, side->surface, way == 1);
        matters = matters || (its && rmap_scatter_is_anisotropic(its, side->scene->channels.n));
    }
    if (!matters) {
        rmap_basis(side->normal, &side->x, &side->y);
        return;
    }
    const struct rmap_vec3 axis[3] = {side->surface->frame_uv ? along_u(side)
                                                              : rmap_vec3(0.0, 0.0, 0.0),
                                      rmap_vec3(1.0, 0.0, 0.0), rmap_vec3(0.0, 1.0, 0.0)};
    for (int k = side->surface->frame_uv ? 0 : 1; k < 3; k++) {
        const struct rmap_vec3 along =
            rmap_normalize(rmap_affine_vector(&side->object->to_world, axis[k]));
        side->x = rmap_axpy(-rmap_dot(along, side->normal), side->normal, along);
        if (rmap_dot(side->x, side->x) > 1e-6)
            break;
    }
    side->x = rmap_normalize(side->x);
    side->y = rmap_cross(side->front ? side->normal : rmap_scale(side->normal, -1.0), side->x);
}

bool rmap_scatter_by_channel(const struct rmap_scatter_side *side, const struct rmap_scatter *its)
{
    const struct rmap_medium *medium = side->scene->medium;
    if (its->next > 0 && rmap_scatter_by_channel(side, another(side, its)))
        return true;
    return its->by_wavelength || (rmap_scatter_uses_index(its) &&
                                  (medium[side->near].dispersive || medium[side->far].dispersive));
}

/* One of the models of the same light, by their shares. */
static void pick(const struct rmap_scatter_side *side, const struct rmap_draw *draw,
                 struct rmap_scattering *at)
{
    const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -at->in.z);
    const struct rmap_scatter *first = at->scatter, *second = another(side, first);
    double u[4];
    ask(side, first, &smooth, at);
    if (!second)
        return;
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_SURFACE, u);
    const double one = lobe_share(side, at, &smooth, lobe_total(side, at));
    ask(side, second, &smooth, at);
    const double other = lobe_share(side, at, &smooth, lobe_total(side, at));
    if (u[3] * (one + other) < one)
        ask(side, first, &smooth, at);
}

/* At the model that scatters light which travels along `direction`. */
static struct rmap_scattering picked(const struct rmap_scatter_side *side, bool passes,
                                     struct rmap_vec3 direction, const struct rmap_draw *draw)
{
    const double cosine = rmap_dot(direction, side->normal);
    struct rmap_scattering at =
        local(side, passes,
              rmap_vec3(rmap_dot(direction, side->x), rmap_dot(direction, side->y),
                        cosine < 0.0 ? cosine : 0.0));
    if (at.scatter && (at.scatter->next > 0 || at.scatter->model == RMAP_SCATTER_CONTAMINATION))
        pick(side, draw, &at);
    return at;
}

const struct rmap_scatter *rmap_scatter_picked(const struct rmap_scatter_side *side, bool passes,
                                               struct rmap_vec3 direction,
                                               const struct rmap_draw *draw)
{
    return picked(side, passes, direction, draw).scatter;
}

struct rmap_vec3 rmap_scatter_turned(const struct rmap_scatter_side *side, bool passes,
                                     struct rmap_vec3 direction, const struct rmap_draw *draw)
{
    if (is_of_facets(side)) {
        struct rmap_facet facet;
        struct rmap_vec3 out = direction;
        rmap_facet_meet(side, direction, draw, &facet);
        (void)rmap_facet_leave(side, &facet, passes, draw, &out);
        return out;
    }
    const struct rmap_scattering at = picked(side, passes, direction, draw);
    return at.scatter ? to_world(side, rmap_lobe_draw(&at, draw)) : direction;
}

static double facet_bsdf(const struct rmap_scatter_side *side, struct rmap_scattering *at,
                         struct rmap_vec3 to)
{
    double cosine, sum;
    const bool is_unified = at->scatter->model == RMAP_SCATTER_UNIFIED;
    if (is_unified)
        at->total = lobe_total(side, at);
    const double f = rmap_facet_bsdf(at, to, &cosine);
    const struct rmap_coat_shares there = rmap_smooth_shares(side, cosine);
    sum = f > 0.0 ? f * (at->passes ? there.passed : there.reflected) : 0.0;
    if (!is_unified)
        return sum;
    const double lobe = *shape_of(at, RMAP_SHAPE_LOBE),
                 other = 1.0 - lobe - *shape_of(at, RMAP_SHAPE_SPIKE);
    const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -at->in.z);
    return at->passes
               ? lobe * sum + other * f * smooth.passed
               : lobe * sum + (other - *shape_of(at, RMAP_SHAPE_BACK)) * smooth.reflected / RMAP_PI;
}

double rmap_scatter_bsdf(const struct rmap_scatter_side *side, struct rmap_vec3 in,
                         struct rmap_vec3 out)
{
    const struct rmap_vec3 from = {rmap_dot(in, side->x), rmap_dot(in, side->y),
                                   rmap_dot(in, side->normal)},
                           to = {rmap_dot(out, side->x), rmap_dot(out, side->y),
                                 rmap_dot(out, side->normal)};
    struct rmap_scattering at = local(side, to.z < 0.0, from);
    if (!at.scatter || !(from.z < 0.0))
        return 0.0;
    if (rmap_scatter_is_facets(at.scatter))
        return facet_bsdf(side, &at, to);
    const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -from.z);
    double sum = 0.0;
    for (const struct rmap_scatter *its = at.scatter; its; its = another(side, its)) {
        ask(side, its, &smooth, &at);
        const double total = lobe_total(side, &at), share = lobe_share(side, &at, &smooth, total);
        sum += share > 0.0 ? share / total * rmap_lobe_shape(&at, to) : 0.0;
    }
    return sum;
}
