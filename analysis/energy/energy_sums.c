/* SPDX-License-Identifier: MIT
 *
 * Where the light of matching rays ended and which detectors registered it, as sums of weights per
 * source: a kind of fold.
 */
#include "analysis/energy/energy_sums.h"

#include <math.h>
#include <string.h>

#include "analysis/paths/path_shares.h"
#include "base/alloc.h"
#include "portion/event.h"
#include "portion/weight.h"

/* A state of 1 GiB: beyond that the tally of the map would not have fitted either. */
#define VALUE_MAX ((size_t)1 << 27)

/* Sizes of the block's parts, in its order; false when they are beyond reason. */
#define N_PART 9
static bool measure(const struct rmap_energy_sums *sums, size_t part[N_PART], size_t *n_value)
{
    const size_t most = VALUE_MAX / (sums->n_source + 1);
    if (sums->n_end > most || sums->n_detector > most)
        return false;
    part[0] = sums->n_source;
    part[1] = part[2] = sums->n_source * sums->n_end;
    part[3] = part[4] = sums->n_source * sums->n_detector;
    part[5] = sums->n_detector;
    part[6] = part[7] = part[8] = sums->n_source;
    *n_value = 0;
    for (int k = 0; k < N_PART; k++)
        *n_value += part[k];
    return *n_value <= VALUE_MAX;
}

enum rmap_status rmap_energy_sums_create(const struct rmap_energy_scope *scope,
                                         struct rmap_energy_sums **sums_ret, struct rmap_error *err)
{
    const struct rmap_scene *scene = scope->scene;
    struct rmap_energy_sums *sums = rmap_alloc(1, sizeof *sums);
    size_t part[N_PART];
    if (!sums)
        goto failed;
    sums->scope = scope;
    sums->n_source = scene->n_source;
    sums->n_end = scene->n_object + scene->n_medium + 3;
    sums->n_detector = scene->n_detector;
    if (measure(sums, part, &sums->n_value))
        sums->value = rmap_alloc(sums->n_value + 1, sizeof *sums->value);
    if (!sums->value)
        goto failed;
    double **field[N_PART] = {&sums->rays,     &sums->ended,          &sums->ended_squared,
                              &sums->caught,   &sums->caught_squared, &sums->pending,
                              &sums->segments, &sums->weight,         &sums->weight_squared};
    double *at = sums->value;
    for (int k = 0; k < N_PART; k++) {
        *field[k] = at;
        at += part[k];
    }
    *sums_ret = sums;
    return RMAP_OK;
failed:
    rmap_energy_sums_destroy(sums);
    return rmap_error_set(err, RMAP_SYSTEM,
                          "out of memory for the sums of %zu sources, %zu objects, %zu detectors",
                          scene->n_source, scene->n_object, scene->n_detector);
}

void rmap_energy_sums_destroy(struct rmap_energy_sums *sums)
{
    if (!sums)
        return;
    if (sums->shares)
        rmap_path_shares_fini(sums->shares);
    rmap_free(sums->shares);
    rmap_free(sums->value);
    rmap_free(sums);
}

rmap_column_set rmap_energy_columns(const struct rmap_energy_scope *scope)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                              RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                              RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                              RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    if (scope->counts)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    if (scope->ends)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                   RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    return columns;
}

bool rmap_energy_needs_scan(const struct rmap_scene *scene)
{
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE)
            return true;
    return false;
}

/* Index among a source's ends; segment: the ray's last, if it has any. */
static size_t end_of(const struct rmap_scene *scene, const struct rmap_portion *portion, size_t ray,
                     size_t segment)
{
    const size_t n_object = scene->n_object, n_medium = scene->n_medium;
    const bool any = portion->ray.segment_count[ray] > 0;
    switch ((enum rmap_stop)portion->ray.stop[ray]) {
    case RMAP_STOP_ABSORBED:
        if (any && portion->segment.object[segment] >= 0)
            return (size_t)portion->segment.object[segment];
        return n_object + (size_t)(any ? portion->segment.medium[segment]
                                       : scene->source[portion->ray.source[ray]].medium);
    case RMAP_STOP_LEFT:
        return n_object + n_medium;
    case RMAP_STOP_LIMIT:
        return n_object + n_medium + 1;
    default:
        return n_object + n_medium + 2;
    }
}

/* A ray, or `times` rays that are alike. */
struct alike {
    const struct rmap_portion *portion;
    const uint8_t *counts; /* [registrations of the portion] */
    size_t ray;
    double weight, squared, times; /* squared: rmap_weight_squared(weight) */
    double segments;               /* of all of them; 0 where they are not counted */
};

/* Registrations [first, first + n) of a ray. Several in one detector are one contribution of the
 * ray: their sum is squared. */
