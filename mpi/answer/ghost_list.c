/* SPDX-License-Identifier: MIT
 *
 * The ghosts on a detector, found, and printed.
 */
#include "mpi/answer/ghost_list.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_matrix.h"
#include "analysis/paths/path_text.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

/* What rank 0 found, as texts that end with 0: of each row the order, the surfaces, the criterion.
 */
struct texts {
    char *bytes;
    size_t nbytes, cap;
};

static enum rmap_status put(struct texts *texts, struct rmap_error *err, const char *format, ...)
    RMAP_PRINTF(3, 4);
static enum rmap_status put(struct texts *texts, struct rmap_error *err, const char *format, ...)
{
    enum rmap_status st = RMAP_OK;
    va_list list, again;
    va_start(list, format);
    va_copy(again, list);
    const int n = vsnprintf(NULL, 0, format, again);
    va_end(again);
    RMAP_TRY(RMAP_RESERVE(texts->bytes, texts->cap, texts->nbytes + (size_t)n + 1, err));
    (void)vsnprintf(texts->bytes + texts->nbytes, (size_t)n + 1, format, list);
    texts->nbytes += (size_t)n + 1;
out:
    va_end(list);
    return st;
}

/* What finds the rows; on rank 0 alone they are put into texts. */
struct finding {
    struct rmap_path_matrix matrix;
    struct rmap_path_order order;
    struct rmap_path_keys *keys;
    const char *joint, *close; /* around what the rays must match, too */
    const char *where;
    uint64_t top;
    enum rmap_path_level level;
    struct rmap_ghost_list *list;
};

static enum rmap_status put_order(const struct finding *f, const char *detector, uint32_t order,
                                  struct texts *texts, struct rmap_error *err)
{
    enum rmap_status st = put(texts, err, "%" PRIu32, order);
    if (st == RMAP_OK)
        st = put(texts, err, "%s", "");
    if (st == RMAP_OK)
        st = put(texts, err,
                 "%s%s%sregistered(%s where ghost_order %s %" PRIu32 " and scatter_order == 0)",
                 f->joint, f->where, f->close, detector,
                 order >= RMAP_PATH_ORDER_MOST ? ">=" : "==", order);
    return st;
}

/* A body whose faces are one object says not which of them made the ghost. */
static void note_body(const struct finding *f, uint32_t label)
{
    const struct rmap_scene *scene = rmap_map_scene(f->matrix.map);
    for (size_t o = 0; o < scene->n_object && !f->list->body; o++) {
        const struct rmap_mesh *mesh = scene->geometry[scene->object[o].geometry].mesh;
        if (f->level == RMAP_PATH_SURFACE && rmap_path_labels(f->keys)[o] == (int32_t)label &&
            mesh && mesh->n_face > 1)
            f->list->body = scene->object[o].name;
    }
}

static enum rmap_status put_pair(const struct finding *f, const struct rmap_path_cellsum *sum,
                                 struct texts *texts, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *criterion = NULL;
    note_body(f, sum->a);
    note_body(f, sum->b);
    RMAP_TRY(rmap_path_ghost_criterion(f->keys, &f->order, sum->a, sum->b, f->matrix.detector,
                                       &criterion, err));
    RMAP_TRY(put(texts, err, "2"));
    RMAP_TRY(put(texts, err, "%s then %s", rmap_path_label(f->keys, sum->a),
                 rmap_path_label(f->keys, sum->b)));
    st = put(texts, err, "%s%s%s%s", f->joint, f->where, f->close, criterion);
out:
    rmap_free(criterion);
    return st;
}

