/* SPDX-License-Identifier: MIT
 *
 * raymap convert: the same map again, in another encoding or in pieces of another size.
 */
#include <string.h>

#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "io/map/map_reader.h"
#include "io/map/map_run.h"
#include "io/write/index_writer.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/copy_run.h"

static const struct rmap_option options[] = {
    {"output", 'o', "MAP2", "directory of the ray map to make, by custom NAME.raymap"},
    {"encoding", 0, "E", "plain or compact (default: that of MAP's first piece)",
     .words = "plain compact"},
    {"piece-size", 0, "BYTES",
     "close a file of the map that has so much to compress (default 512Mi)"},
    {"force", 'f', NULL, "replace a ray map that stands there", "output"},
    {NULL}};

struct request {
    const char *from, *to;
    uint64_t piece_nbytes;
    enum rmap_encoding encoding; /* RMAP_ENCODING_COUNT: not given */
    bool force;
};

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct request){.from = given->operand[0],
                                .to = rmap_argument(given, "output"),
                                .force = rmap_argument(given, "force") != NULL};
    RMAP_TRY(rmap_argument_count(given, "piece-size", &request->piece_nbytes, err));
    if (rmap_argument(given, "piece-size") && request->piece_nbytes == 0)
        return rmap_error_set(err, RMAP_USAGE, "--piece-size must be at least 1");
    RMAP_TRY(rmap_output_encoding(rmap_argument(given, "encoding"), &request->encoding, err));
    if (!request->to)
        return rmap_error_set(err, RMAP_USAGE, "where to? give -o MAP2");
    if (rmap_same_place(request->from, request->to))
        return rmap_error_set(err, RMAP_USAGE,
                              "%s is %s: a map cannot be converted in its own place; choose "
                              "another name",
                              request->to, request->from);
out:
    return st;
}

struct conversion {
    struct rmap_map_lock lock; /* rank 0: of the new map */
    struct rmap_map *map;
    struct rmap_map_summary before, after;
    enum rmap_encoding encoding;
    struct rmap_map_run run;         /* in the map's first colour space, for the index */
    struct rmap_map_content content; /* rank 0 */
    bool begins;                     /* rank 0: what stands at the new place is this run's */
    double begun;
};

/* Spaces, runs and origin are those of the old map. */
static enum rmap_status write_index(const struct request *request, struct conversion *self,
                                    const struct rmap_map_content *content,
                                    const struct rmap_tally *tally, bool complete,
                                    struct rmap_error *err)
{
    const struct rmap_index index = {.run = &self->run.run,
                                     .before = self->map,
                                     .content = content,
                                     .tally = tally,
                                     .complete = complete};
    return rmap_index_write_content(request->to, &index, err);
}

/* Collective. A map without rays: what is left when the conversion is killed. */
static enum rmap_status prepare(const struct rmap_context *context, const struct request *request,
                                struct conversion *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = self->map;
    rmap_map_summarise(map, &self->before);
    self->encoding = request->encoding;
    if (request->encoding == RMAP_ENCODING_COUNT)
        self->encoding = rmap_map_n_piece(map) > 0
                             ? (enum rmap_encoding)rmap_map_piece(map, 0)->encoding
                             : RMAP_ENCODING_PLAIN;
    if (context->rank != 0)
        return rmap_agree(context, RMAP_OK, err);
    RMAP_TRY(rmap_map_run_init(map, 0, self->encoding, &self->run, err));
    RMAP_TRY(rmap_map_create(request->to, request->force, "convert", &self->lock, err));
    self->begins = true;
    RMAP_TRY(write_index(request, self, NULL, NULL, false, err));
out:
    return rmap_agree(context, st, err);
}

static enum rmap_status summarise(const struct rmap_context *context, const struct request *request,
                                  const struct conversion *self, struct rmap_error *err)
{
    const struct rmap_map_summary *after = &self->after;
    const char *encoding = rmap_encoding_name(self->encoding);
    double seconds = rmap_clock_seconds() - self->begun;
    double n_segment = (double)after->n_row[RMAP_TABLE_SEGMENT];
    double per_segment = n_segment > 0 ? (double)after->nbytes / n_segment : 0.0;
    char digest[33];
    rmap_digest_text(after->digest, digest);
    if (context->json)
        return rmap_json_print(
            rmap_json_of_map(
                json_pack("{s:s, s:s, s:I, s:I, s:I, s:I, s:f, s:b, s:s, s:f}", "map", request->to,
                          "encoding", encoding, "rays", (json_int_t)after->n_row[RMAP_TABLE_RAY],
                          "segments", (json_int_t)after->n_row[RMAP_TABLE_SEGMENT], "bytes",
                          (json_int_t)after->nbytes, "bytes_before",
                          (json_int_t)self->before.nbytes, "bytes_per_segment", per_segment,
                          "complete", (int)after->complete, "digest", digest, "seconds", seconds),
                self->map),
            stdout, err);
    if (!context->quiet)
        printf("%s: %s, %s, %.1f MB (before: %.1f MB), %.2f bytes per segment, in %.2f s\n"
               "digest %s\n",
               request->to, rmap_counted(after->n_row[RMAP_TABLE_RAY], "ray").text, encoding,
               1e-6 * (double)after->nbytes, 1e-6 * (double)self->before.nbytes, per_segment,
               seconds, digest);
    return RMAP_OK;
}

/* Rank 0: the index, and that the rays are the same. */
static enum rmap_status conclude(const struct rmap_context *context, const struct request *request,
                                 struct conversion *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *made = NULL;
    RMAP_TRY(write_index(request, self, &self->content, rmap_map_tally(self->map),
                         self->before.complete, err));
    RMAP_TRY(rmap_map_open(request->to, &made, err));
    rmap_map_summarise(made, &self->after);
    if (memcmp(&self->after.digest, &self->before.digest, sizeof self->after.digest) != 0) {
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s holds other rays than its index says: nothing was made of it; see: "
                            "raymap verify %s",
                            request->from, request->from);
        goto out;
    }
    self->begins = false;
    RMAP_TRY(summarise(context, request, self, err));
out:
    rmap_map_close(made);
    return st;
}

static enum rmap_status run_convert(const struct rmap_context *context,
                                    const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct conversion self = {.begun = rmap_clock_seconds()};
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_map(context, request.from, &self.map, err));
    RMAP_TRY(prepare(context, &request, &self, err));
    const struct rmap_copy_plan plan = {.map = self.map,
                                        .to = request.to,
                                        .encoding = self.encoding,
                                        .piece_nbytes = request.piece_nbytes};
    RMAP_TRY(rmap_copy_run(context, &plan, &self.content, err));
    if (context->rank == 0)
        st = conclude(context, &request, &self, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    if (st != RMAP_OK && self.begins)
        rmap_discard_map(request.to, err);
    rmap_map_lock_release(&self.lock);
    rmap_map_run_fini(&self.run);
    rmap_map_content_fini(&self.content);
    rmap_map_close(self.map);
    return st;
}

const struct rmap_command rmap_command_convert = {
    .name = "convert",
    .summary = "write a map again in another encoding",
    .operands = "MAP -o MAP2 [--encoding E] [options]",
    .help =
        "Writes the rays of a map into a new one, bit by bit the same: its digest, energy balance\n"
        "and images do not change. The encoding 'plain' keeps every column as a dataset that any\n"
        "HDF5 tool reads; 'compact' takes a seventh to a hundredth of its bytes, with gradient\n"
        "media more. Runs on all ranks and threads.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_convert,
};
