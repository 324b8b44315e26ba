/* SPDX-License-Identifier: MIT
 *
 * raymap stats: histograms and moments of any number of a ray or registration, with errors.
 */
#include <stdio.h>

#include "analysis/stats/stats_text.h"
#include "io/export/raster.h"
#include "io/map/map_content.h"
#include "mpi/answer/stats_options.h"
#include "mpi/answer/stats_out.h"
#include "mpi/command/asked_each.h"
#include "mpi/command/dim.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/overlay_load.h"
#include "mpi/command/until.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/stats_paths_run.h"
#include "mpi/scan/stats_run.h"

static const struct rmap_option options[] = {
    {"of", 0, "NUMBER",
     "what: wavelength photon_energy flux path_length path_length(MEDIUM) optical_path group_path "
     "start_x start_y start_z segments bounces ray event registrations ghost_order scatter_order, "
     "a test that counts such as 'hit(lens.*, reflect)', or of each registration, with (NAME) "
     "behind it: x y world_x world_y world_z angle time optical_path group_path ghost_order "
     "scatter_order cell cell_i cell_j; a sum such as 'time(far) - 2 * time(near)'; given twice: a "
     "histogram over both"},
    {"where", 'w', "CRITERION" RMAP_ARGUMENT_AGAIN,
     "of the rays that match only, such as 'hit(lens.*, reflect) >= 2'; given again: of those of "
     "each by themselves"},
    RMAP_UNTIL_OPTION,
    RMAP_ASKED_WHICH_OPTION,
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    RMAP_DIM_OPTIONS,
    {"detector", 0, "NAME", "a value for each registration there, instead of each ray",
     .words = "@detectors"},
    {"unit", 0, "U...", "of the values, as ns, um or mrad; given twice: of both numbers"},
    {"bins", 0, "N", "bins of the histogram, or their edges: 0,1,2.5,10 mm"},
    {"range", 0, "A..B", "from where to where, as 400..700 nm (default: all values)"},
    {"log", 0, NULL, "bins of equal ratio"},
    {"by", 0, "WHAT",
     "each by itself: source, detector, object (met last), ended, ghost_order, scatter_order, "
     "event, criterion (of --where or of the FILE of --criteria), path (the classes of "
     "`raymap paths` with most flux, and the others), path:object, path:group",
     .words =
         "source detector object ended ghost_order scatter_order event criterion path path:object "
         "path:group"},
    {"top", 0, "N", "so many classes of --by path (default 10)", "by"},
    {"quantiles", 0, "LIST", "in per cent (default 5,25,50,75,95)"},
    {"memory", 0, "BYTES", "for values; beyond it quantiles are interpolated (default 128Mi)"},
    {"output", 'o', "OUT...",
     "OUT.csv, .json, .h5, .npz, .npy: numbers; .png, .svg: a picture; may be given again"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context,
                             const struct rmap_stats_options *request,
                             const struct rmap_stats *stats, const struct rmap_stats_labels *labels,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_stats_write(stats, labels, request->output[i], err));
    if (context->json)
        st = rmap_json_print(rmap_stats_json(stats, labels), stdout, err);
    else
        st = rmap_stats_print(stats, labels, stdout, err);
    if (!context->json)
        rmap_dim_print(stats->setup->quantities->map);
out:
    return st;
}

