/* SPDX-License-Identifier: MIT
 *
 * Rows of a table of rays, and what its columns mean.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/unit.h"
#include "io/rays/ray_reader.h"

enum rmap_status rmap_file_rays_columns(struct rmap_file_rays *set,
                                        const bool has[RMAP_RAY_COLUMNS], struct rmap_error *err)
{
    if (has[RMAP_RAY_POWER])
        set->below = rmap_alloc(set->n, sizeof *set->below);
    if (has[RMAP_RAY_NM])
        set->wavelength_nm = rmap_alloc(set->n, sizeof *set->wavelength_nm);
    if (has[RMAP_RAY_TIME])
        set->delay_ns = rmap_alloc(set->n, sizeof *set->delay_ns);
    if (has[RMAP_RAY_EVENT])
        set->event = rmap_alloc(set->n, sizeof *set->event);
    if (has[RMAP_RAY_LENGTH])
        set->step = rmap_alloc(set->n, sizeof *set->step);
    return has[RMAP_RAY_LENGTH] > !!set->step || has[RMAP_RAY_POWER] > !!set->below ||
                   has[RMAP_RAY_NM] > !!set->wavelength_nm ||
                   has[RMAP_RAY_TIME] > !!set->delay_ns || has[RMAP_RAY_EVENT] > !!set->event
               ? rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", set->n)
               : RMAP_OK;
}

void rmap_file_rays_put(struct rmap_file_rays *set, size_t row,
                        const double value[RMAP_RAY_COLUMNS])
{
    for (int k = 0; k < 6; k++)
        if (set->wide)
            set->wide[row][k] = value[k];
        else
            set->narrow[row][k] = (float)value[k];
    if (set->below)
        set->below[row] = value[RMAP_RAY_POWER];
    if (set->wavelength_nm)
        set->wavelength_nm[row] = (float)value[RMAP_RAY_NM];
    if (set->delay_ns)
        set->delay_ns[row] = value[RMAP_RAY_TIME];
    if (set->event)
        set->event[row] =
            isnan(value[RMAP_RAY_EVENT]) ? RMAP_NO_EVENT : (uint64_t)value[RMAP_RAY_EVENT];
    if (set->step)
        memcpy(set->step[row], value + RMAP_RAY_LENGTH, sizeof set->step[row]);
}

static enum rmap_status grow_column(void *column_address, size_t cap, size_t size,
                                    struct rmap_error *err)
{
    void *column;
    memcpy(&column, column_address, sizeof column);
    void *more = column ? rmap_realloc(column, cap, size) : NULL;
    if (column && !more)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", cap);
    memcpy(column_address, &more, sizeof more);
    return RMAP_OK;
}

static enum rmap_status grow(struct rmap_file_rays *set, size_t cap, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(grow_column(&set->wide, cap, sizeof *set->wide, err));
    RMAP_TRY(grow_column(&set->below, cap, sizeof *set->below, err));
    RMAP_TRY(grow_column(&set->wavelength_nm, cap, sizeof *set->wavelength_nm, err));
    RMAP_TRY(grow_column(&set->delay_ns, cap, sizeof *set->delay_ns, err));
    RMAP_TRY(grow_column(&set->event, cap, sizeof *set->event, err));
    RMAP_TRY(grow_column(&set->step, cap, sizeof *set->step, err));
out:
    return st;
}

enum rmap_status rmap_ray_rows_add(struct rmap_ray_rows *rows, const double value[RMAP_RAY_COLUMNS],
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!rows->set) {
        rows->cap = 1024;
        RMAP_TRY(rmap_file_rays_create(rows->cap, true, &rows->set, err));
        RMAP_TRY(rmap_file_rays_columns(rows->set, rows->has, err));
        rows->set->n = 0;
    }
    if (rows->set->n == rows->cap) {
        RMAP_TRY(grow(rows->set, 2 * rows->cap, err));
        rows->cap *= 2;
    }
    rmap_file_rays_put(rows->set, rows->set->n++, value);
out:
    return st;
}

enum rmap_status rmap_ray_rows_finish(struct rmap_ray_rows *rows, struct rmap_file_rays **set_ret,
                                      struct rmap_error *err)
{
    if (!rows->set)
        return rmap_error_set(err, RMAP_INPUT, "it has no rays");
    enum rmap_status st = grow(rows->set, rows->set->n, err);
    if (st == RMAP_OK && rows->set->below)
        st = rmap_file_rays_weigh(rows->set, err);
    if (st != RMAP_OK)
        return st;
    *set_ret = rows->set;
    rows->set = NULL;
    return RMAP_OK;
}

/* ---- columns by their names ---- */

static bool is_one_of(const char *words, const char *name, size_t n)
{
    for (const char *at = words; *at; at += strcspn(at, " "), at += strspn(at, " "))
        if (strcspn(at, " ") == n && strncasecmp(at, name, n) == 0)
            return true;
    return false;
}

