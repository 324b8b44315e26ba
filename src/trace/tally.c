/* SPDX-License-Identifier: MIT
 *
 * Sums kept while tracing, per source: the energy balance (emitted = absorbed by each object +
 * absorbed in each medium + left + limits + errors, exact in rays) and the detectors' images.
 */
#include <stddef.h>
#include <string.h>

#include "base/alloc.h"
#include "portion/event.h"
#include "portion/weight.h"
#include "trace/luminescence.h"
#include "trace/tally.h"

/* False, with *product unset, when a x b does not fit. */
static bool multiply(size_t a, size_t b, size_t *product)
{
    if (b && a > SIZE_MAX / b)
        return false;
    *product = a * b;
    return true;
}

/* Values of the images in all, and where each detector's begin. */
static bool lay_out_images(struct rmap_tally *tally, size_t *n_image)
{
    const struct rmap_scene *scene = tally->scene;
    size_t at = 0;
    for (size_t d = 0; d < scene->n_detector; d++) {
        size_t cells, values;
        tally->image_offset[d] = at;
        if (!multiply(scene->detector[d].cells[0], scene->detector[d].cells[1], &cells) ||
            !multiply(cells, scene->n_source, &values) || values > SIZE_MAX / 4 - at)
            return false;
        at += values;
    }
    tally->image_offset[scene->n_detector] = at;
    *n_image = at;
    return true;
}

/* Sizes of the block's parts, in its order; false when they do not fit. */
#define N_PART 11
static bool measure(const struct rmap_scene *scene, size_t n_image, size_t part[N_PART],
                    size_t *n_value)
{
    size_t source = scene->n_source;
    part[0] = part[3] = part[4] = part[5] = source;
    part[6] = 1;
    part[7] = part[8] = n_image;
    part[9] = scene->n_medium;
    part[10] = rmap_scene_changes_weights(scene) ? n_image : 0;
    if (!multiply(source, scene->n_object, &part[1]) ||
        !multiply(source, scene->n_medium, &part[2]))
        return false;
    *n_value = 0;
    for (int k = 0; k < N_PART; k++) {
        if (part[k] > SIZE_MAX / sizeof(double) - *n_value)
            return false;
        *n_value += part[k];
    }
    return true;
}

enum rmap_status rmap_tally_create(const struct rmap_scene *scene, struct rmap_tally **tally_ret,
                                   struct rmap_error *err)
{
    struct rmap_tally *tally = rmap_alloc(1, sizeof *tally);
    size_t n_image = 0, part[N_PART];
    if (!tally)
        goto failed;
    tally->scene = scene;
    tally->first_error_ray = UINT64_MAX;
    tally->image_offset = rmap_alloc(scene->n_detector + 1, sizeof *tally->image_offset);
    if (!tally->image_offset || !lay_out_images(tally, &n_image) ||
        !measure(scene, n_image, part, &tally->n_value))
        goto failed;
    tally->value = rmap_alloc(tally->n_value, sizeof *tally->value);
    if (!tally->value)
        goto failed;
    double **field[N_PART] = {
        &tally->emitted,       &tally->absorbed_object, &tally->absorbed_medium,   &tally->left,
        &tally->limit,         &tally->error,           &tally->segments,          &tally->image,
        &tally->image_squared, &tally->left_elsewhere,  &tally->image_squared_rest};
    double *at = tally->value;
    for (int k = 0; k < N_PART; k++) {
        *field[k] = at;
        at += part[k];
    }
    if (!rmap_scene_changes_weights(scene))
        tally->image_squared_rest = NULL;
    *tally_ret = tally;
    return RMAP_OK;
failed:
    rmap_tally_destroy(tally);
    return rmap_error_set(err, RMAP_SYSTEM,
                          "out of memory for the sums of %zu sources, %zu objects, %zu detectors",
                          scene->n_source, scene->n_object, scene->n_detector);
}

void rmap_tally_destroy(struct rmap_tally *tally)
{
    if (!tally)
        return;
    rmap_free(tally->value);
    rmap_free(tally->image_offset);
    rmap_free(tally);
}

