/* SPDX-License-Identifier: MIT
 *
 * raymap compare: whether two maps, or two criteria of one, are statistically the same.
 */
#include <string.h>

#include "analysis/compare/compare.h"
#include "analysis/compare/compare_out.h"
#include "analysis/compare/compare_products.h"
#include "base/alloc.h"
#include "mpi/answer/compare_fields.h"
#include "mpi/answer/compare_images.h"
#include "mpi/answer/compare_request.h"
#include "mpi/answer/compare_write.h"
#include "mpi/command/asked.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/parallel/agree.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION...",
     "of the rays that match only; twice: of the first sample, and of the second"},
    RMAP_ASKED_WHICH_OPTION,
    {"criteria", 0, "FILE", "named criteria: let NAME = CRITERION ..., used as @NAME"},
    {"test", 't', "KINDS",
     "what is compared: flux, detector, object, medium, stop, image, paths (default: all of them)"},
    {"of", 0, "X",
     "and a number of rays or registrations, such as path_length, 'x(sensor)'; again for more"},
    {"bins", 'b', "N",
     "equal ones of a number (default: 50 with as many rays each, or one per whole number)", "of"},
    {"range", 0, "A..B", "that the bins of a number span (default: all values)", "of"},
    {"detector", 'd', "NAME", "of the detectors this one alone", .words = "@detectors"},
    {"output", 'o', "OUT",
     "what differs where, of the detector or the number: OUT.csv, .h5, .npz, a picture .png, .svg; "
     "OUT.json with all tests"},
    {"force", 'f', NULL, "replace OUT", "output"},
    RMAP_RECEIVERS_OPTION,
    {"significance", 0, "P", "chance of a false alarm among all tests (default 0.01)"},
    {"correction", 0, "NAME", "for the number of tests: holm (default), sidak, none"},
    {NULL}};

struct work {
    const struct rmap_context *context;
    struct rmap_compare_request request;
    const struct rmap_arguments *given;
    struct rmap_asked asked;
    struct rmap_map *map[2];         /* [1] may be [0] */
    struct rmap_overlay *overlay[2]; /* receivers, or NULL; [1] may be [0] */
    struct rmap_criterion *named[2];
    struct rmap_criterion *criterion[RMAP_COMPARE_SAMPLES];
    struct rmap_which *own[2];    /* of each criterion, or of --which */
    struct rmap_which *shared[3]; /* of rays of both: what both choose, A alone, B alone; or NULL */
    struct rmap_compare_samples samples;
    struct rmap_compare_layout layout[2], alone;
    void *sums[RMAP_COMPARE_SAMPLES];
    struct rmap_compare_products_layout products_layout[2];
    void *products[2];
    struct rmap_comparison *comparison;
    struct rmap_compare_bins **bins; /* [n_bins] for the output, on rank 0 */
    size_t n_bins;
};

static const struct rmap_scene *scene_of(const struct work *work, size_t k)
{
    return rmap_scene_with(work->map[k], work->overlay[k]);
}

static bool is_paired(const struct work *work)
{
    return work->map[0] == work->map[1];
}

/* Rays that only one of two criteria selects, and those of both. */
static enum rmap_status compile_pair(struct work *work, struct rmap_error *err)
{
    static const char *const sign[RMAP_COMPARE_SAMPLES][2] = {{"", "not "}, {"not ", ""}, {"", ""}};
    enum rmap_status st = RMAP_OK;
    const char *a = work->request.where[0], *b = work->request.where[1];
    size_t nbytes = strlen(a) + strlen(b) + 32;
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
    for (size_t i = 0; i < RMAP_COMPARE_SAMPLES && st == RMAP_OK; i++) {
        (void)snprintf(text, nbytes, "%s(%s) and %s(%s)", sign[i][0], a, sign[i][1], b);
        st = rmap_criterion_compile_with(text, work->asked.criteria, scene_of(work, 0),
                                         &work->criterion[i], err);
    }
    rmap_free(text);
    return st;
}

/* Which registrations of each criterion's rays count. */
static enum rmap_status choose(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *name = work->request.detector;
    for (size_t k = 0; k < 2; k++) {
        const struct rmap_scene *scene = scene_of(work, k);
        struct rmap_index_set detector = {.span = (uint32_t)scene->n_detector};
        if (name)
            RMAP_TRY(rmap_find_detector(scene, name, &detector.low, err));
        detector.span = name ? 1 : detector.span;
        RMAP_TRY(rmap_asked_which(work->context, work->given, &work->asked, scene, &detector,
                                  work->named[k], &work->own[k], err));
    }
out:
    return st;
}

