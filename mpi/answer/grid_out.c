/* SPDX-License-Identifier: MIT
 *
 * Numbers over a grid as a file for other programs.
 */
#include "mpi/answer/grid_out.h"

#include "base/alloc.h"
#include "io/export/npy.h"
#include "mpi/command/output.h"

enum rmap_status rmap_grid_write(const struct rmap_grid_array *array, size_t n_array,
                                 const struct rmap_grid_text *text, size_t n_text, const char *path,
                                 struct rmap_error *err)
{
    if (rmap_output_is(path, ".h5"))
        return rmap_grid_h5_write(path, array, n_array, text, n_text, err);
    struct rmap_npy_array *npy = rmap_alloc(n_array + 1, sizeof *npy);
    if (!npy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu arrays", n_array);
    for (size_t i = 0; i < n_array; i++) {
        npy[i] = (struct rmap_npy_array){
            .name = array[i].name, .rank = array[i].rank, .data = array[i].data};
        for (int k = 0; k < array[i].rank; k++)
            npy[i].dims[k] = array[i].dims[k];
    }
    enum rmap_status st = rmap_output_is(path, ".npy") ? rmap_npy_write(&npy[0], path, err)
                                                       : rmap_npz_write(npy, n_array, path, err);
    rmap_free(npy);
    return st;
}
