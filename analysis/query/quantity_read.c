/* SPDX-License-Identifier: MIT
 *
 * Values of quantities: places first (rays, or registrations), then each quantity at all of them.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_evaluate.h"
#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/path_in.h"
#include "analysis/criterion/registration_response.h"
#include "analysis/query/quantity.h"
#include "analysis/query/quantity_read.h"
#include "base/alloc.h"
#include "base/wide.h"

void rmap_readings_fini(struct rmap_readings *readings)
{
    rmap_free(readings->ray);
    rmap_free(readings->place);
    rmap_free(readings->channel);
    rmap_free(readings->share);
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        rmap_free(readings->value[i]);
    rmap_free(readings->count);
    *readings = (struct rmap_readings){0};
}

/* Makes a block hold `cap` elements, `had` of which it holds already. */
static enum rmap_status grow(void *block_address, size_t had, size_t cap, size_t size,
                             struct rmap_error *err)
{
    void *block;
    memcpy(&block, block_address, sizeof block);
    enum rmap_status st = rmap_reserve(&block, &had, cap, size, err);
    memcpy(block_address, &block, sizeof block);
    return st;
}

static enum rmap_status reserve(struct rmap_readings *readings, size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t had = readings->cap;
    if (n <= had)
        return RMAP_OK;
    n = n > 2 * had ? n : 2 * had;
    RMAP_TRY(grow(&readings->ray, had, n, sizeof *readings->ray, err));
    RMAP_TRY(grow(&readings->place, had, n, sizeof *readings->place, err));
    RMAP_TRY(grow(&readings->channel, had, n, sizeof *readings->channel, err));
    RMAP_TRY(grow(&readings->share, had, n, sizeof *readings->share, err));
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        RMAP_TRY(grow(&readings->value[i], had, n, sizeof *readings->value[i], err));
    readings->cap = n;
out:
    return st;
}

/* A portion's places in hand. */
struct search {
    const struct rmap_quantities *self;
    const struct rmap_matched *rays;
    const struct rmap_channels *channels; /* that places spread over; NULL: they do not */
    struct rmap_readings *readings;
};

/* The colour of a place: of the registration's segment, or of the ray's last one. NULL: it has
 * none. first_segment: row of the ray's first segment. */
static const uint16_t *colour_at(const struct search *search, size_t ray, size_t place,
                                 size_t first_segment)
{
    const struct rmap_portion *portion = search->rays->portion;
    size_t n_segment = portion->ray.segment_count[ray];
    size_t segment =
        search->self->of_registrations ? portion->registration.segment[place] : n_segment - 1;
    return segment < n_segment
               ? portion->colour + (first_segment + segment) * (size_t)portion->n_channel
               : NULL;
}

static void add_place(struct search *search, size_t ray, size_t place, size_t first_segment)
{
    struct rmap_readings *readings = search->readings;
    const struct rmap_portion *portion = search->rays->portion;
    const uint16_t *colour = NULL;
    readings->ray[readings->n] = (uint32_t)ray;
    readings->place[readings->n] = (uint32_t)place;
    readings->share[readings->n] = 1.0;
    if (!search->channels) {
        readings->n++;
        return;
    }
    readings->channel[readings->n] = -1;
    if (search->self->of_registrations || isnan(portion->ray.wavelength[ray]))
        colour = colour_at(search, ray, place, first_segment);
    if (!colour) {
        readings->n++;
        return;
    }
    for (int c = 0; c < search->channels->n; c++) {
        if (colour[c] == 0)
            continue;
        readings->ray[readings->n] = (uint32_t)ray;
        readings->place[readings->n] = (uint32_t)place;
        readings->share[readings->n] = colour[c] / 65535.0;
        readings->channel[readings->n++] = (int16_t)c;
    }
}

/* Room for all places of the next ray, and for what a place without a colour takes. */
static enum rmap_status make_room(const struct search *search, size_t n_place,
                                  struct rmap_error *err)
{
    size_t each = search->channels ? (size_t)search->channels->n + 1 : 1;
    return reserve(search->readings, search->readings->n + n_place * each, err);
}

