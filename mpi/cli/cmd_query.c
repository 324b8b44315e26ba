/* SPDX-License-Identifier: MIT
 *
 * raymap query: the rays of a map that match a criterion, counted, listed or exported.
 */
#include <stdio.h>

#include "analysis/report/ray_table.h"
#include "base/alloc.h"
#include "mpi/answer/query_count_out.h"
#include "mpi/answer/query_map_out.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/answer/query_request.h"
#include "mpi/answer/query_top_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/load.h"
#include "mpi/command/overlay_load.h"
#include "mpi/command/until.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/overlay_pick.h"
#include "mpi/scan/ray_sample.h"
#include "mpi/scan/scan.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION" RMAP_ARGUMENT_AGAIN, "a CRITERION as other commands are given it"},
    {"count", 'c', NULL, "rays, segments and flux that match (the default)"},
    {"limit", 'l', "N", "list the N matching rays with the smallest ids"},
    {"sample", 's', "N", "list N matching rays picked at random; --seed picks others"},
    {"top", 0, "N", "list the N matching rays with the greatest values of --of"},
    {"of", 0, "Q", "a number of the ray or its registrations, as of `raymap stats`", "top"},
    {"seed", 0, "S", "of --sample (default 1): the same seed picks the same rays"},
    {"output", 'o', "OUT",
     "write the matching rays: OUT.csv, OUT.json, OUT.h5, OUT.vtp, OUT.tm25ray, OUT.mcpl, or "
     "OUT.raymap, a ray map"},
    {"at", 0, "DETECTOR",
     "of OUT.tm25ray and OUT.mcpl: rays as this plane registered them (default: as they end)"},
    {"columns", 0, "LIST",
     "of OUT.h5: ray, segment, registration, or columns of them, registration/x,ray/flux"},
    {"encoding", 0, "E", "of OUT.raymap: plain or compact (default: that of MAP's first piece)",
     .words = "plain compact"},
    {"local", 0, NULL,
     "rank R reads the shards R, R + ranks, ...: for shards on disks of the nodes"},
    {"by", 0, "WHAT",
     "count each by itself: source, detector, object (met last), ended, ghost_order, "
     "scatter_order, event",
     .words = "source detector object ended ghost_order scatter_order event"},
    RMAP_UNTIL_OPTION,
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    {"explain", 'e', NULL, "say what would be read; read nothing"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

struct search {
    struct rmap_map *map;
    struct rmap_overlay *overlay;            /* receivers, or NULL */
    struct rmap_criterion **criterion;       /* [n_criterion] */
    struct rmap_count *count;                /* [n_criterion] */
    struct rmap_registered_list *registered; /* [n_criterion] */
    struct rmap_ray_groups *groups;          /* [n_criterion] */
    uint64_t *id;                            /* [n_id] of a sample */
    size_t n_id;
    struct rmap_quantities *of;  /* of --top, or NULL */
    struct rmap_which *which;    /* registrations that it is of, or NULL: all */
    rmap_column_set columns;     /* read of rays that match; 0: all */
    struct rmap_sample_ray *top; /* [n_top], the greatest first */
    size_t n_top;
};

static enum rmap_status compile(const struct rmap_context *context,
                                struct rmap_query_request *request, struct search *search,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(search->map, search->overlay);
    search->criterion = rmap_alloc(request->asked.n, sizeof(void *));
    search->count = rmap_alloc(request->asked.n, sizeof *search->count);
    search->registered = rmap_alloc(request->asked.n, sizeof *search->registered);
    search->groups = rmap_alloc(request->asked.n, sizeof *search->groups);
    if (!search->criterion || !search->count || !search->registered || !search->groups)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria"));
    for (size_t c = 0; c < request->asked.n; c++) {
        RMAP_TRY(
            rmap_asked_compile(context, &request->asked, c, scene, &search->criterion[c], err));
        RMAP_TRY(rmap_count_init(&search->count[c], scene->n_source, err));
    }
out:
    return st;
}

static void release(const struct rmap_query_request *request, struct search *search)
{
    for (size_t c = 0; c < request->asked.n; c++) {
        if (search->criterion)
            rmap_criterion_destroy(search->criterion[c]);
        if (search->count)
            rmap_count_fini(&search->count[c]);
        if (search->registered)
            rmap_registered_fini(&search->registered[c]);
        if (search->groups)
            rmap_ray_groups_fini(&search->groups[c]);
    }
    rmap_free(search->criterion);
    rmap_free(search->count);
    rmap_free(search->registered);
    rmap_free(search->groups);
    rmap_free(search->id);
    rmap_free(search->top);
    rmap_which_destroy(search->which);
    rmap_quantities_destroy(search->of);
    rmap_overlay_destroy(search->overlay);
    rmap_map_close(search->map);
}

/* Collective. Criteria that may speak of receivers, one scan for each; the counts are rank 0's. */
static enum rmap_status count_with_receivers(const struct rmap_context *context,
                                             const struct rmap_query_request *request,
                                             struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t c = 0; c < request->asked.n; c++) {
        const struct rmap_overlay_question question = {search->map, search->overlay,
                                                       search->criterion[c]};
        RMAP_TRY(rmap_overlay_count_run(context, &question, &search->count[c], err));
    }
out:
    return st;
}

