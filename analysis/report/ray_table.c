/* SPDX-License-Identifier: MIT
 *
 * Tables of rays, segments and registrations, a row for each, in plain columns of numbers.
 */
#include "analysis/report/ray_table.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/ray_number.h"
#include "analysis/report/ray_report.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"

/* A row of a table as a quantity is read from it. */
struct at {
    const struct rmap_map *map;
    const struct rmap_scene *scene; /* in the ray's colour space */
    const struct rmap_table_ray *ray;
    const struct rmap_ray_report *report;
    const struct rmap_table_quantity *quantity;
    size_t k; /* among the ray's rows */
};

struct rmap_table_quantity {
    enum rmap_table table;
    const char *name;
    const char *unit; /* NULL: the scene's length; "flux": its unit of flux */
    const char *description;
    double (*read)(const struct at *at);
    rmap_column_set columns; /* beside those of the number; REPORTED: it needs the ray's report */
    enum rmap_registration_number number; /* of registration_number */
};

static double flux(const struct at *at)
{
    const struct rmap_ray_columns *ray = &at->ray->portion->ray;
    return ray->weight[at->ray->row] * rmap_map_flux_per_weight(at->map)[ray->source[at->ray->row]];
}

static double event(const struct at *at)
{
    return rmap_ray_number_at(RMAP_RAY_NUMBER_EVENT, at->scene, &at->ray->portion->ray,
                              at->ray->row, NULL);
}

/* At the end of segment `row`; NaN where more than one channel is left, and where channels are red,
 * green and blue. */
static double wavelength_at(const struct at *at, size_t row)
{
    const struct rmap_portion *portion = at->ray->portion;
    const uint16_t *share = portion->colour + row * (size_t)portion->n_channel;
    int n = 0, last = 0;
    for (int c = 0; c < portion->n_channel; c++)
        if (share[c] > 0) {
            n++;
            last = c;
        }
    return n == 1 && at->scene->channels.mode != RMAP_COLOUR_RGB
               ? at->scene->channels.wavelength_nm[last]
               : (double)NAN;
}

static double segment_wavelength(const struct at *at)
{
    return wavelength_at(at, at->ray->segment + at->k);
}

/* Row of the segment on which registration k of a ray happened. */
static size_t segment_of(const struct rmap_table_ray *ray, size_t k)
{
    return ray->segment + ray->portion->registration.segment[ray->registration + k];
}

static double registration_wavelength(const struct at *at)
{
    return wavelength_at(at, segment_of(at->ray, at->k));
}

static double length(const struct at *at)
{
    return at->report->step[at->k].length;
}

static double incidence(const struct at *at)
{
    return at->report->step[at->k].incidence_deg;
}

static double reflectance(const struct at *at)
{
    return at->report->step[at->k].reflectance;
}

static double registration_number(const struct at *at)
{
    return rmap_registration_number(at->scene, at->ray->portion, at->ray->registration + at->k,
                                    rmap_time_in(at->scene, at->quantity->number));
}

/* What rows are found by. */
static const rmap_column_set counted[RMAP_TABLE_COUNT] = {
    [RMAP_TABLE_SEGMENT] = RMAP_COLUMN_BIT(RMAP_RAY_segment_count),
    [RMAP_TABLE_REGISTRATION] = RMAP_COLUMN_BIT(RMAP_RAY_registration_count)};
static const rmap_column_set of_segment =
    RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count);

