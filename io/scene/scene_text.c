/* SPDX-License-Identifier: MIT
 *
 * Changes of a scene's text that leave the rest of it as it is written. The tree says which node is
 * meant, yaml_span from where to where it stands.
 */
#include "io/scene/scene_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_include.h"
#include "io/scene/yaml_follow.h"
#include "io/scene/yaml_span.h"
#include "io/scene/yaml_write.h"

/* An item more of a list as its last. */
static void put_item(FILE *out, const char *text, const struct rmap_yaml_span *span,
                     const char *name, const json_t *value)
{
    const size_t end = span->end, line = end + strcspn(text + end, "\n");
    if (span->flow)
        fprintf(out, "%.*s%s", (int)(end - 1), text, span->empty ? "" : ", ");
    else
        fprintf(out, "%.*s\n%*s- ", (int)line, text, span->column, "");
    rmap_yaml_write_named(out, name, value);
    fputs(text + (span->flow ? end - 1 : line), out);
}

/* In the place of an empty value of that key. */
static void put_first(FILE *out, const char *text, const struct rmap_yaml_span *span,
                      const char *key, const char *rest, const json_t *value)
{
    const bool list = rmap_yaml_has_named(key, strlen(key));
    fprintf(out, "%.*s%s%c", (int)span->first, text, span->first == span->end ? " " : "",
            list ? '[' : '{');
    if (list)
        rmap_yaml_write_named(out, rest, value);
    else
        rmap_yaml_write_path(out, rest, value);
    fprintf(out, "%c%s", list ? ']' : '}', text + span->end);
}

/* A block's list stands there, perhaps no further right than its key, as nothing else may. */
static bool is_dash(const char *text, size_t at)
{
    return text[at] == '-' && text[at + 1] && strchr(" \t\r\n", text[at + 1]);
}

/* Writes the text with the node's value, or with a key more in it. */
static void put_changed(FILE *out, const char *text, const struct rmap_yaml_span *span,
                        const char *rest, const json_t *value)
{
    const size_t first = span->first, end = span->end;
    if (!*rest) {
        fprintf(out, "%.*s%s", (int)first, text, first == end || is_dash(text, first) ? " " : "");
        rmap_yaml_write_value(out, value);
        fputs(text + end, out);
    } else if (span->flow) { /* before its bracket */
        fprintf(out, "%.*s%s", (int)(end - 1), text, span->empty ? "" : ", ");
        rmap_yaml_write_path(out, rest, value);
        fputs(text + end - 1, out);
    } else {
        fprintf(out, "%.*s", (int)first, text);
        rmap_yaml_write_path(out, rest, value);
        fprintf(out, "\n%*s%s", span->column, "", text + first);
    }
}

/* Behind blanks, ends of lines and comments. */
static size_t skip_comments(const char *text, size_t at)
{
    for (at += strspn(text + at, " \t\r\n"); text[at] == '#'; at += strspn(text + at, " \t\r\n"))
        at += strcspn(text + at, "\n");
    return at;
}

/* Out of brackets: with the comma behind it, or as the last with the one before. */
static void put_without_entry(FILE *out, const char *text, const struct rmap_yaml_span *span)
{
    const size_t first = span->first, end = span->end;
    const size_t next = skip_comments(text, end);
    const size_t comma = skip_comments(text, span->before);
    if (text[next] == ',') {
        fprintf(out, "%.*s%s", (int)first, text, text + next + 1 + strspn(text + next + 1, " "));
    } else if (comma < first && text[comma] == ',') {
        const size_t rest = comma + 1 + strspn(text + comma + 1, " ");
        fprintf(out, "%.*s%.*s%s", (int)comma, text, (int)(first - rest), text + rest, text + end);
    } else {
        fprintf(out, "%.*s%s", (int)first, text, text + end);
    }
}

/* Out of a block: the lines that it has for itself, with what is said behind it. */
static void put_without_lines(FILE *out, const char *text, const struct rmap_yaml_span *span,
                              bool is_item)
{
    size_t first = span->first, end = span->end, line;
    if (is_item) /* with its dash */
        while (first > 0 && text[--first] != '-')
            continue;
    for (line = first; line > 0 && text[line - 1] != '\n';)
        line--;
    const size_t blank = end + strspn(text + end, " \t\r");
    if (line + strspn(text + line, " ") == first) {
        first = line;
        if (text[end - 1] != '\n' && (text[blank] == '#' || text[blank] == '\n'))
            end = blank + strcspn(text + blank, "\n") + 1;
    }
    fprintf(out, "%.*s%s", (int)first, text, text + (end < strlen(text) ? end : strlen(text)));
}

