/* SPDX-License-Identifier: MIT
 *
 * Complaints of the scene reader, its memory, and typed access to YAML values.
 */
#ifndef RMAP_SCENE_VALUES_H
#define RMAP_SCENE_VALUES_H

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"
#include "io/scene/yaml_tree.h"

struct rmap_reader;

void rmap_reader_error(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const char *format, ...) RMAP_PRINTF(3, 4);
void rmap_reader_warn(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                      const char *format, ...) RMAP_PRINTF(3, 4);

/* "what 'word' (did you mean 'x'?)" + remedy */
void rmap_reader_unknown(struct rmap_reader *reader, int line, int column, const char *what,
                         const char *word, const char *const *known, size_t n_known);

/* The words of a text that blanks part, each once. */
struct rmap_words {
    size_t n;
    const char *word[32];
    char text[400];
};
void rmap_words_split(const char *text, struct rmap_words *words);

/* False, with a complaint, when node is no mapping. Complains about keys that are not known: words,
 * or an array of them. */
bool rmap_reader_check_map(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *what, const char *keys);
bool rmap_reader_check_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what, const char *const *known, size_t n_known);
bool rmap_reader_check_list(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what);

enum rmap_need { RMAP_OPTIONAL, RMAP_REQUIRED };

/* Closed range; the text completes "'key' must be ...". */
struct rmap_range {
    double from, to;
    const char *text;
};
extern const struct rmap_range rmap_range_any, rmap_range_positive, rmap_range_nonnegative,
    rmap_range_share;

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
                      struct rmap_vec3 *value);
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
/* "60 s" -> 60 and "s"; the unit may be empty. Borrowed from text. */
bool rmap_reader_parse_quantity(const char *text, double *value, const char **unit_ret);

/* The scene cannot be read, for what reader->failure says; for want of memory. */
void rmap_reader_fail(struct rmap_reader *reader, enum rmap_status status);
void rmap_reader_no_memory(struct rmap_reader *reader);

/* Hands a library's verdict on, whose text is in reader->failure: RMAP_INPUT becomes a complaint at
 * node. */
void rmap_reader_made(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      enum rmap_status status);

/* Zeroed memory that lives as long as the reader; NULL when short, which the reader then knows. */
void *rmap_reader_alloc(struct rmap_reader *reader, size_t n, size_t size);
void rmap_reader_release(struct rmap_reader *reader); /* all of it */
/* A copy that the scene owns; so NULL. */
char *rmap_reader_strdup(struct rmap_reader *reader, const char *text);

/* A zeroed new element at the end of an array, or NULL. */
#define RMAP_READER_NEW(reader, array, n, cap)                                                     \
    (rmap_reader_room((reader), &(array), &(cap), (n), sizeof *(array)) ? &(array)[(n)++] : NULL)
bool rmap_reader_room(struct rmap_reader *reader, void *array_address, size_t *cap, size_t n,
                      size_t size);

#define RMAP_COUNT(array) (sizeof(array) / sizeof((array)[0]))

#endif
