/* SPDX-License-Identifier: MIT
 *
 * Zemax's tabular BSDF, the BSDF Data Interchange format of Radiant Imaging (R. Rykowski, 2008):
 * words and numbers, azimuth and radial angle about the specular direction, azimuth 0 towards the
 * normal. Its AngleOfIncidence is that of the specular direction; its SampleRotation is
 * counter-clockwise, as seen against the light, from the normal of the plane of incidence (the
 * light's travel x the surface's normal) to the sample's x axis.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_tables.h"

enum { ANGLES_MAX = 2000, WORD_NBYTES = 40 };
enum { ROTATION, INCIDENCE, AZIMUTH, RADIAL, LISTS };
static const char *const list_name[LISTS] = {"SampleRotation", "AngleOfIncidence", "ScatterAzimuth",
                                             "ScatterRadial"};

struct scan {
    const char *at, *end;
    size_t line;
    char word[WORD_NBYTES];
    double *list[LISTS];
    size_t n[LISTS];
    bool is_btdf, is_xyz, is_mirrored;
};

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',';
}

/* The next word, cut where it is too long; false at the end. */
static bool next(struct scan *scan)
{
    size_t n = 0;
    while (scan->at < scan->end && (is_blank(*scan->at) || *scan->at == '#')) {
        if (*scan->at == '#')
            while (scan->at + 1 < scan->end && scan->at[1] != '\n')
                scan->at++;
        scan->line += *scan->at++ == '\n';
    }
    for (; scan->at < scan->end && !is_blank(*scan->at); scan->at++)
        if (n + 1 < WORD_NBYTES)
            scan->word[n++] = *scan->at;
    scan->word[n] = 0;
    return n > 0;
}

static bool is_at(const struct scan *scan, const char *word)
{
    return strcmp(scan->word, word) == 0;
}

static enum rmap_status wrong(const struct scan *scan, const char *due, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_INPUT, "line %zu: '%s': %s was due", scan->line, scan->word,
                          due);
}

static enum rmap_status take_number(struct scan *scan, double low, double high, double *value,
                                    struct rmap_error *err)
{
    char *end = NULL;
    if (!next(scan))
        return wrong(scan, "a number", err);
    *value = strtod(scan->word, &end);
    if (*end || !(*value >= low && *value <= high))
        return rmap_error_set(err, RMAP_INPUT, "line %zu: '%s': a number from %g to %g was due",
                              scan->line, scan->word, low, high);
    return RMAP_OK;
}

/* A count and so many angles, ascending. */
static enum rmap_status take_list(struct scan *scan, int which, struct rmap_error *err)
{
    static const double most[LISTS] = {360.0, 90.0, 360.0, 180.0};
    enum rmap_status st = RMAP_OK;
    double count = 0.0;
    RMAP_TRY(take_number(scan, 1.0, ANGLES_MAX, &count, err));
    if (scan->list[which] || count != floor(count))
        RMAP_TRY(wrong(scan, "one whole number of angles", err));
    scan->n[which] = (size_t)count;
    scan->list[which] = rmap_alloc(scan->n[which], sizeof *scan->list[which]);
    if (!scan->list[which])
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    for (size_t i = 0; i < scan->n[which]; i++) {
        RMAP_TRY(take_number(scan, 0.0, most[which], &scan->list[which][i], err));
        if (i > 0 && !(scan->list[which][i] > scan->list[which][i - 1]))
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "line %zu: %s %s is out of order: they ascend",
                                    scan->line, list_name[which], scan->word));
    }
out:
    return st;
}

