/* SPDX-License-Identifier: MIT
 *
 * The energy balance of a map, or of the rays of it that match: what was emitted = what each
 * object and medium absorbed + what left the scene + what a limit or an error ended + what turned
 * to heat where light was given back at other wavelengths (or less than none). Exact: rays
 * are whole numbers, and each table's add up to its emitted ones.
 *
 * Standard errors are those of docs/physics.md: the flux of a row is sum f_s q, its variance
 * sum f_s^2 N_s/(N_s-1) (sum q^2 - (sum q)^2/N_s), f_s = Phi_s/N_s; a share is the ratio to the
 * flux emitted, its error to first order, with the same rays in both.
 */
#ifndef RMAP_ENERGY_H
#define RMAP_ENERGY_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/energy/energy_sums.h"

enum rmap_energy_end {
    RMAP_ENERGY_OBJECT,
    RMAP_ENERGY_MEDIUM,
    RMAP_ENERGY_LEFT,
    RMAP_ENERGY_LIMIT,
    RMAP_ENERGY_ERROR,
    RMAP_ENERGY_HEAT, /* of light given back at other wavelengths, where its energy is counted */
    RMAP_ENERGY_DETECTOR
};

struct rmap_energy_row {
    enum rmap_energy_end end;
    size_t index;     /* of the object, medium or detector; else 0 */
    const char *name; /* borrowed from the scene; "" for left, limit, error */
    double rays;      /* sum of weights: whole; of a detector, registrations */
    double flux, flux_error;
    double share, share_error; /* of the table's flux emitted; NaN where that is 0 */
};

struct rmap_energy_table {
    const char *source; /* NULL: all sources together */
    double rays;        /* emitted */
    double flux, flux_error;
    bool exact;                  /* the rows' rays add up to `rays` */
    size_t n_row, n_detector;    /* rows of the balance, then of the detectors */
    struct rmap_energy_row *row; /* [n_row + n_detector]; objects, the most first, media alike,
                                    left, limit, error, heat; objects and media that absorbed
                                    nothing are left out; then every detector */
};

struct rmap_energy {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_map *of;      /* borrowed */
    const struct rmap_which *which; /* registrations that were counted, borrowed; NULL: all */
    const char *map, *criterion;    /* borrowed; criterion NULL: all rays */
    const char *unit;               /* "W" or "lm" */
    double map_rays, map_flux;      /* of all rays, matching or not */
    size_t n_table;                 /* that of all sources, then one per source */
    struct rmap_energy_table *table;
};

/* map_name: as outputs shall call it. Texts are borrowed. */
enum rmap_status rmap_energy_create(const struct rmap_map *map, const char *map_name,
                                    const char *criterion, const struct rmap_energy_sums *sums,
                                    struct rmap_energy **energy_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_energy_destroy(struct rmap_energy *energy); /* NULL is fine */

/* "absorbed by", "left", ... */
const char *rmap_energy_end_text(enum rmap_energy_end end);

/* The rows of a balance that people want to see: the largest objects and media, what others
 * absorbed as one row each (whose errors are NaN), and no limit or error without rays. */
#define RMAP_ENERGY_SHOWN 20
struct rmap_energy_shown {
    size_t n;
    struct rmap_energy_row row[2 * (RMAP_ENERGY_SHOWN + 1) + 4];
    char others[2][32]; /* names of rows */
};
void rmap_energy_show(const struct rmap_energy_table *table, struct rmap_energy_shown *shown);

/* For people: objects beyond the first 20 of a table are summed up. */
enum rmap_status rmap_energy_print(const struct rmap_energy *energy, FILE *out,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Lines of "# key: value", then a line per table and row: all of them. */
void rmap_energy_csv(const struct rmap_energy *energy, FILE *out);

/* A JSON object (new reference); NULL when memory is short. */
json_t *rmap_energy_json(const struct rmap_energy *energy);

#endif
