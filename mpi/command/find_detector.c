/* SPDX-License-Identifier: MIT
 *
 * The detector that a command line names.
 */
#include "mpi/command/find_detector.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/detector_bins.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"

enum { SHOWN = 8 };

/* "'sensor', 'far'", some of many. */
static void list_names(const struct rmap_scene *scene, char *text, size_t nbytes)
{
    size_t len = 0;
    text[0] = 0;
    for (size_t d = 0; d < scene->n_detector && d < SHOWN && len < nbytes; d++)
        len += (size_t)snprintf(text + len, nbytes - len, "%s'%.40s'", d ? ", " : "",
                                scene->detector[d].name);
    if (scene->n_detector > SHOWN && len < nbytes)
        (void)snprintf(text + len, nbytes - len, " and %zu more (raymap info)",
                       scene->n_detector - SHOWN);
}

static enum rmap_status refuse_name(const struct rmap_scene *scene, const char *name,
                                    const char *nearest, struct rmap_error *err)
{
    char known[64 * SHOWN];
    for (size_t o = 0; o < scene->n_object; o++)
        if (strcmp(scene->object[o].name, name) == 0)
            return rmap_error_set(
                err, RMAP_INPUT,
                "'%s' is an object, not a detector; lay one on it with "
                "--receivers FILE: {name: NEW, type: plane, on: '%s', cells: 100}",
                name, name);
    if (nearest)
        return rmap_error_set(err, RMAP_INPUT,
                              "no detector named '%s' in this map (did you mean '%s'?)", name,
                              nearest);
    if (scene->n_detector == 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "no detector named '%s' in this map, nor any other; --receivers FILE "
                              "lays some over it",
                              name);
    list_names(scene, known, sizeof known);
    return rmap_error_set(err, RMAP_INPUT, "no detector named '%s' in this map; it has %s", name,
                          known);
}

enum rmap_status rmap_find_detector(const struct rmap_scene *scene, const char *name,
                                    int32_t *detector_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_INPUT;
    const char **known = rmap_alloc(scene->n_detector + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the detectors' names");
    for (size_t d = 0; d < scene->n_detector; d++) {
        known[d] = scene->detector[d].name;
        if (strcmp(known[d], name) == 0) {
            *detector_ret = (int32_t)d;
            st = RMAP_OK;
        }
    }
    if (st != RMAP_OK)
        st = refuse_name(scene, name, rmap_nearest_word(name, known, scene->n_detector), err);
    rmap_free(known);
    return st;
}

enum rmap_status rmap_read_cells(const char *text, const char *or_else, uint32_t cells[2],
                                 struct rmap_error *err)
{
    char *end = NULL, *second = NULL;
    errno = 0;
    unsigned long long n = strtoull(text, &end, 10), m = n;
    if (end > text && (*end == 'x' || *end == 'X')) {
        m = strtoull(end + 1, &second, 10);
        end = second > end + 1 ? second : end;
    }
    if (end == text || *end || errno || text[0] == '-' || n < 1 || m < 1)
        return rmap_error_set(err, RMAP_USAGE, "--cells '%.60s': say how many, as 400x300%s", text,
                              or_else);
    if (n > RMAP_DETECTOR_CELLS_MAX || m > RMAP_DETECTOR_CELLS_MAX ||
        n * m > RMAP_DETECTOR_CELLS_MAX)
        return rmap_error_set(err, RMAP_USAGE, "--cells '%.60s': %u cells are the most", text,
                              RMAP_DETECTOR_CELLS_MAX);
    cells[0] = (uint32_t)n;
    cells[1] = (uint32_t)m;
    return RMAP_OK;
}
