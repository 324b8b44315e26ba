/* SPDX-License-Identifier: MIT
 *
 * The sections that everything else is measured by: units, limits, spectrum.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_glass.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_reader.h"
#include "optics/illuminant.h"

static const double rgb_index_nm = 587.56; /* RGB mode takes indices at the helium d line */

const struct rmap_written_unit *rmap_reader_length_unit(struct rmap_reader *reader,
                                                        const struct rmap_yaml_node *map,
                                                        const char *key)
{
    const char *word[RMAP_UNITS_MAX];
    size_t n = rmap_unit_words(RMAP_DIMENSION_LENGTH, word);
    int choice = -1;
    (void)rmap_reader_one_of(reader, map, key, RMAP_OPTIONAL, word, n, &choice);
    return choice < 0 ? NULL : rmap_unit_of_scene(word[choice], RMAP_DIMENSION_LENGTH);
}

void rmap_reader_read_units(struct rmap_reader *reader)
{
    const struct rmap_written_unit *unit = rmap_reader_length_unit(reader, reader->root, "units");
    char *name = rmap_reader_strdup(reader, unit ? unit->name : "mm");
    rmap_free(reader->scene->unit);
    reader->scene->unit = name;
    reader->scene->unit_m = unit ? unit->size : 1e-3;
}

static const struct rmap_range steps = {1, UINT32_MAX, NULL};
static const struct rmap_range below_one = {0, 0.999, "0 or greater, and below 1",
                                            RMAP_DIMENSION_SHARE};
const struct rmap_mapping rmap_limits_keys = {
    "Head",
    NULL,
    {{"limits", "steps flux"}},
    {{"steps", RMAP_KEY_WHOLE, offsetof(struct rmap_scene, limit_steps), &steps},
     {"flux", RMAP_KEY_NUMBER, offsetof(struct rmap_scene, limit_weight), &below_one}}};

void rmap_reader_limits(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    if (node && rmap_reader_known(reader, node, &rmap_limits_keys, 0))
        (void)rmap_reader_fill(reader, node, &rmap_limits_keys, 0, reader->scene);
}

void rmap_reader_read_limits(struct rmap_reader *reader)
{
    rmap_reader_limits(reader, rmap_yaml_get(reader->root, "limits"));
}

/* ---- wavelengths ---- */

/* Wavelengths gathered before they become channels. */
struct gathered {
    double *nm;
    size_t n, cap;
};

static void gather(struct rmap_reader *reader, struct gathered *set, double nm)
{
    double *place = RMAP_READER_NEW(reader, set->nm, set->n, set->cap);
    if (place)
        *place = nm;
}

static bool number_of(const char *text, double *value)
{
    return rmap_reader_parse_wavelength(text, value);
}

/* False when the source has light at other wavelengths than ones it names. */
static void gather_source(struct rmap_reader *reader, struct gathered *set,
                          const struct rmap_yaml_node *source, bool *named)
{
    const struct rmap_yaml_node *lines = rmap_yaml_get(rmap_yaml_get(source, "spectrum"), "lines");
    const struct rmap_yaml_node *rays = rmap_yaml_get(source, "rays");
    double nm = 0;
    *named = lines && lines->kind == RMAP_YAML_MAP;
    for (size_t i = 0; *named && i < lines->n_item; i++)
        if (number_of(lines->item[i].key, &nm))
            gather(reader, set, nm);
    if (!rays || rays->kind != RMAP_YAML_LIST)
        return;
    bool all = true;
    for (size_t i = 0; i < rays->n_item; i++) {
        const struct rmap_yaml_node *node = rmap_yaml_get(rays->item[i].value, "wavelength");
        bool good = node && node->kind == RMAP_YAML_SCALAR && number_of(node->text, &nm);
        all &= good;
        if (good)
            gather(reader, set, nm);
    }
    *named |= all;
}