enum rmap_status rmap_scene_text_parse(struct rmap_scene_text *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics found;
    if (scene->root)
        return RMAP_OK;
    rmap_diagnostics_init(&found, "scene");
    st = rmap_yaml_parse(scene->text, strlen(scene->text), &scene->root, &found, err);
    if (st == RMAP_INPUT)
        (void)rmap_error_set(err, st, "%s",
                             found.n ? found.item[found.n - 1].text : "the text is no YAML");
    scene->is_sound = found.n == 0;
    rmap_diagnostics_fini(&found);
    return st;
}

static enum rmap_status refuse(const char *path, const char *rest, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_INPUT,
                          "'%s' leads nowhere in the scene: no '%s' (items of a list: by name, or "
                          "by number from 1)",
                          path, rest);
}

/* What of `rest`, behind a node that its key has, is the name of a new item of a list, which may be
 * new, too; NULL: nothing. */
static const char *find_new(const struct rmap_yaml_node *node, const char *key, const char *rest)
{
    if (node->kind == RMAP_YAML_LIST ||
        (node->kind == RMAP_YAML_SCALAR && rmap_yaml_has_named(key, strlen(key))))
        return rest;
    for (const char *dot; (dot = strchr(rest, '.')); rest = dot + 1)
        if (rmap_yaml_has_named(rest, (size_t)(dot - rest)))
            return dot + 1;
    return NULL;
}

static enum rmap_status check_new(const char *path, const char *name, const json_t *value,
                                  struct rmap_error *err)
{
    const int n_list = (int)(name - path) - 1, n_name = (int)strcspn(name, ".");
    if (!json_is_object(value) || name[n_name])
        return rmap_error_set(
            err, RMAP_INPUT,
            "'%s' leads nowhere in the scene: no '%.*s' in '%.*s' (items of a list: by name, or by "
            "number from 1; for a new one set '%.*s' to a mapping)",
            path, n_name, name, n_list, path, n_list + 1 + n_name, path);
    if ((int)strspn(name, "0123456789") == n_name && !json_object_get(value, "name"))
        return rmap_error_set(
            err, RMAP_INPUT,
            "'%s' leads nowhere in the scene: a new item is named, set '%.*s.NAME' "
            "to a mapping",
            path, n_list, path);
    return RMAP_OK;
}

/* What became another: a value that was written in the place of another, or what has a key more,
 * or what is gone. */
struct replaced {
    struct rmap_yaml_node *node; /* NULL: that is not what was done */
    struct rmap_yaml_span span;
    const struct rmap_yaml_node *changed;
};

/* Behind an anchor: it stays. */
static void skip_anchor(const char *text, struct rmap_yaml_span *span)
{
    size_t at = span->first, line;
    if (text[at] != '&')
        return;
    at = skip_comments(text, at + strcspn(text + at, " \t\r\n,]}"));
    at = at < span->end ? at : span->end;
    for (line = at; line > 0 && text[line - 1] != '\n';)
        line--;
    span->first = at;
    span->column = (int)(at - line);
}

/* In the place of an alias, or beside the '<<' that brings it. behind: what of the path is behind
 * the item. */
static enum rmap_status write_shared(FILE *out, const struct rmap_scene_text *scene,
                                     const char *path, const char *behind,
                                     const struct rmap_yaml_item *item,
                                     const struct rmap_yaml_node *in, const json_t *value,
                                     struct replaced *replaced, struct rmap_error *err)
{
    const bool merged = item->value->merged;
    const char *text = scene->text;
    struct rmap_yaml_span span = {0};
    const int n_path = (int)(behind - path) - (*behind != 0);
    if (*behind)
        return rmap_error_set(
            err, RMAP_INPUT,
            "'%s' leads into what an anchor in line %d says for others, too: set '%.*s' as a whole",
            path, item->value->line, n_path, path);
    if (!value || (merged && strchr(item->key, '.')))
        return rmap_error_set(err, RMAP_INPUT,
                              "'%s' comes by '<<' from line %d: change it in the text", path,
                              item->line);
    if (!rmap_yaml_span(text, scene->root, merged ? in->line : item->line,
                        merged ? in->column : item->column, !merged, !merged && item->key ? 2 : 1,
                        &span))
        return refuse(path, path, err);
    if (merged)
        skip_anchor(text, &span);
    else
        for (span.first = span.end; text[span.first] != '*';)
            span.first--;
    put_changed(out, text, &span, merged ? item->key : "", value);
    replaced->changed = merged ? in : item->value;
    return RMAP_OK;
}

