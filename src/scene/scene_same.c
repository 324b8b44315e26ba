/* SPDX-License-Identifier: MIT
 *
 * Whether parts of two scenes are alike for every ray.
 */
#include "scene/scene_same.h"

#include <string.h>

#include "geometry/sag.h"

static bool same_bytes(const void *a, const void *b, size_t nbytes)
{
    return nbytes == 0 || (a && b ? memcmp(a, b, nbytes) == 0 : a == b);
}

/* Both are there, or neither is. */
static bool same_optional(const void *a, const void *b, size_t nbytes)
{
    return !a == !b && (!a || same_bytes(a, b, nbytes));
}

#define SAME(member)    (a->member == b->member)
#define SAME_OF(member) same_bytes(&a->member, &b->member, sizeof a->member)

static size_t channels_nbytes(const struct rmap_scene_pair *pair)
{
    return (size_t)pair->old->channels.n * sizeof(double);
}

static bool same_profile(const struct rmap_profile *a, const struct rmap_profile *b)
{
    return SAME(n) && same_bytes(a->knot, b->knot, a->n * sizeof *a->knot);
}

bool rmap_same_medium_number(const struct rmap_scene_pair *pair, int32_t old, int32_t new)
{
    return old < 0 ? old == new : pair->medium[old] == new;
}

static bool same_phase(const struct rmap_phase *a, const struct rmap_phase *b)
{
    bool same = SAME(kind) && SAME(n_profile);
    for (size_t i = 0; same && a->profile && i < a->n_profile; i++)
        same = same_profile(&a->profile[i], &b->profile[i]);
    return same;
}

static bool same_species(const struct rmap_species *a, const struct rmap_species *b, size_t nbytes)
{
    const size_t n_decay = a->lifetime.n * sizeof(double);
    return same_bytes(a->absorption, b->absorption, nbytes) &&
           same_bytes(a->yield, b->yield, nbytes) && same_bytes(a->below, b->below, nbytes) &&
           SAME(redshift) && SAME(lifetime.n) &&
           same_bytes(a->lifetime.time_ns, b->lifetime.time_ns, n_decay) &&
           same_bytes(a->lifetime.below, b->lifetime.below, n_decay);
}

bool rmap_same_medium(const struct rmap_scene_pair *pair, int32_t old, int32_t new)
{
    const struct rmap_medium *a = &pair->old->medium[old], *b = &pair->new->medium[new];
    const size_t nbytes = channels_nbytes(pair);
    bool same = !a->field && !b->field && same_bytes(a->n, b->n, nbytes) &&
                same_bytes(a->n_group, b->n_group, nbytes) &&
                same_bytes(a->absorption, b->absorption, nbytes) &&
                same_bytes(a->scattering, b->scattering, nbytes) && SAME(dispersive) &&
                SAME(absorbing) && SAME(scattering_at_all) && SAME_OF(scattering_g) &&
                same_phase(&a->phase, &b->phase) && SAME(n_species);
    for (size_t i = 0; same && i < a->n_species; i++)
        same = same_species(&a->species[i], &b->species[i], nbytes);
    return same;
}

static bool same_film(const struct rmap_scene_pair *pair, const struct rmap_thin_film *a,
                      const struct rmap_thin_film *b)
{
    const size_t n_channel = (size_t)pair->old->channels.n;
    return SAME(substrate) && SAME(n_layer) && SAME(n_angle) &&
           same_bytes(a->layer, b->layer, n_channel * a->n_layer * sizeof *a->layer) &&
           same_bytes(a->angle, b->angle, a->n_angle * sizeof *a->angle) &&
           same_bytes(a->share, b->share, n_channel * a->n_angle * 2 * sizeof *a->share);
}

static bool same_totals(const struct rmap_scene_pair *pair, const struct rmap_scatter_totals *a,
                        const struct rmap_scatter_totals *b, bool refracts)
{
    const size_t n = (refracts ? 2 : 1) * (size_t)a->n_channel * (RMAP_TOTAL_STEPS + 1);
    return rmap_same_medium_number(pair, a->near, b->near) &&
           rmap_same_medium_number(pair, a->far, b->far) && SAME(n_channel) &&
           same_bytes(a->at, b->at, n * sizeof *a->at);
}

/* Measured tables and particles are not compared. */
static bool same_model(const struct rmap_scene_pair *pair, const struct rmap_scatter *a,
                       const struct rmap_scatter *b)
{
    const size_t nbytes = channels_nbytes(pair);
    bool same = SAME(model) && SAME(refracts) && SAME(by_wavelength) && SAME(by_roughness) &&
                SAME(n_totals) && !a->table && !b->table && !a->dust && !b->dust &&
                same_bytes(a->amount, b->amount, nbytes);
    for (int k = 0; same && k < RMAP_SHAPE_MAX; k++)
        same = same_bytes(a->shape[k], b->shape[k], nbytes);
    for (size_t k = 0; same && k < a->n_totals; k++)
        same = same_totals(pair, &a->totals[k], &b->totals[k], a->refracts);
    return same;
}