static inline void add_registrations(struct rmap_energy_sums *sums, const struct alike *rays,
                                     size_t first, size_t n)
{
    const struct rmap_registration_columns *rows = &rays->portion->registration;
    const size_t base = (size_t)rays->portion->ray.source[rays->ray] * sums->n_detector;
    if (n == 1) { /* as most have: nothing to sum up */
        const double times = rays->counts[first] ? rays->times : 0.0;
        sums->caught[base + (size_t)rows->detector[first]] += times * rays->weight;
        sums->caught_squared[base + (size_t)rows->detector[first]] += times * rays->squared;
        return;
    }
    for (size_t i = first; i < first + n; i++)
        if (rays->counts[i])
            sums->pending[rows->detector[i]] += rays->weight;
    for (size_t i = first; i < first + n; i++) {
        double *q = &sums->pending[rows->detector[i]];
        sums->caught[base + (size_t)rows->detector[i]] += rays->times * *q;
        sums->caught_squared[base + (size_t)rows->detector[i]] +=
            rays->times * rmap_weight_squared(*q);
        *q = 0.0;
    }
}

static void add_end(struct rmap_energy_sums *sums, const struct alike *rays, size_t segment_end)
{
    const size_t source = (size_t)rays->portion->ray.source[rays->ray];
    const size_t last = segment_end > 0 ? segment_end - 1 : 0;
    const size_t at =
        source * sums->n_end + end_of(sums->scope->scene, rays->portion, rays->ray, last);
    sums->rays[source] += rays->times;
    sums->ended[at] += rays->times * rays->weight;
    sums->ended_squared[at] += rays->times * rays->squared;
}

static inline void add_count(struct rmap_energy_sums *sums, const struct alike *rays)
{
    const size_t source = (size_t)rays->portion->ray.source[rays->ray];
    sums->rays[source] += rays->times;
    sums->segments[source] += rays->segments;
    sums->weight[source] += rays->times * rays->weight;
    sums->weight_squared[source] += rays->times * rays->squared;
}

/* Adds up rays that are like those before, and adds those before where this one is not. */
static inline void count_one(struct rmap_energy_sums *sums, const struct alike *one,
                             struct alike *before)
{
    const struct rmap_ray_columns *ray = &one->portion->ray;
    if (before->weight != one->weight || ray->source[before->ray] != ray->source[one->ray]) {
        if (before->times > 0.0)
            add_count(sums, before);
        *before = *one;
        before->times = before->segments = 0.0;
    }
    before->times += 1.0;
    before->segments += ray->segment_count[one->ray];
}

/* Light that was absorbed by no object: its medium tells where. */
static bool needs_media(const struct rmap_matched *rays)
{
    const struct rmap_ray_columns *ray = &rays->portion->ray;
    const int32_t *object = rays->portion->segment.object;
    for (size_t i = 0, end = 0; i < rays->portion->n_row[RMAP_TABLE_RAY]; i++) {
        end += ray->segment_count[i];
        if (ray->stop[i] == RMAP_STOP_ABSORBED && ray->segment_count[i] > 0 &&
            object[end - 1] < 0 && (!rays->match || rays->match[i]))
            return true;
    }
    return false;
}

/* The cursor has checked that rows add up and indices exist. */
static enum rmap_status add_rays(struct rmap_energy_sums *sums, const struct rmap_matched *rays,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set media = RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counted;
    size_t segment = 0, registration = 0;
    RMAP_TRY(rmap_fold_fetch(rays, rmap_energy_columns(sums->scope) & ~media, err));
    if (sums->scope->ends && needs_media(rays))
        RMAP_TRY(rmap_fold_fetch(rays, media, err));
    counted = rmap_registrations_counted(rays);
    struct alike one = {.portion = portion, .counts = counted, .times = 1.0};
    struct alike before = one; /* rays in a row that weigh alike and have one source */
    before.times = 0.0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n = portion->ray.registration_count[i];
        const size_t first = registration;
        registration += n;
        if (sums->scope->ends)
            segment += portion->ray.segment_count[i];
        if (rays->match && !rays->match[i])
            continue;
        one.ray = i;
        if (one.weight != portion->ray.weight[i]) { /* most rays weigh what the one before did */
            one.weight = portion->ray.weight[i];
            one.squared = rmap_weight_squared(one.weight);
        }
        if (sums->scope->ends)
            add_end(sums, &one, segment);
        if (sums->scope->counts)
            count_one(sums, &one, &before);
        if (n > 0)
            add_registrations(sums, &one, first, n);
    }
    if (before.times > 0.0)
        add_count(sums, &before);
out:
    return st;
}

