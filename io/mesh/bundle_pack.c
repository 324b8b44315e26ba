/* SPDX-License-Identifier: MIT
 *
 * A bundle as bytes, for broadcasting and for keeping inside a map. Little-endian; a text is its
 * length (64 bits; all ones: none) and its bytes; arrays follow their counts. What the fields of
 * gradient media are made of stands at the end, where there is any; behind that the texts of
 * tables, then the tangents of meshes that have them, then rays of files, then the surfaces that
 * faces of meshes lie on, and then texture coordinates.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle.h"
#include "io/mesh/bundle_pack.h"

static const char magic[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '1'};
static const char magic_fields[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '2'};
static const char magic_files[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '3'};
static const char magic_tangents[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '4'};
static const char magic_rays[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '5'};
static const char magic_surfaces[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '6'};
static const char magic_uv[8] = {'R', 'M', 'A', 'P', 'B', 'N', 'D', '7'};

/* ---- bytes out; nbytes only counts while `to` is NULL ---- */

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

enum { SURFACE_NUMBERS = 8 };

static void put_surfaces(struct sink *sink, const struct rmap_bundle *bundle)
{
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        const struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        const size_t n = mesh->surface ? mesh->n_face : 0;
        put_u64(sink, n);
        for (size_t k = 0; k < n; k++) {
            const struct rmap_true_surface *s = &mesh->surface[k];
            const double number[SURFACE_NUMBERS] = {s->at.x,   s->at.y,   s->at.z,   s->axis.x,
                                                    s->axis.y, s->axis.z, s->radius, s->second};
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

/* Which columns there are, as bits. */
enum {
    RAYS_WIDE = 1,
    RAYS_POWER = 2,
    RAYS_NM = 4,
    RAYS_DELAY = 8,
    RAYS_EVENT = 16,
    RAYS_LM = 32,
    RAYS_STEP = 64,
    RAYS_UNIT = 128 /* from here up the unit of flux; LM has a bit of its own */
};

static void put_rays(struct sink *sink, const struct rmap_file_rays *set)
{
    const double said[4] = {set->unit_m, set->all_nm, set->flux, set->loose};
    const bool lumens = set->flux_unit == RMAP_FLUX_LM;
    put_u64(sink, set->n);
    put_u32(sink, (set->wide ? RAYS_WIDE : 0U) | (set->below ? RAYS_POWER : 0U) |
                      (set->wavelength_nm ? RAYS_NM : 0U) | (set->delay_ns ? RAYS_DELAY : 0U) |
                      (set->event ? RAYS_EVENT : 0U) |
                      (lumens ? RAYS_LM : (uint32_t)set->flux_unit * RAYS_UNIT) |
                      (set->step ? RAYS_STEP : 0U));
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

static void put_bundle(struct sink *sink, const struct rmap_bundle *bundle)
{
    const struct rmap_scene_options *options = &bundle->options;
    const bool uv = has_uv(bundle), surfaces = uv || rmap_bundle_has_surfaces(bundle),
               rays = surfaces || bundle->n_ray_set > 0, tangents = rays || has_tangents(bundle),
               files = tangents || bundle->n_file > 0,
               fields = files || bundle->n_grid || bundle->n_plugin;
    put_bytes(sink,
              uv         ? magic_uv
              : surfaces ? magic_surfaces
              : rays     ? magic_rays
              : tangents ? magic_tangents
              : files    ? magic_files
              : fields   ? magic_fields
                         : magic,
              sizeof magic);
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
    if (fields)
        put_fields(sink, bundle);
    if (files)
        put_files(sink, bundle);
    if (tangents)
        put_tangents(sink, bundle);
    if (rays)
        put_u64(sink, bundle->n_ray_set);
    for (size_t i = 0; i < bundle->n_ray_set; i++) {
        put_text(sink, bundle->ray_set[i].name);
        put_rays(sink, bundle->ray_set[i].set);
    }
    if (surfaces)
        put_surfaces(sink, bundle);
    if (uv)
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

/* ---- bytes in ---- */

struct cursor {
    const uint8_t *at;
    size_t left;
    struct rmap_error *err;
};

static enum rmap_status damaged(struct cursor *in, const char *what)
{
    return rmap_error_set(in->err, RMAP_FORMAT, "the stored scene is damaged: %s", what);
}

static enum rmap_status no_memory(struct cursor *in)
{
    return rmap_error_set(in->err, RMAP_SYSTEM, "out of memory for a stored scene");
}

static enum rmap_status take_u32(struct cursor *in, uint32_t *value)
{
    if (in->left < 4)
        return damaged(in, "it ends early");
    *value = 0;
    for (int i = 0; i < 4; i++)
        *value |= (uint32_t)in->at[i] << (8 * i);
    in->at += 4;
    in->left -= 4;
    return RMAP_OK;
}

static enum rmap_status take_u64(struct cursor *in, uint64_t *value)
{
    uint32_t low = 0, high = 0;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(take_u32(in, &low));
    RMAP_TRY(take_u32(in, &high));
    *value = (uint64_t)high << 32 | low;
out:
    return st;
}

/* A count of things that take at least `nbytes` each of what is left. */
static enum rmap_status take_count(struct cursor *in, size_t nbytes, size_t *count)
{
    uint64_t value = 0;
    enum rmap_status st = take_u64(in, &value);
    if (st != RMAP_OK)
        return st;
    if (value > in->left / nbytes)
        return damaged(in, "a length exceeds what is there");
    *count = (size_t)value;
    return RMAP_OK;
}

/* Of any bytes, a 0 behind them; NULL: none. */
static enum rmap_status take_bytes(struct cursor *in, char **text_ret, size_t *nbytes_ret)
{
    uint64_t len = 0;
    enum rmap_status st = take_u64(in, &len);
    *nbytes_ret = 0;
    if (st != RMAP_OK || len == UINT64_MAX)
        return st;
    if (len > in->left)
        return damaged(in, "a text exceeds what is there");
    char *text = rmap_alloc((size_t)len + 1, 1);
    if (!text)
        return no_memory(in);
    memcpy(text, in->at, (size_t)len);
    in->at += len;
    in->left -= (size_t)len;
    *text_ret = text;
    *nbytes_ret = (size_t)len;
    return RMAP_OK;
}

static enum rmap_status take_text(struct cursor *in, char **text_ret)
{
    size_t nbytes = 0;
    enum rmap_status st = take_bytes(in, text_ret, &nbytes);
    if (st != RMAP_OK || !*text_ret || strlen(*text_ret) == nbytes)
        return st;
    rmap_free(*text_ret);
    *text_ret = NULL;
    return damaged(in, "a text holds a NUL");
}

/* A text that must be there. */
static enum rmap_status take_name(struct cursor *in, char **text_ret)
{
    enum rmap_status st = take_text(in, text_ret);
    return st == RMAP_OK && !*text_ret ? damaged(in, "a name is missing") : st;
}

static enum rmap_status take_list(struct cursor *in, char ***list_ret, size_t *n_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    RMAP_TRY(take_count(in, 8, &n));
    if (!n)
        goto out;
    *list_ret = rmap_alloc(n, sizeof **list_ret);
    if (!*list_ret)
        return no_memory(in);
    for (; *n_ret < n; ++*n_ret)
        RMAP_TRY(take_name(in, &(*list_ret)[*n_ret]));
out:
    return st;
}

/* n numbers of `size` bytes as they lie. */
static enum rmap_status take_array(struct cursor *in, void *to, size_t n, size_t size)
{
    if (in->left / size < n)
        return damaged(in, "numbers exceed what is there");
    if (n)
        memcpy(to, in->at, n * size);
    in->at += n * size;
    in->left -= n * size;
    return RMAP_OK;
}

static enum rmap_status take_points(struct cursor *in, float (*point)[3], size_t n)
{
    const float *number = (const float *)point;
    bool finite = true;
    enum rmap_status st = take_array(in, point, n, sizeof *point);
    for (size_t i = 0; st == RMAP_OK && i < 3 * n; i++)
        finite &= fabsf(number[i]) <= FLT_MAX;
    return st == RMAP_OK && !finite ? damaged(in, "a vertex lies nowhere") : st;
}

/* Each below `end`. */
static enum rmap_status take_indices(struct cursor *in, uint32_t *index, size_t n, size_t end,
                                     const char *trouble)
{
    uint32_t most = 0;
    enum rmap_status st = take_array(in, index, n, sizeof *index);
    for (size_t i = 0; st == RMAP_OK && i < n; i++)
        most = index[i] > most ? index[i] : most;
    return st == RMAP_OK && n > 0 && most >= end ? damaged(in, trouble) : st;
}

static enum rmap_status take_mesh_arrays(struct cursor *in, struct rmap_mesh *mesh)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(take_points(in, mesh->vertex, mesh->n_vertex));
    RMAP_TRY(take_indices(in, (uint32_t *)mesh->triangle, 3 * mesh->n_triangle, mesh->n_vertex,
                          "a triangle has a vertex that is not there"));
    RMAP_TRY(take_indices(in, mesh->face, mesh->n_triangle, mesh->n_face,
                          "a triangle has a face that is not there"));
    for (size_t i = 0; i < mesh->n_face; i++)
        RMAP_TRY(take_text(in, &mesh->face_name[i]));
out:
    return st;
}

static enum rmap_status take_mesh(struct cursor *in, struct rmap_mesh **mesh_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t n_vertex = 0, n_triangle = 0, n_face = 0;
    struct rmap_mesh *mesh = NULL;
    RMAP_TRY(take_count(in, 12, &n_vertex));
    RMAP_TRY(take_count(in, 16, &n_triangle));
    RMAP_TRY(take_count(in, 8, &n_face));
    RMAP_TRY(rmap_mesh_create(n_vertex, n_triangle, n_face, &mesh, in->err));
    RMAP_TRY(take_mesh_arrays(in, mesh));
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_mesh_destroy(mesh);
    return st;
}

static enum rmap_status take_meshes(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    char *name = NULL;
    struct rmap_mesh *mesh = NULL;
    RMAP_TRY(take_count(in, 32, &n));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take_mesh(in, &mesh));
        RMAP_TRY(rmap_bundle_add_mesh(bundle, name, mesh, in->err));
        mesh = NULL;
        rmap_free(name);
        name = NULL;
    }
out:
    rmap_free(name);
    rmap_mesh_destroy(mesh);
    return st;
}

/* The count is checked against what is there before memory is taken for it. */
static enum rmap_status take_grid(struct cursor *in, struct rmap_grid **grid_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t n[3], count = 1;
    double frame[6];
    struct rmap_grid *grid = NULL;
    struct rmap_error why = {0};
    for (int axis = 0; axis < 3; axis++) {
        RMAP_TRY(take_count(in, 8, &n[axis]));
        if (n[axis] && count > in->left / 8 / n[axis])
            RMAP_TRY(damaged(in, "a grid exceeds what is there"));
        count *= n[axis];
    }
    RMAP_TRY(take_array(in, frame, 6, sizeof(double)));
    st = rmap_grid_create(n, rmap_vec3(frame[0], frame[1], frame[2]),
                          rmap_vec3(frame[3], frame[4], frame[5]), &grid, &why);
    if (st != RMAP_OK)
        return st == RMAP_SYSTEM ? no_memory(in) : damaged(in, why.text);
    RMAP_TRY(take_array(in, grid->value, count, sizeof(double)));
    *grid_ret = grid;
    grid = NULL;
out:
    rmap_grid_drop(grid);
    return st;
}

static enum rmap_status take_fields(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    char *name = NULL;
    struct rmap_grid *grid = NULL;
    RMAP_TRY(take_count(in, 32, &n));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take_grid(in, &grid));
        RMAP_TRY(rmap_bundle_add_grid(bundle, name, grid, in->err));
        grid = NULL;
        rmap_free(name);
        name = NULL;
    }
    RMAP_TRY(take_count(in, 16, &n));
    for (size_t i = 0; i < n; i++) {
        uint64_t xxh3 = 0;
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take_u64(in, &xxh3));
        RMAP_TRY(rmap_bundle_add_plugin(bundle, name, xxh3, in->err));
        rmap_free(name);
        name = NULL;
    }