static enum rmap_status put_rows(const struct finding *f, const struct rmap_path_cellsum *sum,
                                 size_t n, struct texts *texts, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *detector = NULL;
    uint64_t n_pair = 0;
    RMAP_TRY(rmap_path_quote(f->list->detector->name, &detector, err));
    RMAP_TRY(put_order(f, detector, 0, texts, err));
    for (size_t i = 0; i < n; i++) {
        if (sum[i].part != RMAP_PATH_GHOSTS)
            continue;
        if (n_pair++ < f->top) {
            RMAP_TRY(put_pair(f, &sum[i], texts, err));
            continue;
        }
        f->list->n_left++;
        f->list->flux_left += sum[i].flux;
    }
    for (size_t i = 0; i < n; i++)
        if (sum[i].part == RMAP_PATH_ORDERS && sum[i].b == 0 && sum[i].a > 0 && sum[i].a != 2)
            RMAP_TRY(put_order(f, detector, sum[i].a, texts, err));
out:
    rmap_free(detector);
    return st;
}

/* On all ranks, from what rank 0 put. */
static enum rmap_status take_rows(const struct texts *texts, struct rmap_ghost_list *list,
                                  struct rmap_error *err)
{
    size_t n = 0;
    for (size_t i = 0; i < texts->nbytes; i++)
        n += texts->bytes[i] == 0;
    list->ghost = rmap_alloc(n / 3 + 1, sizeof *list->ghost);
    if (!list->ghost)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu ghosts", n / 3);
    const char *at = texts->bytes;
    for (; list->n < n / 3; list->n++) {
        struct rmap_ghost *ghost = &list->ghost[list->n];
        ghost->order = (uint32_t)strtoul(at, NULL, 10);
        at += strlen(at) + 1;
        ghost->surfaces = *at ? rmap_strdup(at) : NULL;
        bool good = ghost->surfaces || !*at;
        at += strlen(at) + 1;
        ghost->criterion = rmap_strdup(at);
        at += strlen(at) + 1;
        if (!good || !ghost->criterion)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu ghosts", n / 3);
    }
    return RMAP_OK;
}

