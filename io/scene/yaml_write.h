/* SPDX-License-Identifier: MIT
 *
 * Values of JSON as YAML in a line.
 */
#ifndef RMAP_YAML_WRITE_H
#define RMAP_YAML_WRITE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

void rmap_yaml_write_value(FILE *out, const json_t *value);

/* {name: ..., and what the value has} */
void rmap_yaml_write_named(FILE *out, const char *name, const json_t *value);

/* "a.b" and a value: "a: {b: value}"; of a list of what has names "a: [{name: b, ...}]". */
void rmap_yaml_write_path(FILE *out, const char *path, const json_t *value);

/* Has a key of n letters such a list in scenes? */
bool rmap_yaml_has_named(const char *key, size_t n);

#endif