/* Collective. Criteria that detectors do not count as well, in one scan. */
static enum rmap_status scan(const struct rmap_context *context,
                             const struct rmap_query_request *request, struct search *search,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = request->asked.n;
    struct rmap_criterion **criterion = rmap_alloc(n, sizeof(void *));
    struct rmap_count *count = rmap_alloc(n, sizeof *count);
    size_t n_left = 0;
    if (!criterion || !count)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t c = 0; c < n; c++)
        if (!search->registered[c].is_counted) {
            criterion[n_left] = search->criterion[c];
            count[n_left++] = search->count[c];
        }
    if (n_left > 0)
        RMAP_TRY(rmap_scan_map(
            context, search->map, criterion, n_left,
            request->deal == RMAP_DEAL_LOCAL ? RMAP_DEAL_LOCAL : RMAP_DEAL_SHARES, count, err));
    for (size_t c = n; c-- > 0;)
        if (!search->registered[c].is_counted)
            search->count[c] = count[--n_left];
out:
    rmap_free(criterion);
    rmap_free(count);
    return st;
}

/* Collective. */
static enum rmap_status count_portions(const struct rmap_context *context,
                                       const struct rmap_query_request *request,
                                       struct search *search, bool *is_exact_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_source = rmap_map_scene(search->map)->n_source;
    for (size_t c = 0; c < request->asked.n; c++) {
        if (search->registered[c].is_counted)
            continue;
        rmap_count_fini(&search->count[c]);
        RMAP_TRY(rmap_count_init(&search->count[c], n_source, err));
    }
    RMAP_TRY(scan(context, request, search, err));
    *is_exact_ret = true;
    for (size_t c = 0; c < request->asked.n; c++) {
        double flux, error;
        rmap_count_flux(&search->count[c], search->map, &flux, &error);
        *is_exact_ret = *is_exact_ret && rmap_until_suffices(&request->until, flux, error);
    }
out:
    return st;
}

/* Collective. And the rays with them where that is the same scan; not of a part of the map. */
static enum rmap_status count_registered(const struct rmap_context *context,
                                         const struct rmap_query_request *request,
                                         struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool alone =
        search->overlay || request->deal == RMAP_DEAL_LOCAL || request->until.part.relative > 0.0;
    for (size_t c = 0; c < request->asked.n; c++)
        RMAP_TRY(rmap_registered_run(context, search->map, search->overlay, search->criterion[c],
                                     context->json, alone ? NULL : &search->count[c],
                                     &search->registered[c], err));
out:
    return st;
}

