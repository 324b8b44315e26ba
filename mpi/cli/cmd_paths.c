/* SPDX-License-Identifier: MIT
 *
 * raymap paths: which ways the light took, and how much of it took each.
 */
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "analysis/paths/path_matrix.h"
#include "analysis/paths/path_matrix_out.h"
#include "analysis/paths/path_report_out.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
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
#include "mpi/scan/path_run.h"

enum { TOP_DEFAULT = 20 };

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'registered(sensor)'"},
    RMAP_ASKED_WHICH_OPTION,
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    {"by", 0, "LEVEL", "whose names count: surface (default), object or group",
     .words = "surface object group"},
    {"no-events", 0, NULL, "tell paths apart by where they went, not by what happened there"},
    {"collapse", 0, NULL, "equal steps in a row count as one"},
    {"detector", 'd', "NAME", "only rays registered there, and their paths until then",
     .words = "@detectors"},
    {"first", 0, NULL, "of a ray registered there several times, the first time alone", "detector"},
    {"top", 0, "N", "so many classes (default 20); all: every one"},
    {"sort", 0, "BY", "flux (default), share, rays or length (segments per ray)",
     .words = "flux share rays length"},
    {"exact", 0, "N", "count up to N classes exactly (default 786432), the largest beyond"},
    {"no-peaks", 0, NULL, "without the brightest cells of the classes"},
    {"matrix", 0, "LIST", "what detectors saw, by orders, ghosts or contribution; all: these three",
     .words = "orders ghosts contribution all"},
    {"output", 'o', "OUT",
     "OUT.csv or OUT.json: all columns of those classes; CSV with --matrix: that matrix"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

static const char *const suffixes[] = {".csv", ".json", NULL};

struct request {
    const char *map_path, *where, *detector, *output_path;
    struct rmap_path_request paths;
    struct rmap_path_matrix matrix; /* parts 0: none wanted */
    struct rmap_path_order order;
};

/* What is shown, on rank 0. */
struct answer {
    struct rmap_path_report *report;
    struct rmap_path_cellsum *sum; /* of the matrix */
    size_t n_sum;
};

static enum rmap_status find_word(const char *option, const char *text, const char *const *word,
                                  size_t n, int *found, struct rmap_error *err)
{
    for (size_t i = 0; i < n; i++)
        if (strcmp(text, word[i]) == 0) {
            *found = (int)i;
            return RMAP_OK;
        }
    const char *nearest = rmap_nearest_word(text, word, n);
    char choices[96] = "";
    for (size_t i = 0, at = 0; i < n && at < sizeof choices; i++) {
        const char *joint = i == 0 ? "" : i + 1 == n ? " or " : ", ";
        at += (size_t)snprintf(choices + at, sizeof choices - at, "%s%s", joint, word[i]);
    }
    return rmap_error_set(err, RMAP_USAGE, "--%s '%s' is none of: %s%s%s%s", option, text, choices,
                          nearest ? " (did you mean '" : "", nearest ? nearest : "",
                          nearest ? "'?)" : "");
}

static enum rmap_status read_word(const struct rmap_arguments *given, const char *option,
                                  const char *const *word, size_t n, int *found,
                                  struct rmap_error *err)
{
    const char *text = rmap_argument(given, option);
    return text ? find_word(option, text, word, n, found, err) : RMAP_OK;
}

static enum rmap_status read_numbers(const struct rmap_arguments *given,
                                     struct rmap_path_request *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *top = rmap_argument(given, "top");
    if (top && strcmp(top, "all") == 0)
        paths->top = UINT64_MAX;
    else
        RMAP_TRY(rmap_argument_count(given, "top", &paths->top, err));
    RMAP_TRY(rmap_argument_count(given, "exact", &paths->most_classes, err));
    if (paths->most_classes < 16 || paths->most_classes > (uint64_t)1 << 30)
        st = rmap_error_set(err, RMAP_USAGE,
                            "--exact must lie between 16 and 2^30 (64 to 170 bytes for each)");
out:
    return st;
}

static enum rmap_status read_parts(const struct rmap_arguments *given, unsigned *parts,
                                   struct rmap_error *err)
{
    static const char *const word[] = {"orders", "ghosts", "contribution", "all"};
    static const unsigned bits[] = {
        RMAP_PATH_PART_BIT(RMAP_PATH_ORDERS), RMAP_PATH_PART_BIT(RMAP_PATH_GHOSTS),
        RMAP_PATH_PART_BIT(RMAP_PATH_MET),
        RMAP_PATH_PART_BIT(RMAP_PATH_ORDERS) | RMAP_PATH_PART_BIT(RMAP_PATH_GHOSTS) |
            RMAP_PATH_PART_BIT(RMAP_PATH_MET)};
    char **list = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_argument_list(given, "matrix", &list, &n, err);
    for (size_t i = 0; i < n; i++) {
        int found = 0;
        if (st == RMAP_OK)
            st = find_word("matrix", list[i], word, sizeof word / sizeof *word, &found, err);
        *parts |= st == RMAP_OK ? bits[found] : 0;
        rmap_free(list[i]);
    }
    rmap_free(list);
    return st;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    static const char *const level[] = {"surface", "object", "group"};
    static const char *const sort[] = {"flux", "rays", "length", "share"};
    enum rmap_status st = RMAP_OK;
    int by = RMAP_PATH_SURFACE, order = RMAP_PATH_BY_FLUX;
    const bool peaks = !rmap_argument(given, "no-peaks");
    *request = (struct request){.map_path = given->operand[0],
                                .where = rmap_argument(given, "where"),
                                .detector = rmap_argument(given, "detector"),
                                .output_path = rmap_argument(given, "output"),
                                .paths = {.top = TOP_DEFAULT,
                                          .most_classes = RMAP_PATH_CLASSES_MOST,
                                          .most_cells = peaks ? RMAP_PATH_CELLS_MOST : 0}};
    RMAP_TRY(read_word(given, "by", level, sizeof level / sizeof *level, &by, err));
    RMAP_TRY(read_word(given, "sort", sort, sizeof sort / sizeof *sort, &order, err));
    RMAP_TRY(read_numbers(given, &request->paths, err));
    RMAP_TRY(read_parts(given, &request->matrix.parts, err));
    request->paths.sort =
        order < RMAP_PATH_SORT_COUNT ? (enum rmap_path_sort)order : RMAP_PATH_BY_FLUX;
    request->paths.view =
        (struct rmap_path_view){.level = (enum rmap_path_level)by,
                                .without_events = rmap_argument(given, "no-events") != NULL,
                                .collapsed = rmap_argument(given, "collapse") != NULL,
                                .until_detector = request->detector != NULL,
                                .detector = -1};
    if (rmap_argument(given, "which") && !request->detector)
        return rmap_error_set(err, RMAP_USAGE,
                              "--which chooses registrations on a detector: give --detector NAME");
    if (!request->output_path)
        goto out;
    RMAP_TRY(rmap_output_check(request->output_path, suffixes,
                               rmap_argument(given, "force") != NULL, err));
    if ((request->matrix.parts & (request->matrix.parts - 1)) != 0 &&
        rmap_output_is(request->output_path, ".csv"))
        st = rmap_error_set(err, RMAP_USAGE,
                            "a CSV holds one matrix: --matrix orders, ghosts or contribution, or "
                            "-o OUT.json for several");
out:
    return st;
}

static enum rmap_status print_json(const struct request *request, const struct answer *answer,
                                   FILE *out, struct rmap_error *err)
{
    json_t *document = json_pack("{s:s}", "map", request->map_path);
    json_t *paths = rmap_path_report_json(answer->report);
    if (!document || !paths || json_object_update(document, paths) != 0) {
        json_decref(document);
        document = NULL;
    }
    json_decref(paths);
    enum rmap_status st = RMAP_OK;
    if (document)
        st = rmap_path_matrix_json(&request->matrix, answer->sum, answer->n_sum, document, err);
    if (st == RMAP_OK)
        return rmap_json_print(rmap_json_of_map(document, answer->report->map), out, err);
    json_decref(document);
    return st;
}

static enum rmap_status write_file(const struct request *request, const struct answer *answer,
                                   struct rmap_error *err)
{
    const char *path = request->output_path;
    struct rmap_whole_file whole = {0};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    if (rmap_output_is(path, ".json"))
        RMAP_TRY(print_json(request, answer, whole.file, err));
    else if (request->matrix.parts)
        RMAP_TRY(
            rmap_path_matrix_csv(&request->matrix, answer->sum, answer->n_sum, whole.file, err));
    else
        rmap_path_report_csv(answer->report, whole.file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

/* Columns of the terminal; 0: the output is none. */
static size_t terminal_width(void)
{
    struct winsize size = {0};
    if (!isatty(STDOUT_FILENO) || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0)
        return 0;
    return size.ws_col;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (request->output_path)
        RMAP_TRY(write_file(request, answer, err));
    if (context->json) {
        st = print_json(request, answer, stdout, err);
        goto out;
    }
    RMAP_TRY(rmap_path_report_print(answer->report, terminal_width(), stdout, err));
    if (request->matrix.parts)
        st = rmap_path_matrix_print(&request->matrix, answer->sum, answer->n_sum,
                                    request->paths.top, stdout, err);
out:
    return st;
}

struct chosen {
    struct rmap_which *asked, *first, *both; /* both: of these two */
    const struct rmap_which *which;
};

static void chosen_fini(struct chosen *chosen)
{
    rmap_which_destroy(chosen->both);
    rmap_which_destroy(chosen->first);
    rmap_which_destroy(chosen->asked);
}

/* A registration before which there is none on the detector. */
static enum rmap_status choose_first(const struct rmap_scene *scene,
                                     const struct rmap_index_set *detector,
                                     const struct rmap_criterion *criterion, struct chosen *chosen,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *name = scene->detector[detector->low].name;
    const size_t nbytes = 2 * strlen(name) + 40;
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a choice");
    size_t n = (size_t)snprintf(text, nbytes, "not path(\".* V@'");
    for (; *name; name++) { /* a quote is doubled */
        text[n++] = *name;
        if (*name == '\'')
            text[n++] = *name;
    }
    (void)snprintf(text + n, nbytes - n, "' .+\")");
    RMAP_TRY(rmap_which_create(scene, detector, text, NULL, criterion, &chosen->first, err));
    chosen->which = chosen->first;
    if (!rmap_which_chooses(chosen->asked))
        goto out;
    RMAP_TRY(rmap_which_create_with(chosen->asked, chosen->first, true, &chosen->both, err));
    chosen->which = chosen->both;
out:
    rmap_free(text);
    return st;
}

/* Collective. Another fold, over what was registered. */
static enum rmap_status sum_matrix(const struct rmap_context *context, struct request *request,
                                   struct answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_request *paths = &request->paths;
    struct rmap_path_matrix *matrix = &request->matrix;
    void *sums = NULL;
    matrix->map = paths->map;
    matrix->overlay = paths->overlay;
    matrix->keys = paths->keys;
    matrix->order = &request->order;
    matrix->criterion = paths->criterion ? rmap_criterion_text(paths->criterion) : NULL;
    matrix->detector = paths->view.detector;
    st = rmap_path_order_init(&request->order, rmap_map_scene(paths->map), err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_fold fold = {.kind = &rmap_path_matrix_kind,
                                   .context = matrix,
                                   .map = paths->map,
                                   .overlay = paths->overlay,
                                   .criterion = paths->criterion,
                                   .which = paths->which,
                                   .columns = rmap_path_matrix_columns(matrix)};
    RMAP_TRY(rmap_fold_run(context, &fold, &sums, err));
    if (sums)
        st = rmap_path_matrix_list(sums, &answer->sum, &answer->n_sum, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_path_matrix_kind.destroy(sums);
    return st;
}

static enum rmap_status run_paths(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct chosen chosen = {NULL};
    struct rmap_path_keys *keys = NULL;
    struct answer answer = {0};
    struct rmap_path_request *paths = &request.paths;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    if (request.detector)
        st = rmap_find_detector(scene, request.detector, &paths->view.detector, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, scene, &criterion, err);
    if (st == RMAP_OK && request.detector) {
        const struct rmap_index_set only = {.low = paths->view.detector, .span = 1};
        st = rmap_asked_which(context, given, &asked, scene, &only, criterion, &chosen.asked, err);
        chosen.which = chosen.asked;
        if (st == RMAP_OK && rmap_argument(given, "first"))
            st = choose_first(scene, &only, criterion, &chosen, err);
    }
    if (st == RMAP_OK)
        st = rmap_path_keys_create(scene, &paths->view, &keys, err);
    RMAP_TRY(rmap_agree(context, st, err));
    paths->map = map;
    paths->timed = scene->timed;
    paths->overlay = overlay;
    paths->criterion = criterion;
    paths->which = chosen.which;
    paths->keys = keys;
    RMAP_TRY(rmap_path_run(context, paths, &answer.report, err));
    if (request.matrix.parts)
        RMAP_TRY(sum_matrix(context, &request, &answer, err));
    if (context->rank == 0) {
        rmap_tell_hint(context, map, &(struct rmap_choice){criterion, chosen.which},
                       answer.report->total.rays);
        st = show(context, &request, &answer, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_path_report_destroy(answer.report);
    rmap_free(answer.sum);
    rmap_path_order_fini(&request.order);
    rmap_path_keys_destroy(keys);
    chosen_fini(&chosen);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_overlay_destroy(overlay);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_paths = {
    .name = "paths",
    .summary = "which ways the light took, ranked by flux",
    .operands = "MAP [--where CRITERION]",
    .help = "Rays of one source that met the same things in the same order, with the same events,\n"
            "are one class. Prints the classes with most flux: their share, standard error, rays,\n"
            "brightest cell on a detector, a ray to look at, and the criterion that selects\n"
            "exactly this class, to go on with in query, draw, detector or report:\n\n"
            "  raymap paths lens.raymap --detector sensor \\\n"
            "      --where 'registered(sensor where ghost_order >= 1)'",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_paths,
};