#define FLUX         "flux of the ray"
#define EVENT        "number of the event that the ray is of; NaN: of none"
#define WAVELENGTH   "vacuum wavelength there; NaN where more than one is left"
#define FLUX_COLUMNS RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight)
#define COLOUR       RMAP_COLUMN_BIT(RMAP_SEGMENT_colour)
#define NUMBER       RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector)
#define REPORTED     RMAP_COLUMNS_ALL
static const struct rmap_table_quantity quantity_table[] = {
    {RMAP_TABLE_RAY, "flux", "flux", FLUX, flux, FLUX_COLUMNS},
    {RMAP_TABLE_RAY, "event", "1", EVENT, event, RMAP_COLUMN_BIT(RMAP_RAY_id)},
    {RMAP_TABLE_SEGMENT, "flux", "flux", FLUX, flux, FLUX_COLUMNS},
    {RMAP_TABLE_SEGMENT, "wavelength", "nm", WAVELENGTH, segment_wavelength, COLOUR},
    {RMAP_TABLE_SEGMENT, "length", NULL, "0 where the ray leaves the scene", length, REPORTED},
    {RMAP_TABLE_SEGMENT, "angle_of_incidence", "deg", "NaN where nothing is met", incidence,
     REPORTED},
    {RMAP_TABLE_SEGMENT, "reflectance", "1",
     "specular, of the light that arrives; NaN of surfaces without", reflectance, REPORTED},
    {RMAP_TABLE_REGISTRATION, "event", "1", EVENT, event, RMAP_COLUMN_BIT(RMAP_RAY_id)},
    {RMAP_TABLE_REGISTRATION, "flux", "flux", FLUX, flux, FLUX_COLUMNS},
    {RMAP_TABLE_REGISTRATION, "wavelength", "nm", WAVELENGTH, registration_wavelength, COLOUR},
    {RMAP_TABLE_REGISTRATION, "x", NULL, "on the detector; of an intensity detector theta in deg",
     registration_number, NUMBER, RMAP_REGISTRATION_X},
    {RMAP_TABLE_REGISTRATION, "y", NULL, "on the detector; of an intensity detector phi in deg",
     registration_number, NUMBER, RMAP_REGISTRATION_Y},
    {RMAP_TABLE_REGISTRATION, "world_x", NULL, "NaN of an intensity detector", registration_number,
     NUMBER, RMAP_REGISTRATION_WORLD_X},
    {RMAP_TABLE_REGISTRATION, "world_y", NULL, "NaN of an intensity detector", registration_number,
     NUMBER, RMAP_REGISTRATION_WORLD_Y},
    {RMAP_TABLE_REGISTRATION, "world_z", NULL, "NaN of an intensity detector", registration_number,
     NUMBER, RMAP_REGISTRATION_WORLD_Z},
    {RMAP_TABLE_REGISTRATION, "angle", "deg",
     "between the detector's axis and where the light comes from (intensity: goes to)",
     registration_number, NUMBER, RMAP_REGISTRATION_ANGLE},
    {RMAP_TABLE_REGISTRATION, "time", "s", "since emission", registration_number, NUMBER,
     RMAP_REGISTRATION_TIME},
};
enum { QUANTITIES = sizeof quantity_table / sizeof *quantity_table };

/* Columns of /ray that the rows of the other tables have as well. */
static const struct {
    enum rmap_column column;
    const char *name;
} of_ray_table[] = {{RMAP_RAY_id, "ray_id"}, {RMAP_RAY_source, "source"}};

static const char *const table_word[] = {"ray", "segment", "registration", "curve"};

/* All columns that there are; none of colours where spaces differ in channels. */
struct catalogue {
    const struct rmap_map *map;
    enum rmap_vectors vectors;
    int n_table;
    struct rmap_table_column *column;
    size_t n, cap;
};

static enum rmap_status add(struct catalogue *all, const struct rmap_table_column *given,
                            const char *name, const char *suffix, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(all->column, all->cap, all->n + 1, err);
    if (st != RMAP_OK)
        return st;
    all->column[all->n] = *given;
    (void)snprintf(all->column[all->n].name, sizeof given->name, "%s%s", name, suffix);
    all->n++;
    return RMAP_OK;
}

/* 0: it differs from space to space. */
static int width_of(const struct catalogue *all, const struct rmap_column_info *info)
{
    if (info->width > 0)
        return info->width;
    const int n = rmap_map_scene(all->map)->channels.n;
    for (size_t s = 1; s < rmap_map_n_space(all->map); s++)
        if (rmap_map_scene_of(all->map, s)->channels.n != n)
            return 0;
    return n;
}

static enum rmap_status add_stored(struct catalogue *all, enum rmap_table table,
                                   enum rmap_column column, struct rmap_error *err)
{
    static const char *const axis[] = {"_x", "_y", "_z", "_i", "_j"};
    enum rmap_status st = RMAP_OK;
    const struct rmap_column_info *info = rmap_column_info(column);
    const int width = width_of(all, info);
    struct rmap_table_column stored = {.table = table,
                                       .element = info->element,
                                       .width = width,
                                       .unit = info->unit == RMAP_UNIT_LENGTH
                                                   ? rmap_map_scene(all->map)->unit
                                               : info->unit == RMAP_UNIT_NM ? "nm"
                                               : info->unit == RMAP_UNIT_NS ? "ns"
                                                                            : "1",
                                       .description = info->description,
                                       .column = column};
    if (all->vectors == RMAP_VECTORS_WHOLE || info->width == 1)
        return add(all, &stored, info->field, "", err);
    stored.width = 1;
    for (; stored.part < width; stored.part++) {
        char number[16];
        (void)snprintf(number, sizeof number, "_%d", stored.part);
        RMAP_TRY(add(all, &stored, info->field,
                     info->width == 0 ? number : axis[stored.part + (info->width == 2 ? 3 : 0)],
                     err));
    }
out:
    return st;
}

