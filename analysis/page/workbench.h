/* SPDX-License-Identifier: MIT
 *
 * The files of the workbench, the page that `raymap open` shows: page, style, libraries and
 * scripts, embedded when the program is built.
 */
#ifndef RMAP_WORKBENCH_H
#define RMAP_WORKBENCH_H

struct rmap_workbench_file {
    const char *path; /* as browsers ask for it, "/workbench.js" */
    const char *type; /* Content-Type */
    const char *text; /* ends with a zero byte */
};

/* NULL: there is no such file. */
const struct rmap_workbench_file *rmap_workbench_file(const char *path);

/* What Content-Security-Policy is to say of them. */
extern const char rmap_workbench_policy[];

#endif
