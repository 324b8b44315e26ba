/* SPDX-License-Identifier: MIT
 *
 * What the parts of the scene reader (scene_*.c, one per section of the file) share: the reader's
 * state, complaints that say where and what to do, names; typed values are in scene_values.h.
 */
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

/* Complaints of the scene reader, checks of keys, and the reader's memory. */

static void complain(struct rmap_reader *reader, enum rmap_severity severity,
                     const struct rmap_yaml_node *at, const char *format, va_list args)
{
    const struct rmap_scene_options *options = &reader->bundle->options;
    char text[RMAP_ERROR_TEXT_LEN];
    if (reader->status != RMAP_OK)
        return;
    if (!at || at->line >= 0 || (size_t)-at->line > options->n_set) {
        rmap_diagnostics_vadd(reader->diagnostics, severity, at ? at->line : 0, at ? at->column : 0,
                              format, args);
        return;
    }
    (void)vsnprintf(text, sizeof text, format, args);
    rmap_diagnostics_add(reader->diagnostics, severity, 0, 0, "--set %.100s: %s",
                         options->set[-at->line - 1], text);
}

void rmap_reader_error(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const char *format, ...)
{
    va_list args;
    va_start(args, format);
    complain(reader, RMAP_SEVERITY_ERROR, at, format, args);
    va_end(args);
}

void rmap_reader_warn(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                      const char *format, ...)
{
    va_list args;
    va_start(args, format);
    complain(reader, RMAP_SEVERITY_WARNING, at, format, args);
    va_end(args);
}

/* "a, b, c" into text; more than fit end with "...". */
void rmap_words_list(const char *const *word, size_t n_word, char *text, size_t nbytes)
{
    size_t used = 0;
    text[0] = 0;
    for (size_t i = 0; i < n_word; i++) {
        bool room = used + strlen(word[i]) + 8 < nbytes;
        int wrote =
            snprintf(text + used, nbytes - used, "%s%s", i ? ", " : "", room ? word[i] : "...");
        if (wrote < 0 || !room)
            return;
        used += (size_t)wrote;
    }
}

void rmap_reader_unknown(struct rmap_reader *reader, int line, int column, const char *what,
                         const char *word, const char *const *known, size_t n_known)
{
    const struct rmap_yaml_node at = {.line = line, .column = column};
    if (rmap_diagnostics_full(reader->diagnostics)) {
        rmap_reader_error(reader, &at, "%s", what);
        return;
    }
    const char *nearest = rmap_nearest_word(word, known, n_known);
    char choices[400];
    rmap_words_list(known, n_known, choices, sizeof choices);
    if (nearest)
        rmap_reader_error(reader, &at, "%s '%.60s' (did you mean '%.60s'?)", what, word, nearest);
    else if (n_known)
        rmap_reader_error(reader, &at, "%s '%.60s'; known: %s", what, word, choices);
    else
        rmap_reader_error(reader, &at, "%s '%.60s': there are none here", what, word);
}

/* Of {radius: 0,5} the 5: a key with nothing behind it. */
static bool is_decimal_tail(const struct rmap_yaml_item *item)
{
    return isdigit((unsigned char)item->key[0]) && item->value->kind == RMAP_YAML_SCALAR &&
           !item->value->text[0];
}

bool rmap_reader_check_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what, const char *const *known, size_t n_known)
{
    if (node->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, node, "%s must be a mapping of keys and values", what);
        return false;
    }
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        bool found = false;
        for (size_t k = 0; k < n_known && !found; k++)
            found = strcmp(item->key, known[k]) == 0;
        if (found)
            continue;
        if (i > 0 && is_decimal_tail(item)) {
            const struct rmap_yaml_node at = {.line = item->line, .column = item->column};
            const char *before = node->item[i - 1].value->text;
            rmap_reader_error(reader, &at,
                              "'%.40s,%.40s' is no number: decimals have a point, not a comma",
                              before ? before : "", item->key);
            continue;
        }
        char text[120];
        (void)snprintf(text, sizeof text, "unknown key in %s:", what);
        rmap_reader_unknown(reader, item->line, item->column, text, item->key, known, n_known);
    }
    return true;
}

