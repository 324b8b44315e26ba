/* SPDX-License-Identifier: MIT
 *
 * A scene that lives: edited in random order, its structure follows by rmap_accel_move and
 * rmap_accel_create_like, and after every step its rays are those of the text read anew; as are
 * those of the step before, where they are taken over and traced along what is known of them.
 *
 *     test_scene_steps [STEPS [SEED]]
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "accel/accel.h"
#include "base/count.h"
#include "portion/portion_recorder.h"
#include "scene/scene_edit.h"
#include "tests/unit/read_text.h"
#include "trace/touched.h"

enum { N_THING = 14, N_RAY = 300, N_GROUP = 2, TEXT_NBYTES = 16384 };

static int n_step = 500;
static uint64_t random_state = 1;

static unsigned draw(unsigned below)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (unsigned)((random_state >> 33) % below);
}

struct stand {
    double at[3], rotate[3], scale;
};

struct thing {
    bool there;
    int group, geometry, surface; /* group: -1 none */
    struct stand stand;
};

struct model {
    struct thing thing[N_THING];
    struct stand group[N_GROUP];
    int glass, white, box, share, source, detector;
};

static const char *const geometry_name[] = {"ball", "brick", "wedge", "rod", "lens", "plate"};
static const char *const surface_name[] = {"clear", "white", "mirror"};

/* On a coarse grid, so that bodies touch, and rims coincide. */
static struct stand random_stand(void)
{
    struct stand stand = {.scale = draw(3) ? 1 : 0.5 * (1 + draw(3))};
    for (int k = 0; k < 3; k++) {
        stand.at[k] = 4.0 * draw(6) - 10 + (draw(4) ? 0 : 0.37);
        stand.rotate[k] = draw(3) ? 0 : draw(2) ? 90 : 17.0 * draw(20);
    }
    return stand;
}

static struct thing random_thing(void)
{
    return (struct thing){.there = true,
                          .group = (int)draw(N_GROUP + 1) - 1,
                          .geometry = (int)draw((unsigned)RMAP_COUNT(geometry_name)),
                          .surface = (int)draw((unsigned)RMAP_COUNT(surface_name)),
                          .stand = random_stand()};
}

static void put_stand(FILE *out, const struct stand *stand)
{
    fprintf(out, "at: [%.17g, %.17g, %.17g], rotate: [%.17g, %.17g, %.17g], scale: %.17g",
            stand->at[0], stand->at[1], stand->at[2], stand->rotate[0], stand->rotate[1],
            stand->rotate[2], stand->scale);
}

static void put_things(FILE *out, const struct model *model, int group)
{
    bool any = false;
    for (int i = 0; i < N_THING; i++) {
        const struct thing *thing = &model->thing[i];
        if (!thing->there || thing->group != group)
            continue;
        const bool lens = thing->geometry == 4, sheet = thing->geometry == 5;
        fprintf(out, "%s  {name: t%d, geometry: %s, ", any ? ",\n" : "", i,
                geometry_name[thing->geometry]);
        put_stand(out, &thing->stand);
        if (!lens)
            fprintf(out, ", surface: %s", surface_name[sheet ? 1 : thing->surface]);
        fprintf(out, "%s}",
                lens    ? ", outside: air"
                : sheet ? ", front: air, back: air"
                        : ", outside: air, inside: glass");
        any = true;
    }
    if (any && group < 0)
        fprintf(out, ",\n");
}

