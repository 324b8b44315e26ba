/* SPDX-License-Identifier: MIT
 *
 * The files of the workbench.
 */
#include "analysis/page/workbench.h"

#include <stddef.h>
#include <string.h>

#include "analysis/page/page_asset.h"

const char rmap_workbench_policy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const struct rmap_workbench_file *rmap_workbench_file(const char *path)
{
    static const struct rmap_workbench_file file[] = {
        {"/", "text/html; charset=utf-8", rmap_workbench_asset_html},
        {"/workbench.css", "text/css; charset=utf-8", rmap_workbench_asset_style},
        {"/library.js", "text/javascript; charset=utf-8", rmap_workbench_asset_library},
        {"/workbench.js", "text/javascript; charset=utf-8", rmap_workbench_asset_script},
    };
    for (size_t i = 0; i < sizeof file / sizeof *file; i++)
        if (strcmp(path, file[i].path) == 0)
            return &file[i];
    return NULL;
}
