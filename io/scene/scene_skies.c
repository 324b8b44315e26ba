/* SPDX-License-Identifier: MIT
 *
 * Light from far away: skies, the sun.
 */
#include "io/scene/scene_skies.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "formula/azimuth.h"
#include "io/scene/scene_environment.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_sky_models.h"
#include "optics/sun.h"
#include "scene/bounds.h"

/* ---- how bright ---- */

/* Irradiance, and radiance. */
static const struct sky_unit {
    const char *name;
    double size;
    enum rmap_flux_unit flux;
    bool per_sr;
} sky_units[] = {{"lx", 1, RMAP_FLUX_LM, false},        {"klx", 1e3, RMAP_FLUX_LM, false},
                 {"W/m2", 1, RMAP_FLUX_W, false},       {"kW/m2", 1e3, RMAP_FLUX_W, false},
                 {"cd/m2", 1, RMAP_FLUX_LM, true},      {"kcd/m2", 1e3, RMAP_FLUX_LM, true},
                 {"W/(m2 sr)", 1, RMAP_FLUX_W, true},   {"W/m2/sr", 1, RMAP_FLUX_W, true},
                 {"kW/(m2 sr)", 1e3, RMAP_FLUX_W, true}};

/* "10000 lx". False when absent, or after a complaint. */
static bool read_bright(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *key, bool per_sr, const char *usual, double *value,
                        enum rmap_flux_unit *flux)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, key);
    const char *text = at ? rmap_reader_text(reader, node, key, RMAP_OPTIONAL) : NULL, *unit = "";
    const char *known[RMAP_COUNT(sky_units)];
    size_t n = 0;
    if (!text)
        return false;
    if (!rmap_reader_parse_quantity(text, value, &unit) || !(*value > 0)) {
        rmap_reader_error(reader, at, "'%s' must be greater than 0, as in '1000 %s', not '%.40s'",
                          key, usual, text);
        return false;
    }
    unit = unit[0] ? unit : usual;
    for (size_t i = 0; i < RMAP_COUNT(sky_units); i++) {
        if (sky_units[i].per_sr != per_sr)
            continue;
        known[n++] = sky_units[i].name;
        if (strcmp(unit, sky_units[i].name) != 0)
            continue;
        *value *= sky_units[i].size;
        *flux = sky_units[i].flux;
        return true;
    }
    rmap_reader_unknown(reader, at->line, at->column,
                        per_sr ? "unknown unit of radiance" : "unknown unit of irradiance", unit,
                        known, n);
    return false;
}

/* One of these keys, or `flux`, says it. */
static void read_amount(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *const *key, size_t n, struct rmap_source_light *light,
                        struct rmap_sky_plan *plan)
{
    size_t given = rmap_yaml_get(node, "flux") != NULL;
    char all[120];
    plan->amount = light->flux;
    for (size_t i = 0; i < n; i++) {
        const bool per_sr = strcmp(key[i], "zenith") == 0 || strcmp(key[i], "radiance") == 0;
        if (!rmap_yaml_get(node, key[i]))
            continue;
        if (read_bright(reader, node, key[i], per_sr,
                        per_sr                              ? "cd/m2"
                        : strcmp(key[i], "horizontal") == 0 ? "lx"
                                                            : "W/m2",
                        &plan->amount, &light->unit))
            plan->measure = per_sr ? RMAP_SKY_RADIANCE : RMAP_SKY_IRRADIANCE;
        given++;
    }
    light->flux = 1;
    rmap_words_list(key, n, all, sizeof all);
    if (given != 1)
        rmap_reader_error(reader, node, "say once how bright it is: by one of %s, flux", all);
}

/* ---- where the sun stands ---- */

static bool read_place(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_sun_seen *sun)
{
    static const struct rmap_range range = {-180, 180, "an angle between -180 and 180 degrees",
                                            RMAP_DIMENSION_ANGLE};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "time");
    double place[2] = {0, 0}, seconds = 0;
    size_t n = 0;
    if (!rmap_reader_numbers(reader, node, "place", RMAP_REQUIRED, &range, 2, 2, place, &n) ||
        !rmap_reader_text(reader, node, "time", RMAP_REQUIRED))
        return false;
    if (!(place[0] >= -90 && place[0] <= 90)) {
        rmap_reader_error(reader, rmap_yaml_get(node, "place"),
                          "'place' is [latitude, longitude]: a latitude of -90 to 90 degrees, "
                          "north positive, and a longitude, east positive");
        return false;
    }
    if (!rmap_time_parse(at->text, &seconds)) {
        rmap_reader_error(reader, at,
                          "'time' must be a date and a time with its zone, as in "
                          "2026-06-21T12:00+02:00, not '%.40s'",
                          at->text);
        return false;
    }
    if (at->text[0] == '1' && strncmp(at->text, "1950", 4) < 0)
        rmap_reader_warn(reader, at, "the sun's place is good to 0.01 degrees from 1950 to 2050");
    const struct rmap_sun_place stands = rmap_sun_place(place[0], place[1], seconds);
    *sun =
        (struct rmap_sun_seen){stands.azimuth, stands.altitude, rmap_sun_nearness(seconds), true};
    return true;
}

