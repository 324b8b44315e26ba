/* SPDX-License-Identifier: MIT
 *
 * A portion as one block of bytes that travels between ranks of one program.
 */
#ifndef RMAP_PARCEL_H
#define RMAP_PARCEL_H

#include <stdbool.h>

#include "portion/portion.h"

struct rmap_parcel {
    uint8_t *bytes;
    size_t nbytes;
};

/* Copies all columns of a portion that has them all. */
enum rmap_status rmap_parcel_pack(const struct rmap_portion *portion,
                                  struct rmap_parcel **parcel_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Room for bytes that are to come. */
enum rmap_status rmap_parcel_create(size_t nbytes, struct rmap_parcel **parcel_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_parcel_destroy(struct rmap_parcel *parcel); /* NULL is fine */

/* The portion, its columns lying in the parcel. RMAP_INTERNAL when the bytes are none. */
enum rmap_status rmap_parcel_view(const struct rmap_parcel *parcel, struct rmap_portion *view,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
