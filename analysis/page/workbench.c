/* SPDX-License-Identifier: MIT
 *
 * The files of the workbench.
 */
#include "analysis/page/workbench.h"

#include <string.h>

const char rmap_workbench_policy[] = "default-src 'none'; base-uri 'none'; form-action 'none'; "
                                     "script-src 'self'; style-src 'self'; connect-src 'self'; "
                                     "img-src 'self' data: blob:; frame-ancestors 'none'";

static const struct rmap_workbench_file file[] = {
    {"/", "text/html; charset=utf-8",
     "<!DOCTYPE html><meta charset=\"utf-8\"><title>raymap</title><p>raymap serve\n"},
};

const struct rmap_workbench_file *rmap_workbench_file(const char *path)
{
    for (size_t i = 0; i < sizeof file / sizeof *file; i++)
        if (strcmp(path, file[i].path) == 0)
            return &file[i];
    return NULL;
}
