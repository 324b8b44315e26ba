/* SPDX-License-Identifier: MIT
 *
 * Flux and spectrum of a source.
 */
#include "io/scene/scene_source_light.h"

#include <string.h>

void rmap_reader_read_flux(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source_light *light)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "flux");
    const char *text = rmap_reader_text(reader, node, "flux", RMAP_OPTIONAL), *unit = NULL;
    light->flux = 1;
    light->bare = true;
    if (!text)
        return;
    if (!rmap_reader_parse_quantity(text, &light->flux, &unit)) {
        rmap_reader_error(reader, at,
                          "'flux' must be a power, as in '1 W' or '800 lm', not '%.40s'", text);
        return;
    }
    const struct rmap_written_unit *of =
        rmap_unit_of_scene(unit[0] ? unit : "W", RMAP_DIMENSION_FLUX);
    if (!of)
        of = rmap_unit_of_scene(unit, RMAP_DIMENSION_ENERGY);
    if (!of) {
        const char *known[2 * RMAP_UNITS_MAX];
        size_t n = rmap_unit_words(RMAP_DIMENSION_FLUX, known);
        n += rmap_unit_words(RMAP_DIMENSION_ENERGY, known + n);
        rmap_reader_unknown(reader, at->line, at->column, "unknown unit of flux", unit, known, n);
    }
    light->bare = unit[0] == 0;
    light->unit = of ? of->flux : RMAP_FLUX_W;
    light->flux *= of ? of->size : 1;
    if (!(light->flux > 0))
        rmap_reader_error(reader, at, "'flux' must be greater than 0, not %.40s", text);
}

static enum rmap_flux_unit unit_of(const struct rmap_scene *scene,
                                   const struct rmap_source_light *light)
{
    const bool steps = scene->source[light->source].type == RMAP_SOURCE_STEPS;
    return steps ? RMAP_FLUX_PHOTONS : light->unit;
}

enum {
    WATTS = 1 << RMAP_FLUX_W,
    LUMENS = 1 << RMAP_FLUX_LM,
    RATES = 1 << RMAP_FLUX_PHOTON_RATE,
    PHOTONS = 1 << RMAP_FLUX_PHOTONS,
    JOULES = 1 << RMAP_FLUX_J,
    POWERS = WATTS | LUMENS | RATES,
    AMOUNTS = PHOTONS | JOULES
};

/* Which units there are; in *bare_ret whether none is written. */
static unsigned units_seen(const struct rmap_scene *scene, const struct rmap_source_light *light,
                           size_t n, bool *bare_ret)
{
    unsigned seen = 0, either = 0;
    *bare_ret = true;
    for (size_t i = 0; i < n; i++) {
        *(light[i].either ? &either : &seen) |= 1U << unit_of(scene, &light[i]);
        *bare_ret = *bare_ret && light[i].bare && light[i].unit == RMAP_FLUX_W && !light[i].either;
    }
    return either && (seen & ~(unsigned)(WATTS | LUMENS)) ? seen | WATTS : seen;
}

/* Those of species that count energy: light given back would weigh less than the photon it is. */
static void check_accounting(struct rmap_reader *reader, const struct rmap_source_light *light,
                             size_t n)
{
    const struct rmap_scene *scene = reader->scene;
    bool any = false, steps = true;
    for (size_t i = 0; i < scene->n_medium; i++)
        any = any || scene->medium[i].n_species > 0;
    for (size_t i = 0; i < n; i++)
        steps = steps && scene->source[light[i].source].type == RMAP_SOURCE_STEPS;
    if (!any || scene->accounting == RMAP_ACCOUNTING_PHOTONS)
        return;
    if (steps)
        rmap_reader_warn(reader, NULL,
                         "light of steps is in photons, and what species give back is weighed by "
                         "its energy: give media 'accounting: photons'");
    else
        rmap_reader_error(reader, light->node,
                          "flux is in photons, and what species give back is weighed by its "
                          "energy: give media 'accounting: photons'");
}

