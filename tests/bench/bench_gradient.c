/* SPDX-License-Identifier: MIT
 *
 * Measurement of rays through gradient media against the scheme of Sharma, Kumar, Ghatak 1982
 * (doi:10.1364/AO.21.000984), with a fixed step and with steps between a least and a greatest one.
 * Each side takes the coarsest setting that brings the ray out where the closed form does, within
 * an error; all evaluations of the index count, those that find the way out too.
 */
#include <math.h>
#include <stdio.h>

#include "bench.h"
#include "gradient/curve.h"
#include "gradient/field_polynomial.h"
#include "gradient/models.h"

/* A ray whose end is known: on the unit sphere, or (sphere false) at z = end.z. */
struct passage {
    const char *medium, *name;
    bool sphere;
    double size;
    struct rmap_vec3 from, direction, end;
};

/* Luneburg 1944 (Mathematical Theory of Optics, sec. 28): every ray to the antipode. The rod: a
 * sine of z, x = x0 cos(w z) + sin(w z) dx/dz / w, w = n0 alpha / Tz (Ghatak, Thyagarajan 1978,
 * Contemporary Optics, ch. 2); 2.4 periods. */
static const struct passage known[] = {
    {"luneburg", "h 0.6", true, 2.0, {-0.8, 0.6, 0.0}, {1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}},
    {"parabolic-rod",
     "5 deg",
     false,
     16.0,
     {1.0, 0.0, 0.0},
     {0.08715574274765817, 0.0, 0.9961946980917455},
     {-0.367826741470131, 0.0, 150.0}},
};

static const double within[] = {1e-6, 1e-9};

enum { PASSAGES = sizeof known / sizeof known[0], ERRORS = sizeof within / sizeof within[0] };

/* How far beyond its end the ray is; < 0: before. */
static double beyond(const struct passage *passage, struct rmap_vec3 r, struct rmap_vec3 T)
{
    if (!passage->sphere)
        return r.z - passage->end.z;
    return rmap_dot(r, T) > 0.0 ? rmap_dot(r, r) - 1.0 : rmap_dot(r, T);
}

static double beyond_at(const struct passage *passage, const struct rmap_curve_step *step,
                        double theta)
{
    struct rmap_vec3 r, T;
    rmap_curve_at(step, theta, &r, &T);
    return beyond(passage, r, T);
}

/* Where a step ends at last: false position (the Illinois way) on its dense output. */
static double find_end(const struct passage *passage, const struct rmap_curve_step *step)
{
    double low = 0.0, high = 1.0, before = beyond_at(passage, step, 0.0),
           after = beyond_at(passage, step, 1.0);
    double theta = high, here = after, side = 0.0;
    for (int i = 0; i < 60 && fabs(here) > 1e-15 && high - low > 1e-15; i++) {
        theta = low - before * (high - low) / (after - before);
        here = beyond_at(passage, step, theta);
        if (here > 0.0) {
            before *= side > 0.0 ? 0.5 : 1.0;
            high = theta;
            after = here;
        } else {
            after *= side < 0.0 ? 0.5 : 1.0;
            low = theta;
            before = here;
        }
        side = here;
    }
    return theta;
}

/* Sends the ray. Returns its error at the end; INFINITY when it does not get there. */
static double send(const struct passage *passage, const struct rmap_gradient *gradient,
                   uint64_t *n_evaluation)
{
    struct rmap_curve curve;
    struct rmap_curve_step step;
    if (!rmap_curve_begin(&curve, gradient, 0, passage->from, passage->direction))
        return (double)INFINITY;
    for (int i = 0; i < 1000000; i++) {
        if (!rmap_curve_advance(&curve, (double)INFINITY, &step))
            return (double)INFINITY;
        if (beyond(passage, step.to.r, step.to.T) > 0.0) {
            (void)rmap_curve_cut(&curve, &step, find_end(passage, &step));
            *n_evaluation = curve.n_evaluation;
            return rmap_length(rmap_sub(curve.state.r, passage->end));
        }
        if (rmap_length(curve.state.r) > 1.1 * rmap_length(passage->end)) /* stepped over */
            return (double)INFINITY;
    }
    return (double)INFINITY;
}

static bool is_ours(enum rmap_scheme scheme)
{
    return scheme == RMAP_SCHEME_ADAPTIVE || scheme == RMAP_SCHEME_INTEGRATED;
}

/* A setting of a scheme by one number, from coarse to fine; the seed's lengths are as accurate as
 * its ray needs to be. */
