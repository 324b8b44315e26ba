/* SPDX-License-Identifier: MIT
 *
 * What the index says of the scene for those who read it with tools of their own (names, fluxes)
 * against the scene inside, from which the program itself has them.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_internal.h"
#include "io/map/map_rays.h"
#include "io/recovery/verify_internal.h"
#include "io/write/index_scene.h"

static enum rmap_status tell(const char *dataset, const char *text, struct rmap_findings *findings,
                             struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, "map.h5", dataset, "%s", text);
    return rmap_findings_add(findings, &finding, err);
}

static enum rmap_status compare_names(struct rmap_h5 *h5, const struct rmap_name_list *list,
                                      struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_error why = {0};
    char *text = NULL;
    size_t n = 0, width = 0;
    enum rmap_status st = rmap_h5_read_names(h5, list->path, &text, &n, &width, &why);
    bool same = st == RMAP_OK && n == list->n;
    for (size_t i = 0; same && i < n; i++) {
        const char *name = rmap_name_of(list, i);
        same = strcmp(text + i * width, name ? name : "") == 0;
    }
    rmap_free(text);
    if (st == RMAP_OK && !same)
        return tell(list->path, "is not what the scene inside says", findings, err);
    return rmap_findings_take(findings, "map.h5", list->path, st, &why, err);
}

static enum rmap_status compare_fields(struct rmap_h5 *h5, struct rmap_field_table table,
                                       const void *is, size_t n, size_t row_nbytes,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_error why = {0};
    void *says = NULL;
    size_t n_said = 0;
    enum rmap_status st =
        rmap_h5_read_fields(h5, table.field, table.n, row_nbytes, &says, &n_said, &why);
    const struct rmap_table_pair pair = {.file = "map.h5",
                                         .what = "the scene inside",
                                         .table = table,
                                         .says = says,
                                         .is = is,
                                         .n = n,
                                         .row_nbytes = row_nbytes};
    if (st != RMAP_OK)
        st = rmap_findings_take(findings, "map.h5", table.field[0].path, st, &why, err);
    else if (n_said == n)
        st = rmap_verify_tables(&pair, findings, err);
    else
        st = tell(table.field[0].path, "has another number of rows than the scene", findings, err);
    rmap_free(says);
    return st;
}

/* Numbers that were computed from the text may differ in the last bits from machine to machine. */
static bool is_near(double says, double is)
{
    return fabs(says - is) <= 1e-9 * fabs(is);
}

static enum rmap_status compare_numbers(struct rmap_h5 *h5, const char *path, const double *is,
                                        size_t n, struct rmap_findings *findings,
                                        struct rmap_error *err)
{
    struct rmap_error why = {0};
    hsize_t n_said = n;
    void *data = NULL;
    enum rmap_status st = rmap_h5_read(h5, path, RMAP_F64, 1, &n_said, &data, &why);
    const double *says = data;
    bool same = st == RMAP_OK;
    for (size_t i = 0; same && i < n; i++)
        same = is_near(says[i], is[i]);
    rmap_free(data);
    if (st == RMAP_OK && !same)
        return tell(path, "is not what the scene and the rays inside say", findings, err);
    return rmap_findings_take(findings, "map.h5", path, st, &why, err);
}

static enum rmap_status compare_light(const struct rmap_map *map, struct rmap_h5 *h5,
                                      struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = map->scene[0];
    double *flux = rmap_alloc(scene->n_source, sizeof *flux);
    if (!flux)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sources");
    for (size_t s = 0; s < scene->n_source; s++)
        flux[s] = scene->source[s].flux;
    RMAP_TRY(compare_numbers(h5, "/source/flux", flux, scene->n_source, findings, err));
    RMAP_TRY(compare_numbers(h5, "/source/emitted", rmap_map_emitted(map), scene->n_source,
                             findings, err));
    if (map->spaces.n == 1) /* of several, older programs put the last one's here */
        RMAP_TRY(compare_numbers(h5, "/channel/wavelength", scene->channels.wavelength_nm,
                                 (size_t)scene->channels.n, findings, err));
out:
    rmap_free(flux);
    return st;
}

static enum rmap_status compare_shards(const struct rmap_map_content *content,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *portion = &content->portion[i];
        if (portion->shard != content->piece[portion->piece].shard)
            return tell("/portion/shard", "is not the shard of the piece that a portion is in",
                        findings, err);
    }
    return RMAP_OK;
}

/* A complete map has the rays that its runs were asked for. */
static enum rmap_status compare_runs(const struct rmap_verification *self,
                                     struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_set held = {0}, wanted = {0}, missing = {0};
    struct rmap_finding finding;
    RMAP_TRY(rmap_rays_held(self->content, &held, err));
    RMAP_TRY(rmap_rays_wanted(self->map, &wanted, err));
    RMAP_TRY(rmap_ray_set_minus(&wanted, &held, &missing, err));
    rmap_finding_set(&finding, "map.h5", "/run/n_ray",
                     "asks for rays that no portion has, though the map says that it is complete");
    for (size_t i = 0; i < missing.n; i++)
        rmap_finding_add_rays(&finding, missing.range[i].first,
                              missing.range[i].end - missing.range[i].first);
    if (missing.n > 0)
        st = rmap_findings_add(findings, &finding, err);
out:
    rmap_ray_set_fini(&held);
    rmap_ray_set_fini(&wanted);
    rmap_ray_set_fini(&missing);
    return st;
}

enum rmap_status rmap_verify_scene(struct rmap_verification *self, struct rmap_h5 *h5,
                                   struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = self->map->scene[0];
    struct rmap_name_list list[RMAP_NAME_LISTS];
    const struct rmap_name_list text = {.path = "/scene/text",
                                        .first = self->map->bundle,
                                        .n = 1,
                                        .name_offset = offsetof(struct rmap_bundle, text)};
    rmap_index_name_lists(scene, list);
    for (size_t i = 0; i < RMAP_NAME_LISTS; i++)
        RMAP_TRY(compare_names(h5, &list[i], findings, err));
    RMAP_TRY(compare_fields(h5, rmap_index_object_fields(), scene->object, scene->n_object,
                            sizeof *scene->object, findings, err));
    RMAP_TRY(compare_fields(h5, rmap_index_group_fields(), scene->group, scene->n_group,
                            sizeof *scene->group, findings, err));
    RMAP_TRY(compare_names(h5, &text, findings, err));
    RMAP_TRY(compare_light(self->map, h5, findings, err));
    RMAP_TRY(compare_shards(self->content, findings, err));
    if (!self->map->selection) /* picked rays have gaps, and the runs of the map they are from */
        RMAP_TRY(compare_runs(self, findings, err));
out:
    return st;
}
