/* SPDX-License-Identifier: MIT
 *
 * raymap merge: maps of one scene with different rays as one map.
 */
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "io/map/map_reader.h"
#include "io/map/map_writer.h"
#include "io/recovery/merge.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"

static const struct rmap_option options[] = {
    {"output", 'o', "MAP2", "directory of the ray map to make, by custom NAME.raymap"},
    {"force", 'f', NULL, "replace a ray map that stands there", "output"},
    {NULL}};

static enum rmap_status check_request(const struct rmap_arguments *given, const char *to,
                                      struct rmap_error *err)
{
    struct stat target, input;
    if (!to)
        return rmap_error_set(err, RMAP_USAGE, "where to? give -o MAP2");
    if (stat(to, &target) != 0)
        return RMAP_OK;
    for (int i = 0; i < given->n_operand; i++)
        if (stat(given->operand[i], &input) == 0 && input.st_dev == target.st_dev &&
            input.st_ino == target.st_ino)
            return rmap_error_set(err, RMAP_USAGE,
                                  "%s is one of the maps to be merged; choose another name", to);
    return RMAP_OK;
}

static enum rmap_status open_all(const struct rmap_arguments *given,
                                 struct rmap_merge_source **source_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = (size_t)given->n_operand;
    struct rmap_merge_source *source = rmap_alloc(n, sizeof *source);
    *source_ret = source;
    if (!source)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        source[i].path = given->operand[i];
        st = rmap_map_open(source[i].path, &source[i].map, err);
    }
    return st;
}

static enum rmap_status summarise(const struct rmap_context *context, const char *to,
                                  size_t n_symbolic, double begun, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary;
    char digest[33];
    enum rmap_status st = rmap_map_open(to, &map, err);
    if (st != RMAP_OK)
        return st;
    rmap_map_summarise(map, &summary);
    rmap_digest_text(summary.digest, digest);
    double seconds = rmap_clock_seconds() - begun;
    if (context->json)
        st = rmap_json_print(
            rmap_json_of_map(json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:b, s:s, s:f}", "map", to,
                                       "rays", (json_int_t)summary.n_row[RMAP_TABLE_RAY],
                                       "segments", (json_int_t)summary.n_row[RMAP_TABLE_SEGMENT],
                                       "bytes", (json_int_t)summary.nbytes, "pieces",
                                       (json_int_t)rmap_map_n_piece(map), "symbolic_links",
                                       (json_int_t)n_symbolic, "complete", (int)summary.complete,
                                       "digest", digest, "seconds", seconds),
                             map),
            stdout, err);
    else if (!context->quiet)
        printf("%s: %s in %s, %s, digest %s\n", to,
               rmap_counted(summary.n_row[RMAP_TABLE_RAY], "ray").text,
               rmap_counted(rmap_map_n_piece(map), "piece").text,
               summary.complete ? "complete" : "not complete", digest);
    if (n_symbolic > 0 && !context->quiet)
        fprintf(stderr,
                "raymap: %s %s on another file system: symbolic links, so keep the maps "
                "where they are\n",
                rmap_counted(n_symbolic, "piece").text, n_symbolic == 1 ? "lies" : "lie");
    rmap_map_close(map);
    return st;
}

/* Rank 0 does it: no ray is read. */
static enum rmap_status merge(const struct rmap_context *context,
                              const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_lock lock = {0};
    struct rmap_merge_source *source = NULL;
    const char *to = rmap_argument(given, "output");
    size_t n = (size_t)given->n_operand, n_symbolic = 0;
    double begun = rmap_clock_seconds();
    bool begins = false;
    RMAP_TRY(check_request(given, to, err));
    RMAP_TRY(open_all(given, &source, err));
    RMAP_TRY(rmap_merge_check(source, n, err));
    RMAP_TRY(rmap_map_create(to, rmap_argument(given, "force") != NULL, "merge", &lock, err));
    begins = true;
    RMAP_TRY(rmap_merge(source, n, to, &n_symbolic, err));
    begins = false;
    RMAP_TRY(summarise(context, to, n_symbolic, begun, err));
out:
    if (st != RMAP_OK && begins)
        rmap_discard_map(to, err);
    rmap_map_lock_release(&lock);
    for (size_t i = 0; source && i < n; i++)
        rmap_map_close(source[i].map);
    rmap_free(source);
    return st;
}

static enum rmap_status run_merge(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = context->rank == 0 ? merge(context, given, err) : RMAP_OK;
    return rmap_agree_patiently(context, st, err);
}

const struct rmap_command rmap_command_merge = {
    .name = "merge",
    .summary = "make one map of several of the same scene",
    .operands = "MAP... -o MAP2",
    .help =
        "Makes one map of maps of the same scene and seed that hold different rays, such as those\n"
        "of an array of jobs with --first-ray. Pieces are linked, not copied: the new map takes\n"
        "hardly any room, and stays whole when the old ones are removed (unless they lie on\n"
        "another file system, which is told). Maps that share rays are refused.",
    .options = options,
    .min_operands = 1,
    .max_operands = 100000,
    .run = run_merge,
};
