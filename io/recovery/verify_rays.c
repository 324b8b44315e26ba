/* SPDX-License-Identifier: MIT
 *
 * Rays as they decode, against what their portion's row says of them; and the sums of all of them
 * against the index's.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/map/map_internal.h"
#include "io/recovery/verify_internal.h"

/* ---- one portion ---- */

static enum rmap_status lost(struct rmap_verification *self, size_t portion, const char *dataset,
                             const char *text, struct rmap_findings *findings,
                             struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    struct rmap_finding finding;
    rmap_finding_set(&finding, self->content->piece[info->piece].name, dataset, "%s", text);
    rmap_finding_add_portion(&finding, info);
    rmap_verification_flag_portion(self, portion, RMAP_PORTION_LOST);
    return rmap_findings_add(findings, &finding, err);
}

static const char *check_ids(const struct rmap_portion_info *info, const struct rmap_portion *rays)
{
    size_t n = rays->n_row[RMAP_TABLE_RAY];
    const uint64_t *id = rays->ray.id;
    bool ascend = n > 0, run = true;
    for (size_t i = 0; i < n; i++) {
        ascend = ascend && (i == 0 || id[i] > id[i - 1]);
        run = run && id[i] == rays->first_ray + i;
    }
    if (!rmap_portion_has_gaps(info))
        return run ? NULL : "its ray ids do not run from the first one on";
    return ascend && id[0] == info->first_ray && id[n - 1] == info->last_ray
               ? NULL
               : "its ray ids do not ascend from the first one to the last";
}

/* Those fields of /portion that sum up the rays. */
static struct rmap_field_table summary_fields(void)
{
    struct rmap_field_table table = rmap_portion_fields_piece(true);
    while (table.n > 0 && table.field->offset < offsetof(struct rmap_portion_info, summary)) {
        table.field++;
        table.n--;
    }
    return table;
}

static enum rmap_status check_summary(struct rmap_verification *self, size_t portion,
                                      const struct rmap_portion *rays,
                                      struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    struct rmap_portion_info is = *info;
    const struct rmap_table_pair pair = {.file = self->content->piece[info->piece].name,
                                         .what = "the portion itself",
                                         .table = summary_fields(),
                                         .says = info,
                                         .is = &is,
                                         .n = 1,
                                         .row_nbytes = sizeof is,
                                         .portion = info};
    rmap_portion_summarise(rays, &is.summary);
    return rmap_verify_tables(&pair, findings, err);
}

/* Rays that are not those of the row are lost; of a row that is not believed itself, nobody knows.
 */
static const char *check_rays(const struct rmap_verification *self, size_t portion,
                              const struct rmap_portion *rays, const char **dataset)
{
    *dataset = "/ray/id";
    const char *wrong = check_ids(&self->content->portion[portion], rays);
    if (wrong)
        return wrong;
    if (self->portion_flag[portion] & RMAP_PORTION_UNSURE)
        return NULL;
    struct rmap_digest digest = rmap_portion_digest(rays);
    *dataset = "/portion/digest";
    if (memcmp(&digest, &self->content->portion[portion].digest, sizeof digest) != 0)
        return "its rays have another digest than was stored with them";
    return NULL;
}

enum rmap_status rmap_verify_portion(struct rmap_verification *self, struct rmap_cursor *cursor,
                                     size_t portion, struct rmap_tally *tally,
                                     struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_portion *rays = NULL;
    const char *dataset = "", *wrong = NULL;
    struct rmap_error why = {0};
    if (self->portion_flag[portion] & RMAP_PORTION_LOST)
        return RMAP_OK;
    enum rmap_status st = rmap_cursor_read(cursor, portion, &rays, &why);
    if (st == RMAP_OK)
        wrong = check_rays(self, portion, rays, &dataset);
    if (wrong)
        return lost(self, portion, dataset, wrong, findings, err);
    if (st == RMAP_OK && tally)
        st = rmap_tally_add_portion(tally, rays, &why);
    if (st == RMAP_FORMAT)
        return lost(self, portion, "", why.text, findings, err);
    if (st != RMAP_OK) {
        if (err)
            *err = why;
        return st;
    }
    st = rmap_verify_history(self, portion, rays, findings, err);
    if (st != RMAP_OK || self->portion_flag[portion] & RMAP_PORTION_UNSURE)
        return st;
    return check_summary(self, portion, rays, findings, err);
}

/* ---- sums ---- */

static enum rmap_status differ(const char *dataset, double says, double is, const char *of,
                               struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, "map.h5", dataset, "says %.17g where the rays add up to %.17g%s",
                     says, is, of);
    return rmap_findings_add(findings, &finding, err);
}

