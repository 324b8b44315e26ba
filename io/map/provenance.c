/* SPDX-License-Identifier: MIT
 *
 * What every file of a map says of its origin, as attributes of its root.
 */
#include "io/map/provenance.h"

#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/codec/zlib_stream.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_format.h"
#include "io/mesh/bundle_pack.h"
#include "trace/tracer_revision.h"
#include "version.h"

static struct rmap_bundle without_folder(const struct rmap_bundle *bundle)
{
    struct rmap_bundle portable = *bundle;
    const char *slash = bundle->path ? strrchr(bundle->path, '/') : NULL;
    if (slash)
        portable.path += slash + 1 - bundle->path;
    return portable;
}

enum rmap_status rmap_scene_pack(const struct rmap_bundle *bundle, uint8_t **blob_ret,
                                 size_t *nbytes_ret, struct rmap_error *err)
{
    const struct rmap_bundle portable = without_folder(bundle);
    return rmap_bundle_pack(&portable, blob_ret, nbytes_ret, err);
}

static enum rmap_status digest_bundle(const struct rmap_bundle *bundle, char text[33],
                                      struct rmap_error *err)
{
    const struct rmap_bundle portable = without_folder(bundle);
    return rmap_bundle_digest(&portable, text, err);
}

static bool begins_with(const char *text, const char *begin)
{
    return strncmp(text, begin, strlen(begin)) == 0;
}

/* "spectrum...=" of the root, or "simulations...color=". */
static bool sets_colour(const char *assignment)
{
    static const char colour[] = ".color";
    size_t n = strcspn(assignment, "="), n_colour = sizeof colour - 1;
    return begins_with(assignment, "spectrum.") || begins_with(assignment, "spectrum=") ||
           (begins_with(assignment, "simulations.") && n > n_colour &&
            memcmp(assignment + n - n_colour, colour, n_colour) == 0);
}

static bool chooses_colour(const struct rmap_scene_options *options)
{
    bool chooses = options->color != NULL;
    for (size_t i = 0; i < options->n_set; i++)
        chooses = chooses || sets_colour(options->set[i]);
    return chooses;
}

static enum rmap_status digest_without_colour(const struct rmap_bundle *bundle, char text[33],
                                              struct rmap_error *err)
{
    struct rmap_bundle plain = *bundle;
    char **set = rmap_alloc(bundle->options.n_set, sizeof *set);
    if (!set)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the scene's digest");
    plain.options.color = NULL;
    plain.options.set = set;
    plain.options.n_set = 0;
    for (size_t i = 0; i < bundle->options.n_set; i++)
        if (!sets_colour(bundle->options.set[i]))
            set[plain.options.n_set++] = bundle->options.set[i];
    enum rmap_status st = digest_bundle(&plain, text, err);
    rmap_free(set);
    return st;
}

static int32_t tracer_of(const struct rmap_run *run)
{
    return run->tracer_revision ? run->tracer_revision : RMAP_TRACER_REVISION;
}

enum rmap_status rmap_tracer_revision_read(struct rmap_h5 *h5, int32_t *revision_ret,
                                           struct rmap_error *err)
{
    *revision_ret = 1;
    return rmap_h5_get_if(h5, "/", "tracer_revision", RMAP_I32, 1, revision_ret, err);
}

enum rmap_status rmap_piece_origin_of(const struct rmap_run *run, struct rmap_piece_origin *origin,
                                      struct rmap_error *err)
{
    *origin = (struct rmap_piece_origin){.seed = run->seed,
                                         .tracer_revision = tracer_of(run),
                                         .encoding = (int32_t)run->encoding,
                                         .mode = (int32_t)run->scene->channels.mode,
                                         .n_channel = run->scene->channels.n};
    enum rmap_status st = digest_bundle(run->bundle, origin->space_digest, err);
    if (st == RMAP_OK && chooses_colour(&run->bundle->options))
        return digest_without_colour(run->bundle, origin->scene_digest, err);
    memcpy(origin->scene_digest, origin->space_digest, sizeof origin->scene_digest);
    return st;
}

