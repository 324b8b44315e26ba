/* SPDX-License-Identifier: MIT
 *
 * Rays as they decode, against what their portion's row says of them; and the sums of all of them
 * against the index's.
 */
#ifndef RMAP_VERIFY_RAYS_H
#define RMAP_VERIFY_RAYS_H

#include "io/recovery/verify.h"

/* Portion `portion` of self->map, which is there, read through a cursor of all columns: its rays,
 * digest and summary. Adds its rays, if they are good, to the tally (NULL: none). Those known as
 * lost are passed over. */
enum rmap_status rmap_verify_portion(struct rmap_verification *self, struct rmap_cursor *cursor,
                                     size_t portion, struct rmap_tally *tally,
                                     struct rmap_findings *findings,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Sums that the index states: totals, digest, the view of all pieces as one, and, with a tally of
 * all portions (or NULL), the energy balance and images. self->map is there. Uses HDF5. */
enum rmap_status rmap_verify_sums(struct rmap_verification *self, const struct rmap_tally *tally,
                                  struct rmap_findings *findings,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
