/* SPDX-License-Identifier: MIT
 *
 * A scene cut by a plane: profiles of all surfaces, glass between them filled.
 */
#include "analysis/figure/figure_section.h"

#include "analysis/figure/figure_outline.h"
#include "analysis/figure/object_colour.h"
#include "base/alloc.h"

/* Media denser than this are filled as glass (or water). */
static const double GLASS_INDEX = 1.2;

/* Two surfaces of one piece of glass stand at most this many objects apart in the scene. */
enum { NEIGHBOURS = 4 };

static const char glass_fill[] = "#d3e5f4";

struct section {
    const struct rmap_scene *scene;
    const struct rmap_view_frame *frame;
    struct rmap_outline outline;
    size_t *first_run; /* [n_object + 1] */
};

const struct rmap_look_style rmap_look_style[RMAP_LOOK_COUNT] = {
    [RMAP_LOOK_REFRACTING] = {"refracting surface", "#3a6f9f", {0.80, 0.89, 0.97}},
    [RMAP_LOOK_MIRROR] = {"mirror", "#7b5ea7", {0.88, 0.84, 0.94}},
    [RMAP_LOOK_OTHER] = {"other surface", "#454545", {0.94, 0.93, 0.90}},
};

static bool is_glass(const struct rmap_scene *scene, int32_t medium)
{
    return medium >= 0 && (size_t)medium < scene->n_medium &&
           scene->medium[medium].n[scene->channels.n / 2] > GLASS_INDEX;
}

static bool is_cap(const struct rmap_scene *scene, size_t object)
{
    const struct rmap_geometry *geometry = &scene->geometry[scene->object[object].geometry];
    return geometry->kind == RMAP_GEOMETRY_SHAPE && rmap_shape_model[geometry->shape.type].cap;
}

/* World direction of a cap's normal at its vertex. */
static struct rmap_vec3 cap_normal(const struct rmap_object *object)
{
    return rmap_normalize(rmap_affine_transposed(&object->to_local, rmap_vec3(0, 0, 1)));
}

/* The single open run of a cap that the plane cuts through its middle. */
static const struct rmap_outline_run *single_run(const struct section *section, size_t object)
{
    size_t first = section->first_run[object];
    if (section->first_run[object + 1] != first + 1)
        return NULL;
    const struct rmap_outline_run *run = &section->outline.run[first];
    return run->closed || run->n < 2 ? NULL : run;
}

/* Is there glass from the front of cap a to the back of cap b? */
static bool enclose_glass(const struct rmap_scene *scene, size_t a, size_t b)
{
    const struct rmap_object *from = &scene->object[a], *to = &scene->object[b];
    if (!is_cap(scene, b) || from->medium_front != to->medium_back ||
        !is_glass(scene, from->medium_front))
        return false;
    struct rmap_vec3 normal = cap_normal(from);
    return rmap_dot(normal, cap_normal(to)) > 0.5 &&
           rmap_dot(normal, rmap_sub(to->to_world.t, from->to_world.t)) > 0.0;
}

static double gap(const double a[2], const double b[2])
{
    return hypot(a[0] - b[0], a[1] - b[1]);
}

/* Along one profile and back along the other. */
static enum rmap_status fill_between(const struct section *section,
                                     const struct rmap_outline_run *a,
                                     const struct rmap_outline_run *b, struct rmap_svg *svg,
                                     struct rmap_error *err)
{
    double(*point)[2] = section->outline.point;
    double(*pixel)[2] = rmap_alloc(a->n + b->n, sizeof *pixel);
    if (!pixel)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    const double *end = point[a->first + a->n - 1];
    bool forward = gap(end, point[b->first]) < gap(end, point[b->first + b->n - 1]);
    for (size_t i = 0; i < a->n; i++)
        rmap_view_pixel(section->frame, point[a->first + i], pixel[i]);
    for (size_t i = 0; i < b->n; i++)
        rmap_view_pixel(section->frame, point[b->first + (forward ? i : b->n - 1 - i)],
                        pixel[a->n + i]);
    rmap_svg_path(svg, (const double(*)[2])pixel, a->n + b->n,
                  &(struct rmap_svg_style){.fill = glass_fill});
    rmap_free(pixel);
    return RMAP_OK;
}

static enum rmap_status fill_glass(const struct section *section, struct rmap_svg *svg,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = section->scene;
    for (size_t a = 0; a < scene->n_object; a++) {
        size_t first = section->first_run[a], n = section->first_run[a + 1] - first;
        const struct rmap_outline_run *run = single_run(section, a);
        if (!is_cap(scene, a)) { /* a closed body; an open tube has open runs */
            bool closed = n > 0;
            for (size_t i = first; i < first + n; i++)
                closed = closed && section->outline.run[i].closed;
            if (closed && is_glass(scene, scene->object[a].medium_back))
                RMAP_TRY(rmap_outline_draw(&section->outline, first, n, section->frame, svg,
                                           &(struct rmap_svg_style){.fill = glass_fill}, err));
            continue;
        }
        for (size_t b = a + 1; run && b < scene->n_object && b <= a + NEIGHBOURS; b++)
            if (enclose_glass(scene, a, b) && single_run(section, b)) {
                RMAP_TRY(fill_between(section, run, single_run(section, b), svg, err));
                break;
            }
    }
out:
    return st;
}

enum rmap_status rmap_section_draw(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                   const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct section section = {.scene = scene, .frame = frame};
    double(*colour)[3] = rmap_object_colours(scene);
    section.first_run = rmap_alloc(scene->n_object + 1, sizeof *section.first_run);
    if (!section.first_run || !colour)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        RMAP_TRY(rmap_outline_cut(&section.outline, mesh[object->geometry], &object->to_world,
                                  frame->view, err));
        section.first_run[o + 1] = section.outline.n_run;
    }
    RMAP_TRY(fill_glass(&section, svg, err));
    for (size_t o = 0; o < scene->n_object; o++) {
        char ink[8];
        rmap_object_ink(rmap_object_look(scene, o), colour[o], ink);
        RMAP_TRY(rmap_outline_draw(&section.outline, section.first_run[o],
                                   section.first_run[o + 1] - section.first_run[o], frame, svg,
                                   &(struct rmap_svg_style){.stroke = ink, .width = 1.3}, err));
    }
out:
    rmap_free(colour);
    rmap_outline_fini(&section.outline);
    rmap_free(section.first_run);
    return st;
}
