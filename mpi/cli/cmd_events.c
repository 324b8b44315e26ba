/* SPDX-License-Identifier: MIT
 *
 * raymap events: what each event left in each of some detectors.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/event_out.h"
#include "base/alloc.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "io/scene/scene_values.h"
#include "mpi/answer/grid_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/asked.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"
#include "scene/events.h"

static const struct rmap_option options[] = {
    {"at", 0, "NAME,NAME", "these detectors (default: all)"},
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'event in 0..999'"},
    RMAP_ASKED_OPTIONS,
    RMAP_ASKED_WHICH_OPTION,
    RMAP_RECEIVERS_OPTION,
    {"threshold", 0, "N", "a detector fires from so much on (default 1 photo-electron)"},
    {"order", 0, "K", "and its time is that of its K-th count (default 1; 64 at most)"},
    {"coincidence", 0, "N", "so many detectors that fire are a coincidence (default: all)"},
    {"window", 0, "TIME", "within this, as '10 ns' (default: whenever)"},
    {"memory", 0, "BYTES", "for the table, on each rank (default 4Gi)"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.csv, .h5, .npz, .json: the table, a row for each event; again for more"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

static const char *const suffixes[] = {".csv", ".h5", ".npz", ".json", NULL};

struct request {
    const char *map_path, *where;
    char **at; /* [n_at]; none: all */
    size_t n_at;
    char **output; /* [n_output] */
    size_t n_output;
    uint64_t memory;
    struct rmap_event_trigger trigger; /* least 0: all */
};

/* "10 ns"; a number alone is in ns. */
static enum rmap_status read_window(const char *text, double *ns, struct rmap_error *err)
{
    const char *name = "";
    double value = 0.0;
    if (!text)
        return RMAP_OK;
    const bool good = rmap_reader_parse_quantity(text, &value, &name);
    const struct rmap_written_unit *unit =
        good ? rmap_unit_of_scene(*name ? name : "ns", RMAP_DIMENSION_TIME) : NULL;
    *ns = unit ? value * unit->size * 1e9 : (double)NAN;
    return *ns >= 0.0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_USAGE, "--window '%.40s': say a time, as '10 ns'", text);
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t order = 1, least = 0;
    *request = (struct request){.map_path = given->operand[0],
                                .where = rmap_argument(given, "where"),
                                .memory = UINT64_C(4) << 30,
                                .trigger = {.threshold = 1.0, .window_ns = (double)INFINITY}};
    RMAP_TRY(rmap_argument_list(given, "at", &request->at, &request->n_at, err));
    RMAP_TRY(rmap_argument_number(given, "threshold", &request->trigger.threshold, err));
    RMAP_TRY(rmap_argument_count(given, "order", &order, err));
    RMAP_TRY(rmap_argument_count(given, "coincidence", &least, err));
    RMAP_TRY(read_window(rmap_argument(given, "window"), &request->trigger.window_ns, err));
    RMAP_TRY(rmap_argument_count(given, "memory", &request->memory, err));
    if (order < 1 || order > RMAP_EVENT_EARLY_MAX)
        return rmap_error_set(err, RMAP_USAGE, "--order lies between 1 and %d",
                              RMAP_EVENT_EARLY_MAX);
    if (rmap_argument(given, "coincidence") && least < 1)
        return rmap_error_set(err, RMAP_USAGE, "--coincidence is of one detector at least");
    if (!(request->trigger.threshold >= 0.0))
        return rmap_error_set(err, RMAP_USAGE, "--threshold is 0 or more");
    request->trigger.order = (size_t)order;
    request->trigger.least = (size_t)least;
    RMAP_TRY(rmap_argument_each(given, "output", &request->output, &request->n_output, err));
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_output_check(request->output[i], suffixes,
                                   rmap_argument(given, "force") != NULL, err));
out:
    return st;
}

/* What is asked of a map, with what it is made of. */
struct question {
    struct rmap_event_ask ask;
    uint64_t *event;
    int32_t *detector, *place;
    uint8_t *member;
    struct rmap_index_set set; /* of the detectors */
};

static void question_fini(struct question *question)
{
    rmap_free(question->event);
    rmap_free(question->detector);
    rmap_free(question->place);
    rmap_free(question->member);
}

