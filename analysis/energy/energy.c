/* SPDX-License-Identifier: MIT */
#include "analysis/energy/energy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

/* Sources [first, last) of the map and the sums that a table is made of. */
struct making {
    const struct rmap_map *map;
    const struct rmap_energy_sums *sums;
    size_t first, last;
    struct rmap_energy_table *table;
};

/* Per source: rays emitted, flux of one of them. */
static double variance_of(const struct making *making, size_t source, double sum, double squares)
{
    const double n = rmap_map_emitted(making->map)[source];
    const double unit = rmap_map_flux_per_weight(making->map)[source];
    if (sum <= 0.0 && squares <= 0.0)
        return 0.0;
    return n < 2 || isnan(squares) ? (double)NAN
                                   : unit * unit * n / (n - 1) * fmax(squares - sum * sum / n, 0.0);
}

/* A row's sums of q and q^2 of source s are sum[s * stride] and squares[s * stride]. Its share is
 * flux / emitted = R; the residual of a ray is q - R, since each is emitted with weight 1. */
static void fill(const struct making *making, const double *sum, const double *squares,
                 size_t stride, struct rmap_energy_row *row)
{
    double variance = 0.0, of_share = 0.0;
    for (size_t s = making->first; s < making->last; s++) {
        row->rays += sum[s * stride];
        row->flux += rmap_map_flux(making->map, s, sum[s * stride]);
        variance += variance_of(making, s, sum[s * stride], squares[s * stride]);
    }
    const double total = making->table->flux, share = row->flux / total;
    for (size_t s = making->first; s < making->last; s++) {
        const double q = sum[s * stride], q2 = squares[s * stride], m = making->sums->rays[s];
        of_share +=
            variance_of(making, s, fabs(q - share * m), q2 - 2.0 * share * q + share * share * m);
    }
    row->flux_error = sqrt(variance);
    row->share = total > 0.0 ? share : (double)NAN;
    row->share_error = total > 0.0 ? sqrt(of_share) / total : (double)NAN;
}

/* The most first; equal ones by name, then in the scene's order. */
static int by_flux(const void *a, const void *b)
{
    const struct rmap_energy_row *left = a, *right = b;
    if (left->flux > right->flux || left->flux < right->flux)
        return left->flux > right->flux ? -1 : 1;
    int order = strcmp(left->name, right->name);
    return order ? order : (left->index > right->index) - (left->index < right->index);
}

/* One row for ends [from, from + n) of a kind; those that absorbed nothing are left out. */
static void add_ends(const struct making *making, enum rmap_energy_end end, size_t from, size_t n)
{
    const struct rmap_energy_sums *sums = making->sums;
    const struct rmap_scene *scene = sums->scope->scene;
    struct rmap_energy_table *table = making->table;
    struct rmap_energy_row *first = table->row + table->n_row;
    for (size_t i = 0; i < n; i++) {
        struct rmap_energy_row row = {.end = end, .index = i, .name = ""};
        if (end == RMAP_ENERGY_OBJECT)
            row.name = scene->object[i].name;
        else if (end == RMAP_ENERGY_MEDIUM)
            row.name = scene->medium[i].name;
        fill(making, sums->ended + from + i, sums->ended_squared + from + i, sums->n_end, &row);
        if (row.rays > 0.0 || end > RMAP_ENERGY_MEDIUM)
            table->row[table->n_row++] = row;
    }
    if (end <= RMAP_ENERGY_MEDIUM)
        qsort(first, (size_t)(table->row + table->n_row - first), sizeof *first, by_flux);
}

static void add_detectors(const struct making *making)
{
    const struct rmap_energy_sums *sums = making->sums;
    struct rmap_energy_table *table = making->table;
    for (size_t d = 0; d < sums->n_detector; d++) {
        struct rmap_energy_row row = {
            .end = RMAP_ENERGY_DETECTOR, .index = d, .name = sums->scope->scene->detector[d].name};
        fill(making, sums->caught + d, sums->caught_squared + d, sums->n_detector, &row);
        table->row[table->n_row + table->n_detector++] = row;
    }
}

