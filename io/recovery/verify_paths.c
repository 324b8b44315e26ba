/* SPDX-License-Identifier: MIT
 *
 * Whether what a piece says of its rays by their paths is so.
 */
#include "io/recovery/verify_paths.h"

#include "base/alloc.h"
#include "compact/angles.h"
#include "compact/arrivals.h"
#include "io/map/map_cursor.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/piece_paths.h"

/* left: the piece's counts; what is left of them when those of its portions are taken away. */
static enum rmap_status take_away(const struct rmap_map *map, const struct rmap_piece_paths *paths,
                                  uint64_t *left, bool *told_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    const struct rmap_portion *rows;
    struct rmap_path_summary summary;
    RMAP_TRY(rmap_cursor_create(map, 0, &cursor, err));
    for (size_t i = 0; *told_ret && i < map->content.n_portion; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        if ((size_t)info->piece != paths->piece)
            continue;
        RMAP_TRY(rmap_cursor_enter(cursor, i, &rows, err));
        RMAP_TRY(rmap_cursor_path_summary(cursor, false, &summary, err));
        *told_ret = summary.paths != NULL;
        for (size_t k = 0; *told_ret && k < info->n_row[RMAP_TABLE_RAY]; k++)
            if (summary.path[k] > 0)
                left[summary.path[k] - 1]--;
    }
out:
    rmap_cursor_destroy(cursor);
    return st;
}

static enum rmap_status compare(const struct rmap_map *map, const struct rmap_piece_paths *paths,
                                bool *same_ret, struct rmap_error *err)
{
    const size_t n = paths->paths->n_row[RMAP_TABLE_RAY];
    uint64_t *left = rmap_alloc_unset(n, sizeof *left), any = 0;
    bool told = true;
    if (!left)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (size_t k = 0; k < n; k++)
        left[k] = paths->of[k].rays;
    const enum rmap_status st = take_away(map, paths, left, &told, err);
    for (size_t k = 0; k < n; k++)
        any |= left[k];
    *same_ret = told && any == 0;
    rmap_free(left);
    return st;
}

enum rmap_status rmap_verify_path_rays(struct rmap_verification *self, size_t piece,
                                       struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_map *map = self->map;
    struct rmap_piece_sum *sum = NULL;
    struct rmap_piece_paths paths = {0};
    struct rmap_error why = {0};
    bool told = false, same = true;
    enum rmap_status st = rmap_piece_sums(map, &sum, &why);
    if (st == RMAP_OK)
        st = rmap_piece_paths_open(map, piece, false, &sum[piece], &paths, &told, &why);
    if (st == RMAP_OK && told) {
        st = compare(map, &paths, &same, &why);
        if (st == RMAP_OK && !same) {
            struct rmap_finding finding;
            rmap_finding_set(&finding, map->content.piece[piece].name,
                             rmap_path_sum_fields().field->path,
                             "says other numbers of rays than the paths of its portions");
            st = rmap_findings_add(findings, &finding, &why);
        }
    }
    rmap_piece_paths_fini(&paths);
    rmap_free(sum);
    if (st == RMAP_FORMAT)
        return RMAP_OK;
    if (st != RMAP_OK && err)
        *err = why;
    return st;
}

static const char beyond_bounds[] = "has bounds that rays with these paths are beyond";

static bool is_outside(const float bound[2], double x)
{
    return x < (double)bound[0] || x > (double)bound[1];
}

static enum rmap_status tell(const struct rmap_verification *self,
                             const struct rmap_portion_info *info, const char *dataset,
                             const char *what, struct rmap_findings *findings,
                             struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, self->content->piece[info->piece].name, dataset, "%s", what);
    rmap_finding_add_rays(&finding, info->first_ray, info->n_row[RMAP_TABLE_RAY]);
    return rmap_findings_add(findings, &finding, err);
}

