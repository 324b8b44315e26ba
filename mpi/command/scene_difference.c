/* SPDX-License-Identifier: MIT
 *
 * Why a scene is not the one that a map was traced in.
 */
#include "mpi/command/scene_difference.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static bool same_text(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") == 0;
}

static bool same_list(char *const *a, size_t n_a, char *const *b, size_t n_b)
{
    if (n_a != n_b)
        return false;
    for (size_t i = 0; i < n_a; i++)
        if (!same_text(a[i], b[i]))
            return false;
    return true;
}

/* Line of the first byte that differs; 0: none does. */
static size_t differing_line(const struct rmap_bundle *a, const struct rmap_bundle *b)
{
    size_t line = 1, n = a->text_nbytes < b->text_nbytes ? a->text_nbytes : b->text_nbytes;
    for (size_t i = 0; i < n; i++) {
        if (a->text[i] != b->text[i])
            return line;
        line += a->text[i] == '\n';
    }
    return a->text_nbytes == b->text_nbytes ? 0 : line;
}

static const char *differing_choice(const struct rmap_scene_options *a,
                                    const struct rmap_scene_options *b)
{
    if (!same_text(a->simulation, b->simulation))
        return "--simulation";
    if (!same_list(a->only, a->n_only, b->only, b->n_only))
        return "--only";
    if (!same_list(a->without, a->n_without, b->without, b->n_without))
        return "--without";
    if (!same_list(a->set, a->n_set, b->set, b->n_set))
        return "--set";
    return NULL;
}

void rmap_scene_difference(const struct rmap_bundle *of_map, const struct rmap_bundle *now,
                           char *text, size_t text_nbytes)
{
    size_t line = differing_line(of_map, now);
    const char *choice = differing_choice(&of_map->options, &now->options);
    if (line > 0)
        (void)snprintf(text, text_nbytes, "line %zu of its text", line);
    else if (choice)
        (void)snprintf(text, text_nbytes, "%s", choice);
    else
        (void)snprintf(text, text_nbytes, "a mesh that it names");
}
