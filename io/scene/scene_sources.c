/* SPDX-License-Identifier: MIT
 *
 * Sources of light.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_beams.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_environment.h"
#include "io/scene/scene_field_frames.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_lamps.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_ray_files.h"
#include "io/scene/scene_skies.h"
#include "io/scene/scene_source_aim.h"
#include "io/scene/scene_source_light.h"
#include "io/scene/scene_sources.h"
#include "io/scene/scene_steps.h"
#include "io/scene/scene_volumes.h"

/* ---- shape and directions ---- */

void rmap_reader_mesh_shape(struct rmap_reader *reader, const struct rmap_yaml_node *shape,
                            struct rmap_source *source)
{
    const char *name = rmap_reader_text(reader, shape, "mesh", RMAP_REQUIRED);
    const struct rmap_yaml_node *at = rmap_yaml_get(shape, "mesh");
    source->shape = RMAP_EMITTER_MESH;
    source->shape_geometry = -1;
    if (!name)
        return;
    int32_t index = rmap_reader_find(reader, &reader->geometries, "geometry", at, name);
    if (index < 0 || reader->entry[index].broken)
        return;
    const struct rmap_geometry_entry *entry = &reader->entry[index];
    if (entry->lens || reader->scene->geometry[entry->geometry].kind != RMAP_GEOMETRY_MESH)
        rmap_reader_error(reader, at,
                          "geometry '%.60s' is no mesh: a source's shape is a disc, a "
                          "rectangle or a mesh",
                          name);
    else
        source->shape_geometry = entry->geometry;
}

static void read_shape(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_source *source)
{
    static const char *const key[] = {"disc", "rectangle", "mesh"};
    const struct rmap_yaml_node *shape = rmap_yaml_get(node, "shape");
    size_t n_key = source->type == RMAP_SOURCE_AREA ? 3 : 2, n = 0, given = 0;
    source->shape_geometry = -1;
    if (!shape) {
        rmap_reader_error(
            reader, node, "'shape' is missing: {disc: radius} or {rectangle: [width, height]}%s",
            source->type == RMAP_SOURCE_COLLIMATED ? "; or 'fills: NAME' of a lens" : "");
        return;
    }
    if (!rmap_reader_check_keys(reader, shape, "a shape", key, n_key))
        return;
    for (size_t i = 0; i < n_key; i++)
        given += rmap_yaml_get(shape, key[i]) != NULL;
    if (given != 1) {
        rmap_reader_error(reader, shape, "a shape is one of %s",
                          n_key == 3 ? "disc, rectangle, mesh" : "disc, rectangle");
    } else if (rmap_yaml_get(shape, "disc")) {
        source->shape = RMAP_EMITTER_DISC;
        (void)rmap_reader_number(reader, shape, "disc", RMAP_REQUIRED, &rmap_range_size,
                                 &source->shape_size[0]);
    } else if (rmap_yaml_get(shape, "rectangle")) {
        source->shape = RMAP_EMITTER_RECTANGLE;
        (void)rmap_reader_numbers(reader, shape, "rectangle", RMAP_REQUIRED, &rmap_range_size, 1, 2,
                                  source->shape_size, &n);
        if (n == 1)
            source->shape_size[1] = source->shape_size[0];
    } else {
        rmap_reader_mesh_shape(reader, shape, source);
    }
}

static void read_frame(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_source *source)
{
    struct rmap_vec3 direction = {0, 0, 1};
    const struct rmap_yaml_node *rotate = rmap_yaml_get(node, "rotate");
    const struct rmap_yaml_node *scale = rmap_yaml_get(node, "scale");
    bool turned = rotate || rmap_yaml_get(node, "matrix");
    bool mesh = source->shape == RMAP_EMITTER_MESH && source->type == RMAP_SOURCE_AREA;
    if (scale && !mesh)
        rmap_reader_error(reader, scale, "'scale' is for mesh shapes: give the shape its size");
    if (turned && rotate && rmap_yaml_get(node, "direction"))
        rmap_reader_error(reader, rotate, "give 'direction' or 'rotate', not both");
    bool good = rmap_reader_placement(reader, node, &source->frame);
    good &= rmap_reader_direction(reader, node, "direction", &direction);
    if (!good)
        return;
    if (!turned) {
        struct rmap_affine scaling = source->frame;
        scaling.t = rmap_vec3(0, 0, 0);
        struct rmap_affine frame = rmap_affine_frame(direction, source->frame.t);
        source->frame = mesh ? rmap_affine_compose(&frame, &scaling) : frame;
    } else if (!mesh) {
        source->frame = rmap_placement_rigid(&source->frame);
    }
}

