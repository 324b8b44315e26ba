/* SPDX-License-Identifier: MIT
 *
 * Words that a session's line may be made of, for completion: the language's, and the names of the
 * map's scene.
 */
#include "mpi/session/session_words.h"

#include <string.h>

#include "analysis/criterion/criterion_word.h"
#include "base/alloc.h"

/* Of the session itself; `let` is the language's. */
static const char *const own_words[] = {"list", "names", "status", "help", "quit", "exit"};

enum { KINDS = 6, OWN_WORDS = sizeof own_words / sizeof *own_words };

/* Name `index` of a kind, or NULL behind the last. */
static const char *name_of(const struct rmap_scene *scene, int kind, size_t index)
{
    switch (kind) {
    case 0:
        return index < scene->n_object ? scene->object[index].name : NULL;
    case 1:
        return index < scene->n_group ? scene->group[index].name : NULL;
    case 2:
        return index < scene->n_source ? scene->source[index].name : NULL;
    case 3:
        return index < scene->n_detector ? scene->detector[index].name : NULL;
    case 4:
        return index < scene->n_surface ? scene->surface[index].name : NULL;
    default:
        return index < scene->n_medium ? scene->medium[index].name : NULL;
    }
}

enum rmap_status rmap_session_words(const struct rmap_scene *scene, const char ***word_ret,
                                    size_t *n_ret, struct rmap_error *err)
{
    size_t n_language = 0;
    while (rmap_criterion_word(n_language))
        n_language++;
    size_t n = OWN_WORDS + n_language + scene->n_object + scene->n_group + scene->n_source +
               scene->n_detector + scene->n_surface + scene->n_medium;
    const char **word = rmap_alloc(n, sizeof *word);
    if (!word)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu words", n);
    n = 0;
    for (size_t i = 0; i < OWN_WORDS; i++)
        word[n++] = own_words[i];
    for (size_t i = 0; i < n_language; i++)
        word[n++] = rmap_criterion_word(i);
    for (int kind = 0; kind < KINDS; kind++)
        for (size_t i = 0; name_of(scene, kind, i); i++)
            word[n++] = name_of(scene, kind, i);
    *word_ret = word;
    *n_ret = n;
    return RMAP_OK;
}

static const char *const title[KINDS] = {"objects",   "groups",   "sources",
                                         "detectors", "surfaces", "media"};

json_t *rmap_session_names_json(const struct rmap_scene *scene)
{
    json_t *names = json_object();
    for (int kind = 0; kind < KINDS; kind++) {
        json_t *list = json_array();
        for (size_t i = 0; name_of(scene, kind, i); i++)
            (void)json_array_append_new(list, json_string(name_of(scene, kind, i)));
        (void)json_object_set_new(names, title[kind], list);
    }
    return names;
}

void rmap_session_names_list(const struct rmap_scene *scene, const char *kind, FILE *out)
{
    for (int k = 0; k < KINDS; k++)
        for (size_t i = 0; strcmp(title[k], kind) == 0 && name_of(scene, k, i); i++)
            fprintf(out, "%s\n", name_of(scene, k, i));
}

void rmap_session_names_print(const struct rmap_scene *scene, FILE *out)
{
    for (int kind = 0; kind < KINDS; kind++) {
        if (!name_of(scene, kind, 0))
            continue;
        fprintf(out, "%-10s", title[kind]);
        for (size_t i = 0; name_of(scene, kind, i); i++)
            fprintf(out, " %s", name_of(scene, kind, i));
        fputc('\n', out);
    }
}
