/* SPDX-License-Identifier: MIT
 *
 * Energy balance, exact in rays, and purity: a ray is a function of (scene, seed, ray id).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_bench.h"
#include "near.h"
#include "portion/portion_recorder.h"
#include "trace/tally.h"

/* Two coloured sources in a box of mixed walls around an absorbing glass ball. */
static struct rmap_scene *busy_scene(void)
{
    struct rmap_scene *scene = hand_scene(3);
    hand_medium(scene, 1.0);
    int32_t glass = hand_medium(scene, 1.5);
    for (int i = 0; i < 3; i++) {
        scene->medium[glass].n[i] = 1.6 - 0.03 * i;
        scene->medium[glass].absorption[i] = 0.01 + 0.02 * i;
    }
    scene->medium[glass].dispersive = scene->medium[glass].absorbing = true;
    int32_t wall = hand_surface(scene, RMAP_SURFACE_MIXTURE);
    hand_fill(scene, scene->surface[wall].reflect_diffuse, 0.6);
    scene->surface[wall].reflect_diffuse[1] = 0.4;
    hand_fill(scene, scene->surface[wall].reflect_specular, 0.1);
    int32_t clear = hand_surface(scene, RMAP_SURFACE_FRESNEL);
    int32_t face = hand_rectangle(scene, 20, 20);
    const struct rmap_vec3 turn[] = {{0, 0, 0}, {0, 90, 0}, {90, 0, 0}};
    for (int k = 0; k < 5; k++) { /* five walls; the sixth side is open */
        double d = k % 2 ? 10.0 : -10.0;
        struct rmap_vec3 at = k / 2 == 0   ? rmap_vec3(0, 0, d)
                              : k / 2 == 1 ? rmap_vec3(d, 0, 0)
                                           : rmap_vec3(0, d, 0);
        hand_object(scene, face, wall, rmap_affine_placement(rmap_vec3(1, 1, 1), turn[k / 2], at),
                    RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
    }
    int32_t ball = hand_shape(scene, (struct rmap_shape){.type = RMAP_SHAPE_SPHERE, .radius = 4.0});
    hand_object(scene, ball, clear, hand_shift(1, 2, 3), 0, glass);
    hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(-6, -6, -6), rmap_vec3(1, 1, 1));
    hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(6, -6, 6), rmap_vec3(0, 0, 1))->share = 2.5;
    hand_detector(scene, rmap_vec3(0, 0, -10), 1.0, 20.0)->on_object = 0;
    hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 20.0);
    scene->limit_steps = 8;
    return scene;
}

/* Emitted = absorbed by objects + in media + left + limits + errors, exactly, per source; images
 * count what the histories say; halves merge to the whole. */
static void energy_balance(void **state)
{
    (void)state;
    enum { N = 20000 };
    struct bench b = {.scene = busy_scene()};
    start(&b);
    struct rmap_tally *tally[2];
    double registered[2] = {0}, segments = 0.0;
    for (int half = 0; half < 2; half++) {
        struct rmap_tally_recorder recorder;
        assert_int_equal(rmap_tally_create(b.scene, &tally[half], NULL), RMAP_OK);
        rmap_tally_recorder_init(&recorder, tally[half], &b.history.base);
        for (uint64_t ray = (uint64_t)half; ray < N; ray += 2) {
            rmap_trace_ray(&b.tracer, ray, &recorder.base);
            segments += (double)b.history.n_step;
            for (size_t i = 0; i < b.history.n_registration; i++)
                registered[b.history.registration[i].detector] += 1.0;
        }
    }
    struct rmap_tally *t = tally[0];
    rmap_tally_merge(t, tally[1]);
    double emitted = 0.0, kinds[4] = {0};
    for (size_t s = 0; s < 2; s++) {
        double sum = t->left[s] + t->limit[s] + t->error[s];
        for (size_t o = 0; o < b.scene->n_object; o++)
            sum += t->absorbed_object[s * b.scene->n_object + o];
        for (size_t m = 0; m < b.scene->n_medium; m++)
            sum += t->absorbed_medium[s * b.scene->n_medium + m];
        assert_true(sum == t->emitted[s]);
        emitted += t->emitted[s];
        kinds[0] += t->left[s];
        kinds[1] += t->limit[s];
        kinds[2] += t->error[s];
        kinds[3] += t->absorbed_medium[s * b.scene->n_medium + 1];
        assert_true(t->absorbed_object[s * b.scene->n_object + 5] == 0.0);
        assert_true(t->absorbed_medium[s * b.scene->n_medium] == 0.0);
    }
    assert_true(emitted == N && kinds[2] == 0.0 && t->first_error_ray == UINT64_MAX);
    assert_true(kinds[0] > 0.0 && kinds[1] > 0.0 && kinds[3] > 0.0);
    assert_true(t->segments[0] == segments);
    for (size_t d = 0; d < 2; d++) {
        double sum = 0.0;
        for (size_t s = 0; s < 2; s++)
            for (int cell = 0; cell < 100; cell++)
                sum += rmap_tally_image(t, d, s)[cell];
        assert_true(sum == registered[d]);
    }
    rmap_tally_destroy(tally[0]);
    rmap_tally_destroy(tally[1]);
    stop(&b);
}

