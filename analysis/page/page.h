/* SPDX-License-Identifier: MIT
 *
 * A page to explore a map: one HTML file with everything in it, the scene, rays with all their
 * columns, classes of their paths, images of detectors, and the program that shows them (WebGL
 * through three.js, bundled at build time). It opens without a network.
 *
 * The data are one JSON document inside the page; analysis/page/data.js reads it. Names are
 * escaped, so nothing in a scene can break out of it. The same arguments give the same bytes.
 */
#ifndef RMAP_PAGE_H
#define RMAP_PAGE_H

#include "analysis/detector/detector_image.h"
#include "analysis/figure/figure_view.h"
#include "analysis/figure/ray_paint.h"
#include "analysis/paths/path_report.h"
#include "io/map/map_reader.h"
#include "portion/portion.h"

/* Parts of a page's data. */
#define RMAP_PAGE_SCENE     1u /* bodies, sources, media, geometries */
#define RMAP_PAGE_RAYS      2u /* the rays with all their columns, their classes and orders */
#define RMAP_PAGE_DETECTORS 4u /* with their images */
#define RMAP_PAGE_ALL       7u

/* All borrowed. */
struct rmap_page {
    bool is_data;   /* its JSON document alone, without what shows it */
    unsigned parts; /* all of them, but of data; what the others need may be left out */
    const char *title;
    const char *criterion;            /* NULL: all rays */
    const struct rmap_criterion *any; /* that, compiled */
    const struct rmap_map *map;
    const struct rmap_overlay *overlay; /* receivers; NULL: none */
    const struct rmap_portion *rays;    /* those in the page, all columns, with the receivers' */
    uint64_t n_matched;                 /* rays that match, of which `rays` holds some */
    double flux_matched;                /* their flux */
    enum rmap_view_kind kind;           /* first view; AUTO: from above at an angle */
    enum rmap_paint_kind paint;         /* first colours */
    enum rmap_path_level level;         /* of path classes */
    /* [n_where] switches, each with its colour; at most RMAP_PAGE_MOST_WHERE. */
    const struct rmap_criterion *const *where;
    size_t n_where;
    const struct rmap_path_report *paths; /* classes of all matching rays */
    /* [n_image] of all matching rays; of a detector without one the page shows where its rays
     * were registered. */
    size_t n_image;
    struct rmap_detector_image *const *image;
};

#define RMAP_PAGE_MOST_WHERE   31
#define RMAP_PAGE_MOST_CLASSES 500

/* Which registrations on these detectors count: as the switches have it, else the criterion. */
enum rmap_status rmap_page_which(const struct rmap_page *page,
                                 const struct rmap_index_set *detector,
                                 struct rmap_which **which_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Writes the page in place of what stood at `path`. RMAP_SYSTEM when it cannot be written. */
enum rmap_status rmap_page_write(const struct rmap_page *page, const char *path,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