/* Collective. The criteria; several are told apart. */
static enum rmap_status ask(const struct rmap_context *context,
                            const struct rmap_arguments *arguments,
                            struct rmap_stats_options *given, struct rmap_asked *asked,
                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (given->n_where > 0 && rmap_argument(arguments, "zemax"))
        return rmap_error_set(err, RMAP_USAGE, "give --where or --zemax, not both");
    RMAP_TRY(rmap_asked_load(context, arguments, (const char *const *)given->where, given->n_where,
                             asked, err));
    if (given->by == RMAP_STATS_BY_CRITERION)
        rmap_asked_take_file(asked);
    if (asked->n > 1 && given->by == RMAP_STATS_TOGETHER)
        given->by = RMAP_STATS_BY_CRITERION;
    if (asked->n > 1 && given->by >= RMAP_STATS_BY_PATH)
        return rmap_error_set(err, RMAP_USAGE,
                              "--by %s takes one criterion: join several with 'or', or leave --by "
                              "out to tell them apart",
                              rmap_stats_by_word(given->by));
    if (given->by == RMAP_STATS_BY_CRITERION && asked->n == 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "--by criterion wants criteria: --where, once or more often, or "
                              "--criteria FILE");
    if (given->by >= RMAP_STATS_BY_PATH && rmap_argument(arguments, "until"))
        return rmap_error_set(
            err, RMAP_USAGE, "--until with --by path: which classes have most flux, all rays tell");
    if (asked->n > RMAP_STATS_CRITERIA_MAX)
        return rmap_error_set(err, RMAP_USAGE, "statistics tell %d criteria apart at most, not %zu",
                              RMAP_STATS_CRITERIA_MAX, asked->n);
    for (size_t i = 0; asked->n > 1 && given->n_of > 1 && i < given->n_output; i++)
        if (rmap_picture_kind(given->output[i]) != RMAP_PICTURE_NONE)
            return rmap_error_set(err, RMAP_USAGE,
                                  "%s: a picture of two numbers shows one criterion; .csv, .json, "
                                  ".h5 and .npz take several",
                                  given->output[i]);
out:
    return st;
}

/* Not collective: what the options mean for this map. */
static enum rmap_status prepare(const struct rmap_map *map, const struct rmap_overlay *overlay,
                                const struct rmap_stats_options *given,
                                struct rmap_quantities **quantities_ret,
                                struct rmap_stats_setup *setup, struct rmap_stats_request *request,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_quantities_create_over(map, overlay, (const char *const *)given->of, given->n_of,
                                         given->detector, quantities_ret, err));
    for (size_t i = 0; i < given->n_unit; i++)
        RMAP_TRY(rmap_quantity_set_unit(*quantities_ret, i, given->unit[i], err));
    if (given->by == RMAP_STATS_BY_DETECTOR && !(*quantities_ret)->of_registrations) {
        st = rmap_error_set(err, RMAP_USAGE,
                            "--by detector wants a number of registrations: give --detector '*'");
        goto out;
    }
    RMAP_TRY(rmap_stats_group_prepare(given->by, *quantities_ret, err));
    rmap_stats_setup_init(setup, *quantities_ret, given->by, given->memory_nbytes);
    *request = (struct rmap_stats_request){
        .setup = setup, .p = given->quantile, .n_quantile = given->n_quantile};
    st = rmap_stats_options_axes(given, *quantities_ret, request->axis, err);
    for (size_t i = 0; i < (*quantities_ret)->n; i++)
        setup->logarithmic |= request->axis[i].logarithmic;
out:
    return st;
}

/* Rank 0 says where a criterion chooses registrations that a sum of rays does not heed. */
static enum rmap_status tell_sums(const struct rmap_context *context,
                                  const struct rmap_quantity *quantity,
                                  const struct rmap_scene *scene,
                                  const struct rmap_criterion *criterion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool told = quantity->kind != RMAP_QUANTITY_SUM || quantity->of_registration || !criterion;
    for (size_t k = 0; !told && k < quantity->sum.n; k++) {
        struct rmap_which *which = NULL;
        if (quantity->sum.term[k].of_registration)
            RMAP_TRY(rmap_which_create(scene, &quantity->sum.term[k].detector, NULL, NULL,
                                       criterion, &which, err));
        told = rmap_which_chooses(which);
        if (told && context->rank == 0 && !context->quiet)
            fprintf(stderr,
                    "raymap: %s takes all registrations of a ray (undefined where they differ): "
                    "'%s' chooses rays alone\n",
                    quantity->name, which->text);
        rmap_which_destroy(which);
    }
out:
    return st;
}

