/* SPDX-License-Identifier: MIT
 *
 * The page of `raymap draw -o x.html`: images of the detectors from every rank, the page from one.
 */
#ifndef RMAP_PAGE_RUN_H
#define RMAP_PAGE_RUN_H

#include "analysis/criterion/criterion.h"
#include "analysis/page/page.h"
#include "mpi/command/command.h"

/* Rays of a page when nobody says how many, and the most that browsers can be asked to hold. */
#define RMAP_PAGE_DEFAULT_RAYS 2000
#define RMAP_PAGE_MOST_RAYS    200000

/* A file, or where `path` is NULL the data of these parts (RMAP_PAGE_SCENE ...). */
struct rmap_page_wish {
    const char *path;
    unsigned parts;
};

/* Collective. criterion: NULL for all rays. page: all but the images and paths filled in, on rank
 * 0; the map, the overlay and the level on every rank. *data_ret: on rank 0, where data are wished;
 * a new reference. */
enum rmap_status rmap_page_run(const struct rmap_context *context,
                               const struct rmap_criterion *criterion, struct rmap_page *page,
                               const struct rmap_page_wish *wish, json_t **data_ret,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