/* value NULL: what the path leads to goes. */
static enum rmap_status write_one(FILE *out, const struct rmap_scene_text *scene, const char *path,
                                  const json_t *value, struct replaced *replaced,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *text = scene->text, *rest = path;
    const struct rmap_yaml_item *item = NULL;
    struct rmap_yaml_span span = {0};
    const char *behind = path;
    const struct rmap_yaml_node *in = NULL, *node = rmap_yaml_find(scene->root, path, &rest, &item);
    const struct rmap_yaml_item *shared = rmap_yaml_find_shared(scene->root, path, &behind, &in);
    const bool scalar = node->kind == RMAP_YAML_SCALAR;
    if (!rmap_yaml_is_path(path, strlen(path)))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "'%s' is no path of keys, as \"objects.lens.at\" is", path));
    if (shared && (*behind || value || shared->value->merged))
        return write_shared(out, scene, path, behind, shared, in, value, replaced, err);
    replaced->changed = node;
    if (!value) {
        const bool has_key = item && item->key;
        if (!item || *rest ||
            !rmap_yaml_span(text, scene->root, item->line, item->column, has_key || scalar,
                            has_key ? 2 : 1, &span))
            RMAP_TRY(refuse(path, rest, err));
        if (span.in_flow)
            put_without_entry(out, text, &span);
        else
            put_without_lines(out, text, &span, !has_key);
    } else {
        const char *key = item && item->key ? item->key : "";
        const char *name = *rest ? find_new(node, key, rest) : NULL;
        if (name)
            RMAP_TRY(check_new(path, name, value, err));
        if ((*rest && scalar && !rmap_yaml_is_nothing(node)) ||
            !rmap_yaml_span(text, scene->root, node->line, node->column, scalar, 1, &span))
            RMAP_TRY(refuse(path, rest, err));
        skip_anchor(text, &span);
        if (*rest && scalar)
            put_first(out, text, &span, key, rest, value);
        else if (node->kind == RMAP_YAML_LIST && *rest)
            put_item(out, text, &span, rest, value);
        else
            put_changed(out, text, &span, rest, value);
        if (!*rest && item && !is_dash(text, span.first))
            *replaced = (struct replaced){item->value, span, node};
    }
out:
    return st;
}

static bool is_flat(const json_t *value)
{
    bool flat = !json_is_object(value);
    for (size_t i = 0; flat && i < json_array_size(value); i++)
        flat =
            !json_is_array(json_array_get(value, i)) && !json_is_object(json_array_get(value, i));
    return flat;
}

/* The value of a key, which is likely to be the hint-th. */
static const struct rmap_yaml_node *value_of(const struct rmap_yaml_node *map, const char *key,
                                             size_t hint)
{
    for (size_t i = 0; i < map->n_item; i++) {
        const struct rmap_yaml_item *item = &map->item[(hint + i) % map->n_item];
        if (strcmp(item->key, key) == 0)
            return item->value;
    }
    return NULL;
}

/* Whether two trees say the same but for what has changed in the first, or is gone from it. */
static bool says_same(const struct rmap_yaml_node *a, const struct rmap_yaml_node *b,
                      const struct rmap_yaml_node *changed, bool gone)
{
    size_t n_gone = 0;
    if (a == changed)
        return true;
    if (a->kind != b->kind || a->quoted != b->quoted ||
        (a->kind == RMAP_YAML_SCALAR && strcmp(a->text, b->text) != 0))
        return false;
    for (size_t i = 0; i < a->n_item; i++) {
        const struct rmap_yaml_item *item = &a->item[i];
        if (gone && item->value == changed) {
            n_gone = 1;
            continue;
        }
        const size_t k = i - n_gone;
        const struct rmap_yaml_node *other = item->key       ? value_of(b, item->key, k)
                                             : k < b->n_item ? b->item[k].value
                                                             : NULL;
        if (!other || !says_same(item->value, other, changed, gone))
            return false;
    }
    return n_gone > 0 || a->n_item == b->n_item; /* '<<' may bring a key that is gone */
}

