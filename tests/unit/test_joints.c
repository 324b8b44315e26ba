/* SPDX-License-Identifier: MIT
 *
 * Closed bodies joined from analytic surfaces: light that is aimed at the rims that two of them
 * share, to within the rounding of its numbers, neither leaves nor enters unseen.
 */
#include <math.h>

#include "build_scene.h"
#include "geometry/sag.h"

enum { AIR = 0, GLASS = 1, PARTS_MAX = 6, RIMS_MAX = 12 };

/* Part of a body: a shape along +z or -z of the body's frame, or turned. */
struct part {
    struct rmap_shape shape;
    struct rmap_vec3 at, angles;
    bool inward; /* its normal leads into the body */
};

/* A rim: circle about z, or from `at` to `to`; or along the outline of a part, a SAG. */
struct rim {
    double radius;
    struct rmap_vec3 at, to;
    int curve; /* number of the part, from 1 */
};

struct body {
    const char *name;
    struct part part[PARTS_MAX];
    struct rim rim[RIMS_MAX];
    struct rmap_vec3 inside;
};

#define CONIC(radius_, aperture_, conic_)                                                          \
    {                                                                                              \
        .type = RMAP_SHAPE_CONIC, .curvature = 1 / (radius_), .aperture = (aperture_),             \
        .conic = (conic_)                                                                          \
    }
#define DISC(inner_, aperture_)                                                                    \
    {                                                                                              \
        .type = RMAP_SHAPE_DISC, .inner = (inner_), .aperture = (aperture_)                        \
    }
#define TUBE(radius_, radius2_, length_)                                                           \
    {                                                                                              \
        .type = RMAP_SHAPE_TUBE, .radius = (radius_), .radius2 = (radius2_), .length = (length_)   \
    }
#define RECTANGLE(x_, y_)                                                                          \
    {                                                                                              \
        .type = RMAP_SHAPE_RECTANGLE, .size = {(x_), (y_) }                                        \
    }

/* Lenses whose edges end on curved rims: a bottom, a wall, a top that stands `length` above. */
static struct lens {
    struct rmap_sag bottom, top;
    struct rmap_aperture outline;
    double length;
} LENSES[] = {
    {.bottom = {.base = RMAP_SAG_TOROID, .curvature = {0.4, 0.15}, .conic = {0, -1}},
     .outline = {.half = {1, 1}},
     .length = 0.9},
    {.bottom = {.base = RMAP_SAG_BICONIC, .curvature = {0.3, 0.1}, .conic = {0, 0.5}},
     .top = {.curvature = {-0.2, -0.2}, .power = {0, 0, -0.02}, .n_power = 3},
     .outline = {.rectangle = true, .half = {1.1, 0.8}},
     .length = 1.2},
    {.bottom = {.curvature = {0.3, 0.3},
                .zernike_norm = 1.5,
                .zernike = {[4] = 0.03, [5] = 0.02, [8] = 0.01},
                .n_zernike = 4},
     .top = {.xy_norm = 1, .xy = {[3] = -0.1, [4] = 0.03, [5] = -0.2, [7] = 0.01}, .n_xy = 4},
     .outline = {.half = {1.2, 0.7}, .at = {0.2, -0.1}},
     .length = 1},
};
enum { N_LENS = sizeof LENSES / sizeof LENSES[0] };

