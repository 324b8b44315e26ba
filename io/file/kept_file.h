/* SPDX-License-Identifier: MIT
 *
 * What was made of a file and is kept of it for later starts, in a folder that may be deleted at
 * any time. The file and how it was read name the one that keeps it, so that what a changed file
 * leaves there is written over; whether it is of the bytes that are there now, of this program and
 * undamaged says what is in it: a head (kept_file.c), and the body.
 */
#ifndef RMAP_KEPT_FILE_H
#define RMAP_KEPT_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Smaller files are read as fast as what is kept of them. */
#define RMAP_KEPT_LEAST ((size_t)64 << 10)

struct rmap_kept {
    char *path;      /* of the file that keeps it */
    uint64_t key[2]; /* of the bytes that it was made of, and of the program */
};

/* Of the bytes of the file at `path`; how: all else that it depends on; ending: ".mesh".
 * RMAP_SYSTEM. Zero-initialise, fini in any case. */
enum rmap_status rmap_kept_init(struct rmap_kept *kept, const char *folder, const char *path,
                                const char *how, const char *ending, const void *bytes,
                                size_t nbytes, struct rmap_error *err) RMAP_MUST_USE;
void rmap_kept_fini(struct rmap_kept *kept);

/* *bytes_ret, rmap_free: the file, whose body stands at *body_ret. It stays NULL where nothing is
 * kept, or of another state. RMAP_FORMAT: what is there is damaged, or something else; RMAP_SYSTEM.
 */
enum rmap_status rmap_kept_read(const struct rmap_kept *kept, uint8_t **bytes_ret,
                                const uint8_t **body_ret, size_t *nbytes_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* In place of what is there; makes the folder. RMAP_USAGE, RMAP_SYSTEM: it cannot be written. */
enum rmap_status rmap_kept_write(const struct rmap_kept *kept, const uint8_t *body, size_t nbytes,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
