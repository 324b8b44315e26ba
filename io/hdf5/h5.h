/* SPDX-License-Identifier: MIT
 *
 * The little of HDF5 that a map needs, with its error stack turned into rmap_error.
 *
 * A file that failed to write is not touched again, not even closed: HDF5 1.10 crashes in close
 * and exit handlers after a full disk. Every dataset carries units, unitSI, unitDimension and
 * description; those that are read back by the program carry a checksum (XXH3-64) as well.
 */
#ifndef RMAP_H5_H
#define RMAP_H5_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "io/hdf5/h5_unit.h"
#include "portion/columns.h"

struct rmap_h5 {
    hid_t file;
    char *path;                /* for messages */
    enum rmap_status on_error; /* RMAP_SYSTEM when writing, RMAP_FORMAT when reading */
    bool failed;               /* while writing: hands off from now on */
};

/* Unit of a column in a scene whose length unit is `length` of `length_m` metres. */
struct rmap_h5_unit rmap_h5_unit_of(enum rmap_unit unit, const char *length, double length_m);

#define RMAP_H5_RANK_MAX 3

struct rmap_h5_array {
    const char *path; /* "/group/name" */
    enum rmap_element element;
    int rank;
    hsize_t dims[RMAP_H5_RANK_MAX];
    struct rmap_h5_unit unit;
    const char *description;
};

/* The file that `path` names is made anew (earliest format, no time stamps, strict close), and
 * must not exist. RMAP_SYSTEM. */
enum rmap_status rmap_h5_create(struct rmap_h5 *h5, const char *path,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Opens for reading, if the file's seal holds. RMAP_FORMAT when it does not, or HDF5 cannot. */
enum rmap_status rmap_h5_open(struct rmap_h5 *h5, const char *path,
                              struct rmap_error *err) RMAP_MUST_USE;

/* Flushes and closes a written file. */
enum rmap_status rmap_h5_close(struct rmap_h5 *h5, struct rmap_error *err) RMAP_MUST_USE;

/* Lets go of a file without a word: read, failed or abandoned. Zeroed: fine. */
void rmap_h5_drop(struct rmap_h5 *h5);

/* Writes the text of HDF5's innermost error, and latches `failed` of a file being written. */
enum rmap_status rmap_h5_fail(struct rmap_h5 *h5, const char *what, struct rmap_error *err);

/* RMAP_SYSTEM for a file whose writing failed earlier: its handles are not touched again. */
enum rmap_status rmap_h5_check_alive(struct rmap_h5 *h5, struct rmap_error *err);

hid_t rmap_h5_type(enum rmap_element element); /* in the file: little-endian */

enum rmap_status rmap_h5_group(struct rmap_h5 *h5, const char *path,
                               struct rmap_error *err) RMAP_MUST_USE;

/* One column of a table held as structs: `width` numbers at `offset` of each. */
struct rmap_h5_field {
    const char *path;
    enum rmap_element element;
    size_t width;
    size_t offset;
    const char *description;
};

/* ---- reading ---- */

#endif
