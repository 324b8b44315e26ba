/* SPDX-License-Identifier: MIT
 *
 * Names of a scene, as a criterion resolves them.
 */
#include "analysis/criterion/criterion_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/glob.h"
#include "io/file/diagnostics.h"

static const struct {
    const char *phrase; /* what a name of this kind is */
    const char *usage;  /* how it is asked for */
} kind_table[] = {
    [RMAP_NAME_OBJECT] = {"an object", "hit"},
    [RMAP_NAME_GROUP] = {"a group of objects", "hit"},
    [RMAP_NAME_SOURCE] = {"a source", "source"},
    [RMAP_NAME_DETECTOR] = {"a detector", "registered"},
    [RMAP_NAME_SURFACE] = {"a surface property", "surface"},
    [RMAP_NAME_MEDIUM] = {"a medium", "medium"},
};

static const struct {
    const char *noun;
    unsigned kinds; /* bit (1 << kind) */
} wanted_table[] = {
    [RMAP_WANTED_OBJECT] = {"object", 1u << RMAP_NAME_OBJECT | 1u << RMAP_NAME_GROUP},
    [RMAP_WANTED_SOURCE] = {"source", 1u << RMAP_NAME_SOURCE},
    [RMAP_WANTED_DETECTOR] = {"detector", 1u << RMAP_NAME_DETECTOR},
    [RMAP_WANTED_SURFACE] = {"surface", 1u << RMAP_NAME_SURFACE},
    [RMAP_WANTED_MEDIUM] = {"medium", 1u << RMAP_NAME_MEDIUM},
    [RMAP_WANTED_PLACE] = {"object or medium",
                           1u << RMAP_NAME_OBJECT | 1u << RMAP_NAME_GROUP | 1u << RMAP_NAME_MEDIUM},
    [RMAP_WANTED_ANYWHERE] = {"object, medium or detector",
                              1u << RMAP_NAME_OBJECT | 1u << RMAP_NAME_GROUP |
                                  1u << RMAP_NAME_MEDIUM | 1u << RMAP_NAME_DETECTOR},
};

