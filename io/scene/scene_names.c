/* SPDX-License-Identifier: MIT
 *
 * Names of a scene, hashed: a scene may have a hundred thousand objects.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

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
