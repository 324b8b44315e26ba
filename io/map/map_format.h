/* SPDX-License-Identifier: MIT
 *
 * What writer and reader of a map agree on; docs/map.md says the same in words.
 */
#ifndef RMAP_MAP_FORMAT_H
#define RMAP_MAP_FORMAT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/hdf5/h5.h"
#include "io/map/map_content.h"

#define RMAP_FILETYPE_PIECE "raymap piece"
#define RMAP_FILETYPE_MAP   "raymap map"

/* A second link to the index as the last run found or began it: its scene and runs are there still
 * when map.h5 is damaged. */
#define RMAP_INDEX_START "map-start.h5"

#define RMAP_FORMAT_MAJOR 5
#define RMAP_FORMAT_MINOR 0
/* The oldest that is read. Formats 2 to 4 say in their number what 5 has features for: 3 that ids
 * of a portion may have gaps, 4 that there is /curve. */
#define RMAP_FORMAT_OLDEST 2
#define RMAP_FORMAT_CURVED 4

/* What a reader of format 5 must know, by name, in the attribute `features`. */
#define RMAP_FEATURE_CURVES "curves" /* /curve: the scene has gradient media */
#define RMAP_FEATURE_TIMES  "times"  /* group paths and delays; /curve, too */
#define RMAP_FEATURE_GAPS   "gaps"   /* ids of a portion may have gaps: picked rays */
#define RMAP_FEATURE_PLACES "places" /* compact portions may have places stand by themselves */
#define RMAP_FEATURE_CLASSES                                                                       \
    "classes" /* compact portions may have classes of steps for segments of own paths */
#define RMAP_FEATURE_CODES "codes" /* and these in a byte each */
#define RMAP_FEATURE_LENGTHS                                                                       \
    "lengths"                        /* rays with paths of their own say about how long they are */
#define RMAP_FEATURE_ANGLES "angles" /* registrations say about under which angle */
#define RMAP_FEATURE_ARRIVALS                                                                      \
    "arrivals" /* compact portions may say which paths the rays have that arrive at detectors */
#define RMAP_FEATURE_SCATTER                                                                       \
    "scatter" /* compact portions may leave out colours that follow from scatter models */

#define RMAP_FEATURE_METALS                                                                        \
    "metals" /* and those of metals, and of facets of boundaries, with models */
#define RMAP_FEATURE_FILMS "films" /* and those at thin films */
#define RMAP_FEATURE_TURBID                                                                        \
    "turbid" /* compact portions may leave out what follows from scattering and luminescence */

#define RMAP_FEATURE_SURFACES "surfaces" /* faces of meshes lie on surfaces */
#define RMAP_FEATURE_UV       "uv"       /* meshes have texture coordinates */

/* Pieces that the view of all pieces as one (virtual datasets) is made for. */
#define RMAP_VIEW_PIECES_MAX 256

struct rmap_field_table {
    const struct rmap_h5_field *field;
    size_t n;
};

/* Fields of struct rmap_chunk_entry, rmap_portion_info (in a piece, in the index), and
 * rmap_piece_info. curved: those that count rows have room for /curve. */
struct rmap_field_table rmap_chunk_fields(void);
struct rmap_field_table rmap_portion_fields_piece(bool curved);
struct rmap_field_table rmap_portion_fields_index(bool curved);
struct rmap_field_table rmap_portion_fields_picked(void); /* besides, where rays were picked */
struct rmap_field_table rmap_piece_fields(bool curved);

/* struct rmap_path_sum, of each path of a compact piece, where every portion's rays are told by
 * their paths; a piece that is taken over as its journal left it has none. */
struct rmap_field_table rmap_path_sum_fields(void);

/* Stored tables whose rows a file states. */
size_t rmap_format_n_table(bool curved);
struct rmap_field_table rmap_run_fields(void); /* of struct rmap_run_row */

#endif
