/* SPDX-License-Identifier: MIT
 *
 * Quantities over wavelength: tables, reflectances, the spectra of sources.
 */
#include "io/scene/scene_quantity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_glass.h"
#include "io/scene/scene_keys.h"
#include "optics/illuminant.h"

static void read_column(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *key, const struct rmap_range *range, size_t *n_ret,
                        double **column_ret)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, key);
    char what[80];
    (void)snprintf(what, sizeof what, "'%s'", key);
    *n_ret = 0;
    if (!rmap_reader_check_list(reader, list, what))
        return;
    double *column = rmap_reader_alloc(reader, list->n_item, sizeof *column);
    if (!column)
        return;
    bool good = true;
    for (size_t i = 0; i < list->n_item; i++)
        good &= rmap_reader_scalar(reader, list->item[i].value, what, range, &column[i]);
    if (!list->n_item)
        rmap_reader_error(reader, list, "%s must not be empty", what);
    if (good && list->n_item) {
        *n_ret = list->n_item;
        *column_ret = column;
    }
}

static bool is_increasing(struct rmap_reader *reader, const struct rmap_yaml_node *list,
                          const char *word, const double *value, size_t n)
{
    for (size_t i = 1; i < n; i++) {
        if (value[i] > value[i - 1])
            continue;
        const bool energy = strcmp(word, "energy") == 0;
        rmap_reader_error(reader, list->item[i].value, "%s%s must increase, but %g follows %g",
                          energy ? "energies" : word, energy ? "" : "s", value[i], value[i - 1]);
        return false;
    }
    return true;
}

/* Of a table over wavelength or angle. */
static const struct rmap_range *first_range(const char *key)
{
    return strcmp(key, "angle") == 0    ? &rmap_range_polar
           : strcmp(key, "energy") == 0 ? &rmap_range_photon_energy
                                        : &rmap_range_wavelength;
}

void rmap_reader_axis(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *key, size_t *n_ret, double **column)
{
    size_t n = 0;
    *n_ret = 0;
    read_column(reader, node, key, first_range(key), &n, column);
    if (n > 0 && is_increasing(reader, rmap_yaml_get(node, key), key, *column, n))
        *n_ret = n;
}

/* Rows over photon energy in eV become rows over wavelength in nm. */
static void turn_energies(double **column, size_t n_column, size_t n)
{
    for (size_t k = 0; k < n_column; k++)
        for (size_t i = 0; column[k] && i < n / 2; i++) {
            const double last = column[k][n - 1 - i];
            column[k][n - 1 - i] = column[k][i];
            column[k][i] = last;
        }
    for (size_t i = 0; i < n; i++)
        column[0][i] = RMAP_HC_EV / column[0][i];
}

void rmap_reader_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *keys, size_t n_required, const struct rmap_range *range,
                       size_t *n_ret, double **column)
{
    struct rmap_words key;
    bool good = true;
    *n_ret = 0;
    rmap_words_split(keys, &key);
    const bool of_energy = strcmp(key.word[0], "wavelength") == 0 && rmap_yaml_get(node, "energy");
    if (of_energy)
        key.word[0] = "energy";
    for (size_t k = 0; k < key.n; k++)
        column[k] = NULL;
    if (!rmap_reader_check_keys(reader, node, "a table", key.word, key.n))
        return;
    const struct rmap_range *first = first_range(key.word[0]);
    size_t n_row = 0;
    for (size_t k = 0; k < key.n; k++) {
        const struct rmap_yaml_node *list = rmap_yaml_get(node, key.word[k]);
        size_t n = 0;
        if (!list && k >= n_required)
            continue;
        if (!list) {
            rmap_reader_error(reader, node, "'%s' is missing: add it", key.word[k]);
            good = false;
            continue;
        }
        read_column(reader, node, key.word[k], k ? range : first, &n, &column[k]);
        good &= n > 0;
        if (k == 0)
            n_row = n;
        else if (n && n_row && n != n_row) {
            rmap_reader_error(reader, list, "'%s' has %zu entries, '%s' has %zu", key.word[k], n,
                              key.word[0], n_row);
            good = false;
        }
    }
    good = good &&
           is_increasing(reader, rmap_yaml_get(node, key.word[0]), key.word[0], column[0], n_row);
    if (good && of_energy)
        turn_energies(column, key.n, n_row);
    if (good)
        *n_ret = n_row;
}

static bool read_rgb(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_range *range, struct rmap_spectrum *spectrum)
{
    size_t n = 0;
    spectrum->kind = RMAP_SPECTRUM_RGB;
    return rmap_reader_numbers(reader, node, "rgb", RMAP_REQUIRED, range, 3, 3, spectrum->rgb, &n);
}

