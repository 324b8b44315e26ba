/* SPDX-License-Identifier: MIT
 *
 * What detectors registered of the rays that match, beside how many these are: the registrations
 * that the criterion itself chooses (analysis/query/which.h).
 */
#include "mpi/scan/registered.h"

#include <inttypes.h>
#include <math.h>

#include "analysis/energy/energy_sums.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "mpi/command/balance.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"
#include "portion/weight.h"

/* One detector's sums as those of rays. */
static enum rmap_status read_sums(const struct rmap_map *map, const struct rmap_energy_sums *sums,
                                  size_t detector, struct rmap_registered *item,
                                  struct rmap_error *err)
{
    struct rmap_count count = {0};
    enum rmap_status st = rmap_count_init(&count, sums->n_source, err);
    if (st != RMAP_OK)
        return st;
    for (size_t s = 0; s < sums->n_source; s++) {
        const size_t at = s * sums->n_detector + detector;
        count.source_weight[s] = sums->caught[at];
        count.source_weight_squared[s] = sums->caught_squared[at];
        item->registrations += sums->caught[at];
    }
    rmap_count_flux(&count, map, &item->flux, &item->standard_error);
    rmap_count_fini(&count);
    return RMAP_OK;
}

static void read_counts(const struct rmap_map *map, const struct rmap_criterion *criterion,
                        const struct rmap_energy_sums *sums, struct rmap_count *count)
{
    for (size_t s = 0; s < sums->n_source; s++) {
        count->rays += (uint64_t)sums->rays[s];
        count->segments += (uint64_t)sums->segments[s];
        count->source_weight[s] = sums->weight[s];
        count->source_weight_squared[s] = sums->weight_squared[s];
    }
    for (size_t p = 0; p < rmap_map_n_portion(map); p++)
        count->portions_read += !rmap_criterion_skips(criterion, rmap_map_portion(map, p));
}

static enum rmap_status add_item(const struct rmap_map *map, const struct rmap_scene *scene,
                                 const struct rmap_criterion *criterion,
                                 const struct rmap_energy_sums *sums, size_t detector,
                                 struct rmap_registered_list *list, struct rmap_error *err)
{
    struct rmap_registered *item = &list->item[list->n++];
    const struct rmap_index_set only = {.low = (int32_t)detector, .span = 1};
    *item = (struct rmap_registered){.detector = scene->detector[detector].name};
    enum rmap_status st = rmap_which_create(scene, &only, NULL, NULL, criterion, &item->which, err);
    if (st != RMAP_OK)
        return st;
    item->which->criterion = NULL; /* the list may outlive it */
    return read_sums(map, sums, detector, item, err);
}

static size_t count_asked(const struct rmap_which *which, const uint8_t *asked)
{
    size_t n = 0;
    for (size_t d = 0; d < which->scene->n_detector; d++)
        n += asked[d];
    return n;
}

enum rmap_status rmap_registered_run(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_overlay *overlay,
                                     const struct rmap_criterion *criterion, bool bare,
                                     struct rmap_count *count, struct rmap_registered_list *list,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    const struct rmap_index_set all = {.span = (uint32_t)scene->n_detector};
    struct rmap_energy_scope scope = {.scene = scene};
    struct rmap_which *which = NULL;
    void *state = NULL;
    *list = (struct rmap_registered_list){.unit = rmap_flux_unit_name(scene)};
    st = rmap_which_create(scene, &all, NULL, NULL, criterion, &which, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const uint8_t *asked = bare ? which->asked_on : which->chosen_on;
    const size_t n = count_asked(which, asked);
    if (n == 0)
        goto out;
    scope.counts = list->is_counted = count && which->chooses;
    const struct rmap_fold fold = {.kind = &rmap_energy_kind,
                                   .context = &scope,
                                   .map = map,
                                   .overlay = overlay,
                                   .criterion = criterion,
                                   .which = which,
                                   .columns = rmap_energy_columns(&scope),
                                   .deferred = rmap_energy_columns(&scope),
                                   .registered_alone = true, /* those that match have some */
                                   .nbytes_ret = scope.counts ? &count->nbytes_read : NULL};
    RMAP_TRY(rmap_fold_run(context, &fold, &state, err));
    if (state && scope.counts)
        read_counts(map, criterion, state, count);
    if (state) {
        list->item = rmap_alloc(n, sizeof *list->item);
        if (!list->item)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", n);
        for (size_t d = 0; d < scene->n_detector && st == RMAP_OK; d++)
            if (asked[d])
                st = add_item(map, scene, criterion, state, d, list, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_energy_kind.destroy(state);
    rmap_which_destroy(which);
    return st;
}

void rmap_registered_fini(struct rmap_registered_list *list)
{
    for (size_t i = 0; i < list->n; i++)
        rmap_which_destroy(list->item[i].which);
    rmap_free(list->item);
    *list = (struct rmap_registered_list){0};
}

json_t *rmap_registered_json(const struct rmap_registered_list *list)
{
    json_t *array = json_array();
    for (size_t i = 0; i < list->n; i++) {
        const struct rmap_registered *item = &list->item[i];
        (void)json_array_append_new(
            array, json_pack("{s:s, s:o, s:I, s:o, s:o}", "detector", item->detector, "which",
                             rmap_which_json(item->which), "registrations",
                             (json_int_t)rmap_weight_whole(item->registrations), "flux",
                             rmap_json_number(item->flux), "standard_error",
                             rmap_json_number(item->standard_error)));
    }
    return array;
}

void rmap_registered_print(const struct rmap_registered_list *list, FILE *out)
{
    for (size_t i = 0; i < list->n; i++) {
        const struct rmap_registered *item = &list->item[i];
        const uint64_t n = rmap_weight_whole(item->registrations);
        fprintf(out, "  on %s, %s: %" PRIu64 " registration%s, %.6g", item->detector,
                item->which->text, n, n == 1 ? "" : "s", item->flux);
        if (isfinite(item->standard_error))
            fprintf(out, " +- %.2g", item->standard_error);
        fprintf(out, " %s\n", list->unit);
    }
}