/* Models of the same light, one after the other; rows from 1. */
static bool same_models(const struct rmap_scene_pair *pair, int32_t old, int32_t new)
{
    while (old > 0 && new > 0) {
        const struct rmap_scatter *a = &pair->old->scatter[old - 1],
                                  *b = &pair->new->scatter[new - 1];
        if (!same_model(pair, a, b))
            return false;
        old = a->next;
        new = b->next;
    }
    return old <= 0 && new <= 0;
}

bool rmap_same_surface(const struct rmap_scene_pair *pair, int32_t old, int32_t new)
{
    const struct rmap_surface *a = &pair->old->surface[old], *b = &pair->new->surface[new];
    const size_t nbytes = channels_nbytes(pair);
    return SAME(type) && SAME(coat) && SAME(is_metal) && SAME(frame_uv) && SAME(reflect_is_total) &&
           SAME(transmit_is_total) &&
           same_bytes(a->reflect_specular, b->reflect_specular, nbytes) &&
           same_bytes(a->reflect_diffuse, b->reflect_diffuse, nbytes) &&
           same_bytes(a->transmit_specular, b->transmit_specular, nbytes) &&
           same_bytes(a->transmit_diffuse, b->transmit_diffuse, nbytes) &&
           same_bytes(a->metal_n, b->metal_n, nbytes) &&
           same_bytes(a->metal_k, b->metal_k, nbytes) &&
           (a->coat != RMAP_COAT_FILM ||
            same_film(pair, &pair->old->film[a->film], &pair->new->film[b->film])) &&
           same_models(pair, a->scatter_reflect, b->scatter_reflect) &&
           same_models(pair, a->scatter_transmit, b->scatter_transmit);
}

static bool same_sag(const struct rmap_sag *a, const struct rmap_sag *b)
{
    return SAME(base) && SAME_OF(curvature) && SAME_OF(conic) && SAME_OF(power) && SAME(n_power) &&
           SAME_OF(xy_norm) && SAME_OF(xy) && SAME(n_xy) && SAME_OF(zernike_norm) &&
           SAME_OF(zernike) && SAME(n_zernike) && SAME_OF(qcon_norm) && SAME_OF(qcon) &&
           SAME(n_qcon) && SAME_OF(qbfs_norm) && SAME_OF(qbfs) && SAME(n_qbfs) && SAME(fresnel);
}

static bool same_sags(const struct rmap_shape *a, const struct rmap_shape *b)
{
    bool same = rmap_aperture_same(&a->outline, &b->outline) && SAME(outline.inner);
    for (int i = 0; same && i < 2; i++)
        same = a->sag[i] && b->sag[i] ? same_sag(a->sag[i], b->sag[i]) : a->sag[i] == b->sag[i];
    return same;
}

static bool same_shape(const struct rmap_shape *a, const struct rmap_shape *b)
{
    return same_sags(a, b) && SAME(type) && SAME_OF(curvature) && SAME_OF(conic) &&
           SAME_OF(asphere) && SAME(n_asphere) && SAME_OF(aperture) && SAME_OF(inner) &&
           SAME_OF(size) && SAME_OF(radius) && SAME_OF(radius2) && SAME_OF(length);
}

static bool same_surfaces(const struct rmap_mesh *a, const struct rmap_mesh *b, size_t n_face)
{
    bool same = !a->surface == !b->surface;
    for (size_t i = 0; same && a->surface && i < n_face; i++)
        same = rmap_true_same(&a->surface[i], &b->surface[i]);
    return same;
}

/* Of parts with what lies beyond them. */
bool rmap_same_mesh(const struct rmap_mesh *part_a, const struct rmap_mesh *part_b)
{
    const struct rmap_mesh whole_a = rmap_mesh_with_beyond(part_a),
                           whole_b = rmap_mesh_with_beyond(part_b);
    const struct rmap_mesh *a = &whole_a, *b = &whole_b;
    return part_a == part_b ||
           (part_a->n_triangle == part_b->n_triangle && SAME(n_vertex) && SAME(n_triangle) &&
            SAME(n_face) && same_surfaces(a, b, a->n_face) &&
            same_bytes(a->vertex, b->vertex, a->n_vertex * sizeof *a->vertex) &&
            same_bytes(a->triangle, b->triangle, a->n_triangle * sizeof *a->triangle) &&
            same_bytes(a->face, b->face, a->n_triangle * sizeof *a->face) &&
            same_optional(a->tangent, b->tangent, part_a->n_triangle * sizeof *a->tangent));
}

