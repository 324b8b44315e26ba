/* SPDX-License-Identifier: MIT
 *
 * A measured phase function: rows of wavelength, angle, value.
 */
#include "io/scene/phase_csv.h"

#include "base/alloc.h"
#include "io/scene/number_rows.h"

enum { WAVELENGTH, ANGLE, VALUE, COLUMNS };
static const char *const column[COLUMNS] = {"wavelength", "angle", "value"};

static enum rmap_status check_rows(const struct rmap_number_rows *rows, struct rmap_error *err)
{
    for (size_t i = 0; i < rows->n; i++) {
        const double *row = rows->row[i];
        if (row[ANGLE] < 0.0 || row[ANGLE] > 180.0)
            return rmap_error_set(err, RMAP_INPUT, "line %zu: light is turned by 0 to 180 degrees",
                                  rows->line[i]);
        if (row[VALUE] < 0.0)
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %zu: a phase function of %g: it is not negative",
                                  rows->line[i], row[VALUE]);
    }
    if (rows->count[ANGLE] < 2)
        return rmap_error_set(err, RMAP_INPUT, "a phase function needs two angles or more");
    return RMAP_OK;
}

enum rmap_status rmap_phase_csv_read(const char *text, size_t nbytes,
                                     const struct rmap_channels *channels, struct rmap_phase *phase,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double *value = NULL;
    struct rmap_number_rows rows = {
        .n_column = COLUMNS,
        .name = column,
        .n_axis = VALUE,
        .row_is = "a row has three numbers: wavelength (nm; 0: any), angle (degrees), value"};
    RMAP_TRY(rmap_number_rows_read(text, nbytes, &rows, err));
    RMAP_TRY(check_rows(&rows, err));
    RMAP_TRY(rmap_table_covers(rows.each[WAVELENGTH], rows.count[WAVELENGTH], channels, err));
    const size_t n = rows.count[ANGLE],
                 n_table = rows.count[WAVELENGTH] > 1 ? (size_t)channels->n : 1;
    phase->kind = RMAP_PHASE_TABLE;
    RMAP_TRY(rmap_phase_make_room(phase, n_table, err));
    value = rmap_alloc(n, sizeof *value);
    if (!value)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    for (size_t c = 0; c < n_table; c++) {
        double t;
        const size_t low = rmap_table_between(rows.each[WAVELENGTH], rows.count[WAVELENGTH],
                                              channels->wavelength_nm[c], &t);
        for (size_t i = 0; i < n; i++) {
            value[i] = rows.row[low * n + i][VALUE];
            if (t > 0.0)
                value[i] += t * (rows.row[(low + 1) * n + i][VALUE] - value[i]);
        }
        RMAP_TRY(rmap_phase_add_table(rows.each[ANGLE], value, n, phase, err));
    }
out:
    rmap_free(value);
    rmap_number_rows_fini(&rows);
    return st;
}
