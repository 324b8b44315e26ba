/* SPDX-License-Identifier: MIT
 *
 * A small ray map in memory whose values can be changed one by one, every checksum and seal behind
 * them made right again: what a stranger could write who knows the format. HDF5's own structures
 * stay as they are, for HDF5 1.10 cannot be defended against those (docs/security.md).
 */
#ifndef RMAP_MAP_IMAGE_H
#define RMAP_MAP_IMAGE_H

#include <stddef.h>
#include <stdint.h>

enum { MAP_IMAGE_FILES = 8, MAP_IMAGE_FIELDS = 700 };

struct map_image_file {
    char name[64];  /* from the map's directory on */
    uint8_t *bytes; /* as changed; room for `cap` */
    uint8_t *whole; /* as written */
    size_t nbytes, whole_nbytes, cap;
    size_t body_nbytes; /* of `whole`, without its seal */
    int changed, on_disk_differs;
};

/* Numbers of one kind in a file: a dataset of a table, or an attribute of the root. */
struct map_image_field {
    int file;
    char name[64];
    size_t offset, n, element_nbytes;
    size_t sum_at; /* of its checksum in the file; 0: none */
};

struct map_image {
    char directory[64]; /* of the test; removed by map_image_fini */
    char path[96];      /* of the map to read */
    int n_file;
    struct map_image_file file[MAP_IMAGE_FILES]; /* 0: map.h5 */
    int n_field;
    struct map_image_field field[MAP_IMAGE_FIELDS];
};

/* Takes the map that stands at image->path; aborts where that fails. */
void map_image_load(struct map_image *image);
void map_image_fini(struct map_image *image);

/* Back to how it was written. */
void map_image_reset(struct map_image *image);

/* Number of an index field, by name; -1: none. */
int map_image_field(const struct map_image *image, const char *name);
uint64_t map_image_get(const struct map_image *image, int field, size_t element);
void map_image_set(struct map_image *image, int field, size_t element, uint64_t value);

/* Chunk k of the index's table: its bytes changed at `at` to `value`, checksums made right; or its
 * decoded number `row` set to `value` and the chunk encoded anew. */
void map_image_poke_chunk(struct map_image *image, size_t k, size_t at, uint8_t value);
void map_image_set_in_chunk(struct map_image *image, size_t k, size_t row, uint64_t value);

/* Cuts a file (not the index) to nbytes, and tells the index so. */
void map_image_cut(struct map_image *image, int file, size_t nbytes);

/* Seals anew and writes to disk what differs from what is there. */
void map_image_store(struct map_image *image);

#endif
