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
    if (!text)
        return;
    if (!rmap_reader_parse_quantity(text, &light->flux, &unit)) {
        rmap_reader_error(reader, at,
                          "'flux' must be a power, as in '1 W' or '800 lm', not '%.40s'", text);
        return;
    }
    const struct rmap_written_unit *of =
        rmap_unit_of_scene(unit[0] ? unit : "W", RMAP_DIMENSION_FLUX);
    if (!of) {
        const char *known[RMAP_UNITS_MAX];
        size_t n = rmap_unit_words(RMAP_DIMENSION_FLUX, known);
        rmap_reader_unknown(reader, at->line, at->column, "unknown unit of flux", unit, known, n);
    }
    light->lumens = of && of->lumens;
    light->flux *= of ? of->size : 1;
    if (!(light->flux > 0))
        rmap_reader_error(reader, at, "'flux' must be greater than 0, not %.40s", text);
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
    if (!light->lumens || in_lumens)
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