static enum rmap_status put_versions(struct rmap_h5 *h5, const struct rmap_run *run,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char text[128];
    unsigned major = 0, minor = 0, release = 0;
    (void)H5get_libversion(&major, &minor, &release);
    (void)snprintf(text, sizeof text, "%u.%u.%u", major, minor, release);
    RMAP_TRY(rmap_h5_put_text(h5, "/", "hdf5_version", text, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "embree_version",
                              run->embree_version ? run->embree_version : "", err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "libdeflate_version", rmap_libdeflate_version(), err));
    unsigned xxhash = XXH_versionNumber();
    (void)snprintf(text, sizeof text, "%u.%u.%u", xxhash / 10000, xxhash / 100 % 100, xxhash % 100);
    RMAP_TRY(rmap_h5_put_text(h5, "/", "xxhash_version", text, err));
out:
    return st;
}

static enum rmap_status put_features(struct rmap_h5 *h5, const struct rmap_run *run,
                                     struct rmap_error *err)
{
    char text[160];
    (void)snprintf(text, sizeof text, "%s%s%s%s%s%s%s%s%s%s",
                   rmap_scene_keeps_curves(run->scene) ? RMAP_FEATURE_CURVES " " : "",
                   run->scene->timed ? RMAP_FEATURE_TIMES " " : "",
                   run->selection ? RMAP_FEATURE_GAPS " " : "",
                   run->scene->n_scatter > 0 ? RMAP_FEATURE_SCATTER " " : "",
                   rmap_scene_has_rough_metals(run->scene) ? RMAP_FEATURE_METALS " " : "",
                   rmap_scene_has_tinting_films(run->scene) ? RMAP_FEATURE_FILMS " " : "",
                   rmap_scene_is_turbid(run->scene) ? RMAP_FEATURE_TURBID " " : "",
                   rmap_scene_has_surfaces(run->scene) ? RMAP_FEATURE_SURFACES " " : "",
                   rmap_scene_has_uv(run->scene) ? RMAP_FEATURE_UV " " : "",
                   RMAP_FEATURE_PLACES " " RMAP_FEATURE_CLASSES " " RMAP_FEATURE_CODES
                                       " " RMAP_FEATURE_LENGTHS " " RMAP_FEATURE_ANGLES
                                       " " RMAP_FEATURE_ARRIVALS);
    return rmap_h5_put_text(h5, "/", "features", text, err);
}

/* The shared objects that gave gradient media their index: "medium xxh3:0123456789abcdef, ...". */
static enum rmap_status put_plugins(struct rmap_h5 *h5, const struct rmap_bundle *bundle,
                                    struct rmap_error *err)
{
    enum { EACH = 24 };
    size_t nbytes = 1, used = 0;
    if (!bundle || !bundle->n_plugin)
        return RMAP_OK;
    for (size_t i = 0; i < bundle->n_plugin; i++)
        nbytes += strlen(bundle->plugin[i].field) + EACH;
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of plug-ins");
    for (size_t i = 0; i < bundle->n_plugin; i++)
        used +=
            (size_t)snprintf(text + used, nbytes - used, "%s%s xxh3:%016llx", i ? ", " : "",
                             bundle->plugin[i].field, (unsigned long long)bundle->plugin[i].xxh3);
    enum rmap_status st = rmap_h5_put_text(h5, "/", "plugins", text, err);
    rmap_free(text);
    return st;
}

enum rmap_status rmap_provenance_put(struct rmap_h5 *h5, const char *filetype,
                                     const struct rmap_run *run,
                                     const struct rmap_piece_origin *origin, struct rmap_error *err)
{
    const int32_t version[2] = {RMAP_FORMAT_MAJOR, RMAP_FORMAT_MINOR}, tracer = tracer_of(run);
    const struct rmap_scene *scene = run->scene;
    const char *flux = rmap_flux_unit_name(scene);
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_h5_put_text(h5, "/", "filetype", filetype, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "version", RMAP_I32, 2, version, err));
    RMAP_TRY(put_features(h5, run, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "program_version", RMAP_VERSION, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "git_revision", RMAP_GIT_REVISION, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "compiler", RMAP_COMPILER, err));
    RMAP_TRY(put_versions(h5, run, err));
    RMAP_TRY(put_plugins(h5, run->bundle, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "isa", run->isa ? run->isa : "", err));
    RMAP_TRY(rmap_h5_put(h5, "/", "tracer_revision", RMAP_I32, 1, &tracer, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "seed", RMAP_U64, 1, &run->seed, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "scene_digest", origin->scene_digest, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "space_digest", origin->space_digest, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "length_unit", scene->unit, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "length_unitSI", RMAP_F64, 1, &scene->unit_m, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "flux_unit", flux, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "colour_space",
                              scene->channels.mode == RMAP_COLOUR_RGB ? "rgb" : "spectral", err));
    int32_t n_channel = scene->channels.n;
    RMAP_TRY(rmap_h5_put(h5, "/", "channels", RMAP_I32, 1, &n_channel, err));
