/* SPDX-License-Identifier: MIT
 *
 * Rays as text: LightTools' export, and CSV.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "base/unit.h"
#include "io/rays/ray_reader.h"

/* Lines as they come. */
struct lines {
    FILE *in;
    char *text; /* of getline */
    size_t cap, number;
    struct rmap_error *err;
};

/* The next line without its end; false at the end of the file. */
static bool next_line(struct lines *lines)
{
    ssize_t n = getline(&lines->text, &lines->cap, lines->in);
    if (n < 0)
        return false;
    while (n > 0 && strchr("\r\n \t", lines->text[n - 1]))
        lines->text[--n] = 0;
    lines->number++;
    return true;
}

static enum rmap_status wrong(const struct lines *lines, const char *what, const char *word)
{
    return rmap_error_set(lines->err, RMAP_INPUT, "line %zu: '%.40s': %s", lines->number, word,
                          what);
}

static enum rmap_status at_end(const struct lines *lines, struct rmap_ray_rows *rows,
                               struct rmap_file_rays **set_ret)
{
    if (ferror(lines->in))
        return rmap_error_set(lines->err, RMAP_SYSTEM, "cannot be read: %s", strerror(errno));
    return rmap_ray_rows_finish(rows, set_ret, lines->err);
}

/* The next number of a line, behind blanks, commas or semicolons. */
static bool next_number(const char **at, double *value)
{
    char *stop = NULL;
    *at += strspn(*at, " \t,;");
    *value = strtod(*at, &stop);
    const bool good = stop != *at && strchr(" \t,;", *stop);
    *at = good ? stop : *at;
    return good;
}

/* ---- LightTools ---- */

struct lighttools {
    struct lines lines;
    struct rmap_ray_rows rows;
    double unit_m, flux;
    enum rmap_flux_unit flux_unit;
};

/* "lt_length_units: millimeters" */
static enum rmap_status read_head(struct lighttools *self, const char *key, const char *value)
{
    static const char *const unit[][2] = {{"millimeters", "mm"}, {"centimeters", "cm"},
                                          {"meters", "m"},       {"inches", "in"},
                                          {"micrometers", "um"}, {"nanometers", "nm"}};
    const struct lines *lines = &self->lines;
    if (strcmp(key, "lt_length_units") == 0) {
        const struct rmap_written_unit *of = NULL;
        for (size_t i = 0; i < sizeof unit / sizeof *unit; i++)
            if (strcmp(value, unit[i][0]) == 0)
                of = rmap_unit_of_scene(unit[i][1], RMAP_DIMENSION_LENGTH);
        self->unit_m = of ? of->size : 0.0;
        return of ? RMAP_OK : wrong(lines, "it is no unit of length that is known", value);
    }
    if (strcmp(key, "lt_datatype") == 0) {
        const bool lumens = strcmp(value, "luminous_flux") == 0;
        self->flux_unit = lumens ? RMAP_FLUX_LM : RMAP_FLUX_W;
        return lumens || strcmp(value, "radiant_flux") == 0
                   ? RMAP_OK
                   : wrong(lines, "lt_datatype is luminous_flux or radiant_flux", value);
    }
    if (strcmp(key, "lt_radiant_flux") == 0 || strcmp(key, "lt_luminous_flux") == 0) {
        self->flux = strtod(value, NULL);
        return self->flux > 0.0 && self->flux < 1e30 ? RMAP_OK
                                                     : wrong(lines, "it is no flux", value);
    }
    if (strcmp(key, "lt_far_field_data") == 0 && strcmp(value, "no") != 0)
        return wrong(lines, "rays that start nowhere are not read", value);
    if (strcmp(key, "lt_color_info") == 0) {
        self->rows.has[RMAP_RAY_NM] = strcmp(value, "wavelength") == 0;
        return self->rows.has[RMAP_RAY_NM] || strcmp(value, "none") == 0
                   ? RMAP_OK
                   : wrong(lines, "lt_color_info is read where it is none or wavelength", value);
    }
    if (strcmp(key, "lt_data_origin") == 0) {
        double x = 0.0;
        for (const char *at = value; next_number(&at, &x);)
            if (x != 0.0)
                return wrong(lines, "rays about another origin than 0 0 0 are not read", value);
    }
    return RMAP_OK;
}

