/* SPDX-License-Identifier: MIT
 *
 * The colour spaces of a map: the same scene, its light described in several ways.
 */
#include "io/map/map_space.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/hdf5/h5.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_internal.h"
#include "io/mesh/bundle_pack.h"

void rmap_map_spaces_fini(struct rmap_map_spaces *spaces)
{
    for (size_t i = 0; i < spaces->n; i++)
        rmap_free(spaces->space[i].options);
    rmap_free(spaces->space);
    *spaces = (struct rmap_map_spaces){0};
}

int32_t rmap_map_spaces_find(const struct rmap_map_spaces *spaces, const char *digest)
{
    for (size_t i = 0; i < spaces->n; i++)
        if (strcmp(spaces->space[i].digest, digest) == 0)
            return (int32_t)i;
    return -1;
}

static enum rmap_status make_room(struct rmap_map_spaces *spaces, size_t n_more,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(spaces->space, spaces->cap, spaces->n + n_more, err);
    return st;
}

enum rmap_status rmap_map_spaces_add(struct rmap_map_spaces *spaces,
                                     const struct rmap_bundle *bundle,
                                     const struct rmap_scene *scene, const char *digest,
                                     struct rmap_error *err)
{
    const struct rmap_bundle options = {.options = bundle->options, .meshes_complete = 1};
    enum rmap_status st = make_room(spaces, 1, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_map_space *space = &spaces->space[spaces->n];
    *space = (struct rmap_map_space){.mode = (int32_t)scene->channels.mode,
                                     .n_channel = scene->channels.n};
    memcpy(space->wavelength_nm, scene->channels.wavelength_nm, sizeof space->wavelength_nm);
    memcpy(space->digest, digest, strnlen(digest, sizeof space->digest - 1));
    st = rmap_bundle_pack(&options, &space->options, &space->options_nbytes, err);
    if (st == RMAP_OK)
        spaces->n++;
    return st;
}

enum rmap_status rmap_map_spaces_copy(struct rmap_map_spaces *to,
                                      const struct rmap_map_spaces *from, struct rmap_error *err)
{
    enum rmap_status st = make_room(to, from->n, err);
    for (size_t i = 0; st == RMAP_OK && i < from->n; i++) {
        struct rmap_map_space *space = &to->space[to->n];
        *space = from->space[i];
        space->options = rmap_alloc(space->options_nbytes, 1);
        if (!space->options)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
        memcpy(space->options, from->space[i].options, space->options_nbytes);
        to->n++;
    }
    return st;
}

static bool fits(const struct rmap_map_space *space, const struct rmap_scene *scene,
                 const struct rmap_scene *first)
{
    return (int32_t)scene->channels.mode == space->mode && scene->channels.n == space->n_channel &&
           memcmp(scene->channels.wavelength_nm, space->wavelength_nm,
                  (size_t)space->n_channel * sizeof *space->wavelength_nm) == 0 &&
           (!first ||
            (scene->n_object == first->n_object && scene->n_source == first->n_source &&
             scene->n_medium == first->n_medium && scene->n_detector == first->n_detector));
}

enum rmap_status rmap_map_space_scene(const struct rmap_map_space *space,
                                      struct rmap_bundle *bundle, const struct rmap_scene *first,
                                      const char *path, struct rmap_scene **scene_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics diagnostics;
    struct rmap_bundle *options = NULL;
    struct rmap_scene *scene = NULL;
    struct rmap_scene_options before = bundle->options;
    rmap_diagnostics_init(&diagnostics, path);
    RMAP_TRY(rmap_bundle_unpack(space->options, space->options_nbytes, &options, err));
    bundle->options = options->options;
    st = rmap_scene_read(bundle, &scene, &diagnostics, err);
    bundle->options = before;
    if (st != RMAP_OK && st != RMAP_SYSTEM)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s: the scene inside cannot be read (%s%s%s); a program of "
                            "the version that wrote the map can",
                            path, diagnostics.n ? diagnostics.item[0].text : "",
                            diagnostics.n ? "; " : "",
                            rmap_counted(diagnostics.n_error, "mistake").text);
    else if (st == RMAP_OK && !fits(space, scene, first))
        st = rmap_error_set(err, RMAP_FORMAT, "%s: the scene inside does not fit /space", path);
    if (st == RMAP_OK) {
        *scene_ret = scene;
        scene = NULL;
    }
out:
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(options);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}

enum rmap_status rmap_map_options_of(const struct rmap_map *map, size_t space,
                                     struct rmap_bundle **options_ret, struct rmap_error *err)
{
    const struct rmap_map_space *row = &map->spaces.space[space];
    return rmap_bundle_unpack(row->options, row->options_nbytes, options_ret, err);
}

/* ---- /space ---- */

/* Row of /space as its fields have it. */
struct space_row {
    int32_t mode, n_channel;
    uint64_t options_nbytes;
    double wavelength_nm[RMAP_CHANNEL_MAX]; /* NaN behind the last channel */
};