bool rmap_same_geometry(const struct rmap_scene_pair *pair, int32_t old, int32_t new)
{
    const struct rmap_geometry *a = &pair->old->geometry[old], *b = &pair->new->geometry[new];
    return SAME(kind) && (a->kind == RMAP_GEOMETRY_SHAPE ? same_shape(&a->shape, &b->shape)
                                                         : rmap_same_mesh(a->mesh, b->mesh));
}

static bool same_lamp(const struct rmap_lamp *a, const struct rmap_lamp *b)
{
    if (!a || !b)
        return a == b;
    return same_profile(&a->mean, &b->mean) && SAME(n_around) && SAME(body) && SAME(along) &&
           SAME_OF(axis) && SAME_OF(size) && SAME_OF(side) &&
           same_bytes(a->turn, b->turn, a->n_around * sizeof *a->turn) &&
           same_bytes(a->intensity, b->intensity, a->mean.n * a->n_around * sizeof *a->intensity) &&
           same_bytes(a->below, b->below, a->mean.n * (a->n_around + 1) * sizeof *a->below);
}

static bool same_sky(const struct rmap_sky *a, const struct rmap_sky *b)
{
    if (!a || !b)
        return a == b;
    const size_t n = a->n_row * a->n_around;
    return SAME(n_row) && SAME(n_around) && SAME(n_portal) && SAME_OF(mix) &&
           same_bytes(a->edge, b->edge, (a->n_row + 1) * sizeof *a->edge) &&
           same_bytes(a->radiance, b->radiance, n * sizeof *a->radiance) &&
           same_optional(a->band, b->band, n * sizeof *a->band) &&
           same_bytes(a->below, b->below, n * sizeof *a->below) &&
           same_bytes(a->portal, b->portal, a->n_portal * sizeof *a->portal);
}

static bool same_file_rays(const struct rmap_file_rays *a, const struct rmap_file_rays *b)
{
    if (!a || !b)
        return a == b;
    return SAME(n) && SAME_OF(loose) && SAME_OF(all_nm) &&
           same_optional(a->narrow, b->narrow, a->n * sizeof *a->narrow) &&
           same_optional(a->wide, b->wide, a->n * sizeof *a->wide) &&
           same_optional(a->below, b->below, a->n * sizeof *a->below) &&
           same_optional(a->wavelength_nm, b->wavelength_nm, a->n * sizeof *a->wavelength_nm) &&
           same_optional(a->delay_ns, b->delay_ns, a->n * sizeof *a->delay_ns) &&
           same_optional(a->event, b->event, a->n * sizeof *a->event);
}

static bool same_list(const struct rmap_source *a, const struct rmap_source *b)
{
    bool same = SAME(n_list);
    for (size_t i = 0; same && i < a->n_list; i++)
        same =
            same_bytes(&a->list[i].origin, &b->list[i].origin, sizeof a->list[i].origin) &&
            same_bytes(&a->list[i].direction, &b->list[i].direction, sizeof a->list[i].direction) &&
            SAME(list[i].channel) && SAME(list[i].delay_ns);
    return same;
}

bool rmap_source_is_compared(const struct rmap_source *source)
{
    return !source->volume && !source->steps;
}

bool rmap_same_source(const struct rmap_scene_pair *pair, size_t old, size_t new)
{
    const struct rmap_source *a = &pair->old->source[old], *b = &pair->new->source[new];
    return rmap_source_is_compared(a) && rmap_source_is_compared(b) && SAME(type) && SAME(shape) &&
           SAME_OF(shape_size) && SAME_OF(frame) && SAME(distribution) && SAME_OF(cone_rad) &&
           SAME_OF(cosine_power) && SAME_OF(aperture) &&
           same_bytes(a->colour, b->colour, channels_nbytes(pair)) &&
           rmap_same_medium_number(pair, a->medium, b->medium) &&
           (a->shape != RMAP_EMITTER_MESH ||
            rmap_same_geometry(pair, a->shape_geometry, b->shape_geometry)) &&
           same_profile(&a->profile, &b->profile) && same_lamp(a->lamp, b->lamp) &&
           same_sky(a->sky, b->sky) && same_list(a, b) && same_file_rays(a->rays, b->rays);
}

bool rmap_same_detector(const struct rmap_detector *a, const struct rmap_detector *b)
{
    return SAME(type) && SAME_OF(origin) && SAME_OF(x) && SAME_OF(y) && SAME_OF(axis) &&
           SAME_OF(size) && SAME_OF(cells) && SAME(side) && SAME_OF(max_angle_rad);
}