out:
    rmap_free(name);
    rmap_grid_drop(grid);
    return st;
}

static enum rmap_status take_files(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0, nbytes = 0;
    char *name = NULL, *text = NULL;
    RMAP_TRY(take_count(in, 16, &n));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take_bytes(in, &text, &nbytes));
        if (!text)
            RMAP_TRY(damaged(in, "a file is missing"));
        RMAP_TRY(rmap_bundle_add_file(bundle, name, text, nbytes, in->err));
        text = NULL;
        rmap_free(name);
        name = NULL;
    }
out:
    rmap_free(name);
    rmap_free(text);
    return st;
}

static enum rmap_status take_tangents(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        size_t n = 0;
        RMAP_TRY(take_count(in, 12, &n));
        if (n == 0)
            continue;
        if (n != mesh->n_triangle)
            RMAP_TRY(damaged(in, "tangents are not those of its triangles"));
        mesh->tangent = rmap_alloc(n, sizeof *mesh->tangent);
        if (!mesh->tangent)
            RMAP_TRY(no_memory(in));
        RMAP_TRY(take_points(in, mesh->tangent, n));
    }
out:
    return st;
}

static enum rmap_status take_uv(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        size_t n = 0;
        RMAP_TRY(take_count(in, sizeof *mesh->uv, &n));
        if (n == 0)
            continue;
        if (n != mesh->n_triangle)
            RMAP_TRY(damaged(in, "texture coordinates are not those of its triangles"));
        mesh->uv = rmap_alloc(n, sizeof *mesh->uv);
        if (!mesh->uv)
            RMAP_TRY(no_memory(in));
        RMAP_TRY(take_points(in, (float(*)[3])mesh->uv, 2 * n));
        for (size_t k = 0; k < 6 * n; k++)
            if (!(fabsf(mesh->uv[k / 6][k % 6]) <= RMAP_MESH_UV_FARTHEST))
                RMAP_TRY(damaged(in, "texture coordinates lie nowhere"));
    }
