/* SPDX-License-Identifier: MIT
 *
 * The dictionary of paths of a piece being written: which paths stand in it, the classes of their
 * steps, and what the rays that have them have in common.
 */
#ifndef RMAP_COMPACT_PATH_BOOK_H
#define RMAP_COMPACT_PATH_BOOK_H

#include "compact/path_sum.h"
#include "compact/paths.h"

/* The paths that rays of a piece may refer to, as they are appended to it. One per piece; used
 * under the lock that orders the appends. */
enum rmap_status rmap_path_book_create(struct rmap_path_book **book_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_book_destroy(struct rmap_path_book *book);

/* Looks a path up. *reference_ret: 1 + its row in the piece's dictionary, or 0: to be stored with
 * the ray. *added_ret: this path has just been entered, and its rows must be appended. */
enum rmap_status rmap_path_book_find(struct rmap_path_book *book, const uint32_t *word,
                                     uint64_t hash, uint32_t *reference_ret, bool *added_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Enters one that was not found, met before or not; 0: there is no room. Half of the dictionary is
 * left to paths that are met again. */
enum rmap_status rmap_path_book_enter(struct rmap_path_book *book, const uint32_t *word,
                                      uint64_t hash, uint32_t *reference_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Classes of the steps of the paths entered; whoever enters a path adds its own, in order. */
struct rmap_step_classes *rmap_path_book_classes(struct rmap_path_book *book);

/* Sums up the rays of a portion by the paths that were found: path [n_ray] references, length
 * [n_ray] path and optical path. plain: what else discrete questions ask of them is what every ray
 * has (weight 1, ids that follow each other, media as the paths say). */
void rmap_path_book_add(struct rmap_path_book *book, const uint32_t *path,
                        const double (*length)[2], size_t n_ray, bool plain);

/* [paths entered], so far; NULL once a portion was not plain. Paths of few rays are not worth
 * bounds. Borrowed. */
const struct rmap_path_sum *rmap_path_book_sums(struct rmap_path_book *book);

/* A path of this hash will be looked up soon. */
void rmap_path_book_expect(const struct rmap_path_book *book, uint64_t hash);

#endif