static enum rmap_status choose_detectors(const struct request *request,
                                         const struct rmap_scene *scene, struct question *question,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = request->n_at > 0 ? request->n_at : scene->n_detector;
    if (n < 1 || n > RMAP_EVENT_DETECTORS_MAX)
        return rmap_error_set(err, RMAP_USAGE, "%zu detectors: 1 to %d are read", n,
                              RMAP_EVENT_DETECTORS_MAX);
    question->detector = rmap_alloc(n, sizeof *question->detector);
    question->place = rmap_alloc(scene->n_detector, sizeof *question->place);
    question->member = rmap_alloc(scene->n_detector, 1);
    if (!question->detector || !question->place || !question->member)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", n);
    for (size_t d = 0; d < scene->n_detector; d++)
        question->place[d] = -1;
    for (size_t i = 0; i < n; i++) {
        int32_t d = (int32_t)i;
        if (request->n_at > 0)
            RMAP_TRY(rmap_find_detector(scene, request->at[i], &d, err));
        if (question->place[d] >= 0)
            return rmap_error_set(err, RMAP_USAGE, "--at names detector '%.60s' twice",
                                  scene->detector[d].name);
        question->detector[i] = d;
        question->place[d] = (int32_t)i;
        question->member[d] = 1;
    }
    question->set = (struct rmap_index_set){
        .low = 0, .span = (uint32_t)scene->n_detector, .member = question->member};
    question->ask.detector = question->detector;
    question->ask.n_detector = n;
    question->ask.place = question->place;
out:
    return st;
}

static enum rmap_status check(const struct request *request, const struct rmap_event_ask *ask,
                              struct rmap_error *err)
{
    const double nbytes = rmap_event_sums_nbytes(ask);
    if (isfinite(request->trigger.window_ns) && !ask->timed)
        return rmap_error_set(err, RMAP_INPUT,
                              "--window wants times of arrival, which maps traced with 'time: on' "
                              "have");
    if (request->trigger.least > ask->n_detector)
        return rmap_error_set(err, RMAP_USAGE, "--coincidence %zu of %zu detectors",
                              request->trigger.least, ask->n_detector);
    if (nbytes > (double)request->memory && !request->where)
        return rmap_error_set(err, RMAP_USAGE,
                              "the table of %zu events takes %.1f GB: allow that by --memory, or "
                              "ask for some, by --where 'event in 0..999999'",
                              ask->n_event, 1e-9 * nbytes);
    return RMAP_OK;
}

static enum rmap_status prepare(const struct request *request, const struct rmap_map *map,
                                const struct rmap_scene *scene, struct question *question,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_event_ask *ask = &question->ask;
    const char *trouble = rmap_scene_events_trouble(scene);
    if (trouble)
        return rmap_error_set(err, RMAP_INPUT, "%s", trouble);
    *ask = (struct rmap_event_ask){
        .map = map, .scene = scene, .timed = scene->timed, .part = rmap_event_part(map)};
    RMAP_TRY(choose_detectors(request, scene, question, err));
    RMAP_TRY(rmap_scene_events(scene, &question->event, &ask->n_event, err));
    ask->event = question->event;
    ask->n_early = ask->timed ? request->trigger.order : 0;
    st = check(request, ask, err);
out:
    return st;
}

enum { TEXTS = 3 };

/* Columns event, rays, fired, coincident, then of each value a column for each detector. */
static enum rmap_status write_arrays(struct rmap_event_table *table, const char *path,
                                     struct rmap_error *err)
{
    enum { OWN = 4, ARRAYS = OWN + RMAP_EVENT_VALUES };
    static const char *const own[OWN] = {"event", "rays", "fired", "coincident"};
    static const char *const meaning[OWN] = {"its number", "of it that match",
                                             "detectors that fired", "1: enough of them did"};
    const size_t n = table->n_row, n_detector = table->ask->n_detector;
    struct rmap_grid_array array[ARRAYS];
    size_t n_array = 0, index = 0, width = 0;
    enum rmap_status st = RMAP_OK;
    char *names = rmap_alloc(n_detector, 256);
    double *data = rmap_alloc_unset((OWN + RMAP_EVENT_VALUES * n_detector) * (n + 1), sizeof *data);
    if (!data || !names) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rows", n);
        goto out;
    }
    for (; n_array < OWN; n_array++)
        array[n_array] = (struct rmap_grid_array){own[n_array],      "1", meaning[n_array], 1, {n},
                                                  data + n_array * n};
    for (int v = 0; v < RMAP_EVENT_VALUES; v++)
        if (rmap_event_table_has(table, (enum rmap_event_value)v))
            array[n_array++] =
                (struct rmap_grid_array){rmap_event_value_name((enum rmap_event_value)v),
                                         rmap_event_value_unit(table, (enum rmap_event_value)v),
                                         rmap_event_value_description((enum rmap_event_value)v),
                                         2,
                                         {n, n_detector},
                                         data + (OWN + n_detector * width++) * n};
    const struct rmap_event_row *row;
    for (size_t r = 0; (row = rmap_event_table_next(table, &index)) != NULL; r++) {
        const double value[OWN] = {(double)row->event, (double)row->rays, (double)row->n_fired,
                                   row->coincident};
        for (size_t k = 0; k < OWN; k++)
            data[k * n + r] = value[k];
        width = 0;
        for (int v = 0; v < RMAP_EVENT_VALUES; v++)
            if (rmap_event_table_has(table, (enum rmap_event_value)v)) {
                double *to = data + (OWN + n_detector * width++) * n + r * n_detector;
                for (size_t d = 0; d < n_detector; d++)
                    to[d] = row->value[d][v];
            }
    }
    for (size_t d = 0, at = 0; d < n_detector; d++)
        at += (size_t)snprintf(names + at, 256 * n_detector - at, "%s%s", d > 0 ? "," : "",
                               table->ask->scene->detector[table->ask->detector[d]].name);
    const struct rmap_grid_text text[TEXTS] = {
        {"criterion", table->criterion ? table->criterion : "all"},
        {"detectors", names},
        {"flux_unit", rmap_flux_unit_name(table->ask->scene)}};
    st = rmap_grid_write(array, n_array, text, TEXTS, path, err);
