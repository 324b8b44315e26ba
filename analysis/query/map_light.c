/* SPDX-License-Identifier: MIT
 *
 * The light of a map as rays that go on from a detector.
 */
#include "analysis/query/map_light.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/query/fold.h"
#include "base/alloc.h"
#include "io/rays/ray_reader.h"
#include "scene/events.h"

rmap_column_set rmap_map_light_columns(const struct rmap_scene *scene)
{
    const rmap_column_set arrival =
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay);
    return RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
           RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
           RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_SEGMENT_colour) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) |
           (scene->timed ? arrival : RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path));
}

/* One of the wavelengths that a ray has at the end of a segment, drawn by their shares: evenly over
 * the rays of the file (Weyl's sequence of the golden ratio). */
static double wavelength(const struct rmap_channels *channels, const struct rmap_portion *portion,
                         size_t segment, uint64_t n)
{
    const uint16_t *share = portion->colour + segment * (size_t)channels->n;
    double sum = 0.0, below = 0.0;
    for (int c = 0; c < channels->n; c++)
        sum += (double)share[c];
    const double level = fmod(((double)n + 0.5) * 0.61803398874989484820, 1.0) * sum;
    for (int c = 0; c < channels->n; c++) {
        below += (double)share[c];
        if (level < below)
            return channels->wavelength_nm[c];
    }
    return (double)NAN;
}

void rmap_map_light_of_ray(const struct rmap_map *map, size_t space,
                           const struct rmap_portion *portion, size_t ray, size_t segment,
                           uint64_t n, struct rmap_ray_written *out)
{
    const struct rmap_ray_columns *of = &portion->ray;
    out->flux = of->weight[ray] * rmap_map_flux_per_weight(map)[of->source[ray]];
    out->id = of->id[ray];
    if (!rmap_scene_event(rmap_map_scene_of(map, space), out->id, &out->event))
        out->event = RMAP_NO_EVENT;
    if (rmap_map_scene(map)->channels.mode == RMAP_COLOUR_SPECTRAL)
        out->nm = wavelength(&rmap_map_scene_of(map, space)->channels, portion, segment, n);
}

void rmap_map_light_at(const struct rmap_map *map, size_t space, const struct rmap_portion *portion,
                       size_t ray, size_t first, size_t row, uint64_t n,
                       struct rmap_ray_written *out)
{
    const struct rmap_scene *scene = rmap_map_scene_of(map, space);
    const struct rmap_vec3 place = {
        rmap_registration_number(scene, portion, row, RMAP_REGISTRATION_WORLD_X),
        rmap_registration_number(scene, portion, row, RMAP_REGISTRATION_WORLD_Y),
        rmap_registration_number(scene, portion, row, RMAP_REGISTRATION_WORLD_Z)};
    *out = (struct rmap_ray_written){
        .position = rmap_scale(place, scene->unit_m),
        .direction = rmap_vec3_of(&portion->registration.direction[3 * row]),
        .time_ns = 1e9 * rmap_registration_number(scene, portion, row,
                                                  rmap_time_in(scene, RMAP_REGISTRATION_TIME))};
    rmap_map_light_of_ray(map, space, portion, ray, first + portion->registration.segment[row], n,
                          out);
}

/* ---- as a fold, which is run on one thread from the first portion to the last ---- */

struct light {
    const struct rmap_map *map;
    int32_t detector;
    struct rmap_ray_rows *rows;
};

static enum rmap_status add_one(const struct light *light, const struct rmap_ray_written *ray,
                                struct rmap_error *err)
{
    const double value[RMAP_RAY_COLUMNS] = {
        [RMAP_RAY_X] = ray->position.x,
        [RMAP_RAY_Y] = ray->position.y,
        [RMAP_RAY_Z] = ray->position.z,
        [RMAP_RAY_DX] = ray->direction.x,
        [RMAP_RAY_DY] = ray->direction.y,
        [RMAP_RAY_DZ] = ray->direction.z,
        [RMAP_RAY_POWER] = ray->flux,
        [RMAP_RAY_NM] = ray->nm,
        [RMAP_RAY_TIME] = ray->time_ns,
        [RMAP_RAY_EVENT] = ray->event == RMAP_NO_EVENT ? (double)NAN : (double)ray->event};
    return rmap_ray_rows_add(light->rows, value, err);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct light *light = state;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counted = rmap_registrations_counted(rays);
    size_t first = 0, row = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const bool match = !rays->match || rays->match[i];
        for (const size_t end = row + portion->ray.registration_count[i]; row < end; row++) {
            struct rmap_ray_written ray;
            if (!match || !counted[row] || portion->registration.detector[row] != light->detector)
                continue;
            const uint64_t n = light->rows->set ? light->rows->set->n : 0;
            rmap_map_light_at(light->map, rays->space, portion, i, first, row, n, &ray);
            RMAP_TRY(add_one(light, &ray, err));
        }
        first += portion->ray.segment_count[i];
    }
