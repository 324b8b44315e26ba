/* SPDX-License-Identifier: MIT
 *
 * Length of a ray's way inside media.
 */
#include "analysis/criterion/path_in.h"

#include <math.h>

#include "base/vec.h"
#include "portion/event.h"

double rmap_path_length_in(const struct rmap_index_set *media, const struct rmap_portion *portion,
                           size_t row, size_t first)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    const struct rmap_segment_columns *segment = &portion->segment;
    const size_t n_segment = ray->segment_count[row];
    const size_t n = n_segment - (n_segment > 0 && ray->stop[row] == RMAP_STOP_LEFT);
    double straight[2] = {0.0, 0.0}; /* outside of the media, in them */
    size_t n_curved[2] = {0, 0};
    struct rmap_vec3 from = rmap_vec3_of(ray->start + 3 * row);
    for (size_t k = first; k < first + n; k++) {
        const struct rmap_vec3 to = rmap_vec3_of(segment->position + 3 * k);
        const bool inside = rmap_index_set_has(media, segment->medium[k]);
        if (segment->event[k] & RMAP_EVENT_GRADIENT)
            n_curved[inside]++;
        else
            straight[inside] += rmap_length(rmap_sub(to, from));
        from = to;
    }
    if (n_curved[1] == 0)
        return straight[1];
    return n_curved[0] ? (double)NAN : ray->path_length[row] - straight[0];
}

bool rmap_path_is_in(const struct rmap_index_set *media, const struct rmap_portion *portion,
                     size_t first, size_t n)
{
    for (size_t k = first; k < first + n; k++)
        if (rmap_index_set_has(media, portion->segment.medium[k]))
            return true;
    return false;
}
