/* SPDX-License-Identifier: MIT
 *
 * The sections that everything else is measured by: units, limits, spectrum.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_reader.h"

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