out:
    return st;
}

static const struct rmap_fold_kind kind = {.add = add};

static enum rmap_status find_detector(const struct rmap_scene *scene, const char *name,
                                      int32_t *detector, struct rmap_error *err)
{
    size_t n = 0;
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE &&
            (!name || strcmp(scene->detector[d].name, name) == 0)) {
            *detector = (int32_t)d;
            n++;
        }
    if (n == 1)
        return RMAP_OK;
    return n > 1 ? rmap_error_set(err, RMAP_INPUT,
                                  "it has %zu planes that detect: name one with 'detector:'", n)
                 : rmap_error_set(err, RMAP_INPUT, "it has no plane '%.60s' that detects",
                                  name ? name : "");
}

/* Hands the rows over as light that goes on. */
static enum rmap_status finish(const struct rmap_scene *scene, struct rmap_ray_rows *rows,
                               struct rmap_file_rays **set_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!rows->set)
        return rmap_error_set(err, RMAP_INPUT, "none of its rays was registered there");
    RMAP_TRY(rmap_ray_rows_finish(rows, set_ret, err));
    (*set_ret)->unit_m = 1.0;
    (*set_ret)->flux_unit = scene->flux_unit;
    (*set_ret)->loose = RMAP_FILE_RAYS_LOOSE;
    st = rmap_file_rays_finish(*set_ret, err);
    if (st != RMAP_OK) {
        rmap_file_rays_drop(*set_ret);
        *set_ret = NULL;
    }
out:
    return st;
}

enum rmap_status rmap_map_light_read(const char *path, const char *detector, const char *where,
                                     struct rmap_file_rays **set_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *map = NULL;
    struct rmap_criterion *criterion = NULL;
    struct rmap_which *which = NULL;
    struct rmap_fold_scanner *scanner = NULL;
    struct rmap_ray_rows rows = {.has = {[RMAP_RAY_POWER] = true}};
    struct light light = {.rows = &rows};
    RMAP_TRY(rmap_map_open(path, &map, err));
    const struct rmap_scene *scene = rmap_map_scene(map);
    light.map = map;
    rows.has[RMAP_RAY_NM] = scene->channels.mode == RMAP_COLOUR_SPECTRAL;
    rows.has[RMAP_RAY_TIME] = scene->timed;
    rows.has[RMAP_RAY_EVENT] = !rmap_scene_events_trouble(scene);
    RMAP_TRY(find_detector(scene, detector, &light.detector, err));
    const struct rmap_index_set only = {.low = light.detector, .span = 1};
    if (where)
        RMAP_TRY(rmap_criterion_compile(where, scene, &criterion, err));
    RMAP_TRY(rmap_which_create(scene, &only, NULL, NULL, criterion, &which, err));
    const struct rmap_fold fold = {.kind = &kind,
                                   .map = map,
                                   .criterion = criterion,
                                   .which = which,
                                   .columns = rmap_map_light_columns(scene),
                                   .only_detector = 1 + light.detector};
    RMAP_TRY(rmap_fold_scanner_create(&fold, &scanner, err));
    RMAP_TRY(rmap_fold_scanner_add(scanner, &light, 0, rmap_map_n_portion(map), err));
    st = finish(scene, &rows, set_ret, err);
out:
    rmap_file_rays_drop(rows.set);
    rmap_fold_scanner_destroy(scanner);
    rmap_which_destroy(which);
    rmap_criterion_destroy(criterion);
    rmap_map_close(map);
    return st;
}
