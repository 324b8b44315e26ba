/* SPDX-License-Identifier: MIT
 *
 * Cameras, and the light that comes from outside the scene: what pictures need beside the rest.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_cameras.h"
#include "io/scene/scene_environment.h"
#include "io/scene/scene_field_frames.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_sources.h"

#define PIXELS_PER_SIDE_MAX 65535
#define PIXELS_MAX          (1u << 28)

/* ---- where it looks ---- */

/* From `at` to `look_at`, or `direction`; distance: to look_at, 0 where there is none. */
static bool read_forward(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_camera *camera, double *distance)
{
    const struct rmap_yaml_node *look_at = rmap_yaml_get(node, "look_at");
    struct rmap_vec3 target = {0, 0, 0};
    bool good = rmap_reader_vec3(reader, node, "at", &rmap_range_length, &camera->at);
    *distance = 0;
    if (look_at && rmap_yaml_get(node, "direction")) {
        rmap_reader_error(reader, look_at, "give 'look_at' or 'direction', not both");
        return false;
    }
    if (!look_at) {
        if (rmap_yaml_get(node, "direction"))
            return rmap_reader_direction(reader, node, "direction", &camera->forward) && good;
        rmap_reader_error(reader, node,
                          "say where camera '%.60s' looks: 'look_at' a point, or 'direction'",
                          camera->name);
        return false;
    }
    if (!rmap_reader_vec3(reader, node, "look_at", &rmap_range_length, &target) || !good)
        return false;
    struct rmap_vec3 away = rmap_sub(target, camera->at);
    *distance = rmap_length(away);
    if (!(*distance > 0)) {
        rmap_reader_error(reader, look_at,
                          "'look_at' is where camera '%.60s' stands: name a point in front of it",
                          camera->name);
        return false;
    }
    camera->forward = rmap_normalize(away);
    return true;
}

/* Up in the picture is what `up` looks like from the camera; z, or y for one that looks along z. */
static void read_up(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                    struct rmap_camera *camera)
{
    const double steep = 0.999; /* 2.6 degrees from the vertical */
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "up");
    struct rmap_vec3 up = {0, 0, 1};
    if (!at && fabs(camera->forward.z) > steep)
        up = rmap_vec3(0, 1, 0);
    if (at && !rmap_reader_direction(reader, node, "up", &up))
        return;
    struct rmap_vec3 right = rmap_cross(camera->forward, up);
    if (!(rmap_length(right) > 1e-9)) {
        rmap_reader_error(reader, at, "'up' is along the line of sight: give another direction");
        return;
    }
    camera->right = rmap_normalize(right);
    camera->up = rmap_cross(camera->right, camera->forward);
}

/* ---- what it sees ---- */

static void read_resolution(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_camera *camera)
{
    const struct rmap_range range = {1, PIXELS_PER_SIDE_MAX, "between 1 and 65535"};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "resolution");
    double pixels[2] = {640, 480};
    size_t n = 2;
    (void)rmap_reader_numbers(reader, node, "resolution", RMAP_OPTIONAL, &range, 2, 2, pixels, &n);
    if (pixels[0] != floor(pixels[0]) || pixels[1] != floor(pixels[1]))
        rmap_reader_error(reader, at, "'resolution' must be whole numbers");
    else if (pixels[0] * pixels[1] > PIXELS_MAX)
        rmap_reader_error(reader, at, "%.0f x %.0f pixels are too many: %u at most", pixels[0],
                          pixels[1], PIXELS_MAX);
    camera->resolution[0] = (uint32_t)pixels[0];
    camera->resolution[1] = (uint32_t)pixels[1];
}

