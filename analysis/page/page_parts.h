/* SPDX-License-Identifier: MIT
 *
 * The parts of a page's data. Each is a new reference, or NULL with err set.
 */
#ifndef RMAP_PAGE_PARTS_H
#define RMAP_PAGE_PARTS_H

#include <jansson.h>

#include "analysis/page/page.h"

/* Media, groups, objects with their geometry, sources. */
json_t *rmap_page_scene(const struct rmap_scene *scene, struct rmap_error *err);

/* What tells two scenes apart that differ in places alone: those of the objects that moved,
 * {index: matrix}, and of all sources and detectors. NULL: they may differ in more, or memory is
 * short. */
json_t *rmap_page_places(const struct rmap_scene *before, const struct rmap_scene *after);

/* Every geometry: the profile of a surface of revolution, or triangles, their corners as parts of
 * their box, 16 bits each. */
json_t *rmap_page_geometries(const struct rmap_scene *scene, struct rmap_error *err);

/* Every detector, with its image where there is one. */
json_t *rmap_page_detectors(const struct rmap_page *page, struct rmap_error *err);

/* Classes of the paths of all matching rays, most flux first, and which of them each ray of the
 * page is of; and their orders of ghosts and scattering (path_order.h). */
json_t *rmap_page_classes(const struct rmap_page *page, struct rmap_error *err);
json_t *rmap_page_orders(const struct rmap_page *page, struct rmap_error *err);

/* The criteria that are switched, and which of them each ray matches: bits. */
json_t *rmap_page_where(const struct rmap_page *page, struct rmap_error *err);

#endif
