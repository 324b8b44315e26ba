/* SPDX-License-Identifier: MIT
 *
 * libyaml's events become nodes. Aliases are expanded to copies, within a budget, so that the rest
 * of the program sees a plain tree.
 */
#include "io/scene/yaml_tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "base/alloc.h"
#include "io/scene/scene_include.h"
#include "io/scene/scene_reader.h"

struct builder {
    struct rmap_yaml_node *in; /* of the tree */
    yaml_parser_t parser;
    struct rmap_diagnostics *diagnostics;
    struct rmap_error *err;
    const char *text; /* ends with 0 */
    size_t n_node, n_left /* to be copied */, n_part;
    const struct rmap_yaml_node **anchor; /* in the tree */
    size_t n_anchor, cap_anchor;
    struct rmap_yaml_item *open; /* items of lists and mappings that are being read */
    size_t n_open, cap_open;
    struct rmap_names names; /* of anchors; of those with one name the last one counts */
};

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory while reading YAML");
}

/* The reader's errors (bad UTF-8) have an offset in place of a line. */
static yaml_mark_t mark_of_offset(const char *text, size_t offset)
{
    yaml_mark_t mark = {.index = offset};
    for (size_t i = 0; i < offset; i++) {
        mark.column++;
        if (text[i] == '\n') {
            mark.line++;
            mark.column = 0;
        }
    }
    return mark;
}

/* The n-th line from 0 on; NULL where there are not so many. */
static const char *line_of(const char *text, size_t n)
{
    for (size_t i = 0; i < n && text; i++) {
        text = strchr(text, '\n');
        text += text != NULL;
    }
    return text;
}

/* A tab that indents; a bracket that is never closed, for which the parser points at the end of
 * what it swallowed. */
static void tell_remedy(const struct builder *b, yaml_mark_t mark, char *remedy, size_t nbytes)
{
    const yaml_parser_t *parser = &b->parser;
    const char *line = line_of(b->text, mark.line);
    remedy[0] = 0;
    if (line && line[strspn(line, " ")] == '\t')
        (void)snprintf(remedy, nbytes, " (a tab indents this line: indent with spaces)");
    else if (parser->context &&
             (strstr(parser->context, "flow mapping") || strstr(parser->context, "flow sequence") ||
              strstr(parser->context, "quoted")))
        (void)snprintf(remedy, nbytes, ": what is opened in line %zu, column %zu is not closed",
                       parser->context_mark.line + 1, parser->context_mark.column + 1);
}

static enum rmap_status syntax_error(struct builder *b)
{
    yaml_parser_t *parser = &b->parser;
    if (parser->error == YAML_MEMORY_ERROR)
        return no_memory(b->err);
    yaml_mark_t mark = parser->problem_mark;
    if (parser->error == YAML_READER_ERROR)
        mark = mark_of_offset(b->text, parser->problem_offset);
    char remedy[80];
    tell_remedy(b, mark, remedy, sizeof remedy);
    rmap_diagnostics_add(
        b->diagnostics, RMAP_SEVERITY_ERROR, (int)mark.line + 1, (int)mark.column + 1,
        "this is not YAML: %s%s%s%s", parser->problem ? parser->problem : "unreadable",
        parser->context ? " " : "", parser->context ? parser->context : "", remedy);
    return rmap_error_set(b->err, RMAP_INPUT, "not a YAML document");
}

static enum rmap_status next_event(struct builder *b, yaml_event_t *event)
{
    if (!yaml_parser_parse(&b->parser, event))
        return syntax_error(b);
    return RMAP_OK;
}

/* A complaint that ends the reading. */
static enum rmap_status give_up(struct builder *b, yaml_mark_t mark, const char *text)
{
    rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, (int)mark.line + 1,
                         (int)mark.column + 1, "%s", text);
    return rmap_error_set(b->err, RMAP_INPUT, "the YAML text is refused: %s", text);
}