/* {angle: [0, 30, 90], value: [100, 80, 0]} */
static void read_profile(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_source *source)
{
    double *column[2];
    size_t n = 0;
    struct rmap_error err = {0};
    rmap_reader_table(reader, node, "angle value", 2, &rmap_range_nonnegative, &n, column);
    if (n > 0 && rmap_profile_init(column[0], column[1], n, &source->profile, &err) != RMAP_OK)
        rmap_reader_error(reader, node, "%s", err.text);
}

/* "cosine", "cone 20", {cone: 20}, or the key `cone` beside `distribution`. */
static void read_distribution(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_source *source, struct rmap_source_light *light)
{
    const bool area = source->type == RMAP_SOURCE_AREA;
    const struct rmap_range angle = {1e-9, 180, "an angle greater than 0 and up to 180 degrees",
                                     RMAP_DIMENSION_ANGLE};
    const struct rmap_range sine = {1e-9, 1, "greater than 0 and up to 1"};
    const struct rmap_range power = {0, 1e6, "between 0 and 1,000,000"};
    const struct rmap_yaml_node *given = rmap_yaml_get(node, "distribution"), *from = node;
    double cone = 0, cosine_power = 1;
    int choice = 0;
    if (given && given->kind == RMAP_YAML_MAP) {
        (void)rmap_reader_check_map(reader, given, "a distribution", "cone cosine_power table na");
        from = given;
    } else if (given) {
        (void)rmap_reader_choice(reader, node, "distribution", RMAP_OPTIONAL,
                                 area ? "lambertian cosine" : "isotropic cosine", &choice);
    }
    bool has_cone = rmap_yaml_get(from, "cone"), has_power = rmap_yaml_get(from, "cosine_power");
    const struct rmap_yaml_node *table = from == given ? rmap_yaml_get(given, "table") : NULL;
    const bool has_na = rmap_yaml_get(from, "na");
    if (has_cone + has_power + has_na + !!table > 1)
        rmap_reader_error(reader, from, "give one of 'cone', 'cosine_power', 'na' and 'table'");
    if (has_na && !area)
        rmap_reader_error(reader, rmap_yaml_get(from, "na"),
                          "'na' is of an area, as the end of a fibre");
    (void)rmap_reader_number(reader, from, "na", RMAP_OPTIONAL, &sine, &source->aperture);
    const bool file = table && (table->kind != RMAP_YAML_MAP || rmap_yaml_get(table, "file"));
    if (file)
        rmap_reader_distribution_file(reader, table->kind == RMAP_YAML_MAP ? table : given,
                                      table->kind == RMAP_YAML_MAP ? "file" : "table", source,
                                      light);
    else if (table)
        read_profile(reader, table, source);
    (void)rmap_reader_number(reader, from, "cone", RMAP_OPTIONAL, &angle, &cone);
    (void)rmap_reader_number(reader, from, "cosine_power", RMAP_OPTIONAL, &power, &cosine_power);
    source->distribution = file                               ? RMAP_DISTRIBUTION_LAMP
                           : table                            ? RMAP_DISTRIBUTION_TABLE
                           : has_na                           ? RMAP_DISTRIBUTION_SINE
                           : has_cone                         ? RMAP_DISTRIBUTION_CONE
                           : has_power || choice == 1 || area ? RMAP_DISTRIBUTION_COSINE
                                                              : RMAP_DISTRIBUTION_ISOTROPIC;
    source->cone_rad = cone * RMAP_PI / 180;
    source->cosine_power = cosine_power;
}

