/* SPDX-License-Identifier: MIT
 *
 * Paths as text: for people, and as the criterion of exactly these rays.
 */
#ifndef RMAP_PATH_TEXT_H
#define RMAP_PATH_TEXT_H

#include "analysis/paths/path_key.h"

/* "T@lens.1 R@lens.3{2} V@sensor", rmap_free; a medium that shares its name with an object is
 * "A@milk[medium]". Longer than most_nbytes (0: no matter): the middle is
 * left out, as "T@lens.1 ... V@sensor". */
enum rmap_status rmap_path_key_text(const struct rmap_path_keys *keys, const rmap_path_step *symbol,
                                    size_t n, size_t most_nbytes, char **text_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* The same to a text that is there: `most` bytes or some more, as room for it allows. */
void rmap_path_shorten(const char *text, size_t most, char *to, size_t to_nbytes);

/* "lamp: T@lens.1 ...": the steps' text behind their source's name. rmap_free. */
enum rmap_status rmap_path_with_source(const struct rmap_path_keys *keys, int32_t source,
                                       const char *steps, char **text_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* `source(lamp) and path("...")`, or of paths until a detector `source(lamp) and registered(sensor
 * where path("..."))`, rmap_free; true of exactly the rays with this path. A path too
 * long for the criterion language (some 16,000 steps) becomes `ray == only_ray` where it is of one
 * ray alone, else NULL. */
enum rmap_status rmap_path_criterion_of(const struct rmap_path_keys *keys, int32_t source,
                                        const rmap_path_step *symbol, size_t n, uint64_t only_ray,
                                        char **text_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Rays registered on the detector after two reflections that make ghosts, at these labels, and no
 * scatter; rmap_free. */
struct rmap_path_order; /* path_order.h */
enum rmap_status rmap_path_ghost_criterion(const struct rmap_path_keys *keys,
                                           const struct rmap_path_order *order, size_t first,
                                           size_t second, int32_t detector, char **text_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* A name as a criterion wants it: bare, or in single quotes. rmap_free. */
enum rmap_status rmap_path_quote(const char *name, char **text_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
