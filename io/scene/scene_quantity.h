/* SPDX-License-Identifier: MIT
 *
 * Quantities over wavelength: tables, reflectances, the spectra of sources.
 */
#ifndef RMAP_SCENE_QUANTITY_H
#define RMAP_SCENE_QUANTITY_H

#include "io/scene/scene_reader.h"

/* A reflectance-like quantity on the channels: number, {wavelength, value}, {rgb}. value[n]. */
void rmap_reader_quantity(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                          const char *key, enum rmap_need need, const struct rmap_range *range,
                          double *value);

/* Columns of a table over wavelength or angle, by their keys: "wavelength n k", the first of which
 * strictly increases; the others are as long, and the first n_required must be there. Arena memory;
 * columns absent stay NULL. */
void rmap_reader_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *keys, size_t n_required, const struct rmap_range *range,
                       size_t *n_ret, double **column);

/* One such column, `wavelength` or `angle`; *n_ret 0 after a complaint. */
void rmap_reader_axis(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *key, size_t *n_ret, double **column);

/* A source's `spectrum`, or what else is one; absent: equal. */
void rmap_reader_spectrum(struct rmap_reader *reader, const struct rmap_yaml_node *source,
                          const char *key, struct rmap_spectrum *spectrum);

#endif