bool rmap_reader_check_map(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *what, const char *keys)
{
    struct rmap_words known;
    bool all = node->kind == RMAP_YAML_MAP;
    for (size_t i = 0; all && i < node->n_item; i++)
        all = rmap_words_have(keys, node->item[i].key);
    if (all)
        return true;
    rmap_words_split(keys, &known);
    return rmap_reader_check_keys(reader, node, what, known.word, known.n);
}

void rmap_words_split(const char *text, struct rmap_words *words)
{
    char *rest = words->text;
    words->n = 0;
    (void)snprintf(words->text, sizeof words->text, "%s", text);
    for (char *word; words->n < RMAP_COUNT(words->word) && (word = strtok_r(rest, " ", &rest));) {
        size_t same = 0;
        while (same < words->n && strcmp(words->word[same], word) != 0)
            same++;
        words->word[same] = word;
        words->n += same == words->n;
    }
}

bool rmap_words_have(const char *text, const char *word)
{
    const size_t len = strlen(word);
    const char *at = len > 0 && !strchr(word, ' ') ? strstr(text, word) : NULL;
    while (at && ((at > text && at[-1] != ' ') || (at[len] && at[len] != ' ')))
        at = strstr(at + 1, word);
    return at != NULL;
}

bool rmap_reader_check_list(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what)
{
    if (node->kind == RMAP_YAML_LIST)
        return true;
    rmap_reader_error(reader, node, "%s must be a list", what);
    return false;
}

void rmap_reader_fail(struct rmap_reader *reader, enum rmap_status status)
{
    if (reader->status == RMAP_OK && reader->err)
        *reader->err = reader->failure;
    if (reader->status == RMAP_OK)
        reader->status = status;
}

void rmap_reader_no_memory(struct rmap_reader *reader)
{
    rmap_reader_fail(reader, rmap_error_set(&reader->failure, RMAP_SYSTEM,
                                            "out of memory while reading the scene"));
}

void rmap_reader_made(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      enum rmap_status status)
{
    if (status == RMAP_INPUT)
        rmap_reader_error(reader, node, "%s", reader->failure.text);
    else if (status != RMAP_OK)
        rmap_reader_fail(reader, status);
}

void *rmap_reader_alloc(struct rmap_reader *reader, size_t n, size_t size)
{
    void *memory = rmap_pool_alloc(&reader->arena, n, size);
    if (memory)
        memset(memory, 0, n * size);
    else
        rmap_reader_no_memory(reader);
    return memory;
}

void rmap_reader_release(struct rmap_reader *reader)
{
    rmap_pool_fini(&reader->arena);
}

char *rmap_reader_strdup(struct rmap_reader *reader, const char *text)
{
    char *copy = rmap_strdup(text);
    if (!copy)
        rmap_reader_no_memory(reader);
    return copy;
}

bool rmap_reader_room(struct rmap_reader *reader, void *array_address, size_t *cap, size_t n,
                      size_t size)
{
    char *array;
    if (rmap_reserve_array(array_address, cap, n + 1, size, NULL) != RMAP_OK) {
        rmap_reader_no_memory(reader);
        return false;
    }
    memcpy(&array, array_address, sizeof array);
    memset(array + n * size, 0, size);
    return true;
}

/* Names of a scene, hashed: a scene may have a hundred thousand objects. */

static size_t find_slot(const struct rmap_names *names, const char *text)
{
    size_t mask = names->n_slot - 1;
    size_t slot = (size_t)XXH3_64bits(text, strlen(text)) & mask;
    while (names->slot[slot] && strcmp(names->name[names->slot[slot] - 1].text, text) != 0)
        slot = (slot + 1) & mask;
    return slot;
}

static enum rmap_status grow(struct rmap_names *names, struct rmap_error *err)
{
    size_t n_slot = names->n_slot ? 2 * names->n_slot : 64;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu names", names->n);
    rmap_free(names->slot);
    names->slot = slot;
    names->n_slot = n_slot;
    for (size_t i = 0; i < names->n; i++)
        names->slot[find_slot(names, names->name[i].text)] = (uint32_t)(i + 1);
    return RMAP_OK;
}

const struct rmap_name *rmap_names_find(const struct rmap_names *names, const char *text)
{
    if (!names->n_slot)
        return NULL;
    uint32_t entry = names->slot[find_slot(names, text)];
    return entry ? &names->name[entry - 1] : NULL;
}

