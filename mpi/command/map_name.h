/* SPDX-License-Identifier: MIT
 *
 * What outputs call a map: they are the same wherever it lies.
 */
#ifndef RMAP_MAP_NAME_H
#define RMAP_MAP_NAME_H

/* "lens.raymap" of "out/lens.raymap/". */
#define RMAP_MAP_NAME_LEN 256
void rmap_map_name(const char *path, char name[RMAP_MAP_NAME_LEN]);

#endif
