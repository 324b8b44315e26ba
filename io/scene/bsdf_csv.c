/* SPDX-License-Identifier: MIT
 *
 * A measured BSDF as text: rows of wavelength, theta_i, phi_i, theta_s, phi_s, value.
 */
#include <math.h>

#include "base/alloc.h"
#include "io/scene/number_rows.h"
#include "io/scene/scene_tables.h"

enum { WAVELENGTH, THETA_I, PHI_I, THETA_S, PHI_S, VALUE };
static const char *const column[RMAP_ROW_COLUMNS] = {"wavelength", "theta_i", "phi_i",
                                                     "theta_s",    "phi_s",   "value"};

static enum rmap_status check_rows(const struct rmap_number_rows *rows, struct rmap_error *err)
{
    for (size_t i = 0; i < rows->n; i++) {
        const double *row = rows->row[i];
        if (row[VALUE] < 0.0)
            return rmap_error_set(err, RMAP_INPUT, "line %zu: a BSDF of %g: it is not negative",
                                  rows->line[i], row[VALUE]);
        if (row[THETA_I] < 0.0 || row[THETA_I] > 90.0 || row[THETA_S] < 0.0 || row[THETA_S] > 90.0)
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %zu: theta is from 0 to 90 degrees from the normal",
                                  rows->line[i]);
    }
    return RMAP_OK;
}

/* Azimuths go around in equal steps from the first one; 0 to 180 stands for both halves. *turn_ret:
 * steps of a whole turn. */
static enum rmap_status check_turn(const struct rmap_number_rows *rows, int c, bool may_mirror,
                                   size_t *turn_ret, struct rmap_error *err)
{
    const double *phi = rows->each[c], near = 1e-6;
    const size_t n = rows->count[c];
    const double span = n > 1 ? phi[n - 1] - phi[0] : 0.0,
                 step = n > 1 ? span / (double)(n - 1) : 0;
    *turn_ret = n;
    for (size_t i = 1; i < n; i++)
        if (fabs(phi[i] - phi[0] - step * (double)i) > 1e-3 * step)
            return rmap_error_set(err, RMAP_INPUT, "%s is not in equal steps", column[c]);
    if (n == 1)
        return RMAP_OK;
    if (may_mirror && fabs(span - 180.0) < near) {
        *turn_ret = 2 * (n - 1);
        return RMAP_OK;
    }
    if (fabs(span + step - 360.0) < 1e-3 * step && n % 2 == 0)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s goes %sall around in an even number of equal steps, as in 0, 10, ... "
                          "350, or is one number: of a surface without directions",
                          column[c], may_mirror ? "from 0 to 180, or " : "");
}

/* Halfway between angles; the first begins at 0, the last ends as far behind it, at 90 at most. */
static void set_rings(const struct rmap_number_rows *rows, double *edge)
{
    const double *theta = rows->each[THETA_S];
    const size_t n = rows->count[THETA_S];
    edge[0] = 0.0;
    for (size_t i = 1; i < n; i++)
        edge[i] = 0.5 * (theta[i - 1] + theta[i]);
    edge[n] = n > 1 ? fmin(90.0, theta[n - 1] + 0.5 * (theta[n - 1] - theta[n - 2])) : 90.0;
}

/* Where azimuth k of the file stands among the n patches of a ring, which count from the direction
 * of travel. shift: half a turn, in patches. */
static size_t patch_at(size_t k, size_t n, size_t shift)
{
    return (k + shift) % n;
}

static void fill(const struct rmap_number_rows *rows, const struct rmap_channels *channels,
                 size_t n_phi, size_t n_turn, struct rmap_scatter_table *table)
{
    const double *nm = rows->each[WAVELENGTH];
    const size_t n_given = rows->count[PHI_S];
    for (size_t b = 0; b < table->n_band; b++) {
        double t = 0.0;
        const size_t low =
            rmap_table_between(nm, rows->count[WAVELENGTH], channels->wavelength_nm[b], &t);
        for (size_t i = 0; i < rows->count[THETA_I] * n_turn; i++) {
            /* light comes from phi_i: it travels the other way */
            const size_t theta = i / n_turn, from = patch_at(i % n_turn, n_turn, n_turn / 2);
            for (size_t r = 0; r < rows->count[THETA_S]; r++)
                for (size_t k = 0; k < n_phi; k++) {
                    const size_t given = k < n_given ? k : n_phi - k;
                    const size_t row = low * rows->stride[WAVELENGTH] +
                                       theta * rows->stride[THETA_I] + from * rows->stride[PHI_I] +
                                       r * rows->stride[THETA_S] + given;
                    double f = rows->row[row][VALUE];
                    if (t > 0.0)
                        f += t * (rows->row[row + rows->stride[WAVELENGTH]][VALUE] - f);
                    /* isotropic: from the direction of travel, at half a turn from phi_i */
                    const size_t to = n_turn == 1 ? patch_at(k, n_phi, n_phi / 2) : k;
                    for (int side = 0; side < 2; side++)
                        table->block[side].value[(b * table->n_in + i) * table->out.n +
                                                 table->out.first[r] + to] = f;
                }
        }
    }
}

enum rmap_status rmap_bsdf_csv_read(const char *text, size_t nbytes,
                                    const struct rmap_bsdf_wanted *wanted,
                                    struct rmap_scatter_table **table_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_channels *channels = wanted->channels;
    struct rmap_number_rows rows = {
        .n_column = RMAP_ROW_COLUMNS,
        .name = column,
        .n_axis = VALUE,
        .row_is = "a row has six numbers: wavelength (nm; 0: any), theta_i, phi_i, theta_s, phi_s "
                  "(degrees), value (1/sr)"};
    size_t n_phi = 1, n_turn = 1;
    double *edge = NULL;
    struct rmap_scatter_table *table = NULL;
    RMAP_TRY(rmap_number_rows_read(text, nbytes, &rows, err));
    RMAP_TRY(check_rows(&rows, err));
    RMAP_TRY(rmap_table_covers(rows.each[WAVELENGTH], rows.count[WAVELENGTH], channels, err));
    RMAP_TRY(check_turn(&rows, PHI_S, rows.count[PHI_I] == 1, &n_phi, err));
    RMAP_TRY(check_turn(&rows, PHI_I, false, &n_turn, err));
    const size_t n_ring = rows.count[THETA_S];
    if (n_turn > 1 && (rows.each[PHI_I][0] != 0.0 || rows.each[PHI_S][0] != 0.0))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "phi_i and phi_s begin at 0"));
    if (n_turn == 1 && n_phi > 1 && rows.each[PHI_I][0] != rows.each[PHI_S][0])
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "phi_s begins at phi_i, %g: straight back",
                                rows.each[PHI_I][0]));
    edge = rmap_alloc(n_ring + 1, sizeof *edge);
    if (!edge)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    set_rings(&rows, edge);
    RMAP_TRY(rmap_scatter_table_create(
        &(struct rmap_scatter_table_shape){.n_ring = n_ring,
                                           .ring_deg = edge,
                                           .n_phi_each = n_phi,
                                           .n_theta = rows.count[THETA_I],
                                           .theta_deg = rows.each[THETA_I],
                                           .n_turn = n_turn,
                                           .n_band =
                                               rows.count[WAVELENGTH] > 1 ? (size_t)channels->n : 1,
                                           .side = {true, true}},
        &table, err));
    fill(&rows, channels, n_phi, n_turn, table);
    *table_ret = table;
    table = NULL;
out:
    rmap_scatter_table_destroy(table);
    rmap_free(edge);
    rmap_number_rows_fini(&rows);
    return st;
}
