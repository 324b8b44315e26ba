/* SPDX-License-Identifier: MIT
 *
 * Parts of a scene that stand in files of their own.
 */
#include "io/scene/scene_include.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/text_file.h"
#include "io/scene/yaml_tree.h"

static const struct rmap_text_kind part_file = {"a part of a scene", "YAML text", "",
                                                (size_t)64 << 20};

/* Without a look at the whole text where the key does not stand. */
static bool may_include(const struct rmap_bundle *bundle)
{
    return !bundle->meshes_complete &&
           (strncmp(bundle->text, "include", 7) == 0 || strstr(bundle->text, "\ninclude") != NULL);
}

static char *path_of(const struct rmap_bundle *bundle, const char *name)
{
    const char *scene = bundle->path ? bundle->path : "", *slash = strrchr(scene, '/');
    const size_t folder = slash && name[0] != '/' ? (size_t)(slash - scene) + 1 : 0;
    char *path = rmap_alloc(folder + strlen(name) + 1, 1);
    if (!path)
        return NULL;
    memcpy(path, scene, folder);
    memcpy(path + folder, name, strlen(name) + 1);
    return path;
}

/* Behind a byte order mark, and without dashes of its own; its lines stay. */
static char *skip_beginning(char *text, size_t *nbytes)
{
    const size_t mark = strncmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    if (strncmp(text + mark, "---", 3) == 0)
        text[mark] = '#';
    *nbytes -= mark;
    return text + mark;
}

static enum rmap_status append(struct rmap_bundle *bundle, const char *name, const char *text,
                               size_t nbytes, struct rmap_error *err)
{
    const size_t n_name = strlen(name), n_mark = strlen(RMAP_INCLUDE_MARK);
    if (bundle->text_nbytes + nbytes > part_file.nbytes_max)
        return rmap_error_set(err, RMAP_INPUT, "a scene has 64 MiB with all its parts at most");
    char *whole = rmap_realloc(bundle->text, bundle->text_nbytes + n_mark + n_name + nbytes + 4, 1);
    if (!whole)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    char *at = whole + bundle->text_nbytes;
    *at++ = '\n';
    memcpy(at, RMAP_INCLUDE_MARK, n_mark);
    memcpy(at += n_mark, name, n_name);
    at += n_name;
    *at++ = '\n';
    memcpy(at, text, nbytes);
    at[nbytes] = 0;
    bundle->text = whole;
    bundle->text_nbytes = (size_t)(at - whole) + nbytes;
    return RMAP_OK;
}

static enum rmap_status include(struct rmap_bundle *bundle, const struct rmap_yaml_node *at,
                                struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    char *text = NULL, *path = NULL;
    size_t nbytes = 0;
    struct rmap_error why = {0};
    enum rmap_status st = RMAP_INPUT;
    if (at->kind != RMAP_YAML_SCALAR || !at->text[0] || strpbrk(at->text, "\r\n")) {
        st = rmap_error_set(&why, RMAP_INPUT, "'include' is a file's name, or a list of them");
    } else if (!(path = path_of(bundle, at->text))) {
        st = rmap_error_set(&why, RMAP_SYSTEM, "out of memory for a scene");
    } else {
        st = rmap_text_file_read(path, &part_file, &text, &nbytes, &why);
    }
    if (st == RMAP_OK) {
        const char *begin = skip_beginning(text, &nbytes);
        st = append(bundle, at->text, begin, nbytes, &why);
    }
    rmap_free(text);
    rmap_free(path);
    if (st == RMAP_OK)
        return RMAP_OK;
    rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, at->line, at->column, "%s", why.text);
    if (st == RMAP_SYSTEM && err)
        *err = why;
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

enum rmap_status rmap_scene_include_files(struct rmap_bundle *bundle,
                                          struct rmap_diagnostics *diagnostics,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics unheard;
    struct rmap_yaml_node *root = NULL;
    if (!may_include(bundle))
        return RMAP_OK;
    rmap_diagnostics_init(&unheard, NULL); /* the whole text is parsed once more */
    st = rmap_yaml_parse(bundle->text, bundle->text_nbytes, &root, &unheard, NULL);
    rmap_diagnostics_fini(&unheard);
    const struct rmap_yaml_node *list = st == RMAP_OK ? rmap_yaml_get(root, "include") : NULL;
    st = st == RMAP_INPUT ? RMAP_OK : st;
    if (list && list->kind == RMAP_YAML_LIST && list->n_item > RMAP_INCLUDE_MAX)
        rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, list->line, list->column,
                             "%zu files: a scene includes %d at most", list->n_item,
                             RMAP_INCLUDE_MAX);
    else if (list && list->kind == RMAP_YAML_LIST)
        for (size_t i = 0; i < list->n_item && st == RMAP_OK; i++)
            st = include(bundle, list->item[i].value, diagnostics, err);
    else if (list)
        st = include(bundle, list, diagnostics, err);
    rmap_yaml_destroy(root);
    return st;
}
