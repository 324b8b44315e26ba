/* SPDX-License-Identifier: MIT
 *
 * Measured reflectance and transmittance of a coat: rows of wavelength, angle, Rs, Rp, Ts, Tp.
 */
#include "io/scene/coat_csv.h"

#include "base/alloc.h"
#include "io/scene/number_rows.h"

enum { WAVELENGTH, ANGLE, RS, RP, TS, TP };
static const char *const column[RMAP_ROW_COLUMNS] = {"wavelength", "angle", "Rs", "Rp", "Ts", "Tp"};

static enum rmap_status check_rows(const struct rmap_number_rows *rows, struct rmap_error *err)
{
    for (size_t i = 0; i < rows->n; i++) {
        const double *row = rows->row[i];
        if (row[ANGLE] < 0.0 || row[ANGLE] > 90.0)
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %zu: an angle is from 0 to 90 degrees from the normal",
                                  rows->line[i]);
        for (int k = 0; k < 2; k++)
            if (row[RS + k] < 0.0 || row[TS + k] < 0.0 || row[RS + k] + row[TS + k] > 1.0 + 1e-6)
                return rmap_error_set(err, RMAP_INPUT,
                                      "line %zu: %s %g and %s %g are no shares: from 0, and 1 "
                                      "together at most",
                                      rows->line[i], column[RS + k], row[RS + k], column[TS + k],
                                      row[TS + k]);
    }
    return RMAP_OK;
}

enum rmap_status rmap_coat_csv_read(const char *text, size_t nbytes,
                                    const struct rmap_channels *channels,
                                    struct rmap_thin_film *film, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_number_rows rows = {
        .n_column = RMAP_ROW_COLUMNS,
        .name = column,
        .n_axis = RS,
        .row_is =
            "a row has six numbers: wavelength (nm; 0: any), angle (degrees), Rs, Rp, Ts, Tp"};
    RMAP_TRY(rmap_number_rows_read(text, nbytes, &rows, err));
    RMAP_TRY(check_rows(&rows, err));
    RMAP_TRY(rmap_table_covers(rows.each[WAVELENGTH], rows.count[WAVELENGTH], channels, err));
    const size_t n = rows.count[ANGLE];
    film->angle = rmap_alloc(n, sizeof *film->angle);
    film->share = rmap_alloc((size_t)channels->n * n * 2, sizeof *film->share);
    if (!film->angle || !film->share)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    for (size_t k = 0; k < n; k++)
        film->angle[k] = rows.each[ANGLE][k] * (RMAP_PI / 180.0);
    for (size_t i = 0; i < (size_t)channels->n * n; i++) {
        double t;
        const size_t low = rmap_table_between(rows.each[WAVELENGTH], rows.count[WAVELENGTH],
                                              channels->wavelength_nm[i / n], &t);
        const double(*row)[RMAP_ROW_COLUMNS] =
            (const double(*)[RMAP_ROW_COLUMNS])rows.row + low * n + i % n;
        for (int way = 0; way < 2; way++) {
            const int s = way ? TS : RS;
            double share = 0.5 * (row[0][s] + row[0][s + 1]);
            if (t > 0.0)
                share += t * (0.5 * (row[n][s] + row[n][s + 1]) - share);
            film->share[2 * i + (size_t)way] = share;
        }
    }
    film->n_angle = n;
out:
    rmap_number_rows_fini(&rows);
    return st;
}
