/* SPDX-License-Identifier: MIT
 *
 * Names of parts in a Wavefront OBJ file.
 */
#include "io/mesh/obj_names.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"

#define PREFIX "part:"

enum { NAME_MAX_NBYTES = 1000 };

struct known {
    uint64_t value; /* of the object and the group's name; 0: free */
    size_t part;
};

struct numbering {
    struct rmap_obj_names *names;
    struct rmap_error *err;
    size_t cap_text, object, n_slot, n_known;
    struct known *slot;
};

static enum rmap_status put(struct numbering *n, const void *text, size_t nbytes)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_obj_names *names = n->names;
    RMAP_TRY(RMAP_RESERVE(names->text, n->cap_text, names->nbytes + nbytes + 1, n->err));
    memcpy(names->text + names->nbytes, text, nbytes);
    names->nbytes += nbytes;
    names->text[names->nbytes] = 0;
out:
    return st;
}

static struct known *find(const struct numbering *n, uint64_t value)
{
    size_t at = (size_t)value & (n->n_slot - 1);
    while (n->slot[at].value && n->slot[at].value != value)
        at = (at + 1) & (n->n_slot - 1);
    return &n->slot[at];
}

static enum rmap_status grow(struct numbering *n)
{
    struct numbering larger = *n;
    larger.n_slot = n->n_slot ? 2 * n->n_slot : 256;
    larger.slot = rmap_alloc(larger.n_slot, sizeof *larger.slot);
    if (!larger.slot)
        return rmap_error_set(n->err, RMAP_SYSTEM, "out of memory for names");
    for (size_t i = 0; i < n->n_slot; i++)
        if (n->slot[i].value)
            *find(&larger, n->slot[i].value) = n->slot[i];
    rmap_free(n->slot);
    *n = larger;
    return RMAP_OK;
}

static enum rmap_status add_name(struct numbering *n, const char *name, size_t nbytes)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_obj_names *names = n->names;
    RMAP_TRY(RMAP_RESERVE(names->name, names->cap, names->n + 1, n->err));
    char *copy = rmap_alloc(nbytes + 1, 1);
    if (!copy)
        return rmap_error_set(n->err, RMAP_SYSTEM, "out of memory for names");
    memcpy(copy, name, nbytes);
    names->name[names->n++] = copy;
out:
    return st;
}

/* The part of an `o` or `g` line of this name. */
static enum rmap_status part_of(struct numbering *n, char kind, const char *name, size_t nbytes,
                                size_t *part)
{
    enum rmap_status st = RMAP_OK;
    *part = n->names->n;
    if (kind == 'o') {
        n->object++;
        return add_name(n, name, nbytes);
    }
    if (2 * (n->n_known + 1) > n->n_slot)
        RMAP_TRY(grow(n));
    const uint64_t value = XXH3_64bits_withSeed(name, nbytes, n->object);
    struct known *known = find(n, value ? value : 1);
    if (known->value) {
        *part = known->part;
        return RMAP_OK;
    }
    RMAP_TRY(add_name(n, name, nbytes));
    *known = (struct known){value ? value : 1, *part};
    n->n_known++;
out:
    return st;
}

/* "o a name" or "g a name"; *name_ret, without blanks at its ends; false: it is neither. */
static bool is_name(const char *line, const char *end, char *kind, const char **name_ret,
                    size_t *nbytes_ret)
{
    while (line < end && (*line == ' ' || *line == '\t'))
        line++;
    if (end - line < 3 || (*line != 'o' && *line != 'g') || (line[1] != ' ' && line[1] != '\t'))
        return false;
    *kind = *line++;
    while (line < end && (unsigned char)*line <= ' ')
        line++;
    while (end > line && (unsigned char)end[-1] <= ' ')
        end--;
    *name_ret = line;
    *nbytes_ret = (size_t)(end - line) < NAME_MAX_NBYTES ? (size_t)(end - line) : NAME_MAX_NBYTES;
    return end > line;
}

enum rmap_status rmap_obj_names_read(const uint8_t *bytes, size_t nbytes,
                                     struct rmap_obj_names *names, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct numbering n = {.names = names, .err = err};
    const char *text = (const char *)bytes, *const end = text + nbytes;
    for (const char *line = text, *next; line < end; line = next) {
        char kind, word[64];
        const char *name, *stop = line + strcspn(line, "\r\n");
        size_t name_nbytes, part;
        stop = stop < end ? stop : end;
        next = stop < end ? stop + 1 : end;
        if (*line == 0) /* nothing is text behind it */
            break;
        if (!is_name(line, stop, &kind, &name, &name_nbytes)) {
            RMAP_TRY(put(&n, line, (size_t)(next - line)));
            continue;
        }
        RMAP_TRY(part_of(&n, kind, name, name_nbytes, &part));
        const int length = snprintf(word, sizeof word, "%c " PREFIX "%zu\n", kind, part);
        RMAP_TRY(put(&n, word, (size_t)length));
    }
out:
    rmap_free(n.slot);
    return st;
}

void rmap_obj_names_fini(struct rmap_obj_names *names)
{
    for (size_t i = 0; i < names->n; i++)
        rmap_free(names->name[i]);
    rmap_free(names->name);
    rmap_free(names->text);
    *names = (struct rmap_obj_names){0};
}

int32_t rmap_obj_part(const struct rmap_obj_names *names, const char *name)
{
    if (!names || strncmp(name, PREFIX, strlen(PREFIX)) != 0)
        return -1;
    const unsigned long part = strtoul(name + strlen(PREFIX), NULL, 10);
    return part < names->n ? (int32_t)part : -1;
}
