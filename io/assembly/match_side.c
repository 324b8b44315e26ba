/* SPDX-License-Identifier: MIT
 *
 * What parts of a revision are looked for by.
 */
#include "io/assembly/match_side.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"

int rmap_part_key_compare(const void *a, const void *b)
{
    const struct rmap_part_key *x = a, *y = b;
    if (x->value != y->value)
        return x->value < y->value ? -1 : 1;
    return (x->part > y->part) - (x->part < y->part);
}

uint64_t rmap_match_text(const char *text)
{
    return XXH3_64bits(text, strlen(text));
}

uint64_t rmap_match_mix(uint64_t a, uint64_t b)
{
    const uint64_t both[2] = {a, b};
    const uint64_t hash = XXH3_64bits(both, sizeof both);
    return hash ? hash : 1;
}

bool rmap_assembly_is_numbered(const struct rmap_assembly *a, size_t i)
{
    const struct rmap_assembly_part *part = &a->part[i];
    const char *above = part->parent < 0 ? "" : a->part[part->parent].name,
               *step = strrchr(part->id, '/');
    const size_t n = strlen(above);
    return n > 0 && step && step[1] && strspn(step + 1, "0123456789") == strlen(step + 1) &&
           strncmp(part->name, above, n) == 0 && part->name[n] == ' ' &&
           strcmp(part->name + n + 1, step + 1) == 0;
}

/* The last step of its path, without ".2" where there is one without it. */
static uint64_t own_id(const struct rmap_assembly *a, size_t i, const uint64_t *all)
{
    const struct rmap_assembly_part *part = &a->part[i];
    const char *above = part->parent < 0 ? "" : a->part[part->parent].id, *id = part->id;
    const size_t n_above = strlen(above);
    size_t n = strlen(id), low = 0, high = a->n_part;
    const char *dot = strrchr(id, '.');
    if (rmap_assembly_is_numbered(a, i))
        return 0;
    if (dot && dot[1] && dot[1] != '0' && strspn(dot + 1, "0123456789") == strlen(dot + 1)) {
        const uint64_t shorter = XXH3_64bits(id, (size_t)(dot - id));
        while (low < high) {
            const size_t middle = low + (high - low) / 2;
            if (all[middle] < shorter)
                low = middle + 1;
            else
                high = middle;
        }
        if (low < a->n_part && all[low] == shorter)
            n = (size_t)(dot - id);
    }
    if (n_above > 0 && strncmp(id, above, n_above) == 0 && id[n_above] == '/' && n > n_above) {
        id += n_above + 1;
        n -= n_above + 1;
    }
    return XXH3_64bits(id, n);
}

static int by_number(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static enum rmap_status find_ids(struct rmap_match_side *s, struct rmap_error *err)
{
    const struct rmap_assembly *a = s->assembly;
    uint64_t *all = rmap_alloc(a->n_part, sizeof *all);
    if (!all)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", a->n_part);
    for (size_t i = 0; i < a->n_part; i++)
        all[i] = rmap_match_text(a->part[i].id);
    if (a->n_part > 0)
        qsort(all, a->n_part, sizeof *all, by_number);
    for (size_t i = 0; i < a->n_part; i++)
        s->id[i] = own_id(a, i, all);
    rmap_free(all);
    return RMAP_OK;
}

/* Children come behind their parents. by_form: wherever the body lies in its frame. */
static void find_contents(struct rmap_match_side *s, bool by_form)
{
    const struct rmap_assembly *a = s->assembly;
    for (size_t i = a->n_part; i-- > 0;) {
        const struct rmap_assembly_part *part = &a->part[i];
        if (part->shape >= 0)
            s->content[i] =
                rmap_match_text(by_form ? a->shape[part->shape].form : a->shape[part->shape].hash);
        if (part->parent >= 0) /* sums know no order */
            s->content[part->parent] += rmap_match_mix(s->content[i], rmap_match_text(part->name));
    }
}

bool rmap_assembly_has_forms(const struct rmap_assembly *a)
{
    bool has = true;
    for (size_t i = 0; i < a->n_shape && has; i++)
        has = a->shape[i].form[0] != 0;
    return has;
}

static void find_places(struct rmap_match_side *s)
{
    for (size_t i = 0; i < s->assembly->n_part; i++) {
        const struct rmap_assembly_part *part = &s->assembly->part[i];
        const bool root = part->parent < 0;
        s->depth[i] = root ? 0 : s->depth[part->parent] + 1;
        s->world[i] =
            root ? part->place : rmap_affine_compose(&s->world[part->parent], &part->place);
        s->known[i] = -1;
        s->name[i] = (struct rmap_part_key){rmap_match_text(part->name), (int32_t)i};
    }
    if (s->assembly->n_part > 0)
        qsort(s->name, s->assembly->n_part, sizeof *s->name, rmap_part_key_compare);
}

enum rmap_status rmap_match_side_begin(struct rmap_match_side *s, bool by_form,
                                       struct rmap_error *err)
{
    const size_t n = s->assembly->n_part;
    s->known = rmap_alloc(n, sizeof *s->known);
    s->key = rmap_alloc(n, sizeof *s->key);
    s->name = rmap_alloc(n, sizeof *s->name);
    s->id = rmap_alloc(n, sizeof *s->id);
    s->content = rmap_alloc(n, sizeof *s->content);
    s->depth = rmap_alloc(n, sizeof *s->depth);
    s->world = rmap_alloc(n, sizeof *s->world);
    if (!s->known || !s->key || !s->name || !s->id || !s->content || !s->depth || !s->world)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", n);
    find_places(s);
    find_contents(s, by_form);
    return find_ids(s, err);
}

void rmap_match_side_fini(struct rmap_match_side *s)
{
    rmap_free(s->key);
    rmap_free(s->name);
    rmap_free(s->id);
    rmap_free(s->content);
    rmap_free(s->depth);
    rmap_free(s->world);
}
