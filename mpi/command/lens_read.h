/* SPDX-License-Identifier: MIT
 *
 * A lens file with its glass catalogues, and the scene that is made of it.
 */
#ifndef RMAP_LENS_READ_H
#define RMAP_LENS_READ_H

#include <limits.h>

#include "io/lensfile/lens_layout.h"
#include "mpi/command/arguments.h"

enum { RMAP_LENS_CATALOGUES_MAX = 32 };

struct rmap_lens_import {
    const char *path;
    const char *scene; /* where the text is to stand */
    const struct rmap_arguments *given;
    struct rmap_prescription lens;
    struct rmap_lens_plan plan;
    struct rmap_diagnostics findings;
    char *text; /* of the scene; free() */
    size_t text_nbytes;
    size_t n_beside;
    char beside[RMAP_LENS_CATALOGUES_MAX][NAME_MAX + 1]; /* in the lens file's folder */
};

void rmap_lens_import_init(struct rmap_lens_import *import, const char *path, const char *scene,
                           const struct rmap_arguments *given);
void rmap_lens_import_fini(struct rmap_lens_import *import);

/* The name of the lens file without its folder. */
const char *rmap_lens_import_name(const struct rmap_lens_import *import);

/* Makes plan and text of configuration k (from 1; 0: the one that is stored). What the reader of
 * scenes refuses is made plainer, and told. RMAP_USAGE, RMAP_INPUT, RMAP_SYSTEM. */
enum rmap_status rmap_lens_import_read(struct rmap_lens_import *import, int k,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
