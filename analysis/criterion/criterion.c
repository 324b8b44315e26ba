/* SPDX-License-Identifier: MIT
 *
 * The criterion language: one text that selects rays by their whole histories.
 */
#include <stdint.h>
#include <string.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_file.h"
#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_names.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_tree.h"
#include "analysis/criterion/path_in.h"
#include "analysis/criterion/path_store.h"
#include "analysis/criterion/registration_angle.h"
#include "analysis/criterion/registration_response.h"
#include "analysis/criterion/step_number.h"
#include "base/alloc.h"

/* What a criterion will need: the columns of every test, and an order of evaluation. */

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
        if (rmap_side_matters(side[o]) && !rmap_object_medium_tells(&scene->object[o]))
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
    return columns | rmap_step_limit_columns(test);
}

enum rmap_status rmap_check_times(const struct rmap_scene *scene, rmap_column_set columns,
                                  struct rmap_error *err)
{
    if (scene->timed || !(columns & RMAP_COLUMNS_TIME))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "'group_path': this map has no group paths: trace its scene with 'time: "
                          "on' in the simulation, or raymap trace --time on");
}

enum rmap_status rmap_check_channels(const struct rmap_scene *scene, rmap_column_set columns,
                                     struct rmap_error *err)
{
    if (!scene->is_mixed || !(columns & RMAP_COLUMN_BIT(RMAP_SEGMENT_colour)))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "parts of this map were traced in other wavelengths: what is detected by "
                          "chance, or scattered by one of two models, and wavelengths of steps can "
                          "be asked of maps that have the same ones throughout");
}

bool rmap_criterion_of_phase_time(const struct rmap_criterion *criterion)
{
    bool of = false;
    for (size_t i = 0; i < criterion->n_node; i++) {
        const struct rmap_criterion_node *node = &criterion->node[i];
        of |= node->kind == RMAP_CRITERION_ITS_NUMBER && node->its_number == RMAP_REGISTRATION_TIME;
        if (node->kind == RMAP_CRITERION_SUM)
            of |= rmap_sum_of_phase_time(&node->sum);
    }
    return of;
}

bool rmap_criterion_of_ids(const struct rmap_criterion *criterion)
{
    bool of = false;
    for (size_t i = 0; i < criterion->n_node; i++) {
        const struct rmap_criterion_node *node = &criterion->node[i];
        of |= node->kind == RMAP_CRITERION_RAYS ||
              (node->kind == RMAP_CRITERION_NUMBER && node->ray_number == RMAP_RAY_NUMBER_ID) ||
              (node->kind == RMAP_CRITERION_SUM && rmap_sum_of_ids(&node->sum));
    }
    return of;
}

rmap_column_set rmap_registration_number_columns(enum rmap_registration_number number)
{
    switch (number) {
    case RMAP_REGISTRATION_ANGLE:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction);
    case RMAP_REGISTRATION_X:
    case RMAP_REGISTRATION_Y:
    case RMAP_REGISTRATION_WORLD_X:
    case RMAP_REGISTRATION_WORLD_Y:
    case RMAP_REGISTRATION_WORLD_Z:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    case RMAP_REGISTRATION_TIME:
    case RMAP_REGISTRATION_OPTICAL_PATH:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path);
    case RMAP_REGISTRATION_DETECTED:
        return RMAP_RESPONSE_COLUMNS;
    case RMAP_REGISTRATION_ARRIVAL:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) |
               RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay);
    case RMAP_REGISTRATION_GROUP_PATH:
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path);
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
    else if (test->region != RMAP_REGION_ALL || test->box)
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
        node->columns = rmap_ray_number_columns(node->ray_number);
        return node->columns & ~RMAP_COLUMNS_DISCRETE ? COST_NUMBER : COST_RAY;
    case RMAP_CRITERION_RAYS:
        node->columns = RMAP_COLUMN_BIT(RMAP_RAY_id);
        return COST_NUMBER;
    case RMAP_CRITERION_PATH_IN:
        node->columns = RMAP_PATH_IN_COLUMNS;
        return COST_GEOMETRY;
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
    case RMAP_CRITERION_SUM:
        node->columns = rmap_sum_columns(&node->sum);
        return node->columns & ~RMAP_COLUMNS_DISCRETE ? COST_GEOMETRY : COST_RAY;
    }
    return COST_NONE;
}

/* Orders children by cost and sets columns, n_mask and the bits of every test. */
static enum rmap_status criterion_plan(struct rmap_criterion *criterion, struct rmap_error *err)
{
    criterion->n_mask = 0;
    (void)plan_node(criterion, criterion->root, &criterion->n_mask);
    criterion->columns = criterion->node[criterion->root].columns;
    enum rmap_status st = rmap_check_times(criterion->scene, criterion->columns, err);
    return st == RMAP_OK ? rmap_check_channels(criterion->scene, criterion->columns, err) : st;
}

enum rmap_status rmap_criterion_node_add(struct rmap_criterion *criterion,
                                         const struct rmap_criterion_node *node, int32_t *index_ret,
                                         struct rmap_error *err)
{
    if (criterion->n_node >= INT32_MAX)
        return rmap_error_set(err, RMAP_INPUT, "the criterion has too many tests");
    enum rmap_status st =
        RMAP_RESERVE(criterion->node, criterion->node_cap, criterion->n_node + 1, err);
    if (st != RMAP_OK)
        return st;
    *index_ret = (int32_t)criterion->n_node;
    criterion->node[criterion->n_node++] = *node;
    return RMAP_OK;
}