static struct body BODIES[] = {
    {.name = "toroid and plane"},
    {.name = "rectangular biconic"},
    {.name = "elliptic, out of its axis"},
    {.name = "sphere of two halves",
     .part = {{CONIC(1.3, 1.3, 0), {0, 0, -1.3}, {0, 0, 0}, true},
              {CONIC(1.3, 1.3, 0), {0, 0, 1.3}, {180, 0, 0}, true}},
     .rim = {{.radius = 1.3}}},
    {.name = "prolate and oblate half",
     .part = {{CONIC(0.7, 1.4, -0.75), {0, 0, -2.8}, {0, 0, 0}, true},
              {CONIC(1.75, 1.4, 0.5625), {0, 0, 1.12}, {180, 0, 0}, true}},
     .rim = {{.radius = 1.4}}},
    {.name = "dome on a disc",
     .part = {{CONIC(-0.9, 0.9, 0), {0, 0, 0.9}, {0, 0, 0}, false},
              {DISC(0, 0.9), {0, 0, 0}, {0, 0, 0}, true}},
     .rim = {{.radius = 0.9}},
     .inside = {0, 0, 0.3}},
    {.name = "can",
     .part = {{TUBE(0.7, 0.7, 1.1), {0, 0, 0}, {0, 0, 0}, false},
              {DISC(0, 0.7), {0, 0, 0}, {0, 0, 0}, true},
              {DISC(0, 0.7), {0, 0, 1.1}, {0, 0, 0}, false}},
     .rim = {{.radius = 0.7}, {.radius = 0.7, .at = {0, 0, 1.1}}},
     .inside = {0, 0, 0.5}},
    {.name = "cone, frustum and disc",
     .part = {{TUBE(0.9, 0, 1.3), {0, 0, 0.4}, {0, 0, 0}, false},
              {TUBE(0.5, 0.9, 0.4), {0, 0, 0}, {0, 0, 0}, false},
              {DISC(0, 0.5), {0, 0, 0}, {0, 0, 0}, true}},
     .rim = {{.radius = 0.9, .at = {0, 0, 0.4}}, {.radius = 0.5}},
     .inside = {0, 0, 0.45}},
    {.name = "ring",
     .part = {{TUBE(1.2, 1.2, 0.6), {0, 0, 0}, {0, 0, 0}, false},
              {TUBE(0.4, 0.4, 0.6), {0, 0, 0}, {0, 0, 0}, true},
              {DISC(0.4, 1.2), {0, 0, 0}, {0, 0, 0}, true},
              {DISC(0.4, 1.2), {0, 0, 0.6}, {0, 0, 0}, false}},
     .rim = {{.radius = 1.2},
             {.radius = 1.2, .at = {0, 0, 0.6}},
             {.radius = 0.4},
             {.radius = 0.4, .at = {0, 0, 0.6}}},
     .inside = {0.8, 0, 0.3}},
    {.name = "lens with a sharp edge",
     .part = {{CONIC(4.4, 1.2, 0), {0, 0, 0}, {0, 0, 0}, true},
              {CONIC(-2.0, 1.2, 0), {0, 0, 0.5667979022966549}, {0, 0, 0}, false}},
     .rim = {{.radius = 1.2, .at = {0, 0, 0.16679790229665503}}},
     .inside = {0, 0, 0.3}},
    {.name = "aspheric lens with a cylindrical edge",
     .part = {{{.type = RMAP_SHAPE_CONIC,
                .curvature = 0.2,
                .conic = -1,
                .aperture = 1,
                .asphere = {0, 0.01},
                .n_asphere = 2},
               {0, 0, 0},
               {0, 0, 0},
               true},
              {CONIC(-2.5, 1, -1), {0, 0, 1.31}, {0, 0, 0}, false},
              {TUBE(1, 1, 1), {0, 0, 0.11}, {0, 0, 0}, false}},
     .rim = {{.radius = 1, .at = {0, 0, 0.11}}, {.radius = 1, .at = {0, 0, 1.11}}},
     .inside = {0, 0, 0.5}},
    {.name = "box",
     .part = {{RECTANGLE(2.0, 1.2), {0, 0, 0.4}, {0, 0, 0}, false},
              {RECTANGLE(2.0, 1.2), {0, 0, -0.4}, {0, 0, 0}, true},
              {RECTANGLE(0.8, 1.2), {1, 0, 0}, {0, 90, 0}, false},
              {RECTANGLE(0.8, 1.2), {-1, 0, 0}, {0, 90, 0}, true},
              {RECTANGLE(2.0, 0.8), {0, 0.6, 0}, {-90, 0, 0}, false},
              {RECTANGLE(2.0, 0.8), {0, -0.6, 0}, {-90, 0, 0}, true}},
     .rim = {{.at = {-1, 0.6, 0.4}, .to = {1, 0.6, 0.4}},
             {.at = {-1, -0.6, 0.4}, .to = {1, -0.6, 0.4}},
             {.at = {-1, 0.6, -0.4}, .to = {1, 0.6, -0.4}},
             {.at = {-1, -0.6, -0.4}, .to = {1, -0.6, -0.4}},
             {.at = {1, -0.6, 0.4}, .to = {1, 0.6, 0.4}},
             {.at = {-1, -0.6, 0.4}, .to = {-1, 0.6, 0.4}},
             {.at = {1, -0.6, -0.4}, .to = {1, 0.6, -0.4}},
             {.at = {-1, -0.6, -0.4}, .to = {-1, 0.6, -0.4}},
             {.at = {1, 0.6, -0.4}, .to = {1, 0.6, 0.4}},
             {.at = {-1, 0.6, -0.4}, .to = {-1, 0.6, 0.4}},
             {.at = {1, -0.6, -0.4}, .to = {1, -0.6, 0.4}},
             {.at = {-1, -0.6, -0.4}, .to = {-1, -0.6, 0.4}}}},
};

