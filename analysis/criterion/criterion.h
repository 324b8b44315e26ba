/* SPDX-License-Identifier: MIT
 *
 * The criterion language: one text that selects rays by their whole histories. Compiled against a
 * scene's names into a typed tree; nothing is read before the whole of it is understood.
 */
#ifndef RMAP_CRITERION_H
#define RMAP_CRITERION_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "portion/portion.h"
#include "scene/scene.h"

struct rmap_criterion;

/* RMAP_INPUT with err->text ready to print: "criterion:1:16: error: ...\n  text\n     ^~~~".
 * The scene is borrowed and must outlive the criterion. */
enum rmap_status rmap_criterion_compile(const char *text, const struct rmap_scene *scene,
                                        struct rmap_criterion **criterion_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The same where @names stand for definitions (criterion_file.h), which only the call needs; NULL:
 * there are none. A mistake in a definition is reported with its own place, "FILE:LINE:COLUMN". */
struct rmap_criteria;
enum rmap_status rmap_criterion_compile_with(const char *text, const struct rmap_criteria *criteria,
                                             const struct rmap_scene *scene,
                                             struct rmap_criterion **criterion_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_criterion_destroy(struct rmap_criterion *criterion);
const char *rmap_criterion_text(const struct rmap_criterion *criterion);

/* NAME of a criterion that is @NAME and nothing else; NULL of any other. */
const char *rmap_criterion_name(const struct rmap_criterion *criterion);

/* Columns that evaluation needs. */
rmap_column_set rmap_criterion_columns(const struct rmap_criterion *criterion);

/* Whether a time that it compares is the phase path / c, since the scene is not timed. */
bool rmap_criterion_of_phase_time(const struct rmap_criterion *criterion);
#define RMAP_PHASE_TIME_HINT                                                                       \
    "'time' is the optical path (of the phase) / c here: times of arrival, by group index and "    \
    "with delays, need a map traced with 'time: on' (raymap trace --time on)"

/* Whether it compares ids of rays, or asks for rays that the map keeps. */
bool rmap_criterion_of_ids(const struct rmap_criterion *criterion);

/* False when a portion with this summary cannot hold a match. */
bool rmap_criterion_may_match(const struct rmap_criterion *criterion,
                              const struct rmap_portion_summary *summary);

/* Marks the rays of a portion: match[i] = 1 or 0 for row i of /ray. The portion has at least the
 * criterion's columns. flux_per_weight: [n_source], as rmap_map_flux_per_weight. Thread-safe. */
enum rmap_status rmap_criterion_evaluate(const struct rmap_criterion *criterion,
                                         const struct rmap_portion *portion,
                                         const double *flux_per_weight, uint8_t *match,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