static enum rmap_status copy(struct builder *b, const struct rmap_yaml_node *from, yaml_mark_t mark,
                             int depth, struct rmap_yaml_node **node_ret)
{
    struct rmap_error why;
    const enum rmap_status st = rmap_yaml_copy_some(b->in, from, depth, &b->n_left, node_ret, &why);
    return st == RMAP_INPUT ? give_up(b, mark, why.text) : st == RMAP_OK ? st : no_memory(b->err);
}

static enum rmap_status expand_alias(struct builder *b, const yaml_event_t *event, int depth,
                                     struct rmap_yaml_node **node_ret)
{
    const struct rmap_name *name =
        rmap_names_find(&b->names, (const char *)event->data.alias.anchor);
    if (!name)
        return give_up(b, event->start_mark, RMAP_YAML_NO_ANCHOR);
    const enum rmap_status st = copy(b, b->anchor[name->index], event->start_mark, depth, node_ret);
    if (st == RMAP_OK)
        (*node_ret)->aliased = true;
    return st;
}

static enum rmap_status remember_anchor(struct builder *b, const char *name,
                                        const struct rmap_yaml_node *node)
{
    void *anchor = b->anchor;
    if (rmap_reserve(&anchor, &b->cap_anchor, b->n_anchor + 1, sizeof *b->anchor, b->err) !=
        RMAP_OK)
        return RMAP_SYSTEM;
    b->anchor = anchor;
    char *copy = rmap_pool_strdup(b->in->pool, name);
    if (!copy)
        return no_memory(b->err);
    b->anchor[b->n_anchor++] = node;
    return rmap_names_add(&b->names, copy, 0, (int32_t)(b->n_anchor - 1), 0, b->err);
}

struct key_place {
    const char *key;
    size_t index;
};

static int by_key(const void *a, const void *b)
{
    const struct key_place *left = a, *right = b;
    int order = strcmp(left->key, right->key);
    if (order)
        return order;
    return left->index < right->index ? -1 : left->index > right->index;
}

static bool has_same_keys(const struct rmap_yaml_node *map)
{
    for (size_t i = 1; i < map->n_item; i++)
        for (size_t k = 0; k < i; k++)
            if (strcmp(map->item[i].key, map->item[k].key) == 0)
                return true;
    return false;
}

/* Few keys are compared each with each; sorting keeps a mapping of a million cheap to check. */
static enum rmap_status check_duplicate_keys(struct builder *b, const struct rmap_yaml_node *map)
{
    if (map->n_item < 16 && !has_same_keys(map))
        return RMAP_OK;
    struct key_place *place = rmap_alloc(map->n_item, sizeof *place);
    if (!place)
        return no_memory(b->err);
    for (size_t i = 0; i < map->n_item; i++)
        place[i] = (struct key_place){map->item[i].key, i};
    qsort(place, map->n_item, sizeof *place, by_key);
    size_t first = 0;
    for (size_t i = 1; i < map->n_item; i++) {
        if (strcmp(place[i].key, place[first].key) != 0) {
            first = i;
            continue;
        }
        const struct rmap_yaml_item *item = &map->item[place[i].index];
        rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, item->line, item->column,
                             "duplicate key '%.60s' (first on line %d): remove or rename one",
                             item->key, map->item[place[first].index].line);
    }
    rmap_free(place);
    return RMAP_OK;
}

/* Copies the keys of `base` that the mapping does not have behind its own. */
static enum rmap_status take_keys(struct builder *b, struct rmap_yaml_node *map,
                                  struct rmap_names *own, const struct rmap_yaml_node *base,
                                  yaml_mark_t mark, int depth)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < base->n_item && st == RMAP_OK; i++) {
        const struct rmap_yaml_item *item = &base->item[i];
        struct rmap_yaml_node *value = NULL;
        if (rmap_names_find(own, item->key))
            continue;
        st = copy(b, item->value, mark, depth, &value);
        if (st == RMAP_OK)
            value->merged = true;
        if (st == RMAP_OK)
            st = rmap_yaml_append(map, item->key, item->line, item->column, value, b->err);
        if (st == RMAP_OK)
            st = rmap_names_add(own, map->item[map->n_item - 1].key, 0, 0, 0, b->err);
    }
    return st;
}