/* {wavelength: [...], value: [...]}. density: per nm; over photon energy it is per eV, with
 * dE = h c / wavelength^2 dwavelength. */
static void read_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_range *range, bool density, struct rmap_spectrum *spectrum,
                       bool *good)
{
    double *column[2];
    rmap_reader_table(reader, node, "wavelength value", 2, range, &spectrum->table.n, column);
    *good = spectrum->table.n > 0;
    for (size_t i = 0; density && rmap_yaml_get(node, "energy") && i < spectrum->table.n; i++)
        column[1][i] *= RMAP_HC_EV / (column[0][i] * column[0][i]);
    if (*good) {
        spectrum->kind = RMAP_SPECTRUM_TABLE;
        spectrum->table.wavelength_nm = column[0];
        spectrum->table.value = column[1];
    }
}

void rmap_reader_quantity(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                          const char *key, enum rmap_need need, const struct rmap_range *range,
                          double *value)
{
    struct rmap_spectrum spectrum = {.kind = RMAP_SPECTRUM_EQUAL};
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    bool good = true;
    if (!node || node->kind == RMAP_YAML_SCALAR) {
        good = rmap_reader_number(reader, map, key, need, range, &spectrum.value) && node;
    } else if (rmap_yaml_get(node, "rgb")) {
        (void)rmap_reader_check_map(reader, node, "an rgb value", "rgb");
        good = read_rgb(reader, node, range, &spectrum);
    } else if (rmap_yaml_get(node, "wavelength") || rmap_yaml_get(node, "value")) {
        read_table(reader, node, range, false, &spectrum, &good);
        if (spectrum.table.n > 1) /* one alone is a constant */
            rmap_reader_warn_outside(reader, node, "table of", key, spectrum.table.wavelength_nm[0],
                                     spectrum.table.wavelength_nm[spectrum.table.n - 1],
                                     "its ends stand for the rest");
    } else {
        char what[120];
        (void)snprintf(what, sizeof what, "'%s' (a number, {wavelength, value} or {rgb})", key);
        if (rmap_reader_check_map(reader, node, what, "rgb wavelength value") && !node->n_item)
            rmap_reader_error(reader, node, "%s is empty", what);
        good = false;
    }
    if (good)
        rmap_spectrum_sample(&spectrum, &reader->scene->channels, value);
}

static void read_lines(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_spectrum *spectrum)
{
    if (node->kind != RMAP_YAML_MAP || !node->n_item) {
        rmap_reader_error(reader, node, "'lines' must be a mapping {wavelength: power, ...}");
        return;
    }
    double *nm = rmap_reader_alloc(reader, node->n_item, sizeof *nm);
    double *power = rmap_reader_alloc(reader, node->n_item, sizeof *power);
    if (!nm || !power)
        return;
    size_t n = 0;
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
        if (!rmap_reader_parse_wavelength(item->key, &nm[n])) {
            rmap_reader_error(reader, &place, "a wavelength in nm must stand here, not '%.40s'",
                              item->key);
            continue;
        }
        if (!rmap_reader_scalar(reader, item->value, "the power of a line", &rmap_range_nonnegative,
                                &power[n]))
            continue;
        if (reader->scene->channels.mode == RMAP_COLOUR_SPECTRAL &&
            rmap_reader_channel(reader, &place, nm[n]) < 0)
            continue;
        n++;
    }
    if (n) {
        spectrum->kind = RMAP_SPECTRUM_LINES;
        spectrum->table = (struct rmap_table1){n, nm, power};
    }
}

/* Room for a table: of rgb scenes every 5 nm, 0 beyond; else what each channel's band has. */
static double *new_table(struct rmap_reader *reader, struct rmap_spectrum *spectrum)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    const bool spectral = channels->mode == RMAP_COLOUR_SPECTRAL;
    const size_t n = spectral ? (size_t)channels->n : RMAP_ILLUMINANT_N + 2;
    double *nm = rmap_reader_alloc(reader, n, sizeof *nm);
    double *value = rmap_reader_alloc(reader, n, sizeof *value);
    if (!nm || !value)
        return NULL;
    for (size_t i = 0; i < n; i++)
        nm[i] = spectral ? channels->wavelength_nm[i]
                         : RMAP_ILLUMINANT_FROM_NM + RMAP_ILLUMINANT_STEP_NM * ((double)i - 1.0);
    spectrum->kind = RMAP_SPECTRUM_TABLE;
    spectrum->table = (struct rmap_table1){n, nm, value};
    return spectral ? value : value + 1;
}

