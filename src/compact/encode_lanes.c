/* SPDX-License-Identifier: MIT
 *
 * What a part is encoded to without a look at where its legs go.
 */
#include <math.h>

#include "compact/encoder.h"

/* Bits of primitives that are not what they are without meshes: 0 on an object, -1 on none. */
static uint32_t odd_primitives(const struct rmap_portion *part)
{
    uint32_t wrong = 0;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_SEGMENT]; i++)
        wrong |= (uint32_t)part->segment.primitive[i] ^
                 ((uint32_t)0 - ((uint32_t)part->segment.object[i] >> 31));
    return wrong;
}

/* The same of legs that do not end on meshes, and the triangles of those that do, without branches:
 * what a leg meets is anybody's guess. */
static uint32_t note_triangles(struct rmap_compact_encoder *encoder,
                               const struct rmap_portion *part)
{
    const struct rmap_compact_model *model = encoder->model;
    size_t n_listed = encoder->n_triangle;
    uint32_t wrong = 0;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t object = (uint32_t)part->segment.object[i];
        uint32_t primitive = (uint32_t)part->segment.primitive[i];
        bool mesh = model->body[object < model->n_object ? object : model->n_object].mesh;
        encoder->triangle[n_listed] = primitive;
        n_listed += mesh;
        wrong |= mesh ? 0 : primitive ^ ((uint32_t)0 - (object >> 31));
    }
    encoder->n_triangle = n_listed;
    return wrong;
}

/* Triangles of the legs that end on meshes, unless too many of the others have numbers that do not
 * follow: then the whole lane is kept as it is, where all of it is there. */
static void list_triangles(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                           bool all)
{
    struct rmap_lane *lane = &encoder->lane[RMAP_LANE_SEGMENT_primitive];
    const struct rmap_compact_model *model = encoder->model;
    size_t n = part->n_row[RMAP_TABLE_SEGMENT];
    uint32_t wrong = model->meshes ? note_triangles(encoder, part) : odd_primitives(part);
    if (wrong == 0)
        return;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive = part->segment.primitive[i];
        enum rmap_primitive_kind kind = rmap_primitive_kind(model, part->segment.object[i]);
        if (kind != RMAP_PRIMITIVE_LISTED)
            primitive = rmap_primitive_plain(kind);
        (void)rmap_lane_offer(lane, i, 1, sizeof primitive, &primitive);
    }
    if (!all || lane->n_patch * 64 <= n)
        return;
    lane->n_patch = lane->last = encoder->n_triangle = 0;
    for (size_t i = 0; i < n; i++) {
        int32_t primitive =
            rmap_primitive_plain(rmap_primitive_kind(model, part->segment.object[i]));
        (void)rmap_lane_offer(lane, i, 1, sizeof primitive, &primitive);
    }
}

/* Channel of a wavelength; 0: none of the scene's. */
static uint8_t channel_of(const struct rmap_compact_model *model, double wavelength_nm)
{
    for (int i = 0; i < model->n_channel; i++)
        if (model->scene->channels.wavelength_nm[i] == wavelength_nm)
            return (uint8_t)(i + 1);
    return 0;
}

/* Lanes that need no leg. */
static void offer_simple(struct rmap_compact_encoder *encoder, const struct rmap_portion *part)
{
    struct rmap_lane *lane = encoder->lane;
    const struct rmap_ray_columns *ray = &part->ray;
    uint64_t id = encoder->first_ray + encoder->n_ray;
    uint8_t *channel = encoder->channel + encoder->n_ray;
    for (size_t i = 0; i < part->n_row[RMAP_TABLE_RAY]; i++) {
        double weight = 1.0;
        int32_t primitive = -1;
        channel[i] = isnan(ray->wavelength[i]) ? 0 : channel_of(encoder->model, ray->wavelength[i]);
        double wavelength = rmap_wavelength_of(encoder->model, channel[i]);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_id], i, 1, sizeof id, &id);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_weight], i, 1, sizeof weight, &weight);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_wavelength], i, 1, sizeof wavelength,
                              &wavelength);
        (void)rmap_lane_offer(&lane[RMAP_LANE_RAY_start_primitive], i, 1, sizeof primitive,
                              &primitive);
        id++;
    }
    (void)rmap_lane_offer(&lane[RMAP_LANE_SEGMENT_medium], 0, part->n_row[RMAP_TABLE_SEGMENT],
                          sizeof *encoder->medium, encoder->medium);
}

void rmap_encode_lanes(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                       bool all)
{
    list_triangles(encoder, part, all);
    offer_simple(encoder, part);
}
