/* SPDX-License-Identifier: MIT
 *
 * All criteria that a command is given, and the one that they make together.
 */
#ifndef RMAP_ASKED_EACH_H
#define RMAP_ASKED_EACH_H

#include "mpi/command/asked.h"

struct rmap_asked_each {
    struct rmap_criterion **of; /* [n] as they were given */
    size_t n;
    struct rmap_criterion *any; /* rays that match one of them; all rays where n is 0 */
    const char *text;           /* of any; NULL where n is 0 */
};

/* Rank 0 prints the translation of a filter to stderr. RMAP_INPUT of the first that is wrong.
 * rmap_asked_each_fini whatever happened. */
enum rmap_status rmap_asked_each_compile(const struct rmap_context *context,
                                         struct rmap_asked *asked, const struct rmap_scene *scene,
                                         struct rmap_asked_each *each,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_asked_each_fini(struct rmap_asked_each *each);

#endif