/* Of the cone of directions that a collimated source shines in, as the sun's disc is seen. */
static void read_angular_diameter(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                  struct rmap_source *source)
{
    static const struct rmap_range angle = {
        1e-9, 90, "an angle greater than 0 and up to 90 degrees", RMAP_DIMENSION_ANGLE};
    double diameter = 0;
    (void)rmap_reader_number(reader, node, "angular_diameter", RMAP_OPTIONAL, &angle, &diameter);
    if (diameter > 0)
        source->distribution = RMAP_DISTRIBUTION_CONE;
    source->cone_rad = 0.5 * diameter * RMAP_PI / 180;
}

/* ---- rays ---- */

static void read_ray(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_list_ray *ray)
{
    static const char *const key[] = {"origin", "direction"};
    double nm = 0;
    ray->direction = rmap_vec3(0, 0, 1);
    ray->channel = -1;
    if (!rmap_reader_check_map(reader, node, "a ray", "origin direction wavelength"))
        return;
    for (int i = 0; i < 2; i++)
        if (!rmap_yaml_get(node, key[i]))
            rmap_reader_error(reader, node, "'%s' is missing: add it", key[i]);
    (void)rmap_reader_vec3(reader, node, "origin", &rmap_range_length, &ray->origin);
    (void)rmap_reader_direction(reader, node, "direction", &ray->direction);
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "wavelength");
    if (at &&
        rmap_reader_number(reader, node, "wavelength", RMAP_OPTIONAL, &rmap_range_wavelength,
                           &nm) &&
        reader->scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        ray->channel = rmap_reader_channel(reader, at, nm);
}

static void read_rays(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_source *source)
{
    const struct rmap_yaml_node *rays = rmap_yaml_get(node, "rays");
    if (!rays) {
        rmap_reader_error(reader, node, "'rays' is missing: list the rays of source '%.60s'",
                          source->name);
        return;
    }
    if (!rmap_reader_check_list(reader, rays, "'rays'"))
        return;
    if (!rays->n_item)
        rmap_reader_error(reader, rays, "'rays' must not be empty");
    source->list = rmap_alloc(rays->n_item, sizeof *source->list);
    if (!source->list) {
        rmap_reader_no_memory(reader);
        return;
    }
    source->n_list = rays->n_item;
    for (size_t i = 0; i < rays->n_item; i++)
        read_ray(reader, rays->item[i].value, &source->list[i]);
}

/* ---- one source ---- */

#define PLACED "at direction rotate scale matrix "
#define FAR    "sun place time up north toward "
#define LIGHT  "flux spectrum rays_share medium within"
const struct rmap_mapping rmap_source_keys = {
    "sources",
    "collimated point area rays lamp volume sky sun beam steps ray_file",
    {{"a collimated source", "name type shape fills field angular_diameter profile " PLACED LIGHT},
     {"a point source", "name type distribution cone cosine_power " PLACED LIGHT},
     {"an area source", "name type shape distribution cone cosine_power na " PLACED LIGHT},
     {"a list of rays", "name type rays " LIGHT},
     {"a lamp", "name type file set tilt emitter spin at direction rotate " LIGHT},
     {"a volume source", "name type in from to file dataset axes lower upper spacing origin unit "
                         "at rotate scale matrix " LIGHT},
     {"a sky",
      "name type model kind horizontal zenith radiance direct diffuse file map unit rotate " FAR
          LIGHT},
     {"a sun", "name type irradiance shape direction " FAR LIGHT},
     {"a Gaussian beam", "name type waist divergence wavelength waist_at " PLACED LIGHT},
     {"steps of particles",
      "name type file format unit emit count seed wavelengths at rotate scale matrix rays_share "
      "medium within"},
     {"a file of rays", "name type file format detector where unit at rotate scale matrix " LIGHT}},
    {{"rays_share", RMAP_KEY_NUMBER, offsetof(struct rmap_source, share), &rmap_range_positive, 1},
     {"medium", RMAP_KEY_MEDIUM, offsetof(struct rmap_source, medium)}}};

/* Words of `type` that are another type of source. */
enum { RAY_FILE = RMAP_SOURCE_STEPS + 1 };

