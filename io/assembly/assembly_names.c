/* SPDX-License-Identifier: MIT
 *
 * Ids and names that each stand once.
 */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/assembly/assembly.h"
#include "io/file/publish.h"
#include "io/lensfile/lens_text.h"

enum { LONGEST = 180 };

/* Texts by their hash; borrowed. */
struct taken {
    const char **slot;
    uint32_t *count; /* how often it was wanted */
    size_t n_slot;
};

static enum rmap_status init(struct taken *taken, size_t n, struct rmap_error *err)
{
    taken->n_slot = 16;
    while (taken->n_slot < 3 * n)
        taken->n_slot *= 2;
    taken->slot = rmap_alloc(taken->n_slot, sizeof *taken->slot);
    taken->count = rmap_alloc(taken->n_slot, sizeof *taken->count);
    return taken->slot && taken->count
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu names", n);
}

static void fini(struct taken *taken)
{
    rmap_free(taken->slot);
    rmap_free(taken->count);
}

static size_t slot_of(const struct taken *taken, const char *text)
{
    size_t at = (size_t)XXH3_64bits(text, strlen(text)) & (taken->n_slot - 1);
    while (taken->slot[at] && strcmp(taken->slot[at], text) != 0)
        at = (at + 1) & (taken->n_slot - 1);
    return at;
}

/* The text, or text.2, text.3 ... that is free; takes *text over. */
static enum rmap_status take(struct taken *taken, char **text, struct rmap_error *err)
{
    const size_t first = slot_of(taken, *text), nbytes = strlen(*text) + 24;
    if (taken->slot[first]) {
        char *longer = rmap_alloc(nbytes, 1);
        if (!longer)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
        do
            (void)snprintf(longer, nbytes, "%s.%u", *text, ++taken->count[first]);
        while (taken->slot[slot_of(taken, longer)]);
        rmap_free(*text);
        *text = longer;
    }
    const size_t at = slot_of(taken, *text);
    taken->slot[at] = *text;
    taken->count[at] = 1;
    return RMAP_OK;
}

enum rmap_status rmap_assembly_settle_ids(struct rmap_assembly *assembly, struct rmap_error *err)
{
    struct taken taken = {0};
    enum rmap_status st = init(&taken, assembly->n_part, err);
    for (size_t i = 0; i < assembly->n_part && st == RMAP_OK; i++)
        st = take(&taken, &assembly->part[i].id, err);
    fini(&taken);
    return st;
}

/* What can be a name in a scene and is easy to write in a criterion: blanks are '_'. */
static char *legal(const char *name, const char *otherwise)
{
    char *label = rmap_alloc(LONGEST + 1, 1);
    if (!label)
        return NULL;
    rmap_lens_copy(label, LONGEST, name);
    for (char *at = label; *at; at++)
        if (*at == ' ' || strchr("*?'\"\\`", *at))
            *at = '_';
    if (!label[0])
        (void)snprintf(label, LONGEST, "%s", otherwise);
    return label;
}

/* Numbers of before come first; of what is new, the hash of its id, or of that and a count. */
static enum rmap_status settle_numbers(struct rmap_assembly *a, struct rmap_error *err)
{
    size_t n_slot = 16;
    while (n_slot < 3 * a->n_part)
        n_slot *= 2;
    uint64_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", a->n_part);
    for (int round = 0; round < 2; round++)
        for (size_t i = 0; i < a->n_part; i++) {
            uint64_t number = a->part[i].number;
            if ((number != 0) != (round == 0))
                continue;
            for (uint64_t k = 0;; k++) {
                if (number == 0 || k > 0)
                    number = XXH3_64bits_withSeed(a->part[i].id, strlen(a->part[i].id), k);
                size_t at = (size_t)number & (n_slot - 1);
                while (slot[at] && slot[at] != number)
                    at = (at + 1) & (n_slot - 1);
                if (slot[at] || number == 0)
                    continue;
                slot[at] = a->part[i].number = number;
                break;
            }
        }
    rmap_free(slot);
    return RMAP_OK;
}

enum rmap_status rmap_assembly_settle_labels(struct rmap_assembly *assembly, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct taken taken = {0};
    bool *had = rmap_alloc(assembly->n_part, sizeof *had);
    if (!had)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    for (size_t i = 0; i < assembly->n_part; i++)
        had[i] = assembly->part[i].label && assembly->part[i].label[0];
    RMAP_TRY(init(&taken, assembly->n_part, err));
    /* Those of before come first. */
    for (int round = 0; round < 2; round++)
        for (size_t i = 0; i < assembly->n_part && st == RMAP_OK; i++) {
            struct rmap_assembly_part *part = &assembly->part[i];
            if (had[i] != (round == 0))
                continue;
            char *label =
                legal(round == 0 ? part->label : part->name, part->shape >= 0 ? "part" : "group");
            if (!label)
                RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name"));
            rmap_free(part->label);
            part->label = label;
            st = take(&taken, &part->label, err);
        }
    if (st == RMAP_OK)
        st = settle_numbers(assembly, err);
out:
    rmap_free(had);
    fini(&taken);
    return st;
}

/* ---- files ---- */

static char *stem_of(const struct rmap_assembly_shape *shape)
{
    enum { FILE_LONGEST = 60 };
    const bool has = shape->file && shape->file[0];
    char *stem = has ? rmap_strdup(shape->file) : rmap_alloc(FILE_LONGEST + 1, 1);
    size_t n = 0;
    if (!stem)
        return NULL;
    for (const char *at = shape->name; !has && *at && n < FILE_LONGEST; at++) {
        const bool plain = isalnum((unsigned char)*at) || *at == '-' || *at == '_';
        if (plain || (n > 0 && stem[n - 1] != '_'))
            stem[n++] = plain ? (char)tolower((unsigned char)*at) : '_';
    }
    if (has)
        stem[strlen(stem) - strlen(".ply")] = 0;
    else if (n == 0 || stem[0] == '-')
        (void)snprintf(stem, FILE_LONGEST, "shape");
    return stem;
}

enum rmap_status rmap_assembly_settle_files(struct rmap_assembly *a, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct taken taken = {0};
    char **stem = rmap_alloc(a->n_shape, sizeof *stem);
    if (!stem)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    RMAP_TRY(init(&taken, a->n_shape, err));
    for (int round = 0; round < 2; round++) /* those of before come first */
        for (size_t i = 0; i < a->n_shape && st == RMAP_OK; i++) {
            const bool has = a->shape[i].file && a->shape[i].file[0];
            if (stem[i] || has != (round == 0))
                continue;
            stem[i] = stem_of(&a->shape[i]);
            st = stem[i] ? take(&taken, &stem[i], err)
                         : rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
        }
    for (size_t i = 0; i < a->n_shape && st == RMAP_OK; i++) {
        rmap_free(a->shape[i].file);
        a->shape[i].file = rmap_path_format("%s.ply", stem[i]);
        if (!a->shape[i].file)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    }
out:
    for (size_t i = 0; i < a->n_shape; i++)
        rmap_free(stem[i]);
    rmap_free(stem);
    fini(&taken);
    return st;
}
