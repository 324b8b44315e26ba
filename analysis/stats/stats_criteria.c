/* SPDX-License-Identifier: MIT
 *
 * Statistics of what several criteria pick.
 */
#include "analysis/stats/stats_criteria.h"

#include <string.h>

#include "analysis/criterion/criterion.h"
#include "analysis/query/which.h"
#include "base/alloc.h"

const char *rmap_stats_criterion_name(const struct rmap_stats_criteria *criteria, size_t k)
{
    const char *name = rmap_criterion_name(criteria->of[k]);
    return name ? name : rmap_criterion_text(criteria->of[k]);
}

rmap_column_set rmap_stats_criteria_columns(const struct rmap_stats_criteria *criteria)
{
    rmap_column_set columns = 0;
    for (size_t k = 0; k < criteria->n; k++)
        columns |= rmap_criterion_columns(criteria->of[k]) |
                   (criteria->which ? criteria->which[k]->columns : 0);
    return columns;
}

void rmap_stats_held_fini(struct rmap_stats_held *held)
{
    rmap_free(held->held);
    rmap_free(held->match);
    rmap_free(held->chosen);
    *held = (struct rmap_stats_held){0};
}

enum rmap_status rmap_stats_criteria_hold(const struct rmap_stats_criteria *criteria,
                                          const struct rmap_portion *portion,
                                          const struct rmap_readings *readings, bool their_rows,
                                          struct rmap_stats_held *held, size_t *n_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_row = portion->n_row[RMAP_TABLE_REGISTRATION];
    size_t n = 0;
    RMAP_TRY(RMAP_RESERVE(held->held, held->held_cap, readings->n + 1, err));
    RMAP_TRY(RMAP_RESERVE(held->match, held->match_cap, portion->n_row[RMAP_TABLE_RAY] + 1, err));
    RMAP_TRY(RMAP_RESERVE(held->chosen, held->chosen_cap, n_row + 1, err));
    memset(held->held, 0, readings->n * sizeof *held->held);
    for (size_t k = 0; k < criteria->n; k++) {
        const struct rmap_which *which = their_rows && criteria->which ? criteria->which[k] : NULL;
        RMAP_TRY(rmap_criterion_evaluate(criteria->of[k], portion, criteria->flux_per_weight,
                                         held->match, err));
        if (which)
            RMAP_TRY(rmap_which_mark(which, portion, held->chosen, err));
        for (size_t r = 0; r < readings->n; r++) {
            const uint64_t is_held =
                held->match[readings->ray[r]] & (which ? held->chosen[readings->place[r]] : 1);
            held->held[r] |= is_held << k;
            n += is_held;
        }
    }
    *n_ret = n;
out:
    return st;
}
