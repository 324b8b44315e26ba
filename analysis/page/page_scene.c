/* SPDX-License-Identifier: MIT */
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "optics/spectrum.h"

static json_t *vector(struct rmap_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

/* Row by row, as in the scene file. */
static json_t *matrix(const struct rmap_affine *a)
{
    return json_pack("[f, f, f, f, f, f, f, f, f, f, f, f]", a->m[0][0], a->m[0][1], a->m[0][2],
                     a->t.x, a->m[1][0], a->m[1][1], a->m[1][2], a->t.y, a->m[2][0], a->m[2][1],
                     a->m[2][2], a->t.z);
}

static json_t *media(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_medium; i++)
        json_array_append_new(list, rmap_page_string(scene->medium[i].name));
    return list;
}

static json_t *groups(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_group; i++)
        json_array_append_new(list, json_pack("{s:o, s:i}", "name",
                                              rmap_page_string(scene->group[i].name), "parent",
                                              (int)scene->group[i].parent));
    return list;
}

static const char *look_of(const struct rmap_scene *scene, const struct rmap_object *object)
{
    if (rmap_scene_transmits(scene, object->surface_front) ||
        rmap_scene_transmits(scene, object->surface_back))
        return "glass";
    return rmap_surface_look(&scene->surface[object->surface_front]) == RMAP_LOOK_MIRROR ? "metal"
                                                                                         : "opaque";
}

/* Linear RGB of light with so much of each channel, all channels of the same power. */
static void colour_of(const struct rmap_channels *channels, const double *part, double rgb[3])
{
    double colour[RMAP_CHANNEL_MAX][3], sum[3] = {0.0, 0.0, 0.0};
    rmap_channel_colours(channels, 0, colour);
    for (int c = 0; c < channels->n; c++)
        for (int k = 0; k < 3; k++)
            sum[k] += (part ? part[c] : 1.0) * colour[c][k];
    if (channels->mode == RMAP_COLOUR_RGB)
        for (int k = 0; k < 3; k++)
            rgb[k] = sum[k];
    else
        rmap_xyz_to_rgb(sum, rgb);
}

/* Linear RGB of what a surface throws back of white light. */
static void albedo(const struct rmap_scene *scene, const struct rmap_surface *surface,
                   double rgb[3])
{
    double part[RMAP_CHANNEL_MAX], white[3];
    for (int c = 0; c < scene->channels.n; c++)
        part[c] = surface->reflect_diffuse[c] + surface->reflect_specular[c];
    colour_of(&scene->channels, part, rgb);
    colour_of(&scene->channels, NULL, white);
    for (int k = 0; k < 3; k++)
        rgb[k] = fabs(white[k]) > 0.0 ? fmin(fmax(rgb[k] / white[k], 0.0), 1.0) : part[0];
}

static json_t *objects(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        const struct rmap_surface *surface = &scene->surface[object->surface_front];
        double rgb[3];
        albedo(scene, surface, rgb);
        json_array_append_new(
            list, json_pack("{s:o, s:i, s:i, s:o, s:s, s:[f, f, f], s:o}", "name",
                            rmap_page_string(object->name), "parent", (int)object->parent,
                            "geometry", (int)object->geometry, "matrix", matrix(&object->to_world),
                            "look", look_of(scene, object), "albedo", rgb[0], rgb[1], rgb[2],
                            "surface", rmap_page_string(surface->name)));
    }
    return list;
}

static const char *emitter_word(const struct rmap_source *source)
{
    static const char *const word[] = {"point", "disc", "rectangle", "mesh"};
    return source->type == RMAP_SOURCE_RAYS ? "rays" : word[source->shape];
}

static json_t *sources(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_source; i++) {
        const struct rmap_source *source = &scene->source[i];
        bool listed = source->type == RMAP_SOURCE_RAYS && source->n_list > 0;
        struct rmap_affine place = source->frame;
        if (listed)
            place.t = source->list[0].origin;
        json_array_append_new(list, json_pack("{s:o, s:s, s:[f, f], s:o, s:f}", "name",
                                              rmap_page_string(source->name), "shape",
                                              emitter_word(source), "size", source->shape_size[0],
                                              source->shape_size[1], "matrix", matrix(&place),
                                              "flux", source->flux));
    }
    return list;
}

static json_t *wavelengths(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (int c = 0; c < scene->channels.n; c++)
        json_array_append_new(list, json_real(scene->channels.wavelength_nm[c]));
    return list;
}

json_t *rmap_page_scene(const struct rmap_scene *scene, struct rmap_error *err)
{
    json_t *json = json_pack("{s:o, s:s, s:s, s:o, s:o, s:f, s:o, s:o, s:o, s:o}", "unit",
                             rmap_page_string(scene->unit), "flux_unit",
                             scene->flux_unit == RMAP_FLUX_LM ? "lm" : "W", "mode",
                             scene->channels.mode == RMAP_COLOUR_RGB ? "rgb" : "spectral",
                             "wavelengths", wavelengths(scene), "centre", vector(scene->centre),
                             "radius", scene->radius, "media", media(scene), "groups",
                             groups(scene), "objects", objects(scene), "sources", sources(scene));
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the scene of a page");
    return json;
}