/* Which registrations count, where numbers are of registrations. */
static enum rmap_status choose(const struct rmap_context *context,
                               const struct rmap_arguments *arguments, struct rmap_asked *asked,
                               const struct rmap_quantities *quantities,
                               const struct rmap_criterion *criterion,
                               struct rmap_stats_criteria *criteria, struct rmap_which **which_ret,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *which = rmap_argument(arguments, "which");
    rmap_asked_tell_time(context, asked, rmap_quantities_of_phase_time(quantities));
    for (size_t i = 0; i < quantities->n; i++) {
        const struct rmap_quantity *one = &quantities->of[i];
        rmap_asked_tell_mixed(context, quantities->scene, one->name,
                              one->dimension == RMAP_DIMENSION_MIXED);
        for (size_t k = 0; k < criteria->n; k++)
            RMAP_TRY(tell_sums(context, one, quantities->scene, criteria->of[k], err));
    }
    if (quantities->of_registrations && (criteria->n < 2 || which))
        return rmap_asked_which(context, arguments, asked, quantities->scene, &quantities->detector,
                                criterion, which_ret, err);
    if (quantities->of_registrations) {
        RMAP_TRY(rmap_which_create_any(quantities->scene, &quantities->detector, criteria->of,
                                       criteria->n, criteria->flux_per_weight, which_ret, err));
        RMAP_TRY(rmap_which_detect(*which_ret, &quantities->detector, err));
        criteria->which = (const struct rmap_which *const *)(*which_ret)->of;
    }
    if (which && !quantities->of_registrations)
        return rmap_error_set(err, RMAP_USAGE,
                              "--which chooses registrations, and '%s' is a number of a ray: give "
                              "--detector NAME",
                              quantities->of[0].name);
out:
    return st;
}

/* Collective. What groups there are beside those that the scene has. */
static enum rmap_status
tell_apart(const struct rmap_context *context, const struct rmap_stats_options *given,
           const struct rmap_stats_request *request, const struct rmap_overlay *overlay,
           const struct rmap_stats_criteria *criteria, struct rmap_stats_paths *paths,
           struct rmap_quantities *quantities, struct rmap_stats_setup *setup,
           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (given->by == RMAP_STATS_BY_CRITERION || criteria->n > 1) {
        quantities->columns |= rmap_stats_criteria_columns(criteria);
        rmap_stats_setup_criteria(setup, criteria);
    }
    if (given->by < RMAP_STATS_BY_PATH)
        return RMAP_OK;
    const struct rmap_stats_paths_question question = {
        .quantities = quantities,
        .overlay = overlay,
        .criterion = request->criterion,
        .which = request->which,
        .level = (enum rmap_path_level)(given->by - RMAP_STATS_BY_PATH),
        .top = given->top};
    RMAP_TRY(rmap_stats_paths_run(context, &question, paths, err));
    quantities->columns |= rmap_path_keys_columns(paths->keys);
    rmap_stats_setup_paths(setup, paths);
out:
    return st;
}

/* Of every group that has values, of which each criterion has one: its flux, and the means of its
 * numbers as against themselves or the spread about them. */
static bool is_exact_enough(const struct rmap_until *until, const struct rmap_stats *stats)
{
    const size_t n_part = stats->setup->criteria ? stats->setup->criteria->n : 1;
    const size_t n_own = stats->n_group / n_part;
    uint64_t n_reading = 0;
    bool suffices = true;
    for (size_t g = 0; g < stats->n_group; g++) {
        const struct rmap_stats_group *group = &stats->group[g];
        n_reading = g % n_own == 0 ? group->n_reading : n_reading + group->n_reading;
        suffices = suffices && (n_reading > 0 || (g + 1) % n_own > 0);
        if (group->n_reading == 0)
            continue;
        suffices =
            suffices && rmap_until_suffices(until, group->flux.value, group->flux.standard_error);
        for (size_t i = 0; i < stats->setup->quantities->n; i++) {
            const struct rmap_stats_moment_estimates *moment = &group->of[i].moment;
            suffices =
                suffices &&
                (rmap_until_suffices(until, moment->mean.value, moment->mean.standard_error) ||
                 rmap_until_suffices(until, moment->deviation.value, moment->mean.standard_error) ||
                 moment->mean.standard_error <= 0.0);
        }
    }
    return suffices;
}