/* `place` and `time`, or `sun: [azimuth, altitude]`. */
static bool read_sun(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_sun_seen *sun)
{
    static const struct rmap_range range = {-360, 360, "an angle in degrees", RMAP_DIMENSION_ANGLE};
    const struct rmap_yaml_node *own = rmap_yaml_get(node, "sun"),
                                *place = rmap_yaml_get(node, "place");
    double angle[2] = {0, 90};
    size_t n = 0;
    *sun = (struct rmap_sun_seen){.nearness = 1};
    if (own && (place || rmap_yaml_get(node, "time"))) {
        rmap_reader_error(reader, own, "give 'sun', or 'place' and 'time', not both");
        return false;
    }
    if (place || rmap_yaml_get(node, "time"))
        return read_place(reader, node, sun);
    if (!own)
        return true;
    if (!rmap_reader_numbers(reader, node, "sun", RMAP_REQUIRED, &range, 2, 2, angle, &n))
        return false;
    *sun = (struct rmap_sun_seen){angle[0], angle[1], 1, true};
    return true;
}

static bool above_horizon(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          const struct rmap_sun_seen *sun, const char *what)
{
    if (!sun->known)
        rmap_reader_error(reader, node,
                          "%s needs the sun's place: 'place: [latitude, longitude]' and "
                          "'time: 2026-06-21T12:00+02:00', or 'sun: [azimuth, altitude]'",
                          what);
    else if (!(sun->altitude > 0 && sun->altitude <= 90))
        rmap_reader_error(reader, node, "the sun is %.4g degrees below the horizon then",
                          -sun->altitude);
    return sun->known && sun->altitude > 0 && sun->altitude <= 90;
}

/* x south, y east, z up of a sky. */
static bool read_axes(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_affine *frame)
{
    struct rmap_vec3 up = {0, 0, 1}, north = {0, 1, 0};
    if (!rmap_reader_direction(reader, node, "up", &up) ||
        !rmap_reader_direction(reader, node, "north", &north))
        return false;
    const struct rmap_vec3 level = rmap_axpy(-rmap_dot(up, north), up, north);
    if (!(rmap_length(level) > 1e-6)) {
        rmap_reader_error(reader, node, "'up' and 'north' must not point the same way");
        return false;
    }
    const struct rmap_vec3 x = rmap_scale(rmap_normalize(level), -1), y = rmap_cross(up, x);
    *frame =
        (struct rmap_affine){{{x.x, y.x, up.x}, {x.y, y.y, up.y}, {x.z, y.z, up.z}}, {0, 0, 0}};
    return true;
}

struct rmap_vec3 rmap_sky_direction(double azimuth, double altitude)
{
    double ca, sa, ch, sh;
    const double turns = azimuth / 360.0 - floor(azimuth / 360.0);
    rmap_azimuth(turns, &ca, &sa);
    rmap_azimuth(altitude / 360.0, &ch, &sh);
    return rmap_vec3(-ca * ch, sa * ch, sh);
}

/* ---- one source ---- */

static void read_shape(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       enum rmap_sunshape *shape, double *size)
{
    static const char *const key[] = {"pillbox", "gaussian", "buie"};
    static const struct rmap_range angle = {1e-6, 20,
                                            "an angle greater than 0 and up to 20 degrees",
                                            RMAP_DIMENSION_ANGLE},
                                   ratio = {0, 0.849, "between 0 and 0.849"};
    const struct rmap_yaml_node *given = rmap_yaml_get(node, "shape");
    *shape = RMAP_SUNSHAPE_PILLBOX;
    *size = RMAP_SUN_RIM;
    if (!given || !rmap_reader_check_keys(reader, given, "a sun's shape", key, RMAP_COUNT(key)))
        return;
    if (given->n_item != 1) {
        rmap_reader_error(reader, given, "a sun's shape is one of pillbox, gaussian, buie");
        return;
    }
    for (int i = 0; i < 3; i++)
        if (strcmp(given->item[0].key, key[i]) == 0)
            *shape = (enum rmap_sunshape)i;
    const bool is_angle = *shape != RMAP_SUNSHAPE_BUIE;
    if (rmap_reader_number(reader, given, key[*shape], RMAP_REQUIRED, is_angle ? &angle : &ratio,
                           size) &&
        is_angle)
        *size *= RMAP_PI / 180;
}