static int make_lenses(void **state)
{
    (void)state;
    for (int k = 0; k < N_LENS; k++) {
        struct lens *lens = &LENSES[k];
        struct part *part = BODIES[k].part;
        for (int side = 0; side < (lens->outline.rectangle ? 4 : 1); side++)
            assert_null(rmap_shape_of_wall(&part[2 + side].shape, &lens->bottom, &lens->top,
                                           lens->length, &lens->outline, side));
        assert_null(rmap_shape_of_sag(&part[0].shape, &lens->bottom, &lens->outline));
        assert_null(rmap_shape_of_sag(&part[1].shape, &lens->top, &lens->outline));
        part[0].inward = true;
        part[1].at = BODIES[k].rim[1].at = rmap_vec3(0, 0, lens->length);
        BODIES[k].rim[0].curve = 1;
        BODIES[k].rim[1].curve = 2;
        BODIES[k].inside = rmap_vec3(lens->outline.at[0], lens->outline.at[1], 0.5 * lens->length);
    }
    return 0;
}

static int count_rims(const struct body *body)
{
    int n = 0;
    while (n < RIMS_MAX && (body->rim[n].curve || body->rim[n].radius > 0 ||
                            rmap_length(rmap_sub(body->rim[n].to, body->rim[n].at)) > 0))
        n++;
    return n;
}

static void open_body(struct builder *b, const struct body *body, struct rmap_affine place)
{
    builder_open(b, PARTS_MAX);
    for (int k = 0; k < PARTS_MAX; k++) {
        const struct part *part = &body->part[k];
        const struct rmap_shape *shape = &part->shape;
        if (!(shape->aperture > 0 || shape->radius > 0 || shape->size[0] > 0))
            break;
        struct rmap_affine local =
            rmap_affine_placement(rmap_vec3(1, 1, 1), part->angles, part->at);
        builder_object(b, builder_shape(b, *shape), rmap_affine_compose(&place, &local),
                       part->inward ? GLASS : AIR, part->inward ? AIR : GLASS);
    }
    builder_close(b);
}

/* Number k of a run, in [0, 1). */
static double draw(uint64_t ray, uint64_t k)
{
    double u[4];
    rmap_rng(11, ray, (uint32_t)k, RMAP_RNG_EMIT_POINT, u);
    return u[0];
}

