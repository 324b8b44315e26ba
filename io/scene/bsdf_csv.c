/* SPDX-License-Identifier: MIT
 *
 * A measured BSDF as text: rows of wavelength, theta_i, phi_i, theta_s, phi_s, value.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_tables.h"

enum { COLUMNS = 6, WAVELENGTH = 0, THETA_I, PHI_I, THETA_S, PHI_S, VALUE };
static const char *const column_name[COLUMNS] = {"wavelength", "theta_i", "phi_i",
                                                 "theta_s",    "phi_s",   "value"};

struct rows {
    double (*row)[COLUMNS];
    size_t *line; /* of each, from 1 */
    size_t n, cap;
    /* The distinct numbers of each column but the last, ascending, and how many rows one stands
     * for. */
    double *each[VALUE];
    size_t count[VALUE], stride[VALUE];
};

static void rows_fini(struct rows *rows)
{
    for (int c = 0; c < VALUE; c++)
        rmap_free(rows->each[c]);
    rmap_free(rows->row);
    rmap_free(rows->line);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

/* The names of the columns, as a first line may have them. */
static bool is_head(const char *at, const char *end)
{
    for (int c = 0; c < COLUMNS; c++) {
        const size_t n = strlen(column_name[c]);
        while (at < end && is_blank(*at))
            at++;
        if ((size_t)(end - at) < n || strncmp(at, column_name[c], n) != 0)
            return false;
        at += n;
    }
    return true;
}

static enum rmap_status read_row(const char *at, const char *end, size_t line, struct rows *rows,
                                 struct rmap_error *err)
{
    double value[COLUMNS];
    for (int c = 0; c < COLUMNS; c++) {
        char *stop = NULL;
        while (at < end && is_blank(*at))
            at++;
        value[c] = at < end ? strtod(at, &stop) : 0.0;
        if (at >= end || stop == at || stop > end || !isfinite(value[c]))
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %zu: a row has six numbers: wavelength (nm; 0: any), "
                                  "theta_i, phi_i, theta_s, phi_s (degrees), value (1/sr)",
                                  line);
        at = stop;
    }
    while (at < end && is_blank(*at))
        at++;
    if (at < end && *at != '#')
        return rmap_error_set(err, RMAP_INPUT, "line %zu: something follows its six numbers", line);
    if (value[VALUE] < 0.0)
        return rmap_error_set(err, RMAP_INPUT, "line %zu: a BSDF of %g: it is not negative", line,
                              value[VALUE]);
    if (value[THETA_I] < 0.0 || value[THETA_I] > 90.0 || value[THETA_S] < 0.0 ||
        value[THETA_S] > 90.0)
        return rmap_error_set(err, RMAP_INPUT,
                              "line %zu: theta is from 0 to 90 degrees from the normal", line);
    if (rows->n == rows->cap) {
        const size_t cap = rows->cap ? 2 * rows->cap : 1024;
        void *more = rmap_realloc(rows->row, cap, sizeof *rows->row);
        if (more)
            rows->row = more;
        void *lines = more ? rmap_realloc(rows->line, cap, sizeof *rows->line) : NULL;
        if (!lines)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
        rows->line = lines;
        rows->cap = cap;
    }
    memcpy(rows->row[rows->n], value, sizeof value);
    rows->line[rows->n++] = line;
    return RMAP_OK;
}

static enum rmap_status read_rows(const char *text, size_t nbytes, struct rows *rows,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *at = text, *const end = text + nbytes;
    bool first = true;
    for (size_t line = 1; st == RMAP_OK && at < end; line++) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        while (at < stop && is_blank(*at))
            at++;
        const bool content = at < stop && *at != '#';
        if (content && !(first && is_head(at, stop)))
            st = read_row(at, stop, line, rows, err);
        first = first && !content;
        at = stop + (stop < end);
    }
    if (st == RMAP_OK && rows->n == 0)
        st = rmap_error_set(err, RMAP_INPUT,
                            "it has no rows of wavelength, theta_i, phi_i, theta_s, phi_s, value");
    return st;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Every combination once, the last column fastest, all ascending. */
static enum rmap_status find_axes(struct rows *rows, struct rmap_error *err)
{
    size_t product = 1;
    for (int c = 0; c < VALUE; c++) {
        rows->each[c] = rmap_alloc(rows->n, sizeof *rows->each[c]);
        if (!rows->each[c])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
        for (size_t i = 0; i < rows->n; i++)
            rows->each[c][i] = rows->row[i][c];
        qsort(rows->each[c], rows->n, sizeof *rows->each[c], ascending);
        for (size_t i = 0; i < rows->n; i++)
            if (i == 0 || rows->each[c][i] != rows->each[c][rows->count[c] - 1])
                rows->each[c][rows->count[c]++] = rows->each[c][i];
        product = product > rows->n ? product : product * rows->count[c];
    }
    rows->stride[PHI_S] = 1;
    for (int c = PHI_S; c > 0; c--)
        rows->stride[c - 1] = rows->stride[c] * rows->count[c];
    for (size_t i = 0; i < rows->n; i++)
        for (int c = 0; c < VALUE; c++)
            if (rows->row[i][c] != rows->each[c][i / rows->stride[c] % rows->count[c]])
                return rmap_error_set(err, RMAP_INPUT,
                                      "line %zu: %s %g is out of order: every combination of "
                                      "angles stands there once, ascending, the last column "
                                      "fastest (here %g was due)",
                                      rows->line[i], column_name[c], rows->row[i][c],
                                      rows->each[c][i / rows->stride[c] % rows->count[c]]);
    if (product != rows->n)
        return rmap_error_set(err, RMAP_INPUT,
                              "it has %zu rows, and %zu wavelengths x %zu x %zu x %zu x %zu angles "
                              "are more",
                              rows->n, rows->count[0], rows->count[1], rows->count[2],
                              rows->count[3], rows->count[4]);
    return RMAP_OK;
}