static void read_source(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_source *source, struct rmap_source_light *light)
{
    source->medium = -1;
    source->frame = rmap_affine_identity();
    source->cosine_power = 1;
    source->shape_geometry = -1;
    light->node = node;
    light->spectrum = (struct rmap_spectrum){.kind = RMAP_SPECTRUM_EQUAL, .value = 1};
    light->spectrum_given = rmap_yaml_get(node, "spectrum") != NULL;
    rmap_reader_read_flux(reader, node, light);
    rmap_reader_spectrum(reader, node, "spectrum", &light->spectrum);
    const bool around = node == rmap_yaml_get(reader->root, "background");
    int type = around ? RMAP_SOURCE_SKY : rmap_reader_type(reader, node, &rmap_source_keys);
    (void)rmap_reader_fill(reader, node, &rmap_source_keys, type, source);
    if (type < 0)
        return;
    (void)rmap_reader_known(reader, node, around ? &rmap_background_keys : &rmap_source_keys,
                            around ? 0 : type);
    if (type == RAY_FILE) {
        rmap_reader_read_ray_file(reader, node, source, light);
        return;
    }
    if (type == RMAP_SOURCE_VOLUME) {
        rmap_reader_read_volume(reader, node, source);
        return;
    }
    source->type = (enum rmap_source_type)type;
    switch (source->type) {
    case RMAP_SOURCE_COLLIMATED:
        read_angular_diameter(reader, node, source);
        if (rmap_reader_aim_source(reader, node, source)) {
            rmap_reader_read_profile(reader, node, source);
            return;
        }
        read_shape(reader, node, source);
        rmap_reader_read_profile(reader, node, source);
        break;
    case RMAP_SOURCE_POINT:
        source->shape = RMAP_EMITTER_POINT;
        read_distribution(reader, node, source, light);
        break;
    case RMAP_SOURCE_AREA:
        read_shape(reader, node, source);
        read_distribution(reader, node, source, light);
        break;
    case RMAP_SOURCE_RAYS:
        read_rays(reader, node, source);
        return;
    case RMAP_SOURCE_STEPS:
        rmap_reader_read_steps(reader, node, source);
        return;
    case RMAP_SOURCE_SKY:
    case RMAP_SOURCE_SUN:
        rmap_reader_read_sky(reader, node, source, light);
        return;
    case RMAP_SOURCE_LAMP:
    case RMAP_SOURCE_VOLUME:
        break;
    case RMAP_SOURCE_BEAM:
        rmap_reader_read_beam(reader, node, source);
        break;
    }
    read_frame(reader, node, source);
    if (source->type == RMAP_SOURCE_LAMP && !source->lamp)
        rmap_reader_read_lamp(reader, node, source, light);
}

/* How much a group makes what stands in it larger, the same in all directions; 0: not the same. */
static double enlargement(const struct rmap_affine *to_world)
{
    double length[3];
    for (int j = 0; j < 3; j++)
        length[j] = rmap_length(rmap_vec3(to_world->m[0][j], to_world->m[1][j], to_world->m[2][j]));
    const bool same = fabs(length[1] - length[0]) < 1e-9 * length[0] &&
                      fabs(length[2] - length[0]) < 1e-9 * length[0];
    return same ? length[0] : 0;
}

/* From the group's frame to the world. */
static void place_source(struct rmap_reader *reader, const struct rmap_placed_source *placed,
                         struct rmap_source *source)
{
    const bool mesh = source->type == RMAP_SOURCE_AREA && source->shape == RMAP_EMITTER_MESH;
    const double larger = enlargement(&placed->to_world);
    source->parent = placed->parent;
    if (rmap_yaml_get(placed->node, "fills") ||
        (source->volume && source->volume->kind == RMAP_VOLUME_BODY)) /* in the world already */
        return;
    source->frame = rmap_affine_compose(&placed->to_world, &source->frame);
    if (mesh || source->rays || source->volume || source->type == RMAP_SOURCE_STEPS)
        return;
    if (!(larger > 0))
        rmap_reader_error(reader, placed->node,
                          "source '%.60s' stands in a group that is stretched, and can only be "
                          "made larger as a whole: give its group one number as 'scale'",
                          source->name);
    source->frame = rmap_placement_rigid(&source->frame);
    for (int k = 0; k < 2; k++)
        source->shape_size[k] *= larger;
    if (source->type == RMAP_SOURCE_BEAM)
        source->cone_rad *= larger;
    if (source->lamp)
        rmap_lamp_enlarge(source->lamp, larger);
    for (size_t i = 0; i < source->n_list; i++) {
        struct rmap_list_ray *ray = &source->list[i];
        ray->origin = rmap_affine_point(&placed->to_world, ray->origin);
        ray->direction = rmap_normalize(rmap_affine_vector(&placed->to_world, ray->direction));
    }
}

