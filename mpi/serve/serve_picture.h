/* SPDX-License-Identifier: MIT
 *
 * Answers that commands write as files.
 */
#ifndef RMAP_SERVE_PICTURE_H
#define RMAP_SERVE_PICTURE_H

#include "mpi/serve/serve_state.h"

/* Collective. A name for a file of the `format` that the message asks for, one of `formats`
 * ("svg png"; else the first): *path_ret (rmap_free), its Content-Type *type_ret. RMAP_USAGE: there
 * is no such format. */
enum rmap_status rmap_serve_picture_name(struct rmap_serve *self, const char *formats,
                                         const json_t *message, char **path_ret,
                                         const char **type_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* {"type", "text" or "base64", and what the command printed}; of JSON the document alone. */
enum rmap_status rmap_serve_picture_take(const char *path, const char *type, const json_t *printed,
                                         json_t **result_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Removes the folder that such files were in. */
void rmap_serve_picture_fini(struct rmap_serve *self);

#endif