static void read_the_sun(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_source *source, struct rmap_source_light *light,
                         struct rmap_sky_plan *plan)
{
    static const char *const amount[] = {"irradiance"};
    struct rmap_affine axes;
    struct rmap_sun_seen sun;
    struct rmap_vec3 direction = {0, 0, -1};
    enum rmap_sunshape shape;
    double size = 0;
    read_amount(reader, node, amount, 1, light, plan);
    read_shape(reader, node, &shape, &size);
    if (!read_axes(reader, node, &axes) || !read_sun(reader, node, &sun) ||
        !rmap_reader_direction(reader, node, "direction", &direction))
        return;
    if (rmap_yaml_get(node, "direction") && sun.known)
        rmap_reader_error(reader, node, "give 'direction' or the sun's place, not both");
    if (!rmap_yaml_get(node, "direction")) {
        if (!above_horizon(reader, node, &sun, "a sun"))
            return;
        direction = rmap_scale(
            rmap_affine_vector(&axes, rmap_sky_direction(sun.azimuth, sun.altitude)), -1);
        (void)snprintf(source->sky->title, sizeof source->sky->title,
                       "azimuth %.3f, altitude %.3f deg", sun.azimuth, sun.altitude);
    }
    source->frame = rmap_affine_frame(rmap_scale(direction, -1), rmap_vec3(0, 0, 0));
    rmap_reader_made(reader, node, rmap_sky_of_sun(shape, size, source->sky, &reader->failure));
}

static void read_cie(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_source *source, const struct rmap_sun_seen *sun)
{
    uint64_t kind = 0;
    if (!rmap_yaml_get(node, "kind")) {
        rmap_reader_error(reader, node,
                          "'kind' is missing: 1 (overcast) to 15, 5 being uniform, 12 a clear sky");
        return;
    }
    if (!rmap_reader_whole(reader, node, "kind", 1, RMAP_CIE_SKIES, &kind))
        return;
    const struct rmap_sky_pattern pattern = rmap_cie_sky((int)kind);
    if (rmap_sky_pattern_has_sun(&pattern) &&
        !above_horizon(reader, node, sun, "a sky of this kind"))
        return;
    (void)snprintf(source->sky->title, sizeof source->sky->title, "CIE type %d", (int)kind);
    rmap_reader_made(reader, node,
                     rmap_sky_of_pattern(&pattern, sun, source->sky, &reader->failure));
}

static void read_perez(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_source *source, const struct rmap_sun_seen *sun,
                       struct rmap_source_light *light, struct rmap_sky_plan *plan)
{
    double direct = 0, diffuse = 0;
    enum rmap_flux_unit unit = RMAP_FLUX_W;
    struct rmap_sky_pattern pattern;
    if (!rmap_yaml_get(node, "direct") || !rmap_yaml_get(node, "diffuse")) {
        rmap_reader_error(reader, node,
                          "a Perez sky needs 'direct', the irradiance of what faces the sun by its "
                          "disc, and 'diffuse', that of the ground by the sky, in W/m2");
        return;
    }
    if (!read_bright(reader, node, "direct", false, "W/m2", &direct, &unit) ||
        !read_bright(reader, node, "diffuse", false, "W/m2", &diffuse, &unit) ||
        !above_horizon(reader, node, sun, "a Perez sky"))
        return;
    if (unit == RMAP_FLUX_LM) {
        rmap_reader_error(reader, rmap_yaml_get(node, "diffuse"),
                          "'direct' and 'diffuse' must be in W/m2: they tell what sky it is; "
                          "'horizontal: 10000 lx' may say how bright");
        return;
    }
    pattern = rmap_perez_sky(direct, diffuse, 90 - sun->altitude, sun->nearness);
    if (!rmap_yaml_get(node, "horizontal") && !rmap_yaml_get(node, "zenith") &&
        !rmap_yaml_get(node, "flux")) {
        plan->amount = diffuse;
        plan->measure = RMAP_SKY_IRRADIANCE;
        light->unit = RMAP_FLUX_W;
    }
    (void)snprintf(source->sky->title, sizeof source->sky->title, "Perez");
    rmap_reader_made(reader, node,
                     rmap_sky_of_pattern(&pattern, sun, source->sky, &reader->failure));
}

