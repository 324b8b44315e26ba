/* SPDX-License-Identifier: MIT
 *
 * Rays as they decode, against what their portion's row says of them; and the sums of all of them
 * against the index's.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_internal.h"
#include "io/map/map_rays.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_columns.h"
#include "io/recovery/verify_paths.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_rays.h"
#include "io/recovery/verify_tables.h"
#include "io/write/index_scene.h"

/* The view of all pieces as one: each of its datasets names every piece, in order, all rows. */

/* The datasets' sources, one after the other. */
struct source {
    const struct rmap_verification *self;
    const struct rmap_stream_info *stream;
    size_t piece; /* next to be named */
    hsize_t at;   /* next row */
};

static enum rmap_status tell(const struct source *source, const char *piece, const char *text,
                             struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, "map.h5", source->stream->path, "%s%s", text, piece);
    return rmap_findings_add(findings, &finding, err);
}

/* Moves on to the next piece that has rows; false when there is none. */
static bool next_piece(struct source *source)
{
    const struct rmap_map_content *content = source->self->content;
    while (source->piece < content->n_piece &&
           content->piece[source->piece].stored_rows[source->stream->table] == 0)
        source->piece++;
    return source->piece < content->n_piece;
}

/* Whether mapping i is that of the next piece. */
static bool fits(struct source *source, hid_t create, size_t i)
{
    const struct rmap_piece_info *piece = &source->self->content->piece[source->piece];
    hsize_t rows = piece->stored_rows[source->stream->table];
    hsize_t first[2] = {0}, last[2] = {0};
    char name[sizeof piece->name] = "", set[128] = "";
    hid_t space = H5Pget_virtual_vspace(create, i);
    bool good = H5Pget_virtual_filename(create, i, name, sizeof name) > 0 &&
                H5Pget_virtual_dsetname(create, i, set, sizeof set) > 0 && space >= 0 &&
                H5Sget_simple_extent_ndims(space) <= 2 &&
                H5Sget_select_bounds(space, first, last) >= 0 && strcmp(name, piece->name) == 0 &&
                strcmp(set, source->stream->path) == 0 && first[0] == source->at &&
                last[0] + 1 == source->at + rows;
    if (space >= 0)
        (void)H5Sclose(space);
    source->at += rows;
    return good;
}

static enum rmap_status check_set(struct source *source, hid_t create,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    size_t n = 0;
    if (H5Pget_layout(create) != H5D_VIRTUAL)
        return next_piece(source) ? tell(source, "", "the view lacks this column", findings, err)
                                  : RMAP_OK;
    if (H5Pget_virtual_count(create, &n) < 0)
        return tell(source, "", "the view's list of pieces cannot be read", findings, err);
    for (size_t i = 0; i < n; i++) {
        if (!next_piece(source))
            return tell(source, "", "the view names more pieces than there are", findings, err);
        const char *name = source->self->content->piece[source->piece].name;
        if (!fits(source, create, i))
            return tell(source, name, "the view does not show, in its place, ", findings, err);
        source->piece++;
    }
    if (next_piece(source))
        return tell(source, source->self->content->piece[source->piece].name,
                    "the view does not show ", findings, err);
    return RMAP_OK;
}

/* The view is made of plain pieces of one colour space. */
static bool has_view(const struct rmap_map_content *content)
{
    bool has = content->n_piece > 0 && content->n_piece <= RMAP_VIEW_PIECES_MAX;
    for (size_t i = 0; i < content->n_piece; i++)
        has = has && content->piece[i].encoding == RMAP_ENCODING_PLAIN &&
              content->piece[i].space == content->piece[0].space;
    return has;
}

/* The index's view of all pieces as one. */
static enum rmap_status verify_view(struct rmap_verification *self, struct rmap_h5 *h5,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!has_view(self->content))
        return RMAP_OK;
    const struct rmap_layout *layout = rmap_map_piece_layout(self->map, 0);
    int n_stream = rmap_layout_n_stream(layout, self->map->scene[0]);
    for (int s = 0; s < n_stream && st == RMAP_OK; s++) {
        struct source source = {.self = self, .stream = &layout->stream[s]};
        hid_t set = rmap_h5_has(h5, source.stream->path)
                        ? H5Dopen2(h5->file, source.stream->path, H5P_DEFAULT)
                        : H5I_INVALID_HID;
        hid_t create = set >= 0 ? H5Dget_create_plist(set) : H5I_INVALID_HID;
        st = create >= 0 ? check_set(&source, create, findings, err)
                         : tell(&source, "", "the view lacks this column", findings, err);
        if (create >= 0)
            (void)H5Pclose(create);
        if (set >= 0)
            (void)H5Dclose(set);
    }
    return st;
}