static int by_value(const void *a, const void *b)
{
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

/* Sorted, with what differs by less than 1e-6 of itself merged. */
static size_t sort_unique(double *nm, size_t n)
{
    size_t kept = 0;
    if (n)
        qsort(nm, n, sizeof *nm, by_value);
    for (size_t i = 0; i < n; i++)
        if (!kept || nm[i] - nm[kept - 1] > 1e-6 * nm[i])
            nm[kept++] = nm[i];
    return kept;
}

static void set_channels(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                         const double *nm, size_t n)
{
    struct rmap_channels *channels = &reader->scene->channels;
    if (n > RMAP_CHANNEL_MAX) {
        rmap_reader_error(reader, at, "%zu wavelengths, but a scene has %d at most: take fewer", n,
                          RMAP_CHANNEL_MAX);
        n = RMAP_CHANNEL_MAX;
    }
    channels->n = (int)n;
    memcpy(channels->wavelength_nm, nm, n * sizeof *nm);
}

/* The range that is used where neither the scene nor its sources name wavelengths. */
static void set_visible(struct rmap_channels *channels)
{
    channels->n = 41;
    for (int i = 0; i < channels->n; i++)
        channels->wavelength_nm[i] = 380.0 + 10.0 * i;
}

/* Of the sources listed in a mapping, the scene or a group, and in the groups among its objects. */
static void gather_sources(struct rmap_reader *reader, struct gathered *set,
                           const struct rmap_yaml_node *map, bool *named)
{
    const struct rmap_yaml_node *sources = rmap_yaml_get(map, "sources");
    const struct rmap_yaml_node *objects = rmap_yaml_get(map, "objects");
    for (size_t i = 0; *named && sources && i < sources->n_item; i++)
        gather_source(reader, set, sources->item[i].value, named);
    for (size_t i = 0; *named && objects && i < objects->n_item; i++)
        gather_sources(reader, set, objects->item[i].value, named);
}

static void channels_of_sources(struct rmap_reader *reader)
{
    struct gathered set = {0};
    bool named = true;
    gather_sources(reader, &set, reader->root, &named);
    size_t n = sort_unique(set.nm, set.n);
    if (named && n)
        set_channels(reader, rmap_yaml_get(reader->root, "sources"), set.nm, n);
    else
        set_visible(&reader->scene->channels);
    rmap_free(set.nm);
}

struct range {
    double from, to, step;
};
#define STEP(member)                                                                               \
    RMAP_KEY_NUMBER, offsetof(struct range, member), &rmap_range_wavelength, .need = RMAP_REQUIRED
static const struct rmap_mapping range_keys = {
    "Head",
    NULL,
    {{"wavelengths", "from to step"}},
    {{"from", STEP(from)}, {"to", STEP(to)}, {"step", STEP(step)}}};

static void channels_of_range(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    struct range range = {0};
    double nm[RMAP_CHANNEL_MAX];
    set_visible(&reader->scene->channels);
    if (!rmap_reader_known(reader, node, &range_keys, 0) ||
        !rmap_reader_fill(reader, node, &range_keys, 0, &range))
        return;
    const double from = range.from, to = range.to, step = range.step;
    if (to < from) {
        rmap_reader_error(reader, rmap_yaml_get(node, "to"), "'to' must not be below 'from'");
        return;
    }
    double n = floor((to - from) / step + 1e-9) + 1;
    if (!(n <= RMAP_CHANNEL_MAX) || from + step == from) {
        rmap_reader_error(reader, node,
                          "%.0f wavelengths, but a scene has %d at most: take a larger step", n,
                          RMAP_CHANNEL_MAX);
        return;
    }
    for (int i = 0; i < (int)n; i++)
        nm[i] = from + step * i;
    set_channels(reader, node, nm, (size_t)n);
}

static void channels_of_list(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    size_t n = 0;
    set_visible(&reader->scene->channels);
    if (node->kind == RMAP_YAML_SCALAR) {
        double nm = 0;
        if (rmap_reader_scalar(reader, node, "'wavelengths'", &rmap_range_wavelength, &nm))
            set_channels(reader, node, &nm, 1);
        return;
    }
    double *nm = rmap_reader_alloc(reader, node->n_item, sizeof *nm);
    if (!nm)
        return;
    for (size_t i = 0; i < node->n_item; i++)
        if (rmap_reader_scalar(reader, node->item[i].value, "a wavelength", &rmap_range_wavelength,
                               &nm[n]))
            n++;
    size_t distinct = sort_unique(nm, n);
    if (distinct < n)
        rmap_reader_error(reader, node, "a wavelength stands there twice: remove one");
    if (distinct)
        set_channels(reader, node, nm, distinct);
    else if (!node->n_item)
        rmap_reader_error(reader, node, "'wavelengths' must not be empty");
}

static enum rmap_colour_mode colour_mode(struct rmap_reader *reader,
                                         const struct rmap_yaml_node *spectrum)
{
    static const char *const mode[] = {"spectral", "rgb"};
    const char *option = reader->bundle->options.color;
    int choice = 0;
    (void)rmap_reader_choice(reader, spectrum, "mode", RMAP_OPTIONAL, "spectral rgb", &choice);
    (void)rmap_reader_choice(reader, reader->simulation, "color", RMAP_OPTIONAL, "spectral rgb",
                             &choice);
    if (option && strcmp(option, mode[0]) == 0)
        choice = 0;
    else if (option && strcmp(option, mode[1]) == 0)
        choice = 1;
    else if (option)
        rmap_reader_unknown(reader, 0, 0, "unknown --color", option, mode, 2);
    return choice ? RMAP_COLOUR_RGB : RMAP_COLOUR_SPECTRAL;
}

const struct rmap_mapping rmap_spectrum_keys = {
    "Head", NULL, {{"spectrum", "mode wavelengths coatings"}}};

/* Group paths and delays: asked for by the simulation, or by the scene for all of them. */
static void read_timed(struct rmap_reader *reader)
{
    int choice = 0;
    (void)rmap_reader_choice(reader, reader->root, "time", RMAP_OPTIONAL, "off on", &choice);
    (void)rmap_reader_choice(reader, reader->simulation, "time", RMAP_OPTIONAL, "off on", &choice);
    reader->scene->timed = choice == 1;
    if (choice == 1 && reader->scene->channels.mode == RMAP_COLOUR_RGB)
        rmap_reader_warn(reader, NULL,
                         "'time: on' in colours of rgb: group indices are the phase indices, since "
                         "dispersion needs wavelengths (spectrum: {mode: spectral})");
}

void rmap_reader_read_channels(struct rmap_reader *reader)
{
    struct rmap_channels *channels = &reader->scene->channels;
    const struct rmap_yaml_node *spectrum = rmap_yaml_get(reader->root, "spectrum");
    if (spectrum && !rmap_reader_known(reader, spectrum, &rmap_spectrum_keys, 0))
        spectrum = NULL;
    const struct rmap_yaml_node *wavelengths = rmap_yaml_get(spectrum, "wavelengths");
    channels->mode = colour_mode(reader, spectrum);
    if (wavelengths && wavelengths->kind == RMAP_YAML_MAP)
        channels_of_range(reader, wavelengths);
    else if (wavelengths)
        channels_of_list(reader, wavelengths);
    else if (channels->mode == RMAP_COLOUR_SPECTRAL)
        channels_of_sources(reader);
    if (channels->mode == RMAP_COLOUR_RGB) {
        channels->n = 3;
        for (int i = 0; i < 3; i++)
            channels->wavelength_nm[i] = rgb_index_nm;
    }
    int coats = 0;
    (void)rmap_reader_choice(reader, spectrum, "coatings", RMAP_OPTIONAL, "line bands", &coats);
    channels->coats_by_band = coats == 1;
    read_timed(reader);
}

int32_t rmap_reader_channel(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            double wavelength_nm)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    int best = 0;
    for (int i = 1; i < channels->n; i++)
        if (fabs(channels->wavelength_nm[i] - wavelength_nm) <
            fabs(channels->wavelength_nm[best] - wavelength_nm))
            best = i;
    double first = channels->wavelength_nm[0], last = channels->wavelength_nm[channels->n - 1];
    double slack = 1e-6 * wavelength_nm;
    if (wavelength_nm < first - slack || wavelength_nm > last + slack) {
        rmap_reader_error(reader, at,
                          "%g nm lies outside the scene's wavelengths, %g to %g nm: add it to "
                          "'wavelengths' of 'spectrum'",
                          wavelength_nm, first, last);
        return -1;
    }
    if (fabs(channels->wavelength_nm[best] - wavelength_nm) > slack)
        rmap_reader_warn(reader, at,
                         "%g nm is none of the scene's wavelengths: the nearest one, %g nm, "
                         "stands for it",
                         wavelength_nm, channels->wavelength_nm[best]);
    return best;
}

/* Quantities over wavelength: tables, reflectances, the spectra of sources. */

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
