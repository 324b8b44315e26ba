/* SPDX-License-Identifier: MIT
 *
 * The scene file as a JSON Schema, made of the tables by which it is read.
 */
#include "mpi/answer/scene_schema.h"

#include <float.h>
#include <string.h>

#include "io/scene/scene_keys.h"

/* How the mappings of a section stand in the file. */
enum holder { ALONE, NAMED, LISTED };

static const struct section {
    const char *key;
    const struct rmap_mapping *mapping;
    enum holder holder;
} sections[] = {
    {"spectrum", &rmap_spectrum_keys, ALONE},
    {"limits", &rmap_limits_keys, ALONE},
    {"background", &rmap_background_keys, ALONE},
    {"media", &rmap_medium_keys, NAMED},
    {"films", &rmap_film_keys, NAMED},
    {"surfaces", &rmap_surface_keys, NAMED},
    {"geometries", &rmap_geometry_keys, NAMED},
    {"objects", &rmap_object_keys, LISTED},
    {"attributes", &rmap_attribute_keys, LISTED},
    {"sources", &rmap_source_keys, LISTED},
    {"detectors", &rmap_detector_keys, LISTED},
    {"cameras", &rmap_camera_keys, LISTED},
    {"simulations", &rmap_simulation_keys, LISTED},
};

static json_t *words_json(const char *list)
{
    json_t *json = json_array();
    struct rmap_words words;
    rmap_words_split(list, &words);
    for (size_t i = 0; i < words.n; i++)
        (void)json_array_append_new(json, json_string(words.word[i]));
    return json;
}

/* Numbers may have a unit, and then are text. */
static json_t *number_json(const struct rmap_key *key)
{
    json_t *json = json_pack("{s:[s, s]}", "type", "number", "string");
    if (key->range && key->range->from > 0 && key->range->from <= DBL_MIN)
        (void)json_object_set_new(json, "exclusiveMinimum", json_integer(0));
    else if (key->range && key->range->from > -DBL_MAX)
        (void)json_object_set_new(json, "minimum", json_real(key->range->from));
    if (key->range && key->range->to < DBL_MAX)
        (void)json_object_set_new(json, "maximum", json_real(key->range->to));
    if (key->otherwise != 0)
        (void)json_object_set_new(json, "default", json_real(key->otherwise));
    return json;
}

static json_t *value_json(const struct rmap_key *key)
{
    json_t *json = NULL;
    switch (key->kind) {
    case RMAP_KEY_NUMBER:
    case RMAP_KEY_ANGLE:
    case RMAP_KEY_WHOLE:
        json = number_json(key);
        break;
    case RMAP_KEY_TRUTH:
        json = json_pack("{s:s}", "type", "boolean");
        break;
    case RMAP_KEY_WORD:
        json = json_pack("{s:o}", "enum", words_json(key->words));
        break;
    case RMAP_KEY_MEDIUM:
        json = json_pack("{s:s}", "description", "the name of a medium");
        break;
    case RMAP_KEY_PAIR:
    case RMAP_KEY_SHARES:
        json = json_object();
        break;
    }
    if (key->range)
        (void)json_object_set_new(json, "description", json_string(key->range->text));
    return json;
}

/* Mappings of one type; -1: of none. */
static json_t *type_json(const struct rmap_mapping *mapping, int type)
{
    const struct rmap_mapping_type *of = &mapping->type[type < 0 ? 0 : type];
    json_t *property = json_object(), *required = json_array();
    struct rmap_words words, types;
    rmap_words_split(of->keys, &words);
    for (size_t i = 0; i < words.n; i++)
        (void)json_object_set_new(property, words.word[i], json_object());
    for (size_t k = 0; k < RMAP_COUNT(mapping->key) && mapping->key[k].name; k++) {
        const struct rmap_key *key = &mapping->key[k];
        if (!json_object_get(property, key->name) ||
            (key->types && type >= 0 && !(key->types >> type & 1)))
            continue;
        (void)json_object_set_new(property, key->name, value_json(key));
        if (key->need == RMAP_REQUIRED)
            (void)json_array_append_new(required, json_string(key->name));
    }
    if (type >= 0 && mapping->types) {
        rmap_words_split(mapping->types, &types);
        (void)json_object_set_new(property, "type", json_pack("{s:s}", "const", types.word[type]));
    }
    return json_pack("{s:s, s:s, s:b, s:o, s:o}", "type", "object", "title",
                     of->what ? of->what : mapping->section, "additionalProperties", 0,
                     "properties", property, "required", required);
}

static json_t *mapping_json(const struct rmap_mapping *mapping)
{
    json_t *list = json_array();
    for (int t = 0; t < (int)RMAP_COUNT(mapping->type) && mapping->type[t].keys; t++)
        (void)json_array_append_new(list, type_json(mapping, t));
    return json_pack("{s:o}", "anyOf", list);
}

json_t *rmap_scene_schema(void)
{
    json_t *root = type_json(&rmap_root_keys, -1), *property = json_object_get(root, "properties");
    for (size_t i = 0; i < RMAP_COUNT(sections); i++) {
        json_t *of = mapping_json(sections[i].mapping);
        if (sections[i].holder == NAMED)
            of = json_pack("{s:s, s:o}", "type", "object", "additionalProperties", of);
        else if (sections[i].holder == LISTED)
            of = json_pack("{s:s, s:o}", "type", "array", "items", of);
        (void)json_object_set_new(property, sections[i].key, of);
    }
    if (root)
        (void)json_object_set_new(root, "$schema",
                                  json_string("http://json-schema.org/draft-07/schema#"));
    return root;
}
