/* SPDX-License-Identifier: MIT
 *
 * What `raymap draw` is asked for.
 */
#ifndef RMAP_DRAW_REQUEST_H
#define RMAP_DRAW_REQUEST_H

#include "analysis/figure/figure_view.h"
#include "analysis/figure/ray_paint.h"
#include "mpi/command/arguments.h"

enum rmap_draw_format {
    RMAP_DRAW_PICTURE,  /* .svg, .png */
    RMAP_DRAW_PAGE,     /* .html, and its data, .json */
    RMAP_DRAW_POLYDATA, /* .vtp */
    RMAP_DRAW_GLTF      /* .glb, .gltf */
};

struct rmap_draw_request {
    const char *map_path, *output_path;
    const char *camera; /* NULL: none */
    char **where;       /* [n_where] */
    size_t n_where;
    enum rmap_draw_format format;
    bool is_data;   /* .json */
    unsigned parts; /* of the page, RMAP_PAGE_SCENE ... */
    uint64_t limit;
    bool thin; /* nobody asked for so many */
    enum rmap_view_kind kind;
    enum rmap_paint_kind paint;
    enum rmap_path_level level;
    bool has_eye, has_cut, has_level;
    double eye[2];    /* azimuth, elevation, degrees */
    double cut;       /* scene units */
    double stretch;   /* 0: as suits */
    double near;      /* of a section's plane rays must run, scene units; 0: anywhere */
    double opacity;   /* 0: by the number of rays */
    double time[3];   /* of a film: from, until, step, ns */
    uint32_t n_frame; /* 0: one picture of whole rays */
    bool animated;    /* one file for all of them */
};

/* "-62,28": azimuth and elevation. RMAP_USAGE. */
enum rmap_status rmap_read_eye(const char *text, double eye[2],
                               struct rmap_error *err) RMAP_MUST_USE;

/* "film.png" as "film-0001.png" for the first (0) of many. RMAP_USAGE where it is too long. */
#define RMAP_FRAME_PATH_LEN 4096
enum rmap_status rmap_frame_path(const char *path, uint32_t frame, char out[RMAP_FRAME_PATH_LEN],
                                 struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE; rmap_draw_request_fini whatever happened. */
enum rmap_status rmap_draw_request_read(const struct rmap_arguments *given,
                                        struct rmap_draw_request *request,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_draw_request_fini(struct rmap_draw_request *request);

#endif
