/* SPDX-License-Identifier: MIT
 *
 * Scenes from text in memory, for tests.
 */
#ifndef RMAP_TEST_READ_TEXT_H
#define RMAP_TEST_READ_TEXT_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle.h"

/* A bundle of the text, whose meshes would be looked for in `folder`. NULL when memory is short. */
static inline struct rmap_bundle *bundle_of(const char *folder, const char *text)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/scene.yaml", folder);
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    if (!bundle)
        return NULL;
    bundle->path = rmap_strdup(path);
    bundle->text = rmap_strdup(text);
    bundle->text_nbytes = strlen(text);
    if (bundle->path && bundle->text)
        return bundle;
    rmap_bundle_destroy(bundle);
    return NULL;
}

/* Appends a copy of `word` to a list of options. */
static inline void add_word(char ***list, size_t *n, const char *word)
{
    *list = rmap_realloc(*list, *n + 1, sizeof **list);
    (*list)[(*n)++] = rmap_strdup(word);
}

/* What rmap_diagnostics_print writes; free() it. */
static inline char *printed(const struct rmap_diagnostics *diagnostics)
{
    char *text = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&text, &nbytes);
    rmap_diagnostics_print(diagnostics, out);
    (void)fclose(out);
    return text;
}

/* Reads the bundle's scene; *told_ret: what the diagnostics say, to be freed with free(). */
static inline struct rmap_scene *read_bundle(struct rmap_bundle *bundle, char **told_ret)
{
    struct rmap_scene *scene = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_error err = {0};
    rmap_diagnostics_init(&diagnostics, "s");
    enum rmap_status st = rmap_scene_read(bundle, &scene, &diagnostics, &err);
    *told_ret = printed(&diagnostics);
    if ((st == RMAP_OK) != (diagnostics.n_error == 0)) {
        printf("status %d with %zu errors: %s\n%s\n", (int)st, diagnostics.n_error, err.text,
               *told_ret);
        abort();
    }
    rmap_diagnostics_fini(&diagnostics);
    return st == RMAP_OK ? scene : NULL;
}

/* The scene of a text, or NULL and what is wrong with it. */
static inline struct rmap_scene *read_text(const char *text, char **told_ret)
{
    struct rmap_bundle *bundle = bundle_of(".", text);
    struct rmap_scene *scene = read_bundle(bundle, told_ret);
    rmap_bundle_destroy(bundle);
    return scene;
}

#endif
