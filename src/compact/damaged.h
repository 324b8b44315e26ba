/* SPDX-License-Identifier: MIT */
#ifndef RMAP_COMPACT_DAMAGED_H
#define RMAP_COMPACT_DAMAGED_H

#include "base/status.h"

/* RMAP_FORMAT, of the rows of a portion. */
static inline enum rmap_status rmap_portion_damaged(const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "damaged portion: %s", what);
}

#endif