/* `<<: *base` or `<<: [*first, *second]` (YAML's merge key): own keys and earlier bases count. */
static enum rmap_status merge_keys(struct builder *b, struct rmap_yaml_node *map, int depth)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_names own = {0};
    size_t at = 0;
    while (at < map->n_item && strcmp(map->item[at].key, "<<") != 0)
        at++;
    if (at == map->n_item)
        return RMAP_OK;
    const struct rmap_yaml_item merge = map->item[at];
    rmap_yaml_remove(map, at);
    const struct rmap_yaml_item alone = {.value = merge.value};
    bool list = merge.value->kind == RMAP_YAML_LIST;
    const struct rmap_yaml_item *base = list ? merge.value->item : &alone;
    const yaml_mark_t mark = {.line = (size_t)merge.line - 1, .column = (size_t)merge.column - 1};
    for (size_t i = 0; i < map->n_item; i++)
        RMAP_TRY(rmap_names_add(&own, map->item[i].key, 0, 0, 0, b->err));
    for (size_t i = 0; i < (list ? merge.value->n_item : 1); i++)
        if (base[i].value->kind == RMAP_YAML_MAP)
            RMAP_TRY(take_keys(b, map, &own, base[i].value, mark, depth + 1));
        else
            rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, merge.line, merge.column,
                                 "'<<' takes the keys of a mapping or of a list of mappings, as in "
                                 "<<: *base");
out:
    rmap_names_fini(&own);
    return st;
}

static enum rmap_status build(struct builder *b, const yaml_event_t *event, int depth,
                              struct rmap_yaml_node **node_ret);

/* With its key, or behind the items before it. */
static enum rmap_status read_item(struct builder *b, const yaml_event_t *event,
                                  const yaml_event_t *key, int depth)
{
    enum rmap_status st = RMAP_OK;
    const yaml_mark_t mark = key ? key->start_mark : event->start_mark;
    struct rmap_yaml_item item = {.line = (int)mark.line + 1, .column = (int)mark.column + 1};
    RMAP_TRY(build(b, event, depth, &item.value));
    if (key && !(item.key = rmap_pool_strdup(b->in->pool, (const char *)key->data.scalar.value)))
        RMAP_TRY(no_memory(b->err));
    RMAP_TRY(RMAP_RESERVE(b->open, b->cap_open, b->n_open + 1, b->err));
    b->open[b->n_open++] = item;
out:
    return st;
}

/* The items from the first-th that is open on are all that the node has. */
static enum rmap_status close_node(struct builder *b, struct rmap_yaml_node *node, size_t first)
{
    const size_t n = b->n_open - first;
    node->item = rmap_pool_alloc(b->in->pool, n, sizeof *node->item);
    if (!node->item)
        return no_memory(b->err);
    if (n > 0)
        memcpy(node->item, &b->open[first], n * sizeof *node->item);
    node->n_item = node->cap_item = n;
    b->n_open = first;
    return RMAP_OK;
}

static enum rmap_status build_list(struct builder *b, struct rmap_yaml_node *node, int depth)
{
    enum rmap_status st = RMAP_OK;
    const size_t first = b->n_open;
    for (bool end = false; !end && st == RMAP_OK;) {
        yaml_event_t event;
        RMAP_TRY(next_event(b, &event));
        end = event.type == YAML_SEQUENCE_END_EVENT;
        if (!end)
            st = read_item(b, &event, NULL, depth + 1);
        yaml_event_delete(&event);
    }
    RMAP_TRY(st);
    st = close_node(b, node, first);
out:
    return st;
}