/* `sensor` at the distance where a lens of this focal length makes its image. */
static void read_sensor(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_camera *camera)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "sensor");
    double f = 1, sensor[2] = {1, 1};
    size_t n = 0;
    if (!rmap_reader_number(reader, node, "focal_length", RMAP_REQUIRED,
                            &rmap_range_positive_length, &f) ||
        !rmap_reader_numbers(reader, node, "sensor", RMAP_REQUIRED, &rmap_range_positive_length, 2,
                             2, sensor, &n))
        return;
    double distance = f;
    const bool near = camera->type == RMAP_CAMERA_THIN_LENS && camera->focus > 0;
    if (near && !(camera->focus > f)) {
        rmap_reader_error(reader, at,
                          "camera '%.60s' cannot focus nearer than its focal length of %g",
                          camera->name, f);
        return;
    }
    if (near)
        distance = f * camera->focus / (camera->focus - f);
    camera->slope = 0.5 * sensor[1] / distance;
    double wanted = sensor[0] / sensor[1];
    double given = (double)camera->resolution[0] / (double)camera->resolution[1];
    if (fabs(given / wanted - 1) > 0.01)
        rmap_reader_warn(reader, at,
                         "a sensor of %g x %g has other proportions than the resolution: pixels "
                         "are square, and the height decides",
                         sensor[0], sensor[1]);
}

static void read_field(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_camera *camera)
{
    const struct rmap_range angle = {1e-6, 179, "an angle greater than 0 and up to 179 degrees",
                                     RMAP_DIMENSION_ANGLE};
    const struct rmap_yaml_node *fov_at = rmap_yaml_get(node, "fov");
    bool sensor = rmap_yaml_get(node, "sensor") || rmap_yaml_get(node, "focal_length");
    double fov = 40;
    if (fov_at && sensor) {
        rmap_reader_error(reader, fov_at, "give 'fov', or 'focal_length' and 'sensor'");
        return;
    }
    if (sensor)
        read_sensor(reader, node, camera);
    else if (rmap_reader_number(reader, node, "fov", RMAP_OPTIONAL, &angle, &fov))
        camera->slope = tan(0.5 * fov * RMAP_PI / 180);
}

#define SEEN                                                                                       \
    "name type at look_at up direction resolution fov sensor focal_length exposure medium within"
const struct rmap_mapping rmap_camera_keys = {
    "cameras",
    "pinhole thin_lens",
    {{"a pinhole camera", SEEN}, {"a thin_lens camera", SEEN " focus aperture"}},
    {{"exposure", RMAP_KEY_NUMBER, offsetof(struct rmap_camera, exposure), &rmap_range_positive},
     {"medium", RMAP_KEY_MEDIUM, offsetof(struct rmap_camera, medium)},
     {"aperture", RMAP_KEY_NUMBER, offsetof(struct rmap_camera, aperture),
      &rmap_range_positive_length, .need = RMAP_REQUIRED}}};

void rmap_reader_view(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool far,
                      struct rmap_camera *camera)
{
    double distance = 0;
    if (read_forward(reader, node, camera, &distance))
        read_up(reader, node, camera);
    camera->focus = distance;
    if (camera->type == RMAP_CAMERA_THIN_LENS)
        (void)rmap_reader_number(reader, node, "focus",
                                 distance > 0 || far ? RMAP_OPTIONAL : RMAP_REQUIRED,
                                 &rmap_range_positive_length, &camera->focus);
    read_resolution(reader, node, camera);
    read_field(reader, node, camera);
}

static void read_camera(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_camera *camera)
{
    int type = 0;
    if (!rmap_reader_choice(reader, node, "type", RMAP_OPTIONAL, rmap_camera_keys.types, &type))
        return;
    camera->type = (enum rmap_camera_type)type;
    (void)rmap_reader_known(reader, node, &rmap_camera_keys, type);
    (void)rmap_reader_fill(reader, node, &rmap_camera_keys, type, camera);
    rmap_reader_view(reader, node, false, camera);
    if (camera->medium < 0 && !rmap_yaml_get(node, "medium"))
        rmap_reader_surrounding_medium(reader, &camera->medium);
    rmap_reader_place_within(reader, node, camera->medium, &camera->gradient);
}

/* ---- the sections ---- */

