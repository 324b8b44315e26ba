/* SPDX-License-Identifier: MIT
 *
 * The rays that match, told apart (--by): how many are in each group, and their flux.
 */
#include "mpi/scan/groups.h"

#include <math.h>

#include "analysis/stats/group_count.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_number.h"
#include "mpi/command/balance.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

/* On rank 0. */
static enum rmap_status list(const struct rmap_map *map, const struct rmap_group_counts *counts,
                             struct rmap_ray_groups *groups, struct rmap_error *err)
{
    const struct rmap_group_counting *of = counts->of;
    groups->group = rmap_alloc(of->n_group + 1, sizeof *groups->group);
    if (!groups->group)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu groups", of->n_group);
    for (size_t g = 0; g < of->n_group; g++) {
        struct rmap_ray_group *own = &groups->group[groups->n];
        struct rmap_count count;
        const enum rmap_status st = rmap_count_init(&count, of->scene->n_source, err);
        if (st != RMAP_OK)
            return st;
        rmap_group_counts_read(counts, g, &count);
        *own = (struct rmap_ray_group){.name = rmap_stats_group_name(of->by, of->quantities, g),
                                       .rays = count.rays,
                                       .segments = count.segments};
        rmap_count_flux(&count, map, &own->flux, &own->standard_error);
        groups->n += count.rays > 0;
        rmap_count_fini(&count);
    }
    return RMAP_OK;
}

enum rmap_status rmap_ray_groups_run(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_overlay *overlay,
                                     const struct rmap_criterion *criterion, enum rmap_stats_by by,
                                     struct rmap_ray_groups *groups, struct rmap_error *err)
{
    const char *of = "segments"; /* any number of a ray */
    struct rmap_quantities *quantities = NULL;
    void *state = NULL;
    *groups = (struct rmap_ray_groups){.by = by, .unit = rmap_flux_unit_name(rmap_map_scene(map))};
    if (by == RMAP_STATS_TOGETHER)
        return RMAP_OK;
    enum rmap_status st = rmap_quantities_create_over(map, overlay, &of, 1, NULL, &quantities, err);
    if (st == RMAP_OK)
        st = rmap_stats_group_prepare(by, quantities, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_group_counting counting =
        rmap_group_counting(quantities->scene, by, quantities);
    const struct rmap_fold fold = {.kind = &rmap_group_count_kind,
                                   .context = &counting,
                                   .map = map,
                                   .overlay = overlay,
                                   .criterion = criterion,
                                   .columns = rmap_group_count_columns(&counting)};
    RMAP_TRY(rmap_fold_run(context, &fold, &state, err));
    if (state)
        st = list(map, state, groups, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_group_count_kind.destroy(state);
    groups->quantities = quantities;
    return st;
}

void rmap_ray_groups_fini(struct rmap_ray_groups *groups)
{
    rmap_free(groups->group);
    rmap_quantities_destroy(groups->quantities);
    *groups = (struct rmap_ray_groups){0};
}

void rmap_ray_groups_add_json(json_t *object, const struct rmap_ray_groups *groups)
{
    if (!object || groups->by == RMAP_STATS_TOGETHER)
        return;
    json_t *array = json_array();
    for (size_t g = 0; g < groups->n; g++) {
        const struct rmap_ray_group *own = &groups->group[g];
        (void)json_array_append_new(
            array, json_pack("{s:s, s:I, s:I, s:{s:o, s:o, s:s}}", "name", own->name, "rays",
                             (json_int_t)own->rays, "segments", (json_int_t)own->segments, "flux",
                             "value", rmap_json_number(own->flux), "standard_error",
                             rmap_json_number(own->standard_error), "unit", groups->unit));
    }
    (void)json_object_set_new(object, "by", json_string(rmap_stats_by_word(groups->by)));
    (void)json_object_set_new(object, "groups", array);
}

enum rmap_status rmap_ray_groups_print(const struct rmap_ray_groups *groups, FILE *out,
                                       struct rmap_error *err)
{
    struct rmap_text_table table;
    if (groups->by == RMAP_STATS_TOGETHER)
        return RMAP_OK;
    rmap_text_table_init(&table, 5);
    rmap_text_table_add(&table, "  by %s", rmap_stats_by_word(groups->by));
    rmap_text_table_add(&table, "rays");
    rmap_text_table_add(&table, "segments");
    rmap_text_table_add(&table, "flux, %s", groups->unit);
    rmap_text_table_add(&table, "%s", "");
    for (size_t g = 0; g < groups->n; g++) {
        const struct rmap_ray_group *own = &groups->group[g];
        char n[RMAP_GROUPED_LEN];
        rmap_text_table_add(&table, "  %s", own->name);
        rmap_text_table_add(&table, "%s", rmap_grouped(own->rays, n));
        rmap_text_table_add(&table, "%s", rmap_grouped(own->segments, n));
        rmap_text_table_add(&table, "%.6g", own->flux);
        rmap_text_table_add(&table, isfinite(own->standard_error) ? "+- %.2g" : "",
                            own->standard_error);
    }
    const enum rmap_status st = rmap_text_table_print(&table, "lrrrl", out, err);
    rmap_text_table_fini(&table);
    return st;
}
