/* SPDX-License-Identifier: MIT
 *
 * What the commands of analysis do with a map, for targets that damage one.
 */
#ifndef RMAP_MAP_ANALYSIS_H
#define RMAP_MAP_ANALYSIS_H

#include "io/map/map_reader.h"

/* Demands that a status is RMAP_OK or tells of a wrong file; returns it. */
enum rmap_status map_analysis_judge(enum rmap_status st, const struct rmap_error *err);

/* Statistics, classes of paths, receivers, pictures and the energy of a map of the fixture's scene:
 * each ends in an answer, or tells that rows do not fit. What takes long is done
 * for some values of `pick` only. */
void map_analysis(const struct rmap_map *map, unsigned pick);

/* `raymap verify`: findings or none. */
void map_analysis_verify(const char *path);

#endif
