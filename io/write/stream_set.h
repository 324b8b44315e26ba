/* SPDX-License-Identifier: MIT
 *
 * The dataset of a stream in a file that is being written: it takes ready chunks.
 */
#ifndef RMAP_STREAM_SET_H
#define RMAP_STREAM_SET_H

#include "compact/layout.h"
#include "io/hdf5/h5.h"
#include "io/map/map_content.h"

/* An empty one, for H5Dclose. */
enum rmap_status rmap_stream_set_create(struct rmap_h5 *h5, const struct rmap_stream_info *info,
                                        const struct rmap_scene *scene, hid_t *set_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Stores chunk `index`, after which the stream has n_row rows. entry: where it lies, for the table
 * of chunks, as of stream `number`. */
enum rmap_status rmap_stream_set_put(struct rmap_h5 *h5, hid_t set,
                                     const struct rmap_stream_info *info, int n_channel, int number,
                                     uint32_t index, uint64_t n_row, const uint8_t *stored,
                                     size_t nbytes, struct rmap_chunk_entry *entry,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