out:
    return st;
}

static enum rmap_status take_surface(struct cursor *in, struct rmap_true_surface *surface)
{
    enum rmap_status st = RMAP_OK;
    uint32_t kind = 0;
    double number[SURFACE_NUMBERS] = {0};
    RMAP_TRY(take_u32(in, &kind));
    RMAP_TRY(take_array(in, number, SURFACE_NUMBERS, sizeof(double)));
    if (kind > RMAP_TRUE_TORUS)
        RMAP_TRY(damaged(in, "a surface is of no kind"));
    *surface = (struct rmap_true_surface){.kind = (enum rmap_true_kind)kind,
                                          .at = rmap_vec3(number[0], number[1], number[2]),
                                          .axis = rmap_vec3(number[3], number[4], number[5]),
                                          .radius = number[6],
                                          .second = number[7]};
    if (rmap_true_surface_finish(surface))
        RMAP_TRY(damaged(in, "a face lies on no surface"));
out:
    return st;
}

static enum rmap_status take_surfaces(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        struct rmap_mesh *mesh = bundle->mesh[i].mesh;
        size_t n = 0;
        RMAP_TRY(take_count(in, 4 + SURFACE_NUMBERS * sizeof(double), &n));
        if (n == 0)
            continue;
        if (n != mesh->n_face)
            RMAP_TRY(damaged(in, "surfaces are not those of its faces"));
        mesh->surface = rmap_alloc(n, sizeof *mesh->surface);
        if (!mesh->surface)
            RMAP_TRY(no_memory(in));
        for (size_t k = 0; k < n; k++)
            RMAP_TRY(take_surface(in, &mesh->surface[k]));
    }
