/* SPDX-License-Identifier: MIT
 *
 * Numbers of a whole ray that criteria compare and `stats --of` counts: one table.
 */
#ifndef RMAP_RAY_NUMBER_H
#define RMAP_RAY_NUMBER_H

#include <math.h>

#include "portion/portion.h"
#include "scene/events.h"

/* Columns: symbol, the columns it is made of, and that in which it stands as it is, or NULL. Units:
 * WAVELENGTH nm; PHOTON_ENERGY eV, in vacuum; FLUX the scene's flux unit; paths, and START in the
 * world, the scene's length unit. */
#define RMAP_RAY_NUMBERS(X)                                                                        \
    X(ID, RMAP_COLUMN_BIT(RMAP_RAY_id), NULL)                                                      \
    X(SEGMENTS, RMAP_COLUMN_BIT(RMAP_RAY_segment_count), NULL)                                     \
    X(WAVELENGTH, RMAP_COLUMN_BIT(RMAP_RAY_wavelength), ray->wavelength)                           \
    X(FLUX, RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_source), NULL)             \
    X(PATH_LENGTH, RMAP_COLUMN_BIT(RMAP_RAY_path_length), ray->path_length)                        \
    X(OPTICAL_PATH, RMAP_COLUMN_BIT(RMAP_RAY_optical_path), ray->optical_path)                     \
    X(GROUP_PATH, RMAP_COLUMN_BIT(RMAP_RAY_group_path), ray->group_path)                           \
    X(START_X, RMAP_COLUMN_BIT(RMAP_RAY_start), NULL)                                              \
    X(START_Y, RMAP_COLUMN_BIT(RMAP_RAY_start), NULL)                                              \
    X(START_Z, RMAP_COLUMN_BIT(RMAP_RAY_start), NULL)                                              \
    X(EVENT, RMAP_COLUMN_BIT(RMAP_RAY_id), NULL)                                                   \
    X(PHOTON_ENERGY, RMAP_COLUMN_BIT(RMAP_RAY_wavelength), NULL)

enum rmap_ray_number {
#define RMAP_RAY_NUMBER_ENUM(symbol, columns, stored) RMAP_RAY_NUMBER_##symbol,
    RMAP_RAY_NUMBERS(RMAP_RAY_NUMBER_ENUM)
#undef RMAP_RAY_NUMBER_ENUM
};

static inline rmap_column_set rmap_ray_number_columns(enum rmap_ray_number number)
{
    static const rmap_column_set of[] = {
#define RMAP_RAY_NUMBER_COLUMNS(symbol, columns, stored) columns,
        RMAP_RAY_NUMBERS(RMAP_RAY_NUMBER_COLUMNS)
#undef RMAP_RAY_NUMBER_COLUMNS
    };
    return of[number];
}

/* [n_ray], borrowed; NULL where it is not stored as such. */
static inline const double *rmap_ray_number_stored(enum rmap_ray_number number,
                                                   const struct rmap_ray_columns *ray)
{
    const double *const of[] = {
#define RMAP_RAY_NUMBER_STORED(symbol, columns, stored) stored,
        RMAP_RAY_NUMBERS(RMAP_RAY_NUMBER_STORED)
#undef RMAP_RAY_NUMBER_STORED
    };
    return of[number];
}

/* Of ray i, whatever it is made of. flux_per_weight: [n_source]. NaN: the ray has no event. */
static inline double rmap_ray_number_at(enum rmap_ray_number number, const struct rmap_scene *scene,
                                        const struct rmap_ray_columns *ray, size_t i,
                                        const double *flux_per_weight)
{
    const double *stored = rmap_ray_number_stored(number, ray);
    if (stored)
        return stored[i];
    if (number == RMAP_RAY_NUMBER_ID)
        return (double)ray->id[i];
    if (number == RMAP_RAY_NUMBER_SEGMENTS)
        return ray->segment_count[i];
    if (number == RMAP_RAY_NUMBER_EVENT) {
        uint64_t event = 0;
        return rmap_scene_event(scene, ray->id[i], &event) ? (double)event : (double)NAN;
    }
    if (number == RMAP_RAY_NUMBER_PHOTON_ENERGY)
        return RMAP_HC_EV / ray->wavelength[i];
    if (number == RMAP_RAY_NUMBER_FLUX)
        return ray->weight[i] * flux_per_weight[ray->source[i]];
    return (double)ray->start[3 * i + (size_t)(number - RMAP_RAY_NUMBER_START_X)];
}

#endif