static int by_name(const void *left, const void *right)
{
    const struct rmap_name *a = left, *b = right;
    int order = strcmp(a->text, b->text);
    if (order)
        return order;
    if (a->kind != b->kind)
        return a->kind < b->kind ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Names of n structs of `stride` bytes, each with its name at byte `offset`. */
static void add_names(struct rmap_names *names, enum rmap_name_kind kind, const void *array,
                      size_t n, size_t stride, size_t offset)
{
    for (size_t i = 0; i < n; i++) {
        const char *text =
            *(char *const *)(const void *)((const char *)array + i * stride + offset);
        if (text)
            names->name[names->n++] = (struct rmap_name){text, kind, (int32_t)i};
    }
}

#define ADD_NAMES(names, kind, field)                                                              \
    add_names(names, RMAP_NAME_##kind, (names)->scene->field, (names)->scene->n_##field,           \
              sizeof *(names)->scene->field, offsetof(struct rmap_##field, name))

enum rmap_status rmap_names_create(const struct rmap_scene *scene, struct rmap_names **names_ret,
                                   struct rmap_error *err)
{
    struct rmap_names *names = rmap_alloc(1, sizeof *names);
    size_t n = scene->n_object + scene->n_group + scene->n_source + scene->n_detector +
               scene->n_surface + scene->n_medium;
    if (names)
        names->name = rmap_alloc(n, sizeof *names->name);
    if (!names || !names->name) {
        rmap_names_destroy(names);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of the scene");
    }
    names->scene = scene;
    ADD_NAMES(names, OBJECT, object);
    ADD_NAMES(names, GROUP, group);
    ADD_NAMES(names, SOURCE, source);
    ADD_NAMES(names, DETECTOR, detector);
    ADD_NAMES(names, SURFACE, surface);
    ADD_NAMES(names, MEDIUM, medium);
    qsort(names->name, names->n, sizeof *names->name, by_name);
    *names_ret = names;
    return RMAP_OK;
}

void rmap_names_destroy(struct rmap_names *names)
{
    if (!names)
        return;
    rmap_free(names->name);
    rmap_free(names);
}

const char *rmap_name_kind_usage(enum rmap_name_kind kind)
{
    return kind_table[kind].usage;
}

const char *rmap_name_kind_phrase(enum rmap_name_kind kind)
{
    return kind_table[kind].phrase;
}

/* Index of the first name that is not before the text. */
static size_t lower_bound(const struct rmap_names *names, const char *text)
{
    size_t low = 0, high = names->n;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (strcmp(names->name[middle].text, text) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

const struct rmap_name *rmap_names_lookup(const struct rmap_names *names, const char *text)
{
    size_t at = lower_bound(names, text);
    return at < names->n && strcmp(names->name[at].text, text) == 0 ? &names->name[at] : NULL;
}

void rmap_token_name(const char *text, const struct rmap_token *token,
                     char name[RMAP_TOKEN_NAME_NBYTES + 1])
{
    bool quoted = token->kind == RMAP_TOKEN_QUOTED;
    size_t len = 0;
    for (size_t i = token->begin + quoted; i < token->end - quoted; i++) {
        name[len++] = text[i];
        i += quoted && text[i] == '\'';
    }
    name[len] = 0;
}

static void mark_name(const struct rmap_scene *scene, const struct rmap_name *name, uint8_t *mark)
{
    if (name->kind != RMAP_NAME_GROUP) {
        mark[name->index] = 1;
        return;
    }
    for (size_t o = 0; o < scene->n_object; o++)
        if (rmap_scene_in_group(scene, (int32_t)o, name->index))
            mark[o] = 1;
}

void rmap_names_mark(const struct rmap_names *names, const char *name, bool wildcards,
                     enum rmap_name_wanted wanted, uint8_t *mark, bool *found_ret)
{
    unsigned kinds = wanted_table[wanted].kinds;
    *found_ret = false;
    for (size_t i = lower_bound(names, name);
         i < names->n && strcmp(names->name[i].text, name) == 0; i++)
        if (kinds >> names->name[i].kind & 1) {
            mark_name(names->scene, &names->name[i], mark);
            *found_ret = true;
        }
    if (*found_ret || !wildcards)
        return;
    for (size_t i = 0; i < names->n; i++)
        if (kinds >> names->name[i].kind & 1 && rmap_glob(name, names->name[i].text)) {
            mark_name(names->scene, &names->name[i], mark);
            *found_ret = true;
        }
}

size_t rmap_names_count(const struct rmap_names *names, enum rmap_name_wanted wanted)
{
    const struct rmap_scene *scene = names->scene;
    const size_t count[] = {
        [RMAP_WANTED_OBJECT] = scene->n_object,     [RMAP_WANTED_SOURCE] = scene->n_source,
        [RMAP_WANTED_DETECTOR] = scene->n_detector, [RMAP_WANTED_SURFACE] = scene->n_surface,
        [RMAP_WANTED_MEDIUM] = scene->n_medium,
    };
    return count[wanted];
}

/* The nearest name of the wanted kind, or NULL. Memory running short only costs the hint. */
static const char *nearest(const struct rmap_names *names, const char *name, unsigned kinds)
{
    const char **candidate = rmap_alloc(names->n, sizeof *candidate);
    size_t n = 0;
    for (size_t i = 0; candidate && i < names->n; i++)
        if (kinds >> names->name[i].kind & 1)
            candidate[n++] = names->name[i].text;
    const char *word = n ? rmap_nearest_word(name, candidate, n) : NULL;
    rmap_free(candidate);
    return word;
}

enum rmap_status rmap_names_fail(const struct rmap_names *names, const char *text,
                                 const struct rmap_token *token, enum rmap_name_wanted wanted,
                                 struct rmap_error *err)
{
    char name[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES], hint[RMAP_SHOWN_NBYTES];
    char written[RMAP_SHOWN_NBYTES];
    rmap_token_name(text, token, name);
    rmap_criterion_shorten(name, shown);
    rmap_token_shorten(text, token, written);
    const char *noun = wanted_table[wanted].noun;
    const struct rmap_name *other = rmap_names_lookup(names, name);
    if (other) {
        const char *usage = kind_table[other->kind].usage;
        char more[RMAP_SHOWN_NBYTES + 16] = "";
        if (other->kind == RMAP_NAME_DETECTOR)
            (void)snprintf(more, sizeof more, " or crossed(%s)", written);
        return rmap_criterion_fail(text, token->begin, token->end, err,
                                   "'%s' is %s, not %s %s (use %s(%s)%s)", shown,
                                   kind_table[other->kind].phrase, noun[0] == 'o' ? "an" : "a",
                                   noun, usage, written, more);
    }
    if (strpbrk(name, "*?"))
        return rmap_criterion_fail(text, token->begin, token->end, err,
                                   "no %s in this map matches '%s'", noun, shown);
    const char *word = nearest(names, name, wanted_table[wanted].kinds);
    if (!word)
        return rmap_criterion_fail(text, token->begin, token->end, err,
                                   "no %s named '%s' in this map", noun, shown);
    rmap_criterion_shorten(word, hint);
    return rmap_criterion_fail(text, token->begin, token->end, err,
                               "no %s named '%s' in this map (did you mean '%s'?)", noun, shown,
                               hint);
}