static enum rmap_status read_lighttools(struct lighttools *self, struct rmap_file_rays **set_ret)
{
    enum rmap_status st = RMAP_OK;
    bool data = false, ended = false;
    double value[RMAP_RAY_COLUMNS] = {0};
    struct lines *lines = &self->lines;
    self->rows.has[RMAP_RAY_POWER] = true;
    while (!ended && next_line(lines)) {
        const char *at = lines->text + strspn(lines->text, " \t");
        char *colon = strchr(lines->text, ':');
        ended = data && strcmp(at, "lt_endofdata") == 0;
        if (*at == 0 || *at == '#' || ended)
            continue;
        if (!data) {
            data = strcmp(at, "lt_startofdata") == 0;
            if (!data && colon) {
                *colon = 0;
                RMAP_TRY(read_head(self, at, colon + 1 + strspn(colon + 1, " \t")));
            } else if (!data) {
                RMAP_TRY(wrong(lines,
                               "a line of the head is 'lt_...: value', and the last one "
                               "lt_startofdata",
                               at));
            }
            continue;
        }
        const int n = self->rows.has[RMAP_RAY_NM] ? 8 : 7;
        for (int k = 0; k < n; k++)
            if (!next_number(&at, &value[k]))
                RMAP_TRY(wrong(lines, "a ray has x y z, its direction L M N and its flux", at));
        RMAP_TRY(rmap_ray_rows_add(&self->rows, value, lines->err));
    }
    if (!data)
        RMAP_TRY(rmap_error_set(lines->err, RMAP_INPUT, "it ends before lt_startofdata"));
    RMAP_TRY(at_end(lines, &self->rows, set_ret));
    (*set_ret)->unit_m = self->unit_m;
    (*set_ret)->flux = self->flux;
    (*set_ret)->flux_unit = self->flux_unit;
    (*set_ret)->loose = RMAP_FILE_RAYS_LOOSE;
out:
    return st;
}

enum rmap_status rmap_lighttools_read(FILE *in, struct rmap_file_rays **set_ret,
                                      struct rmap_error *err)
{
    struct lighttools self = {.lines = {.in = in, .err = err}, .unit_m = 1e-3, .flux = (double)NAN};
    const enum rmap_status st = read_lighttools(&self, set_ret);
    free(self.lines.text);
    rmap_file_rays_drop(self.rows.set);
    return st;
}

/* ---- CSV ---- */

enum { CSV_COLUMNS_MAX = 32 };

struct csv {
    struct lines lines;
    struct rmap_ray_rows rows;
    bool steps;
    struct rmap_ray_meaning column[CSV_COLUMNS_MAX];
    size_t n_column;
    double unit_m;
    bool flux_said;
    enum rmap_flux_unit flux_unit;
};

/* Of positions all, or none, say their unit, and the same. */
static enum rmap_status add_column(struct csv *self, const char *name)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_meaning meaning;
    const struct lines *lines = &self->lines;
    if (self->n_column == CSV_COLUMNS_MAX)
        return wrong(lines, "a file of rays has 32 columns at most", name);
    st = rmap_ray_meaning_of(name, NULL, self->steps, &meaning, lines->err);
    if (st != RMAP_OK) {
        rmap_error_context(lines->err, "line %zu", lines->number);
        return st;
    }
    for (size_t k = 0; k < self->n_column; k++)
        if (self->column[k].column == meaning.column)
            return wrong(lines, "there are two columns of it", name);
    if (meaning.column <= RMAP_RAY_Z) {
        if (meaning.column != RMAP_RAY_X && meaning.factor != self->unit_m)
            return wrong(lines, "x, y and z have one unit, and x comes first", name);
        self->unit_m = meaning.factor;
        meaning.factor = 1.0;
    }
    if (meaning.column == RMAP_RAY_LENGTH && meaning.factor != self->unit_m)
        return wrong(lines, "it has the unit of x, y and z, which come first", name);
    if (meaning.column == RMAP_RAY_LENGTH)
        meaning.factor = 1.0;
    if (meaning.column == RMAP_RAY_POWER) {
        self->flux_said = meaning.said;
        self->flux_unit = meaning.flux_unit;
    }
    self->rows.has[meaning.column] = true;
    self->column[self->n_column++] = meaning;
    return RMAP_OK;
}

