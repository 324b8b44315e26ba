/* SPDX-License-Identifier: MIT
 *
 * raymap verify: whether every byte of a map is what was written.
 */
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "mpi/answer/unfinished_out.h"
#include "mpi/command/json_out.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/upkeep/verify_run.h"

static const struct rmap_option options[] = {{NULL}};

static json_t *finding_json(const struct rmap_finding *finding)
{
    json_t *one = json_pack(
        "{s:s, s:s, s:o, s:s}", "file", finding->file, "dataset", finding->dataset, "chunk",
        finding->chunk >= 0 ? json_integer(finding->chunk) : json_null(), "text", finding->text);
    json_t *ranges = json_array();
    int n = finding->n_range;
    for (int i = 0; i < n; i++)
        (void)json_array_append_new(ranges, json_pack("[I,I]", (json_int_t)finding->range[i][0],
                                                      (json_int_t)finding->range[i][1]));
    (void)json_object_set_new(one, "rays",
                              n > 0 ? json_pack("[I,I]", (json_int_t)finding->range[0][0],
                                                (json_int_t)finding->range[n - 1][1])
                                    : json_null());
    (void)json_object_set_new(one, "ray_ranges", ranges);
    (void)json_object_set_new(one, "ray_count", json_integer((json_int_t)finding->n_ray));
    (void)json_object_set_new(one, "rows",
                              finding->n_row > 0
                                  ? json_pack("[I,I]", (json_int_t)finding->first_row,
                                              (json_int_t)(finding->first_row + finding->n_row - 1))
                                  : json_null());
    return one;
}

/* As `info` says it: rays of a piece that is gone are missing, whatever the index says. */
static bool is_complete(const struct rmap_verification *verification)
{
    struct rmap_map_summary summary = {0};
    if (verification->map)
        rmap_map_summarise(verification->map, &summary);
    for (size_t i = 0; i < verification->content->n_piece; i++)
        summary.complete = summary.complete && !(verification->piece_flag[i] & RMAP_PIECE_GONE);
    return summary.complete;
}

static json_t *to_json(const struct rmap_findings *findings, const struct rmap_verified *verified,
                       const struct rmap_verification *verification)
{
    json_t *list = json_array();
    for (size_t i = 0; i < findings->n; i++)
        (void)json_array_append_new(list, finding_json(&findings->row[i]));
    json_t *document =
        json_pack("{s:b, s:b, s:o, s:{s:I, s:I, s:I, s:I, s:I, s:I}, s:f}", "ok", findings->n == 0,
                  "complete", (int)is_complete(verification), "findings", list, "checked", "pieces",
                  (json_int_t)verified->pieces, "chunks", (json_int_t)verified->chunks, "portions",
                  (json_int_t)verified->portions, "rays", (json_int_t)verified->rays, "segments",
                  (json_int_t)verified->segments, "bytes", (json_int_t)verified->bytes, "seconds",
                  verified->seconds);
    document = verification->map ? rmap_json_of_map(document, verification->map) : document;
    if (document) /* without the pieces that are gone */
        (void)json_object_set_new(document, "complete", json_boolean(is_complete(verification)));
    return document;
}

static void print_finding(const struct rmap_finding *finding, FILE *out)
{
    char count[RMAP_GROUPED_LEN];
    fprintf(out, "%s", finding->file);
    if (finding->dataset[0])
        fprintf(out, ": %s", finding->dataset);
    if (finding->chunk >= 0)
        fprintf(out, " chunk %lld", (long long)finding->chunk);
    if (finding->n_row > 0)
        fprintf(out, " (rows %llu to %llu)", (unsigned long long)finding->first_row,
                (unsigned long long)(finding->first_row + finding->n_row - 1));
    fprintf(out, ": %s\n", finding->text);
    for (int i = 0; i < finding->n_range; i++)
        fprintf(out, "%s%llu-%llu", i == 0 ? "    rays " : ", ",
                (unsigned long long)finding->range[i][0], (unsigned long long)finding->range[i][1]);
    if (finding->n_range > 0)
        fprintf(out, " (%s)\n", rmap_grouped(finding->n_ray, count));
}

static void print_text(const char *path, const struct rmap_findings *findings,
                       const struct rmap_verified *verified,
                       const struct rmap_verification *verification, FILE *out)
{
    struct rmap_map_summary summary = {0};
    for (size_t i = 0; i < findings->n; i++)
        print_finding(&findings->row[i], out);
    if (verification->map)
        rmap_map_summarise(verification->map, &summary);
    fprintf(out, "%s: %s in %s, %s, %s, %s, %.1f MB%s\n", path,
            rmap_counted(findings->n, "finding").text, rmap_counted(verified->pieces, "piece").text,
            rmap_counted(verified->chunks, "chunk").text, rmap_counted(verified->rays, "ray").text,
            rmap_counted(verified->segments, "segment").text, 1e-6 * (double)verified->bytes,
            !verification->map       ? "; rays were not decoded: the index is unusable"
            : summary.complete       ? ""
            : rmap_map_is_live(path) ? "; not complete: it is being traced"
                                     : "; not complete: rays that were asked for are missing");
}

static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             const struct rmap_findings *findings,
                             const struct rmap_verified *verified,
                             const struct rmap_verification *verification, struct rmap_error *err)
{
    struct rmap_findings left = {0};
    enum rmap_status st = rmap_map_note_unfinished(path, &left, err);
    if (st == RMAP_OK && context->json) {
        json_t *document = to_json(findings, verified, verification);
        if (document)
            (void)json_object_set_new(document, "unfinished", rmap_unfinished_json(&left));
        st = rmap_json_print(document, stdout, err);
    } else if (st == RMAP_OK && (!context->quiet || findings->n > 0)) {
        rmap_unfinished_print(&left, stdout);
        print_text(path, findings, verified, verification, stdout);
    }
    rmap_findings_fini(&left);
    if (!context->json && !context->quiet)
        fprintf(stderr, "%.2f s\n", verified->seconds);
    if (st == RMAP_OK && findings->n > 0)
        st = rmap_error_set(err, RMAP_FORMAT, "%s is damaged in %s; see: raymap repair --help",
                            path, rmap_counted(findings->n, "place").text);
    return st;
}

static enum rmap_status run_verify(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    const char *path = given->operand[0];
    struct rmap_verify_result result = {0};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_verify_run(context, path, &result, err));
    if (context->rank == 0)
        st = tell(context, path, &result.findings, &result.verified, result.verification, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_verify_result_fini(&result);
    return st;
}

const struct rmap_command rmap_command_verify = {
    .name = "verify",
    .summary = "check that every byte of a map is what was written",
    .operands = "MAP",
    .help = "Checks every file, table, stored chunk and ray of a map: sizes, seals, checksums, "
            "counts,\n"
            "digests, energy balance and images. Goes on after a finding, and names for each the "
            "file,\n"
            "the dataset, the chunk and the rays that it hits. Runs on all ranks and threads; the\n"
            "findings are the same for any number of them. Exit status 4 when there are some.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_verify,
};