static enum rmap_status build_map(struct builder *b, struct rmap_yaml_node *node, int depth)
{
    enum rmap_status st = RMAP_OK;
    const size_t first = b->n_open;
    while (st == RMAP_OK) {
        yaml_event_t key, event;
        RMAP_TRY(next_event(b, &key));
        if (key.type == YAML_MAPPING_END_EVENT) {
            yaml_event_delete(&key);
            RMAP_TRY(close_node(b, node, first));
            RMAP_TRY(check_duplicate_keys(b, node));
            return merge_keys(b, node, depth);
        }
        if (key.type != YAML_SCALAR_EVENT)
            st = give_up(b, key.start_mark, "a key must be a plain word");
        else if (strlen((const char *)key.data.scalar.value) != key.data.scalar.length)
            st = give_up(b, key.start_mark, "a NUL character in a key");
        if (st == RMAP_OK)
            st = next_event(b, &event);
        if (st == RMAP_OK) {
            st = read_item(b, &event, &key, depth + 1);
            yaml_event_delete(&event);
        }
        yaml_event_delete(&key);
    }
out:
    return st;
}

static enum rmap_status build_scalar(struct builder *b, const yaml_event_t *event,
                                     struct rmap_yaml_node *node)
{
    const char *text = (const char *)event->data.scalar.value;
    if (strlen(text) != event->data.scalar.length)
        return give_up(b, event->start_mark, "a NUL character in a value");
    node->kind = RMAP_YAML_SCALAR;
    node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text = rmap_pool_strdup(b->in->pool, text);
    return node->text ? RMAP_OK : no_memory(b->err);
}

static enum rmap_status build(struct builder *b, const yaml_event_t *event, int depth,
                              struct rmap_yaml_node **node_ret)
{
    enum rmap_status st = RMAP_OK;
    if (depth > RMAP_YAML_DEPTH_MAX)
        return give_up(b, event->start_mark, RMAP_YAML_TOO_DEEP);
    if (event->type == YAML_ALIAS_EVENT)
        return expand_alias(b, event, depth, node_ret);
    if (++b->n_node > RMAP_YAML_NODE_MAX)
        return give_up(b, event->start_mark, "more than 4,000,000 values");
    struct rmap_yaml_node *node =
        rmap_yaml_new(b->in, RMAP_YAML_SCALAR, (int)event->start_mark.line + 1,
                      (int)event->start_mark.column + 1);
    if (!node)
        return no_memory(b->err);
    const yaml_char_t *anchor = NULL;
    if (event->type == YAML_SCALAR_EVENT) {
        anchor = event->data.scalar.anchor;
        RMAP_TRY(build_scalar(b, event, node));
    } else if (event->type == YAML_SEQUENCE_START_EVENT) {
        anchor = event->data.sequence_start.anchor;
        node->kind = RMAP_YAML_LIST;
        RMAP_TRY(build_list(b, node, depth));
    } else {
        anchor = event->data.mapping_start.anchor;
        node->kind = RMAP_YAML_MAP;
        RMAP_TRY(build_map(b, node, depth));
    }
    if (anchor)
        RMAP_TRY(remember_anchor(b, (const char *)anchor, node));
    *node_ret = node;
out:
    return st;
}

/* True where the document is a file that the scene includes: lines from the next one on are its
 * own. */
static bool begins_part(struct builder *b, yaml_mark_t mark)
{
    static const char sign[] = RMAP_INCLUDE_MARK;
    const char *line = line_of(b->text, mark.line);
    if (!line || strncmp(line, sign, sizeof sign - 1) != 0 || ++b->n_part > RMAP_INCLUDE_MAX)
        return false;
    line += sizeof sign - 1;
    rmap_diagnostics_begin_part(b->diagnostics, (int)mark.line + 2, line, strcspn(line, "\n"));
    return true;
}

/* A key behind which nothing stands is as good as none. */
static void drop_nothing(struct rmap_yaml_node *map)
{
    size_t n = 0;
    for (size_t i = 0; i < map->n_item; i++)
        if (!rmap_yaml_is_nothing(map->item[i].value))
            map->item[n++] = map->item[i];
    map->n_item = n;
}

