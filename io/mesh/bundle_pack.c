/* SPDX-License-Identifier: MIT
 *
 * A bundle as bytes.
 */
#include <stdbool.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/mesh/bundle_format.h"
#include "io/mesh/bundle_pack.h"
#include "portion/portion.h"

/* nbytes only counts while `to` is NULL. */
struct sink {
    uint8_t *to;
    size_t nbytes;
};

static void put_bytes(struct sink *sink, const void *bytes, size_t n)
{
    if (sink->to && n)
        memcpy(sink->to + sink->nbytes, bytes, n);
    sink->nbytes += n;
}

static void put_u32(struct sink *sink, uint32_t value)
{
    if (sink->to)
        for (int i = 0; i < 4; i++)
            sink->to[sink->nbytes + (size_t)i] = (uint8_t)(value >> (8 * i));
    sink->nbytes += 4;
}

static void put_u64(struct sink *sink, uint64_t value)
{
    put_u32(sink, (uint32_t)value);
    put_u32(sink, (uint32_t)(value >> 32));
}

static void put_text(struct sink *sink, const char *text)
{
    size_t len = text ? strlen(text) : 0;
    put_u64(sink, text ? (uint64_t)len : UINT64_MAX);
    put_bytes(sink, text, len);
}

static void put_list(struct sink *sink, char *const *list, size_t n)
{
    put_u64(sink, n);
    for (size_t i = 0; i < n; i++)
        put_text(sink, list[i]);
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are packed as they lie");
_Static_assert(sizeof(float) == 4, "a float is packed as four bytes");

static void put_mesh(struct sink *sink, const struct rmap_mesh *mesh)
{
    put_u64(sink, mesh->n_vertex);
    put_u64(sink, mesh->n_triangle);
    put_u64(sink, mesh->n_face);
    put_bytes(sink, mesh->vertex, mesh->n_vertex * sizeof *mesh->vertex);
    put_bytes(sink, mesh->triangle, mesh->n_triangle * sizeof *mesh->triangle);
    put_bytes(sink, mesh->face, mesh->n_triangle * sizeof *mesh->face);
    for (size_t i = 0; i < mesh->n_face; i++)
        put_text(sink, mesh->face_name[i]);
}

_Static_assert(sizeof(double) == 8, "a double is packed as eight bytes");

static void put_fields(struct sink *sink, const struct rmap_bundle *bundle)
{
    put_u64(sink, bundle->n_grid);
    for (size_t i = 0; i < bundle->n_grid; i++) {
        const struct rmap_grid *grid = bundle->grid[i].grid;
        const double frame[6] = {grid->origin.x,  grid->origin.y,  grid->origin.z,
                                 grid->spacing.x, grid->spacing.y, grid->spacing.z};
        put_text(sink, bundle->grid[i].field);
        for (int axis = 0; axis < 3; axis++)
            put_u64(sink, grid->n[axis]);
        put_bytes(sink, frame, sizeof frame);
        put_bytes(sink, grid->value, rmap_grid_count(grid) * sizeof *grid->value);
    }
    put_u64(sink, bundle->n_plugin);
    for (size_t i = 0; i < bundle->n_plugin; i++) {
        put_text(sink, bundle->plugin[i].field);
        put_u64(sink, bundle->plugin[i].xxh3);
    }
}

static void put_files(struct sink *sink, const struct rmap_bundle *bundle)
{
    put_u64(sink, bundle->n_file);
    for (size_t i = 0; i < bundle->n_file; i++) {
        put_text(sink, bundle->file[i].name);
        put_u64(sink, bundle->file[i].nbytes);
        put_bytes(sink, bundle->file[i].text, bundle->file[i].nbytes);
    }
}

static bool has_tangents(const struct rmap_bundle *bundle)
{
    bool has = false;
    for (size_t i = 0; i < bundle->n_mesh; i++)
        has = has || bundle->mesh[i].mesh->tangent;
    return has;
}

static void put_tangents(struct sink *sink, const struct rmap_bundle *bundle)
{
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        const struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        const size_t n = mesh->tangent ? mesh->n_triangle : 0;
        put_u64(sink, n);
        put_bytes(sink, mesh->tangent, n * sizeof *mesh->tangent);
    }
}

bool rmap_bundle_has_surfaces(const struct rmap_bundle *bundle)
{
    bool has = false;
    for (size_t i = 0; i < bundle->n_mesh; i++)
        has = has || bundle->mesh[i].mesh->surface;
    return has;
}

static void put_surfaces(struct sink *sink, const struct rmap_bundle *bundle)
{
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        const struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        const size_t n = mesh->surface ? mesh->n_face : 0;
        put_u64(sink, n);
        for (size_t k = 0; k < n; k++) {
            const struct rmap_true_surface *s = &mesh->surface[k];
            const double number[RMAP_BUNDLE_SURFACE_NUMBERS] = {
                s->at.x, s->at.y, s->at.z, s->axis.x, s->axis.y, s->axis.z, s->radius, s->second};
            put_u32(sink, (uint32_t)s->kind);
            put_bytes(sink, number, sizeof number);
        }
    }
}

static bool has_uv(const struct rmap_bundle *bundle)
{
    bool has = false;
    for (size_t i = 0; i < bundle->n_mesh; i++)
        has = has || bundle->mesh[i].mesh->uv;
    return has;
}

static void put_uv(struct sink *sink, const struct rmap_bundle *bundle)
{
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        const struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        const size_t n = mesh->uv ? mesh->n_triangle : 0;
        put_u64(sink, n);
        put_bytes(sink, mesh->uv, n * sizeof *mesh->uv);
    }
}