static enum rmap_status read_names(struct csv *self)
{
    static const struct {
        enum rmap_ray_column column;
        const char *name;
    } needed[] = {{RMAP_RAY_X, "x"},           {RMAP_RAY_Y, "y"},           {RMAP_RAY_Z, "z"},
                  {RMAP_RAY_DX, "dx"},         {RMAP_RAY_DY, "dy"},         {RMAP_RAY_DZ, "dz"},
                  {RMAP_RAY_LENGTH, "length"}, {RMAP_RAY_DEPOSIT, "energy"}};
    enum rmap_status st = RMAP_OK;
    struct lines *lines = &self->lines;
    bool found = false;
    while (!found && next_line(lines))
        found = *lines->text && *lines->text != '#';
    if (!found)
        return rmap_error_set(lines->err, RMAP_INPUT, "it has no line of names of columns");
    char *save = NULL;
    for (char *name = strtok_r(lines->text, ",;", &save); name;
         name = strtok_r(NULL, ",;", &save)) {
        name += strspn(name, " \t\"");
        name[strcspn(name, "\"")] = 0;
        RMAP_TRY(add_column(self, name));
    }
    for (size_t k = 0; k < (self->steps ? RMAP_COUNT(needed) : 6); k++)
        if (!self->rows.has[needed[k].column])
            RMAP_TRY(rmap_error_set(lines->err, RMAP_INPUT,
                                    "line %zu: it has no column %s: %s need x, y, z, dx, dy, dz%s",
                                    lines->number, needed[k].name, self->steps ? "steps" : "rays",
                                    self->steps ? ", length, energy" : ""));
out:
    return st;
}

static enum rmap_status read_csv(struct csv *self, struct rmap_file_rays **set_ret)
{
    enum rmap_status st = RMAP_OK;
    struct lines *lines = &self->lines;
    double value[RMAP_RAY_COLUMNS] = {[RMAP_RAY_CHARGE] = 1.0, [RMAP_RAY_BETA] = 1.0};
    RMAP_TRY(read_names(self));
    while (next_line(lines)) {
        const char *at = lines->text;
        if (*at == 0 || *at == '#')
            continue;
        for (size_t k = 0; k < self->n_column; k++) {
            const struct rmap_ray_meaning *is = &self->column[k];
            double number;
            if (!next_number(&at, &number))
                RMAP_TRY(wrong(lines, "it is no number, or one is missing", at));
            value[is->column] = is->inverse ? is->factor / number : number * is->factor;
        }
        if (at[strspn(at, " \t,;")] != 0)
            RMAP_TRY(wrong(lines, "there are more numbers than columns", at));
        if (!rmap_ray_event_good(value[RMAP_RAY_EVENT]))
            RMAP_TRY(wrong(lines, "an event is a whole number from 0", lines->text));
        RMAP_TRY(rmap_ray_rows_add(&self->rows, value, lines->err));
    }
    RMAP_TRY(at_end(lines, &self->rows, set_ret));
    (*set_ret)->unit_m = self->unit_m;
    (*set_ret)->flux_unit = self->flux_unit;
    if (!self->flux_said)
        (*set_ret)->flux = (double)NAN;
    (*set_ret)->loose = RMAP_FILE_RAYS_LOOSE;
out:
    return st;
}

enum rmap_status rmap_ray_csv_read(FILE *in, bool steps, struct rmap_file_rays **set_ret,
                                   struct rmap_error *err)
{
    struct csv self = {.steps = steps, .lines = {.in = in, .err = err}};
    const enum rmap_status st = read_csv(&self, set_ret);
    free(self.lines.text);
    rmap_file_rays_drop(self.rows.set);
    return st;
}
