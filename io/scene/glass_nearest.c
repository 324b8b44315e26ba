/* SPDX-License-Identifier: MIT
 *
 * Which glass of the catalogue may be meant by a name that it does not have.
 */
#include "io/scene/glass_nearest.h"

#include <stdio.h>
#include <string.h>

#include "io/file/diagnostics.h"
#include "optics/catalogue.h"

/* Twice an edit's worth, and once that of a prefix. */
enum { EDIT = 2, PREFIX = 1 };

static size_t most_edits(const char *name)
{
    return strlen(name) / 3 + 1;
}

const char *rmap_glass_stem(const char *name)
{
    const char *hyphen = strchr(name, '-');
    enum { LONGEST = 2 };
    return hyphen && hyphen > name && hyphen - name <= LONGEST && hyphen[1] ? hyphen + 1 : name;
}

size_t rmap_glass_difference(const char *a, const char *b)
{
    const char *stem_a = rmap_glass_stem(a), *stem_b = rmap_glass_stem(b);
    const size_t most = most_edits(a);
    size_t whole = EDIT * rmap_word_distance(a, b, most);
    if (stem_a == a && stem_b == b)
        return whole;
    size_t part = EDIT * rmap_word_distance(stem_a, stem_b, most) + PREFIX;
    return part < whole ? part : whole;
}

/* Glasses that differ least, or by half an edit more, each once and the nearest first. */
enum { NEAREST_MAX = 4 };
struct nearest {
    size_t n, from[NEAREST_MAX];
    char name[NEAREST_MAX][32];
};

static void keep_nearest(struct nearest *nearest, const char *name, size_t from)
{
    size_t at = nearest->n;
    for (size_t i = 0; i < nearest->n; i++)
        if (strcmp(nearest->name[i], name) == 0)
            return;
    while (at > 0 && nearest->from[at - 1] > from)
        at--;
    if (at == NEAREST_MAX)
        return;
    nearest->n += nearest->n < NEAREST_MAX;
    for (size_t i = nearest->n - 1; i > at; i--) {
        nearest->from[i] = nearest->from[i - 1];
        memcpy(nearest->name[i], nearest->name[i - 1], sizeof nearest->name[i]);
    }
    nearest->from[at] = from;
    (void)snprintf(nearest->name[at], sizeof nearest->name[at], "%s", name);
}

static struct nearest find_nearest(const char *name)
{
    struct nearest nearest = {0};
    struct rmap_catalogue place = {0};
    char own[32], group[16];
    while (rmap_catalogue_next(&place)) {
        rmap_catalogue_name(&place, own, group);
        size_t from = rmap_glass_difference(name, own);
        if (from <= EDIT * most_edits(name))
            keep_nearest(&nearest, own, from);
    }
    while (nearest.n && nearest.from[nearest.n - 1] > nearest.from[0] + PREFIX)
        nearest.n--;
    return nearest;
}

size_t rmap_glass_nearest(const char *name, char *text, size_t nbytes)
{
    const struct nearest nearest = find_nearest(name);
    size_t used = 0;
    if (text)
        text[0] = 0;
    for (size_t i = 0; i < nearest.n && used < nbytes; i++)
        used +=
            (size_t)snprintf(text + used, nbytes - used, "%s'%s'", i ? ", " : "", nearest.name[i]);
    return nearest.n ? nearest.from[0] : EDIT * most_edits(name);
}
