/* SPDX-License-Identifier: MIT
 *
 * The keys of a mapping as a table: which there are, what may stand behind them, and where it goes.
 * docs/scene.md is held against these tables (unit.test_scene_keys).
 */
#ifndef RMAP_SCENE_KEYS_H
#define RMAP_SCENE_KEYS_H

#include "io/scene/scene_reader.h"

enum rmap_key_kind {
    RMAP_KEY_NUMBER, /* double */
    RMAP_KEY_ANGLE,  /* double, in radians; degrees in the file */
    RMAP_KEY_PAIR,   /* double[2]; a number alone stands for both */
    RMAP_KEY_WHOLE,  /* uint64_t, within the range */
    RMAP_KEY_TRUTH,  /* bool */
    RMAP_KEY_WORD,   /* an enum: place among `words` */
    RMAP_KEY_SHARES, /* double[RMAP_CHANNEL_MAX]: a quantity over wavelength */
    RMAP_KEY_MEDIUM  /* int32_t */
};

/* A key that is read by the table. */
struct rmap_key {
    const char *name;
    enum rmap_key_kind kind;
    size_t at; /* offset in the structure that is filled */
    const struct rmap_range *range;
    double otherwise; /* of a number that is absent; 0: what was there stays */
    enum rmap_need need;
    unsigned types;    /* RMAP_TYPE bits: where not all types that have it mean the same; else 0 */
    const char *words; /* "front back both" */
};
#define RMAP_TYPE(type) (1u << (type))

struct rmap_mapping {
    const char *section; /* its heading in docs/scene.md */
    const char *types;   /* what its key `type` may be, in order; NULL: no such key */
    struct rmap_mapping_type {
        const char *what, *keys; /* "a plane detector", "name type on size ..." */
    } type[16];
    struct rmap_key key[26]; /* ends with a NULL name */
};
/* The i-th mapping of scene files; NULL behind the last. */
const struct rmap_mapping *rmap_scene_mapping(size_t i);
extern const struct rmap_mapping rmap_root_keys, rmap_spectrum_keys, rmap_limits_keys,
    rmap_medium_keys, rmap_film_keys, rmap_film_layer_keys, rmap_curve_keys, rmap_surface_keys,
    rmap_scatter_keys, rmap_geometry_keys, rmap_lens_row_keys, rmap_object_keys, rmap_source_keys,
    rmap_scattering_keys, rmap_mie_keys, rmap_species_keys, rmap_scintillation_keys,
    rmap_reading_keys, rmap_afterpulse_keys, rmap_detector_keys, rmap_camera_keys,
    rmap_background_keys, rmap_simulation_keys, rmap_face_keys, rmap_attribute_keys,
    rmap_match_keys, rmap_set_keys;

/* Its `type`; -1: missing or none of them. */
int rmap_reader_type(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_mapping *mapping);

/* Complains of keys that a mapping of this type does not have. False when node is no mapping. */
bool rmap_reader_known(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_mapping *mapping, int type);

/* Reads the keys of the table into a structure; of type -1, an unknown one, those that all types
 * have. False after a complaint. */
bool rmap_reader_fill(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct rmap_mapping *mapping, int type, void *into);

#endif