static void add_part(struct work *work, size_t criterion, const struct rmap_which *which,
                     size_t sample, bool registrations_alone)
{
    work->samples.part[work->samples.n_part++] =
        (struct rmap_compare_part){work->criterion[criterion], which, sample, registrations_alone};
}

/* Where the criteria of one map choose differently, rays of both bring registrations to the sample
 * of each, too. That these are of the same rays is left out of the errors, which are then rather
 * too large. */
static enum rmap_status share_out(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_which *const *own = work->own;
    work->samples = (struct rmap_compare_samples){.map = {work->map[0], work->map[1]},
                                                  .overlay = {work->overlay[0], work->overlay[1]},
                                                  .n = is_paired(work) ? 3 : 2};
    add_part(work, 0, own[0], 0, false);
    add_part(work, 1, own[1], 1, false);
    if (!is_paired(work))
        return RMAP_OK;
    if (strcmp(own[0]->text, own[1]->text) == 0) {
        add_part(work, 2, own[0], 2, false);
        return RMAP_OK;
    }
    RMAP_TRY(rmap_which_create_with(own[0], own[1], true, &work->shared[0], err));
    RMAP_TRY(rmap_which_create_with(own[0], own[1], false, &work->shared[1], err));
    RMAP_TRY(rmap_which_create_with(own[1], own[0], false, &work->shared[2], err));
    add_part(work, 2, work->shared[0], 2, false);
    add_part(work, 2, work->shared[1], 0, true);
    add_part(work, 2, work->shared[2], 1, true);
out:
    return st;
}

static enum rmap_status compile(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < 2 && work->request.n_where > 0; k++) {
        size_t which = k < work->request.n_where ? k : 0;
        RMAP_TRY(rmap_asked_compile(work->context, &work->asked, which, scene_of(work, k),
                                    &work->named[k], err));
    }
    RMAP_TRY(choose(work, err));
    if (is_paired(work))
        st = compile_pair(work, err);
    else
        for (size_t k = 0; k < 2; k++) {
            work->criterion[k] = work->named[k];
            work->named[k] = NULL;
        }
    RMAP_TRY(st);
    st = share_out(work, err);
out:
    return st;
}

static enum rmap_status check_detector(const struct work *work, struct rmap_error *err)
{
    const char *name = work->request.detector;
    for (int k = 0; k < 2 && name; k++) {
        const struct rmap_scene *scene = scene_of(work, (size_t)k);
        bool found = false;
        for (size_t d = 0; d < scene->n_detector; d++)
            found = found || strcmp(scene->detector[d].name, name) == 0;
        if (!found)
            return rmap_error_set(err, RMAP_INPUT, "no detector named '%s' in '%s'", name,
                                  work->request.path[k]);
    }
    return RMAP_OK;
}

/* What can be said before any ray is read. */
static enum rmap_status prepare(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check_detector(work, err));
    RMAP_TRY(compile(work, err));
    const char *text[2] = {NULL, NULL};
    for (size_t k = 0; k < 2 && work->request.n_where > 0; k++)
        text[k] = work->request.where[k < work->request.n_where ? k : 0];
    const struct rmap_map *const map[2] = {work->map[0], work->map[1]};
    const struct rmap_overlay *const overlay[2] = {work->overlay[0], work->overlay[1]};
    RMAP_TRY(
        rmap_comparison_create(map, overlay, work->request.path, text, &work->comparison, err));
    for (int k = 0; k < 2; k++)
        work->comparison->which[k] = work->own[k];
    for (int k = 0; k < 2; k++)
        RMAP_TRY(rmap_compare_layout_init(&work->layout[k], work->map[k], work->overlay[k], err));
out:
    return st;
}

/* Collective. What each sample adds up to, on rank 0. */
static enum rmap_status add_up(struct work *work, struct rmap_error *err)
{
    const struct rmap_compare_sum sum = {
        .kind = &rmap_compare_sums_kind,
        .context = {&work->layout[0], &work->layout[1]},
        .alone = &work->alone,
        .columns = {RMAP_COMPARE_SUMS_COLUMNS, RMAP_COMPARE_SUMS_COLUMNS},
        .n_sample = RMAP_COMPARE_SAMPLES};
    work->alone = work->layout[0];
    work->alone.registrations_alone = true;
    return rmap_compare_samples_run(work->context, &work->samples, &sum, work->sums, err);
}