static enum rmap_status add_table(struct catalogue *all, enum rmap_table table,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(all->map);
    for (size_t i = 0; counted[table] && i < sizeof of_ray_table / sizeof *of_ray_table; i++) {
        const struct rmap_column_info *info = rmap_column_info(of_ray_table[i].column);
        const struct rmap_table_column given = {.table = table,
                                                .element = info->element,
                                                .width = 1,
                                                .unit = "1",
                                                .description = info->description,
                                                .column = of_ray_table[i].column};
        RMAP_TRY(add(all, &given, of_ray_table[i].name, "", err));
    }
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (rmap_column_info((enum rmap_column)c)->table == table &&
            (rmap_columns_of_run(scene->timed) & RMAP_COLUMN_BIT(c)))
            RMAP_TRY(add_stored(all, table, (enum rmap_column)c, err));
    if (table == RMAP_TABLE_REGISTRATION)
        RMAP_TRY(add_stored(all, table, RMAP_SEGMENT_colour, err));
    for (size_t i = 0; i < QUANTITIES; i++) {
        const struct rmap_table_quantity *quantity = &quantity_table[i];
        const struct rmap_table_column given = {.table = table,
                                                .element = RMAP_F64,
                                                .width = 1,
                                                .unit = !quantity->unit ? scene->unit
                                                        : strcmp(quantity->unit, "flux") == 0
                                                            ? rmap_flux_unit_name(scene)
                                                            : quantity->unit,
                                                .description = quantity->description,
                                                .column = RMAP_COLUMN_COUNT,
                                                .quantity = quantity};
        if (quantity->table == table &&
            (quantity->read != event || !rmap_scene_events_trouble(scene)))
            RMAP_TRY(add(all, &given, quantity->name, "", err));
    }
out:
    return st;
}

/* "registration/x" of a column; true where a word of n characters is that, or its table alone. */
static bool is_named(const struct rmap_table_column *column, const char *word, size_t n)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%s/%s", table_word[column->table], column->name);
    const char *table = table_word[column->table];
    return (n == strlen(name) && memcmp(word, name, n) == 0) ||
           (n == strlen(table) && memcmp(word, table, n) == 0);
}

static enum rmap_status unknown(const struct catalogue *all, const char *word, size_t n,
                                struct rmap_error *err)
{
    const size_t n_table = (size_t)all->n_table;
    char(*name)[64] = rmap_alloc(all->n + n_table, sizeof *name);
    const char **candidate = rmap_alloc(all->n + n_table, sizeof *candidate);
    char given[64];
    const char *near = NULL;
    (void)snprintf(given, sizeof given, "%.*s", (int)(n < 60 ? n : 60), word);
    /* Of a table that there is, the column's own name is looked for. */
    const size_t slash = strcspn(given, "/");
    size_t skip = 0, n_candidate = 0;
    for (size_t t = 0; given[slash] && t < n_table; t++)
        if (strlen(table_word[t]) == slash && memcmp(given, table_word[t], slash) == 0)
            skip = slash + 1;
    for (size_t i = 0; name && candidate && i < all->n + n_table; i++) {
        if (i < n_table)
            (void)snprintf(name[i], sizeof name[i], "%s", table_word[i]);
        else
            (void)snprintf(name[i], sizeof name[i], "%s/%s",
                           table_word[all->column[i - n_table].table],
                           all->column[i - n_table].name);
        if (strncmp(name[i], given, skip) == 0)
            candidate[n_candidate++] = name[i] + skip;
    }
    if (n_candidate > 0)
        near = rmap_nearest_word(given + skip, candidate, n_candidate);
    near = near ? near - skip : NULL;
    enum rmap_status st =
        rmap_error_set(err, RMAP_INPUT,
                       "no column '%s'%s%s%s: there are ray, segment and registration, and columns "
                       "of them as "
                       "in registration/x,registration/time; docs/python.md lists them",
                       given, near ? " (did you mean '" : "", near ? near : "", near ? "'?)" : "");
    rmap_free(name);
    rmap_free(candidate);
    return st;
}

