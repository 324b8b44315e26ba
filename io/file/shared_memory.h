/* SPDX-License-Identifier: MIT
 *
 * Memory that processes of one host read without a copy each. It has no name and goes with the last
 * of them, however they end.
 */
#ifndef RMAP_SHARED_MEMORY_H
#define RMAP_SHARED_MEMORY_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* What another process opens it by. */
struct rmap_shared_place {
    int64_t pid, fd;
    uint64_t device, inode;
};

/* Empty memory, to be written as a file. A file descriptor, which its user closes; -1 where there
 * is no such memory. */
int rmap_shared_memory_create(struct rmap_shared_place *place_ret);

/* Memory of another process, while that has its descriptor. -1 where it is out of reach, as in a
 * container of its own. */
int rmap_shared_memory_open(const struct rmap_shared_place *place);

/* Maps all of it. What this process writes there is its own. *address_ret: munmap. RMAP_SYSTEM. */
enum rmap_status rmap_shared_memory_map(int fd, void **address_ret, size_t *nbytes_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