/* On a rim, up to 1e-7 off; each second time no more than rounding, and some right on it. */
static struct rmap_vec3 near_rim(const struct body *body, uint64_t ray, uint64_t k)
{
    int n = count_rims(body);
    const struct rim *rim = &body->rim[(int)(draw(ray, k) * n)];
    double off = ray % 8 == 0 ? 0 : ray % 2 ? 1e-7 : 1e-15, angle = 2 * RMAP_PI * draw(ray, k + 1);
    if (ray % 16 == 0)
        angle = 0.25 * RMAP_PI * floor(8 * draw(ray, k + 1));
    struct rmap_vec3 p =
        rim->radius > 0
            ? rmap_add(rim->at, rmap_vec3(rim->radius * cos(angle), rim->radius * sin(angle), 0))
            : rmap_axpy(angle / (2 * RMAP_PI), rmap_sub(rim->to, rim->at), rim->at);
    if (rim->curve) {
        const struct rmap_shape *shape = &body->part[rim->curve - 1].shape;
        p = rmap_aperture_chart(&shape->outline, angle / (2 * RMAP_PI), 0);
        p.z = rim->at.z + rmap_shape_height(shape, p.x, p.y);
    }
    return rmap_axpy(
        off, rmap_vec3(draw(ray, k + 2) - 0.5, draw(ray, k + 3) - 0.5, draw(ray, k + 4) - 0.5), p);
}

/* Well inside; each fourth time the middle itself. */
static struct rmap_vec3 inside(const struct body *body, uint64_t ray, uint64_t k)
{
    double size = ray % 4 == 0 ? 0 : 0.3;
    return rmap_axpy(size,
                     rmap_vec3(draw(ray, k) - 0.5, draw(ray, k + 1) - 0.5, draw(ray, k + 2) - 0.5),
                     body->inside);
}

/* The ring is not convex: its middle is where the rim is. */
static struct rmap_vec3 from_inside(const struct body *body, uint64_t ray, struct rmap_vec3 aim)
{
    struct rmap_vec3 p = inside(body, ray, 10);
    double r = hypot(p.x, p.y),
           angle = atan2(aim.y, aim.x) + (ray % 4 ? 0.2 * (draw(ray, 13) - 0.5) : 0);
    if (body->inside.x > 0)
        p = rmap_vec3(r * cos(angle), r * sin(angle), p.z);
    return p;
}

static bool step(const struct builder *b, struct rmap_ray *ray, struct rmap_hit *hit, int32_t *near,
                 int32_t *far)
{
    if (!rmap_accel_next(b->accel, ray, hit))
        return false;
    const struct rmap_object *o = &b->scene->object[hit->object];
    bool front = rmap_dot(hit->normal, ray->direction) < 0;
    *near = front ? o->medium_front : o->medium_back;
    *far = front ? o->medium_back : o->medium_front;
    ray->origin = hit->position;
    return true;
}

/* Straight on: out of the body once, and from outside through it: always from the medium that it is
 * in. */
static int lost_straight(const struct builder *b, struct rmap_ray ray, int32_t medium, bool once)
{
    struct rmap_hit hit;
    int32_t near, far;
    int n = 0;
    ray.medium = medium;
    while (n < 20 && step(b, &ray, &hit, &near, &far)) {
        if (near != ray.medium)
            return 1;
        rmap_contact_pass(&ray.contact, &hit);
        ray.medium = far;
        n++;
    }
    return ray.medium != AIR || n == 20 || (once && n != 1);
}

static struct rmap_ray to_world(const struct rmap_affine *place, struct rmap_vec3 from,
                                struct rmap_vec3 to)
{
    struct rmap_ray ray = {.origin = rmap_affine_point(place, from)};
    ray.direction = rmap_normalize(rmap_sub(rmap_affine_point(place, to), ray.origin));
    return ray;
}

/* Mirrored at every wall, 12 times; the first segment is aimed at a rim, where others follow at
 * once.
 */
