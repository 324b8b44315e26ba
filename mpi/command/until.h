/* SPDX-License-Identifier: MIT
 *
 * --until: answers from the first rays of a map, as many as make them exact enough. The first
 * 65,536 are asked, then twice as many, and so on, so that the same question has the same answer.
 */
#ifndef RMAP_UNTIL_H
#define RMAP_UNTIL_H

#include "io/map/map_cut.h"
#include "mpi/command/arguments.h"

#define RMAP_UNTIL_OPTION                                                                          \
    {                                                                                              \
        "until", 0, "P%",                                                                          \
            "ask the first rays, and more until the standard error is P % of the answer"           \
    }

struct rmap_until {
    struct rmap_map_part part;
    struct rmap_map_cut cut;
    size_t n_portion;
};

/* "1%", "0.5 %" or "0.01". RMAP_USAGE. */
enum rmap_status rmap_until_read(const struct rmap_arguments *given, struct rmap_until *until,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Where it is asked for, the map is the first part of itself from begin to fini; all of it where
 * the answer is of_ids, for which the first rays are no sample. To be called alike on all ranks. */
enum rmap_status rmap_until_begin(struct rmap_until *until, struct rmap_map *map, bool of_ids,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_until_fini(struct rmap_until *until);

/* Takes note of an answer, and makes the part larger. False: it was the last one, as it was exact
 * enough, or there is no more. */
bool rmap_until_goes_on(struct rmap_until *until, bool is_exact);

/* Whether an error is small enough, as against a value. */
bool rmap_until_suffices(const struct rmap_until *until, double value, double standard_error);

#endif
