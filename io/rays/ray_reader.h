/* SPDX-License-Identifier: MIT
 *
 * What the readers of files of rays share.
 */
#ifndef RMAP_RAY_READER_H
#define RMAP_RAY_READER_H

#include "io/rays/ray_file.h"

/* Bytes in their order. */
struct rmap_ray_bytes {
    FILE *in;
    uint64_t at, nbytes; /* read so far, in all */
    struct rmap_error *err;
};

/* RMAP_INPUT when it ends before them; `what` is in the message. */
enum rmap_status rmap_ray_take(struct rmap_ray_bytes *bytes, void *to, size_t n,
                               const char *what) RMAP_MUST_USE;
enum rmap_status rmap_ray_skip(struct rmap_ray_bytes *bytes, uint64_t n,
                               const char *what) RMAP_MUST_USE;

enum rmap_status rmap_tm25_read(struct rmap_ray_bytes *bytes, struct rmap_file_rays **set_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_mcpl_read(struct rmap_ray_bytes *bytes, struct rmap_ray_wanted *wanted,
                                struct rmap_file_rays **set_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_lighttools_read(FILE *in, struct rmap_file_rays **set_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_ray_csv_read(FILE *in, bool steps, struct rmap_file_rays **set_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_ray_hdf5_read(const char *path, const struct rmap_ray_wanted *wanted,
                                    struct rmap_file_rays **set_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* What a column of a table of rays is. */
enum rmap_ray_column {
    RMAP_RAY_X,
    RMAP_RAY_Y,
    RMAP_RAY_Z,
    RMAP_RAY_DX,
    RMAP_RAY_DY,
    RMAP_RAY_DZ,
    RMAP_RAY_POWER,
    RMAP_RAY_NM,
    RMAP_RAY_TIME,
    RMAP_RAY_EVENT,
    RMAP_RAY_LENGTH, /* this and those below: of steps alone */
    RMAP_RAY_DEPOSIT,
    RMAP_RAY_CHARGE,
    RMAP_RAY_BETA,
    RMAP_RAY_COLUMNS
};

static inline bool rmap_ray_event_good(double event)
{
    return event >= 0.0 && event < 9e18 && event == (double)(uint64_t)event;
}

/* Rows as they come, their number not known before. */
struct rmap_ray_rows {
    struct rmap_file_rays *set; /* wide; NULL before the first row */
    size_t cap;
    bool has[RMAP_RAY_COLUMNS]; /* those from POWER on that there are */
};
/* A row more, with all its columns. RMAP_SYSTEM. */
enum rmap_status rmap_ray_rows_add(struct rmap_ray_rows *rows, const double value[RMAP_RAY_COLUMNS],
                                   struct rmap_error *err) RMAP_MUST_USE;
/* Hands the rows over, their powers summed up. RMAP_INPUT where there are none. */
enum rmap_status rmap_ray_rows_finish(struct rmap_ray_rows *rows, struct rmap_file_rays **set_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Room for columns of a set of a known size. */
enum rmap_status rmap_file_rays_columns(struct rmap_file_rays *set,
                                        const bool has[RMAP_RAY_COLUMNS],
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_file_rays_put(struct rmap_file_rays *set, size_t row,
                        const double value[RMAP_RAY_COLUMNS]);

/* Planck's constant times the speed of light (SI 2019, exact to the digits): eV nm. */
#define RMAP_EV_NM 1239.841984332

/* The column of this name of a file of rays, or of steps, its unit behind it in brackets or by
 * `unit` (NULL: none): what its numbers are to be multiplied with to be in m, nm, ns (a length
 * without a unit: 0); energies are to be divided into *factor, *inverse says so. RMAP_INPUT where
 * there is no such column or unit.
 */
struct rmap_ray_meaning {
    enum rmap_ray_column column;
    double factor;
    bool inverse;
    bool said; /* which unit its flux is in */
    enum rmap_flux_unit flux_unit;
};
enum rmap_status rmap_ray_meaning_of(const char *name, const char *unit, bool steps,
                                     struct rmap_ray_meaning *meaning,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