/* Its column, where the quantity is one as it is stored. */
static const double *column_of(const struct rmap_quantity *quantity,
                               const struct rmap_ray_columns *ray)
{
    if (quantity->kind != RMAP_QUANTITY_RAY_NUMBER)
        return NULL;
    return rmap_ray_number_stored(quantity->ray_number, ray);
}

/* Rays that are one place each. */
static enum rmap_status list_rays(struct search *search, struct rmap_error *err)
{
    const struct rmap_matched *rays = search->rays;
    struct rmap_readings *readings = search->readings;
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    enum rmap_status st = reserve(readings, n_ray + 1, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < n_ray; i++) {
        readings->ray[readings->n] = (uint32_t)i;
        readings->n += !rays->match || rays->match[i];
    }
    for (size_t k = 0; k < readings->n; k++) {
        readings->place[k] = 0;
        readings->share[k] = 1.0;
    }
    return RMAP_OK;
}

static enum rmap_status find_rays(struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_matched *rays = search->rays;
    size_t first_segment = 0;
    if (!search->channels)
        return list_rays(search, err);
    for (size_t i = 0; i < rays->portion->n_row[RMAP_TABLE_RAY]; i++) {
        if (!rays->match || rays->match[i]) {
            RMAP_TRY(make_room(search, 1, err));
            add_place(search, i, 0, first_segment);
        }
        first_segment += rays->portion->ray.segment_count[i];
    }
out:
    return st;
}

static enum rmap_status find_registrations(struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_matched *rays = search->rays;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    size_t row = 0, first_segment = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t n_row = portion->ray.registration_count[i];
        if (n_row > 0 && (!rays->match || rays->match[i])) {
            RMAP_TRY(make_room(search, n_row, err));
            for (size_t k = row; k < row + n_row; k++)
                if (counts[k] &&
                    rmap_index_set_has(&search->self->detector, portion->registration.detector[k]))
                    add_place(search, i, k, first_segment);
        }
        row += n_row;
        first_segment += search->channels ? portion->ray.segment_count[i] : 0;
    }
out:
    return st;
}

static void read_wavelengths(const struct search *search, double *value)
{
    const struct rmap_readings *readings = search->readings;
    const struct rmap_portion *portion = search->rays->portion;
    for (size_t k = 0; k < readings->n; k++)
        value[k] = search->channels && readings->channel[k] >= 0
                       ? search->channels->wavelength_nm[readings->channel[k]]
                       : portion->ray.wavelength[readings->ray[k]];
}

/* Those that are not stored as such. */
static void read_ray_numbers(const struct search *search, enum rmap_ray_number number,
                             double *value)
{
    const struct rmap_readings *readings = search->readings;
    const struct rmap_ray_columns *ray = &search->rays->portion->ray;
    const double *flux_per_weight = rmap_map_flux_per_weight(search->self->map);
    for (size_t k = 0; k < readings->n; k++)
        value[k] =
            rmap_ray_number_at(number, search->self->scene, ray, readings->ray[k], flux_per_weight);
}

static void read_paths_in(const struct rmap_quantity *quantity, const struct rmap_portion *portion,
                          const struct rmap_readings *readings, double *value)
{
    size_t ray = 0, first = 0;
    for (size_t k = 0; k < readings->n; k++) {
        while (ray < readings->ray[k])
            first += portion->ray.segment_count[ray++];
        value[k] = rmap_path_length_in(&quantity->media, portion, ray, first);
    }
}

static void read_sums(const struct rmap_quantities *self, const struct rmap_quantity *quantity,
                      const struct rmap_portion *portion, const struct rmap_readings *readings,
                      double *value)
{
    const double *flux_per_weight = rmap_map_flux_per_weight(self->map);
    const uint32_t *n_row = portion->ray.registration_count;
    size_t ray = 0, first = 0;
    for (size_t k = 0; k < readings->n; k++) {
        for (; ray < readings->ray[k]; ray++)
            first += n_row ? n_row[ray] : 0;
        const size_t row = quantity->of_registration ? readings->place[k] : first;
        const size_t n = quantity->of_registration ? 1 : n_row ? n_row[ray] : 0;
        value[k] =
            rmap_sum_of_ray(self->scene, &quantity->sum, portion, flux_per_weight, ray, row, n);
    }
}

