/* SPDX-License-Identifier: MIT
 *
 * What detectors have registered up to a time, as dots where the light was.
 */
#include "analysis/figure/figure_registered.h"

#include "analysis/criterion/criterion_mark.h"

static const double RADIUS = 2.2, OPACITY = 0.7; /* pixels */

/* Where the light of a ray was at a time, on its segment in row `at` of /segment. */
static struct rmap_vec3 place_of(const struct rmap_portion *rays, size_t ray, size_t first,
                                 size_t at, double share)
{
    struct rmap_vec3 from = rmap_vec3_of(at > first ? rays->segment.position + 3 * (at - 1)
                                                    : rays->ray.start + 3 * ray);
    const struct rmap_vec3 to = rmap_vec3_of(rays->segment.position + 3 * at);
    size_t row, n = rmap_portion_curve_of(rays, rays->ray.id[ray], &row);
    double length = 0.0, left;
    struct rmap_vec3 last = from;
    for (; n > 0 && rays->curve.segment[row] < at - first; n--)
        row++;
    while (n > 0 && rays->curve.segment[row + n - 1] > at - first)
        n--;
    for (size_t k = 0; k <= n; k++) {
        const struct rmap_vec3 next =
            k < n ? rmap_vec3_of(rays->curve.position + 3 * (row + k)) : to;
        length += rmap_length(rmap_sub(next, last));
        last = next;
    }
    left = share * length;
    for (size_t k = 0; k <= n; k++) {
        const struct rmap_vec3 next =
            k < n ? rmap_vec3_of(rays->curve.position + 3 * (row + k)) : to;
        const double chord = rmap_length(rmap_sub(next, from));
        if (chord > 0.0 && left <= chord)
            return rmap_axpy(left / chord, rmap_sub(next, from), from);
        left -= chord;
        from = next;
    }
    return to;
}

static void put_dot(const struct rmap_ray_lines *lines, struct rmap_vec3 place, const char *ink,
                    struct rmap_svg *svg)
{
    if (!rmap_view_sees(lines->frame->view, place))
        return;
    const struct rmap_vec3 p = rmap_view_project(lines->frame->view, place);
    double pixel[2];
    rmap_view_pixel(lines->frame, (const double[2]){p.x, p.y}, pixel);
    rmap_svg_circle(svg, pixel[0], pixel[1], RADIUS,
                    &(struct rmap_svg_style){.fill = ink, .opacity = OPACITY});
}

/* The registration in this row, which has come: a dot, but for the far field. */
static void draw_one(const struct rmap_scene *scene, const struct rmap_portion *rays, size_t ray,
                     size_t first, size_t row, double time, const struct rmap_ray_lines *lines,
                     struct rmap_svg *svg)
{
    const struct rmap_light_times *times = lines->window->times;
    const size_t at = first + rays->registration.segment[row];
    const double took = times->end[at] - times->begin[at];
    struct rmap_vec3 place;
    char ink[8];
    if (scene->detector[rays->registration.detector[row]].type != RMAP_DETECTOR_PLANE)
        return;
    if (took > 0.0)
        place = place_of(rays, ray, first, at, fmin((time - times->begin[at]) / took, 1.0));
    else /* on its way out, or at once */
        place = rmap_axpy(fmax(time - times->end[at], 0.0) / times->leaving[ray],
                          rmap_vec3_of(rays->ray.end_direction + 3 * ray),
                          place_of(rays, ray, first, at, 0.0));
    if (lines->map)
        scene = rmap_map_scene_of(lines->map, rmap_map_space_of_ray(lines->map, rays->ray.id[ray]));
    (void)rmap_segment_ink(scene, rays, lines->paint, ray, at, ink);
    put_dot(lines, place, ink, svg);
}

uint64_t rmap_registered_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                              const struct rmap_ray_lines *lines, struct rmap_svg *svg)
{
    uint64_t n = 0;
    size_t first = 0, row = 0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; first += rays->ray.segment_count[i++])
        for (const size_t end = row + rays->ray.registration_count[i]; row < end; row++) {
            const double time =
                1e9 * rmap_registration_number(scene, rays, row, RMAP_REGISTRATION_ARRIVAL);
            if (!rays->registration.registered[row] || time > lines->window->until)
                continue;
            n++;
            draw_one(scene, rays, i, first, row, time, lines, svg);
        }
    return n;
}
