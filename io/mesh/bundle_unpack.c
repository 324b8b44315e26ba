/* SPDX-License-Identifier: MIT
 *
 * A bundle from its bytes, none of which is believed.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle_format.h"
#include "io/mesh/bundle_pack.h"

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
    double number[RMAP_BUNDLE_SURFACE_NUMBERS] = {0};
    RMAP_TRY(take_u32(in, &kind));
    RMAP_TRY(take_array(in, number, RMAP_BUNDLE_SURFACE_NUMBERS, sizeof(double)));
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
        RMAP_TRY(take_count(in, 4 + RMAP_BUNDLE_SURFACE_NUMBERS * sizeof(double), &n));
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
        bits / RMAP_BUNDLE_RAYS_UNIT > RMAP_FLUX_J ||
        !(said[3] >= 0.0 && said[3] <= RMAP_FILE_RAYS_LOOSE))
        RMAP_TRY(damaged(in, "rays are not as they are written"));
    memcpy(set->title, title, strlen(title) + 1);
    set->unit_m = said[0];
    set->all_nm = said[1];
    set->flux = said[2];
    set->loose = said[3];
    set->flux_unit = bits & RMAP_BUNDLE_RAYS_LM
                         ? RMAP_FLUX_LM
                         : (enum rmap_flux_unit)(bits / RMAP_BUNDLE_RAYS_UNIT);
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_WIDE) != 0, set->n, sizeof *set->wide,
                         &set->wide));
    RMAP_TRY(take_column(in, !(bits & RMAP_BUNDLE_RAYS_WIDE), set->n, sizeof *set->narrow,
                         &set->narrow));
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_POWER) != 0, set->n, sizeof *set->below,
                         &set->below));
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_NM) != 0, set->n, sizeof *set->wavelength_nm,
                         &set->wavelength_nm));
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_DELAY) != 0, set->n, sizeof *set->delay_ns,
                         &set->delay_ns));
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_EVENT) != 0, set->n, sizeof *set->event,
                         &set->event));
    RMAP_TRY(take_column(in, (bits & RMAP_BUNDLE_RAYS_STEP) != 0, set->n, sizeof *set->step,
                         &set->step));
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

/* What each entry of a list of named things is. */
typedef enum rmap_status take_named(struct cursor *in, struct rmap_bundle *bundle,
                                    const char *name);

/* A list whose entries have so many bytes at least. */
static enum rmap_status take_each(struct cursor *in, size_t least_nbytes,
                                  struct rmap_bundle *bundle, take_named *take)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0;
    char *name = NULL;
    RMAP_TRY(take_count(in, least_nbytes, &n));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(take_name(in, &name));
        RMAP_TRY(take(in, bundle, name));
        rmap_free(name);
        name = NULL;
    }
out:
    rmap_free(name);
    return st;
}

static enum rmap_status take_named_mesh(struct cursor *in, struct rmap_bundle *bundle,
                                        const char *name)
{
    struct rmap_mesh *mesh = NULL;
    enum rmap_status st = take_mesh(in, &mesh);
    if (st == RMAP_OK)
        st = rmap_bundle_add_mesh(bundle, name, mesh, in->err);
    if (st != RMAP_OK)
        rmap_mesh_destroy(mesh);
    return st;
}

static enum rmap_status take_named_grid(struct cursor *in, struct rmap_bundle *bundle,
                                        const char *name)
{
    struct rmap_grid *grid = NULL;
    enum rmap_status st = take_grid(in, &grid);
    if (st == RMAP_OK)
        st = rmap_bundle_add_grid(bundle, name, grid, in->err);
    if (st != RMAP_OK)
        rmap_grid_drop(grid);
    return st;
}

static enum rmap_status take_plugin(struct cursor *in, struct rmap_bundle *bundle, const char *name)
{
    uint64_t xxh3 = 0;
    const enum rmap_status st = take_u64(in, &xxh3);
    return st == RMAP_OK ? rmap_bundle_add_plugin(bundle, name, xxh3, in->err) : st;
}

static enum rmap_status take_file(struct cursor *in, struct rmap_bundle *bundle, const char *name)
{
    size_t nbytes = 0;
    char *text = NULL;
    enum rmap_status st = take_bytes(in, &text, &nbytes);
    if (st == RMAP_OK)
        st = text ? rmap_bundle_add_file(bundle, name, text, nbytes, in->err)
                  : damaged(in, "a file is missing");
    if (st != RMAP_OK)
        rmap_free(text);
    return st;
}

static enum rmap_status take_ray_set(struct cursor *in, struct rmap_bundle *bundle,
                                     const char *name)
{
    struct rmap_file_rays *set = NULL;
    enum rmap_status st = take_rays(in, &set);
    if (st == RMAP_OK)
        st = rmap_bundle_add_ray_set(bundle, name, set, in->err);
    if (st != RMAP_OK)
        rmap_file_rays_drop(set);
    return st;
}

static enum rmap_status take_bundle(struct cursor *in, struct rmap_bundle *bundle)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options *options = &bundle->options;
    uint32_t complete = 0;
    const size_t n = strlen(RMAP_BUNDLE_MAGIC);
    const int level = in->left > n ? in->at[n] - '0' : 0;
    if (level < RMAP_BUNDLE_PLAIN || level > RMAP_BUNDLE_UV ||
        memcmp(in->at, RMAP_BUNDLE_MAGIC, n) != 0)
        return damaged(in, "it does not begin like one");
    in->at += n + 1;
    in->left -= n + 1;
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
    RMAP_TRY(take_each(in, 32, bundle, take_named_mesh));
    if (level >= RMAP_BUNDLE_FIELDS) {
        RMAP_TRY(take_each(in, 32, bundle, take_named_grid));
        RMAP_TRY(take_each(in, 16, bundle, take_plugin));
    }
    if (level >= RMAP_BUNDLE_FILES)
        RMAP_TRY(take_each(in, 16, bundle, take_file));
    if (level >= RMAP_BUNDLE_TANGENTS)
        RMAP_TRY(take_tangents(in, bundle));
    if (level >= RMAP_BUNDLE_RAYS)
        RMAP_TRY(take_each(in, 32, bundle, take_ray_set));
    if (level >= RMAP_BUNDLE_SURFACES)
        RMAP_TRY(take_surfaces(in, bundle));
    if (level >= RMAP_BUNDLE_UV)
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
