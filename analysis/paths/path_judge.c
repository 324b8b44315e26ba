/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_judge.h"

#include <string.h>

#include "analysis/paths/path_key_internal.h"
#include "base/alloc.h"
#include "base/count.h"
#include "base/wide.h"

enum { N_STEP = 1 << 16 };

void rmap_path_judge_fini(struct rmap_path_judge *judge)
{
    rmap_free(judge->symbol);
    rmap_free(judge->match);
    rmap_free(judge->skip);
    *judge = (struct rmap_path_judge){0};
}

static const struct rmap_criterion_node *root_of(const struct rmap_criterion *criterion)
{
    return &criterion->node[criterion->root];
}

/* Sets of events of each letter: one stands for all. False: the path tells some of them apart. */
static bool find_events(const struct rmap_path_keys *keys, const struct rmap_path_table *table,
                        uint32_t of_letter[1 << RMAP_PATH_LETTER_BITS])
{
    for (uint32_t events = RMAP_PATH_EVENT_CODES; events-- > 0;)
        of_letter[keys->letter[events]] = events;
    for (uint32_t events = 0; events < RMAP_PATH_EVENT_CODES; events++)
        if (table->letter_of_event[events] !=
            table->letter_of_event[of_letter[keys->letter[events]]])
            return false;
    return true;
}

bool rmap_path_judges(const struct rmap_path_keys *keys, const struct rmap_criterion *criterion)
{
    uint32_t of_letter[1 << RMAP_PATH_LETTER_BITS];
    const struct rmap_criterion_node *node = root_of(criterion);
    return node->kind == RMAP_CRITERION_PATH && !node->path.table->of_medium &&
           rmap_path_keys_are_simple(keys) && rmap_path_keys_are_narrow(keys) && keys->tells_all &&
           find_events(keys, node->path.table, of_letter);
}

/* The places of a step: rmap_path_keys. */
static enum rmap_status make_symbols(struct rmap_path_judge *judge,
                                     const struct rmap_path_keys *keys,
                                     const struct rmap_criterion_node *node, struct rmap_error *err)
{
    uint32_t of_letter[1 << RMAP_PATH_LETTER_BITS] = {0};
    if (judge->symbol)
        return RMAP_OK;
    judge->symbol = rmap_alloc(N_STEP, sizeof *judge->symbol);
    if (!judge->symbol)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the symbols of paths");
    (void)find_events(keys, node->path.table, of_letter);
    const size_t n_place = 1 + keys->labels.n + keys->scene->n_medium; /* that legs have */
    for (uint32_t step = 0; step < n_place << RMAP_PATH_LETTER_BITS; step++) {
        const size_t place = step >> RMAP_PATH_LETTER_BITS;
        const bool is_object = place > 0 && place <= keys->labels.n;
        judge->symbol[step] = rmap_path_symbol(node, is_object ? (int32_t)place - 1 : -1,
                                               of_letter[step % (1 << RMAP_PATH_LETTER_BITS)], -1);
    }
    return RMAP_OK;
}

static enum rmap_status reserve(uint8_t **bytes, size_t *cap, size_t n, struct rmap_error *err)
{
    const enum rmap_status st = RMAP_RESERVE(*bytes, *cap, n, err);
    return st;
}

RMAP_WIDE static void set_where(uint8_t *restrict match, const uint8_t *restrict skip, size_t n)
{
    for (size_t i = 0; i < n; i++)
        match[i] |= skip[i];
}

/* The verdicts stand in judge->match: also those on rays that were skipped. */
static void settle(struct rmap_path_judge *judge, struct rmap_matched *rays)
{
    judge->n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    judge->n_match = rmap_count_ones(judge->match, judge->n_ray);
    rays->match = judge->match;
    rays->n_match = judge->n_match;
    rays->open = NULL;
}

enum rmap_status rmap_path_judge_columns(struct rmap_path_judge *judge, struct rmap_matched *rays,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_criterion *criterion = rays->open;
    RMAP_TRY(rmap_fold_fetch(rays, criterion->columns, err));
    RMAP_TRY(reserve(&judge->match, &judge->match_cap, rays->portion->n_row[RMAP_TABLE_RAY], err));
    RMAP_TRY(rmap_path_mark(criterion, root_of(criterion), rays->portion, judge->match, err));
    settle(judge, rays);
out:
    return st;
}

/* skip: NULL, or of each ray whether it is left out; what is marked there means nothing. */
static enum rmap_status mark(struct rmap_path_judge *judge, const struct rmap_path_hasher *hasher,
                             const struct rmap_matched *rays, const uint8_t *skip,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_criterion_node *node = root_of(rays->open);
    RMAP_TRY(make_symbols(judge, hasher->keys, node, err));
    RMAP_TRY(reserve(&judge->match, &judge->match_cap, rays->portion->n_row[RMAP_TABLE_RAY], err));
    const struct rmap_path_rows rows = {
        .row_class = hasher->few, .symbol = judge->symbol, .is_padded = true, .skip = skip};
    st = rmap_path_mark_rows(node, rays->portion, &rows, judge->match, err);
out:
    return st;
}

enum rmap_status rmap_path_judge_steps(struct rmap_path_judge *judge,
                                       const struct rmap_path_hasher *hasher,
                                       struct rmap_matched *rays, struct rmap_error *err)
{
    const enum rmap_status st = mark(judge, hasher, rays, NULL, err);
    if (st == RMAP_OK)
        settle(judge, rays);
    return st;
}

enum rmap_status rmap_path_judge_left(struct rmap_path_judge *judge,
                                      const struct rmap_path_hasher *hasher,
                                      struct rmap_matched *rays, uint32_t *left, uint64_t *with,
                                      size_t *n_left, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    size_t n = 0;
    RMAP_TRY(reserve(&judge->skip, &judge->skip_cap, n_ray, err));
    memset(judge->skip, 1, n_ray);
    for (size_t i = 0; i < *n_left; i++)
        judge->skip[left[i]] = 0;
    RMAP_TRY(mark(judge, hasher, rays, judge->skip, err));
    set_where(judge->match, judge->skip, n_ray);
    settle(judge, rays);
    if (rays->n_match == n_ray)
        goto out;
    for (size_t i = 0; i < *n_left; i++) {
        const uint32_t ray = left[i];
        left[n] = ray;
        with[n] = with[i];
        n += judge->match[ray];
    }
    *n_left = n;
out:
    return st;
}