/* Up to DataBegin of the block that is read: of XYZ that of Y. */
static enum rmap_status take_head(struct scan *scan, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool wanted = false, begun = false;
    while (!begun && next(scan)) {
        int which = 0;
        while (which < LISTS && !is_at(scan, list_name[which]))
            which++;
        if (which < LISTS) {
            RMAP_TRY(take_list(scan, which, err));
        } else if (is_at(scan, "SpectralContent")) {
            scan->is_xyz = next(scan) && is_at(scan, "XYZ");
        } else if (is_at(scan, "ScatterType")) {
            scan->is_btdf = next(scan) && is_at(scan, "BTDF");
        } else if (is_at(scan, "Symmetry")) {
            scan->is_mirrored = next(scan) && is_at(scan, "PlaneSymmetrical");
        } else if (is_at(scan, scan->is_xyz ? "TristimulusY" : "Monochrome")) {
            wanted = true;
        } else {
            begun = wanted && is_at(scan, "DataBegin");
        }
    }
    for (int i = 0; i < LISTS && st == RMAP_OK; i++)
        if (!scan->list[i])
            st = rmap_error_set(err, RMAP_INPUT, "it has no %s: a tabular BSDF of Zemax has it",
                                list_name[i]);
    if (st == RMAP_OK && !begun)
        st = rmap_error_set(err, RMAP_INPUT, "it has no DataBegin behind %s",
                            scan->is_xyz ? "TristimulusY" : "Monochrome");
out:
    return st;
}

static bool is_near(double angle, double due)
{
    return fabs(angle - due) < 1e-3;
}

/* Of a list: without the first angle once more, after a whole turn. */
static size_t n_around(const struct scan *scan, int which)
{
    const size_t n = scan->n[which];
    return n > 1 && is_near(scan->list[which][n - 1], 360.0) ? n - 1 : n;
}

static double step_to(size_t i, size_t n_step)
{
    return 360.0 * (double)i / (double)n_step;
}

/* The first of n angles that is not where so many equal steps of a turn, from 0, have it; n: all
 * are. */
static size_t first_uneven(const double *angle, size_t n, size_t n_step)
{
    size_t i = 0;
    while (i < n && is_near(angle[i], step_to(i, n_step)))
        i++;
    return i;
}

/* Equal steps around, or over the half that the other mirrors. */
static enum rmap_status check_azimuth(const struct scan *scan, size_t *n_phi_ret,
                                      struct rmap_error *err)
{
    const double *phi = scan->list[AZIMUTH];
    const size_t n = n_around(scan, AZIMUTH);
    const bool half = n > 1 && scan->is_mirrored && is_near(phi[n - 1], 180.0);
    *n_phi_ret = half ? 2 * (n - 1) : n;
    return first_uneven(phi, n, *n_phi_ret) == n
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "its ScatterAzimuth is not in equal steps from 0 around, or to 180 "
                                "of a PlaneSymmetrical surface");
}

/* One rotation, whichever it is, or equal steps around. */
static enum rmap_status check_rotation(const struct scan *scan, size_t *n_turn_ret,
                                       struct rmap_error *err)
{
    const double *rotation = scan->list[ROTATION];
    const size_t n = n_around(scan, ROTATION), k = n > 1 ? first_uneven(rotation, n, n) : n;
    *n_turn_ret = n;
    return k == n ? RMAP_OK
                  : rmap_error_set(
                        err, RMAP_INPUT,
                        "SampleRotation %g, of %zu, stands where %g was due: they go from 0 around "
                        "in equal steps, as in 0 10 ... 350, those that the surface's symmetry "
                        "makes equal written out; or it is one, of a surface without directions",
                        rotation[k], n, step_to(k, n));
}

/* Every value takes a character and a blank: tables that the text has no room for are not made. */
static enum rmap_status check_room(const struct scan *scan, struct rmap_error *err)
{
    double due = 1.0;
    for (int i = 0; i < LISTS; i++)
        due *= (double)scan->n[i];
    return 2.0 * due <= (double)(scan->end - scan->at)
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "its angles ask for %.0f values, and less stands behind DataBegin",
                                due);
}