static const struct {
    const char *words;
    enum rmap_ray_column column;
    enum rmap_dimension dimension;
    bool no_steps, no_rays;
} known[] = {
    {"x px position_x", RMAP_RAY_X, RMAP_DIMENSION_LENGTH},
    {"y py position_y", RMAP_RAY_Y, RMAP_DIMENSION_LENGTH},
    {"z pz position_z", RMAP_RAY_Z, RMAP_DIMENSION_LENGTH},
    {"dx kx l ux direction_x", RMAP_RAY_DX, RMAP_DIMENSION_NONE},
    {"dy ky m uy direction_y", RMAP_RAY_DY, RMAP_DIMENSION_NONE},
    {"dz kz n uz direction_z", RMAP_RAY_DZ, RMAP_DIMENSION_NONE},
    {"weight power flux", RMAP_RAY_POWER, RMAP_DIMENSION_FLUX, .no_steps = true},
    {"wavelength lambda", RMAP_RAY_NM, RMAP_DIMENSION_WAVELENGTH, .no_steps = true},
    {"energy", RMAP_RAY_NM, RMAP_DIMENSION_NONE, .no_steps = true},
    {"energy edep deposit", RMAP_RAY_DEPOSIT, RMAP_DIMENSION_NONE, .no_rays = true},
    {"length", RMAP_RAY_LENGTH, RMAP_DIMENSION_LENGTH, .no_rays = true},
    {"charge", RMAP_RAY_CHARGE, RMAP_DIMENSION_NONE, .no_rays = true},
    {"beta", RMAP_RAY_BETA, RMAP_DIMENSION_NONE, .no_rays = true},
    {"time delay", RMAP_RAY_TIME, RMAP_DIMENSION_TIME},
    {"event", RMAP_RAY_EVENT, RMAP_DIMENSION_NONE},
};

/* eV and its multiples; 0: none. */
static double electronvolts(const char *unit, size_t n)
{
    static const struct {
        const char *name;
        double size;
    } all[] = {{"eV", 1.0}, {"meV", 1e-3}, {"keV", 1e3}, {"MeV", 1e6}, {"GeV", 1e9}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (strlen(all[i].name) == n && memcmp(all[i].name, unit, n) == 0)
            return all[i].size;
    return 0.0;
}

static enum rmap_status unit_of(size_t k, const char *unit, size_t n,
                                struct rmap_ray_meaning *meaning, struct rmap_error *err)
{
    const enum rmap_dimension dimension = known[k].dimension;
    const bool nm = dimension == RMAP_DIMENSION_WAVELENGTH;
    const struct rmap_written_unit *written = rmap_unit_named(unit, n);
    const bool flux = dimension == RMAP_DIMENSION_FLUX;
    const double mev =
        known[k].column == RMAP_RAY_DEPOSIT && n > 0 ? 1e-6 * electronvolts(unit, n) : 1.0;
    meaning->inverse = strcmp(known[k].words, "energy") == 0;
    meaning->said = flux && written;
    meaning->flux_unit = meaning->said ? written->flux : RMAP_FLUX_W;
    meaning->factor = dimension == RMAP_DIMENSION_LENGTH ? 0.0 : 1.0;
    if (meaning->inverse)
        meaning->factor = RMAP_EV_NM / (n > 0 ? electronvolts(unit, n) : 1.0);
    else if (known[k].column == RMAP_RAY_DEPOSIT)
        meaning->factor = mev > 0.0 ? mev : HUGE_VAL;
    else if (written && (written->dimension == (nm ? RMAP_DIMENSION_LENGTH : dimension) ||
                         (flux && written->dimension == RMAP_DIMENSION_ENERGY)))
        meaning->factor = written->size * (nm || dimension == RMAP_DIMENSION_TIME ? 1e9 : 1.0);
    else if (n > 0 && !(n == 1 && *unit == '1'))
        meaning->factor = HUGE_VAL;
    return meaning->factor < HUGE_VAL
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT, "'%.*s' is no unit of its column '%.*s'",
                                (int)(n < 40 ? n : 40), unit, (int)strcspn(known[k].words, " "),
                                known[k].words);
}

enum rmap_status rmap_ray_meaning_of(const char *name, const char *unit, bool steps,
                                     struct rmap_ray_meaning *meaning, struct rmap_error *err)
{
    const size_t n = strcspn(name, " \t([");
    if (!unit)
        unit = name + n + strspn(name + n, " \t([");
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (!(steps ? known[k].no_steps : known[k].no_rays) && is_one_of(known[k].words, name, n)) {
            meaning->column = known[k].column;
            return unit_of(k, unit, strcspn(unit, " \t)]"), meaning, err);
        }
    return rmap_error_set(
        err, RMAP_INPUT,
        "it has a column '%.60s'; known are x, y, z, dx, dy, dz, %s and event, "
        "with their units in brackets",
        name, steps ? "length, energy, time, charge, beta" : "wavelength or energy, time, weight");
}
