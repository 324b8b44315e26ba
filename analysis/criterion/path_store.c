/* SPDX-License-Identifier: MIT
 *
 * The automata of the paths of all criteria that share definitions: paths of one text are one
 * automaton, and all together are bounded in time and memory.
 */
#include "analysis/criterion/path_store.h"

#include <string.h>

#include "analysis/criterion/path_table.h"
#include "base/alloc.h"

enum {
    ENTRY_MAX = 1 << 24, /* of all tables: 64 MiB */
    WORK_MAX = 1 << 28   /* nodes looked at for all paths: some seconds */
};

struct path {
    char *text; /* with its quotes */
    const struct rmap_scene *scene;
    const struct rmap_path_table *table;
};

struct rmap_path_store {
    size_t n_holder;
    struct path *path; /* [n] */
    size_t n, cap;
    size_t n_entry, work;
    struct rmap_criterion *owner; /* of the tables' memory; of no text */
    const struct rmap_scene *scene;
    const uint8_t *letters; /* as in struct rmap_parser */
};

struct rmap_path_store *rmap_path_store_create(void)
{
    struct rmap_path_store *store = rmap_alloc(1, sizeof *store);
    struct rmap_criterion *owner = store ? rmap_alloc(1, sizeof *owner) : NULL;
    if (!owner) {
        rmap_free(store);
        return NULL;
    }
    store->owner = owner;
    store->n_holder = 1;
    return store;
}

struct rmap_path_store *rmap_path_store_hold(struct rmap_path_store *store)
{
    store->n_holder++;
    return store;
}

void rmap_path_store_release(struct rmap_path_store *store)
{
    if (!store || --store->n_holder > 0)
        return;
    for (size_t i = 0; i < store->n; i++)
        rmap_free(store->path[i].text);
    rmap_free(store->path);
    rmap_criterion_destroy(store->owner);
    rmap_free(store);
}

static enum rmap_status begin_table(struct rmap_parser *parser, struct rmap_path_table **table_ret)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = parser->criterion->scene;
    void *block = NULL, *follows = NULL;
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, 1, sizeof(struct rmap_path_table), &block,
                                      parser->err));
    RMAP_TRY(rmap_criterion_block_add(parser->criterion, scene->n_detector + 1, 1, &follows,
                                      parser->err));
    struct rmap_path_table *table = block;
    uint8_t *mark = follows;
    for (size_t d = 0; d < scene->n_detector; d++)
        mark[d] = rmap_detector_lies_on(&scene->detector[d]);
    *table = (struct rmap_path_table){.n_object = scene->n_object,
                                      .n_medium = scene->n_medium,
                                      .n_detector = scene->n_detector,
                                      .follows_object = follows};
    *table_ret = table;
out:
    return st;
}

static enum rmap_status compile(struct rmap_parser *parser, const struct rmap_token *string,
                                struct rmap_path_table *table)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_regex regex = {0};
    struct rmap_path_alphabet alphabet = {0};
    RMAP_TRY(rmap_path_regex_parse(parser, string, &regex));
    RMAP_TRY(rmap_path_alphabet_create(parser, string, &regex, table, &alphabet));
    RMAP_TRY(rmap_path_needs_create(parser, &regex, &alphabet, table));
    RMAP_TRY(rmap_path_automaton_create(parser, string, &regex, &alphabet, table));
out:
    rmap_free(alphabet.has);
    rmap_path_regex_fini(&regex);
    return st;
}

/* What is made for the path is the store's, from here on. */
static enum rmap_status build(struct rmap_path_store *store, struct rmap_parser *parser,
                              const struct rmap_token *string, struct rmap_path_table **table_ret)
{
    struct rmap_criterion *criterion = parser->criterion;
    const size_t work = parser->path_work;
    enum rmap_status st;
    if (store->scene != criterion->scene)
        store->letters = NULL;
    store->scene = store->owner->scene = criterion->scene;
    parser->criterion = store->owner;
    parser->path_letters = store->letters;
    RMAP_TRY(begin_table(parser, table_ret));
    RMAP_TRY(compile(parser, string, *table_ret));
    store->n_entry += (size_t)(*table_ret)->n_state * (*table_ret)->width;
    if (store->n_entry > ENTRY_MAX)
        st = RMAP_PARSER_FAIL(parser, string,
                              "the paths of all criteria are too complex together: their automata "
                              "need more than %d entries in "
                              "their tables of states and symbols",
                              ENTRY_MAX);
    else if (store->work + (parser->path_work - work) > WORK_MAX)
        st = RMAP_PARSER_FAIL(parser, string,
                              "the paths of all criteria are too complex together: they need more "
                              "than %d steps of work to be "
                              "understood",
                              WORK_MAX);
out:
    store->work += parser->path_work - work;
    store->letters = parser->path_letters;
    parser->criterion = criterion;
    return st;
}

enum rmap_status rmap_path_store_table(struct rmap_path_store *store, struct rmap_parser *parser,
                                       const struct rmap_token *string,
                                       const struct rmap_path_table **table_ret)
{
    enum rmap_status st = RMAP_OK;
    const char *text = parser->text + string->begin;
    const size_t nbytes = string->end - string->begin;
    struct rmap_path_table *table = NULL;
    for (size_t i = 0; i < store->n; i++)
        if (store->path[i].scene == parser->criterion->scene &&
            strncmp(store->path[i].text, text, nbytes) == 0 && store->path[i].text[nbytes] == 0) {
            *table_ret = store->path[i].table;
            return RMAP_OK;
        }
    RMAP_TRY(build(store, parser, string, &table));
    RMAP_TRY(RMAP_RESERVE(store->path, store->cap, store->n + 1, parser->err));
    char *copy = rmap_alloc(nbytes + 1, 1);
    if (!copy)
        return rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for the criterion");
    store->path[store->n++] =
        (struct path){memcpy(copy, text, nbytes), parser->criterion->scene, table};
    *table_ret = table;
out:
    return st;
}