out:
    return st;
}

/* A column of n rows; NULL where there is none. */
static enum rmap_status take_column(struct cursor *in, bool there, size_t n, size_t size,
                                    void *column_address)
{
    if (!there)
        return RMAP_OK;
    if (n > in->left / size)
        return damaged(in, "rays exceed what is there");
    void *column = rmap_alloc_unset(n, size);
    if (!column)
        return no_memory(in);
    memcpy(column, in->at, n * size);
    memcpy(column_address, &column, sizeof column);
    in->at += n * size;
    in->left -= n * size;
    return RMAP_OK;
}

static enum rmap_status take_rays(struct cursor *in, struct rmap_file_rays **set_ret)
{
    enum rmap_status st = RMAP_OK;
    uint32_t bits = 0;
    double said[4];
    char *title = NULL;
    struct rmap_error why = {0};
    struct rmap_file_rays *set = rmap_alloc(1, sizeof *set);
    if (!set)
        return no_memory(in);
    set->n_holder = 1;
    RMAP_TRY(take_count(in, 24, &set->n));
    RMAP_TRY(take_u32(in, &bits));
    RMAP_TRY(take_array(in, said, 4, sizeof(double)));
    RMAP_TRY(take_name(in, &title));
    if (strlen(title) >= sizeof set->title || set->n == 0 || !(said[0] >= 0.0 && said[0] < 1e9) ||
        bits / RAYS_UNIT > RMAP_FLUX_J || !(said[3] >= 0.0 && said[3] <= RMAP_FILE_RAYS_LOOSE))
        RMAP_TRY(damaged(in, "rays are not as they are written"));
    memcpy(set->title, title, strlen(title) + 1);
    set->unit_m = said[0];
    set->all_nm = said[1];
    set->flux = said[2];
    set->loose = said[3];
    set->flux_unit = bits & RAYS_LM ? RMAP_FLUX_LM : (enum rmap_flux_unit)(bits / RAYS_UNIT);
    RMAP_TRY(take_column(in, (bits & RAYS_WIDE) != 0, set->n, sizeof *set->wide, &set->wide));
    RMAP_TRY(take_column(in, !(bits & RAYS_WIDE), set->n, sizeof *set->narrow, &set->narrow));
    RMAP_TRY(take_column(in, (bits & RAYS_POWER) != 0, set->n, sizeof *set->below, &set->below));
    RMAP_TRY(take_column(in, (bits & RAYS_NM) != 0, set->n, sizeof *set->wavelength_nm,
                         &set->wavelength_nm));
    RMAP_TRY(
        take_column(in, (bits & RAYS_DELAY) != 0, set->n, sizeof *set->delay_ns, &set->delay_ns));
    RMAP_TRY(take_column(in, (bits & RAYS_EVENT) != 0, set->n, sizeof *set->event, &set->event));
    RMAP_TRY(take_column(in, (bits & RAYS_STEP) != 0, set->n, sizeof *set->step, &set->step));
    st = rmap_file_rays_finish(set, &why);
    if (st != RMAP_OK)
        RMAP_TRY(damaged(in, why.text));
    *set_ret = set;
    set = NULL;
out:
    rmap_free(title);
    rmap_file_rays_drop(set);
    return st;
}

