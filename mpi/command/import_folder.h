/* SPDX-License-Identifier: MIT
 *
 * The folder of an import: what stands there already, and what is left there when it ends.
 */
#ifndef RMAP_IMPORT_FOLDER_H
#define RMAP_IMPORT_FOLDER_H

#include "io/assembly/assembly.h"

enum rmap_import_kind { RMAP_IMPORT_LENS, RMAP_IMPORT_MODEL };

struct rmap_import_folder {
    const char *path; /* the caller's; all else zeroed at the start */
    size_t had;       /* length of the part of the path that was there */
    bool made;
    bool has_model;              /* of an import before this one */
    struct rmap_assembly before; /* it */
};

/* "FOLDER/name"; rmap_free. */
char *rmap_import_path(const char *folder, const char *name);

/* RMAP_USAGE: a file stands there, or an import of the other kind, unless `force`. */
enum rmap_status rmap_import_folder_check(struct rmap_import_folder *place,
                                          enum rmap_import_kind kind, bool force,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* With the folders above it. */
enum rmap_status rmap_import_folder_make(struct rmap_import_folder *place,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Removes what an import of a model wrote there, but texts with edits, once a lens has replaced it.
 */
void rmap_import_folder_replaced(const struct rmap_import_folder *place, bool quiet);

/* st: what the import came to; of one that failed no empty folder stays. */
void rmap_import_folder_fini(struct rmap_import_folder *place, enum rmap_status st);

#endif
