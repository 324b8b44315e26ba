/* SPDX-License-Identifier: MIT
 *
 * HDF5 files may say that parts of them lie in other files, of any name: in a stranger's file that
 * could be a secret of the reader's, or a pipe. And that a library is to be loaded for a filter of
 * theirs. Nothing of such is followed.
 */
#ifndef RMAP_H5_INSIDE_H
#define RMAP_H5_INSIDE_H

#include <hdf5.h>

/* 1 where every link of a file leads to an object within it, 0 where not, negative where HDF5
 * fails. Soft links, which may lead to others, count as leading out. */
int rmap_h5_links_inside(hid_t file);

/* Opens the dataset "/group/name", unless the way to it or its data leave the file, or HDF5 has a
 * filter of it not in itself: negative then, as where there is none. */
hid_t rmap_h5_dataset(hid_t file, const char *path);

#endif
