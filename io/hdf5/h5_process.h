/* SPDX-License-Identifier: MIT
 *
 * HDF5 as a process has it, which may be another's that only reads maps.
 */
#ifndef RMAP_H5_PROCESS_H
#define RMAP_H5_PROCESS_H

#include <stdint.h>

/* To be called before anything else of HDF5 by who owns the process: after a full disk HDF5's own
 * exit handler crashes, so there is none. */
void rmap_h5_own_process(void);

/* Where HDF5 prints errors of the calling thread, which reading a map switches off. */
struct rmap_h5_printing {
    int (*print)(int64_t stack, void *data);
    void *data;
};
struct rmap_h5_printing rmap_h5_printing_get(void);
void rmap_h5_printing_set(struct rmap_h5_printing printing);

#endif
