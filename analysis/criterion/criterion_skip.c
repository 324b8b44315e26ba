/* SPDX-License-Identifier: MIT
 *
 * Which portions a criterion can skip, by their summaries and ids.
 */
#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_tree.h"
#include "io/map/map_reader.h"

/* What a portion's rays can be: some true, some false, or (both) unknown. */
struct possible {
    bool yes, no;
};

static struct possible possible_count(const struct rmap_interval *interval, bool zero, bool one)
{
    bool zero_holds = rmap_interval_holds(interval, 0.0);
    bool one_holds = rmap_interval_holds(interval, 1.0);
    return (struct possible){(zero && zero_holds) || (one && one_holds),
                             (zero && !zero_holds) || (one && !one_holds)};
}

static bool share_objects(const uint64_t a[4], const uint64_t b[4])
{
    return ((a[0] & b[0]) | (a[1] & b[1]) | (a[2] & b[2]) | (a[3] & b[3])) != 0;
}

static struct possible possible_rows(const struct rmap_interval *interval, bool any)
{
    return any ? (struct possible){true, true} : possible_count(interval, true, false);
}

static struct possible possible_leaf(const struct rmap_criterion *criterion,
                                     const struct rmap_criterion_node *node,
                                     const struct rmap_portion_summary *summary)
{
    switch (node->kind) {
    case RMAP_CRITERION_ALL:
        return possible_count(&node->interval, false, true);
    case RMAP_CRITERION_SOURCE: {
        bool exact = criterion->scene->n_source <= 64;
        return possible_count(&node->interval, !exact || summary->sources & ~node->source_bits,
                              summary->sources & node->source_bits);
    }
    case RMAP_CRITERION_ENDED: {
        const struct rmap_ending_test *test = &node->ending;
        bool one = summary->stops >> test->stop & 1 &&
                   (!test->somewhere || test->medium.span ||
                    share_objects(summary->objects, test->object_bits));
        return possible_count(&node->interval,
                              test->somewhere || summary->stops & ~(1u << test->stop), one);
    }
    case RMAP_CRITERION_STEPS: {
        const struct rmap_step_test *test = &node->steps;
        return possible_rows(
            &node->interval,
            (!test->of_object || share_objects(summary->objects, test->object_bits)) &&
                (!test->events || summary->events & test->events));
    }
    case RMAP_CRITERION_REGISTRATIONS:
        return possible_rows(&node->interval,
                             summary->detectors & node->registrations.detector_bits);
    default:
        return (struct possible){true, true};
    }
}

static struct possible possible_of(const struct rmap_criterion *criterion, int32_t index,
                                   const struct rmap_portion_summary *summary)
{
    const struct rmap_criterion_node *node = &criterion->node[index];
    bool is_and = node->kind == RMAP_CRITERION_AND;
    if (!is_and && node->kind != RMAP_CRITERION_OR && node->kind != RMAP_CRITERION_NOT)
        return possible_leaf(criterion, node, summary);
    struct possible own = {is_and, !is_and};
    for (int32_t child = node->first; child >= 0; child = criterion->node[child].next) {
        struct possible its = possible_of(criterion, child, summary);
        if (node->kind == RMAP_CRITERION_NOT)
            return (struct possible){its.no, its.yes};
        own.yes = is_and ? own.yes && its.yes : own.yes || its.yes;
        own.no = is_and ? own.no || its.no : own.no && its.no;
    }
    return own;
}

bool rmap_criterion_may_match(const struct rmap_criterion *criterion,
                              const struct rmap_portion_summary *summary)
{
    return possible_of(criterion, criterion->root, summary).yes;
}

static bool may_hold(const struct rmap_criterion *criterion, int32_t index, uint64_t first,
                     uint64_t last)
{
    const struct rmap_criterion_node *node = &criterion->node[index];
    bool is_and = node->kind == RMAP_CRITERION_AND;
    if (node->kind == RMAP_CRITERION_NUMBER && node->ray_number == RMAP_RAY_NUMBER_ID &&
        !node->interval.outside)
        return first <= node->id_high && last >= node->id_low;
    if (node->kind == RMAP_CRITERION_NUMBER && node->ray_number == RMAP_RAY_NUMBER_EVENT &&
        !node->interval.outside)
        return first <= node->ray_high && last >= node->ray_low;
    if (node->kind == RMAP_CRITERION_RAYS)
        return rmap_id_set_meets(node->rays, first, last);
    if (!is_and && node->kind != RMAP_CRITERION_OR)
        return true;
    bool own = is_and;
    for (int32_t child = node->first; child >= 0 && own == is_and;
         child = criterion->node[child].next)
        own = may_hold(criterion, child, first, last);
    return own;
}

bool rmap_criterion_may_hold(const struct rmap_criterion *criterion, uint64_t first, uint64_t last)
{
    return may_hold(criterion, criterion->root, first, last);
}

bool rmap_criterion_skips(const struct rmap_criterion *criterion,
                          const struct rmap_portion_info *portion)
{
    const uint64_t end = rmap_portion_end(portion);
    return !rmap_criterion_may_hold(criterion, portion->first_ray,
                                    end > portion->first_ray ? end - 1 : UINT64_MAX) ||
           !rmap_criterion_may_match(criterion, &portion->summary);
}
