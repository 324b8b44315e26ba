/* SPDX-License-Identifier: MIT
 *
 * What a criterion will need: the columns of every test, and an order of evaluation.
 */
#include "analysis/criterion/registration_angle.h"
#include "portion/event.h"

/* Relative cost of evaluating a node, cheapest first: what is read, and how much is done per row.
 */
enum cost {
    COST_NONE,
    COST_RAY,
    COST_NUMBER,
    COST_REGISTRATION,
    COST_STEP,
    COST_ROWS, /* of /segment in their order */
    COST_GEOMETRY,
    COST_CLASSES
};

/* Bits (index mod n_bit) of a set's members. */
static void set_bits(const struct rmap_index_set *set, uint64_t *bits, uint32_t n_bit)
{
    for (uint32_t i = 0; i < set->span; i++)
        if (!set->member || set->member[i]) {
            uint32_t bit = ((uint32_t)set->low + i) % n_bit;
            bits[bit / 64] |= (uint64_t)1 << bit % 64;
        }
}

rmap_column_set rmap_side_columns(const struct rmap_scene *scene, const uint8_t *side)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    for (size_t o = 0; o < scene->n_object; o++)
        if ((side[o] == 1 || side[o] == 2) && !rmap_object_medium_tells(&scene->object[o]))
            columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_position) |
                       RMAP_COLUMN_BIT(RMAP_SEGMENT_normal) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
                       RMAP_COLUMN_BIT(RMAP_RAY_start);
    return columns;
}

static rmap_column_set plan_steps(const struct rmap_scene *scene, struct rmap_step_test *test)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    set_bits(&test->object, test->object_bits, 256);
    if (test->of_object)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_object);
    if (test->events | test->events_not)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_event);
    if (test->of_medium)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    if (test->part != RMAP_PART_ALL)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive);
    if (test->side)
        columns |= rmap_side_columns(scene, test->side);
    return columns;
}

rmap_column_set rmap_registration_number_columns(enum rmap_registration_number number)
{
    switch (number) {
    case RMAP_REGISTRATION_ANGLE:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction);
    case RMAP_REGISTRATION_X:
    case RMAP_REGISTRATION_Y:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    case RMAP_REGISTRATION_TIME:
    case RMAP_REGISTRATION_OPTICAL_PATH:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path);
    }
    return 0;
}

static rmap_column_set plan_registrations(struct rmap_registration_test *test)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    set_bits(&test->detector, &test->detector_bits, 64);
    if (!test->crossed)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    if (test->region == RMAP_REGION_CELLS)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell);
    else if (test->region != RMAP_REGION_ALL)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    return columns;
}

static rmap_column_set plan_ending(struct rmap_ending_test *test)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_stop);
    set_bits(&test->object, test->object_bits, 256);
    if (test->somewhere)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_SEGMENT_object);
    if (test->somewhere && test->medium.span > 0)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    return columns;
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
    criterion->node[index].columns = 0;
    for (int c = 0; c < COST_CLASSES; c++)
        class[c] = (struct chain){-1, -1};
    for (int32_t child = criterion->node[index].first, next; child >= 0; child = next) {
        int need = 0;
        enum cost own = plan_node(criterion, child, &need);
        next = criterion->node[child].next;
        criterion->node[child].next = -1;
        criterion->node[index].columns |= criterion->node[child].columns;
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
    enum cost cost;
    switch (node->kind) {
    case RMAP_CRITERION_ALL:
        node->columns = 0;
        return COST_NONE;
    case RMAP_CRITERION_NOT:
        cost = plan_node(criterion, node->first, n_mask);
        node->columns = criterion->node[node->first].columns;
        return cost;
    case RMAP_CRITERION_AND:
    case RMAP_CRITERION_OR:
        return plan_children(criterion, index, n_mask);
    case RMAP_CRITERION_SOURCE:
        set_bits(&node->source, &node->source_bits, 64);
        node->columns = RMAP_COLUMN_BIT(RMAP_RAY_source);
        return COST_RAY;
    case RMAP_CRITERION_ENDED:
        node->columns = plan_ending(&node->ending);
        return node->ending.somewhere ? COST_ROWS : COST_RAY;
    case RMAP_CRITERION_NUMBER:
        node->columns = ray_number_columns(node->ray_number);
        return node->columns & ~RMAP_COLUMNS_DISCRETE ? COST_NUMBER : COST_RAY;
    case RMAP_CRITERION_STEPS:
        node->columns = plan_steps(criterion->scene, &node->steps);
        return node->columns & ~RMAP_COLUMNS_DISCRETE ? COST_GEOMETRY : COST_STEP;
    case RMAP_CRITERION_REGISTRATIONS:
        node->columns = plan_registrations(&node->registrations);
        if (node->registrations.where >= 0) {
            (void)plan_node(criterion, node->registrations.where, &(int){0});
            node->columns |= criterion->node[node->registrations.where].columns;
            if (node->columns & RMAP_COLUMN_BIT(RMAP_RAY_segment_count))
                node->columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment);
        }
        return COST_REGISTRATION;
    case RMAP_CRITERION_PATH:
        node->columns = node->path.columns;
        return COST_ROWS;
    case RMAP_CRITERION_ITS_NUMBER:
        node->columns = rmap_registration_number_columns(node->its_number);
        if (node->its_number == RMAP_REGISTRATION_ANGLE)
            rmap_angle_ends_set(&node->angle, &node->interval);
        return COST_NONE;
    }
    return COST_NONE;
}

void rmap_criterion_plan(struct rmap_criterion *criterion)
{
    criterion->n_mask = 0;
    (void)plan_node(criterion, criterion->root, &criterion->n_mask);
    criterion->columns = criterion->node[criterion->root].columns;
}