static enum rmap_status take_ray_sets(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    char *name = NULL;
    struct rmap_file_rays *set = NULL;
    RMAP_TRY(take_count(in, 32, &n));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take_rays(in, &set));
        RMAP_TRY(rmap_bundle_add_ray_set(bundle, name, set, in->err));
        set = NULL;
        rmap_free(name);
        name = NULL;
    }
out:
    rmap_free(name);
    rmap_file_rays_drop(set);
    return st;
}

static enum rmap_status take_bundle(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options *options = &bundle->options;
    uint32_t complete = 0;
    bool known = in->left >= sizeof magic;
    const bool uv = known && memcmp(in->at, magic_uv, sizeof magic) == 0;
    const bool surfaces = uv || (known && memcmp(in->at, magic_surfaces, sizeof magic) == 0);
    const bool rays = surfaces || (known && memcmp(in->at, magic_rays, sizeof magic) == 0);
    const bool tangents = rays || (known && memcmp(in->at, magic_tangents, sizeof magic) == 0);
    const bool files = tangents || (known && memcmp(in->at, magic_files, sizeof magic) == 0);
    const bool fields = files || (known && memcmp(in->at, magic_fields, sizeof magic) == 0);
    if (!known || (!fields && memcmp(in->at, magic, sizeof magic) != 0))
        return damaged(in, "it does not begin like one");
    in->at += sizeof magic;
    in->left -= sizeof magic;
    RMAP_TRY(take_text(in, &bundle->path));
    RMAP_TRY(take_name(in, &bundle->text));
    bundle->text_nbytes = strlen(bundle->text);
    RMAP_TRY(take_text(in, &options->simulation));
    RMAP_TRY(take_text(in, &options->color));
    RMAP_TRY(take_list(in, &options->only, &options->n_only));
    RMAP_TRY(take_list(in, &options->without, &options->n_without));
    RMAP_TRY(take_list(in, &options->set, &options->n_set));
    RMAP_TRY(take_u32(in, &complete));
    if (complete != 1) /* or else reading the scene would open files that a stranger's map names */
        RMAP_TRY(damaged(in, "its meshes are not all in it"));
    bundle->meshes_complete = 1;
    RMAP_TRY(take_meshes(in, bundle));
    if (fields)
        RMAP_TRY(take_fields(in, bundle));
    if (files)
        RMAP_TRY(take_files(in, bundle));
    if (tangents)
        RMAP_TRY(take_tangents(in, bundle));
    if (rays)
        RMAP_TRY(take_ray_sets(in, bundle));
    if (surfaces)
        RMAP_TRY(take_surfaces(in, bundle));
    if (uv)
        RMAP_TRY(take_uv(in, bundle));
    if (in->left)
        RMAP_TRY(damaged(in, "something follows its end"));
out:
    return st;
}

enum rmap_status rmap_bundle_unpack(const uint8_t *blob, size_t nbytes,
                                    struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct cursor in = {blob, nbytes, err};
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    if (!bundle)
        return no_memory(&in);
    enum rmap_status st = take_bundle(&in, bundle);
    if (st == RMAP_OK)
        *bundle_ret = bundle;
    else
        rmap_bundle_destroy(bundle);
    return st;
}
