/* SPDX-License-Identifier: MIT
 *
 * What outputs call a map: they are the same wherever it lies.
 */
#include "mpi/command/map_name.h"

#include <stdio.h>
#include <string.h>

void rmap_map_name(const char *path, char name[RMAP_MAP_NAME_LEN])
{
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/')
        end--;
    size_t begin = end;
    while (begin > 0 && path[begin - 1] != '/')
        begin--;
    (void)snprintf(name, RMAP_MAP_NAME_LEN, "%.*s", (int)(end - begin), path + begin);
}
