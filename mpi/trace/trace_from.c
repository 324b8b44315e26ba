/* SPDX-License-Identifier: MIT
 *
 * `raymap trace --from`: an older map, of another version of the scene.
 */
#include "mpi/trace/trace_from.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/map/map_rays.h"
#include "mpi/parallel/agree.h"
#include "trace/tracer_revision.h"

/* Reading and encoding what is kept costs about as much as tracing a third of it. */
static const double most_touched = 0.5;

static enum rmap_status check_other(const char *from, const char *to, struct rmap_error *err)
{
    struct stat a, b;
    if (!to || stat(from, &a) != 0 || stat(to, &b) != 0)
        return RMAP_OK;
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino
               ? rmap_error_set(err, RMAP_USAGE,
                                "%s cannot be made from itself: give the new map another name "
                                "(-o)",
                                from)
               : RMAP_OK;
}

static enum rmap_status check_map(const struct rmap_trace_from *from,
                                  const struct rmap_trace_request *request, struct rmap_error *err)
{
    const char *path = request->from_path;
    if (rmap_map_selection(from->map))
        return rmap_error_set(err, RMAP_INPUT,
                              "--from: %s holds rays that a query picked (raymap info says which): "
                              "give the map that was asked",
                              path);
    if (from->summary.tracer_revision != RMAP_TRACER_REVISION)
        return rmap_error_set(err, RMAP_INPUT,
                              "--from: %s has rays of tracer revision %d, and this program's are "
                              "of %d, which makes others of the same scene: leave out --from",
                              path, (int)from->summary.tracer_revision, RMAP_TRACER_REVISION);
    if (request->has_seed && request->seed != from->summary.seed)
        return rmap_error_set(err, RMAP_USAGE,
                              "--from: %s was traced with seed %llu, not %llu: no ray of it is one "
                              "of the new map",
                              path, (unsigned long long)from->summary.seed,
                              (unsigned long long)request->seed);
    return RMAP_OK;
}

/* What the command line leaves open. */
static enum rmap_status adopt(const struct rmap_trace_from *from,
                              struct rmap_trace_request *request, struct rmap_error *err)
{
    struct rmap_ray_set wanted = {0};
    enum rmap_status st = rmap_rays_wanted(from->map, &wanted, err);
    if (st != RMAP_OK)
        return st;
    const bool one = wanted.n == 1;
    if (one && !request->has_n_ray) {
        request->n_of_parent = wanted.range[0].end - wanted.range[0].first;
        if (!request->has_first_ray)
            request->first_ray = wanted.range[0].first;
    }
    rmap_ray_set_fini(&wanted);
    if (!one && !request->has_n_ray && request->mode == RMAP_TRACE_NEW)
        return rmap_error_set(err, RMAP_USAGE,
                              "--from: %s was not asked for one run of rays after the other: say "
                              "how many are wanted (-n, --first-ray)",
                              request->from_path);
    if (!request->has_seed)
        request->seed = from->summary.seed;
    if (!request->has_encoding && rmap_map_n_piece(from->map) > 0)
        request->encoding = (enum rmap_encoding)rmap_map_piece(from->map, 0)->encoding;
    return RMAP_OK;
}

enum rmap_status rmap_trace_from_open(const struct rmap_context *context,
                                      struct rmap_trace_request *request,
                                      struct rmap_trace_from *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!request->from_path)
        return RMAP_OK;
    if (context->rank == 0)
        st = check_other(request->from_path, request->map_path, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_map(context, request->from_path, &from->map, err));
    rmap_map_summarise(from->map, &from->summary);
    rmap_digest_text(from->summary.digest, from->digest);
    st = check_map(from, request, err);
    if (st == RMAP_OK)
        st = adopt(from, request, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* The colour space of the map that light of the scene is described in; -1: none. */
static int32_t space_of(const struct rmap_map *map, const struct rmap_channels *channels)
{
    for (size_t i = 0; i < rmap_map_n_space(map); i++) {
        const struct rmap_channels *its = &rmap_map_scene_of(map, i)->channels;
        if (its->mode == channels->mode && its->n == channels->n &&
            memcmp(its->wavelength_nm, channels->wavelength_nm,
                   (size_t)channels->n * sizeof *channels->wavelength_nm) == 0)
            return (int32_t)i;
    }
    return -1;
}

/* Rank 0. Rays of other spaces are no rays of the new map. */
static void tell_other_spaces(const struct rmap_context *context, struct rmap_trace_from *from,
                              int32_t space)
{
    for (size_t i = 0; i < rmap_map_n_portion(from->map); i++)
        if (rmap_map_portion(from->map, i)->space != space)
            from->n_other += rmap_map_portion(from->map, i)->n_row[RMAP_TABLE_RAY];
    if (from->n_other > 0 && !context->quiet)
        fprintf(stderr,
                "raymap: --from: %s of the map in another colour space than the scene's, in which "
                "the new map has all of its own\n",
                rmap_counted(from->n_other, "ray").text);
}

/* Rank 0. */
static enum rmap_status look(struct rmap_trace_from *from, struct rmap_error *err)
{
    double share = 0.0;
    const enum rmap_status st = rmap_reuse_estimate(&from->reuse, &share, err);
    from->in_use = st == RMAP_OK && share <= most_touched;
    if (st == RMAP_OK && !from->in_use)
        (void)snprintf(from->all, sizeof from->all,
                       "about %.0f %% of them come to what has changed", 100.0 * share);
    return st;
}

enum rmap_status rmap_trace_from_decide(const struct rmap_context *context,
                                        struct rmap_trace_from *from,
                                        const struct rmap_scene *scene, const char *isa,
                                        uint64_t seed, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!from->map)
        return RMAP_OK;
    const int32_t space = space_of(from->map, &scene->channels);
    if (context->rank == 0)
        tell_other_spaces(context, from, space);
    if (strcmp(isa, from->summary.isa) != 0)
        (void)snprintf(from->all, sizeof from->all, "they were traced with %s, which is not here",
                       from->summary.isa);
    else if (seed != from->summary.seed)
        (void)snprintf(from->all, sizeof from->all, "they were traced with another seed");
    else
        st = rmap_reuse_init(&from->reuse, from->map, space < 0 ? 0 : space, scene, err);
    if (st == RMAP_OK && from->reuse.touch.change.all[0])
        (void)snprintf(from->all, sizeof from->all, "%s", from->reuse.touch.change.all);
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank == 0 && !from->all[0])
        st = look(from, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&from->in_use, 1, MPI_C_BOOL, 0, context->comm)));
    if (context->rank == 0 && !from->in_use && !context->quiet)
        fprintf(stderr, "raymap: --from: all rays are traced anew: %s\n", from->all);
out:
    return st;
}

void rmap_trace_from_fini(struct rmap_trace_from *from)
{
    rmap_reuse_fini(&from->reuse);
    rmap_map_close(from->map);
    *from = (struct rmap_trace_from){.map = NULL};
}