/* Of a text with anchors: what others have by them is to stay. */
static enum rmap_status check_others(const struct rmap_scene_text *before,
                                     struct rmap_scene_text *now,
                                     const struct rmap_yaml_node *changed, bool gone,
                                     const char *path, struct rmap_error *err)
{
    struct rmap_error why = {0};
    const enum rmap_status st = rmap_scene_text_parse(now, &why);
    if (st == RMAP_OK && says_same(before->root, now->root, changed, gone))
        return RMAP_OK;
    if (st != RMAP_OK && !strstr(why.text, RMAP_YAML_NO_ANCHOR))
        return rmap_error_set(err, st, "%s", why.text);
    return rmap_error_set(err, RMAP_INPUT,
                          "'%s' stands in an anchor that others take by an alias or '<<': they "
                          "would change, too; change it in the text",
                          path);
}

/* The tree becomes that of the changed text, as if it was read anew; or there is none any more. */
static void follow(struct rmap_scene_text *scene, const struct replaced *replaced,
                   const json_t *value, const char *written)
{
    const char *text = scene->text;
    const size_t first = replaced->span.first, nbytes = replaced->span.end - first;
    /* Included files have lines of their own. */
    if (replaced->node && is_flat(value) && !strstr(text, RMAP_INCLUDE_MARK) &&
        rmap_yaml_follow(scene->root, replaced->node, text + first, nbytes, written + first,
                         nbytes + strlen(written) - strlen(text)))
        return;
    rmap_yaml_destroy(scene->root);
    scene->root = NULL;
}

/* On failure the text is as it was. */
static enum rmap_status change_one(struct rmap_scene_text *scene, const char *path,
                                   const json_t *value, struct rmap_error *err)
{
    char *written = NULL;
    size_t n = 0;
    struct rmap_scene_text next = {0};
    struct replaced replaced = {0};
    enum rmap_status st = rmap_scene_text_parse(scene, err);
    FILE *out = st == RMAP_OK ? open_memstream(&written, &n) : NULL;
    if (out)
        st = write_one(out, scene, path, value, &replaced, err);
    if (out && fclose(out) == 0 && st == RMAP_OK)
        next.text = rmap_strdup(written);
    free(written);
    if (st == RMAP_OK && !next.text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text");
    if (next.text && strchr(scene->text, '&')) { /* copies of anchors do not follow */
        st = check_others(scene, &next, replaced.changed, !value, path, err);
    } else if (next.text) {
        follow(scene, &replaced, value, next.text);
        next.root = scene->root;
        next.is_sound = scene->is_sound;
        scene->root = NULL;
    }
    if (st != RMAP_OK) {
        rmap_scene_text_fini(&next);
        return st;
    }
    rmap_scene_text_fini(scene);
    *scene = next;
    return RMAP_OK;
}

void rmap_scene_text_fini(struct rmap_scene_text *scene)
{
    rmap_free(scene->text);
    rmap_yaml_destroy(scene->root);
    *scene = (struct rmap_scene_text){0};
}

static enum rmap_status begin(struct rmap_scene_text *from, struct rmap_scene_text *scene,
                              struct rmap_error *err)
{
    enum rmap_status st = rmap_scene_text_parse(from, err);
    scene->is_sound = from->is_sound;
    if (st == RMAP_OK)
        st = rmap_yaml_duplicate(from->root, &scene->root, err);
    if (st == RMAP_OK && !(scene->text = rmap_strdup(from->text)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text");
    return st;
}

enum rmap_status rmap_scene_text_change(struct rmap_scene_text *from, const json_t *remove,
                                        const json_t *values, struct rmap_scene_text *scene_ret,
                                        struct rmap_error *err)
{
    const char *path;
    json_t *value;
    struct rmap_scene_text now = {0};
    enum rmap_status st = begin(from, &now, err);
    for (size_t i = 0; i < json_array_size(remove) && st == RMAP_OK; i++) {
        path = json_string_value(json_array_get(remove, i));
        st = path ? change_one(&now, path, NULL, err)
                  : rmap_error_set(err, RMAP_USAGE, "'remove' is a list of keys' paths");
    }
    json_object_foreach((json_t *)(uintptr_t)values, path, value)
    {
        if (st == RMAP_OK)
            st = change_one(&now, path, value, err);
    }
    if (st == RMAP_OK)
        *scene_ret = now;
    else
        rmap_scene_text_fini(&now);
    return st;
}
