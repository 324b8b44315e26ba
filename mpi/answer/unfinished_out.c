/* SPDX-License-Identifier: MIT
 *
 * What killed writers left in a map, as `info` and `verify` tell of it.
 */
#include "mpi/answer/unfinished_out.h"

json_t *rmap_unfinished_json(const struct rmap_findings *files)
{
    json_t *list = json_array();
    for (size_t i = 0; i < files->n; i++)
        (void)json_array_append_new(
            list, json_pack("{s:s, s:s}", "file", files->row[i].file, "text", files->row[i].text));
    return list;
}

void rmap_unfinished_print(const struct rmap_findings *files, FILE *out)
{
    for (size_t i = 0; i < files->n; i++)
        fprintf(out, "  unfinished %s: %s\n", files->row[i].file, files->row[i].text);
}
