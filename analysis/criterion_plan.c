/* SPDX-License-Identifier: MIT
 *
 * What a criterion will need: columns, an order of evaluation, and which portions it can skip.
 */
#include <math.h>

#include "analysis/criterion_tree.h"
#include "trace/event.h"

/* Relative cost of evaluating a node, cheapest first. */
enum cost { COST_NONE, COST_RAY, COST_REGISTRATION, COST_STEP, COST_PATH, COST_GEOMETRY, COST_CLASSES };

/* Bits (index mod n_bit) of a set's members. */
static void set_bits(const struct rmap_index_set *set, uint64_t *bits, uint32_t n_bit)
{
    for (uint32_t i = 0; i < set->span; i++)
        if (!set->member || set->member[i]) {
            uint32_t bit = ((uint32_t)set->low + i) % n_bit;
            bits[bit / 64] |= (uint64_t)1 << bit % 64;
        }
}

static enum cost plan_steps(struct rmap_criterion *criterion, struct rmap_step_test *test)
{
    const struct rmap_scene *scene = criterion->scene;
    enum cost cost = COST_STEP;
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    set_bits(&test->object, test->object_bits, 256);
    if (test->of_object)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_object);
    if (test->events | test->events_not)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_event);
    if (test->of_medium || test->side)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    if (test->part != RMAP_PART_ALL)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive);
    for (size_t o = 0; test->side && o < scene->n_object; o++)
        if ((test->side[o] == 1 || test->side[o] == 2) &&
            !rmap_object_medium_tells(&scene->object[o])) {
            columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_position) |
                       RMAP_COLUMN_BIT(RMAP_SEGMENT_normal) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
                       RMAP_COLUMN_BIT(RMAP_RAY_start);
            cost = COST_GEOMETRY;
        }
    criterion->columns |= columns;
    return cost;
}

static rmap_column_set its_number_columns(enum rmap_registration_number number)
{
    switch (number) {
    case RMAP_REGISTRATION_ANGLE:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction);
    case RMAP_REGISTRATION_X:
    case RMAP_REGISTRATION_Y:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    case RMAP_REGISTRATION_TIME:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path);
    }
    return 0;
}

static void plan_registrations(struct rmap_criterion *criterion,
                               struct rmap_registration_test *test)
{
    set_bits(&test->detector, &test->detector_bits, 64);
    criterion->columns |=
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    if (!test->crossed)
        criterion->columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    if (test->region == RMAP_REGION_CELLS)
        criterion->columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell);
    else if (test->region != RMAP_REGION_ALL)
        criterion->columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
}

static void plan_ending(struct rmap_criterion *criterion, struct rmap_ending_test *test)
{
    set_bits(&test->object, test->object_bits, 256);
    criterion->columns |= RMAP_COLUMN_BIT(RMAP_RAY_stop);
    if (test->somewhere)
        criterion->columns |= RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                              RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
                              RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
}

static rmap_column_set ray_number_columns(enum rmap_ray_number number)
{
    switch (number) {
    case RMAP_RAY_NUMBER_ID:
        return RMAP_COLUMN_BIT(RMAP_RAY_id);
    case RMAP_RAY_NUMBER_SEGMENTS:
        return RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    case RMAP_RAY_NUMBER_WAVELENGTH:
        return RMAP_COLUMN_BIT(RMAP_RAY_wavelength);
    case RMAP_RAY_NUMBER_FLUX:
        return RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_source);
    case RMAP_RAY_NUMBER_PATH_LENGTH:
        return RMAP_COLUMN_BIT(RMAP_RAY_path_length);
    case RMAP_RAY_NUMBER_OPTICAL_PATH:
        return RMAP_COLUMN_BIT(RMAP_RAY_optical_path);
    }
    return 0;
}

/* Children in a stable order of cost. A chain keeps its links in the nodes: one list per class,
 * joined at the end. */
struct chain {
    int32_t head, tail;
};