static const struct rmap_h5_field space_field[] = {
    {"/space/mode", RMAP_I32, 1, offsetof(struct space_row, mode), "0 spectral, 1 RGB"},
    {"/space/channels", RMAP_I32, 1, offsetof(struct space_row, n_channel),
     "channels of a colour in this space"},
    {"/space/wavelength_nm", RMAP_F64, RMAP_CHANNEL_MAX, offsetof(struct space_row, wavelength_nm),
     "vacuum wavelength of each channel in nm; NaN behind the last"},
    {"/space/options_nbytes", RMAP_U64, 1, offsetof(struct space_row, options_nbytes),
     "bytes of the space in /space/options"},
};

enum { N_SPACE_FIELD = sizeof space_field / sizeof *space_field };

static enum rmap_status write_options(struct rmap_h5 *h5, const struct rmap_map_spaces *spaces,
                                      struct rmap_error *err)
{
    struct rmap_h5_array array = {
        "/space/options",
        RMAP_U8,
        1,
        {0},
        {"1", 1.0, {0}},
        "choices of each space, one after the other, as the program packs them"};
    size_t at = 0, nbytes = 0;
    for (size_t i = 0; i < spaces->n; i++)
        nbytes += spaces->space[i].options_nbytes;
    uint8_t *blob = rmap_alloc(nbytes, 1);
    if (!blob)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
    for (size_t i = 0; i < spaces->n; i++) {
        memcpy(blob + at, spaces->space[i].options, spaces->space[i].options_nbytes);
        at += spaces->space[i].options_nbytes;
    }
    array.dims[0] = nbytes;
    enum rmap_status st = rmap_h5_write(h5, &array, blob, err);
    rmap_free(blob);
    return st;
}

enum rmap_status rmap_map_spaces_write(struct rmap_h5 *h5, const struct rmap_map_spaces *spaces,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct space_row *row = rmap_alloc(spaces->n, sizeof *row);
    const char **digest = rmap_alloc(spaces->n, sizeof *digest);
    if (!row || !digest) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
        goto out;
    }
    for (size_t i = 0; i < spaces->n; i++) {
        const struct rmap_map_space *space = &spaces->space[i];
        row[i] = (struct space_row){.mode = space->mode,
                                    .n_channel = space->n_channel,
                                    .options_nbytes = space->options_nbytes};
        for (int k = 0; k < RMAP_CHANNEL_MAX; k++)
            row[i].wavelength_nm[k] = k < space->n_channel ? space->wavelength_nm[k] : (double)NAN;
        digest[i] = space->digest;
    }
    RMAP_TRY(rmap_h5_group(h5, "/space", err));
    RMAP_TRY(
        rmap_h5_write_fields(h5, space_field, N_SPACE_FIELD, row, spaces->n, sizeof *row, err));
    RMAP_TRY(rmap_h5_write_names(h5, "/space/digest", digest, spaces->n,
                                 "the space_digest of its pieces", err));
    RMAP_TRY(write_options(h5, spaces, err));
out:
    rmap_free(row);
    rmap_free(digest);
    return st;
}

static enum rmap_status take_space(struct rmap_map_spaces *spaces, const struct space_row *row,
                                   const char *digest, const uint8_t *options,
                                   struct rmap_error *err)
{
    struct rmap_map_space *space = &spaces->space[spaces->n];
    *space = (struct rmap_map_space){.mode = row->mode,
                                     .n_channel = row->n_channel,
                                     .options_nbytes = (size_t)row->options_nbytes};
    memcpy(space->wavelength_nm, row->wavelength_nm, sizeof space->wavelength_nm);
    memcpy(space->digest, digest, strnlen(digest, sizeof space->digest - 1));
    space->options = rmap_alloc(space->options_nbytes, 1);
    if (!space->options)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for colour spaces");
    memcpy(space->options, options, space->options_nbytes);
    spaces->n++;
    return RMAP_OK;
}

enum rmap_status rmap_map_spaces_read(struct rmap_h5 *h5, struct rmap_map_spaces *spaces,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *rows = NULL, *options = NULL;
    char *digest = NULL;
    size_t n = 0, n_digest = 0, width = 0;
    hsize_t nbytes = 0;
    RMAP_TRY(rmap_h5_read_fields(h5, space_field, N_SPACE_FIELD, sizeof(struct space_row), &rows,
                                 &n, err));
    RMAP_TRY(rmap_h5_read_names(h5, "/space/digest", &digest, &n_digest, &width, err));
    RMAP_TRY(rmap_h5_read(h5, "/space/options", RMAP_U8, 1, &nbytes, &options, err));
    RMAP_TRY(make_room(spaces, n, err));
    const struct space_row *row = rows;
    const uint8_t *at = options;
    for (size_t i = 0; i < n; i++) {
        bool good = n_digest == n && row[i].options_nbytes <= nbytes && row[i].n_channel >= 1 &&
                    row[i].n_channel <= RMAP_CHANNEL_MAX &&
                    (row[i].mode == RMAP_COLOUR_SPECTRAL || row[i].mode == RMAP_COLOUR_RGB);
        if (!good) {
            st = rmap_error_set(err, RMAP_FORMAT, "%s: /space makes no sense", h5->path);
            goto out;
        }
        RMAP_TRY(take_space(spaces, &row[i], digest + i * width, at, err));
        at += row[i].options_nbytes;
        nbytes -= row[i].options_nbytes;
    }
out:
    rmap_free(rows);
    rmap_free(options);
    rmap_free(digest);
    return st;
}
