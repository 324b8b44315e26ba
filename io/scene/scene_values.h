/* SPDX-License-Identifier: MIT
 *
 * Typed values of a scene file: numbers with units, words, names; every refusal says where, what
 * and what to do.
 */
#ifndef RMAP_SCENE_VALUES_H
#define RMAP_SCENE_VALUES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/unit.h"
#include "base/vec.h"

struct rmap_reader;
struct rmap_yaml_node;

enum rmap_need { RMAP_OPTIONAL, RMAP_REQUIRED };

/* Closed range; the text completes "'key' must be ...". Of a dimension that has units, they may
 * stand behind the number, which is brought to the one of the scene. */
struct rmap_range {
    double from, to;
    const char *text;
    enum rmap_dimension dimension;
};
extern const struct rmap_range rmap_range_any, rmap_range_positive, rmap_range_nonnegative,
    rmap_range_share, rmap_range_length, rmap_range_positive_length, rmap_range_nonnegative_length,
    rmap_range_angle, rmap_range_polar /* 0 to 180 */, rmap_range_wavelength,
    rmap_range_photon_energy /* in eV */, rmap_range_temperature, rmap_range_delay /* in ns */,
    rmap_range_curvature, rmap_range_attenuation,
    rmap_range_size; /* a length, of what positions can reach */

/* All of these: false after a complaint (or when a required key is missing, complained of);
 * true with *value untouched when an optional key is absent. */
bool rmap_reader_number(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const struct rmap_range *range,
                        double *value);
bool rmap_reader_whole(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                       const char *key, uint64_t from, uint64_t to, uint64_t *value);
bool rmap_reader_bool(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      bool *value);
bool rmap_reader_vec3(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      const struct rmap_range *range, struct rmap_vec3 *value);
/* The same, of length 1; zero is refused. */
bool rmap_reader_direction(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           const char *key, struct rmap_vec3 *value);
/* n_min to n_max numbers, or a single one standing alone when n_min is 1. *n_ret numbers. */
bool rmap_reader_numbers(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                         const char *key, enum rmap_need need, const struct rmap_range *range,
                         size_t n_min, size_t n_max, double *value, size_t *n_ret);
/* One of the words, as a text or as an array; *choice_ret its index. */
bool rmap_reader_choice(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const char *words, int *choice_ret);
bool rmap_reader_one_of(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const char *const *word,
                        size_t n_word, int *choice_ret);
/* NULL when absent or wrong. */
const char *rmap_reader_text(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                             const char *key, enum rmap_need need);
/* A name that people and criteria can write; RMAP_UNNAMED after a complaint. */
const char *rmap_reader_name(struct rmap_reader *reader, const struct rmap_yaml_node *map);
bool rmap_reader_check_name(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            const char *name);

/* The number that a scalar node is; `what` names it in the complaint. */
bool rmap_reader_scalar(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, const struct rmap_range *range, double *value);
/* A whole text as a finite number, in the notation of YAML and C, no hexadecimal. */
bool rmap_reader_parse_number(const char *text, size_t len, double *value);
/* The same of a wavelength in nm, or with its unit. */
bool rmap_reader_parse_wavelength(const char *text, double *nm_ret);
/* "60 s" -> 60 and "s"; the unit may be empty. Borrowed from text. */
bool rmap_reader_parse_quantity(const char *text, double *value, const char **unit_ret);

#endif
