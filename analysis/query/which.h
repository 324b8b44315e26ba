/* SPDX-License-Identifier: MIT
 *
 * Which registrations of the rays that match are counted: those that --which chooses, else those
 * for which a conjunct registered(NAME, REGION where CONDITION) of the criterion holds, else all.
 */
#ifndef RMAP_WHICH_H
#define RMAP_WHICH_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/criterion/criterion_tree.h"

enum rmap_which_from { RMAP_WHICH_OPTION, RMAP_WHICH_WHERE, RMAP_WHICH_ALL };

struct rmap_which {
    enum rmap_which_from from;
    char *text;                     /* "where ghost_order == 2", several joined by "or"; "all" */
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_criterion *criterion; /* of the tests: borrowed, or `own` */
    struct rmap_criterion *own;
    int32_t *test; /* [n_test] nodes: a registration counts where one of them holds */
    size_t n_test;
    uint8_t *chosen_on; /* [n_detector] 0: all registrations on it count */
    uint8_t *asked_on;  /* [n_detector] 1: a conjunct registered(...) of the criterion names it */
    char *remark;       /* for people: a test that chooses rays and looks as if it chose
                           registrations; NULL: none */
    rmap_column_set columns; /* that choosing reads */
    bool chooses;            /* some registrations may not count */
    bool detects;            /* on detectors that detect by chance, those alone that are detected */
    /* Of several criteria: each with what it chooses. */
    size_t n_of;
    struct rmap_which **of;
    const struct rmap_criterion *const *rays; /* [n_of], borrowed, as is the next */
    const double *flux_per_weight;            /* [n_source] */
    /* Of two choices: as the first has it, and the second does, or does not; borrowed. */
    const struct rmap_which *both[2]; /* NULL: not of two */
    bool second_counts;
};

/* Rays, and registrations of theirs; borrowed. */
struct rmap_choice {
    const struct rmap_criterion *criterion; /* NULL: all rays */
    const struct rmap_which *which;         /* NULL: all registrations */
};

/* detector: those asked about, of the scene. text: that of --which, or NULL: as the criterion has
 * it (NULL: all rays), which is borrowed. criteria: what @names in the text stand for, or NULL.
 * RMAP_INPUT: "--which:1:7: error: ...". */
enum rmap_status rmap_which_create(const struct rmap_scene *scene,
                                   const struct rmap_index_set *detector, const char *text,
                                   const struct rmap_criteria *criteria,
                                   const struct rmap_criterion *criterion,
                                   struct rmap_which **which_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Of rays that match any of n criteria (borrowed, as their array is): a registration counts where
 * its ray matches one that has it count. flux_per_weight: as rmap_map_flux_per_weight, borrowed. */
enum rmap_status rmap_which_create_any(const struct rmap_scene *scene,
                                       const struct rmap_index_set *detector,
                                       const struct rmap_criterion *const *criterion, size_t n,
                                       const double *flux_per_weight, struct rmap_which **which_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Registrations that a has count and b does, too; or does not. Both borrowed. */
enum rmap_status rmap_which_create_with(const struct rmap_which *a, const struct rmap_which *b,
                                        bool b_counts, struct rmap_which **which_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
/* From now on, of detectors that detect by chance what they detect counts, alone. detector: those
 * asked about. */
enum rmap_status rmap_which_detect(struct rmap_which *which, const struct rmap_index_set *detector,
                                   struct rmap_error *err) RMAP_MUST_USE;

void rmap_which_destroy(struct rmap_which *which); /* NULL is fine */

/* chosen: [rows of /registration] 1 for those that were registered and count, else 0. The portion
 * has the columns, and rows that add up. Thread-safe. */
enum rmap_status rmap_which_mark(const struct rmap_which *which, const struct rmap_portion *portion,
                                 uint8_t *chosen, struct rmap_error *err) RMAP_MUST_USE;

/* The same where the portion has these columns alone, which may tell (rmap_cursor_tells_of) of
 * others: chosen: [rows] those that surely count; open: [rows] 1 for others that may. */
enum rmap_status rmap_which_bound(const struct rmap_which *which,
                                  const struct rmap_portion *portion, rmap_column_set columns,
                                  uint8_t *chosen, uint8_t *open,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Whether that can be: of several criteria, two choices, or what is detected by chance, it cannot.
 */
bool rmap_which_may_be_bound(const struct rmap_which *which);

/* Some registrations may not count. */
static inline bool rmap_which_chooses(const struct rmap_which *which)
{
    return which && which->chooses;
}

/* {"text": ..., "from": "option", "where" or "all"}; new reference. NULL stands for all. */
json_t *rmap_which_json(const struct rmap_which *which);

/* For people, of both; nothing is said of registrations where all count. criterion: NULL for all
 * rays. A caption "rays: ...; registrations: ..."; a line behind that of the criterion; a line of a
 * table of numbers. */
void rmap_which_caption(const struct rmap_which *which, const char *criterion, char *line,
                        size_t nbytes);
void rmap_which_print(const struct rmap_which *which, FILE *out);
void rmap_which_csv(const struct rmap_which *which, FILE *out);

#endif
