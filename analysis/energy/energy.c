/* SPDX-License-Identifier: MIT
 *
 * The energy balance of a map, or of the rays of it that match: what was emitted = what each
 * object and medium absorbed + what left the scene + what a limit or an error ended.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/energy/energy.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_number.h"
#include "portion/weight.h"

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

/* Of each ray what its weight lost. */
static enum rmap_status add_heat(const struct making *making, struct rmap_error *err)
{
    const struct rmap_energy_sums *sums = making->sums;
    struct rmap_energy_row row = {.end = RMAP_ENERGY_HEAT, .name = ""};
    double *heat = rmap_alloc(2 * sums->n_source, sizeof *heat);
    if (!heat)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the energy balance");
    for (size_t s = making->first; s < making->last; s++) {
        heat[2 * s] = heat[2 * s + 1] = sums->rays[s];
        for (size_t e = s * sums->n_end; e < (s + 1) * sums->n_end; e++) {
            heat[2 * s] -= sums->ended[e];
            heat[2 * s + 1] += sums->ended_squared[e] - 2.0 * sums->ended[e];
        }
    }
    fill(making, heat, heat + 1, 2, &row);
    making->table->row[making->table->n_row++] = row;
    rmap_free(heat);
    return RMAP_OK;
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

static enum rmap_status make_table(const struct making *making, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
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
    if (rmap_scene_changes_weights(scene))
        RMAP_TRY(add_heat(making, err));
    for (size_t i = 0; i < table->n_row; i++)
        ended += table->row[i].rays;
    table->exact = !(ended < table->rays || ended > table->rays);
    add_detectors(making);
out:
    return st;
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
        table->row = rmap_alloc(sums->n_end + 1 + sums->n_detector, sizeof *table->row);
        if (!table->row)
            break;
        const enum rmap_status st = make_table(&making, err);
        if (st != RMAP_OK)
            return st;
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
    energy->unit = rmap_flux_unit_name(energy->scene);
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
        else if (row->rays > 0.0 || row->end <= RMAP_ENERGY_LEFT || row->end == RMAP_ENERGY_HEAT)
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

/* The energy balance as text: for people, as CSV and as JSON. */

const char *rmap_energy_end_text(enum rmap_energy_end end)
{
    static const char *const text[] = {
        [RMAP_ENERGY_OBJECT] = "absorbed by",        [RMAP_ENERGY_MEDIUM] = "absorbed in",
        [RMAP_ENERGY_LEFT] = "left the scene",       [RMAP_ENERGY_LIMIT] = "stopped by a limit",
        [RMAP_ENERGY_ERROR] = "stopped by an error", [RMAP_ENERGY_HEAT] = "turned to heat",
        [RMAP_ENERGY_DETECTOR] = "registered by"};
    return text[end];
}

static void add_number(struct rmap_text_table *table, double value, int digits)
{
    if (isfinite(value))
        rmap_text_table_add(table, "%.*g", digits, value);
    else
        rmap_text_table_add(table, "-");
}

static void add_share(struct rmap_text_table *table, double share)
{
    if (isfinite(share))
        rmap_text_table_add(table, "%.4f", 100.0 * share);
    else
        rmap_text_table_add(table, "-");
}

/* The whole of a table: a share of 1, or of nothing none. */
static struct rmap_energy_row emitted_row(const struct rmap_energy_table *table)
{
    return (struct rmap_energy_row){.name = "",
                                    .rays = table->rays,
                                    .flux = table->flux,
                                    .flux_error = table->flux_error,
                                    .share = table->flux / table->flux};
}

/* What, name, rays, flux, its error, share, its error. */
enum { N_COLUMN = 7 };

static void add_row(struct rmap_text_table *table, const char *what,
                    const struct rmap_energy_row *row)
{
    char rays[RMAP_GROUPED_LEN];
    rmap_text_table_add(table, "  %s", what);
    rmap_text_table_add(table, "%s", row->name);
    rmap_text_table_add(table, "%s", rmap_grouped(rmap_weight_whole(row->rays), rays));
    add_number(table, row->flux, 6);
    add_number(table, row->flux_error, 2);
    add_share(table, row->share);
    add_number(table, 100.0 * row->share_error, 2);
}

static void add_headings(struct rmap_text_table *table, const char *counted, const char *unit)
{
    const char *const heading[N_COLUMN] = {"", "", counted, unit, "+-", "%", "+-"};
    for (int k = 0; k < N_COLUMN; k++)
        rmap_text_table_add(table, "%s", heading[k]);
}

static void add_rows(const struct rmap_energy_table *from, struct rmap_text_table *table)
{
    struct rmap_energy_shown shown;
    rmap_energy_show(from, &shown);
    for (size_t i = 0; i < shown.n; i++)
        add_row(table, rmap_energy_end_text(shown.row[i].end), &shown.row[i]);
}

static enum rmap_status print_table(const struct rmap_energy *energy,
                                    const struct rmap_energy_table *from, FILE *out,
                                    struct rmap_error *err)
{
    struct rmap_text_table table;
    const struct rmap_energy_row emitted = emitted_row(from);
    if (from->source)
        fprintf(out, "\nsource %s\n", from->source);
    else
        fprintf(out, energy->n_table > 2 ? "\nall sources\n" : "\n");
    rmap_text_table_init(&table, N_COLUMN);
    add_headings(&table, "rays", energy->unit);
    add_row(&table, "emitted", &emitted);
    add_rows(from, &table);
    enum rmap_status st = rmap_text_table_print(&table, "llrrrrr", out, err);
    rmap_text_table_fini(&table);
    if (st != RMAP_OK)
        return st;
    fprintf(out,
            from->exact ? "  these add up to the %s emitted, exactly\n"
                        : "  these do NOT add up to the %s emitted\n",
            rmap_counted(rmap_weight_whole(from->rays), "ray").text);
    if (from->n_detector == 0)
        return RMAP_OK;
    fprintf(out, "\n  beside that, light that detectors registered on its way:\n");
    rmap_text_table_init(&table, N_COLUMN);
    add_headings(&table, "registrations", energy->unit);
    for (size_t d = 0; d < from->n_detector; d++)
        add_row(&table, rmap_energy_end_text(RMAP_ENERGY_DETECTOR), &from->row[from->n_row + d]);
    st = rmap_text_table_print(&table, "llrrrrr", out, err);
    rmap_text_table_fini(&table);
    return st;
}

enum rmap_status rmap_energy_print(const struct rmap_energy *energy, FILE *out,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char rays[RMAP_GROUPED_LEN];
    fprintf(out, "energy of %s\n", energy->map);
    if (energy->criterion) {
        fprintf(out, "  of the rays that match: %s\n", energy->criterion);
        fprintf(out, "  %s of %s, %.6g of %.6g %s\n",
                rmap_grouped(rmap_weight_whole(energy->table[0].rays), rays),
                rmap_counted(rmap_weight_whole(energy->map_rays), "ray").text,
                energy->table[0].flux, energy->map_flux, energy->unit);
    }
    if (rmap_which_chooses(energy->which))
        fprintf(out, "  registrations: %s\n", energy->which->text);
    if (!(energy->table[0].rays > 0.0))
        fprintf(out, "  no ray matches: nothing is shared out\n");
    for (size_t i = energy->n_table == 2 ? 1 : 0; i < energy->n_table && st == RMAP_OK; i++)
        st = print_table(energy, &energy->table[i], out, err);
    return st;
}

static void put_line(const struct rmap_energy_table *table, const char *what,
                     const struct rmap_energy_row *row, FILE *out)
{
    const double number[] = {row->flux, row->flux_error, row->share, row->share_error};
    rmap_csv_put_first(table->source, out);
    fprintf(out, ",%s", what);
    rmap_csv_put_text(row->name, out);
    fprintf(out, ",%.17g", row->rays);
    for (size_t k = 0; k < sizeof number / sizeof *number; k++)
        rmap_csv_put_number(number[k], out);
    fputc('\n', out);
}

static const char *const word[] = {
    [RMAP_ENERGY_OBJECT] = "object",    [RMAP_ENERGY_MEDIUM] = "medium",
    [RMAP_ENERGY_LEFT] = "left",        [RMAP_ENERGY_LIMIT] = "limit",
    [RMAP_ENERGY_ERROR] = "error",      [RMAP_ENERGY_HEAT] = "heat",
    [RMAP_ENERGY_DETECTOR] = "detector"};

void rmap_energy_csv(const struct rmap_energy *energy, FILE *out)
{
    fprintf(out, "# energy of: %s\n# criterion: %s\n# flux: %s\n", energy->map,
            energy->criterion ? energy->criterion : "all", energy->unit);
    rmap_which_csv(energy->which, out);
    fprintf(out, "# exact: %s\n", energy->table[0].exact ? "true" : "false");
    fprintf(out, "source,what,name,rays,flux,standard_error,share,share_standard_error\n");
    for (size_t t = 0; t < energy->n_table; t++) {
        const struct rmap_energy_table *table = &energy->table[t];
        const struct rmap_energy_row emitted = emitted_row(table);
        put_line(table, "emitted", &emitted, out);
        for (size_t i = 0; i < table->n_row + table->n_detector; i++)
            put_line(table, word[table->row[i].end], &table->row[i], out);
    }
}

static json_t *row_json(const struct rmap_energy_row *row)
{
    json_t *object = json_object();
    if (*row->name)
        (void)json_object_set_new(object, "name", json_string(row->name));
    (void)json_object_set_new(object, row->end == RMAP_ENERGY_DETECTOR ? "registrations" : "rays",
                              json_integer((json_int_t)rmap_weight_whole(row->rays)));
    (void)json_object_set_new(object, "flux", rmap_json_number(row->flux));
    (void)json_object_set_new(object, "standard_error", rmap_json_number(row->flux_error));
    (void)json_object_set_new(object, "share", rmap_json_number(row->share));
    (void)json_object_set_new(object, "share_standard_error", rmap_json_number(row->share_error));
    return object;
}

static json_t *table_json(const struct rmap_energy *energy, const struct rmap_energy_table *table)
{
    json_t *list[RMAP_ENERGY_DETECTOR + 1] = {NULL};
    for (int end = 0; end <= RMAP_ENERGY_DETECTOR; end++)
        list[end] = end < RMAP_ENERGY_LEFT || end == RMAP_ENERGY_DETECTOR ? json_array() : NULL;
    for (size_t i = 0; i < table->n_row + table->n_detector; i++) {
        const struct rmap_energy_row *row = &table->row[i];
        if (list[row->end])
            (void)json_array_append_new(list[row->end], row_json(row));
        else
            list[row->end] = row_json(row);
    }
    return json_pack("{s:o, s:I, s:{s:o, s:o, s:s}, s:b, s:{s:o, s:o}, s:o, s:o, s:o, s:o*, s:o}",
                     "source", table->source ? json_string(table->source) : json_null(), "emitted",
                     (json_int_t)rmap_weight_whole(table->rays), "flux", "value",
                     rmap_json_number(table->flux), "standard_error",
                     rmap_json_number(table->flux_error), "unit", energy->unit, "exact",
                     (int)table->exact, "absorbed", "objects", list[RMAP_ENERGY_OBJECT], "media",
                     list[RMAP_ENERGY_MEDIUM], "left", list[RMAP_ENERGY_LEFT], "limit",
                     list[RMAP_ENERGY_LIMIT], "error", list[RMAP_ENERGY_ERROR], "heat",
                     list[RMAP_ENERGY_HEAT], "detectors", list[RMAP_ENERGY_DETECTOR]);
}

json_t *rmap_energy_json(const struct rmap_energy *energy)
{
    json_t *sources = json_array();
    for (size_t i = 1; i < energy->n_table; i++)
        (void)json_array_append_new(sources, table_json(energy, &energy->table[i]));
    return json_pack("{s:s, s:s, s:o, s:{s:I, s:I}, s:{s:o, s:o, s:o, s:s}, s:o, s:o}", "map",
                     energy->map, "criterion", energy->criterion ? energy->criterion : "all",
                     "which", rmap_which_json(energy->which), "rays", "total",
                     (json_int_t)rmap_weight_whole(energy->map_rays), "matched",
                     (json_int_t)rmap_weight_whole(energy->table[0].rays), "flux", "total",
                     rmap_json_number(energy->map_flux), "matched",
                     rmap_json_number(energy->table[0].flux), "standard_error",
                     rmap_json_number(energy->table[0].flux_error), "unit", energy->unit, "total",
                     table_json(energy, &energy->table[0]), "sources", sources);
}