/* Collective. The groups of cells that rank 0 made of the images to look at again. */
static enum rmap_status share_groups(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_comparison *comparison = work->comparison;
    uint64_t n_again = comparison->n_again;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&n_again, 1, MPI_UINT64_T, 0, work->context->comm)));
    if (work->context->rank > 0 && n_again > 0) {
        comparison->again = rmap_alloc((size_t)n_again, sizeof *comparison->again);
        if (comparison->again)
            comparison->n_again = (size_t)n_again;
        else
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for images");
    }
    RMAP_TRY(rmap_agree(work->context, st, err));
    for (size_t i = 0; i < n_again; i++) {
        struct rmap_compare_again *again = &comparison->again[i];
        uint64_t number[3] = {again->detector[0], again->detector[1], again->n_group};
        RMAP_TRY(RMAP_MPI(MPI_Bcast(number, 3, MPI_UINT64_T, 0, work->context->comm)));
        again->detector[0] = (size_t)number[0];
        again->detector[1] = (size_t)number[1];
        again->n_group = (size_t)number[2];
        const size_t *first = work->layout[0].first_cell + number[0];
        size_t nbytes = (first[1] - first[0]) * sizeof *again->group;
        uint8_t *blob = (uint8_t *)again->group;
        st = rmap_broadcast_blob(work->context, &blob, &nbytes, err);
        again->group = (int32_t *)(void *)blob;
        RMAP_TRY(st);
    }
out:
    return st;
}

/* Collective. A second look at images that rays count in several times. */
static enum rmap_status look_again(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(share_groups(work, err));
    if (work->comparison->n_again == 0)
        goto out;
    for (int k = 0; k < 2 && st == RMAP_OK; k++)
        st = rmap_compare_products_layout_init(&work->products_layout[k], &work->layout[k],
                                               work->comparison, k, err);
    RMAP_TRY(rmap_agree(work->context, st, err));
    const struct rmap_compare_sum sum = {
        .kind = &rmap_compare_products_kind,
        .context = {&work->products_layout[0], &work->products_layout[1]},
        .alone = &work->products_layout[0],
        .columns = {RMAP_COMPARE_SUMS_COLUMNS, RMAP_COMPARE_SUMS_COLUMNS},
        .n_sample = 2};
    RMAP_TRY(rmap_compare_samples_run(work->context, &work->samples, &sum, work->products, err));
    if (work->context->rank == 0)
        st = rmap_comparison_add_products(
            work->comparison, work->sums[2],
            (const struct rmap_compare_products *const[]){work->products[0], work->products[1]},
            err);
    RMAP_TRY(rmap_agree(work->context, st, err));
out:
    return st;
}

/* Collective. Distributions of paths and numbers. */
static enum rmap_status add_fields(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_compare_request *request = &work->request;
    if (request->kinds & 1u << RMAP_COMPARE_PATHS)
        RMAP_TRY(rmap_compare_paths_run(work->context, &work->samples, work->comparison, err));
    for (size_t i = 0; i < request->n_of; i++) {
        const struct rmap_compare_number number = {.of = request->of[i],
                                                   .detector = request->detector,
                                                   .n_bin = (size_t)request->n_bin,
                                                   .range = request->range};
        RMAP_TRY(rmap_compare_number_run(work->context, &work->samples, &number, work->comparison,
                                         request->output_path ? &work->bins[work->n_bins] : NULL,
                                         err));
        work->n_bins += work->bins && work->bins[work->n_bins] ? 1 : 0;
    }
out:
    return st;
}

/* Collective. What is written of the detector. */
static enum rmap_status add_images(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = rmap_compare_images_run(
        work->context, &work->samples, work->request.detector,
        rmap_output_is(work->request.output_path, ".json"), work->comparison, &work->bins[0], err);
    work->n_bins = work->bins[0] ? 1 : 0;
    return st;
}

static enum rmap_status show(const struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (work->request.output_path)
        st = rmap_compare_write(work->comparison,
                                (const struct rmap_compare_bins *const *)work->bins, work->n_bins,
                                work->request.output_path, err);
    if (st != RMAP_OK)
        return st;
    if (work->context->json)
        return rmap_json_print(rmap_comparison_json(work->comparison), stdout, err);
    return rmap_comparison_print(work->comparison, stdout, err);
}