static void read_a_sky(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_source *source, struct rmap_source_light *light,
                       struct rmap_sky_plan *plan)
{
    static const char *const of_pattern[] = {"horizontal", "zenith"}, *const of_all[] = {
                                                                          "radiance"};
    enum { CIE, PEREZ, UNIFORM, ENVIRONMENT };
    const bool around = node == rmap_yaml_get(reader->root, "background");
    int model = rmap_yaml_get(node, "file") ? ENVIRONMENT : around ? UNIFORM : CIE;
    struct rmap_sun_seen sun;
    if ((!around && !rmap_reader_choice(reader, node, "model", RMAP_OPTIONAL,
                                        "cie perez uniform environment", &model)) ||
        !read_axes(reader, node, &source->frame) || !read_sun(reader, node, &sun))
        return;
    const bool dim = model == PEREZ && !rmap_yaml_get(node, "horizontal") &&
                     !rmap_yaml_get(node, "zenith") && !rmap_yaml_get(node, "flux");
    light->flux = rmap_yaml_get(node, "flux") ? light->flux : 1;
    if (!dim && model < UNIFORM)
        read_amount(reader, node, of_pattern, 2, light, plan);
    switch (model) {
    case CIE:
        read_cie(reader, node, source, &sun);
        break;
    case PEREZ:
        read_perez(reader, node, source, &sun, light, plan);
        break;
    case ENVIRONMENT:
        rmap_reader_read_environment(reader, node, source, light, plan);
        break;
    default:
        if (around) { /* in whatever unit the sources have, as in pictures */
            light->either = true;
            plan->measure = RMAP_SKY_RADIANCE;
            (void)rmap_reader_number(reader, node, "radiance", RMAP_REQUIRED, &rmap_range_positive,
                                     &plan->amount);
        } else {
            read_amount(reader, node, of_all, 1, light, plan);
        }
        (void)snprintf(source->sky->title, sizeof source->sky->title, "uniform");
        rmap_reader_made(reader, node, rmap_sky_of_all(source->sky, &reader->failure));
    }
}

void rmap_reader_read_sky(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_source *source, struct rmap_source_light *light)
{
    struct rmap_sky_plan *plan =
        RMAP_READER_NEW(reader, reader->sky, reader->n_sky, reader->cap_sky);
    source->shape = RMAP_EMITTER_SKY;
    source->distribution = RMAP_DISTRIBUTION_SKY;
    source->shape_size[0] = 1;
    source->sky = rmap_alloc(1, sizeof *source->sky);
    if (!plan || !source->sky) {
        rmap_reader_no_memory(reader);
        return;
    }
    *plan = (struct rmap_sky_plan){.source = light->source, .node = node};
    if (source->type == RMAP_SOURCE_SUN)
        read_the_sun(reader, node, source, light, plan);
    else
        read_a_sky(reader, node, source, light, plan);
}

/* ---- what is lit ---- */

/* A sphere about objects and detectors. */
static double enclose(const struct rmap_scene *scene, struct rmap_vec3 *centre)
{
    struct rmap_bounds box = rmap_bounds_empty();
    for (size_t i = 0; i < scene->n_object; i++)
        rmap_bounds_include_geometry(&box, &scene->geometry[scene->object[i].geometry],
                                     &scene->object[i].to_world);
    for (size_t i = 0; i < scene->n_detector; i++)
        rmap_bounds_include_detector(&box, &scene->detector[i]);
    *centre = rmap_vec3(0, 0, 0);
    if (!(box.lower.x <= box.upper.x) || box.infinite)
        return 1;
    *centre = rmap_scale(rmap_add(box.lower, box.upper), 0.5);
    const double radius = 1.001 * 0.5 * rmap_length(rmap_sub(box.upper, box.lower));
    return radius > 0 ? radius : 1;
}

/* The rectangle about something flat. */
static bool portal_of_object(const struct rmap_scene *scene, const struct rmap_object *object,
                             struct rmap_sky_portal *portal)
{
    struct rmap_vec3 lower, upper;
    rmap_geometry_bounds(&scene->geometry[object->geometry], &lower, &upper);
    const struct rmap_vec3 whole = rmap_sub(upper, lower);
    const double wide[3] = {whole.x, whole.y, whole.z};
    int flat = 0, n = 0;
    for (int k = 1; k < 3; k++)
        flat = wide[k] < wide[flat] ? k : flat;
    for (int k = 0; k < 3; k++)
        if (k != flat)
            portal->side[n++] = rmap_affine_vector(
                &object->to_world,
                rmap_vec3(k == 0 ? wide[0] : 0.0, k == 1 ? wide[1] : 0.0, k == 2 ? wide[2] : 0.0));
    portal->centre = rmap_affine_point(&object->to_world, rmap_scale(rmap_add(lower, upper), 0.5));
    return wide[flat] <= 1e-5 * rmap_max(wide[(flat + 1) % 3], wide[(flat + 2) % 3]);
}

