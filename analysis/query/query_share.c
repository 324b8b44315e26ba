/* SPDX-License-Identifier: MIT */
#include "analysis/query/query_share.h"

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"

/* Slots hold a byte per ray each. */
enum { SLOT_MAX = 1024 };

/* A subtree's hash, and where it stands. */
struct subtree {
    XXH128_hash_t hash;
    size_t criterion;
    int32_t node;
};

static void add(XXH3_state_t *state, const void *bytes, size_t n)
{
    if (n > 0)
        (void)XXH3_128bits_update(state, bytes, n);
}

static void add_number(XXH3_state_t *state, uint64_t number)
{
    add(state, &number, sizeof number);
}

static void add_set(XXH3_state_t *state, const struct rmap_index_set *set)
{
    add_number(state, (uint64_t)(uint32_t)set->low << 32 | set->span);
    add_number(state, set->member != NULL);
    if (set->member)
        add(state, set->member, set->span);
}

static void add_steps(XXH3_state_t *state, const struct rmap_step_test *test, size_t n_object)
{
    add_number(state, (uint64_t)test->of << 2 | (uint64_t)test->of_object << 1 | test->of_medium);
    add_set(state, &test->object);
    add_set(state, &test->medium);
    add_number(state, (uint64_t)test->events << 32 | test->events_not);
    add_number(state, test->part);
    add_number(state, (uint64_t)test->part_low << 32 | test->part_high);
    add_number(state, test->side != NULL);
    if (test->side)
        add(state, test->side, n_object);
}

static void add_registrations(XXH3_state_t *state, const struct rmap_registration_test *test,
                              size_t n_detector)
{
    add_set(state, &test->detector);
    add_number(state, (uint64_t)test->region << 2 | (uint64_t)test->crossed << 1 | test->relative);
    add(state, test->bound, sizeof test->bound);
    add_number(state, test->n_corner << 1 | (test->box != NULL));
    if (test->box)
        add(state, test->box, n_detector * sizeof *test->box);
    if (test->corner)
        add(state, test->corner, test->n_corner * sizeof *test->corner);
}

/* Of a node above children of this hash. */
static XXH128_hash_t hash_node(const struct rmap_criterion *criterion,
                               const struct rmap_criterion_node *node, XXH128_hash_t children)
{
    XXH3_state_t memory, *state = &memory;
    XXH3_INITSTATE(state);
    (void)XXH3_128bits_reset(state);
    add(state, &children, sizeof children);
    add_number(state, node->kind);
    add(state, &node->interval.low, sizeof node->interval.low);
    add(state, &node->interval.high, sizeof node->interval.high);
    add_number(state, node->interval.outside);
    switch (node->kind) {
    case RMAP_CRITERION_SOURCE:
        add_set(state, &node->source);
        break;
    case RMAP_CRITERION_ENDED:
        add_number(state, (uint64_t)node->ending.stop << 1 | node->ending.somewhere);
        add_set(state, &node->ending.object);
        add_set(state, &node->ending.medium);
        break;
    case RMAP_CRITERION_NUMBER:
        add_number(state, node->ray_number);
        add_number(state, node->id_low);
        add_number(state, node->id_high);
        break;
    case RMAP_CRITERION_ITS_NUMBER:
        add_number(state, node->its_number);
        break;
    case RMAP_CRITERION_STEPS:
        add_steps(state, &node->steps, criterion->scene->n_object);
        break;
    case RMAP_CRITERION_REGISTRATIONS:
        add_registrations(state, &node->registrations, criterion->scene->n_detector);
        break;
    case RMAP_CRITERION_PATH: /* the automaton is the criterion's own */
        add(state, &node->path.table, sizeof node->path.table);
        break;
    default:
        break;
    }
    return XXH3_128bits_digest(state);
}

/* Appends the subtree below a node, its children first. */
static XXH128_hash_t list_subtree(const struct rmap_criterion *criterion, int32_t index,
                                  size_t which, struct subtree *list, size_t *n)
{
    const struct rmap_criterion_node *node = &criterion->node[index];
    bool counts = node->kind == RMAP_CRITERION_REGISTRATIONS;
    int32_t child = counts ? node->registrations.where : node->first;
    XXH128_hash_t children = {0};
    for (; child >= 0; child = counts ? -1 : criterion->node[child].next) {
        size_t unlisted = *n; /* what stands below `where` is of rows, not of rays */
        XXH128_hash_t pair[2] = {children, list_subtree(criterion, child, which, list, n)};
        if (counts)
            *n = unlisted;
        children = XXH3_128bits(pair, sizeof pair);
    }
    list[*n] = (struct subtree){hash_node(criterion, node, children), which, index};
    return list[(*n)++].hash;
}

static int compare_subtrees(const void *a, const void *b)
{
    const struct subtree *x = a, *y = b;
    if (x->hash.high64 != y->hash.high64)
        return x->hash.high64 < y->hash.high64 ? -1 : 1;
    return (x->hash.low64 > y->hash.low64) - (x->hash.low64 < y->hash.low64);
}

static void give_slots(struct rmap_shared_tests *self, const struct subtree *list, size_t n)
{
    for (size_t i = 0, end; i < n && self->n_slot < SLOT_MAX; i = end) {
        for (end = i + 1; end < n && compare_subtrees(&list[i], &list[end]) == 0;)
            end++;
        for (size_t k = i; end - i > 1 && k < end; k++)
            self->slot[list[k].criterion][list[k].node] = (int32_t)self->n_slot;
        self->n_slot += end - i > 1;
    }
}

enum rmap_status rmap_shared_tests_init(struct rmap_shared_tests *self,
                                        const struct rmap_criterion *const *criterion,
                                        size_t n_criterion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_node = 0, n = 0;
    struct subtree *list = NULL;
    *self = (struct rmap_shared_tests){.n_criterion = n_criterion};
    self->slot = rmap_alloc(n_criterion, sizeof *self->slot);
    for (size_t c = 0; self->slot && c < n_criterion; c++) {
        n_node += criterion[c]->n_node;
        self->slot[c] = rmap_alloc(criterion[c]->n_node, sizeof **self->slot);
        if (!self->slot[c])
            goto short_of_memory;
        memset(self->slot[c], -1, criterion[c]->n_node * sizeof **self->slot);
    }
    list = rmap_alloc(n_node, sizeof *list);
    if (!self->slot || !list)
        goto short_of_memory;
    for (size_t c = 0; c < n_criterion; c++)
        (void)list_subtree(criterion[c], criterion[c]->root, c, list, &n);
    qsort(list, n, sizeof *list, compare_subtrees);
    give_slots(self, list, n);
    goto out;
short_of_memory:
    st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n_criterion);
    rmap_shared_tests_fini(self);
out:
    rmap_free(list);
    return st;
}

void rmap_shared_tests_fini(struct rmap_shared_tests *self)
{
    for (size_t c = 0; self->slot && c < self->n_criterion; c++)
        rmap_free(self->slot[c]);
    rmap_free(self->slot);
    *self = (struct rmap_shared_tests){0};
}
