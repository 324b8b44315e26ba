/* SPDX-License-Identifier: MIT
 *
 * Rays to a TM-25 or an MCPL file, as they come: their number is put into the head in the end.
 */
#ifndef RMAP_RAY_WRITE_H
#define RMAP_RAY_WRITE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"
#include "base/vec.h"
#include "io/rays/ray_file.h"

struct rmap_ray_written {
    struct rmap_vec3 position; /* m */
    struct rmap_vec3 direction;
    double flux; /* W or lm */
    double nm;
    double time_ns;
    uint64_t event; /* RMAP_NO_EVENT: of none */
    uint64_t id; /* in its map: TM-25 has id / 4096 and id modulo 4096 as the columns `portion` and
                 `number`, both exact in float up to 2^36; MCPL's user flags its lower 32 bits */
};

struct rmap_ray_writer;

/* TM25 or MCPL, to a file that can be sought in; borrowed. lumens: flux is in lm; coloured: rays
 * have wavelengths, which MCPL cannot be without. title: of the lamp. RMAP_SYSTEM. */
enum rmap_status rmap_ray_writer_begin(FILE *out, enum rmap_ray_format format, bool lumens,
                                       bool coloured, const char *title,
                                       struct rmap_ray_writer **writer_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
/* Errors of the file are its owner's to find. */
void rmap_ray_writer_add(struct rmap_ray_writer *writer, const struct rmap_ray_written *ray);
/* Completes the head, the file then ends behind the last ray; and releases. RMAP_SYSTEM. */
enum rmap_status rmap_ray_writer_finish(struct rmap_ray_writer *writer,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_writer_destroy(struct rmap_ray_writer *writer); /* without; NULL is fine */

#endif