/* One of the scene's own list, or one that is placed with its group. False when memory is short. */
static bool add_source(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_placed_source *placed, struct rmap_source_light *light,
                       size_t *n)
{
    struct rmap_scene *scene = reader->scene;
    if (node->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, node, "a source must be a mapping, as in {name: lamp, ...}");
        return true;
    }
    struct rmap_source *source =
        RMAP_READER_NEW(reader, scene->source, scene->n_source, reader->cap_source);
    if (!source)
        return false;
    source->name =
        rmap_reader_strdup(reader, placed ? placed->name : rmap_reader_name(reader, node));
    source->line = node->line;
    source->column = node->column;
    source->parent = -1;
    light[*n].source = (int32_t)(scene->n_source - 1);
    rmap_reader_add_member(reader, source->name, RMAP_MEMBER_SOURCE, light[*n].source, node);
    read_source(reader, node, source, &light[(*n)++]);
    if (placed)
        place_source(reader, placed, source);
    return true;
}

/* ---- what a source says by saying nothing ---- */

void rmap_reader_surrounding_medium(struct rmap_reader *reader, int32_t *medium_ret)
{
    *medium_ret = rmap_scene_surrounding_medium(reader->scene);
    if (*medium_ret < 0)
        rmap_reader_vacuum(reader, medium_ret);
}

static void settle(struct rmap_reader *reader, const struct rmap_source_light *light, size_t n)
{
    struct rmap_scene *scene = reader->scene;
    int32_t medium = -1;
    rmap_reader_settle_unit(reader, light, n);
    for (size_t i = 0; i < n; i++) {
        rmap_reader_settle_light(reader, &light[i]);
        struct rmap_source *source = &scene->source[light[i].source];
        bool named = source->medium >= 0 || rmap_yaml_get(light[i].node, "medium");
        if (!named && medium < 0)
            rmap_reader_surrounding_medium(reader, &medium);
        if (!named)
            source->medium = medium;
        rmap_reader_place_within(reader, light[i].node, source->medium, &source->gradient);
        if (source->type == RMAP_SOURCE_STEPS)
            rmap_reader_settle_steps(reader, light[i].node, source);
    }
}

void rmap_reader_read_sources(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *sources = rmap_yaml_get(reader->root, "sources");
    if (sources && !rmap_reader_check_list(reader, sources, "'sources'"))
        return;
    const struct rmap_yaml_node *around = rmap_yaml_get(reader->root, "background");
    const size_t n_own = sources ? sources->n_item : 0;
    if (rmap_reader_background_shines(reader) &&
        rmap_reader_room(reader, &reader->placed, &reader->cap_placed, reader->n_placed,
                         sizeof *reader->placed))
        reader->placed[reader->n_placed++] =
            (struct rmap_placed_source){around, "background", -1, rmap_affine_identity()};
    if (n_own + reader->n_placed == 0 && around && rmap_yaml_get(reader->root, "cameras"))
        return; /* for pictures alone, which have the background's light */
    if (n_own + reader->n_placed == 0) {
        rmap_reader_error(reader, sources, "no sources: a scene needs at least one");
        return;
    }
    struct rmap_source_light *light =
        rmap_reader_alloc(reader, n_own + reader->n_placed, sizeof *light);
    if (!light)
        return;
    size_t n = 0;
    bool good = true;
    for (size_t i = 0; i < n_own && good; i++)
        good = add_source(reader, sources->item[i].value, NULL, light, &n);
    for (size_t i = 0; i < reader->n_placed && good; i++)
        good = add_source(reader, reader->placed[i].node, &reader->placed[i], light, &n);
    if (good)
        settle(reader, light, n);
}
