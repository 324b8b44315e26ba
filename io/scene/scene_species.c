/* SPDX-License-Identifier: MIT
 *
 * Species in a medium: what absorbs light and gives some of it back at other wavelengths.
 */
#include "io/scene/scene_species.h"

#include <math.h>

#include "base/alloc.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"

struct parameters {
    double absorption[RMAP_CHANNEL_MAX], yield[RMAP_CHANNEL_MAX];
    double concentration;
    int redshift;
};
static const struct rmap_range mol = {0, 1e3, "a concentration in mol/l, 0 to 1000"},
                               lifetime = {0, 1e15, "0 or longer", RMAP_DIMENSION_TIME};
const struct rmap_mapping rmap_species_keys = {
    "media",
    NULL,
    {{"a species", "absorption concentration emission yield lifetime redshift"}},
    {{"absorption", RMAP_KEY_SHARES, offsetof(struct parameters, absorption),
      &rmap_range_attenuation, .need = RMAP_REQUIRED},
     {"concentration", RMAP_KEY_NUMBER, offsetof(struct parameters, concentration), &mol},
     {"yield", RMAP_KEY_SHARES, offsetof(struct parameters, yield), &rmap_range_share},
     {"redshift", RMAP_KEY_WORD, offsetof(struct parameters, redshift), .words = "off only"}}};

/* Of decadic molar absorption in l/(mol cm). */
static double per_length(const struct rmap_scene *scene, double molar, double concentration)
{
    const double ln10 = 2.30258509299404568402;
    return ln10 * molar * concentration * 100.0 * scene->unit_m;
}

static void read_emission(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_species *its)
{
    struct rmap_spectrum spectrum;
    double sum = 0.0;
    rmap_reader_spectrum(reader, node, "emission", &spectrum);
    if (rmap_spectrum_shares(&spectrum, &reader->scene->channels, 0, its->below,
                             &reader->failure) != RMAP_OK)
        rmap_reader_error(reader, rmap_yaml_get(node, "emission"), "species '%.60s': %.200s",
                          its->name, reader->failure.text);
    /* rounded, as the C library's exponentials of some spectra differ between machines */
    for (int i = 0; i < reader->scene->channels.n; i++)
        its->below[i] = sum += floor(its->below[i] * 0x1p40 + 0.5) * 0x1p-40;
}

/* [2 ns], or [{time: 2 ns, share: 0.7}, ...] */
static void read_lifetimes(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_species *its)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "lifetime");
    const size_t n = list->kind == RMAP_YAML_LIST ? list->n_item : 1;
    double sum = 0.0;
    if (n == 0 || n > RMAP_DECAY_MAX) {
        rmap_reader_error(reader, list, "'lifetime' is one time, or a list of up to %d",
                          RMAP_DECAY_MAX);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        const struct rmap_yaml_node *at = list->kind == RMAP_YAML_LIST ? list->item[i].value : list;
        double share = 1.0;
        if (at->kind != RMAP_YAML_MAP) {
            if (n > 1)
                rmap_reader_error(reader, at,
                                  "several lifetimes have shares, as in {time: 2 ns, "
                                  "share: 0.7}");
            (void)rmap_reader_scalar(reader, at, "'lifetime'", &lifetime,
                                     &its->lifetime.time_ns[i]);
        } else if (rmap_reader_check_map(reader, at, "a lifetime", "time share")) {
            (void)rmap_reader_number(reader, at, "time", RMAP_REQUIRED, &lifetime,
                                     &its->lifetime.time_ns[i]);
            (void)rmap_reader_number(reader, at, "share", RMAP_OPTIONAL, &rmap_range_share, &share);
        }
        its->lifetime.below[i] = sum += share;
    }
    if (!(sum > 0.0))
        rmap_reader_error(reader, list, "the shares of the lifetimes sum to 0");
    for (size_t i = 0; i < n; i++)
        its->lifetime.below[i] /= sum;
    its->lifetime.n = n;
}

