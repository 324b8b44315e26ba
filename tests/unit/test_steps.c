/* SPDX-License-Identifier: MIT
 *
 * Light of charged particles: how much of it, where, in which directions, of which colours, when;
 * each against its formula.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/count.h"
#include "hand_scene.h"
#include "near.h"
#include "optics/cherenkov.h"
#include "optics/photon_number.h"
#include "scene/steps.h"
#include "trace/source.h"

#define N 200000

/* n = 1.33, 300 to 600 nm in bands of 10 nm, one muon of 1 cm along z, 2 MeV in it. */
static struct rmap_scene *water(void)
{
    struct rmap_scene *scene = hand_scene(30);
    for (int i = 0; i < 30; i++)
        scene->channels.wavelength_nm[i] = 305.0 + 10.0 * i;
    hand_medium(scene, 1.33);
    struct rmap_source *source =
        hand_source(scene, RMAP_SOURCE_STEPS, rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 1));
    source->distribution = RMAP_DISTRIBUTION_STEPS;
    assert_int_equal(rmap_steps_create(1, &source->steps, NULL), RMAP_OK);
    source->steps->step[0] = (struct rmap_track_step){.position = {1, 2, 3},
                                                      .direction = {0.6, 0, 0.8},
                                                      .length = 10,
                                                      .energy_mev = 2,
                                                      .time_ns = 5,
                                                      .charge = -1,
                                                      .beta = 1,
                                                      .event = 7};
    source->steps->emits[RMAP_PHOTON_CHERENKOV] = true;
    return scene;
}

static struct rmap_scintillation *scintillate(struct rmap_scene *scene)
{
    struct rmap_scintillation *light = rmap_alloc(1, sizeof *light);
    assert_non_null(light);
    *light = (struct rmap_scintillation){.per_mev = 100,
                                         .birks = 0.126,
                                         .resolution = 1,
                                         .rise_ns = 0.5,
                                         .decay = {2, {2.1, 14}, {0.75, 1}}};
    light->share[3] = 0.25;
    light->share[4] = 0.75;
    scene->medium[0].scintillation = light;
    scene->source[0].steps->emits[RMAP_PHOTON_SCINTILLATION] = true;
    return light;
}

static void finish(struct rmap_scene *scene)
{
    struct rmap_error err = {0};
    if (rmap_scene_finish(scene, &err) != RMAP_OK)
        fail_msg("%s", err.text);
}

static double chi_square(const double *seen, const double *expected, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        if (expected[i] > 0)
            sum += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
    return sum;
}

/* By the formulas, evaluated to 50 digits elsewhere. */
static double yield_of(double n, double beta, double charge, const double band[2])
{
    return rmap_cherenkov_strength(n, beta, charge) * rmap_cherenkov_band(band);
}

static void cherenkov_yield(void **state)
{
    (void)state;
    static const double band[2] = {300, 600};
    assert_near(yield_of(1.33, 1, 1, band) / 100, 332.168, 0.005);
    assert_near(yield_of(1.47, 1, 1, band) / 100, 410.54, 0.005);
    assert_near(yield_of(1.33, 1, -2, band) / 400, 332.168, 0.005);
    assert_true(yield_of(1.33, 0.75, 1, band) == 0.0);
    assert_true(yield_of(1.33, 0.7519, 1, band) > 0.0);
    struct rmap_scene *scene = water();
    finish(scene);
    assert_near(scene->source[0].flux, 332.168, 0.005);
    rmap_scene_destroy(scene);
}

static void cherenkov_rays(void **state)
{
    (void)state;
    struct rmap_scene *scene = water();
    const struct rmap_vec3 way = {0.6, 0, 0.8}, from = {1, 2, 3};
    double seen[30] = {0}, expected[30], place[10] = {0}, even[10], turn[8] = {0}, all_round[8];
    finish(scene);
    for (uint64_t ray = 0; ray < N; ray++) {
        struct rmap_colour colour;
        struct rmap_emission e;
        rmap_source_emit(scene, 42, ray, &colour, &e);
        const double cosine = rmap_dot(e.direction, way),
                     along = rmap_dot(rmap_sub(e.position, from), way);
        assert_near(acos(cosine) * 180 / RMAP_PI, 41.247, 0.001);
        assert_near(rmap_length(e.direction), 1, 1e-15);
        assert_true(rmap_colour_single(&colour) && along > 0 && along < 10 && e.predicted);
        const struct rmap_vec3 x = {0.8, 0, -0.6};
        const double phi = atan2(e.direction.y, rmap_dot(e.direction, x));
        seen[colour.begin]++;
        place[(int)along]++;
        turn[(int)((phi / RMAP_PI + 1) * 3.99999999)]++;
        assert_int_equal(rmap_scene_track_step(scene, 42, ray)->event, 7);
    }
    for (int i = 0; i < 30; i++) { /* flat in energy: as 1 / from - 1 / to */
        const double nm = 300 + 10 * i;
        expected[i] = N * (1 / nm - 1 / (nm + 10)) / (1.0 / 300 - 1.0 / 600);
        assert_near(scene->source[0].colour[i] * N, expected[i], 1e-9 * expected[i]);
    }
    for (int i = 0; i < 10; i++)
        even[i] = N / 10.0;
    for (int i = 0; i < 8; i++)
        all_round[i] = N / 8.0;
    assert_true(chi_square(seen, expected, 30) < 29 + 4 * sqrt(2 * 29.0));
    assert_true(chi_square(place, even, 10) < 9 + 4 * sqrt(2 * 9.0));
    assert_true(chi_square(turn, all_round, 8) < 7 + 4 * sqrt(2 * 7.0));
    rmap_scene_destroy(scene);
}