static void chain_append(struct rmap_criterion *criterion, struct chain *chain, struct chain more)
{
    if (more.head < 0)
        return;
    if (chain->head < 0)
        chain->head = more.head;
    else
        criterion->node[chain->tail].next = more.head;
    chain->tail = more.tail;
}

static enum cost plan_node(struct rmap_criterion *criterion, int32_t index, int *n_mask);

static enum cost plan_children(struct rmap_criterion *criterion, int32_t index, int *n_mask)
{
    struct chain class[COST_CLASSES];
    enum cost cost = COST_NONE;
    for (int c = 0; c < COST_CLASSES; c++)
        class[c] = (struct chain){-1, -1};
    for (int32_t child = criterion->node[index].first, next; child >= 0; child = next) {
        int need = 0;
        enum cost own = plan_node(criterion, child, &need);
        next = criterion->node[child].next;
        criterion->node[child].next = -1;
        chain_append(
            criterion, &class [own], (struct chain) { child, child });
        cost = own > cost ? own : cost;
        /* One mask for the result of a child while its siblings' stands. */
        *n_mask = need + 1 > *n_mask ? need + 1 : *n_mask;
    }
    struct chain all = {-1, -1};
    for (int c = 0; c < COST_CLASSES; c++)
        chain_append(criterion, &all, class[c]);
    criterion->node[index].first = all.head;
    return cost;
}

static enum cost plan_node(struct rmap_criterion *criterion, int32_t index, int *n_mask)
{
    struct rmap_criterion_node *node = &criterion->node[index];
    switch (node->kind) {
    case RMAP_CRITERION_ALL:
        return COST_NONE;
    case RMAP_CRITERION_NOT:
        return plan_node(criterion, node->first, n_mask);
    case RMAP_CRITERION_AND:
    case RMAP_CRITERION_OR:
        return plan_children(criterion, index, n_mask);
    case RMAP_CRITERION_SOURCE:
        set_bits(&node->source, &node->source_bits, 64);
        criterion->columns |= RMAP_COLUMN_BIT(RMAP_RAY_source);
        return COST_RAY;
    case RMAP_CRITERION_ENDED:
        plan_ending(criterion, &node->ending);
        return COST_RAY;
    case RMAP_CRITERION_NUMBER:
        criterion->columns |= ray_number_columns(node->ray_number);
        return COST_RAY;
    case RMAP_CRITERION_STEPS:
        return plan_steps(criterion, &node->steps);
    case RMAP_CRITERION_REGISTRATIONS:
        plan_registrations(criterion, &node->registrations);
        if (node->registrations.where >= 0)
            (void)plan_node(criterion, node->registrations.where, &(int){0});
        return COST_REGISTRATION;
    case RMAP_CRITERION_PATH:
        criterion->columns |= node->path.columns;
        return COST_PATH;
    case RMAP_CRITERION_ITS_NUMBER:
        criterion->columns |= its_number_columns(node->its_number);
        return COST_NONE;
    }
    return COST_NONE;
}

void rmap_criterion_plan(struct rmap_criterion *criterion)
{
    criterion->columns = 0;
    criterion->n_mask = 0;
    (void)plan_node(criterion, criterion->root, &criterion->n_mask);
}

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

static double last_ray(const struct rmap_criterion *criterion, int32_t index)
{
    const struct rmap_criterion_node *node = &criterion->node[index];
    bool is_and = node->kind == RMAP_CRITERION_AND;
    if (node->kind == RMAP_CRITERION_NUMBER && node->ray_number == RMAP_RAY_NUMBER_ID &&
        !node->interval.outside)
        return node->interval.high;
    if (!is_and && node->kind != RMAP_CRITERION_OR)
        return (double)INFINITY;
    double last = is_and ? (double)INFINITY : -(double)INFINITY;
    for (int32_t child = node->first; child >= 0; child = criterion->node[child].next) {
        double its = last_ray(criterion, child);
        last = is_and ? fmin(last, its) : fmax(last, its);
    }
    return last;
}

double rmap_criterion_last_ray(const struct rmap_criterion *criterion)
{
    return last_ray(criterion, criterion->root);
}