static void read_one(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_medium *medium, struct rmap_species *its)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_yaml_node *concentration = rmap_yaml_get(node, "concentration");
    struct parameters read = {.redshift = 0};
    const bool emits = rmap_yaml_get(node, "emission") != NULL;
    for (int i = 0; i < scene->channels.n; i++)
        read.yield[i] = emits ? 1.0 : 0.0;
    if (!rmap_reader_known(reader, node, &rmap_species_keys, 0) ||
        !rmap_reader_fill(reader, node, &rmap_species_keys, 0, &read))
        return;
    if (!emits && (rmap_yaml_get(node, "yield") || rmap_yaml_get(node, "lifetime")))
        rmap_reader_error(reader, node,
                          "species '%.60s' gives nothing back without its 'emission' spectrum",
                          its->name);
    for (int i = 0; i < scene->channels.n; i++) {
        its->absorption[i] = concentration
                                 ? per_length(scene, read.absorption[i], read.concentration)
                                 : read.absorption[i];
        its->yield[i] = read.yield[i];
        medium->absorption[i] += its->absorption[i];
        medium->absorbing |= medium->absorption[i] > 0.0;
    }
    its->redshift = read.redshift > 0;
    if (emits)
        read_emission(reader, node, its);
    if (rmap_yaml_get(node, "lifetime"))
        read_lifetimes(reader, node, its);
}

static void read_accounting(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_medium *medium)
{
    struct rmap_scene *scene = reader->scene;
    int choice = RMAP_ACCOUNTING_ENERGY;
    if (!rmap_reader_choice(reader, node, "accounting", RMAP_OPTIONAL, "energy photons", &choice))
        return;
    for (const struct rmap_medium *other = scene->medium; other < medium; other++)
        if (other->n_species > 0 && scene->accounting != (enum rmap_accounting)choice) {
            rmap_reader_error(reader, node,
                              "media '%.60s' and '%.60s' count flux in different ways: give both "
                              "the same 'accounting', energy (the default) or photons",
                              other->name, medium->name);
            return;
        }
    scene->accounting = (enum rmap_accounting)choice;
}

void rmap_reader_species(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_medium *medium)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "species");
    if (!list) {
        if (rmap_yaml_get(node, "accounting"))
            rmap_reader_error(reader, rmap_yaml_get(node, "accounting"),
                              "'accounting' says how what 'species' give back is counted: give "
                              "these, too");
        return;
    }
    if (list->kind != RMAP_YAML_MAP || list->n_item == 0) {
        rmap_reader_error(reader, list,
                          "'species' is a mapping of names, as in {dye: {absorption: 0.1, "
                          "emission: {...}}}");
        return;
    }
    if (reader->scene->channels.mode == RMAP_COLOUR_RGB) {
        rmap_reader_error(reader, list,
                          "'species' change wavelengths: take 'spectrum: {mode: spectral}'");
        return;
    }
    medium->species = rmap_alloc(list->n_item, sizeof *medium->species);
    if (!medium->species) {
        rmap_reader_no_memory(reader);
        return;
    }
    read_accounting(reader, node, medium);
    for (size_t i = 0; i < list->n_item; i++) {
        struct rmap_species *its = &medium->species[medium->n_species++];
        its->name = rmap_reader_strdup(reader, list->item[i].key);
        if (its->name)
            read_one(reader, list->item[i].value, medium, its);
    }
}

void rmap_reader_check_worth(struct rmap_reader *reader)
{
    const struct rmap_scene *scene = reader->scene;
    const double *nm = scene->channels.wavelength_nm;
    enum { WEIGHT_MAX = 1024 }; /* rmap_weight_round */
    double most = 1.0;
    int from = 0, to = 0;
    for (size_t m = 0; m < scene->n_medium; m++)
        for (size_t k = 0; k < scene->medium[m].n_species; k++) {
            const struct rmap_species *its = &scene->medium[m].species[k];
            for (int i = 0; i < scene->channels.n; i++)
                for (int c = 0; c < scene->channels.n && its->absorption[i] * its->yield[i] > 0.0;
                     c++)
                    if (its->below[c] > (c > 0 ? its->below[c - 1] : 0.0) &&
                        scene->worth[c] > most * scene->worth[i]) {
                        most = scene->worth[c] / scene->worth[i];
                        from = i;
                        to = c;
                    }
        }
    if (most > WEIGHT_MAX)
        rmap_reader_warn(reader, NULL,
                         "light of %g nm that is given back at %g nm is %.0f times as many lumens, "
                         "and more than %d times are not counted: give flux in W, and let "
                         "detectors make lx of it (--quantity illuminance, --xyz)",
                         nm[from], nm[to], most, WEIGHT_MAX);
}