static char *text_of(const struct model *model)
{
    char *text = malloc(TEXT_NBYTES);
    assert_non_null(text);
    FILE *out = fmemopen(text, TEXT_NBYTES, "w");
    fprintf(out,
            "raymap: 1\nmedia: {air: {index: 1}, glass: {index: %g}}\nsurfaces: {clear: {type: "
            "fresnel}, white: {type: lambert, reflectance: %g}, mirror: {type: mirror, "
            "reflectance: 0.9}}\ngeometries:\n"
            "  ball: {type: sphere, radius: 2}\n  brick: {type: box, size: [4, 4, %d]}\n"
            "  wedge: {type: prism, points: [[0, 0], [4, 0], [0, 4]], length: 4}\n"
            "  rod: {type: cylinder, radius: 2, length: 4}\n"
            "  lens: {type: lens, surface: clear, edge: white, surfaces: [{radius: 8, thickness: "
            "2, medium: glass, aperture: 2}, {radius: -8, medium: air, aperture: 2}]}\n"
            "  plate: {type: rectangle, size: [4, 4]}\nobjects: [\n",
            1.4 + 0.1 * model->glass, 0.5 + 0.1 * model->white, 2 + 2 * model->box);
    put_things(out, model, -1);
    for (int g = 0; g < N_GROUP; g++) {
        fprintf(out, " {name: g%d, ", g);
        put_stand(out, &model->group[g]);
        fprintf(out, ", objects: [\n");
        put_things(out, model, g);
        fprintf(out, "]}%s\n", g + 1 < N_GROUP ? "," : "");
    }
    fprintf(out,
            "]\nsources:\n - {name: a, type: point, at: [0.3, %d.1, 0.2], medium: air, rays_share: "
            "%d}\n - {name: b, type: collimated, shape: {disc: 9}, at: [0, 0, -30], medium: air}\n"
            "detectors:\n - {name: d, type: plane, at: [0, 0, %d], size: 40, cells: 8}\n",
            model->source, 1 + model->share, 20 + model->detector);
    assert_true(ftell(out) < TEXT_NBYTES - 1);
    (void)fclose(out);
    return text;
}

struct live {
    struct rmap_scene *scene;
    struct rmap_accel *accel;
};

static struct rmap_scene *read_model(const struct model *model)
{
    char *text = text_of(model), *told = NULL;
    struct rmap_scene *scene = read_text(text, &told);
    if (!scene)
        printf("%s\n%s\n", text, told);
    assert_non_null(scene);
    free(text);
    free(told);
    return scene;
}

/* The rays of a scene, of which those before a change are known (NULL: none are). */
struct taking {
    const struct rmap_touch *touch;
    const struct rmap_portion *rows;
    uint8_t touched[N_RAY];
    size_t at[RMAP_TABLE_COUNT];
};

static size_t n_taken, n_traced, n_known; /* n_traced, n_known: segments */

/* A ray from the rows of before, or traced along them. */
static void take(struct taking *taking, const struct rmap_tracer *tracer, uint64_t ray,
                 struct rmap_portion_recorder *recorder)
{
    struct rmap_error err = {0};
    struct rmap_portion *to = recorder->portion;
    const struct rmap_ray_columns *its = &taking->rows->ray;
    const size_t n[RMAP_TABLE_COUNT] = {1, its->segment_count[ray], its->registration_count[ray]};
    size_t before[RMAP_TABLE_COUNT];
    if (taking->touched[ray] || draw(2)) {
        const struct rmap_known_way way = rmap_touch_known(taking->touch, taking->rows, taking->at);
        const size_t first = to->n_row[RMAP_TABLE_SEGMENT];
        rmap_trace_known(tracer, ray, &way, &recorder->base);
        for (size_t k = 0; k < way.n; k++)
            n_known += way.object[k] >= 0;
        n_traced += to->n_row[RMAP_TABLE_SEGMENT] - first;
    } else {
        memcpy(before, to->n_row, sizeof before);
        assert_int_equal(rmap_portion_append_rows(to, taking->rows, taking->at, n, &err), RMAP_OK);
        rmap_touch_renumber(taking->touch, to, before);
        n_taken++;
    }
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        taking->at[t] += n[t];
}