void rmap_tally_merge(struct rmap_tally *into, const struct rmap_tally *from)
{
    for (size_t i = 0; i < into->n_value; i++)
        into->value[i] += from->value[i];
    if (from->first_error_ray < into->first_error_ray)
        into->first_error_ray = from->first_error_ray;
}

static size_t cells_of(const struct rmap_scene *scene, size_t detector)
{
    return (size_t)scene->detector[detector].cells[0] * scene->detector[detector].cells[1];
}

const double *rmap_tally_image(const struct rmap_tally *tally, size_t detector, size_t source)
{
    return tally->image + tally->image_offset[detector] + source * cells_of(tally->scene, detector);
}

static void emit(struct rmap_recorder *self, const struct rmap_emission *emission)
{
    struct rmap_tally_recorder *recorder = (struct rmap_tally_recorder *)self;
    recorder->source = emission->source;
    recorder->ray = emission->ray;
    recorder->last_object = -1;
    recorder->last_medium = emission->medium;
    recorder->tally->emitted[emission->source] += 1.0;
    if (recorder->next)
        recorder->next->emit(recorder->next, emission);
}

static void step(struct rmap_recorder *self, const struct rmap_step *row)
{
    struct rmap_tally_recorder *recorder = (struct rmap_tally_recorder *)self;
    recorder->last_object = row->object;
    recorder->last_medium = row->medium;
    recorder->tally->segments[0] += 1.0;
    if (recorder->next)
        recorder->next->step(recorder->next, row);
}

static size_t cell_of(const struct rmap_tally *tally, size_t detector, size_t source,
                      uint32_t cell_x, uint32_t cell_y)
{
    return tally->image_offset[detector] + source * cells_of(tally->scene, detector) +
           (size_t)cell_y * tally->scene->detector[detector].cells[0] + cell_x;
}

/* Whole squares, up to 2^20, would leave their sum of multiples of 2^-21 no room to be exact; what
 * is above 1024 is added up in multiples of 2^-12: 2^21 rays of the greatest weight. */
static void tally_add_hit(struct rmap_tally *tally, size_t cell, double weight)
{
    const double squared = weight * weight, part = 1 << 12;
    tally->image[cell] += weight;
    tally->image_squared[cell] += rmap_weight_round(squared);
    if (squared > 1024.0 && tally->image_squared_rest)
        tally->image_squared_rest[cell] +=
            (double)(int64_t)((squared - 1024.0) * part + 0.5) / part;
}

static void tally_add_ending(struct rmap_tally *tally, const struct rmap_tally_ending *ending)
{
    const struct rmap_scene *scene = tally->scene;
    size_t source = (size_t)ending->source;
    switch (ending->stop) {
    case RMAP_STOP_ABSORBED:
        if (ending->object >= 0)
            tally->absorbed_object[source * scene->n_object + (size_t)ending->object] +=
                ending->weight;
        else
            tally->absorbed_medium[source * scene->n_medium + (size_t)ending->medium] +=
                ending->weight;
        break;
    case RMAP_STOP_LEFT:
        tally->left[source] += ending->weight;
        if (ending->medium >= 0 && ending->medium != scene->source[source].medium)
            tally->left_elsewhere[ending->medium] += ending->weight;
        break;
    case RMAP_STOP_LIMIT:
        tally->limit[source] += ending->weight;
        break;
    case RMAP_STOP_ERROR:
    case RMAP_STOP_COUNT:
        tally->error[source] += ending->weight;
        if (ending->ray < tally->first_error_ray)
            tally->first_error_ray = ending->ray;
    }
}

static void keep_hit(struct rmap_tally_recorder *recorder, size_t cell)
{
    if (RMAP_RESERVE(recorder->hit, recorder->cap_hit, recorder->n_hit + 1, NULL) != RMAP_OK) {
        recorder->status = RMAP_SYSTEM;
        return;
    }
    recorder->hit[recorder->n_hit++] = cell;
}

