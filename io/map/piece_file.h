/* SPDX-License-Identifier: MIT
 *
 * The file of a piece that an open map lists. One that was being written when the map was opened
 * may have its final name by now: the bytes that its journal told of stand there at the same
 * places.
 */
#ifndef RMAP_PIECE_FILE_H
#define RMAP_PIECE_FILE_H

#include <sys/stat.h>

#include "io/map/map_reader.h"

/* Open for reading: a descriptor, for the caller to close, or -1 with errno. */
int rmap_piece_file_open(const char *map_path, const struct rmap_piece_info *piece) RMAP_MUST_USE;

/* 0, or -1 with errno. */
int rmap_piece_file_stat(const char *map_path, const struct rmap_piece_info *piece,
                         struct stat *info) RMAP_MUST_USE;

#endif