static void make_table(const struct making *making)
{
    const struct rmap_energy_sums *sums = making->sums;
    const struct rmap_scene *scene = sums->scope->scene;
    struct rmap_energy_table *table = making->table;
    double variance = 0.0, ended = 0.0;
    for (size_t s = making->first; s < making->last; s++) {
        table->rays += sums->rays[s];
        table->flux += rmap_map_flux_per_weight(making->map)[s] * sums->rays[s];
        variance += variance_of(making, s, sums->rays[s], sums->rays[s]);
    }
    table->flux_error = sqrt(variance);
    const size_t n_object = scene->n_object, n_medium = scene->n_medium;
    add_ends(making, RMAP_ENERGY_OBJECT, 0, n_object);
    add_ends(making, RMAP_ENERGY_MEDIUM, n_object, n_medium);
    add_ends(making, RMAP_ENERGY_LEFT, n_object + n_medium, 1);
    add_ends(making, RMAP_ENERGY_LIMIT, n_object + n_medium + 1, 1);
    add_ends(making, RMAP_ENERGY_ERROR, n_object + n_medium + 2, 1);
    for (size_t i = 0; i < table->n_row; i++)
        ended += table->row[i].rays;
    table->exact = !(ended < table->rays || ended > table->rays);
    add_detectors(making);
}

static enum rmap_status make_tables(const struct rmap_map *map, const struct rmap_energy_sums *sums,
                                    struct rmap_energy *energy, struct rmap_error *err)
{
    energy->table = rmap_alloc(sums->n_source + 1, sizeof *energy->table);
    for (; energy->table && energy->n_table < sums->n_source + 1; energy->n_table++) {
        struct rmap_energy_table *table = &energy->table[energy->n_table];
        struct making making = {map, sums, 0, sums->n_source, table};
        if (energy->n_table > 0) {
            making.first = energy->n_table - 1;
            making.last = energy->n_table;
            table->source = sums->scope->scene->source[making.first].name;
        }
        table->row = rmap_alloc(sums->n_end + sums->n_detector, sizeof *table->row);
        if (!table->row)
            break;
        make_table(&making);
        void *row = rmap_realloc(table->row, table->n_row + table->n_detector, sizeof *table->row);
        table->row = row ? row : table->row;
    }
    if (energy->n_table < sums->n_source + 1)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the energy balance");
    return RMAP_OK;
}

enum rmap_status rmap_energy_create(const struct rmap_map *map, const char *map_name,
                                    const char *criterion, const struct rmap_energy_sums *sums,
                                    struct rmap_energy **energy_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_tally *tally = rmap_map_tally(map);
    struct rmap_energy *energy = rmap_alloc(1, sizeof *energy);
    if (!energy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the energy balance");
    energy->scene = rmap_map_scene(map);
    energy->map = map_name;
    energy->of = map;
    energy->criterion = criterion;
    energy->unit = energy->scene->flux_unit == RMAP_FLUX_LM ? "lm" : "W";
    for (size_t s = 0; s < sums->n_source; s++) {
        energy->map_rays += tally->emitted[s];
        energy->map_flux += rmap_map_flux_per_weight(map)[s] * tally->emitted[s];
    }
    RMAP_TRY(make_tables(map, sums, energy, err));
    *energy_ret = energy;
    energy = NULL;
out:
    rmap_energy_destroy(energy);
    return st;
}

/* Adds up what comes behind the largest ones of a kind. */
static void add_to_others(struct rmap_energy_shown *shown, const struct rmap_energy_row *row,
                          size_t n)
{
    struct rmap_energy_row *others = &shown->row[shown->n - 1];
    if (n == 1) {
        others = &shown->row[shown->n++];
        *others = (struct rmap_energy_row){
            .end = row->end, .flux_error = (double)NAN, .share_error = (double)NAN};
    }
    (void)snprintf(shown->others[row->end], sizeof shown->others[0], "%zu other%s", n,
                   n > 1 ? "s" : "");
    others->name = shown->others[row->end];
    others->rays += row->rays;
    others->flux += row->flux;
    others->share += row->share;
}

void rmap_energy_show(const struct rmap_energy_table *table, struct rmap_energy_shown *shown)
{
    size_t n[RMAP_ENERGY_DETECTOR] = {0};
    shown->n = 0;
    for (size_t i = 0; i < table->n_row; i++) {
        const struct rmap_energy_row *row = &table->row[i];
        n[row->end]++;
        if (row->end <= RMAP_ENERGY_MEDIUM && n[row->end] > RMAP_ENERGY_SHOWN)
            add_to_others(shown, row, n[row->end] - RMAP_ENERGY_SHOWN);
        else if (row->rays > 0.0 || row->end <= RMAP_ENERGY_LEFT)
            shown->row[shown->n++] = *row;
    }
}

void rmap_energy_destroy(struct rmap_energy *energy)
{
    if (!energy)
        return;
    for (size_t i = 0; energy->table && i < energy->n_table; i++)
        rmap_free(energy->table[i].row);
    rmap_free(energy->table);
    rmap_free(energy);
}