/* Collective. Which pairs and orders there are. */
static enum rmap_status scan(const struct rmap_context *context,
                             const struct rmap_criterion *criterion, struct finding *f,
                             struct texts *texts, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_cellsum *sum = NULL;
    struct rmap_which *which = NULL;
    void *sums = NULL;
    size_t n = 0;
    const struct rmap_index_set only = {.low = f->matrix.detector, .span = 1};
    st =
        rmap_which_create(rmap_map_scene(f->matrix.map), &only, NULL, NULL, criterion, &which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_fold fold = {.kind = &rmap_path_matrix_kind,
                                   .context = &f->matrix,
                                   .map = f->matrix.map,
                                   .criterion = criterion,
                                   .which = which,
                                   .columns = rmap_path_matrix_columns(&f->matrix)};
    RMAP_TRY(rmap_fold_run(context, &fold, &sums, err));
    if (context->rank == 0) {
        st = rmap_path_matrix_list(sums, &sum, &n, err);
        if (st == RMAP_OK)
            st = put_rows(f, sum, n, texts, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_free(sum);
    rmap_path_matrix_kind.destroy(sums);
    rmap_which_destroy(which);
    return st;
}

enum rmap_status rmap_ghost_list_find(const struct rmap_context *context,
                                      const struct rmap_map *map,
                                      const struct rmap_criterion *criterion, int32_t detector,
                                      enum rmap_path_level level, uint64_t top,
                                      struct rmap_ghost_list **list_ret, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    const struct rmap_path_view view = {
        .level = level, .until_detector = true, .detector = detector};
    struct finding f = {.joint = criterion ? "(" : "",
                        .where = criterion ? rmap_criterion_text(criterion) : "",
                        .close = criterion ? ") and " : "",
                        .top = top,
                        .level = level};
    struct texts texts = {NULL, 0, 0};
    struct rmap_ghost_list *list = rmap_alloc(1, sizeof *list);
    enum rmap_status st = list ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (st == RMAP_OK)
        st = rmap_path_keys_create(scene, &view, &f.keys, err);
    if (st == RMAP_OK)
        st = rmap_path_order_init(&f.order, scene, err);
    RMAP_TRY(rmap_agree(context, st, err));
    list->detector = &scene->detector[detector];
    f.list = list;
    f.matrix = (struct rmap_path_matrix){.map = map,
                                         .keys = f.keys,
                                         .order = &f.order,
                                         .criterion = criterion ? f.where : NULL,
                                         .detector = detector,
                                         .parts = RMAP_PATH_PART_BIT(RMAP_PATH_ORDERS) |
                                                  RMAP_PATH_PART_BIT(RMAP_PATH_GHOSTS)};
    RMAP_TRY(scan(context, criterion, &f, &texts, err));
    uint8_t *blob = (uint8_t *)texts.bytes;
    st = rmap_broadcast_blob(context, &blob, &texts.nbytes, err);
    texts.bytes = (char *)blob;
    RMAP_TRY(st);
    st = take_rows(&texts, list, err);
    RMAP_TRY(rmap_agree(context, st, err));
    *list_ret = list;
    list = NULL;
out:
    rmap_free(texts.bytes);
    rmap_path_order_fini(&f.order);
    rmap_path_keys_destroy(f.keys);
    rmap_ghost_list_destroy(list);
    return st;
}

void rmap_ghost_list_destroy(struct rmap_ghost_list *list)
{
    if (!list)
        return;
    for (size_t i = 0; i < list->n; i++) {
        rmap_free(list->ghost[i].surfaces);
        rmap_free(list->ghost[i].criterion);
    }
    rmap_free(list->ghost);
    rmap_free(list);
}

void rmap_ghost_list_take(struct rmap_ghost_list *list, size_t row,
                          const struct rmap_detector_image *image)
{
    struct rmap_ghost *ghost = &list->ghost[row];
    const size_t c = image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0];
    ghost->flux = image->flux;
    ghost->flux_error = image->flux_error;
    ghost->registrations = image->registrations;
    ghost->peak = image->peak;
    ghost->peak_error = image->standard_error[c];
    ghost->peak_x = image->peak_x;
    ghost->peak_y = image->peak_y;
    ghost->centroid[0] = image->centroid[0];
    ghost->centroid[1] = image->centroid[1];
    ghost->rms_radius = image->rms_radius;
    list->quantity = image->quantity;
    list->unit = image->unit;
    list->flux_unit = image->flux_unit;
    list->place_unit = rmap_detector_image_coordinate_unit(image);
}

/* "lens.5 then lens.3", "direct image", "4 reflections", "9 or more reflections" */
static void add_name(struct rmap_text_table *table, const struct rmap_ghost *ghost)
{
    if (ghost->surfaces || ghost->order == 0)
        rmap_text_table_add(table, "%s", ghost->surfaces ? ghost->surfaces : "direct image");
    else
        rmap_text_table_add(table, "%" PRIu32 "%s reflection%s", ghost->order,
                            ghost->order >= RMAP_PATH_ORDER_MOST ? " or more" : "",
                            ghost->order > 1 ? "s" : "");
}

static double ratio_of(const struct rmap_ghost_list *list, const struct rmap_ghost *ghost)
{
    return list->ghost[0].flux > 0.0 ? ghost->flux / list->ghost[0].flux : (double)NAN;
}

static void add_number(struct rmap_text_table *table, double value, int digits)
{
    if (isfinite(value))
        rmap_text_table_add(table, "%.*g", digits, value);
    else
        rmap_text_table_add(table, "-");
}

static void add_row(const struct rmap_ghost_list *list, size_t row, struct rmap_text_table *table)
{
    const struct rmap_ghost *ghost = &list->ghost[row];
    rmap_text_table_add(table, "%zu", row);
    add_name(table, ghost);
    add_number(table, ghost->registrations, 10);
    add_number(table, ghost->flux, 4);
    add_number(table, ghost->flux_error, 2);
    add_number(table, ratio_of(list, ghost), 3);
    add_number(table, ghost->peak, 4);
    add_number(table, ghost->peak_error, 2);
    add_number(table, ghost->peak_x, 4);
    add_number(table, ghost->peak_y, 4);
    add_number(table, ghost->rms_radius, 3);
}

enum rmap_status rmap_ghost_list_print(const struct rmap_ghost_list *list, FILE *out,
                                       struct rmap_error *err)
{
    static const char *const head[] = {
        "#", "reflections at", "seen", "flux", "+-", "ratio", "peak", "+-", "x", "y", "RMS radius"};
    enum rmap_status st = RMAP_OK;
    struct rmap_text_table table;
    rmap_text_table_init(&table, sizeof head / sizeof *head);
    for (size_t k = 0; k < sizeof head / sizeof *head; k++)
        rmap_text_table_add(&table, "%s", head[k]);
    for (size_t row = 0; row < list->n; row++)
        add_row(list, row, &table);
    fprintf(out, "%s: flux in %s, peak %s in %s, places and sizes in %s\n", list->detector->name,
            list->flux_unit, list->quantity, list->unit, list->place_unit);
    RMAP_TRY(rmap_text_table_print(&table, "rlrrrrrrrrr", out, err));
    if (list->n_left > 0)
        fprintf(out, "and %zu pairs more: %.4g %s\n", list->n_left, list->flux_left,
                list->flux_unit);
    fputs("\ncriteria\n", out);
    for (size_t row = 0; row < list->n; row++)
        fprintf(out, "%zu  %s\n", row, list->ghost[row].criterion);
out:
    rmap_text_table_fini(&table);
    return st;
}

void rmap_ghost_list_csv(const struct rmap_ghost_list *list, FILE *out)
{
    fprintf(out,
            "# detector: %s\n# flux: %s; %s: %s; places: %s\n"
            "number,order,surfaces,registrations,flux,standard_error,ratio,peak,"
            "peak_standard_error,peak_x,peak_y,centroid_x,centroid_y,rms_radius,criterion\n",
            list->detector->name, list->flux_unit, list->quantity, list->unit, list->place_unit);
    for (size_t row = 0; row < list->n; row++) {
        const struct rmap_ghost *ghost = &list->ghost[row];
        const double number[] = {ghost->peak_x, ghost->peak_y, ghost->centroid[0],
                                 ghost->centroid[1], ghost->rms_radius};
        fprintf(out, "%zu,%" PRIu32, row, ghost->order);
        rmap_csv_put_text(ghost->surfaces, out);
        rmap_csv_put_number(ghost->registrations, out);
        rmap_csv_put_estimate(ghost->flux, ghost->flux_error, out);
        rmap_csv_put_number(ratio_of(list, ghost), out);
        rmap_csv_put_estimate(ghost->peak, ghost->peak_error, out);
        for (size_t k = 0; k < sizeof number / sizeof *number; k++)
            rmap_csv_put_number(number[k], out);
        rmap_csv_put_text(ghost->criterion, out);
        fputc('\n', out);
    }
}

json_t *rmap_ghost_list_json(const struct rmap_ghost_list *list)
{
    json_t *rows = json_array();
    for (size_t row = 0; row < list->n; row++) {
        const struct rmap_ghost *g = &list->ghost[row];
        (void)json_array_append_new(
            rows,
            json_pack("{s:i, s:s?, s:I, s:{s:o, s:o}, s:o, s:{s:o, s:o, s:o, s:o}, s:[o, o], s:o, "
                      "s:s}",
                      "order", (int)g->order, "surfaces", g->surfaces, "registrations",
                      (json_int_t)llround(g->registrations), "flux", "value",
                      rmap_json_number(g->flux), "standard_error", rmap_json_number(g->flux_error),
                      "ratio", rmap_json_number(ratio_of(list, g)), "peak", "value",
                      rmap_json_number(g->peak), "standard_error", rmap_json_number(g->peak_error),
                      "x", rmap_json_number(g->peak_x), "y", rmap_json_number(g->peak_y),
                      "centroid", rmap_json_number(g->centroid[0]),
                      rmap_json_number(g->centroid[1]), "rms_radius",
                      rmap_json_number(g->rms_radius), "criterion", g->criterion));
    }
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:{s:I, s:o}}", "detector",
                     list->detector->name, "flux_unit", list->flux_unit, "quantity", list->quantity,
                     "unit", list->unit, "length_unit", list->place_unit, "rows", rows, "rest",
                     "pairs", (json_int_t)list->n_left, "flux", rmap_json_number(list->flux_left));
}
