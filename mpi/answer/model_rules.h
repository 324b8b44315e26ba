/* SPDX-License-Identifier: MIT
 *
 * Rules of a user that a new revision of a model makes doubtful.
 */
#ifndef RMAP_MODEL_RULES_H
#define RMAP_MODEL_RULES_H

#include "io/assembly/assembly_match.h"

enum { RMAP_MODEL_RULE_FILES = 2 }; /* attributes.yaml and scene.yaml */

/* Warns, with their lines, of rules that name faces by number on parts whose shape has changed:
 * findings[k] of each file, for rmap_diagnostics_fini in any case. RMAP_SYSTEM. */
enum rmap_status rmap_model_check_rules(const char *folder, const struct rmap_assembly *before,
                                        const struct rmap_assembly *after,
                                        const struct rmap_assembly_match *match,
                                        struct rmap_diagnostics findings[RMAP_MODEL_RULE_FILES],
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
