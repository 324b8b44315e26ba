/* SPDX-License-Identifier: MIT
 *
 * Receivers laid over a finished map: detectors that the scene did not have when it was traced.
 * Their registrations are computed from the stored segments by the tracer's own formulas
 * (trace/detector.h): planes free in space cut the segments, those lying on an object take the
 * stored hits, intensity grids the directions in which rays left.
 *
 * What the stored numbers cost: points are float32 and directions of segments come from them, so a
 * crossing lies where the tracer would have put it up to 1e-7 of the scene's coordinates, and
 * its direction up to that over the segment's length. A curved segment is made
 * again between the recorded points by the ray equation in its medium's field. A segment that left
 * the scene goes on in its direction to wherever a receiver stands.
 */
#ifndef RMAP_OVERLAY_H
#define RMAP_OVERLAY_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"
#include "io/scene/receivers.h"

/* Immutable, any number of threads. The map is borrowed and must outlive it. RMAP_INPUT with the
 * mistakes in receivers->diagnostics; the text is not needed any more. */
struct rmap_overlay;
enum rmap_status rmap_overlay_create(const struct rmap_map *map,
                                     const struct rmap_receivers *receivers,
                                     struct rmap_overlay **overlay_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_overlay_destroy(struct rmap_overlay *overlay); /* NULL is fine */

/* The map's scene (colour space 0) with the receivers behind its detectors: what criteria are
 * compiled against, and what says what detector an index is; without an overlay (NULL) the map's
 * own. Not for tracing. Borrowed. */
const struct rmap_scene *rmap_scene_with(const struct rmap_map *map,
                                         const struct rmap_overlay *overlay);

/* Index of the first receiver: as many detectors as the map's scene has. */
size_t rmap_overlay_first(const struct rmap_overlay *overlay);

/* What must be read to have the columns `wanted` of the portion with its receivers. */
rmap_column_set rmap_overlay_columns(const struct rmap_overlay *overlay, rmap_column_set wanted);

/* What a portion's row says once receivers may have registered any of its rays. */
void rmap_overlay_info(const struct rmap_overlay *overlay, const struct rmap_portion_info *stored,
                       struct rmap_portion_info *info);

/* Portions of the map that may hold a match, which are read (criterion NULL: all). */
size_t rmap_overlay_n_read(const struct rmap_overlay *overlay,
                           const struct rmap_criterion *criterion);

/* One thread's. Gives portions with the receivers' registrations among those of the scene's
 * detectors: as the tracer would have put them, by distance along the segment, then by detector. */
struct rmap_overlay_view;
enum rmap_status rmap_overlay_view_create(const struct rmap_overlay *overlay,
                                          struct rmap_overlay_view **view_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_overlay_view_destroy(struct rmap_overlay_view *view); /* NULL is fine */

/* As a colour space: each ray is in its own, as in a portion of rays picked from all over a map. */
#define RMAP_OVERLAY_EACH_SPACE SIZE_MAX

/* stored: with the columns of rmap_overlay_columns, of colour space `space`. *extended_ret: the
 * view's, valid until the next call; its other tables are those of `stored`. RMAP_FORMAT when rows
 * do not fit together. */
enum rmap_status rmap_overlay_view_extend(struct rmap_overlay_view *view,
                                          const struct rmap_portion *stored, size_t space,
                                          const struct rmap_portion **extended_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
