/* SPDX-License-Identifier: MIT
 *
 * What `raymap query` is asked for.
 */
#include "mpi/answer/query_request.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/answer/query_map_out.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/output.h"

/* Which and how many rays are listed. */
static enum rmap_status read_selection(const struct rmap_arguments *given,
                                       struct rmap_query_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *limit = rmap_argument(given, "limit"), *sample = rmap_argument(given, "sample");
    request->sample = (struct rmap_sample_order){.by_hash = true, .seed = 1};
    RMAP_TRY(rmap_argument_count(given, "limit", &request->limit, err));
    RMAP_TRY(rmap_argument_count(given, "sample", &request->sample.most, err));
    RMAP_TRY(rmap_argument_count(given, "seed", &request->sample.seed, err));
    RMAP_TRY(rmap_argument_count(given, "top", &request->top, err));
    if (rmap_argument(given, "top") && (limit || sample))
        st = rmap_error_set(err, RMAP_USAGE,
                            "--top, --limit and --sample each say which rays: give one");
    else if (rmap_argument(given, "top") && (request->top == 0 || !request->of))
        st = rmap_error_set(err, RMAP_USAGE,
                            request->of ? "--top 0 lists nothing; ask for at least one ray"
                                        : "--top lists the greatest values of a number: name it, "
                                          "--of path_length");
    else if (limit && sample)
        st = rmap_error_set(err, RMAP_USAGE,
                            "--limit takes the first rays, --sample any of them: give one");
    else if ((limit && request->limit == 0) || (sample && request->sample.most == 0))
        st = rmap_error_set(err, RMAP_USAGE, "%s 0 lists nothing; ask for at least one ray",
                            limit ? "--limit" : "--sample");
    else if (rmap_argument(given, "seed") && !sample)
        st = rmap_error_set(err, RMAP_USAGE, "--seed is that of --sample N; give both");
out:
    return st;
}

enum rmap_status rmap_query_request_read(const struct rmap_arguments *given,
                                         struct rmap_query_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct rmap_query_request){
        .map_path = given->operand[0],
        .output_path = rmap_argument(given, "output"),
        .columns = rmap_argument(given, "columns"),
        .at = rmap_argument(given, "at"),
        .of = rmap_argument(given, "of"),
        .limit = UINT64_MAX,
        .deal = rmap_argument(given, "local") ? RMAP_DEAL_LOCAL : RMAP_DEAL_TURNS,
        .explain = rmap_argument(given, "explain") != NULL,
        .force = rmap_argument(given, "force") != NULL,
    };
    RMAP_TRY(read_selection(given, request, err));
    bool list = request->output_path || rmap_argument(given, "limit") || request->sample.most > 0 ||
                request->top > 0;
    request->count = rmap_argument(given, "count") || !list;
    if (list && rmap_argument(given, "count"))
        return rmap_error_set(err, RMAP_USAGE,
                              "--count adds up all matching rays; it goes with none of --limit, "
                              "--sample, --top and -o");
    RMAP_TRY(
        rmap_stats_by_read(rmap_argument(given, "by"), RMAP_STATS_BY_CRITERION, &request->by, err));
    if (request->by >= RMAP_STATS_BY_PATH)
        return rmap_error_set(err, RMAP_USAGE,
                              "--by path: `raymap paths` counts the rays of classes of paths");
    if (request->by == RMAP_STATS_BY_CRITERION)
        return rmap_error_set(err, RMAP_USAGE,
                              "--by criterion: several criteria are counted each by itself anyway");
    if (request->by != RMAP_STATS_TOGETHER && (list || request->explain))
        return rmap_error_set(err, RMAP_USAGE,
                              "--by is of counts: it goes with none of --limit, --sample, --top, "
                              "-o and --explain");
    RMAP_TRY(rmap_until_read(given, &request->until, err));
    if (request->until.part.relative > 0.0 &&
        (list || request->explain || rmap_argument(given, "receivers")))
        return rmap_error_set(err, RMAP_USAGE,
                              "--until is of counts: it goes with none of --limit, --sample, "
                              "--top, -o, --explain and --receivers");
    request->map = request->output_path && rmap_map_answer_is(request->output_path);
    RMAP_TRY(rmap_output_encoding(rmap_argument(given, "encoding"), &request->encoding, err));
    if (request->encoding != RMAP_ENCODING_COUNT && !request->map)
        return rmap_error_set(err, RMAP_USAGE, "--encoding is that of a ray map: -o OUT.raymap");
    if (request->columns &&
        (!request->output_path || !rmap_query_rays_are_tables(request->output_path)))
        return rmap_error_set(err, RMAP_USAGE, "--columns are those of tables: -o OUT.h5");
    if (request->at && (!request->output_path || !rmap_query_rays_are_files(request->output_path)))
        return rmap_error_set(err, RMAP_USAGE,
                              "--at is of files of rays: -o OUT.tm25ray or OUT.mcpl");
    if (rmap_argument(given, "receivers") && request->explain)
        return rmap_error_set(
            err, RMAP_USAGE,
            "--explain tells what the map's own columns and indexes decide; with "
            "--receivers all segments of portions that may match are read: leave one "
            "of them out");
    if (request->output_path && !request->map)
        RMAP_TRY(rmap_query_rays_check(request->output_path, request->force, err));
out:
    return st;
}

/* Those that stand by themselves, then those of --where. */
static enum rmap_status list_criteria(const struct rmap_arguments *given, const char ***text_ret,
                                      size_t *n_ret, struct rmap_error *err)
{
    const char **text = rmap_alloc((size_t)given->n_operand + given->n_value, sizeof *text);
    size_t n = 0;
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
    for (int i = 1; i < given->n_operand; i++)
        text[n++] = given->operand[i];
    for (size_t i = 0; i < given->n_value; i++)
        if (strcmp(given->value[i].option->name, "where") == 0)
            text[n++] = given->value[i].text;
    *text_ret = text;
    *n_ret = n;
    return RMAP_OK;
}

enum rmap_status rmap_query_request_criteria(const struct rmap_context *context,
                                             const struct rmap_arguments *given,
                                             struct rmap_query_request *request,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_asked *asked = &request->asked;
    size_t n = 0;
    request->listed = rmap_argument(given, "criteria") != NULL;
    RMAP_TRY(list_criteria(given, &request->text, &n, err));
    RMAP_TRY(rmap_asked_load(context, given, request->text, n, asked, err));
    rmap_asked_take_file(asked);
    if (asked->n == 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "a criterion is missing; usage: raymap query MAP CRITERION... (or "
                              "--criteria FILE); see: raymap query --help");
    if (!request->count && asked->n > 1)
        st = rmap_error_set(err, RMAP_USAGE,
                            "--limit, --sample, --top and -o take one criterion; join several "
                            "with 'or'");
out:
    return st;
}

void rmap_query_request_fini(struct rmap_query_request *request)
{
    rmap_asked_fini(&request->asked);
    rmap_free(request->text);
}
