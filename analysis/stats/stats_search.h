/* SPDX-License-Identifier: MIT
 *
 * Where shares of the flux are reached. The fine histogram says in which of its bins; with the
 * readings in memory, those of the few bins of interest are listed and tell it exactly;
 * without, it is interpolated in the bin.
 */
#ifndef RMAP_STATS_SEARCH_H
#define RMAP_STATS_SEARCH_H

#include "analysis/stats/stats.h"
#include "analysis/stats/stats_items.h"
#include "analysis/stats/stats_levels.h"
#include "analysis/stats/stats_windows.h"

/* A fine bin that is of interest: what is in it. */
struct rmap_stats_list {
    size_t bin;   /* group * n_fine + place */
    double place; /* among the bins of the group */
    double least, greatest;
};

/* Items of a list stand in so many parts, each of a part of its bin. */
enum { RMAP_STATS_PARTS = 32 };

struct rmap_stats_found {
    union {
        const double *at; /* first: where it is read from */
        double value;
    };
    double weight;
    uint32_t source;
    uint32_t part; /* list * RMAP_STATS_PARTS + part */
};

/* What a thread found. */
struct rmap_stats_findings_share {
    struct rmap_stats_found *found; /* [n] */
    size_t n, cap;
    enum rmap_status status;
    struct rmap_error error;
};

struct rmap_stats_findings {
    struct rmap_stats_findings_share *share; /* [n] */
    size_t n;
};

/* One quantity of all groups. All but what it allocates is borrowed. */
struct rmap_stats_search {
    const struct rmap_stats *stats;
    const struct rmap_stats_sums *sums;
    const struct rmap_stats_gathered *gathered; /* no parts: readings are not in memory */
    bool in_memory;
    int n_thread; /* that look for readings, at most */
    size_t quantity;
    struct rmap_stats_levels levels;
    int32_t *of_bin;                    /* [n_group][n_fine] list, -1: of no interest */
    struct rmap_stats_windows *windows; /* [n_group] over the bins with a list */
    struct rmap_stats_list *list;
    size_t n_list, list_cap, n_filled;
    struct rmap_stats_findings findings;
    struct rmap_stats_item *item; /* all that were found */
    size_t *first; /* [n_filled * RMAP_STATS_PARTS + 1] of the items of a part; the end of all */
};

/* The caller has set what is borrowed. */
enum rmap_status rmap_stats_search_init(struct rmap_stats_search *search,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_search_fini(struct rmap_stats_search *search);

/* Every fine bin is that of one whole number. */
bool rmap_stats_search_is_whole(const struct rmap_stats_search *search);

/* Says that shares p [n_group][n] will be looked for; NaN is none. */
enum rmap_status rmap_stats_search_want(struct rmap_stats_search *search, const double *p, size_t n,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Lists the readings wanted, unless they are. */
enum rmap_status rmap_stats_search_fill(struct rmap_stats_search *search,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Least value with a share p of the group's flux at or below it; interpolated where its bin is not
 * listed. weight: [n_source] scratch. */
double rmap_stats_search_at(const struct rmap_stats_search *search, size_t g, double p,
                            double *weight);

/* Weight of a class at or below a value: of its bin, all where that is not listed. */
double rmap_stats_search_below(const struct rmap_stats_search *search, size_t class, double value);

#endif
