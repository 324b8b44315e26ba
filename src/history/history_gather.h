/* SPDX-License-Identifier: MIT
 *
 * Classes of segments, of all rays of a portion or of some.
 */
#ifndef RMAP_HISTORY_GATHER_H
#define RMAP_HISTORY_GATHER_H

#include "history/history_index.h"

/* ROWS: a bit for each segment whose class is wanted, borrowed until the next call with this view;
 * one word more may be read. NULL: there are none. wanted: [n_class] bytes, 0 or 1. */
const uint64_t *rmap_history_mark(const struct rmap_history_view *view, const uint8_t *wanted);

/* ROWS: number of the class of each segment, in order. row_class: [n_segment], set. */
void rmap_history_row_classes(const struct rmap_history_view *view, uint16_t *row_class);

/* ROWS: the rays whose bits [words of n_ray] are set; how many. ray has room for them. */
size_t rmap_history_place_rays(const struct rmap_history_view *view, const uint64_t *bits,
                               struct rmap_history_place_of_ray *ray);

/* ROWS: rays side by side: ray [n], ascending. out: its columns segment_count and
 * registration_count [n] and detector, registered and segment of /registration have room for theirs
 * and are set, as are its rows of /ray and /registration; row_class has room for their segments. */
void rmap_history_gather(const struct rmap_history_view *view,
                         const struct rmap_history_place_of_ray *ray, size_t n,
                         struct rmap_portion *out, uint16_t *row_class);

/* Either form: the discrete columns of the portion again, those that `columns` names (the counts
 * always); the others are as they were. out: emptied first, its memory is reused; out->first_ray
 * and n_row are set. RMAP_SYSTEM. */
enum rmap_status rmap_history_unfold(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