/* Collective. */
static enum rmap_status count_rays(const struct rmap_context *context,
                                   struct rmap_query_request *request, struct search *search,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double begun = rmap_clock_seconds();
    const bool of_part = request->until.part.relative > 0.0;
    bool is_exact = false, of_ids = false;
    for (size_t c = 0; c < request->asked.n; c++)
        of_ids |= rmap_criterion_of_ids(search->criterion[c]);
    RMAP_TRY(rmap_agree(context, rmap_until_begin(&request->until, search->map, of_ids, err), err));
    if (!of_part)
        RMAP_TRY(count_registered(context, request, search, err));
    if (search->overlay)
        RMAP_TRY(count_with_receivers(context, request, search, err));
    else
        do
            RMAP_TRY(count_portions(context, request, search, &is_exact, err));
        while (rmap_until_goes_on(&request->until, is_exact));
    if (of_part)
        RMAP_TRY(count_registered(context, request, search, err));
    for (size_t c = 0; c < request->asked.n; c++)
        RMAP_TRY(rmap_ray_groups_run(context, search->map, search->overlay, search->criterion[c],
                                     request->by, &search->groups[c], err));
    double seconds = rmap_clock_seconds() - begun;
    if (context->rank == 0)
        st = rmap_query_count_print(context, search->map, search->criterion, search->count,
                                    search->registered, search->groups, request->asked.n,
                                    request->listed, &request->until.part, seconds, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_until_fini(&request->until);
    return st;
}

static struct rmap_top_question top_question(const struct rmap_query_request *request,
                                             const struct search *search)
{
    return (struct rmap_top_question){search->map,   search->overlay, search->criterion[0],
                                      search->which, search->of,      request->top};
}

/* Collective. */
static enum rmap_status find_top(const struct rmap_context *context,
                                 const struct rmap_arguments *given,
                                 const struct rmap_query_request *request, struct search *search,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (search->of->of_registrations)
        st = rmap_asked_which(context, given, &request->asked, search->of->scene,
                              &search->of->detector, search->criterion[0], &search->which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_top_question question = top_question(request, search);
    RMAP_TRY(rmap_top_pick(context, &question, &search->top, &search->n_top, err));
    search->id = rmap_alloc(search->n_top + 1, sizeof *search->id);
    if (!search->id)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    RMAP_TRY(rmap_agree(context, st, err));
    search->n_id = search->n_top;
    for (size_t i = 0; i < search->n_top; i++)
        search->id[i] = search->top[i].id;
    rmap_sort_ids(search->id, search->n_id);
out:
    return st;
}

/* Rank 0. */
static enum rmap_status print_top(const struct rmap_context *context,
                                  const struct rmap_query_request *request,
                                  const struct search *search, struct rmap_error *err)
{
    const struct rmap_top_question question = top_question(request, search);
    if (context->rank > 0)
        return RMAP_OK;
    return rmap_query_top_print(context, &question, search->top, search->n_top, err);
}

/* Collective. What a sample picks is found first, and the first rays of a map that many write; and
 * all rays where receivers decide. */
static enum rmap_status choose(const struct rmap_context *context,
                               const struct rmap_query_request *request, struct search *search,
                               struct rmap_pick *pick, struct rmap_error *err)
{
    struct rmap_sample_order order = request->sample;
    *pick = (struct rmap_pick){.criterion = search->criterion[0]};
    if (request->top > 0) {
        *pick = (struct rmap_pick){.id = search->id, .n_id = search->n_id};
        return RMAP_OK;
    }
    if (order.most == 0 && request->map && request->limit < UINT64_MAX)
        order = (struct rmap_sample_order){.most = request->limit};
    if (order.most == 0 && search->overlay)
        order = (struct rmap_sample_order){.most = request->limit};
    if (order.most == 0)
        return RMAP_OK;
    const struct rmap_overlay_question question = {search->map, search->overlay,
                                                   search->criterion[0]};
    enum rmap_status st =
        search->overlay
            ? rmap_overlay_pick(context, &question, &order, &search->id, &search->n_id, err)
            : rmap_ray_sample(context, search->map, pick, request->deal, &order, &search->id,
                              &search->n_id, err);
    *pick = (struct rmap_pick){.id = search->id, .n_id = search->n_id};
    return st;
}

/* What of the rays that match is written: "all", "limit 10". */
static const char *answer_text(const struct rmap_query_request *request,
                               const struct search *search, char text[80])
{
    (void)snprintf(text, 80, "all");
    if (request->top > 0)
        (void)snprintf(text, 80, "top %llu of %.50s", (unsigned long long)request->top,
                       search->of->of[0].name);
    else if (request->sample.most > 0)
        (void)snprintf(text, 80, "sample %llu seed %llu", (unsigned long long)request->sample.most,
                       (unsigned long long)request->sample.seed);
    else if (request->limit < UINT64_MAX)
        (void)snprintf(text, 80, "limit %llu", (unsigned long long)request->limit);
    return text;
}

/* Collective. */
static enum rmap_status list_rays(const struct rmap_context *context,
                                  const struct rmap_query_request *request, struct search *search,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_rays_out *out = NULL;
    char answer[80];
    const struct rmap_table_request table = {.path = request->output_path,
                                             .from = request->map_path,
                                             .criterion = rmap_criterion_text(search->criterion[0]),
                                             .answer = answer_text(request, search, answer),
                                             .columns = request->columns,
                                             .at = request->at};
    struct rmap_pick pick;
    uint64_t n = 0;
    RMAP_TRY(choose(context, request, search, &pick, err));
    pick.columns = search->columns;
    if (context->rank == 0)
        st = rmap_rays_out_begin(context, search->map, &table, &out, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_ray_sink sink = {out, rmap_rays_out_take};
    RMAP_TRY(rmap_ray_stream(context, search->map, &pick, request->deal, request->limit, &sink, &n,
                             err));
    if (context->rank == 0)
        st = rmap_rays_out_finish(out, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_rays_out_destroy(out);
    return st;
}

/* Collective. */
static enum rmap_status write_map(const struct rmap_context *context,
                                  const struct rmap_query_request *request, struct search *search,
                                  struct rmap_error *err)
{
    struct rmap_pick pick;
    char how[80], *spelled = NULL;
    enum rmap_status st =
        rmap_criterion_spell(search->criterion[0], request->asked.criteria, &spelled, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(choose(context, request, search, &pick, err));
    const struct rmap_map_answer answer = {.map = search->map,
                                           .pick = &pick,
                                           .deal = request->deal,
                                           .encoding = request->encoding,
                                           .from = request->map_path,
                                           .to = request->output_path,
                                           .criterion = rmap_criterion_text(search->criterion[0]),
                                           .spelled = spelled,
                                           .answer = answer_text(request, search, how),
                                           .force = request->force};
    st = rmap_map_answer_write(context, &answer, err);
out:
    rmap_free(spelled);
    return st;
}

/* Those of the tables that are asked for. */
static enum rmap_status find_columns(const struct rmap_query_request *request,
                                     struct search *search, struct rmap_error *err)
{
    struct rmap_ray_table *table = NULL;
    if (!request->columns)
        return RMAP_OK;
    enum rmap_status st =
        rmap_ray_table_create(search->map, request->columns, RMAP_VECTORS_BY_PARTS, &table, err);
    if (st == RMAP_OK)
        search->columns = table->columns;
    rmap_ray_table_destroy(table);
    return st;
}

static enum rmap_status run_query(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_query_request request = {0};
    struct search search = {0};
    enum rmap_status st = rmap_query_request_read(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_query_request_criteria(context, given, &request, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &search.map, err));
    RMAP_TRY(rmap_overlay_load(context, given, search.map, &search.overlay, err));
    st = compile(context, &request, &search, err);
    if (st == RMAP_OK)
        st = find_columns(&request, &search, err);
    if (st == RMAP_OK && request.top > 0)
        st = rmap_quantities_create_over(search.map, search.overlay, &request.of, 1, NULL,
                                         &search.of, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (request.top > 0 && !request.explain)
        RMAP_TRY(find_top(context, given, &request, &search, err));
    if (request.explain && context->rank == 0)
        st = rmap_query_explain(
            context, search.map, search.criterion, request.asked.n,
            request.count ? 0
            : request.top && !request.output_path
                ? RMAP_SAMPLE_COLUMNS | search.of->columns
                : rmap_pick_columns(&(struct rmap_pick){.columns = search.columns}),
            err);
    else if (!request.explain)
        st = request.count                             ? count_rays(context, &request, &search, err)
             : request.top > 0 && !request.output_path ? print_top(context, &request, &search, err)
             : request.map                             ? write_map(context, &request, &search, err)
                                                       : list_rays(context, &request, &search, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    release(&request, &search);
    rmap_query_request_fini(&request);
    return st;
}

const struct rmap_command rmap_command_query = {
    .name = "query",
    .summary = "count, list or export the rays that match a criterion",
    .operands = "MAP CRITERION... [--criteria FILE] [--limit|--sample|--top N] [-o OUT]",
    .help =
        "Finds the rays whose histories match a criterion, such as\n\n"
        "  raymap query lens.raymap 'registered(sensor where ghost_order >= 1)'\n\n"
        "Several criteria are counted in one scan. FILE defines names, as in\n\n"
        "  let ghost = registered(sensor where ghost_order >= 1)\n\n"
        "for use as @ghost; without a CRITERION all of its definitions are answered. OUT.csv has\n"
        "one row per segment, OUT.json an array of rays as `raymap report` prints them, OUT.h5\n"
        "tables of rays, segments and registrations in plain columns, for h5py and pandas, "
        "OUT.vtp\n"
        "a polyline per ray for ParaView, OUT.tm25ray and OUT.mcpl a row per ray with which its\n"
        "light goes on elsewhere, and OUT.raymap is a ray map of the matching rays, with the\n"
        "fluxes that they have in MAP. Rays come in the order of their ids. The answer\n"
        "does not depend on the number of ranks and threads.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1000,
    .run = run_query,
};