enum rmap_status rmap_names_add(struct rmap_names *names, const char *text, int32_t kind,
                                int32_t index, int32_t line, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (2 * (names->n + 1) > names->n_slot)
        RMAP_TRY(grow(names, err));
    RMAP_TRY(RMAP_RESERVE(names->name, names->cap, names->n + 1, err));
    size_t slot = find_slot(names, text);
    names->name[names->n++] = (struct rmap_name){text, kind, index, line};
    names->slot[slot] = (uint32_t)names->n;
out:
    return st;
}

void rmap_names_fini(struct rmap_names *names)
{
    rmap_free(names->name);
    rmap_free(names->slot);
    *names = (struct rmap_names){0};
}

void rmap_reader_add_name(struct rmap_reader *reader, struct rmap_names *names, const char *text,
                          int32_t kind, int32_t index, int32_t line)
{
    if (!text || rmap_names_add(names, text, kind, index, line, &reader->failure) != RMAP_OK)
        rmap_reader_fail(reader, RMAP_SYSTEM);
}

static bool is_receiver(const struct rmap_reader *reader, const struct rmap_name *name)
{
    return name->kind == RMAP_MEMBER_DETECTOR &&
           (size_t)name->index >= reader->scene->n_detector - reader->n_receiver;
}

void rmap_reader_add_member(struct rmap_reader *reader, const char *name, enum rmap_member kind,
                            int32_t index, const struct rmap_yaml_node *at)
{
    static const char *const word[] = {"object", "group", "source", "detector"};
    if (!name || name[0] == RMAP_UNNAMED[0])
        return;
    const struct rmap_name *taken = rmap_names_find(&reader->members, name);
    bool elsewhere = taken && reader->n_receiver > 0 && !is_receiver(reader, taken);
    if (elsewhere) {
        rmap_reader_error(reader, at, "the name '%.60s' is taken by a %s of the map's scene", name,
                          word[taken->kind]);
        return;
    }
    if (taken) {
        rmap_reader_error(reader, at,
                          "the name '%.60s' is taken by the %s on line %d: names are unique over "
                          "objects, groups, sources and detectors",
                          name, word[taken->kind], (int)taken->line);
        return;
    }
    rmap_reader_add_name(reader, &reader->members, name, (int32_t)kind, index, at ? at->line : 0);
}

int32_t rmap_reader_find(struct rmap_reader *reader, const struct rmap_names *names,
                         const char *what, const struct rmap_yaml_node *at, const char *text)
{
    const struct rmap_name *name = rmap_names_find(names, text);
    if (name)
        return name->index;
    char kind[80];
    (void)snprintf(kind, sizeof kind, "unknown %s", what);
    const char **word = rmap_alloc(names->n, sizeof *word);
    for (size_t i = 0; word && i < names->n; i++)
        word[i] = names->name[i].text;
    rmap_reader_unknown(reader, at->line, at->column, kind, text, word, word ? names->n : 0);
    rmap_free(word);
    return -1;
}

const struct rmap_name *rmap_reader_find_body(struct rmap_reader *reader, const char *what,
                                              const struct rmap_yaml_node *at, const char *text)
{
    const struct rmap_name *name = rmap_names_find(&reader->members, text);
    if (!name)
        (void)rmap_reader_find(reader, &reader->members, what, at, text);
    else if (name->kind != RMAP_MEMBER_OBJECT && name->kind != RMAP_MEMBER_GROUP)
        rmap_reader_error(reader, at, "'%.60s' is no object or group", text);
    else
        return name;
    return NULL;
}

void rmap_reader_each_named(struct rmap_reader *reader, const char *section, const char *one,
                            const struct rmap_names *names,
                            void (*read)(struct rmap_reader *reader,
                                         const struct rmap_yaml_item *item))
{
    const struct rmap_yaml_node *node = rmap_yaml_get(reader->root, section);
    if (node && node->kind != RMAP_YAML_MAP)
        rmap_reader_error(reader, node, "%s must be a mapping {name: %s, ...}", section, one);
    else
        for (size_t i = 0; node && i < node->n_item && reader->status == RMAP_OK; i++) {
            const struct rmap_yaml_item *item = &node->item[i];
            const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
            if (!rmap_names_find(names, item->key) &&
                rmap_reader_check_name(reader, &place, item->key))
                read(reader, item);
        }
}