/* Where the index rises towards the blue, only that is above threshold. */
static void cherenkov_threshold(void **state)
{
    (void)state;
    struct rmap_scene *scene = water();
    struct rmap_track_step *step = &scene->source[0].steps->step[0];
    for (int i = 0; i < 30; i++)
        scene->medium[0].n[i] = 1.36 - 0.002 * i;
    step->beta = 1 / 1.34;
    finish(scene);
    double sum = 0;
    for (int i = 0; i < 30; i++) {
        const double nm = 300 + 10 * i,
                     part = yield_of(1.36 - 0.002 * i, 1 / 1.34, 1, (const double[]){nm, nm + 10}) /
                            100;
        sum += part;
        assert_true(i < 10 ? scene->source[0].colour[i] > 0 : scene->source[0].colour[i] < 1e-9);
    }
    assert_near(scene->source[0].flux, sum, 1e-12 * sum);
    for (uint64_t ray = 0; ray < 2000; ray++) {
        struct rmap_photon photon;
        rmap_source_photon(scene, &scene->source[0], 1, ray, &photon);
        assert_near(rmap_dot(photon.direction, step->direction),
                    1.34 / scene->medium[0].n[photon.channel], 1e-12);
    }
    scene->source[0].steps->range_nm[0] = 320;
    scene->source[0].steps->range_nm[1] = 345;
    finish(scene);
    assert_true(scene->source[0].colour[1] == 0 && scene->source[0].colour[5] == 0);
    assert_true(scene->source[0].colour[4] > 0);
    rmap_scene_destroy(scene);
}

static void birks(void **state)
{
    (void)state;
    struct rmap_scintillation medium = {.per_mev = 10000, .birks = 0.126};
    assert_near(rmap_scintillation_mean(&medium, 2, 10), 20000 / (1 + 0.126 * 0.2), 1e-8);
    assert_near(rmap_scintillation_mean(&medium, 5, 0.05), 50000 / (1 + 0.126 * 100), 1e-8);
    assert_near(rmap_scintillation_mean(&medium, 5, 0), 50000, 0); /* of unknown dE/dx */
    medium.birks = 0;
    assert_near(rmap_scintillation_mean(&medium, 5, 0.05), 50000, 0);
}

/* The share of photons after a time, of the density of one component. */
static double later(double t, double rise, double decay)
{
    return (decay * exp(-t / decay) - rise * exp(-t / rise)) / (decay - rise);
}

static void decay_times(void **state)
{
    (void)state;
    struct rmap_scene *scene = water();
    (void)scintillate(scene);
    scene->source[0].steps->emits[RMAP_PHOTON_CHERENKOV] = false;
    scene->source[0].steps->step[0].length = 0;
    finish(scene);
    static const double edge[] = {0, 0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 12, 20, 40, 1e9};
    double seen[13] = {0}, expected[13], mean = 0, of_channel[30] = {0};
    for (uint64_t ray = 0; ray < N; ray++) {
        struct rmap_photon photon;
        rmap_source_photon(scene, &scene->source[0], 3, ray, &photon);
        const double t = photon.delay_ns - 5;
        int k = 0;
        while (t >= edge[k + 1])
            k++;
        seen[k]++;
        of_channel[photon.channel]++;
        mean += photon.direction.z / N;
    }
    for (int k = 0; k < 13; k++)
        expected[k] = N * (0.75 * (later(edge[k], 0.5, 2.1) - later(edge[k + 1], 0.5, 2.1)) +
                           0.25 * (later(edge[k], 0.5, 14) - later(edge[k + 1], 0.5, 14)));
    assert_true(chi_square(seen, expected, 13) < 12 + 4 * sqrt(2 * 12.0));
    assert_near(of_channel[3], 0.25 * N, 4 * sqrt(0.25 * 0.75 * N));
    assert_near(of_channel[3] + of_channel[4], N, 0);
    assert_near(mean, 0, 4 / sqrt(3.0 * N));
    rmap_scene_destroy(scene);
}