/* Path by path; rays with paths of their own one by one. */
static enum rmap_status add_paths(struct rmap_energy_sums *sums, const struct rmap_matched *rays,
                                  const struct rmap_path_summary *summary, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_matched own;
    if (!sums->shares && !(sums->shares = rmap_alloc(1, sizeof *sums->shares)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    RMAP_TRY(rmap_path_shares_count(sums->shares, rays, summary, err));
    for (size_t k = 0; k < sums->shares->n; k++) {
        const size_t row = sums->shares->row[k];
        const size_t n = summary->paths->ray.registration_count[row];
        const struct alike some = {summary->paths,
                                   summary->paths->registration.registered,
                                   row,
                                   1.0,
                                   1.0,
                                   (double)sums->shares->n_ray[k],
                                   (double)sums->shares->n_ray[k] *
                                       summary->paths->ray.segment_count[row]};
        if (sums->scope->ends)
            add_end(sums, &some,
                    summary->first_segment[row] + summary->paths->ray.segment_count[row]);
        if (sums->scope->counts)
            add_count(sums, &some);
        if (n > 0)
            add_registrations(sums, &some, summary->first_registration[row], n);
    }
    RMAP_TRY(rmap_path_shares_own(sums->shares, rays, summary, &own, err));
    if (own.n_match > 0)
        st = add_rays(sums, &own, err);
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_summary summary = {.paths = NULL};
    RMAP_TRY(rmap_fold_path_summary(rays, &summary, err));
    st = rmap_path_shares_matter(rays, &summary) ? add_paths(state, rays, &summary, err)
                                                 : add_rays(state, rays, err);
out:
    return st;
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    struct rmap_energy_sums *sums = NULL;
    enum rmap_status st = rmap_energy_sums_create(context, &sums, err);
    *state_ret = sums;
    return st;
}

static void destroy(void *state)
{
    rmap_energy_sums_destroy(state);
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_energy_sums *sum = into;
    const struct rmap_energy_sums *part = from;
    (void)err;
    for (size_t i = 0; i < sum->n_value; i++)
        sum->value[i] += part->value[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_energy_sums *sums = state;
    block[0] = (struct rmap_fold_block){sums->value, sums->n_value * sizeof *sums->value};
    return 1;
}

/* Without ends or counts a portion counts where a detector saw something. */
static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_energy_scope *scope = context;
    return scope->ends || scope->counts || portion->n_row[RMAP_TABLE_REGISTRATION] > 0;
}

const struct rmap_fold_kind rmap_energy_kind = {.create = create,
                                                .destroy = destroy,
                                                .add = add,
                                                .merge = merge,
                                                .blocks = blocks,
                                                .may_count = may_count};

static void take_images(struct rmap_energy_sums *sums, const struct rmap_tally *tally,
                        enum rmap_detector_type type)
{
    const struct rmap_scene *scene = sums->scope->scene;
    for (size_t d = 0; d < sums->n_detector; d++) {
        const size_t n_cell = (size_t)scene->detector[d].cells[0] * scene->detector[d].cells[1];
        for (size_t s = 0; s < sums->n_source && scene->detector[d].type == type; s++) {
            const double *image = rmap_tally_image(tally, d, s);
            double caught = 0.0;
            for (size_t c = 0; c < n_cell; c++)
                caught += image[c];
            bool once = type == RMAP_DETECTOR_INTENSITY || caught < 1.0;
            sums->caught[s * sums->n_detector + d] = caught;
            sums->caught_squared[s * sums->n_detector + d] = once ? caught : (double)NAN;
        }
    }
}

void rmap_energy_sums_take_tally(struct rmap_energy_sums *sums, const struct rmap_tally *tally)
{
    const size_t n_object = sums->scope->scene->n_object, n_medium = sums->scope->scene->n_medium;
    for (size_t s = 0; s < sums->n_source; s++) {
        double *ended = sums->ended + s * sums->n_end;
        sums->rays[s] = tally->emitted[s];
        memcpy(ended, tally->absorbed_object + s * n_object, n_object * sizeof *ended);
        memcpy(ended + n_object, tally->absorbed_medium + s * n_medium, n_medium * sizeof *ended);
        ended[n_object + n_medium] = tally->left[s];
        ended[n_object + n_medium + 1] = tally->limit[s];
        ended[n_object + n_medium + 2] = tally->error[s];
        for (size_t e = 0; e < sums->n_end; e++) /* weights are 1, or their squares not known */
            sums->ended_squared[s * sums->n_end + e] =
                rmap_scene_changes_weights(tally->scene) && ended[e] > 0.0 ? (double)NAN : ended[e];
    }
    take_images(sums, tally, RMAP_DETECTOR_INTENSITY);
}

void rmap_energy_sums_take_planes(struct rmap_energy_sums *sums, const struct rmap_tally *tally)
{
    take_images(sums, tally, RMAP_DETECTOR_PLANE);
}