static struct rmap_portion *trace_along(const struct live *live, struct taking *taking)
{
    struct rmap_error err = {0};
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    assert_int_equal(rmap_portion_create(N_RAY, live->scene->channels.n, &portion, &err), RMAP_OK);
    const struct rmap_tracer tracer = {live->scene, live->accel, 5};
    rmap_portion_recorder_init(&recorder, portion);
    for (uint64_t ray = 0; ray < N_RAY; ray++)
        if (taking)
            take(taking, &tracer, ray, &recorder);
        else
            rmap_trace_ray(&tracer, ray, &recorder.base);
    assert_int_equal(recorder.status, RMAP_OK);
    return portion;
}

static struct rmap_digest trace(const struct live *live)
{
    struct rmap_portion *portion = trace_along(live, NULL);
    struct rmap_digest digest = rmap_portion_digest(portion);
    rmap_portion_destroy(portion);
    return digest;
}

static void close_live(struct live *live)
{
    rmap_accel_destroy(live->accel);
    rmap_scene_destroy(live->scene);
}

static void count_search(void *context, const struct rmap_ray *ray, double length)
{
    (void)ray;
    (void)length;
    ++*(size_t *)context;
}

static size_t n_search;

/* The rays of the scene before a step, as far as they can be used, are those of the one after it.
 */
static void assert_taken_over(const struct live *old, const struct live *live,
                              const struct rmap_digest *wanted)
{
    struct rmap_error err = {0};
    struct rmap_touch touch;
    assert_int_equal(rmap_touch_init(&touch, old->scene, live->scene, &err), RMAP_OK);
    if (!touch.change.all[0]) {
        struct rmap_portion *rows = trace_along(old, NULL);
        struct taking taking = {.touch = &touch, .rows = rows};
        rmap_touch_paths(&touch, rows, taking.touched);
        (void)rmap_touch_places(&touch, rows, taking.touched);
        rmap_accel_watch(live->accel, count_search, &n_search);
        struct rmap_portion *portion = trace_along(live, &taking);
        rmap_accel_watch(live->accel, NULL, NULL);
        const struct rmap_digest digest = rmap_portion_digest(portion);
        assert_memory_equal(&digest, wanted, sizeof digest);
        rmap_portion_destroy(portion);
        rmap_portion_destroy(rows);
    }
    rmap_touch_fini(&touch);
}

static size_t n_moved, n_reread, n_kept;

/* The text is read again, and the structure takes over what it can. */
static void reread(struct live *live, const struct model *model)
{
    struct rmap_error err = {0};
    struct live next = {.scene = read_model(model)};
    assert_int_equal(rmap_accel_create_like(live->accel, next.scene, &next.accel, &err), RMAP_OK);
    n_kept += rmap_accel_last_build(next.accel)->n_kept;
    n_reread++;
    if (draw(2)) { /* either goes first */
        rmap_scene_destroy(live->scene);
        live->scene = NULL;
    }
    close_live(live);
    *live = next;
}

static void move(struct live *live, const struct model *model, const char *name,
                 const struct stand *to)
{
    struct rmap_error err = {0};
    struct rmap_scene_part part;
    const struct rmap_affine placement =
        rmap_affine_placement(rmap_vec3(to->scale, to->scale, to->scale),
                              rmap_vec3(to->rotate[0], to->rotate[1], to->rotate[2]),
                              rmap_vec3(to->at[0], to->at[1], to->at[2]));
    int32_t *object = NULL;
    size_t n_object = 0;
    if (!rmap_scene_part_find(live->scene, name, &part) ||
        !rmap_scene_part_is_movable(live->scene, part)) {
        reread(live, model);
        return;
    }
    assert_int_equal(rmap_scene_move(live->scene, part, &placement, &object, &n_object, &err),
                     RMAP_OK);
    assert_int_equal(rmap_accel_move(live->accel, object, n_object, &err), RMAP_OK);
    rmap_free(object);
    n_moved++;
}