static void check_unique(struct rmap_reader *reader, const struct rmap_yaml_node *list, size_t i,
                         const char *name)
{
    if (name[0] == RMAP_UNNAMED[0])
        return;
    for (size_t k = 0; k < i; k++) {
        const struct rmap_yaml_node *earlier = list->item[k].value;
        const struct rmap_yaml_node *taken = rmap_yaml_get(earlier, "name");
        if (!taken || taken->kind != RMAP_YAML_SCALAR || strcmp(taken->text, name) != 0)
            continue;
        rmap_reader_error(reader, list->item[i].value,
                          "the name '%.60s' is taken by the camera on line %d", name,
                          earlier->line);
        return;
    }
}

void rmap_reader_read_cameras(struct rmap_reader *reader)
{
    struct rmap_scene *scene = reader->scene;
    const struct rmap_yaml_node *list = rmap_yaml_get(reader->root, "cameras");
    if (!list || !rmap_reader_check_list(reader, list, "'cameras'"))
        return;
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *node = list->item[i].value;
        if (node->kind != RMAP_YAML_MAP) {
            rmap_reader_error(reader, node, "a camera must be a mapping, as in {name: front, ...}");
            continue;
        }
        struct rmap_camera *camera =
            RMAP_READER_NEW(reader, scene->camera, scene->n_camera, reader->cap_camera);
        if (!camera)
            return;
        *camera = (struct rmap_camera){.medium = -1, .slope = 1};
        const char *name = rmap_reader_name(reader, node);
        camera->name = rmap_reader_strdup(reader, name);
        check_unique(reader, list, i, name);
        read_camera(reader, node, camera);
    }
}

const struct rmap_mapping rmap_background_keys = {
    "cameras",
    NULL,
    {{"'background'",
      "radiance spectrum trace file map unit rotate up north toward rays_share medium"}},
    {{"radiance", RMAP_KEY_NUMBER, 0, &rmap_range_nonnegative}}};

void rmap_reader_read_background(struct rmap_reader *reader)
{
    struct rmap_scene *scene = reader->scene;
    const struct rmap_yaml_node *node = rmap_yaml_get(reader->root, "background");
    struct rmap_spectrum spectrum = {.kind = RMAP_SPECTRUM_EQUAL, .value = 1};
    double radiance = 0;
    if (!node || !rmap_reader_known(reader, node, &rmap_background_keys, 0))
        return;
    bool traced = true;
    if (!rmap_yaml_get(node, "file") == !rmap_yaml_get(node, "radiance"))
        rmap_reader_error(reader, node, "'background' has a 'file', or else a 'radiance'");
    if (!rmap_reader_bool(reader, node, "trace", &traced))
        return;
    if (rmap_yaml_get(node, "file") && !traced)
        rmap_reader_error(reader, rmap_yaml_get(node, "trace"),
                          "a picture is always traced: '--without background' leaves it out");
    if (rmap_reader_background_shines(reader)) /* a source */
        return;
    static const char *const traces[] = {"up", "north", "toward", "rays_share", "medium"};
    for (size_t i = 0; i < RMAP_COUNT(traces); i++)
        if (rmap_yaml_get(node, traces[i]))
            rmap_reader_error(reader, rmap_yaml_get(node, traces[i]),
                              "'%s' is for light that is traced: add 'trace: true'", traces[i]);
    (void)rmap_reader_fill(reader, node, &rmap_background_keys, 0, &radiance);
    rmap_reader_spectrum(reader, node, "spectrum", &spectrum);
    if (reader->diagnostics->n_error > 0)
        return;
    if (rmap_spectrum_shares(&spectrum, &scene->channels, scene->flux_unit == RMAP_FLUX_LM,
                             scene->background, &reader->failure) != RMAP_OK)
        rmap_reader_error(reader, node, "'background': %.200s", reader->failure.text);
    for (int i = 0; i < scene->channels.n; i++)
        scene->background[i] *= radiance;
    if (!rmap_yaml_get(node, "trace") && radiance > 0.0 &&
        (scene->n_detector > 0 || scene->n_camera == 0))
        rmap_reader_warn(reader, node,
                         "'background' is light for `raymap render` alone%s: trace sends no ray of "
                         "it; 'trace: true' makes it a source, 'trace: false' says that it is none",
                         scene->n_camera == 0 ? ", and there is no camera" : "");
}
