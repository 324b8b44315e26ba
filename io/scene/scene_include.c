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
           (strncmp(bundle->text, "include", 7) == 0 || strstr(bundle->text, "\ninclude") != NULL ||
            strstr(bundle->text, "\n" RMAP_INCLUDE_MARK) != NULL);
}

bool rmap_include_next(const char **at, struct rmap_include_part *part)
{
    const size_t n_mark = strlen(RMAP_INCLUDE_MARK);
    if (!*at)
        return false;
    *part = (struct rmap_include_part){.name = *at, .text = *at};
    if (strncmp(*at, RMAP_INCLUDE_MARK, n_mark) == 0) {
        part->name += n_mark;
        part->n_name = strcspn(part->name, "\n");
        part->text = part->name + part->n_name + (part->name[part->n_name] == '\n');
    }
    const char *end = strstr(part->text, "\n" RMAP_INCLUDE_MARK);
    part->nbytes = end ? (size_t)(end - part->text) : strlen(part->text);
    *at = end ? end + 1 : NULL;
    return true;
}

bool rmap_include_stands_elsewhere(const char *name)
{
    return name[0] == '/' || strncmp(name, "../", 3) == 0 || strstr(name, "/../") != NULL;
}

char *rmap_include_path(const char *scene_path, const struct rmap_include_part *part)
{
    const char *slash = scene_path ? strrchr(scene_path, '/') : NULL;
    const size_t folder = slash && part->name[0] != '/' ? (size_t)(slash - scene_path) + 1 : 0;
    char *path = rmap_alloc(folder + part->n_name + 1, 1);
    if (!path)
        return NULL;
    if (folder > 0)
        memcpy(path, scene_path, folder);
    memcpy(path + folder, part->name, part->n_name);
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

char *rmap_include_text(const struct rmap_include_part *part)
{
    char *text = rmap_alloc(part->nbytes + 1, 1);
    if (!text)
        return NULL;
    memcpy(text, part->text, part->nbytes);
    if (part->n_name > 0 && strncmp(text, "#--", 3) == 0)
        text[0] = '-';
    return text;
}

bool rmap_include_is_stored(const struct rmap_include_part *part, const char *path)
{
    char *text = NULL;
    size_t nbytes = 0;
    bool same = false;
    if (rmap_text_file_read(path, &part_file, &text, &nbytes, NULL) == RMAP_OK) {
        const char *begin = part->n_name > 0 ? skip_beginning(text, &nbytes) : text;
        same = nbytes == part->nbytes && memcmp(begin, part->text, nbytes) == 0;
    }
    rmap_free(text);
    return same;
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

static bool has_part(const char *whole, const char *name)
{
    struct rmap_include_part part;
    for (const char *at = whole; rmap_include_next(&at, &part);)
        if (part.n_name > 0 && part.n_name == strlen(name) &&
            memcmp(part.name, name, part.n_name) == 0)
            return true;
    return false;
}

static enum rmap_status include(struct rmap_bundle *bundle, const struct rmap_yaml_node *at,
                                struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    char *text = NULL, *path = NULL;
    size_t nbytes = 0;
    struct rmap_error why = {0};
    enum rmap_status st = RMAP_INPUT;
    const char *name = at->kind == RMAP_YAML_SCALAR ? at->text : "";
    const struct rmap_include_part part = {.name = name, .n_name = strlen(name)};
    if (!name[0] || strpbrk(name, "\r\n"))
        st = rmap_error_set(&why, RMAP_INPUT, "'include' is a file's name, or a list of them");
    else if (has_part(bundle->text, name))
        return RMAP_OK;
    else if (!(path = rmap_include_path(bundle->path, &part)))
        st = rmap_error_set(&why, RMAP_SYSTEM, "out of memory for a scene");
    else
        st = rmap_text_file_read(path, &part_file, &text, &nbytes, &why);
    if (st == RMAP_OK) {
        const char *begin = skip_beginning(text, &nbytes);
        st = append(bundle, name, begin, nbytes, &why);
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

/* What stands behind the scene's own text and is not, or no more, named there. */
static void refuse_unnamed(const char *whole, const struct rmap_yaml_node *const *named, size_t n,
                           struct rmap_diagnostics *diagnostics)
{
    struct rmap_include_part part;
    for (const char *at = whole; rmap_include_next(&at, &part);) {
        bool is_named = part.n_name == 0;
        for (size_t i = 0; i < n && !is_named; i++)
            is_named = named[i]->kind == RMAP_YAML_SCALAR &&
                       strlen(named[i]->text) == part.n_name &&
                       memcmp(named[i]->text, part.name, part.n_name) == 0;
        if (!is_named)
            rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, 0, 0,
                                 "the text goes on with '%.*s', which 'include' does not name: "
                                 "name it there, or take its lines away",
                                 (int)(part.n_name < 100 ? part.n_name : 100), part.name);
    }
}

enum rmap_status rmap_scene_include_files(struct rmap_bundle *bundle,
                                          struct rmap_diagnostics *diagnostics,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics unheard;
    struct rmap_yaml_node *root = NULL;
    const struct rmap_yaml_node *named[RMAP_INCLUDE_MAX];
    size_t n = 0;
    if (!may_include(bundle))
        return RMAP_OK;
    rmap_diagnostics_init(&unheard, NULL); /* the whole text is parsed once more */
    st = rmap_yaml_parse(bundle->text, bundle->text_nbytes, &root, &unheard, err);
    rmap_diagnostics_fini(&unheard);
    const struct rmap_yaml_node *list = st == RMAP_OK ? rmap_yaml_get(root, "include") : NULL;
    if (st != RMAP_OK)
        return st == RMAP_INPUT ? RMAP_OK : st;
    if (list && list->kind == RMAP_YAML_LIST && list->n_item > RMAP_INCLUDE_MAX)
        rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, list->line, list->column,
                             "%zu files: a scene includes %d at most", list->n_item,
                             RMAP_INCLUDE_MAX);
    else if (list && list->kind == RMAP_YAML_LIST)
        for (; n < list->n_item; n++)
            named[n] = list->item[n].value;
    else if (list)
        named[n++] = list;
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        st = include(bundle, named[i], diagnostics, err);
    refuse_unnamed(bundle->text, named, n, diagnostics);
    rmap_yaml_destroy(root);
    return st;
}