out:
    return st;
}

enum { FEATURES_NBYTES = 512 };

/* A word of a list. */
static bool has_feature(const char *features, const char *name)
{
    const size_t n = strlen(name);
    for (const char *at = features; *at; at += strcspn(at, " ")) {
        at += strspn(at, " ");
        if (strcspn(at, " ") == n && strncmp(at, name, n) == 0)
            return true;
    }
    return false;
}

/* Names what a file needs and this program has not got. */
static enum rmap_status check_features(struct rmap_h5 *h5, struct rmap_error *err)
{
    static const char known[] =
        RMAP_FEATURE_CURVES " " RMAP_FEATURE_TIMES " " RMAP_FEATURE_GAPS " " RMAP_FEATURE_PLACES
                            " " RMAP_FEATURE_CLASSES " " RMAP_FEATURE_CODES " " RMAP_FEATURE_LENGTHS
                            " " RMAP_FEATURE_SCATTER " " RMAP_FEATURE_METALS " " RMAP_FEATURE_FILMS
                            " " RMAP_FEATURE_TURBID " " RMAP_FEATURE_SURFACES " " RMAP_FEATURE_UV
                            " " RMAP_FEATURE_ANGLES " " RMAP_FEATURE_ARRIVALS;
    char features[FEATURES_NBYTES];
    enum rmap_status st = rmap_h5_get_text(h5, "/", "features", features, sizeof features, err);
    char *rest = features, *name;
    while (st == RMAP_OK && (name = strtok_r(rest, " ", &rest)))
        if (!has_feature(known, name))
            st = rmap_error_set(
                err, RMAP_FORMAT,
                "%s needs '%s', which this program does not know: use a newer raymap", h5->path,
                name);
    return st;
}

enum rmap_status rmap_provenance_check(struct rmap_h5 *h5, const char *filetype,
                                       struct rmap_error *err)
{
    char text[64];
    int32_t version[2] = {0};
    if (rmap_h5_get_text(h5, "/", "filetype", text, sizeof text, NULL) != RMAP_OK ||
        strcmp(text, filetype) != 0 ||
        rmap_h5_get(h5, "/", "version", RMAP_I32, 2, version, NULL) != RMAP_OK)
        return rmap_error_set(err, RMAP_FORMAT,
                              "%s is an HDF5 file, but not a '%s': give the map's directory",
                              h5->path, filetype);
    if (version[0] < RMAP_FORMAT_OLDEST || version[0] > RMAP_FORMAT_MAJOR)
        return rmap_error_set(
            err, RMAP_FORMAT,
            "%s has format version %d.%d; this program reads %d.x to %d.x: use %s raymap", h5->path,
            (int)version[0], (int)version[1], RMAP_FORMAT_OLDEST, RMAP_FORMAT_MAJOR,
            version[0] > RMAP_FORMAT_MAJOR ? "a newer" : "an older");
    return version[0] < RMAP_FORMAT_MAJOR ? RMAP_OK : check_features(h5, err);
}

bool rmap_provenance_is_curved(struct rmap_h5 *h5)
{
    int32_t version[2] = {0};
    char features[FEATURES_NBYTES];
    if (rmap_h5_get(h5, "/", "version", RMAP_I32, 2, version, NULL) != RMAP_OK)
        return false;
    if (version[0] < RMAP_FORMAT_MAJOR)
        return version[0] == RMAP_FORMAT_CURVED;
    return rmap_h5_get_text(h5, "/", "features", features, sizeof features, NULL) == RMAP_OK &&
           has_feature(features, RMAP_FEATURE_CURVES);
}