/* Room for two counts of every row of a table. */
static enum rmap_status reserve_counts(struct rmap_readings *readings, size_t n_row,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(readings->count, readings->count_cap, 2 * n_row + 1, err);
    return st;
}

static enum rmap_status read_counts(const struct rmap_quantity *quantity,
                                    const struct rmap_portion *portion,
                                    struct rmap_readings *readings, double *value,
                                    struct rmap_error *err)
{
    enum rmap_status st = reserve_counts(readings, portion->n_row[RMAP_TABLE_RAY], err);
    if (st == RMAP_OK)
        st = rmap_criterion_count(quantity->counted, portion, readings->count, err);
    for (size_t k = 0; st == RMAP_OK && k < readings->n; k++)
        value[k] = readings->count[readings->ray[k]];
    return st;
}

static enum rmap_status read_orders(const struct search *search, bool scatter, double *value,
                                    struct rmap_error *err)
{
    const struct rmap_quantities *self = search->self;
    const struct rmap_portion *portion = search->rays->portion;
    struct rmap_readings *readings = search->readings;
    const bool its = self->of_registrations;
    const size_t n_row = portion->n_row[its ? RMAP_TABLE_REGISTRATION : RMAP_TABLE_RAY];
    enum rmap_status st = reserve_counts(readings, n_row, err);
    if (st != RMAP_OK)
        return st;
    uint32_t *ghosts = readings->count, *scatters = readings->count + n_row;
    if (its)
        rmap_path_orders_of_registrations(&self->order, portion, ghosts, scatters);
    else
        rmap_path_orders_of_rays(&self->order, portion, ghosts, scatters);
    const uint32_t *order = scatter ? scatters : ghosts;
    for (size_t k = 0; k < readings->n; k++)
        value[k] = order[its ? readings->place[k] : readings->ray[k]];
    return RMAP_OK;
}

static void read_cells(const struct rmap_quantities *self, const struct rmap_quantity *quantity,
                       const struct rmap_registration_columns *registration,
                       const struct rmap_readings *readings, double *value)
{
    for (size_t k = 0; k < readings->n; k++) {
        size_t row = readings->place[k];
        double i = registration->cell[2 * row], j = registration->cell[2 * row + 1];
        double width = self->scene->detector[registration->detector[row]].cells[0];
        value[k] = quantity->kind == RMAP_QUANTITY_CELL_I   ? i
                   : quantity->kind == RMAP_QUANTITY_CELL_J ? j
                                                            : i + width * j;
    }
}

static enum rmap_status read_values(const struct search *search,
                                    const struct rmap_quantity *quantity, double *value,
                                    struct rmap_error *err)
{
    const struct rmap_quantities *self = search->self;
    const struct rmap_portion *portion = search->rays->portion;
    struct rmap_readings *readings = search->readings;
    const double *column = column_of(quantity, &portion->ray);
    switch (quantity->kind) {
    case RMAP_QUANTITY_RAY_NUMBER:
        if (column && (quantity->ray_number != RMAP_RAY_NUMBER_WAVELENGTH ||
                       (!self->of_registrations && !search->channels)))
            for (size_t k = 0; k < readings->n; k++)
                value[k] = column[readings->ray[k]];
        else if (quantity->ray_number == RMAP_RAY_NUMBER_WAVELENGTH)
            read_wavelengths(search, value);
        else
            read_ray_numbers(search, quantity->ray_number, value);
        break;
    case RMAP_QUANTITY_PATH_IN:
        read_paths_in(quantity, portion, readings, value);
        break;
    case RMAP_QUANTITY_ITS_NUMBER:
        for (size_t k = 0; k < readings->n; k++)
            value[k] = rmap_registration_number(self->scene, portion, readings->place[k],
                                                quantity->its_number);
        break;
    case RMAP_QUANTITY_SUM:
        read_sums(self, quantity, portion, readings, value);
        break;
    case RMAP_QUANTITY_COUNT:
        return read_counts(quantity, portion, readings, value, err);
    case RMAP_QUANTITY_GHOST_ORDER:
    case RMAP_QUANTITY_SCATTER_ORDER:
        return read_orders(search, quantity->kind == RMAP_QUANTITY_SCATTER_ORDER, value, err);
    case RMAP_QUANTITY_CELL:
    case RMAP_QUANTITY_CELL_I:
    case RMAP_QUANTITY_CELL_J:
        read_cells(self, quantity, &portion->registration, readings, value);
        break;
    }
    return RMAP_OK;
}

