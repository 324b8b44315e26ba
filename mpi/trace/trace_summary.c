/* SPDX-License-Identifier: MIT
 *
 * What `raymap trace` says when it is done.
 */
#include "mpi/trace/trace_summary.h"

#include "base/grouped.h"
#include "mpi/command/balance.h"
#include "mpi/command/json_out.h"
#include "mpi/command/mismatch.h"
#include "mpi/parallel/progress.h"

struct summary {
    const struct rmap_context *context;
    const struct rmap_trace_report *report;
    double segments, mean_path, rate;
    double errors;
    char error_text[RMAP_ERROR_TEXT_LEN];
};

static void print_text(const struct summary *summary, FILE *out)
{
    const struct rmap_trace_outcome *outcome = summary->report->outcome;
    char rate[RMAP_GROUPED_LEN];
    if (outcome->n_wanted > 0)
        fprintf(out, "%s in %.2f s: %s rays/s (ranks: %d, threads: %d)\n",
                rmap_counted(outcome->n_ray, "ray").text, outcome->seconds,
                rmap_grouped((uint64_t)summary->rate, rate), summary->context->size,
                outcome->n_thread);
    if (summary->report->n_held > 0)
        fprintf(out, "%s that the map held already\n",
                rmap_counted(summary->report->n_held, "ray").text);
    if (summary->report->from && summary->report->from->in_use)
        fprintf(out, "%s taken over from %s (digest %s), %s traced anew\n",
                rmap_counted(outcome->n_reused, "ray").text, summary->report->from_path,
                summary->report->from->digest,
                rmap_grouped(outcome->n_ray - outcome->n_reused, rate));
    fprintf(out, "%s, %.2f per ray\n", rmap_counted((uint64_t)summary->segments, "segment").text,
            summary->mean_path);
    if (summary->report->map_path) {
        const char *encodings = rmap_map_content_encodings(summary->report->content);
        const double nbytes = (double)summary->report->map_nbytes;
        char digest[33];
        rmap_digest_text(summary->report->content->digest, digest);
        fprintf(out, "%s: %s%s%.1f MB, %.2f bytes per segment, digest %s\n",
                summary->report->map_path, encodings, *encodings ? ", " : "", 1e-6 * nbytes,
                summary->segments > 0 ? nbytes / summary->segments : 0.0, digest);
    }
    fputs("energy balance\n", out);
    rmap_balance_print(outcome->tally, NULL, out);
    rmap_balance_print_detectors(outcome->tally, out);
}

/* What became of the rays of an older map. */
static json_t *from_json(const struct rmap_trace_report *report)
{
    const struct rmap_trace_from *from = report->from;
    return json_pack("{s:s, s:s, s:I, s:I, s:s?, s:I}", "map", report->from_path, "digest",
                     from->digest, "reused", (json_int_t)report->outcome->n_reused, "traced",
                     (json_int_t)(report->outcome->n_ray - report->outcome->n_reused), "all_anew",
                     from->all[0] ? from->all : NULL, "other_spaces", (json_int_t)from->n_other);
}

static json_t *to_json(const struct summary *summary)
{
    const struct rmap_trace_outcome *outcome = summary->report->outcome;
    json_t *document = json_pack(
        "{s:s?, s:I, s:I, s:I, s:f, s:f, s:f, s:f, s:b, s:I, s:I, s:i, s:i, s:I}", "map",
        summary->report->map_path, "rays", (json_int_t)(summary->report->n_held + outcome->n_ray),
        "traced", (json_int_t)outcome->n_ray, "segments", (json_int_t)summary->segments,
        "mean_path", summary->mean_path, "seconds", outcome->seconds, "seconds_until_tracing",
        summary->report->until_tracing, "rays_per_second", summary->rate, "complete",
        outcome->n_ray == outcome->n_wanted, "rays_asked",
        (json_int_t)(summary->report->n_held + outcome->n_wanted), "rays_traced",
        (json_int_t)(summary->report->n_held + outcome->n_ray), "ranks", summary->context->size,
        "threads", outcome->n_thread, "seed", (json_int_t)summary->report->plan->seed);
    if (summary->report->map_path) {
        const struct rmap_map_content *content = summary->report->content;
        const uint64_t nbytes = summary->report->map_nbytes;
        char digest[33];
        rmap_digest_text(content->digest, digest);
        (void)json_object_set_new(document, "encoding",
                                  json_string(rmap_map_content_encodings(content)));
        (void)json_object_set_new(document, "bytes", json_integer((json_int_t)nbytes));
        (void)json_object_set_new(document, "bytes_per_segment",
                                  rmap_json_number((double)nbytes / summary->segments));
        (void)json_object_set_new(document, "digest", json_string(digest));
    }
    if (summary->report->from)
        (void)json_object_set_new(document, "from", from_json(summary->report));
    (void)json_object_set_new(document, "sources", rmap_balance_json(outcome->tally, NULL));
    (void)json_object_set_new(document, "detectors", rmap_balance_detectors_json(outcome->tally));
    if (summary->errors > 0)
        (void)json_object_set_new(document, "first_error",
                                  json_pack("{s:I, s:s}", "ray",
                                            (json_int_t)outcome->tally->first_error_ray, "text",
                                            summary->error_text));
    return document;
}

static void find_errors(struct summary *summary)
{
    const struct rmap_tally *tally = summary->report->outcome->tally;
    for (size_t s = 0; s < tally->scene->n_source; s++)
        summary->errors += tally->error[s];
    if (summary->errors <= 0.0)
        return;
    struct rmap_tracer tracer = {.scene = summary->report->plan->scene,
                                 .accel = summary->report->plan->accel,
                                 .seed = summary->report->plan->seed};
    rmap_mismatch_describe(&tracer, tally->first_error_ray, summary->error_text,
                           sizeof summary->error_text);
    fprintf(stderr, "raymap: %s ended in an error; the first is ray %llu: %s\n",
            rmap_counted((uint64_t)summary->errors, "ray").text,
            (unsigned long long)tally->first_error_ray, summary->error_text);
}

/* Light that never came out of a body again: its surface has a gap. */
static void tell_left_inside(const struct rmap_tally *tally)
{
    const struct rmap_scene *scene = tally->scene;
    const int32_t around = rmap_scene_surrounding_medium(scene);
    for (size_t m = 0; m < scene->n_medium; m++)
        if (tally->left_elsewhere[m] > 0.0 && (int32_t)m != around && !scene->medium[m].field)
            fprintf(stderr,
                    "raymap: %s left the scene inside a body, in '%s': close it there, as with an "
                    "edge, unless that medium fills the surroundings; raymap check tells where\n",
                    rmap_counted((uint64_t)tally->left_elsewhere[m], "ray").text,
                    scene->medium[m].name);
}

enum rmap_status rmap_trace_summarise(const struct rmap_context *context,
                                      const struct rmap_trace_report *report,
                                      struct rmap_error *err)
{
    const struct rmap_trace_outcome *outcome = report->outcome;
    struct summary summary = {
        .context = context, .report = report, .segments = outcome->tally->segments[0]};
    double in_map = (double)(report->n_held + outcome->n_ray);
    summary.mean_path = in_map > 0.0 ? summary.segments / in_map : 0.0;
    summary.rate = outcome->seconds > 0 ? (double)outcome->n_ray / outcome->seconds : 0.0;
    find_errors(&summary);
    tell_left_inside(outcome->tally);
    if (context->json)
        return rmap_json_print(to_json(&summary), stdout, err);
    if (!context->quiet || !report->map_path) /* or else the map is the result */
        print_text(&summary, stdout);
    return RMAP_OK;
}