/* The lobe of one rotation and incidence into a row of patches; NULL: it is passed over. */
static enum rmap_status take_lobe(struct scan *scan, size_t n_phi,
                                  const struct rmap_patches *patches, double *row,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double tis = 0.0, f = 0.0;
    if (!next(scan) || !is_at(scan, "TIS"))
        RMAP_TRY(wrong(scan, "TIS", err));
    RMAP_TRY(take_number(scan, 0.0, HUGE_VAL, &tis, err));
    for (size_t k = 0; k < scan->n[AZIMUTH]; k++)
        for (size_t r = 0; r < scan->n[RADIAL]; r++) {
            RMAP_TRY(take_number(scan, 0.0, 1e300, &f, err));
            if (row && k < n_phi)
                row[patches->first[r] + k] = f;
            if (row && k > 0 && n_phi > scan->n[AZIMUTH])
                row[patches->first[r] + n_phi - k] = f;
        }
out:
    return st;
}

/* The sample turned one way is the plane of incidence turned the other way about it. */
static enum rmap_status take_data(struct scan *scan, size_t n_phi, struct rmap_scatter_table *table,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_turn = table->n_turn;
    double *value = table->block[1].value;
    for (size_t j = 0; j < scan->n[ROTATION]; j++)
        for (size_t i = 0; i < scan->n[INCIDENCE]; i++) {
            const size_t row = i * n_turn + (n_turn - j % n_turn) % n_turn;
            RMAP_TRY(take_lobe(scan, n_phi, &table->out,
                               j < n_turn ? value + row * table->out.n : NULL, err));
        }
    if (!next(scan) || !is_at(scan, "DataEnd"))
        RMAP_TRY(wrong(scan, "DataEnd", err));
    memcpy(table->block[0].value, value, table->n_in * table->out.n * sizeof *value);
out:
    return st;
}

/* Halfway between angles; the last ends as far behind it. */
static void set_rings(const struct scan *scan, double *edge)
{
    const double *radial = scan->list[RADIAL];
    const size_t n = scan->n[RADIAL];
    edge[0] = 0.0;
    for (size_t r = 1; r < n; r++)
        edge[r] = 0.5 * (radial[r - 1] + radial[r]);
    edge[n] = n > 1 ? fmin(180.0, radial[n - 1] + 0.5 * (radial[n - 1] - radial[n - 2])) : 180.0;
}

enum rmap_status rmap_bsdf_zemax_read(const char *text, size_t nbytes,
                                      const struct rmap_bsdf_wanted *wanted,
                                      struct rmap_scatter_table **table_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct scan scan = {.at = text, .end = text + nbytes, .line = 1};
    struct rmap_scatter_table *table = NULL;
    double *edge = NULL;
    size_t n_phi = 1, n_turn = 1;
    RMAP_TRY(take_head(&scan, err));
    const size_t n_ring = scan.n[RADIAL];
    if (scan.is_btdf != wanted->passes)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "it is a %s light",
                                scan.is_btdf ? "BTDF, of transmitted" : "BRDF, of reflected"));
    RMAP_TRY(check_rotation(&scan, &n_turn, err));
    RMAP_TRY(check_azimuth(&scan, &n_phi, err));
    RMAP_TRY(check_room(&scan, err));
    edge = rmap_alloc(n_ring + 1, sizeof *edge);
    if (!edge)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table"));
    set_rings(&scan, edge);
    RMAP_TRY(rmap_scatter_table_create(
        &(struct rmap_scatter_table_shape){.n_ring = n_ring,
                                           .ring_deg = edge,
                                           .n_phi_each = n_phi,
                                           .n_theta = scan.n[INCIDENCE],
                                           .theta_deg = scan.list[INCIDENCE],
                                           .n_turn = n_turn,
                                           .first_turn = 0.25, /* at 0 it travels along y */
                                           .n_band = 1,
                                           .side = {true, true},
                                           .about_specular = true},
        &table, err));
    RMAP_TRY(take_data(&scan, n_phi, table, err));
    *table_ret = table;
    table = NULL;
out:
    rmap_scatter_table_destroy(table);
    rmap_free(edge);
    for (int i = 0; i < LISTS; i++)
        rmap_free(scan.list[i]);
    return st;
}
