/* SPDX-License-Identifier: MIT
 *
 * Any number of a ray or of its registrations, by the words of the criterion language: what
 * statistics are made of.
 *
 *   of a ray:           wavelength flux path_length optical_path segments bounces ray
 *                       registrations  registrations(detector)  ghost_order  scatter_order
 *                       and every test that counts: hit(lens.*, reflect), event(scatter_volume) ...
 *   of a registration:  x(detector) y(detector) angle(detector) time(detector)
 *                       optical_path(detector) cell(detector) cell_i(detector) cell_j(detector)
 *                       ghost_order(detector)  scatter_order(detector)
 *
 *   sums of either:     optical_path - path_length   time(far) - 2 * time(near)   x - y
 *
 * A ray with several wavelengths left has a reading of `wavelength` per channel, each with its
 * share of the ray's flux.
 */
#ifndef RMAP_QUANTITY_H
#define RMAP_QUANTITY_H

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/path_order.h"
#include "analysis/query/fold.h"
#include "compact/path_sum.h"
#include "io/map/map_reader.h"

#define RMAP_QUANTITIES_MAX 2

enum rmap_quantity_kind {
    RMAP_QUANTITY_RAY_NUMBER,
    RMAP_QUANTITY_PATH_IN, /* analysis/criterion/path_in.h */
    RMAP_QUANTITY_ITS_NUMBER,
    RMAP_QUANTITY_SUM, /* analysis/criterion/criterion_sum.h */
    RMAP_QUANTITY_COUNT,
    RMAP_QUANTITY_GHOST_ORDER, /* analysis/criterion/path_order.h */
    RMAP_QUANTITY_SCATTER_ORDER,
    RMAP_QUANTITY_CELL, /* i + cells along x * j */
    RMAP_QUANTITY_CELL_I,
    RMAP_QUANTITY_CELL_J
};

struct rmap_quantity {
    char *name;       /* as written: "x(sensor)" */
    const char *unit; /* "mm"; "" of a plain number */
    double unit_size; /* in m, degrees, s, W or lm */
    enum rmap_dimension dimension;
    enum rmap_quantity_kind kind;
    bool is_whole; /* its values are whole numbers */
    bool of_registration;
    enum rmap_ray_number ray_number;
    enum rmap_registration_number its_number;
    struct rmap_criterion *counted; /* COUNT: the one test */
    struct rmap_index_set media;    /* PATH_IN */
    struct rmap_sum sum;            /* SUM */
};

/* One or two numbers read at the same places: of rays, or, where one of them is a registration's or
 * a detector is given, of registrations. */
struct rmap_quantities {
    const struct rmap_map *map;         /* borrowed, with its scene */
    const struct rmap_overlay *overlay; /* borrowed; NULL: no receivers */
    const struct rmap_scene *scene;
    size_t n;
    struct rmap_quantity of[RMAP_QUANTITIES_MAX];
    bool of_registrations;
    struct rmap_index_set detector; /* whose registrations */
    uint64_t detector_bits;         /* as in struct rmap_portion_summary */
    bool spreads;                   /* `wavelength` is among them */
    bool weighs;                    /* some of the detectors have a response */
    struct rmap_path_order order;   /* when an order is among them */
    uint64_t *event;                /* [n_event] ascending, where groups are told by them */
    char (*event_name)[24];         /* [n_event] */
    size_t n_event;
    rmap_column_set columns;       /* that reading them needs, with sources and weights */
    rmap_column_set deferred;      /* those of them that only their flux needs */
    struct rmap_criterion *holder; /* of the sets' memory */
};

/* text: [n], 1 <= n <= RMAP_QUANTITIES_MAX. detector: its name, a group's or a pattern; NULL: not
 * given. RMAP_INPUT, "--of:1:3: error: ..." with a caret and the nearest known word. The map and
 * the overlay (NULL: none) are borrowed. */
enum rmap_status rmap_quantities_create_over(const struct rmap_map *map,
                                             const struct rmap_overlay *overlay,
                                             const char *const *text, size_t n,
                                             const char *detector,
                                             struct rmap_quantities **quantities_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
/* As rmap_criterion_of_phase_time and rmap_criterion_of_ids, of any of them. */
bool rmap_quantities_of_phase_time(const struct rmap_quantities *self);
bool rmap_quantities_of_ids(const struct rmap_quantities *self);

enum rmap_status rmap_quantities_create(const struct rmap_map *map, const char *const *text,
                                        size_t n, const char *detector,
                                        struct rmap_quantities **quantities_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_quantities_destroy(struct rmap_quantities *quantities); /* NULL is fine */

/* Values are in this unit from now on, as "ns". RMAP_USAGE with those that fit. */
enum rmap_status rmap_quantity_set_unit(struct rmap_quantities *quantities, size_t index,
                                        const char *unit, struct rmap_error *err) RMAP_MUST_USE;

/* Between which values of it lie those of rays with these bounds; false: they say nothing of it. */
bool rmap_quantity_bound(const struct rmap_quantities *quantities, size_t index,
                         const struct rmap_path_sum *of, double bound[2]);

/* "10..20 um", in the quantity's unit. RMAP_USAGE; `option` names it in the message. */
enum rmap_status rmap_quantity_range(const struct rmap_quantities *quantities, size_t index,
                                     const char *text, const char *option, double range[2],
                                     struct rmap_error *err) RMAP_MUST_USE;

/* What was read of a portion. All zero at first; used again from portion to portion. */
struct rmap_readings {
    size_t n;
    uint32_t *ray;                      /* [n] row of /ray, ascending */
    uint32_t *place;                    /* [n] row of /registration; of rays unset */
    int16_t *channel;                   /* [n] for spreading */
    double *share;                      /* [n] of the ray's weight; 1 unless it spreads */
    double *value[RMAP_QUANTITIES_MAX]; /* [n], finite */
    uint64_t n_undefined;               /* readings of the portion that are no number: left out */
    uint32_t *count;                    /* for counting */
    size_t cap, count_cap;
};

#endif