out:
    rmap_free(names);
    rmap_free(data);
    return st;
}

/* What files hold, the table being walked once more for each. */
struct writing {
    struct rmap_event_table *table;
    const struct rmap_event_summary *summary;
    const struct rmap_map *map;
};

static enum rmap_status put_csv(const void *context, FILE *file, struct rmap_error *err)
{
    const struct writing *writing = context;
    (void)err;
    rmap_event_csv(writing->table, file);
    return RMAP_OK;
}

static enum rmap_status put_json(const void *context, FILE *file, struct rmap_error *err)
{
    const struct writing *writing = context;
    return rmap_json_print(
        rmap_json_of_map(rmap_event_json(writing->table, writing->summary, true), writing->map),
        file, err);
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct writing *writing, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < request->n_output; i++) {
        const char *path = request->output[i];
        if (rmap_output_is(path, ".csv"))
            RMAP_TRY(rmap_whole_file_put(path, put_csv, writing, err));
        else if (rmap_output_is(path, ".json"))
            RMAP_TRY(rmap_whole_file_put(path, put_json, writing, err));
        else
            RMAP_TRY(write_arrays(writing->table, path, err));
    }
    if (context->json)
        return rmap_json_print(
            rmap_json_of_map(rmap_event_json(writing->table, writing->summary, false),
                             writing->map),
            stdout, err);
    st = rmap_event_print(writing->table, writing->summary, stdout, err);
out:
    return st;
}

/* Collective. */
static enum rmap_status sum_up(const struct rmap_context *context, const struct rmap_fold *fold,
                               const struct request *request, struct rmap_error *err)
{
    const struct rmap_event_ask *ask = fold->context;
    struct rmap_event_table table = {0};
    struct rmap_event_summary summary = {0};
    struct rmap_event_trigger trigger = request->trigger;
    void *state = NULL;
    trigger.least = trigger.least > 0 ? trigger.least : ask->n_detector;
    enum rmap_status st = rmap_fold_run(context, fold, &state, err);
    if (st == RMAP_OK && state) {
        st = rmap_event_table_init(state, &trigger, &table, err);
        table.criterion = fold->criterion ? rmap_criterion_text(fold->criterion) : NULL;
        table.which = fold->which;
        if (st == RMAP_OK)
            st = rmap_event_summary_init(&table, &summary, err);
        if (st == RMAP_OK)
            st = show(context, request, &(struct writing){&table, &summary, ask->map}, err);
    }
    rmap_event_summary_fini(&summary);
    rmap_event_table_fini(&table);
    fold->kind->destroy(state);
    return rmap_agree(context, st, err);
}

static enum rmap_status run_events(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct question question = {.event = NULL};
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_which *which = NULL;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    st = prepare(&request, map, scene, &question, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, scene, &criterion, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(
        rmap_asked_which(context, given, &asked, scene, &question.set, criterion, &which, err));
    const struct rmap_fold fold = {.kind = &rmap_event_kind,
                                   .context = &question.ask,
                                   .map = map,
                                   .criterion = criterion,
                                   .which = which,
                                   .columns = rmap_event_columns(&question.ask),
                                   .overlay = overlay};
    RMAP_TRY(sum_up(context, &fold, &request, err));
out:
    rmap_argument_list_free(request.at, request.n_at);
    rmap_argument_list_free(request.output, request.n_output);
    question_fini(&question);
    rmap_which_destroy(which);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_overlay_destroy(overlay);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_events = {
    .name = "events",
    .summary = "what each event left in detectors: sums, times, coincidences",
    .operands = "MAP [--at NAME,NAME] [--window TIME] [--where CRITERION] [-o OUT]",
    .help =
        "Tells of each event (of files of rays or of steps that number them) what each detector\n"
        "read: registrations, the sum of their flux times its response, first and mean time of\n"
        "arrival, and by its `reading` dark counts, crosstalk and the cells that fired; and in\n"
        "how many events detectors fired together:\n\n"
        "  raymap events bar.raymap --at left,right --window '10 ns' -o events.csv",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_events,
};
