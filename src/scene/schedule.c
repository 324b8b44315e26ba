/* SPDX-License-Identifier: MIT
 *
 * Which ray id belongs to which source: a fixed period in proportion to `rays_share`, whatever the
 * number of rays wanted, so that a map can grow without its rays changing.
 */
#include "scene/schedule.h"

#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"

#define PERIOD_MAX 65536

/* The shortest period that holds every share exactly (to rounding), or the longest allowed. */
static size_t choose_period(const struct rmap_scene *scene, double total)
{
    for (size_t period = scene->n_source; period <= PERIOD_MAX; period++) {
        size_t i = 0;
        for (; i < scene->n_source; i++) {
            double wanted = scene->source[i].share / total * (double)period;
            if (wanted < 0.5 || fabs(wanted - round(wanted)) > 1e-9 * (double)period)
                break;
        }
        if (i == scene->n_source)
            return period;
    }
    return scene->n_source > PERIOD_MAX ? scene->n_source : PERIOD_MAX;
}

/* Entries by largest remainder, ties to the first source; every source gets at least one, taken
 * from the source that has most. */
static void set_quotas(struct rmap_scene *scene, double total, size_t period, double *remainder_of)
{
    uint64_t *quota = scene->schedule_quota, given = 0;
    for (size_t i = 0; i < scene->n_source; i++) {
        double wanted = scene->source[i].share / total * (double)period;
        quota[i] = (uint64_t)floor(wanted + 1e-6);
        remainder_of[i] = wanted - (double)quota[i];
        if (quota[i] == 0) {
            quota[i] = 1;
            remainder_of[i] = -1.0;
        }
        given += quota[i];
    }
    while (given != period) {
        size_t best = 0;
        for (size_t i = 1; i < scene->n_source; i++)
            if (given < period ? remainder_of[i] > remainder_of[best] : quota[i] > quota[best])
                best = i;
        remainder_of[best] -= 1.0;
        quota[best] += given < period ? 1 : (uint64_t)-1;
        given += given < period ? 1 : (uint64_t)-1;
    }
}

/* The k-th of a source's q entries stands at (2 k + 1) / (2 q) of the period. */
struct entry {
    uint64_t place, quota;
    int32_t source;
};

static int compare_entries(const void *left, const void *right)
{
    const struct entry *a = left, *b = right;
    uint64_t x = a->place * b->quota, y = b->place * a->quota;
    if (x != y)
        return x < y ? -1 : 1;
    return (a->source > b->source) - (a->source < b->source);
}

static void interleave(struct rmap_scene *scene, struct entry *entry)
{
    size_t n = 0;
    for (size_t i = 0; i < scene->n_source; i++)
        for (uint64_t k = 0; k < scene->schedule_quota[i]; k++)
            entry[n++] = (struct entry){2 * k + 1, scene->schedule_quota[i], (int32_t)i};
    qsort(entry, n, sizeof *entry, compare_entries);
    for (size_t k = 0; k < n; k++) {
        scene->schedule[k] = entry[k].source;
        scene->schedule_rank[k] = entry[k].place / 2;
    }
}

enum rmap_status rmap_scene_schedule(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct entry *entry = NULL;
    double *remainder_of = NULL;
    double total = 0.0;
    scene->schedule_len = 0;
    for (size_t i = 0; i < scene->n_source; i++) {
        double share = scene->source[i].share;
        if (!(share > 0.0) || !isfinite(share)) {
            const char *name = scene->source[i].name;
            st = rmap_error_set(err, RMAP_INPUT, "source '%s': rays_share must be > 0",
                                name ? name : "");
            goto out;
        }
        total += share;
    }
    if (scene->n_source == 0)
        goto out;
    rmap_free(scene->schedule);
    rmap_free(scene->schedule_rank);
    rmap_free(scene->schedule_quota);
    size_t period = choose_period(scene, total);
    scene->schedule = rmap_alloc(period, sizeof *scene->schedule);
    scene->schedule_rank = rmap_alloc(period, sizeof *scene->schedule_rank);
    scene->schedule_quota = rmap_alloc(scene->n_source, sizeof *scene->schedule_quota);
    entry = rmap_alloc(period, sizeof *entry);
    remainder_of = rmap_alloc(scene->n_source, sizeof *remainder_of);
    if (!scene->schedule || !scene->schedule_rank || !scene->schedule_quota || !entry ||
        !remainder_of) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the schedule of rays");
        goto out;
    }
    set_quotas(scene, total, period, remainder_of);
    interleave(scene, entry);
    scene->schedule_len = period;
out:
    rmap_free(entry);
    rmap_free(remainder_of);
    return st;
}
