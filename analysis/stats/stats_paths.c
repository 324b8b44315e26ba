/* SPDX-License-Identifier: MIT
 *
 * Statistics of classes of paths.
 */
#include "analysis/stats/stats_paths.h"

#include "base/alloc.h"

void rmap_stats_paths_fini(struct rmap_stats_paths *paths)
{
    rmap_path_keys_destroy(paths->keys);
    for (size_t k = 0; paths->name && k < paths->n; k++)
        rmap_free(paths->name[k]);
    rmap_free(paths->name);
    rmap_free(paths->key);
    *paths = (struct rmap_stats_paths){0};
}

const char *rmap_stats_path_name(const struct rmap_stats_paths *paths, size_t group)
{
    return group < paths->n ? paths->name[group] : "(others)";
}

bool rmap_stats_paths_of_registrations(const struct rmap_stats_paths *paths)
{
    return rmap_path_keys_view(paths->keys)->until_detector;
}

/* Of the ray, or of the path until the registration that it is to end with. */
static uint32_t group_of(const struct rmap_stats_paths *paths, const struct rmap_portion *portion,
                         const struct rmap_path_place_of_ray *place, rmap_path_step *step)
{
    size_t n_step = 0, k = 0;
    if (!rmap_path_key_of(paths->keys, portion, place, step, &n_step))
        return (uint32_t)paths->n;
    const struct rmap_key key = rmap_path_key_hash(step, n_step, portion->ray.source[place->ray]);
    while (k < paths->n && !rmap_keys_equal(paths->key[k], key))
        k++;
    return (uint32_t)k;
}

enum rmap_status rmap_stats_paths_mark(const struct rmap_stats_paths *paths,
                                       const struct rmap_matched *rays,
                                       struct rmap_stats_marks *marks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counted = rmap_registrations_counted(rays);
    const struct rmap_path_view *view = rmap_path_keys_view(paths->keys);
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    struct rmap_path_place_of_ray place = {0};
    RMAP_TRY(RMAP_RESERVE(
        marks->group, marks->group_cap,
        portion->n_row[view->until_detector ? RMAP_TABLE_REGISTRATION : RMAP_TABLE_RAY] + 1, err));
    for (; place.ray < n_ray; place.ray++) {
        const size_t n_segment = portion->ray.segment_count[place.ray];
        const size_t n_hit = portion->ray.registration_count[place.ray];
        RMAP_TRY(RMAP_RESERVE(marks->other, marks->other_cap, n_segment + n_hit + 1, err));
        const bool matches = !rays->match || rays->match[place.ray];
        if (matches && !view->until_detector)
            marks->group[place.ray] = group_of(paths, portion, &place, marks->other);
        for (size_t i = place.registration;
             matches && view->until_detector && i < place.registration + n_hit; i++) {
            place.until = i + 1;
            const bool is_there = counted[i] && portion->registration.detector[i] == view->detector;
            marks->group[i] =
                is_there ? group_of(paths, portion, &place, marks->other) : (uint32_t)paths->n;
        }
        place.segment += n_segment;
        place.registration += n_hit;
    }
out:
    return st;
}
