/* SPDX-License-Identifier: MIT
 *
 * The ghosts on a detector: the direct image, pairs of surfaces that reflected twice, and what came
 * by more reflections; each with its image's numbers.
 */
#ifndef RMAP_GHOST_LIST_H
#define RMAP_GHOST_LIST_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/detector_image.h"
#include "analysis/paths/path_key.h"
#include "mpi/command/command.h"

struct rmap_ghost {
    char *surfaces;  /* "lens.5 then lens.3"; NULL: any */
    uint32_t order;  /* reflections that make ghosts; 0: the direct image */
    char *criterion; /* of just these registrations */

    double flux, flux_error, registrations;
    double peak, peak_error, peak_x, peak_y; /* NaN: nothing was registered */
    double centroid[2], rms_radius;          /* of planes, else NaN */
};

struct rmap_ghost_list {
    struct rmap_ghost *ghost; /* [n], the direct image first */
    size_t n;
    size_t n_left;                        /* pairs beyond the first `top` */
    double flux_left;                     /* of these */
    const struct rmap_detector *detector; /* borrowed from the map */
    const char *body; /* rank 0: an object of several faces that made a ghost, borrowed; or NULL */
    const char *place_unit, *quantity, *unit, *flux_unit; /* as those of an image */
};

/* Collective, a scan of the map; the same on all ranks, with names and criteria. criterion: NULL:
 * all rays; else each row's criterion has it, too. */
enum rmap_status rmap_ghost_list_find(const struct rmap_context *context,
                                      const struct rmap_map *map,
                                      const struct rmap_criterion *criterion, int32_t detector,
                                      enum rmap_path_level level, uint64_t top,
                                      struct rmap_ghost_list **list_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_ghost_list_destroy(struct rmap_ghost_list *list); /* NULL is fine */

/* The numbers of a row's image. */
void rmap_ghost_list_take(struct rmap_ghost_list *list, size_t row,
                          const struct rmap_detector_image *image);

enum rmap_status rmap_ghost_list_print(const struct rmap_ghost_list *list, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_ghost_list_csv(const struct rmap_ghost_list *list, FILE *out);
json_t *rmap_ghost_list_json(const struct rmap_ghost_list *list); /* NULL when memory is short */

#endif