void rmap_reader_settle_unit(struct rmap_reader *reader, const struct rmap_source_light *light,
                             size_t n)
{
    struct rmap_scene *scene = reader->scene;
    bool bare;
    const unsigned seen = units_seen(scene, light, n, &bare);
    scene->flux_unit = RMAP_FLUX_W;
    for (int unit = 0; unit <= RMAP_FLUX_J; unit++)
        if (seen == 1U << unit)
            scene->flux_unit = (enum rmap_flux_unit)unit;
    if (bare && seen == WATTS && scene->accounting == RMAP_ACCOUNTING_PHOTONS)
        scene->flux_unit = RMAP_FLUX_PHOTONS;
    if (seen == AMOUNTS)
        scene->flux_unit = RMAP_FLUX_J;
    for (size_t i = 0; i < n && (seen & POWERS) && (seen & AMOUNTS); i++) {
        const struct rmap_source *source = &scene->source[light[i].source];
        if (!(1U << unit_of(scene, &light[i]) & AMOUNTS))
            continue;
        if (source->type == RMAP_SOURCE_STEPS)
            rmap_reader_warn(reader, light[i].node,
                             "light of steps is in photons, that of other sources a power: sums "
                             "of both mean nothing");
        else
            rmap_reader_error(reader, light[i].node,
                              "source '%.60s' is an amount of light, others are powers (W, lm, "
                              "photons/s): give all as amounts (photons, J, eV) or all as powers",
                              source->name);
    }
    if (scene->flux_unit == RMAP_FLUX_PHOTONS || scene->flux_unit == RMAP_FLUX_PHOTON_RATE)
        check_accounting(reader, light, n);
}

/* From photons, of which `colour` has the shares, to their energy. */
static void weigh_photons(struct rmap_reader *reader, const struct rmap_source_light *light,
                          struct rmap_source *source)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    double energy = 0.0;
    if (!light->spectrum_given || channels->mode == RMAP_COLOUR_RGB || source->rays ||
        source->steps) {
        rmap_reader_error(reader, light->node,
                          "source '%.60s' is given in photons, others are not: to turn photons "
                          "into energy its 'spectrum' must be given, of wavelengths",
                          source->name);
        return;
    }
    for (int i = 0; i < channels->n; i++) {
        source->colour[i] *= RMAP_HC_J / channels->wavelength_nm[i];
        energy += source->colour[i];
    }
    for (int i = 0; i < channels->n; i++)
        source->colour[i] /= energy;
    source->flux *= energy;
}

void rmap_reader_settle_light(struct rmap_reader *reader, const struct rmap_source_light *light)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_source *source = &scene->source[light->source];
    bool in_lumens = scene->flux_unit == RMAP_FLUX_LM;
    const struct rmap_yaml_node *at = rmap_yaml_get(light->node, "spectrum");
    source->flux = light->flux;
    source->spectrum_given = light->spectrum_given;
    if (rmap_spectrum_shares(&light->spectrum, &scene->channels, in_lumens, source->colour,
                             &reader->failure) != RMAP_OK) {
        rmap_reader_error(reader, at ? at : light->node, "source '%.60s': %.200s", source->name,
                          reader->failure.text);
        return;
    }
    const enum rmap_flux_unit unit = unit_of(scene, light);
    if ((unit == RMAP_FLUX_PHOTONS && scene->flux_unit == RMAP_FLUX_J) ||
        (unit == RMAP_FLUX_PHOTON_RATE && scene->flux_unit == RMAP_FLUX_W))
        weigh_photons(reader, light, source);
    if (light->unit != RMAP_FLUX_LM || in_lumens)
        return;
    double lm_per_w = rmap_luminous_efficacy(&scene->channels, source->colour);
    if (!light->spectrum_given)
        rmap_reader_error(reader, light->node,
                          "source '%.60s' is given in lm, others in W: to turn lm into W its "
                          "'spectrum' must be given",
                          source->name);
    else if (!(lm_per_w > 0))
        rmap_reader_error(reader, light->node,
                          "source '%.60s' is given in lm but has no visible light", source->name);
    else
        source->flux = light->flux / lm_per_w;
}
