/* SPDX-License-Identifier: MIT
 *
 * Complaints of the scene reader, checks of keys, and the reader's memory.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

static void complain(struct rmap_reader *reader, enum rmap_severity severity,
                     const struct rmap_yaml_node *at, const char *format, va_list args)
{
    if (reader->status != RMAP_OK)
        return;
    rmap_diagnostics_vadd(reader->diagnostics, severity, at ? at->line : 0, at ? at->column : 0,
                          format, args);
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
static void list_words(const char *const *word, size_t n_word, char *text, size_t nbytes)
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
    list_words(known, n_known, choices, sizeof choices);
    if (nearest)
        rmap_reader_error(reader, &at, "%s '%.60s' (did you mean '%.60s'?)", what, word, nearest);
    else if (n_known)
        rmap_reader_error(reader, &at, "%s '%.60s'; known: %s", what, word, choices);
    else
        rmap_reader_error(reader, &at, "%s '%.60s': there are none here", what, word);
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

/* Each block begins with the address of the one before it, in a space that keeps what follows
 * aligned for any type. */
union block_head {
    void *before;
    double align_double;
    long double align_long_double;
};

void *rmap_reader_alloc(struct rmap_reader *reader, size_t n, size_t size)
{
    union block_head *head = NULL;
    if (!size || n <= (SIZE_MAX - sizeof(union block_head)) / size)
        head = rmap_alloc(1, sizeof *head + n * size);
    if (!head) {
        rmap_reader_no_memory(reader);
        return NULL;
    }
    head->before = reader->arena;
    reader->arena = head;
    return head + 1;
}

void rmap_reader_release(struct rmap_reader *reader)
{
    for (union block_head *head = reader->arena; head;) {
        union block_head *before = head->before;
        rmap_free(head);
        head = before;
    }
    reader->arena = NULL;
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