static void numbers(void **state)
{
    (void)state;
    static const struct {
        double mean, resolution, variance;
    } of[] = {{0.3, 1, 0.3},   {7, 1, 7},       {40, 1, 40},
              {1000, 1, 1000}, {1000, 2, 4000}, {400, 0.2, 16 + 0.17}};
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        const int n = 20000;
        double sum = 0, square = 0;
        for (int i = 0; i < n; i++) {
            const double photons =
                (double)rmap_photon_number(of[k].mean, of[k].resolution, 5, (uint64_t)i);
            sum += photons;
            square += (photons - of[k].mean) * (photons - of[k].mean);
        }
        assert_near(sum / n, of[k].mean, 4 * sqrt(of[k].variance / n));
        assert_near(square / n, of[k].variance, 6 * of[k].variance * sqrt(2.5 / n));
    }
    assert_int_equal(rmap_photon_number(0, 1, 5, 5), 0);
}

/* Three steps of two events, in the wrong order: each photon once, event by event, as many as were
 * drawn of each; a weighted source has the same shares. */
static void counted(void **state)
{
    (void)state;
    struct rmap_scene *scene = water();
    struct rmap_source *source = &scene->source[0];
    const struct rmap_track_step step = source->steps->step[0];
    rmap_steps_destroy(source->steps);
    assert_int_equal(rmap_steps_create(3, &source->steps, NULL), RMAP_OK);
    for (int i = 0; i < 3; i++) {
        source->steps->step[i] = step;
        source->steps->step[i].event = (uint64_t)(i == 0 ? 9 : 4);
        source->steps->step[i].energy_mev = 1 + i;
    }
    (void)scintillate(scene);
    source->steps->emits[RMAP_PHOTON_CHERENKOV] = true;
    finish(scene);
    const double expected = source->flux;
    assert_int_equal(source->steps->step[0].event, 4);
    assert_near(source->steps->step[2].energy_mev, 1, 0);
    double share[6], before = 0, of[6] = {0};
    for (int k = 0; k < 6; k++) {
        share[k] = source->steps->photons[k] - before;
        before = source->steps->photons[k];
    }
    for (uint64_t ray = 0; ray < N; ray++) {
        struct rmap_photon photon;
        rmap_source_photon(scene, source, 8, ray, &photon);
        of[photon.step * 2 + photon.kind]++;
    }
    for (int k = 0; k < 6; k++)
        assert_near(of[k], N * share[k] / expected, 4 * sqrt(N * share[k] / expected));
    source->steps->counted = true;
    finish(scene);
    assert_near(source->flux, expected, 4 * sqrt(expected));
    assert_true(source->flux == floor(source->flux));
    size_t last = 0;
    double times[6] = {0};
    for (uint64_t ray = 0; ray < (uint64_t)source->flux; ray++) {
        struct rmap_photon photon;
        rmap_source_photon(scene, source, 8, ray, &photon);
        assert_true(photon.step * 2 + photon.kind >= last);
        last = photon.step * 2 + photon.kind;
        times[last]++;
        assert_true(rmap_scene_track_step(scene, 8, ray) == &source->steps->step[photon.step]);
    }
    before = 0;
    for (int k = 0; k < 6; k++) {
        assert_near(times[k], source->steps->photons[k] - before, 0);
        assert_near(times[k], share[k], 4 * sqrt(share[k]) + 1);
        before = source->steps->photons[k];
    }
    assert_int_equal(rmap_scene_n_photon(scene), (int)source->flux);
    static const double damaged[] = {-5, 0.5, 1e16, 0x1p64, 1e300, (double)NAN};
    for (size_t i = 0; i < RMAP_COUNT(damaged); i++) {
        struct rmap_photon photon;
        source->steps->photons[5] = damaged[i];
        assert_int_equal(rmap_scene_n_photon(scene), 0);
        rmap_source_photon(scene, source, 8, 12345, &photon);
        assert_true(photon.step < 3);
    }
    rmap_scene_destroy(scene);
}

static void refused(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rmap_scene *scene = water();
    struct rmap_track_step *step = &scene->source[0].steps->step[0];
    step->beta = 0.5; /* below threshold: no light */
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    step->beta = 1.5;
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "step 1"));
    step->beta = 1;
    step->energy_mev = (double)NAN;
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    step->energy_mev = 1;
    scene->channels.wavelength_nm[0] = 10;
    scene->channels.wavelength_nm[1] = 305;
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    scene->source[0].steps->range_nm[0] = 300;
    finish(scene);
    scene->source[0].steps->counted = true;
    scintillate(scene)->per_mev = 1e30; /* not drawn one by one */
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "9e+15"));
    rmap_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cherenkov_yield),
                                       cmocka_unit_test(cherenkov_rays),
                                       cmocka_unit_test(cherenkov_threshold),
                                       cmocka_unit_test(birks),
                                       cmocka_unit_test(decay_times),
                                       cmocka_unit_test(numbers),
                                       cmocka_unit_test(counted),
                                       cmocka_unit_test(refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