/* What the index says of the scene for those who read it with tools of their own (names, fluxes)
 * against the scene inside, from which the program itself has them. */
static enum rmap_status tell_scene(const char *dataset, const char *text,
                                   struct rmap_findings *findings, struct rmap_error *err)
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
        return tell_scene(list->path, "is not what the scene inside says", findings, err);
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
        st = tell_scene(table.field[0].path, "has another number of rows than the scene", findings,
                        err);
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
        return tell_scene(path, "is not what the scene and the rays inside say", findings, err);
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
            return tell_scene("/portion/shard",
                              "is not the shard of the piece that a portion is in", findings, err);
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

/* What the index repeats of the scene inside, and of its pieces, for other readers. */
static enum rmap_status verify_scene(struct rmap_verification *self, struct rmap_h5 *h5,
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
    st = rmap_verify_path_bounds(self, cursor, portion, rays, findings, err);
    if (st == RMAP_OK)
        st = rmap_verify_own_lengths(self, cursor, portion, rays, findings, err);
    if (st == RMAP_OK)
        st = rmap_verify_arrivals(self, cursor, portion, findings, err);
    if (st == RMAP_OK)
        st = rmap_verify_angles(self, portion, rays, findings, err);
    if (st == RMAP_OK)
        st = rmap_verify_columns(self, cursor, portion, findings, err);
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

/* Values [n] of two tallies; the first that differs is reported. at_most: less may be said. */
struct compared {
    const char *dataset;
    const double *says, *is;
    size_t n;
    bool at_most;
};

static enum rmap_status compare_values(const struct compared *values,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    for (size_t i = 0; i < values->n; i++) {
        const double says = values->says[i], is = values->is[i];
        char of[64];
        if ((says >= is || values->at_most) && says <= is)
            continue;
        (void)snprintf(of, sizeof of, " (value %zu)", i);
        return differ(values->dataset, says, is, of, findings, err);
    }
    return RMAP_OK;
}

/* Of the rest of squared weights less is known of rays from before it was kept. */
static enum rmap_status compare_images(const struct rmap_tally *says, const struct rmap_tally *is,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    const struct compared item[] = {
        {"image", says->image, is->image, 0, false},
        {"image_squared", says->image_squared, is->image_squared, 0, false},
        {"image_squared_rest", says->image_squared_rest, is->image_squared_rest, 0, true}};
    const size_t n_item = is->image_squared_rest ? 3 : 2;
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < n_item * is->scene->n_detector && st == RMAP_OK; k++) {
        const struct compared *of = &item[k % n_item];
        const size_t d = k / n_item, first = is->image_offset[d];
        char *path = rmap_path_format("/detector/%s/%s", is->scene->detector[d].name, of->dataset);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        st = compare_values(&(struct compared){path, of->says + first, of->is + first,
                                               is->image_offset[d + 1] - first, of->at_most},
                            findings, err);
        rmap_free(path);
    }
    return st;
}

static enum rmap_status compare_tallies(const struct rmap_tally *says, const struct rmap_tally *is,
                                        struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = is->scene->n_source;
    const struct compared list[] = {
        {"/tally/emitted", says->emitted, is->emitted, n, false},
        {"/tally/absorbed_object", says->absorbed_object, is->absorbed_object,
         n * is->scene->n_object, false},
        {"/tally/absorbed_medium", says->absorbed_medium, is->absorbed_medium,
         n * is->scene->n_medium, false},
        {"/tally/left", says->left, is->left, n, false},
        {"/tally/limit", says->limit, is->limit, n, false},
        {"/tally/error", says->error, is->error, n, false},
        {"/tally", says->segments, is->segments, 1, false},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list && st == RMAP_OK; i++)
        st = compare_values(&list[i], findings, err);
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
    const bool curved = rmap_scene_keeps_curves(self->map->scene[0]);
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
    RMAP_TRY(verify_scene(self, &h5, findings, err));
    RMAP_TRY(verify_view(self, &h5, findings, err));
out:
    rmap_h5_drop(&h5);
    rmap_free(path);
    return st;
}