/* Values [n] of two tallies; the first that differs is told. */
static enum rmap_status compare_values(const char *dataset, const double *says, const double *is,
                                       size_t n, struct rmap_findings *findings,
                                       struct rmap_error *err)
{
    for (size_t i = 0; i < n; i++) {
        char of[64];
        if (says[i] >= is[i] && says[i] <= is[i])
            continue;
        (void)snprintf(of, sizeof of, " (value %zu)", i);
        return differ(dataset, says[i], is[i], of, findings, err);
    }
    return RMAP_OK;
}

static enum rmap_status compare_images(const struct rmap_tally *says, const struct rmap_tally *is,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t d = 0; d < is->scene->n_detector && st == RMAP_OK; d++) {
        size_t first = is->image_offset[d], n = is->image_offset[d + 1] - first;
        char *image = rmap_path_format("/detector/%s/image", is->scene->detector[d].name);
        char *squared = rmap_path_format("/detector/%s/image_squared", is->scene->detector[d].name);
        if (!image || !squared)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        if (st == RMAP_OK)
            st = compare_values(image, says->image + first, is->image + first, n, findings, err);
        if (st == RMAP_OK)
            st = compare_values(squared, says->image_squared + first, is->image_squared + first, n,
                                findings, err);
        rmap_free(image);
        rmap_free(squared);
    }
    return st;
}

static enum rmap_status compare_tallies(const struct rmap_tally *says, const struct rmap_tally *is,
                                        struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = is->scene->n_source;
    const struct {
        const char *dataset;
        const double *says, *is;
        size_t n;
    } list[] = {
        {"/tally/emitted", says->emitted, is->emitted, n},
        {"/tally/absorbed_object", says->absorbed_object, is->absorbed_object,
         n * is->scene->n_object},
        {"/tally/absorbed_medium", says->absorbed_medium, is->absorbed_medium,
         n * is->scene->n_medium},
        {"/tally/left", says->left, is->left, n},
        {"/tally/limit", says->limit, is->limit, n},
        {"/tally/error", says->error, is->error, n},
        {"/tally", says->segments, is->segments, 1},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list && st == RMAP_OK; i++)
        st = compare_values(list[i].dataset, list[i].says, list[i].is, list[i].n, findings, err);
    if (st == RMAP_OK && says->first_error_ray != is->first_error_ray)
        st = differ("/tally", (double)says->first_error_ray, (double)is->first_error_ray,
                    " (first_error_ray)", findings, err);
    return st == RMAP_OK ? compare_images(says, is, findings, err) : st;
}

static enum rmap_status check_totals(struct rmap_verification *self, struct rmap_h5 *h5,
                                     struct rmap_findings *findings, struct rmap_error *err)
{
    static const char *const name[RMAP_TABLE_COUNT] = {"rays", "segments", "registrations",
                                                       "curve_points"};
    const bool curved = rmap_scene_is_curved(self->map->scene[0]);
    enum rmap_status st = RMAP_OK;
    char says[40] = "", is[33];
    for (int t = 0; t < (curved ? RMAP_TABLE_COUNT : RMAP_TABLE_CURVE) && st == RMAP_OK; t++) {
        uint64_t n = 0;
        char of[64];
        (void)snprintf(of, sizeof of, " (%s)", name[t]);
        st = rmap_h5_get(h5, "/", name[t], RMAP_U64, 1, &n, err);
        if (st == RMAP_SYSTEM)
            return st;
        if (st != RMAP_OK || n != self->content->n_row[t])
            st = differ("/", (double)n, (double)self->content->n_row[t], of, findings, err);
    }
    rmap_digest_text(self->content->digest, is);
    if (st != RMAP_OK)
        return st;
    st = rmap_h5_get_text(h5, "/", "digest", says, sizeof says, err);
    if (st == RMAP_SYSTEM)
        return st;
    if (st != RMAP_OK || strcmp(says, is) != 0) {
        struct rmap_finding finding;
        rmap_finding_set(&finding, "map.h5", "/", "says digest %s where its portions add up to %s",
                         says, is);
        st = rmap_findings_add(findings, &finding, err);
    }
    return st;
}

enum rmap_status rmap_verify_sums(struct rmap_verification *self, const struct rmap_tally *tally,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_error why = {0};
    char *path = rmap_path_format("%s/map.h5", self->path);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (tally)
        RMAP_TRY(compare_tallies(self->map->tally, tally, findings, err));
    if (!self->map->summary.complete) /* its index is of an earlier moment */
        goto out;
    st = rmap_h5_open(&h5, path, &why);
    if (st != RMAP_OK) {
        st = rmap_findings_take(findings, "map.h5", "", st, &why, err);
        goto out;
    }
    RMAP_TRY(check_totals(self, &h5, findings, err));
    RMAP_TRY(rmap_verify_scene(self, &h5, findings, err));
    RMAP_TRY(rmap_verify_view(self, &h5, findings, err));
out:
    rmap_h5_drop(&h5);
    rmap_free(path);
    return st;
}