static void add_registration(struct rmap_recorder *self,
                             const struct rmap_registration *registration)
{
    struct rmap_tally_recorder *recorder = (struct rmap_tally_recorder *)self;
    if (registration->registered) {
        const size_t cell =
            cell_of(recorder->tally, (size_t)registration->detector, (size_t)recorder->source,
                    registration->cell[0], registration->cell[1]);
        if (rmap_scene_changes_weights(recorder->tally->scene))
            keep_hit(recorder, cell);
        else
            tally_add_hit(recorder->tally, cell, 1.0); /* analog: every weight is 1 */
    }
    if (recorder->next)
        recorder->next->registration(recorder->next, registration);
}

static void curve(struct rmap_recorder *self, const struct rmap_curve_point *point)
{
    struct rmap_tally_recorder *recorder = (struct rmap_tally_recorder *)self;
    recorder->next->curve(recorder->next, point);
}

static void end(struct rmap_recorder *self, const struct rmap_ending *ending)
{
    struct rmap_tally_recorder *recorder = (struct rmap_tally_recorder *)self;
    tally_add_ending(recorder->tally, &(struct rmap_tally_ending){.ray = recorder->ray,
                                                                  .source = recorder->source,
                                                                  .object = recorder->last_object,
                                                                  .medium = recorder->last_medium,
                                                                  .stop = ending->stop,
                                                                  .weight = ending->weight});
    for (size_t i = 0; i < recorder->n_hit; i++)
        tally_add_hit(recorder->tally, recorder->hit[i], ending->weight);
    recorder->n_hit = 0;
    if (recorder->next)
        recorder->next->end(recorder->next, ending);
}

void rmap_tally_recorder_fini(struct rmap_tally_recorder *recorder)
{
    rmap_free(recorder->hit);
    recorder->hit = NULL;
    recorder->n_hit = recorder->cap_hit = 0;
}

void rmap_tally_recorder_init(struct rmap_tally_recorder *recorder, struct rmap_tally *tally,
                              struct rmap_recorder *next)
{
    *recorder = (struct rmap_tally_recorder){.base = {.emit = emit,
                                                      .step = step,
                                                      .curve = next && next->curve ? curve : NULL,
                                                      .registration = add_registration,
                                                      .end = end},
                                             .next = next,
                                             .tally = tally};
}

/* A ray's rows in the other tables. */
struct ray_rows {
    size_t row, first_segment, n_segment, first_registration, n_registration;
};

static enum rmap_status complain(struct rmap_error *err, const struct rmap_portion *portion,
                                 size_t row, const char *what)
{
    return rmap_error_set(err, RMAP_FORMAT, "ray %llu: %s",
                          (unsigned long long)portion->ray.id[row], what);
}

static bool below(int64_t index, size_t n)
{
    return index >= 0 && (uint64_t)index < n;
}

static enum rmap_status check_registrations(const struct rmap_scene *scene,
                                            const struct rmap_portion *portion,
                                            const struct ray_rows *rows, struct rmap_error *err)
{
    const struct rmap_registration_columns *columns = &portion->registration;
    for (size_t i = 0; i < rows->n_registration; i++) {
        size_t at = rows->first_registration + i;
        if (!below(columns->detector[at], scene->n_detector))
            return complain(err, portion, rows->row, "a detector that the scene has not");
        const uint32_t *cells = scene->detector[columns->detector[at]].cells;
        if (columns->registered[at] &&
            (columns->cell[2 * at] >= cells[0] || columns->cell[2 * at + 1] >= cells[1]))
            return complain(err, portion, rows->row, "a cell that the detector has not");
    }
    return RMAP_OK;
}

static enum rmap_status check_ray(const struct rmap_scene *scene,
                                  const struct rmap_portion *portion, const struct ray_rows *rows,
                                  struct rmap_error *err)
{
    if (!below(portion->ray.source[rows->row], scene->n_source))
        return complain(err, portion, rows->row, "a source that the scene has not");
    if (portion->ray.stop[rows->row] >= RMAP_STOP_COUNT)
        return complain(err, portion, rows->row, "ended in a way that there is not");
    if (rows->n_segment > 0) {
        size_t last = rows->first_segment + rows->n_segment - 1;
        int32_t object = portion->segment.object[last];
        if (object != -1 && !below(object, scene->n_object))
            return complain(err, portion, rows->row, "an object that the scene has not");
        if (!below(portion->segment.medium[last], scene->n_medium))
            return complain(err, portion, rows->row, "a medium that the scene has not");
    }
    return check_registrations(scene, portion, rows, err);
}

