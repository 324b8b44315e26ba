/* SPDX-License-Identifier: MIT
 *
 * Mappings read by their tables of keys.
 */
#include "io/scene/scene_keys.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_quantity.h"

#include <string.h>

static const struct rmap_mapping *const mappings[] = {
    &rmap_root_keys,          &rmap_spectrum_keys,   &rmap_limits_keys,     &rmap_medium_keys,
    &rmap_film_keys,          &rmap_film_layer_keys, &rmap_curve_keys,      &rmap_surface_keys,
    &rmap_geometry_keys,      &rmap_lens_row_keys,   &rmap_object_keys,     &rmap_source_keys,
    &rmap_detector_keys,      &rmap_camera_keys,     &rmap_background_keys, &rmap_simulation_keys,
    &rmap_scatter_keys,       &rmap_scattering_keys, &rmap_mie_keys,        &rmap_species_keys,
    &rmap_scintillation_keys, &rmap_reading_keys,    &rmap_afterpulse_keys, &rmap_face_keys,
    &rmap_attribute_keys,     &rmap_match_keys,      &rmap_set_keys};

const struct rmap_mapping *rmap_scene_mapping(size_t i)
{
    return i < RMAP_COUNT(mappings) ? mappings[i] : NULL;
}

int rmap_reader_type(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_mapping *mapping)
{
    int type = -1;
    (void)rmap_reader_choice(reader, node, "type", RMAP_REQUIRED, mapping->types, &type);
    return type;
}

bool rmap_reader_known(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_mapping *mapping, int type)
{
    return rmap_reader_check_map(reader, node, mapping->type[type].what, mapping->type[type].keys);
}

static bool is_of_type(const struct rmap_mapping *mapping, const struct rmap_key *key, int type)
{
    bool all = true;
    if (type >= 0)
        return rmap_words_have(mapping->type[type].keys, key->name) &&
               (!key->types || key->types >> type & 1);
    for (size_t t = 0; t < RMAP_COUNT(mapping->type) && mapping->type[t].keys; t++)
        all &= rmap_words_have(mapping->type[t].keys, key->name);
    return all && !key->types;
}

static bool read_pair(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct rmap_key *key, double pair[2])
{
    size_t n = 0;
    bool good = rmap_reader_numbers(reader, node, key->name, key->need, key->range, 1, 2, pair, &n);
    if (n == 1)
        pair[1] = pair[0];
    return good;
}

static bool read_key(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_key *key, void *to)
{
    double *number = to;
    size_t before = reader->diagnostics->n_error;
    switch (key->kind) {
    case RMAP_KEY_NUMBER:
    case RMAP_KEY_ANGLE:
        if (key->otherwise != 0)
            *number = key->otherwise;
        (void)rmap_reader_number(reader, node, key->name, key->need, key->range, number);
        if (key->kind == RMAP_KEY_ANGLE)
            *number = *number * RMAP_PI / 180;
        break;
    case RMAP_KEY_PAIR:
        return read_pair(reader, node, key, number);
    case RMAP_KEY_WHOLE:
        return rmap_reader_whole(reader, node, key->name, (uint64_t)key->range->from,
                                 (uint64_t)key->range->to, to);
    case RMAP_KEY_TRUTH:
        return rmap_reader_bool(reader, node, key->name, to);
    case RMAP_KEY_WORD:
        return rmap_reader_choice(reader, node, key->name, key->need, key->words, to);
    case RMAP_KEY_SHARES:
        rmap_reader_quantity(reader, node, key->name, key->need, key->range, number);
        break;
    case RMAP_KEY_MEDIUM:
        rmap_reader_medium(reader, node, key->name, to);
        break;
    }
    return reader->diagnostics->n_error == before;
}

bool rmap_reader_fill(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct rmap_mapping *mapping, int type, void *into)
{
    bool good = true;
    for (size_t k = 0; k < RMAP_COUNT(mapping->key) && mapping->key[k].name; k++)
        if (is_of_type(mapping, &mapping->key[k], type))
            good &= read_key(reader, node, &mapping->key[k], (char *)into + mapping->key[k].at);
    return good;
}
