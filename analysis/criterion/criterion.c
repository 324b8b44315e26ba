/* SPDX-License-Identifier: MIT
 *
 * A criterion as a whole: made of its text, its nodes and blocks, destroyed.
 */
#include "analysis/criterion/criterion.h"

#include <string.h>

#include "analysis/criterion/criterion_file.h"
#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_names.h"
#include "analysis/criterion/criterion_tree.h"
#include "analysis/criterion/path_store.h"
#include "base/alloc.h"

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
    struct rmap_error unread; /* what cannot be read is told by the parser */
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
    void *fitting = rmap_realloc(criterion->node, criterion->n_node, sizeof *criterion->node);
    if (fitting) { /* a file may have very many criteria */
        criterion->node = fitting;
        criterion->node_cap = criterion->n_node;
    }
    rmap_criterion_plan(criterion);
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
    rmap_criterion_plan(criterion);
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