enum rmap_status rmap_criterion_block_add(struct rmap_criterion *criterion, size_t n, size_t size,
                                          void **block_ret, struct rmap_error *err)
{
    enum rmap_status st =
        RMAP_RESERVE(criterion->block, criterion->block_cap, criterion->n_block + 1, err);
    if (st != RMAP_OK)
        return st;
    *block_ret = rmap_alloc(n, size);
    if (!*block_ret)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criterion");
    criterion->block[criterion->n_block++] = *block_ret;
    return RMAP_OK;
}

enum rmap_status rmap_criterion_compile(const char *text, const struct rmap_scene *scene,
                                        struct rmap_criterion **criterion_ret,
                                        struct rmap_error *err)
{
    return rmap_criterion_compile_with(text, NULL, scene, criterion_ret, err);
}

static enum rmap_status set_name(struct rmap_criterion *criterion,
                                 const struct rmap_criteria *criteria, struct rmap_error *err)
{
    struct rmap_token token;
    struct rmap_error unread; /* what cannot be read is reported by the parser */
    char name[RMAP_TOKEN_NAME_NBYTES + 1];
    const char *text = criterion->text;
    if (!criteria || *text != '@' || rmap_token_read(text, 1, &token, &unread) != RMAP_OK ||
        (token.kind != RMAP_TOKEN_WORD && token.kind != RMAP_TOKEN_QUOTED))
        return RMAP_OK;
    rmap_token_name(text, &token, name);
    const size_t let = rmap_criteria_find(criteria, name);
    if (let == SIZE_MAX || strcmp(rmap_criteria_reference(criteria, let), text) != 0)
        return RMAP_OK;
    criterion->name = rmap_strdup(name);
    return criterion->name ? RMAP_OK
                           : rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criterion");
}

/* Of a criterion that is @NAME of rays in the map, and nothing else. */
static enum rmap_status name_rays(struct rmap_criterion *criterion, struct rmap_error *err)
{
    const struct rmap_criterion_node *node = &criterion->node[0];
    const size_t n = node->end - node->begin - 1;
    criterion->name = rmap_alloc(n + 1, 1);
    if (!criterion->name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criterion");
    memcpy(criterion->name, criterion->text + node->begin + 1, n);
    return RMAP_OK;
}

static enum rmap_status create(const char *text, const struct rmap_scene *scene,
                               struct rmap_criterion **criterion_ret, struct rmap_error *err)
{
    struct rmap_criterion *criterion = rmap_alloc(1, sizeof *criterion);
    if (criterion)
        criterion->text = rmap_strdup(text);
    if (!criterion || !criterion->text) {
        rmap_criterion_destroy(criterion);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criterion");
    }
    if (strchr(criterion->text, '#')) { /* what is shown, and joined to others, goes without */
        rmap_criterion_blank_comments(criterion->text);
        size_t len = strlen(criterion->text);
        while (len > 0 && strchr(" \t\r\n", criterion->text[len - 1]))
            criterion->text[--len] = 0;
    }
    criterion->scene = scene;
    *criterion_ret = criterion;
    return RMAP_OK;
}

enum rmap_status rmap_criterion_compile_with(const char *text, const struct rmap_criteria *criteria,
                                             const struct rmap_scene *scene,
                                             struct rmap_criterion **criterion_ret,
                                             struct rmap_error *err)
{
    struct rmap_criterion *criterion = NULL;
    enum rmap_status st = create(text, scene, &criterion, err);
    RMAP_TRY(st);
    RMAP_TRY(set_name(criterion, criteria, err));
    RMAP_TRY(rmap_criterion_parse(criterion, criteria, err));
    if (criterion->n_node == 1 && criterion->node[0].kind == RMAP_CRITERION_RAYS)
        RMAP_TRY(name_rays(criterion, err));
    void *fitting = rmap_realloc(criterion->node, criterion->n_node, sizeof *criterion->node);
    if (fitting) { /* a file may have very many criteria */
        criterion->node = fitting;
        criterion->node_cap = criterion->n_node;
    }
    RMAP_TRY(criterion_plan(criterion, err));
    *criterion_ret = criterion;
    criterion = NULL;
out:
    rmap_criterion_destroy(criterion);
    return st;
}

enum rmap_status
rmap_criterion_compile_which(const char *text, const struct rmap_criteria *criteria,
                             const struct rmap_scene *scene, const struct rmap_index_set *detector,
                             struct rmap_criterion **criterion_ret, struct rmap_error *err)
{
    struct rmap_criterion *criterion = NULL;
    struct rmap_index_set own = *detector;
    enum rmap_status st = create(text, scene, &criterion, err);
    RMAP_TRY(st);
    if (detector->member) {
        void *block = NULL;
        RMAP_TRY(rmap_criterion_block_add(criterion, detector->span, 1, &block, err));
        own.member = memcpy(block, detector->member, detector->span);
    }
    st = rmap_criterion_parse_which(criterion, criteria, &own, err);
    if (st == RMAP_INPUT)
        rmap_criterion_relabel("--which", err);
    RMAP_TRY(st);
    RMAP_TRY(criterion_plan(criterion, err));
    *criterion_ret = criterion;
    criterion = NULL;
out:
    rmap_criterion_destroy(criterion);
    return st;
}

void rmap_criterion_destroy(struct rmap_criterion *criterion)
{
    if (!criterion)
        return;
    for (size_t i = 0; i < criterion->n_block; i++)
        rmap_free(criterion->block[i]);
    rmap_free(criterion->block);
    rmap_path_store_release(criterion->paths);
    rmap_free(criterion->node);
    rmap_free(criterion->name);
    rmap_free(criterion->text);
    rmap_free(criterion);
}

const char *rmap_criterion_name(const struct rmap_criterion *criterion)
{
    return criterion->name;
}

const char *rmap_criterion_text(const struct rmap_criterion *criterion)
{
    return criterion->text;
}

rmap_column_set rmap_criterion_columns(const struct rmap_criterion *criterion)
{
    return criterion->columns;
}