/* The columns of traced rays add up to what was summed while tracing. */
static void columns_add_up(void **state)
{
    (void)state;
    enum { N = 20000 };
    struct bench b = {.scene = busy_scene()};
    start(&b);
    struct rmap_tally *tally[2];
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    struct rmap_tally_recorder summing;
    for (int k = 0; k < 2; k++)
        assert_int_equal(rmap_tally_create(b.scene, &tally[k], NULL), RMAP_OK);
    assert_int_equal(rmap_portion_create(N, 3, &portion, NULL), RMAP_OK);
    rmap_portion_recorder_init(&recorder, portion);
    rmap_tally_recorder_init(&summing, tally[0], &recorder.base);
    for (uint64_t ray = 0; ray < N; ray++)
        rmap_trace_ray(&b.tracer, ray, &summing.base);
    assert_int_equal(recorder.status, RMAP_OK);
    assert_int_equal(rmap_tally_add_portion(tally[1], portion, NULL), RMAP_OK);
    assert_memory_equal(tally[1]->value, tally[0]->value,
                        tally[0]->n_value * sizeof *tally[0]->value);
    rmap_portion_destroy(portion);
    rmap_tally_destroy(tally[0]);
    rmap_tally_destroy(tally[1]);
    stop(&b);
}

static void assert_same_history(const struct rmap_history *a, const struct rmap_history *b)
{
    assert_int_equal(a->n_step, b->n_step);
    assert_int_equal(a->n_registration, b->n_registration);
    assert_true(a->ending.optical_path == b->ending.optical_path);
    assert_true(a->ending.stop == b->ending.stop);
    for (size_t i = 0; i < a->n_step; i++) {
        assert_true(a->step[i].events == b->step[i].events);
        assert_true(a->step[i].object == b->step[i].object);
        assert_true(a->step[i].position.x == b->step[i].position.x &&
                    a->step[i].position.y == b->step[i].position.y &&
                    a->step[i].position.z == b->step[i].position.z);
        for (int k = 0; k < a->n_channel; k++)
            assert_true(a->step[i].colour[k] == b->step[i].colour[k]);
    }
}

/* A ray is a function of its id: backwards, and by another structure built anew, it is the same;
 * every colour is normalised. */
static void purity(void **state)
{
    (void)state;
    enum { N = 200 };
    struct bench a = {.scene = busy_scene()}, b = {.scene = busy_scene()};
    start(&a);
    start(&b);
    struct rmap_history *first = rmap_alloc(N, sizeof *first);
    for (uint64_t ray = 0; ray < N; ray++) {
        rmap_history_init(&first[ray], 3);
        rmap_trace_ray(&a.tracer, ray, &first[ray].base);
    }
    for (uint64_t ray = N; ray-- > 0;) {
        assert_same_history(trace(&a, ray), &first[ray]);
        assert_same_history(trace(&b, ray), &first[ray]);
        for (size_t i = 0; i < first[ray].n_step; i++) {
            const double *c = first[ray].step[i].colour;
            assert_near(c[0] + c[1] + c[2], 1.0, 1e-14);
        }
        rmap_history_fini(&first[ray]);
    }
    rmap_free(first);
    b.tracer.seed++;
    double same = 0.0;
    for (uint64_t ray = 0; ray < N; ray++)
        same += trace(&a, ray)->ending.path_length == trace(&b, ray)->ending.path_length;
    assert_true(same < 5.0);
    stop(&a);
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(energy_balance),
        cmocka_unit_test(columns_add_up),
        cmocka_unit_test(purity),
    };
    return cmocka_run_group_tests_name("tracer_balance", test, NULL, NULL);
}
