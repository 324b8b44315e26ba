/* SPDX-License-Identifier: MIT
 *
 * `scintillation:` of a medium.
 */
#include "io/scene/scene_scintillation.h"

#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"

static const struct rmap_range resolution = {0, 100, "between 0 and 100"};
const struct rmap_mapping rmap_scintillation_keys = {
    "scintillation",
    NULL,
    {{"scintillation", "per_MeV birks resolution spectrum rise decay"}},
    {{"per_MeV", RMAP_KEY_NUMBER, offsetof(struct rmap_scintillation, per_mev),
      &rmap_range_positive, 0, RMAP_REQUIRED},
     {"resolution", RMAP_KEY_NUMBER, offsetof(struct rmap_scintillation, resolution), &resolution},
     {"rise", RMAP_KEY_NUMBER, offsetof(struct rmap_scintillation, rise_ns), &rmap_range_delay}}};

/* "0.126 mm/MeV" in the scene's length unit per MeV; a number alone is that. */
static void read_birks(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_scintillation *light)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "birks");
    const char *text = rmap_reader_text(reader, node, "birks", RMAP_OPTIONAL), *unit = NULL;
    if (!text)
        return;
    const bool good = rmap_reader_parse_quantity(text, &light->birks, &unit);
    const size_t n = good ? strcspn(unit, "/") : 0;
    const struct rmap_written_unit *length = rmap_unit_named(good ? unit : "", n);
    const double energy = !good                           ? 0
                          : unit[0] == 0                  ? 1
                          : strcmp(unit + n, "/keV") == 0 ? 1e-3
                          : strcmp(unit + n, "/MeV") == 0 ? 1
                          : strcmp(unit + n, "/GeV") == 0 ? 1e3
                                                          : 0;
    if (!(light->birks >= 0) || !(energy > 0) ||
        (unit[0] && (!length || length->dimension != RMAP_DIMENSION_LENGTH)))
        rmap_reader_error(
            reader, at,
            "'birks' must be a length per energy, 0 or greater, as in '0.126 mm/MeV', "
            "not '%.40s'",
            text);
    else if (unit[0])
        light->birks *= length->size / reader->scene->unit_m / energy;
}

static void read_component(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double *time_ns, double *share)
{
    *share = 1;
    if (!rmap_reader_check_map(reader, node, "a component of 'decay'", "time share"))
        return;
    (void)rmap_reader_number(reader, node, "time", RMAP_REQUIRED, &rmap_range_delay, time_ns);
    (void)rmap_reader_number(reader, node, "share", RMAP_OPTIONAL, &rmap_range_positive, share);
}

/* A time, or a list of components. */
static void read_decay(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_scintillation *light)
{
    const struct rmap_yaml_node *decay = rmap_yaml_get(node, "decay");
    struct rmap_decay *its = &light->decay;
    double share[RMAP_DECAY_MAX], sum = 0, below = 0;
    if (!decay)
        return;
    if (decay->kind == RMAP_YAML_MAP) {
        rmap_reader_error(reader, decay,
                          "'decay' is a time, or a list of components: [{time: 2.1 ns, share: 1}]");
        return;
    }
    if (decay->kind != RMAP_YAML_LIST) {
        its->n = 1;
        its->below[0] = 1;
        (void)rmap_reader_number(reader, node, "decay", RMAP_REQUIRED, &rmap_range_delay,
                                 &its->time_ns[0]);
        return;
    }
    if (decay->n_item < 1 || decay->n_item > RMAP_DECAY_MAX) {
        rmap_reader_error(reader, decay, "'decay' has 1 to %d components", RMAP_DECAY_MAX);
        return;
    }
    its->n = decay->n_item;
    for (size_t i = 0; i < its->n; i++) {
        read_component(reader, decay->item[i].value, &its->time_ns[i], &share[i]);
        sum += share[i];
    }
    for (size_t i = 0; i < its->n; i++)
        its->below[i] = below += share[i] / sum;
}

void rmap_reader_scintillation(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_medium *medium)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "scintillation");
    struct rmap_spectrum spectrum;
    if (!at || !rmap_reader_known(reader, at, &rmap_scintillation_keys, 0))
        return;
    struct rmap_scintillation *light = rmap_alloc(1, sizeof *light);
    if (!light) {
        rmap_reader_no_memory(reader);
        return;
    }
    medium->scintillation = light;
    light->resolution = 1;
    (void)rmap_reader_fill(reader, at, &rmap_scintillation_keys, 0, light);
    read_birks(reader, at, light);
    read_decay(reader, at, light);
    if (light->rise_ns > 0 && !rmap_yaml_get(at, "decay"))
        rmap_reader_error(reader, rmap_yaml_get(at, "rise"),
                          "'rise' is that of light that decays: give 'decay', too");
    const struct rmap_yaml_node *its = rmap_yaml_get(at, "spectrum");
    rmap_reader_spectrum(reader, at, "spectrum", &spectrum);
    if (rmap_spectrum_shares(&spectrum, &reader->scene->channels, 0, light->share,
                             &reader->failure) != RMAP_OK)
        rmap_reader_error(reader, its ? its : at, "%s", reader->failure.text);
}
