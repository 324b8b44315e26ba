/* SPDX-License-Identifier: MIT
 *
 * Names that a session gives to criteria (`let NAME = CRITERION`); a later definition of a name
 * takes the place of the earlier one.
 */
#ifndef RMAP_SESSION_DEFINE_H
#define RMAP_SESSION_DEFINE_H

#include "analysis/criterion/criterion_file.h"

/* Adds the definitions of a text to *criteria (NULL: none yet), which it replaces. RMAP_INPUT with
 * a message to print, also when one means nothing in the scene; *criteria is as it was then. */
enum rmap_status rmap_session_define(struct rmap_criteria **criteria, const char *text,
                                     const struct rmap_scene *scene,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
