/* SPDX-License-Identifier: MIT
 *
 * Rays from files of their makers, as docs/scene.md describes them: TM-25, LightTools text, CSV,
 * HDF5 and MCPL.
 */
#ifndef RMAP_RAY_FILE_H
#define RMAP_RAY_FILE_H

#include <stdio.h>

#include "scene/file_rays.h"

enum rmap_ray_format {
    RMAP_RAYS_TM25,       /* .tm25ray, .tm25: ANSI/IES TM-25-13 and -20 */
    RMAP_RAYS_LIGHTTOOLS, /* .ray */
    RMAP_RAYS_CSV,        /* .csv, .txt */
    RMAP_RAYS_HDF5,       /* .h5, .hdf5 */
    RMAP_RAYS_MCPL        /* .mcpl, versions 2 and 3 */
};

/* By the end of the name, in any case, before .gz; false: by none. */
bool rmap_ray_format_of(const char *path, enum rmap_ray_format *format_ret);

struct rmap_ray_wanted {
    const char *detector; /* HDF5 of a query: rays as they crossed this one; NULL: the only one */
    bool steps;           /* of charged particles, in place of rays: CSV, HDF5, MCPL */
    size_t n_passed_over; /* set: MCPL's particles that are no photons */
};

/* The whole file, which is regular; one that is packed by gzip (but HDF5) is unpacked. RMAP_INPUT
 * with the line or row and what is wrong there, the text names the path; RMAP_SYSTEM. */
enum rmap_status rmap_ray_file_read(const char *path, enum rmap_ray_format format,
                                    struct rmap_ray_wanted *wanted, struct rmap_file_rays **set_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* The same of an open file of nbytes, but HDF5's; numbers of text are read in the calling thread's
 * locale, which has a point. Rows are not checked yet. */
enum rmap_status rmap_ray_stream_read(FILE *in, uint64_t nbytes, enum rmap_ray_format format,
                                      struct rmap_ray_wanted *wanted,
                                      struct rmap_file_rays **set_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