static void set_fineness(struct rmap_gradient *gradient, enum rmap_scheme scheme, double fineness,
                         double error)
{
    struct rmap_curve_options *options = &gradient->options;
    *options = (struct rmap_curve_options){.scheme = scheme, .tolerance = error};
    options->step = options->step_max = fineness * gradient->size;
    options->step_min = 0.01 * options->step_max;
    options->amplitude = 1.0 / gradient->size;
    if (is_ours(scheme))
        options->tolerance = fineness * gradient->size;
}

/* The coarsest setting that keeps the error, and so does the next finer one: no lucky hit. */
static uint64_t find_fineness(const struct passage *passage, struct rmap_gradient *gradient,
                              enum rmap_scheme scheme, double error)
{
    const double finer = is_ours(scheme) ? 0.75 : 0.97;
    double kept = 0.0;
    uint64_t n_evaluation = 0, n_kept = 0;
    for (double fineness = is_ours(scheme) ? 1e-3 : 0.25; fineness > 1e-16; fineness *= finer) {
        set_fineness(gradient, scheme, fineness, error);
        bool good = send(passage, gradient, &n_evaluation) <= error;
        if (good && kept > 0.0)
            break;
        kept = good ? fineness : 0.0;
        n_kept = n_evaluation;
    }
    set_fineness(gradient, scheme, kept, error);
    return n_kept;
}

static double time_of(const struct passage *passage, const struct rmap_gradient *gradient,
                      int n_ray)
{
    uint64_t n_evaluation = 0;
    double begun = rmap_bench_cpu();
    for (int i = 0; i < n_ray; i++)
        (void)send(passage, gradient, &n_evaluation);
    return (rmap_bench_cpu() - begun) / n_ray;
}

/* Ours as it is, where both media have a closed form, or integrated as media without one are. */
struct sides {
    enum rmap_scheme ours, seed;
    const char *name;
};

static const struct sides compared[] = {
    {RMAP_SCHEME_ADAPTIVE, RMAP_SCHEME_SHARMA_FIXED, "closed form, fixed step"},
    {RMAP_SCHEME_ADAPTIVE, RMAP_SCHEME_SHARMA, "closed form, step rule"},
    {RMAP_SCHEME_INTEGRATED, RMAP_SCHEME_SHARMA_FIXED, "integrated, fixed step"},
    {RMAP_SCHEME_INTEGRATED, RMAP_SCHEME_SHARMA, "integrated, step rule"}};

static void compare(struct rmap_bench *bench, const struct passage *passage,
                    const struct rmap_gradient *place, double error, const struct sides *sides)
{
    const struct rmap_bench_scene scene = {.name = passage->medium};
    struct rmap_gradient ours = *place, seed = *place;
    struct rmap_bench_series series = {0};
    char class[80];
    uint64_t n_ours = find_fineness(passage, &ours, sides->ours, error);
    uint64_t n_seed = find_fineness(passage, &seed, sides->seed, error);
    int n_ray = bench->quick ? 100 : 1000;
    for (int i = 0; i < bench->n_repeat; i++) {
        rmap_bench_add(&series, (double)n_ours, (double)n_seed);
        rmap_bench_add_cpu(&series, time_of(passage, &ours, n_ray), time_of(passage, &seed, n_ray));
    }
    (void)snprintf(class, sizeof class, "%s to %.0e, %s", passage->name, error, sides->name);
    rmap_bench_report(bench, "gradient_evaluations_vs_seed", &scene, &series, "evaluations per ray",
                      json_pack("{s:s, s:f, s:f}", "class", class, "tolerance",
                                ours.options.tolerance, "step", seed.options.step));
}

enum rmap_status rmap_bench_gradient(struct rmap_bench *bench, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_field *field[PASSAGES] = {NULL};
    const struct rmap_luneburg luneburg = {.n_edge = 1.0, .radius = 1.0};
    const struct rmap_parabolic rod = {.n0 = 1.5, .alpha = 0.1};
    RMAP_TRY(rmap_field_luneburg(&field[0], 1, &luneburg, err));
    RMAP_TRY(rmap_field_parabolic(&field[1], 1, &rod, err));
    for (int p = 0; p < PASSAGES; p++) {
        const struct rmap_gradient place = {.field = field[p],
                                            .to_world = rmap_affine_identity(),
                                            .to_local = rmap_affine_identity(),
                                            .size = known[p].size};
        for (int e = 0; e < ERRORS; e++)
            for (size_t k = 0; k < sizeof compared / sizeof compared[0]; k++)
                compare(bench, &known[p], &place, within[e], &compared[k]);
    }
out:
    for (int p = 0; p < PASSAGES; p++)
        rmap_field_destroy(field[p]);
    return st;
}
