/* SPDX-License-Identifier: MIT
 *
 * glTF 2.0 files (Khronos Group, "glTF 2.0 Specification", 2021): the JSON document and the numbers
 * that its accessors stand for. Every place and count is checked against the bytes that are there.
 */
#ifndef RMAP_GLTF_NUMBERS_H
#define RMAP_GLTF_NUMBERS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* A mesh and the files it names together; assimp and we hold them in memory. */
#define RMAP_MESH_NBYTES_MAX ((size_t)16 << 30)

struct rmap_gltf {
    json_t *root;
    const char *path; /* borrowed, as is what it holds */
    const uint8_t *body;
    size_t body_nbytes;               /* of the binary chunk */
    struct rmap_gltf_buffer *buffer;  /* [n_buffer], filled when first asked for */
    size_t n_buffer, nbytes, charged; /* bytes held, and what was made of them */
    bool elsewhere;                   /* buffers stand in files of their own */
    struct rmap_error *err;
};

/* Values of an accessor, one behind the other; zero-initialise, rmap_free(value). */
struct rmap_gltf_numbers {
    double *value;
    size_t n, cap; /* n: elements, of `n_component` values each */
};

/* The document within a file that was read. All below: RMAP_INPUT, without the path, where the file
 * is not as glTF wants it; RMAP_SYSTEM. Call rmap_gltf_fini in any case. */
enum rmap_status rmap_gltf_init(struct rmap_gltf *gltf, const char *path, const uint8_t *bytes,
                                size_t nbytes, struct rmap_error *err) RMAP_MUST_USE;
void rmap_gltf_fini(struct rmap_gltf *gltf);

/* Counts n vertices, corners, parts or letters that a file unfolds to: no more than 10 million, and
 * 16 for each of its bytes. */
enum rmap_status rmap_gltf_charge(struct rmap_gltf *gltf, size_t n) RMAP_MUST_USE;

/* The accessor's elements, of n_component values each (1 to 3), charged. */
enum rmap_status rmap_gltf_numbers(struct rmap_gltf *gltf, size_t accessor, size_t n_component,
                                   struct rmap_gltf_numbers *numbers) RMAP_MUST_USE;

/* The object's number in [0, 2^53]; `missing` where it has none. False where it is none. */
bool rmap_gltf_count(const json_t *object, const char *key, size_t missing, size_t *count);

/* RMAP_INPUT, and why. */
enum rmap_status rmap_gltf_refuse(const struct rmap_gltf *gltf, const char *format, ...)
    RMAP_PRINTF(2, 3);

#endif