static void add_registrations(struct rmap_tally *tally, const struct rmap_portion *portion,
                              const struct ray_rows *rows)
{
    const struct rmap_registration_columns *columns = &portion->registration;
    size_t source = (size_t)portion->ray.source[rows->row];
    const double weight = rmap_scene_changes_weights(tally->scene)
                              ? rmap_weight_round(portion->ray.weight[rows->row])
                              : 1.0;
    for (size_t i = 0; i < rows->n_registration; i++) {
        size_t at = rows->first_registration + i;
        if (!columns->registered[at])
            continue;
        size_t detector = (size_t)columns->detector[at];
        tally_add_hit(
            tally,
            cell_of(tally, detector, source, columns->cell[2 * at], columns->cell[2 * at + 1]),
            weight);
    }
}

static void add_ray(struct rmap_tally *tally, const struct rmap_portion *portion,
                    const struct ray_rows *rows)
{
    int32_t source = portion->ray.source[rows->row];
    struct rmap_tally_ending ending = {.ray = portion->ray.id[rows->row],
                                       .source = source,
                                       .object = -1,
                                       .medium = tally->scene->source[source].medium,
                                       .stop = (enum rmap_stop)portion->ray.stop[rows->row],
                                       .weight = portion->ray.weight[rows->row]};
    if (rows->n_segment > 0) {
        size_t last = rows->first_segment + rows->n_segment - 1;
        ending.object = portion->segment.object[last];
        ending.medium = portion->segment.medium[last];
    }
    tally->emitted[source] += 1.0;
    tally->segments[0] += (double)rows->n_segment;
    add_registrations(tally, portion, rows);
    tally_add_ending(tally, &ending);
}

/* The next ray's rows; false when there are not that many. */
static bool advance(const struct rmap_portion *portion, struct ray_rows *rows, size_t row)
{
    rows->row = row;
    rows->first_segment += rows->n_segment;
    rows->first_registration += rows->n_registration;
    rows->n_segment = portion->ray.segment_count[row];
    rows->n_registration = portion->ray.registration_count[row];
    return rows->n_segment <= portion->n_row[RMAP_TABLE_SEGMENT] - rows->first_segment &&
           rows->n_registration <=
               portion->n_row[RMAP_TABLE_REGISTRATION] - rows->first_registration;
}

enum rmap_status rmap_tally_add_rows(struct rmap_tally *tally, const struct rmap_portion *portion,
                                     const size_t first[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    const size_t n = portion->n_row[RMAP_TABLE_RAY];
    const struct ray_rows begin = {.first_segment = first[RMAP_TABLE_SEGMENT],
                                   .first_registration = first[RMAP_TABLE_REGISTRATION]};
    struct ray_rows rows = begin;
    for (size_t i = first[RMAP_TABLE_RAY]; i < n; i++) {
        if (!advance(portion, &rows, i))
            return complain(err, portion, i,
                            "counts more segments or registrations than there are");
        enum rmap_status st = check_ray(tally->scene, portion, &rows, err);
        if (st != RMAP_OK)
            return st;
    }
    if (rows.first_segment + rows.n_segment != portion->n_row[RMAP_TABLE_SEGMENT] ||
        rows.first_registration + rows.n_registration != portion->n_row[RMAP_TABLE_REGISTRATION])
        return rmap_error_set(err, RMAP_FORMAT, "segments or registrations that belong to no ray");
    rows = begin;
    for (size_t i = first[RMAP_TABLE_RAY]; i < n && advance(portion, &rows, i); i++)
        add_ray(tally, portion, &rows);
    return RMAP_OK;
}

enum rmap_status rmap_tally_add_portion(struct rmap_tally *tally,
                                        const struct rmap_portion *portion, struct rmap_error *err)
{
    const size_t first[RMAP_TABLE_COUNT] = {0};
    return rmap_tally_add_rows(tally, portion, first, err);
}