/* Azimuths go around in equal steps from the first one; 0 to 180 stands for both halves. *turn_ret:
 * steps of a whole turn. */
static enum rmap_status check_turn(const struct rows *rows, int c, bool may_mirror,
                                   size_t *turn_ret, struct rmap_error *err)
{
    const double *phi = rows->each[c], near = 1e-6;
    const size_t n = rows->count[c];
    const double span = n > 1 ? phi[n - 1] - phi[0] : 0.0,
                 step = n > 1 ? span / (double)(n - 1) : 0;
    *turn_ret = n;
    for (size_t i = 1; i < n; i++)
        if (fabs(phi[i] - phi[0] - step * (double)i) > 1e-3 * step)
            return rmap_error_set(err, RMAP_INPUT, "%s is not in equal steps", column_name[c]);
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
                          column_name[c], may_mirror ? "from 0 to 180, or " : "");
}

/* Halfway between angles; the first begins at 0, the last ends as far behind it, at 90 at most. */
static void set_rings(const struct rows *rows, double *edge)
{
    const double *theta = rows->each[THETA_S];
    const size_t n = rows->count[THETA_S];
    edge[0] = 0.0;
    for (size_t i = 1; i < n; i++)
        edge[i] = 0.5 * (theta[i - 1] + theta[i]);
    edge[n] = n > 1 ? fmin(90.0, theta[n - 1] + 0.5 * (theta[n - 1] - theta[n - 2])) : 90.0;
}

static enum rmap_status check_wavelengths(const struct rows *rows,
                                          const struct rmap_channels *channels,
                                          struct rmap_error *err)
{
    const double *nm = rows->each[WAVELENGTH];
    const size_t n = rows->count[WAVELENGTH];
    if (n == 1 && nm[0] == 0.0)
        return RMAP_OK;
    const double from = channels->wavelength_nm[0], to = channels->wavelength_nm[channels->n - 1];
    if (nm[0] > from + 1e-6 || nm[n - 1] < to - 1e-6)
        return rmap_error_set(err, RMAP_INPUT,
                              "it covers %g to %g nm, and the scene has light from %g to %g nm; "
                              "wavelength 0 stands for any",
                              nm[0], nm[n - 1], from, to);
    return RMAP_OK;
}

/* Where azimuth k of the file stands among the n patches of a ring, which count from the direction
 * of travel. shift: half a turn, in patches. */
static size_t patch_at(size_t k, size_t n, size_t shift)
{
    return (k + shift) % n;
}

static void fill(const struct rows *rows, const struct rmap_channels *channels, size_t n_phi,
                 size_t n_turn, struct rmap_scatter_table *table)
{
    const double *nm = rows->each[WAVELENGTH];
    const size_t n_given = rows->count[PHI_S];
    for (size_t b = 0; b < table->n_band; b++) {
        size_t low = 0;
        double t = 0.0;
        if (table->n_band > 1 || rows->count[WAVELENGTH] > 1) {
            const double at = channels->wavelength_nm[b];
            while (low + 2 < rows->count[WAVELENGTH] && at >= nm[low + 1])
                low++;
            t = (at - nm[low]) / (nm[low + 1] - nm[low]);
            t = t < 0.0 ? 0.0 : t < 1.0 ? t : 1.0;
        }
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
    struct rows rows = {.n = 0};
    size_t n_phi = 1, n_turn = 1, *each_phi = NULL;
    double *edge = NULL;
    struct rmap_scatter_table *table = NULL;
    RMAP_TRY(read_rows(text, nbytes, &rows, err));
    RMAP_TRY(find_axes(&rows, err));
    RMAP_TRY(check_wavelengths(&rows, channels, err));
    RMAP_TRY(check_turn(&rows, PHI_S, rows.count[PHI_I] == 1, &n_phi, err));
    RMAP_TRY(check_turn(&rows, PHI_I, false, &n_turn, err));
    const size_t n_ring = rows.count[THETA_S];
    if (n_turn > 1 && (rows.each[PHI_I][0] != 0.0 || rows.each[PHI_S][0] != 0.0))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "phi_i and phi_s begin at 0"));
    if (n_turn == 1 && n_phi > 1 && rows.each[PHI_I][0] != rows.each[PHI_S][0])
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "phi_s begins at phi_i, %g: straight back",
                                rows.each[PHI_I][0]));
    edge = rmap_alloc(n_ring + 1, sizeof *edge);
    each_phi = rmap_alloc(n_ring, sizeof *each_phi);
    if (!edge || !each_phi)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    set_rings(&rows, edge);
    for (size_t r = 0; r < n_ring; r++)
        each_phi[r] = n_phi;
    RMAP_TRY(rmap_scatter_table_create(
        &(struct rmap_scatter_table_shape){.n_ring = n_ring,
                                           .ring_deg = edge,
                                           .n_phi = each_phi,
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
    rmap_free(each_phi);
    rows_fini(&rows);
    return st;
}