/* Lists of the part go behind those of the whole, keys of its mappings beside those. */
static enum rmap_status join(struct builder *b, struct rmap_yaml_node *whole,
                             const struct rmap_yaml_node *part)
{
    enum rmap_status st = RMAP_OK;
    if (part->kind != RMAP_YAML_MAP || whole->kind != RMAP_YAML_MAP) {
        rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, part->line, part->column,
                             "an included file must be a mapping, as a scene is");
        return RMAP_OK;
    }
    drop_nothing(whole);
    for (size_t i = 0; i < part->n_item && st == RMAP_OK; i++) {
        const struct rmap_yaml_item *item = &part->item[i];
        struct rmap_yaml_node *value = item->value, *own = rmap_yaml_get(whole, item->key);
        if (strcmp(item->key, "raymap") == 0 || rmap_yaml_is_nothing(value))
            continue;
        if (strcmp(item->key, "include") == 0 ||
            (own && (own->kind != value->kind || own->kind == RMAP_YAML_SCALAR))) {
            rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, item->line, item->column,
                                 strcmp(item->key, "include") == 0
                                     ? "an included file includes no other: name it in the scene"
                                     : "'%.60s' stands in the scene, too: take one of them away",
                                 item->key);
            continue;
        }
        if (!own) {
            st = rmap_yaml_append(whole, item->key, item->line, item->column, value, b->err);
            continue;
        }
        for (size_t k = 0; k < value->n_item && st == RMAP_OK; k++) {
            const struct rmap_yaml_item *inner = &value->item[k];
            st =
                rmap_yaml_append(own, inner->key, inner->line, inner->column, inner->value, b->err);
        }
        if (st == RMAP_OK && own->kind == RMAP_YAML_MAP)
            st = check_duplicate_keys(b, own);
    }
    return st;
}

/* Stream start, one document and the parts that it includes, stream end. */
static enum rmap_status build_document(struct builder *b, struct rmap_yaml_node **root_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_yaml_node *root = NULL, *part = NULL;
    for (bool end = false; !end;) {
        yaml_event_t event;
        RMAP_TRY(next_event(b, &event));
        yaml_event_type_t type = event.type;
        end = type == YAML_STREAM_END_EVENT;
        if (type == YAML_DOCUMENT_START_EVENT && root && !begins_part(b, event.start_mark))
            st = give_up(b, event.start_mark, "a second document: a scene is one document");
        else if (type == YAML_SCALAR_EVENT || type == YAML_SEQUENCE_START_EVENT ||
                 type == YAML_MAPPING_START_EVENT || type == YAML_ALIAS_EVENT)
            st = build(b, &event, 1, root ? &part : &root);
        yaml_event_delete(&event);
        if (part && st == RMAP_OK)
            st = join(b, root, part);
        part = NULL;
        if (st != RMAP_OK)
            goto out;
    }
    if (!root) {
        rmap_diagnostics_add(b->diagnostics, RMAP_SEVERITY_ERROR, 0, 0, "the text is empty");
        RMAP_TRY(rmap_error_set(b->err, RMAP_INPUT, "the text is empty"));
    }
    *root_ret = root;
out:
    return st;
}

enum rmap_status rmap_yaml_parse(const char *text, size_t nbytes, struct rmap_yaml_node **root_ret,
                                 struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    /* Some editors begin a file with the byte order mark; columns are counted without it. */
    if (nbytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        text += 3;
        nbytes -= 3;
    }
    char *copy = rmap_alloc(nbytes + 1, 1);
    struct builder b = {.in = rmap_yaml_create(),
                        .diagnostics = diagnostics,
                        .err = err,
                        .n_left = RMAP_YAML_COPY_MAX,
                        .text = copy};
    if (!copy || !b.in || !yaml_parser_initialize(&b.parser)) {
        rmap_free(copy);
        rmap_yaml_destroy(b.in);
        return no_memory(err);
    }
    if (nbytes > 0)
        memcpy(copy, text, nbytes);
    yaml_parser_set_encoding(&b.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&b.parser, (const unsigned char *)text, nbytes);
    enum rmap_status st = build_document(&b, root_ret);
    if (st != RMAP_OK)
        rmap_yaml_destroy(b.in);
    rmap_free(b.open);
    rmap_free(b.anchor);
    rmap_names_fini(&b.names);
    yaml_parser_delete(&b.parser);
    rmap_free(copy);
    return st;
}