/* A number less itself is 0, unless it is none or infinite. */
RMAP_WIDE static uint64_t any_infinite(const double *value, size_t n)
{
    uint64_t any = 0;
    for (size_t k = 0; k < n; k++) {
        const double none = value[k] - value[k];
        uint64_t bits;
        memcpy(&bits, &none, sizeof bits);
        any |= bits;
    }
    return any;
}

static bool all_finite(const struct rmap_quantities *self, const struct rmap_readings *readings)
{
    uint64_t any = 0;
    for (size_t i = 0; i < self->n; i++)
        any |= any_infinite(readings->value[i], readings->n);
    return !any;
}

/* Leaves out readings of which a value is no number. */
static void keep_defined(const struct rmap_quantities *self, struct rmap_readings *readings)
{
    size_t n = 0;
    if (all_finite(self, readings))
        return;
    for (size_t k = 0; k < readings->n; k++) {
        bool defined = true;
        for (size_t i = 0; i < self->n; i++) {
            defined = defined && isfinite(readings->value[i][k]);
            readings->value[i][n] = readings->value[i][k];
        }
        readings->ray[n] = readings->ray[k];
        readings->place[n] = readings->place[k];
        readings->share[n] = readings->share[k];
        n += defined;
    }
    readings->n_undefined = readings->n - n;
    readings->n = n;
}

/* Channels that places spread over; NULL: they do not. */
static const struct rmap_channels *channels_of(const struct rmap_quantities *self,
                                               const struct rmap_matched *rays)
{
    const struct rmap_channels *channels = &rmap_map_scene_of(self->map, rays->space)->channels;
    const bool spread = self->spreads && channels->mode == RMAP_COLOUR_SPECTRAL &&
                        rays->portion->n_channel == channels->n;
    return spread ? channels : NULL;
}

/* A reading has the detector's response as its part of the ray's weight; of spread places that to
 * its own channel. */
static void weigh(const struct search *search)
{
    const struct rmap_quantities *self = search->self;
    struct rmap_readings *readings = search->readings;
    const struct rmap_portion *portion = search->rays->portion;
    const struct rmap_scene *own = rmap_map_scene_of(self->map, search->rays->space);
    struct rmap_registration_place at = {0, 0, 0};
    for (size_t k = 0; k < readings->n; k++) {
        while (at.ray < readings->ray[k])
            at.first_segment += portion->ray.segment_count[at.ray++];
        at.row = readings->place[k];
        const size_t detector = (size_t)portion->registration.detector[at.row];
        const struct rmap_scene *scene = detector < own->n_detector ? own : self->scene;
        if (!rmap_detector_weighs(&scene->detector[detector]))
            continue;
        readings->share[k] *=
            search->channels && readings->channel[k] >= 0
                ? rmap_registration_response_to(scene, portion, &at, readings->channel[k])
                : rmap_registration_response(scene, portion, &at);
    }
}

enum rmap_status rmap_quantities_read(const struct rmap_quantities *self,
                                      const struct rmap_matched *rays,
                                      struct rmap_readings *readings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct search search = {
        .self = self, .rays = rays, .channels = channels_of(self, rays), .readings = readings};
    readings->n = 0;
    readings->n_undefined = 0;
    if (self->of_registrations)
        RMAP_TRY(find_registrations(&search, err));
    else
        RMAP_TRY(find_rays(&search, err));
    for (size_t i = 0; i < self->n && readings->n > 0; i++) {
        RMAP_TRY(read_values(&search, &self->of[i], readings->value[i], err));
        const double scale = rmap_quantity_scale(self, i);
        for (size_t k = 0; scale != 1.0 && k < readings->n; k++)
            readings->value[i][k] *= scale;
    }
    if (self->weighs)
        weigh(&search);
    keep_defined(self, readings);
out:
    return st;
}

bool rmap_quantities_may_count(const struct rmap_quantities *self,
                               const struct rmap_portion_info *portion)
{
    return !self->of_registrations || (portion->summary.detectors & self->detector_bits) != 0;
}
