/* SPDX-License-Identifier: MIT
 *
 * The counts of a query, as text and as JSON.
 */
#include "mpi/answer/query_count_out.h"

#include <math.h>

#include "base/grouped.h"
#include "io/map/map_content.h"
#include "io/map/map_json.h"
#include "mpi/command/balance.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/parallel/progress.h"

/* Of all sources, also where a query picked the map's rays or some source has none in it. */
static double total_flux(const struct rmap_map *map)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    double total = 0.0;
    for (size_t s = 0; s < scene->n_source; s++)
        total += scene->source[s].flux;
    return total;
}

json_t *rmap_query_count_json(const struct rmap_map *map, const struct rmap_criterion *criterion,
                              const struct rmap_count *count,
                              const struct rmap_registered_list *registered, double seconds)
{
    double flux, error;
    const uint64_t *n_row = rmap_map_contents(map)->n_row;
    rmap_count_flux(count, map, &flux, &error);
    json_t *document = json_pack(
        "{s:s, s:{s:I, s:I}, s:{s:I, s:I}, s:{s:f, s:f, s:o, s:s}, s:o, s:{s:I, s:I}, s:o, s:f}",
        "criterion", rmap_criterion_text(criterion), "rays", "total",
        (json_int_t)n_row[RMAP_TABLE_RAY], "matched", (json_int_t)count->rays, "segments", "total",
        (json_int_t)n_row[RMAP_TABLE_SEGMENT], "matched", (json_int_t)count->segments, "flux",
        "total", total_flux(map), "matched", flux, "standard_error", rmap_json_number(error),
        "unit", rmap_flux_unit_name(rmap_map_scene(map)), "registered",
        rmap_registered_json(registered), "portions", "total", (json_int_t)rmap_map_n_portion(map),
        "read", (json_int_t)count->portions_read, "bytes_read",
        count->nbytes_read == UINT64_MAX ? json_null()
                                         : json_integer((json_int_t)count->nbytes_read),
        "seconds", seconds);
    if (document && rmap_criterion_of_phase_time(criterion))
        (void)json_object_set_new(document, "time", json_string("phase"));
    if (document && rmap_criterion_name(criterion))
        (void)json_object_set_new(document, "name", json_string(rmap_criterion_name(criterion)));
    return rmap_json_of_map(document, map);
}

static void print_row(const char *what, uint64_t matched, uint64_t total)
{
    char first[RMAP_GROUPED_LEN], second[RMAP_GROUPED_LEN];
    printf("  %-9s %s of %s", what, rmap_grouped(matched, first), rmap_grouped(total, second));
    if (total > 0)
        printf(" (%.4g %%)", 100.0 * (double)matched / (double)total);
    putchar('\n');
}

static void print_text(const struct rmap_map *map, const struct rmap_criterion *criterion,
                       const struct rmap_count *count,
                       const struct rmap_registered_list *registered)
{
    const uint64_t *n_row = rmap_map_contents(map)->n_row;
    double flux, error;
    const char *unit = rmap_flux_unit_name(rmap_map_scene(map));
    rmap_count_flux(count, map, &flux, &error);
    printf("%s\n", rmap_criterion_text(criterion));
    print_row("rays", count->rays, n_row[RMAP_TABLE_RAY]);
    print_row("segments", count->segments, n_row[RMAP_TABLE_SEGMENT]);
    printf("  flux      %.6g", flux);
    if (isfinite(error))
        printf(" +- %.2g", error);
    printf(" of %.6g %s\n", total_flux(map), unit);
    rmap_registered_print(registered, stdout);
}

enum rmap_status
rmap_query_count_print(const struct rmap_context *context, const struct rmap_map *map,
                       struct rmap_criterion *const *criterion, const struct rmap_count *count,
                       const struct rmap_registered_list *registered,
                       const struct rmap_ray_groups *groups, size_t n_criterion, bool listed,
                       const struct rmap_map_part *part, double seconds, struct rmap_error *err)
{
    for (size_t c = 0; c < n_criterion; c++)
        rmap_tell_hint(context, map, &(struct rmap_choice){criterion[c], NULL}, count[c].rays);
    if (context->json) {
        json_t *list = json_array();
        for (size_t c = 0; c < n_criterion; c++) {
            json_t *own =
                rmap_query_count_json(map, criterion[c], &count[c], &registered[c], seconds);
            rmap_json_add_part(own, part);
            rmap_ray_groups_add_json(own, &groups[c]);
            (void)json_array_append_new(list, own);
        }
        json_t *document = list;
        if (n_criterion == 1 && !listed) {
            document = json_incref(json_array_get(list, 0));
            json_decref(list);
        }
        return rmap_json_print(document, stdout, err);
    }
    uint64_t nbytes = 0, read = 0;
    char of_all[RMAP_GROUPED_LEN], of_part[RMAP_MAP_PART_LEN];
    rmap_map_part_text(part, of_part);
    for (size_t c = 0; c < n_criterion; c++) {
        print_text(map, criterion[c], &count[c], &registered[c]);
        if (of_part[0])
            printf("  until     %s\n", of_part);
        const enum rmap_status st = rmap_ray_groups_print(&groups[c], stdout, err);
        if (st != RMAP_OK)
            return st;
        nbytes = count[c].nbytes_read > nbytes ? count[c].nbytes_read : nbytes;
        read = count[c].portions_read > read ? count[c].portions_read : read;
    }
    if (!context->quiet && nbytes == UINT64_MAX)
        fprintf(stderr, "%s of %s read, %.3f s\n", rmap_grouped(read, of_all),
                rmap_counted(rmap_map_n_portion(map), "portion").text, seconds);
    else if (!context->quiet)
        fprintf(stderr, "%s of %s read, %.1f MB, %.3f s\n", rmap_grouped(read, of_all),
                rmap_counted(rmap_map_n_portion(map), "portion").text, 1e-6 * (double)nbytes,
                seconds);
    return RMAP_OK;
}