static enum rmap_status compare(struct work *work, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = work->context;
    const struct rmap_compare_request *request = &work->request;
    if (request->output_path) {
        work->bins = rmap_alloc(request->n_of + 1, sizeof *work->bins);
        if (!work->bins)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for differences");
    }
    if (st == RMAP_OK)
        st = prepare(work, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(add_up(work, err));
    if (context->rank == 0)
        st = rmap_comparison_add_sums(
            work->comparison,
            (const struct rmap_compare_sums *const[]){work->sums[0], work->sums[1], work->sums[2]},
            request->kinds, request->detector, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(look_again(work, err));
    RMAP_TRY(add_fields(work, err));
    if (request->output_path && request->n_of == 0)
        RMAP_TRY(add_images(work, err));
    if (context->rank == 0)
        st = rmap_comparison_conclude(work->comparison, request->significance, request->correction,
                                      err);
    if (context->rank == 0 && st == RMAP_OK)
        st = show(work, err);
    st = rmap_agree(context, st, err);
out:
    return st;
}

static void work_fini(struct work *work)
{
    for (size_t i = 0; i < RMAP_COMPARE_SAMPLES; i++) {
        rmap_compare_sums_kind.destroy(work->sums[i]);
        rmap_criterion_destroy(work->criterion[i]);
    }
    for (size_t k = 0; k < 3; k++)
        rmap_which_destroy(work->shared[k]);
    for (size_t k = 0; k < 2; k++) {
        rmap_compare_products_kind.destroy(work->products[k]);
        rmap_compare_products_layout_fini(&work->products_layout[k]);
        rmap_compare_layout_fini(&work->layout[k]);
        rmap_which_destroy(work->own[k]);
        rmap_criterion_destroy(work->named[k]);
    }
    rmap_comparison_destroy(work->comparison);
    for (size_t i = 0; i < work->n_bins; i++)
        rmap_compare_bins_destroy(work->bins[i]);
    rmap_free(work->bins);
    rmap_asked_fini(&work->asked);
    if (work->overlay[1] != work->overlay[0])
        rmap_overlay_destroy(work->overlay[1]);
    rmap_overlay_destroy(work->overlay[0]);
    if (work->map[1] != work->map[0])
        rmap_map_close(work->map[1]);
    rmap_map_close(work->map[0]);
    rmap_compare_request_fini(&work->request);
}

static enum rmap_status run_compare(const struct rmap_context *context,
                                    const struct rmap_arguments *given, struct rmap_error *err)
{
    struct work work = {.context = context, .given = given};
    struct rmap_compare_request *request = &work.request;
    enum rmap_status st = rmap_compare_request_read(given, request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load(context, given, (const char *const *)request->where, request->n_where,
                             &work.asked, err));
    RMAP_TRY(rmap_load_map(context, request->path[0], &work.map[0], err));
    if (given->n_operand == 1)
        work.map[1] = work.map[0];
    else
        RMAP_TRY(rmap_load_map(context, request->path[1], &work.map[1], err));
    RMAP_TRY(rmap_overlay_load(context, given, work.map[0], &work.overlay[0], err));
    if (given->n_operand == 1)
        work.overlay[1] = work.overlay[0];
    else
        RMAP_TRY(rmap_overlay_load(context, given, work.map[1], &work.overlay[1], err));
    st = compare(&work, err);
out:
    work_fini(&work);
    return st;
}

const struct rmap_command rmap_command_compare = {
    .name = "compare",
    .summary = "whether two maps, or two criteria, are statistically the same",
    .operands = "MAP MAP2 [--where CRITERION] | MAP --where A --where B",
    .help = "Tests whatever has a name in both: flux of the rays that match, registered by each\n"
            "detector, absorbed by each object and medium, how rays ended (z, of the difference\n"
            "over its standard error), each detector's image and the classes of paths\n"
            "(chi-square); with --of the distribution of a number. The verdict is corrected for\n"
            "the number of tests. Exit status 0 whatever it is:\n\n"
            "  raymap compare before.raymap after.raymap --where 'registered(sensor)'\n"
            "  raymap compare lens.raymap --where 'hit(left.*)' --where 'hit(right.*)'\n\n"
            "Maps of one seed hold the same random numbers: trace one of them with --seed.",
    .options = options,
    .min_operands = 1,
    .max_operands = 2,
    .run = run_compare,
};
