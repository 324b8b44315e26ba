/* SPDX-License-Identifier: MIT
 *
 * The rays that a map keeps by name, as `select` and `info` tell of them.
 */
#include "mpi/answer/named_rays_out.h"

#include "base/grouped.h"

static const char *state_of(const struct rmap_named_rays *rays)
{
    return rays->why.text[0] ? "damaged" : rays->is_stale ? "stale" : "good";
}

json_t *rmap_named_rays_json(const struct rmap_named_rays_list *list)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < list->n; i++) {
        const struct rmap_named_rays *rays = &list->row[i];
        (void)json_array_append_new(
            rows, json_pack("{s:s, s:s, s:s?, s:I, s:I}", "name", rays->name, "state",
                            state_of(rays), "criterion", rays->criterion, "rays",
                            (json_int_t)rays->n_ray, "bytes", (json_int_t)rays->nbytes));
    }
    return rows;
}

void rmap_named_rays_print(const char *path, const struct rmap_named_rays_list *list, FILE *out)
{
    if (list->n == 0 && path)
        fprintf(out, "%s: no rays have a name\n", path);
    for (size_t i = 0; i < list->n; i++) {
        const struct rmap_named_rays *rays = &list->row[i];
        if (rays->why.text[0])
            fprintf(out, "  @%s: damaged: raymap select --force makes it again (%s)\n", rays->name,
                    rays->why.text);
        else
            fprintf(out, "  @%s: %s, %.2f MB: %s%s\n", rays->name,
                    rmap_counted(rays->n_ray, "ray").text, 1e-6 * (double)rays->nbytes,
                    rays->criterion,
                    rays->is_stale ? " (stale: of other rays than the map has now; raymap select "
                                     "--force selects again)"
                                   : "");
    }
}