static int lost_mirrored(const struct builder *b, struct rmap_ray ray)
{
    struct rmap_hit hit;
    int32_t near, far;
    ray.medium = GLASS;
    for (int i = 0; i < 12; i++) {
        if (!step(b, &ray, &hit, &near, &far) || near != GLASS)
            return 1;
        rmap_contact_turn(&ray.contact, &hit);
        ray.direction = rmap_normalize(
            rmap_axpy(-2 * rmap_dot(ray.direction, hit.normal), hit.normal, ray.direction));
    }
    return 0;
}

/* The same with light that is scattered, to another rim each second time. */
static int lost_scattered(const struct builder *b, const struct body *body,
                          const struct rmap_affine *place, struct rmap_ray ray, uint64_t number)
{
    struct rmap_hit hit;
    int32_t near, far;
    ray.medium = GLASS;
    for (uint64_t i = 0; i < 12; i++) {
        if (!step(b, &ray, &hit, &near, &far) || near != GLASS)
            return 1;
        rmap_contact_turn(&ray.contact, &hit);
        struct rmap_vec3 n =
            rmap_dot(ray.direction, hit.normal) < 0 ? hit.normal : rmap_scale(hit.normal, -1);
        struct rmap_vec3 d =
            rmap_sub(rmap_affine_point(place, near_rim(body, number, 20 + 10 * i)), hit.position);
        double z = 2 * draw(number, 25 + 10 * i) - 1,
               angle = 2 * RMAP_PI * draw(number, 26 + 10 * i);
        if (i % 2 == 0 || hit.t < 1e-3 || rmap_length(d) < 1e-3 ||
            rmap_dot(d, n) < 1e-3 * rmap_length(d))
            d = rmap_axpy(1.001, n,
                          rmap_vec3(sqrt(1 - z * z) * cos(angle), sqrt(1 - z * z) * sin(angle), z));
        ray.direction = rmap_normalize(d);
    }
    return 0;
}

enum { RAYS = 4000 };

static void test_no_light_is_lost_at_joints(void **state)
{
    (void)state;
    const struct rmap_affine places[] = {
        rmap_affine_identity(),
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(11, 23, 47), rmap_vec3(7, -5, 2)),
        rmap_affine_placement(rmap_vec3(40, 40, 40), rmap_vec3(-70, 5, 130),
                              rmap_vec3(1e3, 2e3, -1e3)),
        rmap_affine_placement(rmap_vec3(0.2, 1.7, -0.9), rmap_vec3(1, 2, 3), rmap_vec3(9, 8, 7))};
    int worst = 0;
    for (size_t k = 0; k < sizeof(BODIES) / sizeof(BODIES[0]); k++)
        for (size_t m = 0; m < sizeof(places) / sizeof(places[0]); m++) {
            const struct body *body = &BODIES[k];
            struct builder b;
            int lost[4] = {0};
            open_body(&b, body, places[m]);
            for (uint64_t i = 0; i < RAYS; i++) {
                struct rmap_vec3 aim = near_rim(body, i, 0), from = from_inside(body, i, aim);
                struct rmap_ray ray = to_world(&places[m], from, aim);
                lost[0] += lost_straight(&b, ray, GLASS, true);
                lost[1] += lost_mirrored(&b, ray);
                lost[2] += lost_scattered(&b, body, &places[m], ray, i);
                from = rmap_axpy(-4, rmap_sub(aim, from), from);
                lost[3] += lost_straight(&b, to_world(&places[m], from, aim), AIR, false);
            }
            if (lost[0] + lost[1] + lost[2] + lost[3] > 0)
                print_message(
                    "%s, place %zu: of %d: straight %d, mirrored %d, scattered %d, through %d\n",
                    body->name, m, (int)RAYS, lost[0], lost[1], lost[2], lost[3]);
            worst += lost[0] + lost[1] + lost[2] + lost[3];
            builder_destroy(&b);
        }
    assert_int_equal(worst, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_light_is_lost_at_joints),
    };
    return cmocka_run_group_tests(tests, make_lenses, NULL);
}