static void step(struct live *live, struct model *model)
{
    char name[8];
    const int i = (int)draw(N_THING), g = (int)draw(N_GROUP);
    struct thing *thing = &model->thing[i];
    switch (draw(14)) {
    case 0:
        *thing = random_thing(); /* added, or replaced */
        break;
    case 1:
        thing->there = false;
        break;
    case 2:
        thing->surface = (int)draw((unsigned)RMAP_COUNT(surface_name));
        model->white = (int)draw(4);
        break;
    case 3:
        model->glass = (int)draw(4);
        break;
    case 4:
        model->box = (int)draw(3);
        break;
    case 5:
        model->share = (int)draw(3);
        model->source = (int)draw(5);
        break;
    case 6:
        model->detector = (int)draw(5);
        break;
    case 7:
        model->group[g] = random_stand();
        (void)snprintf(name, sizeof name, "g%d", g);
        move(live, model, name, &model->group[g]);
        return;
    default:
        if (!thing->there)
            break;
        thing->stand = random_stand();
        (void)snprintf(name, sizeof name, "t%d", i);
        move(live, model, name, &thing->stand);
        return;
    }
    reread(live, model);
}

/* *fresh_ret, *digest_ret: the scene read anew, and its rays. */
static void read_fresh(const struct live *live, const struct model *model, struct live *fresh_ret,
                       struct rmap_digest *digest_ret)
{
    struct rmap_error err = {0};
    struct live fresh = {.scene = read_model(model)};
    assert_int_equal(rmap_accel_create(fresh.scene, 1, &fresh.accel, &err), RMAP_OK);
    assert_int_equal(live->scene->n_object, fresh.scene->n_object);
    for (size_t i = 0; i < fresh.scene->n_object; i++) {
        const struct rmap_object *a = &live->scene->object[i], *b = &fresh.scene->object[i];
        assert_memory_equal(&a->to_world, &b->to_world, sizeof a->to_world);
        assert_memory_equal(&a->to_local, &b->to_local, sizeof a->to_local);
    }
    assert_memory_equal(&live->scene->centre, &fresh.scene->centre, sizeof fresh.scene->centre);
    assert_memory_equal(&live->scene->radius, &fresh.scene->radius, sizeof(double));
    const struct rmap_digest a = trace(live);
    *digest_ret = trace(&fresh);
    assert_memory_equal(&a, digest_ret, sizeof a);
    *fresh_ret = fresh;
}

static void assert_as_fresh(const struct live *live, const struct model *model)
{
    struct rmap_digest digest;
    struct live fresh;
    read_fresh(live, model, &fresh, &digest);
    close_live(&fresh);
}

static void test_edits_in_random_order(void **state)
{
    struct rmap_error err = {0};
    struct model model = {.glass = 1};
    (void)state;
    for (int i = 0; i < N_THING; i++)
        model.thing[i] = random_thing();
    for (int g = 0; g < N_GROUP; g++)
        model.group[g] = random_stand();
    struct live live = {.scene = read_model(&model)};
    assert_int_equal(rmap_accel_create(live.scene, 1, &live.accel, &err), RMAP_OK);
    struct live before, fresh;
    struct rmap_digest digest;
    read_fresh(&live, &model, &before, &digest);
    for (int i = 0; i < n_step; i++) {
        step(&live, &model);
        read_fresh(&live, &model, &fresh, &digest);
        assert_taken_over(&before, &fresh, &digest);
        close_live(&before);
        before = fresh;
    }
    close_live(&before);
    printf("%zu moved, %zu read again with %zu meshes taken over\n", n_moved, n_reread, n_kept);
    printf("%zu rays taken over; %zu segments traced, %zu of them known, with %zu searches\n",
           n_taken, n_traced, n_known, n_search);
    assert_true(n_moved > 0 && n_reread > 0 && n_kept > 0);
    assert_true(n_taken > 0 && n_search < n_traced - n_known / 2);
    close_live(&live);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Too far, and without an inverse: the scene is as it was. */
static void test_a_bad_place_changes_nothing(void **state)
{
    struct rmap_error err = {0};
    struct model model = {.glass = 1};
    (void)state;
    for (int i = 0; i < N_THING; i++)
        model.thing[i] = random_thing();
    for (int g = 0; g < N_GROUP; g++)
        model.group[g] = random_stand();
    struct live live = {.scene = read_model(&model)};
    assert_int_equal(rmap_accel_create(live.scene, 1, &live.accel, &err), RMAP_OK);
    struct rmap_scene_part part;
    int32_t *object = NULL;
    size_t n_object = 0;
    assert_true(rmap_scene_part_find(live.scene, "g1", &part));
    const double bad[] = {0, 1e30};
    for (size_t i = 0; i < RMAP_COUNT(bad); i++) {
        const struct rmap_affine placement = rmap_affine_placement(
            rmap_vec3(bad[i], bad[i], bad[i]), rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 0));
        assert_int_equal(rmap_scene_move(live.scene, part, &placement, &object, &n_object, &err),
                         RMAP_INPUT);
        assert_as_fresh(&live, &model);
    }
    assert_false(rmap_scene_part_find(live.scene, "nobody", &part));
    close_live(&live);
}