enum rmap_status rmap_verify_path_bounds(struct rmap_verification *self, struct rmap_cursor *cursor,
                                         size_t portion, const struct rmap_portion *rays,
                                         struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const struct rmap_path_sum *sum = NULL;
    struct rmap_path_summary summary;
    struct rmap_error why = {0};
    size_t n_outside = 0;
    enum rmap_status st = rmap_cursor_path_summary(cursor, false, &summary, &why);
    if (st == RMAP_OK && summary.paths)
        st = rmap_cursor_path_sums(cursor, &sum, &why);
    if (st == RMAP_FORMAT) /* of the file that says so: told of by itself */
        return RMAP_OK;
    if (st != RMAP_OK && err)
        *err = why;
    for (size_t i = 0; sum && i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        const struct rmap_path_sum *its = &sum[summary.path[i] - (summary.path[i] > 0)];
        n_outside +=
            summary.path[i] > 0 && (is_outside(its->path_length, rays->ray.path_length[i]) ||
                                    is_outside(its->optical_path, rays->ray.optical_path[i]));
    }
    if (st != RMAP_OK || n_outside == 0)
        return st;
    return tell(self, info, "/tally/path_length", beyond_bounds, findings, err);
}

enum rmap_status rmap_verify_own_lengths(struct rmap_verification *self, struct rmap_cursor *cursor,
                                         size_t portion, const struct rmap_portion *rays,
                                         struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const struct rmap_path_sum *own = NULL;
    struct rmap_path_summary summary;
    struct rmap_error why = {0};
    bool beyond = false;
    enum rmap_status st = rmap_cursor_path_summary(cursor, false, &summary, &why);
    if (st == RMAP_OK && summary.paths)
        st = rmap_cursor_own_lengths(cursor, &own, &why);
    for (size_t i = 0, k = 0; own && i < rays->n_row[RMAP_TABLE_RAY]; i++)
        if (summary.path[i] == 0)
            beyond |= is_outside(own[k++].path_length, rays->ray.path_length[i]);
    if (st != RMAP_OK && st != RMAP_FORMAT) {
        if (err)
            *err = why;
        return st;
    }
    return beyond || st == RMAP_FORMAT
               ? tell(self, info, "/pool16/value", beyond_bounds, findings, err)
               : RMAP_OK;
}

enum rmap_status rmap_verify_arrivals(struct rmap_verification *self, struct rmap_cursor *cursor,
                                      size_t portion, struct rmap_findings *findings,
                                      struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const uint32_t *arriving = NULL;
    struct rmap_path_summary summary;
    struct rmap_error why = {0};
    size_t n = 0, k = 0;
    bool differ = false;
    enum rmap_status st = rmap_cursor_path_summary(cursor, false, &summary, &why);
    if (st == RMAP_OK && summary.paths)
        st = rmap_cursor_arrivals(cursor, &arriving, &n, &why);
    for (size_t i = 0; arriving && i < info->n_row[RMAP_TABLE_RAY]; i++) {
        const uint32_t path = summary.path[i];
        if (!rmap_arrives(path, path > 0 ? summary.paths->ray.registration_count[path - 1] : 0))
            continue;
        differ |= k >= n || arriving[k] != path;
        k++;
    }
    differ |= arriving && k != n;
    if (st != RMAP_OK && st != RMAP_FORMAT) {
        if (err)
            *err = why;
        return st;
    }
    return differ || st == RMAP_FORMAT
               ? tell(self, info, "/pool16/value",
                      "names other rays that arrive at detectors than there are", findings, err)
               : RMAP_OK;
}

enum rmap_status rmap_verify_angles(struct rmap_verification *self, size_t portion,
                                    const struct rmap_portion *rays, struct rmap_findings *findings,
                                    struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const struct rmap_scene *scene = self->map->scene[info->space];
    const struct rmap_registration_columns *seen = &rays->registration;
    bool differ = false;
    for (size_t i = 0; rays->knows_angles && i < rays->n_row[RMAP_TABLE_REGISTRATION]; i++)
        differ |= !rmap_angle_is_in(rays->angle[i], &scene->detector[seen->detector[i]],
                                    seen->direction + 3 * i);
    return differ ? tell(self, info, "/pool32/value",
                         "says other angles than its registrations have", findings, err)
                  : RMAP_OK;
}