static void put_rays(struct sink *sink, const struct rmap_file_rays *set)
{
    const double said[4] = {set->unit_m, set->all_nm, set->flux, set->loose};
    const bool lumens = set->flux_unit == RMAP_FLUX_LM;
    put_u64(sink, set->n);
    put_u32(sink,
            (set->wide ? RMAP_BUNDLE_RAYS_WIDE : 0U) | (set->below ? RMAP_BUNDLE_RAYS_POWER : 0U) |
                (set->wavelength_nm ? RMAP_BUNDLE_RAYS_NM : 0U) |
                (set->delay_ns ? RMAP_BUNDLE_RAYS_DELAY : 0U) |
                (set->event ? RMAP_BUNDLE_RAYS_EVENT : 0U) |
                (lumens ? RMAP_BUNDLE_RAYS_LM : (uint32_t)set->flux_unit * RMAP_BUNDLE_RAYS_UNIT) |
                (set->step ? RMAP_BUNDLE_RAYS_STEP : 0U));
    put_bytes(sink, said, sizeof said);
    put_text(sink, set->title);
    if (set->wide)
        put_bytes(sink, set->wide, set->n * sizeof *set->wide);
    else
        put_bytes(sink, set->narrow, set->n * sizeof *set->narrow);
    put_bytes(sink, set->below, set->below ? set->n * sizeof *set->below : 0);
    put_bytes(sink, set->wavelength_nm,
              set->wavelength_nm ? set->n * sizeof *set->wavelength_nm : 0);
    put_bytes(sink, set->delay_ns, set->delay_ns ? set->n * sizeof *set->delay_ns : 0);
    put_bytes(sink, set->event, set->event ? set->n * sizeof *set->event : 0);
    put_bytes(sink, set->step, set->step ? set->n * sizeof *set->step : 0);
}

static enum rmap_bundle_level level_of(const struct rmap_bundle *bundle)
{
    return has_uv(bundle)                               ? RMAP_BUNDLE_UV
           : rmap_bundle_has_surfaces(bundle)           ? RMAP_BUNDLE_SURFACES
           : bundle->n_ray_set > 0                      ? RMAP_BUNDLE_RAYS
           : has_tangents(bundle)                       ? RMAP_BUNDLE_TANGENTS
           : bundle->n_file > 0                         ? RMAP_BUNDLE_FILES
           : bundle->n_grid > 0 || bundle->n_plugin > 0 ? RMAP_BUNDLE_FIELDS
                                                        : RMAP_BUNDLE_PLAIN;
}

static void put_bundle(struct sink *sink, const struct rmap_bundle *bundle)
{
    const struct rmap_scene_options *options = &bundle->options;
    const enum rmap_bundle_level level = level_of(bundle);
    const char digit = (char)('0' + level);
    put_bytes(sink, RMAP_BUNDLE_MAGIC, strlen(RMAP_BUNDLE_MAGIC));
    put_bytes(sink, &digit, 1);
    put_text(sink, bundle->path);
    put_u64(sink, bundle->text_nbytes);
    put_bytes(sink, bundle->text, bundle->text_nbytes);
    put_text(sink, options->simulation);
    put_text(sink, options->color);
    put_list(sink, options->only, options->n_only);
    put_list(sink, options->without, options->n_without);
    put_list(sink, options->set, options->n_set);
    put_u32(sink, bundle->meshes_complete ? 1 : 0);
    put_u64(sink, bundle->n_mesh);
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        put_text(sink, bundle->mesh[i].geometry);
        put_mesh(sink, bundle->mesh[i].mesh);
    }
    if (level >= RMAP_BUNDLE_FIELDS)
        put_fields(sink, bundle);
    if (level >= RMAP_BUNDLE_FILES)
        put_files(sink, bundle);
    if (level >= RMAP_BUNDLE_TANGENTS)
        put_tangents(sink, bundle);
    if (level >= RMAP_BUNDLE_RAYS)
        put_u64(sink, bundle->n_ray_set);
    for (size_t i = 0; i < bundle->n_ray_set; i++) {
        put_text(sink, bundle->ray_set[i].name);
        put_rays(sink, bundle->ray_set[i].set);
    }
    if (level >= RMAP_BUNDLE_SURFACES)
        put_surfaces(sink, bundle);
    if (level >= RMAP_BUNDLE_UV)
        put_uv(sink, bundle);
}

enum rmap_status rmap_bundle_pack(const struct rmap_bundle *bundle, uint8_t **blob_ret,
                                  size_t *nbytes_ret, struct rmap_error *err)
{
    struct sink sink = {0};
    put_bundle(&sink, bundle);
    size_t nbytes = sink.nbytes;
    sink = (struct sink){.to = rmap_alloc(nbytes, 1)};
    if (!sink.to)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu bytes of a scene", nbytes);
    put_bundle(&sink, bundle);
    *blob_ret = sink.to;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

enum rmap_status rmap_bundle_digest(const struct rmap_bundle *bundle, char text[33],
                                    struct rmap_error *err)
{
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_bundle_pack(bundle, &blob, &nbytes, err);
    if (st != RMAP_OK)
        return st;
    const XXH128_hash_t hash = XXH3_128bits(blob, nbytes);
    rmap_digest_text((struct rmap_digest){hash.low64, hash.high64}, text);
    rmap_free(blob);
    return RMAP_OK;
}