/* Of many instances a few stand beside the top level before it is built anew. */
static void test_many_instances(void **state)
{
    static const char text[] =
        "raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}}\nsurfaces: {clear: {type: "
        "fresnel}}\ngeometries:\n  brick: {type: box, size: [1, 1.5, 2]}\nobjects:\n"
        "  - {name: c, geometry: brick, surface: clear, outside: air, inside: glass, rotate: [9, "
        "0, "
        "5], copies: {count: [13, 13, 13], step: [3, 3, 3]}}\n"
        "sources:\n  - {name: a, type: point, at: [19.4, 19.3, 19.2], medium: air}\n";
    struct rmap_error err = {0};
    char *told = NULL;
    struct live live = {.scene = read_text(text, &told)};
    size_t n_top = 0;
    (void)state;
    assert_non_null(live.scene);
    free(told);
    assert_int_equal(rmap_accel_create(live.scene, 1, &live.accel, &err), RMAP_OK);
    for (int i = 0; i < 60; i++) {
        const int beside = 1098 + (int)draw(40) - 20; /* near the source */
        const struct rmap_scene_part part = {.object = draw(3) ? beside : (int)draw(2197),
                                             .group = -1};
        const double far = draw(12) ? 0 : 40;
        const struct rmap_affine placement = rmap_affine_placement(
            rmap_vec3(1, 1, 1), rmap_vec3(draw(90), draw(90), 0),
            rmap_vec3(16 + 0.1 * draw(70) + far, 16 + 0.1 * draw(70), 16 + 0.1 * draw(70)));
        int32_t *object = NULL;
        size_t n_object = 0;
        struct live fresh = {.scene = live.scene};
        assert_int_equal(rmap_scene_move(live.scene, part, &placement, &object, &n_object, &err),
                         RMAP_OK);
        assert_int_equal(rmap_accel_move(live.accel, object, n_object, &err), RMAP_OK);
        n_top += rmap_accel_last_build(live.accel)->n_beside == 0;
        rmap_free(object);
        assert_int_equal(rmap_accel_create(fresh.scene, 1, &fresh.accel, &err), RMAP_OK);
        const struct rmap_digest a = trace(&live), b = trace(&fresh);
        assert_memory_equal(&a, &b, sizeof a);
        rmap_accel_destroy(fresh.accel);
    }
    assert_true(n_top > 2 && n_top < 20);
    const struct rmap_digest before = trace(&live);
    assert_int_equal(rmap_accel_settle(live.accel, &err), RMAP_OK);
    assert_int_equal(rmap_accel_last_build(live.accel)->n_beside, 0);
    const struct rmap_digest after = trace(&live);
    assert_memory_equal(&before, &after, sizeof before);
    close_live(&live);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_edits_in_random_order),
                                       cmocka_unit_test(test_a_bad_place_changes_nothing),
                                       cmocka_unit_test(test_many_instances)};
    if (argc > 1)
        n_step = atoi(argv[1]);
    if (argc > 2)
        random_state = (uint64_t)atoll(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
