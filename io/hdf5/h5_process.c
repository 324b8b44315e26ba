/* SPDX-License-Identifier: MIT
 *
 * HDF5 as a process has it.
 */
#include "io/hdf5/h5_process.h"

#include <hdf5.h>

void rmap_h5_own_process(void)
{
    (void)H5dont_atexit();
}

struct rmap_h5_printing rmap_h5_printing_get(void)
{
    struct rmap_h5_printing printing = {0};
    (void)H5Eget_auto2(H5E_DEFAULT, &printing.print, &printing.data);
    return printing;
}

void rmap_h5_printing_set(struct rmap_h5_printing printing)
{
    (void)H5Eset_auto2(H5E_DEFAULT, printing.print, printing.data);
}
