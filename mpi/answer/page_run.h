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

/* Collective. criterion: NULL for all rays. page: all but the images and paths filled in, on rank
 * 0; the map, the overlay and the level on every rank. */
enum rmap_status rmap_page_run(const struct rmap_context *context,
                               const struct rmap_criterion *criterion, struct rmap_page *page,
                               const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