static bool portal_of(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                      struct rmap_sky_portal *portal)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_name *name = at->text ? rmap_names_find(&reader->members, at->text) : NULL;
    bool flat = false;
    if (!name) {
        (void)rmap_reader_find(reader, &reader->members, "object or detector", at,
                               at->text ? at->text : "");
        return false;
    }
    if (name->kind == RMAP_MEMBER_OBJECT) {
        flat = portal_of_object(scene, &scene->object[name->index], portal);
    } else if (name->kind == RMAP_MEMBER_DETECTOR &&
               scene->detector[name->index].type == RMAP_DETECTOR_PLANE) {
        const struct rmap_detector *detector = &scene->detector[name->index];
        *portal = (struct rmap_sky_portal){detector->origin,
                                           {rmap_scale(detector->x, detector->size[0]),
                                            rmap_scale(detector->y, detector->size[1])}};
        flat = true;
    }
    if (!flat)
        rmap_reader_error(reader, at,
                          "'%.60s' is not flat: light is sampled through rectangles, discs, flat "
                          "meshes and plane detectors; lay a detector over the opening",
                          at->text);
    return flat;
}

static void read_portals(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_sky *sky)
{
    const struct rmap_yaml_node *toward = rmap_yaml_get(node, "toward");
    if (!toward)
        return;
    const bool one = toward->kind == RMAP_YAML_SCALAR;
    const size_t n = one ? 1 : toward->n_item;
    if (toward->kind == RMAP_YAML_MAP || n == 0) {
        rmap_reader_error(reader, toward, "'toward' must be a list of names, as in [window]");
        return;
    }
    sky->portal = rmap_alloc(n, sizeof *sky->portal);
    if (!sky->portal) {
        rmap_reader_no_memory(reader);
        return;
    }
    sky->n_portal = n;
    for (size_t i = 0; i < n; i++)
        (void)portal_of(reader, one ? toward : toward->item[i].value, &sky->portal[i]);
}

/* Radiances and flux in the unit of the scene's sources. source->flux: one unit of what was said,
 * in that. */
static void settle(struct rmap_reader *reader, const struct rmap_sky_plan *plan,
                   struct rmap_source *source)
{
    struct rmap_sky *sky = source->sky;
    const double unit_m2 = reader->scene->unit_m * reader->scene->unit_m,
                 facing = rmap_sky_irradiance(sky);
    if (sky->band && !rmap_reader_colour_environment(reader, plan, source))
        return;
    double flux = rmap_sky_gather(source) * unit_m2,
           scale = plan->amount * (sky->band ? 1.0 : source->flux);
    if (plan->measure == RMAP_SKY_IRRADIANCE)
        scale /= facing;
    if (plan->measure == RMAP_SKY_FLUX)
        scale /= flux;
    if (!(flux > 0) || !isfinite(scale)) {
        rmap_reader_error(reader, plan->node, "source '%.60s' sends no light into the scene",
                          source->name);
        return;
    }
    for (size_t i = 0; i < sky->n_row * sky->n_around; i++)
        sky->radiance[i] *= scale;
    (void)rmap_sky_gather(source); /* by what is kept in maps, to the same bits */
    source->flux = flux * scale;
    if (sky->band)
        rmap_environment_mean(source, reader->scene->channels.n);
}

void rmap_reader_aim_skies(struct rmap_reader *reader)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_vec3 centre;
    if (reader->n_sky == 0 || reader->diagnostics->n_error > 0)
        return;
    const double radius = enclose(scene, &centre);
    for (size_t i = 0; i < reader->n_sky; i++) {
        struct rmap_source *source = &scene->source[reader->sky[i].source];
        const size_t before = reader->diagnostics->n_error;
        source->frame = rmap_placement_rigid(&source->frame);
        source->frame.t = centre;
        source->shape_size[0] = radius;
        source->shape_size[1] = 0;
        read_portals(reader, reader->sky[i].node, source->sky);
        if (reader->diagnostics->n_error == before && reader->status == RMAP_OK)
            settle(reader, &reader->sky[i], source);
    }
}