static enum rmap_status run_stats(const struct rmap_context *context,
                                  const struct rmap_arguments *arguments, struct rmap_error *err)
{
    struct rmap_stats_options given = {0};
    struct rmap_map *map = NULL;
    struct rmap_asked asked = {0};
    struct rmap_asked_each each = {0};
    struct rmap_stats_criteria criteria = {0};
    struct rmap_stats_paths paths = {0};
    struct rmap_which *which = NULL;
    struct rmap_overlay *overlay = NULL;
    struct rmap_quantities *quantities = NULL;
    struct rmap_stats_setup setup;
    struct rmap_stats_request request = {0};
    struct rmap_stats_answer answer = {0};
    struct rmap_until until = {.part = {.relative = 0.0}};
    enum rmap_status st = rmap_stats_options_read(arguments, rmap_stats_suffixes, &given, err);
    if (st == RMAP_OK)
        st = rmap_until_read(arguments, &until, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(ask(context, arguments, &given, &asked, err));
    RMAP_TRY(rmap_load_map(context, arguments->operand[0], &map, err));
    RMAP_TRY(rmap_overlay_load(context, arguments, map, &overlay, err));
    RMAP_TRY(rmap_agree(context, rmap_dim_read(arguments, map, err), err));
    st = rmap_asked_each_compile(context, &asked, rmap_scene_with(map, overlay), &each, err);
    const struct rmap_criterion *criterion = each.n > 0 ? each.any : NULL;
    criteria.of = (const struct rmap_criterion *const *)each.of;
    criteria.n = each.n;
    criteria.flux_per_weight = rmap_map_flux_per_weight(map);
    if (st == RMAP_OK)
        st = prepare(map, overlay, &given, &quantities, &setup, &request, err);
    if (st == RMAP_OK)
        st = choose(context, arguments, &asked, quantities, criterion, &criteria, &which, err);
    if (st == RMAP_OK)
        st = rmap_until_begin(&until, map,
                              rmap_criterion_of_ids(each.any) || rmap_quantities_of_ids(quantities),
                              err);
    RMAP_TRY(rmap_agree(context, st, err));
    request.criterion = criterion;
    request.which = which;
    RMAP_TRY(
        tell_apart(context, &given, &request, overlay, &criteria, &paths, quantities, &setup, err));
    setup.all_rays = !criterion;
    int is_exact = 0;
    do {
        rmap_stats_answer_fini(&answer);
        RMAP_TRY(rmap_stats_run(context, &request, &answer, err));
        is_exact = context->rank == 0 && is_exact_enough(&until, answer.stats);
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&is_exact, 1, MPI_INT, 0, context->comm)));
    } while (rmap_until_goes_on(&until, is_exact));
    if (context->rank == 0) {
        const struct rmap_stats_labels labels = {.map = arguments->operand[0],
                                                 .criterion = each.text,
                                                 .which = which,
                                                 .detector = given.detector,
                                                 .part = &until.part,
                                                 .n_ray =
                                                     rmap_map_contents(map)->n_row[RMAP_TABLE_RAY]};
        if (!criterion)
            answer.stats->known.n_ray = labels.n_ray;
        rmap_tell_hint(context, map, &(struct rmap_choice){criterion, which},
                       answer.stats->known.n_reading);
        st = show(context, &given, answer.stats, &labels, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_until_fini(&until);
    rmap_stats_answer_fini(&answer);
    rmap_stats_axes_fini(request.axis);
    rmap_stats_paths_fini(&paths);
    rmap_which_destroy(which);
    rmap_quantities_destroy(quantities);
    rmap_asked_each_fini(&each);
    rmap_overlay_destroy(overlay);
    rmap_asked_fini(&asked);
    rmap_map_close(map);
    rmap_stats_options_fini(&given);
    return st;
}

const struct rmap_command rmap_command_stats = {
    .name = "stats",
    .summary = "histograms and moments of any number, with errors",
    .operands = "MAP --of NUMBER [--of NUMBER] [--where CRITERION] [-o OUT]",
    .help =
        "Mean, standard deviation, skewness, kurtosis, quantiles and a histogram of a number of\n"
        "the matching rays or of their registrations, weighted by flux, each with its standard\n"
        "error, as\n\n"
        "  raymap stats lens.raymap --of 'angle(sensor)' --where 'hit(*, reflect) >= 2'\n"
        "  raymap stats lens.raymap --of 'x(sensor)' --of 'y(sensor)' --bins 200 -o a.csv\n\n"
        "kurtosis is the fourth moment over the square of the variance: 3 for a normal\n"
        "distribution. A ray with several wavelengths left counts as a value of `wavelength` for\n"
        "each, with its share of the flux.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_stats,
};