static void set_illuminant(struct rmap_reader *reader, const double power[RMAP_ILLUMINANT_N],
                           struct rmap_spectrum *spectrum)
{
    double *value = new_table(reader, spectrum);
    if (value && reader->scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        rmap_illuminant_means(power, &reader->scene->channels, value);
    else if (value)
        memcpy(value, power, RMAP_ILLUMINANT_N * sizeof *value);
}

static void read_named(struct rmap_reader *reader, const struct rmap_yaml_node *source,
                       const char *key, struct rmap_spectrum *spectrum)
{
    enum { EQUAL, D65, FIRST };
    double power[RMAP_ILLUMINANT_N];
    int choice = EQUAL;
    (void)rmap_reader_choice(reader, source, key, RMAP_OPTIONAL, "equal D65 A D50 D55 D75 F2 F11",
                             &choice);
    if (choice < FIRST) {
        spectrum->kind = choice == D65 ? RMAP_SPECTRUM_D65 : RMAP_SPECTRUM_EQUAL;
        return;
    }
    rmap_illuminant_named((enum rmap_illuminant)(choice - FIRST), power);
    set_illuminant(reader, power, spectrum);
}

static void read_daylight(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_spectrum *spectrum)
{
    static const struct rmap_range range = {
        4000, 25000, "a colour temperature from 4000 to 25000 K", RMAP_DIMENSION_TEMPERATURE};
    double power[RMAP_ILLUMINANT_N], kelvin;
    if (!rmap_reader_number(reader, node, "daylight", RMAP_REQUIRED, &range, &kelvin))
        return;
    rmap_illuminant_daylight(kelvin, power);
    set_illuminant(reader, power, spectrum);
}

static void read_led(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_spectrum *spectrum)
{
    double peak, width, *value;
    if (!rmap_reader_check_map(reader, node, "an LED", "peak width") ||
        !rmap_reader_number(reader, node, "peak", RMAP_REQUIRED, &rmap_range_wavelength, &peak) ||
        !rmap_reader_number(reader, node, "width", RMAP_REQUIRED, &rmap_range_wavelength, &width))
        return;
    value = new_table(reader, spectrum);
    if (value && reader->scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        rmap_led_means(peak, width, &reader->scene->channels, value);
    else if (value)
        rmap_led_steps(peak, width, value);
}

void rmap_reader_spectrum(struct rmap_reader *reader, const struct rmap_yaml_node *source,
                          const char *key, struct rmap_spectrum *spectrum)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(source, key);
    bool good = true;
    *spectrum = (struct rmap_spectrum){.kind = RMAP_SPECTRUM_EQUAL, .value = 1};
    if (!node)
        return;
    if (node->kind == RMAP_YAML_SCALAR) {
        read_named(reader, source, key, spectrum);
        return;
    }
    if (!rmap_reader_check_map(reader, node, "a spectrum",
                               "lines table blackbody daylight led rgb wavelength energy value"))
        return;
    const struct rmap_yaml_node *lines = rmap_yaml_get(node, "lines");
    const struct rmap_yaml_node *table = rmap_yaml_get(node, "table");
    bool plain = rmap_yaml_get(node, "wavelength") || rmap_yaml_get(node, "value");
    bool blackbody = rmap_yaml_get(node, "blackbody") != NULL;
    bool rgb = rmap_yaml_get(node, "rgb") != NULL;
    bool daylight = rmap_yaml_get(node, "daylight") != NULL;
    const struct rmap_yaml_node *led = rmap_yaml_get(node, "led");
    if (!!lines + !!table + plain + blackbody + rgb + daylight + !!led != 1)
        rmap_reader_error(reader, node,
                          "a spectrum is one of: equal, A, D50, D55, D65, D75, F2, F11, {lines: "
                          "{nm: power}}, {table: "
                          "{wavelength, value}}, {blackbody: kelvin}, {daylight: kelvin}, {led: "
                          "{peak, width}}, {rgb: [r, g, b]}");
    else if (daylight)
        read_daylight(reader, node, spectrum);
    else if (led)
        read_led(reader, led, spectrum);
    else if (lines)
        read_lines(reader, lines, spectrum);
    else if (table || plain)
        read_table(reader, table ? table : node, &rmap_range_nonnegative, true, spectrum, &good);
    else if (rgb)
        (void)read_rgb(reader, node, &rmap_range_nonnegative, spectrum);
    else if (rmap_reader_number(reader, node, "blackbody", RMAP_REQUIRED, &rmap_range_temperature,
                                &spectrum->temperature_k))
        spectrum->kind = RMAP_SPECTRUM_BLACKBODY;
}
