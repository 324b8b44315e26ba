/* SPDX-License-Identifier: MIT
 *
 * The rays of a file, as many as there are: where each starts, its direction, what part of the
 * light it is, and what else the file says of it.
 */
#ifndef RMAP_FILE_RAYS_H
#define RMAP_FILE_RAYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/unit.h"
#include "base/vec.h"

#define RMAP_FILE_RAYS_TITLE 128
#define RMAP_FILE_RAYS_STEP  4    /* length, MeV left, charge, beta */
#define RMAP_FILE_RAYS_LOOSE 1e-6 /* numbers of float, or of seven digits */
#define RMAP_NO_EVENT        UINT64_MAX

/* Shared by those who hold it; columns that the file does not have are NULL. */
struct rmap_file_rays {
    size_t n;
    float (*narrow)[6]; /* [n] position and direction, in the file's frame; this or the next */
    double (*wide)[6];
    double *below;        /* [n] sum of the powers up to and with each row; NULL: all are alike */
    float *wavelength_nm; /* [n] NaN: not known */
    double *delay_ns;     /* [n] */
    uint64_t *event;      /* [n] RMAP_NO_EVENT: of none */
    double (*step)[RMAP_FILE_RAYS_STEP]; /* [n] of steps of charged particles, which are no rays */
    double unit_m;                       /* of the positions; 0: that of the scene */
    double all_nm;                       /* wavelength of all; NaN: not said */
    double flux;                         /* of all; NaN: not said */
    double loose; /* share of its coordinates that a start may be off, as it is rounded */
    enum rmap_flux_unit flux_unit;
    char title[RMAP_FILE_RAYS_TITLE]; /* for people; may be "" */
    /* By rmap_file_rays_finish. */
    struct rmap_vec3 lower, upper; /* box about the starts */
    double least_nm, greatest_nm;  /* NaN: no row has a wavelength */
    size_t n_other;                /* rows without one */
    int n_holder;
};

/* Held once; rows are 0, no column. RMAP_INPUT without a row, RMAP_SYSTEM. */
enum rmap_status rmap_file_rays_create(size_t n, bool wide, struct rmap_file_rays **set_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
struct rmap_file_rays *
rmap_file_rays_hold(struct rmap_file_rays *set);      /* not for threads at once */
void rmap_file_rays_drop(struct rmap_file_rays *set); /* the last holder frees it; NULL is fine */

/* Sums up powers, which `below` has until then, also into `flux`; the column goes where all are
 * alike. */
enum rmap_status rmap_file_rays_weigh(struct rmap_file_rays *set,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Checks every row and fills what is derived. RMAP_INPUT with the row, from 1. */
enum rmap_status rmap_file_rays_finish(struct rmap_file_rays *set,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Which row is the ordinal-th ray: row `ordinal` modulo n where all powers are alike. Where not,
 * each n rays share the power out in n equal parts, in the order of the rows, and a row has as many
 * of them, to one, as its power asks for (systematic resampling: Kitagawa 1996,
 * doi:10.1080/10618600.1996.10474692, A.2); where the parts begin changes from one n rays to
 * the next, by a sequence that fills them evenly. The same bits everywhere. */
size_t rmap_file_rays_row(const struct rmap_file_rays *set, uint64_t ordinal);

/* A row, in the file's frame; the direction as it stands there. */
void rmap_file_rays_get(const struct rmap_file_rays *set, size_t row, struct rmap_vec3 *position,
                        struct rmap_vec3 *direction);

/* NaN: not known. */
double rmap_file_rays_nm(const struct rmap_file_rays *set, size_t row);

#endif