/* Marks what a list names; words are parted by commas and blanks. */
static enum rmap_status choose(const struct catalogue *all, const char *names, bool *wanted,
                               struct rmap_error *err)
{
    bool is_due = true; /* behind a comma, and at first */
    for (const char *at = names; *at;) {
        const size_t n = strcspn(at, ", \t\n");
        is_due = is_due && n == 0;
        if (at[n] == ',' && is_due)
            break;
        is_due = is_due || at[n] == ',';
        bool found = n == 0;
        for (size_t i = 0; n > 0 && i < all->n; i++)
            if (is_named(&all->column[i], at, n))
                found = wanted[i] = true;
        if (!found)
            return unknown(all, at, n, err);
        at += n + (at[n] != '\0');
    }
    return is_due ? rmap_error_set(err, RMAP_INPUT,
                                   "a place in the list of columns names no column: '%.80s'", names)
                  : RMAP_OK;
}

static rmap_column_set columns_of(const struct rmap_scene *scene,
                                  const struct rmap_table_column *column)
{
    const struct rmap_table_quantity *quantity = column->quantity;
    rmap_column_set columns = counted[column->table];
    if (!quantity)
        columns |= RMAP_COLUMN_BIT(column->column);
    else
        columns |= quantity->columns;
    if (quantity && quantity->read == registration_number)
        columns |= rmap_registration_number_columns(rmap_time_in(scene, quantity->number));
    if (column->table == RMAP_TABLE_REGISTRATION && columns & COLOUR)
        columns |= of_segment;
    return columns;
}

enum rmap_status rmap_ray_table_create(const struct rmap_map *map, const char *names,
                                       enum rmap_vectors vectors, struct rmap_ray_table **table_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool has_curves =
        vectors == RMAP_VECTORS_WHOLE && rmap_scene_is_curved(rmap_map_scene(map));
    struct catalogue all = {.map = map,
                            .vectors = vectors,
                            .n_table = has_curves ? RMAP_TABLE_COUNT : RMAP_TABLE_HISTORY_COUNT};
    struct rmap_ray_table *self = rmap_alloc(1, sizeof *self);
    bool *wanted = NULL;
    for (int t = 0; t < all.n_table; t++)
        RMAP_TRY(add_table(&all, (enum rmap_table)t, err));
    wanted = rmap_alloc(all.n + 1, sizeof *wanted);
    if (!self || !wanted)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the columns of a table"));
    memset(wanted, !names, all.n);
    if (names)
        RMAP_TRY(choose(&all, names, wanted, err));
    self->map = map;
    for (size_t i = 0; i < all.n; i++)
        if (wanted[i]) {
            self->columns |= columns_of(rmap_map_scene(map), &all.column[i]);
            all.column[self->n++] = all.column[i];
        }
    self->is_reported = self->columns == REPORTED;
    self->column = all.column;
    all.column = NULL;
    *table_ret = self;
    self = NULL;
out:
    rmap_free(all.column);
    rmap_free(wanted);
    rmap_ray_table_destroy(self);
    return st;
}

void rmap_ray_table_destroy(struct rmap_ray_table *self)
{
    if (!self)
        return;
    rmap_free(self->column);
    rmap_free(self);
}

const char *rmap_ray_table_word(enum rmap_table table)
{
    return table_word[table];
}

size_t rmap_ray_table_rows(const struct rmap_table_ray *ray, enum rmap_table table)
{
    return table == RMAP_TABLE_SEGMENT        ? ray->portion->ray.segment_count[ray->row]
           : table == RMAP_TABLE_REGISTRATION ? ray->portion->ray.registration_count[ray->row]
                                              : 1;
}

void rmap_ray_table_read(const struct rmap_ray_table *self, const struct rmap_table_column *column,
                         const struct rmap_table_ray *ray, const struct rmap_ray_report *report,
                         size_t k, void *out)
{
    if (column->quantity) {
        const struct at at = {
            self->map, rmap_map_scene_of(self->map, ray->space), ray, report, column->quantity, k};
        const double value = column->quantity->read(&at);
        memcpy(out, &value, sizeof value);
        return;
    }
    const struct rmap_column_info *info = rmap_column_info(column->column);
    size_t row = ray->row;
    if (column->table == RMAP_TABLE_SEGMENT && info->table == RMAP_TABLE_SEGMENT)
        row = ray->segment + k;
    else if (info->table == RMAP_TABLE_SEGMENT)
        row = segment_of(ray, k);
    else if (info->table == RMAP_TABLE_REGISTRATION)
        row = ray->registration + k;
    const size_t width = info->width ? (size_t)info->width : (size_t)ray->portion->n_channel,
                 nbytes = rmap_element_nbytes(info->element);
    const char *from = rmap_portion_column(ray->portion, column->column);
    memcpy(out, from + (row * width + (size_t)column->part) * nbytes,
           nbytes * (column->width > 0 ? (size_t)column->width : width));
}
