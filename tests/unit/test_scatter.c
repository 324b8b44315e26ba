/* SPDX-License-Identifier: MIT
 *
 * The promise: directions of every scatter model are drawn with the density of its BSDF, totals are
 * the published ones, and models that say so are reciprocal.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/portable.h"
#include "base/vec.h"
#include "optics/mie.h"
#include "scatter/dust.h"
#include "scatter/scatter.h"
#include "scatter/table.h"

static void near_to(double is, double want, double within)
{
    if (!(fabs(is - want) <= within))
        fail_msg("%.16g, not %.16g (off by %.2g)", is, want, is - want);
}

/* A lobe on one channel. */
static struct rmap_scatter lobe(enum rmap_scatter_model model, double a, double b, double c,
                                double d)
{
    struct rmap_scatter its = {.model = model, .amount = {1.0}};
    const double shape[RMAP_SHAPE_MAX] = {a, b, c, d};
    for (int k = 0; k < RMAP_SHAPE_MAX; k++)
        its.shape[k][0] = shape[k];
    rmap_scatter_derive(&its, 1);
    return its;
}

static struct rmap_scatter rough_diffuse(double r, double albedo)
{
    struct rmap_scatter its = lobe(RMAP_SCATTER_OREN_NAYAR, r, 0, 0, 0);
    rmap_rough_diffuse(r, albedo, &its.amount[0], &its.shape[RMAP_SHAPE_SEVERAL][0]);
    return its;
}

static struct rmap_scattering meet(const struct rmap_scatter *scatter, double degrees)
{
    const double angle = degrees * RMAP_PI / 180.0;
    return (struct rmap_scattering){
        .scatter = scatter, .n1 = 1.0, .n2 = 1.0, .in = rmap_vec3(sin(angle), 0.0, -cos(angle))};
}

static double total_of(const struct rmap_scatter *scatter, double degrees)
{
    const struct rmap_scattering at = meet(scatter, degrees);
    return rmap_lobe_total(&at);
}

static void test_portable(void **state)
{
    (void)state;
    for (double x = -690.0; x < 690.0; x += 0.37)
        near_to(rmap_portable_exp(x) / exp(x), 1.0, 4e-16);
    for (double x = 1e-12; x < 1e12; x *= 1.7)
        for (double p = -2.5; p < 3.0; p += 0.45)
            near_to(rmap_portable_power(x, p) / pow(x, p), 1.0, 4e-14);
}

/* Harvey's law cut at the horizon: in closed form at normal incidence, by quadrature elsewhere
 * (b0 of 2 nm at 632.8 nm). */
static void test_harvey_totals(void **state)
{
    static const double angle[] = {0, 30, 60, 80}, want[] = {0, 1.4875e-3, 1.2188e-3, 9.460e-4};
    const double b0 = 0.13947;
    struct rmap_scatter its = lobe(RMAP_SCATTER_HARVEY, 0.01, -1.5, 0, 0);
    (void)state;
    const double closed = 2 * RMAP_PI * 1e-4 / 0.5 * (pow(1 + 1e4, 0.25) - 1);
    near_to(total_of(&its, 0), closed, 1e-8 * closed);
    near_to(b0 * closed, 1.5774e-3, 2e-7);
    for (int i = 1; i < 4; i++)
        near_to(b0 * total_of(&its, angle[i]), want[i], 6e-8);
    its = lobe(RMAP_SCATTER_HARVEY, 0.01, -2, 0, 0);
    const double log_law = RMAP_PI * 1e-4 * log(1 + 1e4);
    near_to(total_of(&its, 0), log_law, 1e-8 * log_law);
}

/* Pfisterer's form (BSDF-01 of the public corpus); g = 2 is Harvey's law of s = -2. */
static void test_abg_totals(void **state)
{
    static const double set[][3] = {{0.0025, 0.001, 1.8}, {0.01, 0.005, 2.0}, {0.001, 0.0001, 1.5}};
    static const double want[] = {0.0413436938881748, 0.166608237389051, 0.0118616978795582};
    (void)state;
    for (int i = 0; i < 3; i++) {
        const struct rmap_scatter its = lobe(RMAP_SCATTER_ABG, set[i][1], set[i][2], 0, 0);
        near_to(set[i][0] * total_of(&its, 0), want[i], 1e-7 * want[i]);
    }
    const struct rmap_scatter abg = lobe(RMAP_SCATTER_ABG, 1e-4, 2, 0, 0),
                              harvey = lobe(RMAP_SCATTER_HARVEY, 0.01, -2, 0, 0);
    for (double angle = 0; angle < 90; angle += 17)
        near_to(1e-4 * total_of(&abg, angle) / total_of(&harvey, angle), 1.0, 1e-9);
}

static void test_rough_shares(void **state)
{
    (void)state;
    near_to(rmap_rough_share(2.0 / 1e4, false, 1, 1, 1, 1), 6.32e-6, 5e-9);
    near_to(rmap_rough_share(2.0 / 587.56, false, 1, 1, 1.5168, 1), 1 - exp(-1.8297e-3), 1e-7);
    near_to(rmap_rough_share(2.0 / 587.56, true, 1, 1, 1.5168, 1), 1.2217e-4, 2e-8);
    /* either way through */
    near_to(rmap_rough_share(0.01, true, 1, 0.8, 1.5, 0.9),
            rmap_rough_share(0.01, true, 1.5, 0.9, 1, 0.8), 1e-16);
}

static void test_other_totals(void **state)
{
    struct rmap_scatter its = lobe(RMAP_SCATTER_GAUSSIAN, 0.02, 0, 0, 0);
    (void)state;
    near_to(total_of(&its, 0), 2 * RMAP_PI * 4e-4, 1e-11); /* nothing is cut */
    near_to(total_of(&its, 30), 2 * RMAP_PI * 4e-4, 1e-11);
    its = lobe(RMAP_SCATTER_COSINE, 7, 0, 0, 0);
    near_to(total_of(&its, 0), 2 * RMAP_PI / 9, 1e-8);
    near_to(total_of(&its, 90), 2 * RMAP_PI / 9 / 2, 0.5);
    its = lobe(RMAP_SCATTER_LAMBERT, 0, 0, 0, 0);
    near_to(total_of(&its, 71), RMAP_PI, 0);
    its = lobe(RMAP_SCATTER_K_CORRELATION, 0.05, 2.5, 0, 0);
    /* at normal incidence the cosine is sqrt(1 - x^2): by Simpson's rule in x = sin t */
    double sum = 0;
    enum { STEPS = 20000 };
    for (int i = 0; i <= STEPS; i++) {
        const double t = 0.5 * RMAP_PI * i / STEPS, x = sin(t);
        sum +=
            (i % STEPS ? i % 2 ? 4 : 2 : 1) * x * cos(t) * cos(t) * pow(1 + x * x / 0.0025, -1.25);
    }
    near_to(total_of(&its, 0), 2 * RMAP_PI * sum * RMAP_PI / STEPS / 6, 1e-9);
}

/* By the middles of patches; none has a kink inside. */
static double integral_of(const struct rmap_scattering *at)
{
    enum { RADII = 500, AROUND = 400 };
    const double cos_1 = -at->in.z;
    double sum = 0;
    for (int part = 0; part < 2; part++)
        for (int i = 0; i < RADII; i++)
            for (int j = 0; j < AROUND; j++) {
                const double span = part ? 1 - cos_1 : cos_1;
                const double z = (part ? cos_1 : 0) + span * (i + 0.5) / RADII;
                const double turn = 2 * RMAP_PI * (j + 0.5) / AROUND, s = sqrt(1 - z * z);
                sum += span * z *
                       rmap_lobe_shape(
                           at, rmap_vec3(s * cos(turn), s * sin(turn), at->passes ? -z : z));
            }
    return sum * 2 * RMAP_PI / RADII / AROUND;
}

/* Totals against the BSDF; a white surface keeps nothing, none sends more than its albedo; what
 * is sent by one facet and from all around, by the closed forms of the paper; Lambert's law. */
static void test_rough_diffuse(void **state)
{
    static const double r[] = {0, 0.3, 1}, albedo[] = {0.12, 0.8, 1};
    (void)state;
    for (int i = 0; i < 9; i++)
        for (double angle = 0; angle < 90; angle += 29.9) {
            const struct rmap_scatter its = rough_diffuse(r[i / 3], albedo[i % 3]);
            struct rmap_scattering at = meet(&its, angle);
            const double total = rmap_lobe_total(&at), share = its.amount[0] * total;
            near_to(integral_of(&at) / total, 1, 1e-5);
            assert_true(share <= albedo[i % 3] + 1e-15);
            if (albedo[i % 3] == 1 || r[i / 3] == 0)
                near_to(share, albedo[i % 3], 4e-16);
            at.passes = true;
            near_to(integral_of(&at) / total, 1, 1e-5);
        }
    struct rmap_scatter its = rough_diffuse(1, 1);
    const double a = 1 / (1.5 - 2 / (3 * RMAP_PI));
    its.shape[RMAP_SHAPE_SEVERAL][0] = 0;
    near_to(its.amount[0] * total_of(&its, 0), a, 1e-15);
    near_to(its.amount[0] * total_of(&its, 90), 1, 1e-15);
    double sum = 0;
    enum { STEPS = 2000 };
    for (int i = 0; i < STEPS; i++) {
        const double sin2 = (i + 0.5) / STEPS; /* of the same light from all around */
        sum += its.amount[0] * total_of(&its, asin(sqrt(sin2)) * 180 / RMAP_PI) / STEPS;
    }
    near_to(sum, a * (1 + 2.0 / 3 - 28 / (15 * RMAP_PI)), 1e-6);
}

/* ---- draws against the density ---- */

enum { DRAWS = 40000, RINGS = 12, SECTORS = 8, BINS = RINGS * SECTORS };

struct sample {
    struct rmap_vec3 *out;
    size_t n;
    double edge[RINGS + 1]; /* of x */
    int fine;               /* more points of the integrals */
};

static double x_of(struct rmap_vec3 centre, struct rmap_vec3 out)
{
    return hypot(out.x - centre.x, out.y - centre.y);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void set_edges(struct rmap_vec3 centre, struct sample *sample)
{
    double *x = malloc(sample->n * sizeof *x);
    assert_non_null(x);
    for (size_t i = 0; i < sample->n; i++)
        x[i] = x_of(centre, sample->out[i]);
    qsort(x, sample->n, sizeof *x, ascending);
    for (int k = 1; k < RINGS; k++)
        sample->edge[k] = x[(size_t)k * sample->n / RINGS];
    sample->edge[0] = 0;
    sample->edge[RINGS] = 1 + hypot(centre.x, centre.y);
    free(x);
}

/* Integral of density (per projected solid angle) over a bin. */
static double expected(const struct rmap_scattering *at, struct rmap_vec3 centre,
                       const struct sample *sample, int bin,
                       double (*density)(const struct rmap_scattering *, struct rmap_vec3))
{
    const int across = 60 * sample->fine, along = 110 * sample->fine, sector = bin % SECTORS;
    const double *edge = sample->edge + bin / SECTORS;
    double sum = 0;
    for (int i = 0; i < across; i++) {
        const double p = (i + 0.5) / across, span = edge[1] - edge[0];
        const double x = edge[0] + span * p * p, dx = 2 * p * span / across;
        for (int k = 0; k < along; k++) {
            const double turn = 2 * RMAP_PI * (sector + (k + 0.5) / along) / SECTORS;
            const double bx = centre.x + x * cos(turn), by = centre.y + x * sin(turn);
            const double rest = 1 - bx * bx - by * by;
            if (rest > 0)
                sum += x * dx * density(at, rmap_vec3(bx, by, (at->passes ? -1 : 1) * sqrt(rest)));
        }
    }
    return sum * 2 * RMAP_PI / SECTORS / along;
}

static void compare(const struct rmap_scattering *at, struct rmap_vec3 centre,
                    struct sample *sample, size_t n_drawn, const char *what,
                    double (*density)(const struct rmap_scattering *, struct rmap_vec3))
{
    double count[BINS] = {0}, chi2 = 0;
    int n_bin = 0;
    set_edges(centre, sample);
    for (size_t i = 0; i < sample->n; i++) {
        const double x = x_of(centre, sample->out[i]);
        double turn =
            atan2(sample->out[i].y - centre.y, sample->out[i].x - centre.x) / (2 * RMAP_PI);
        int ring = 0, sector = (int)((turn < 0 ? turn + 1 : turn) * SECTORS);
        while (ring + 1 < RINGS && x >= sample->edge[ring + 1])
            ring++;
        count[ring * SECTORS + (sector < SECTORS ? sector : SECTORS - 1)]++;
    }
    for (int k = 0; k < BINS; k++) {
        const double want = (double)n_drawn * expected(at, centre, sample, k, density);
        if (want < 8)
            continue;
        n_bin++;
        chi2 += (count[k] - want) * (count[k] - want) / want;
    }
    assert_true(n_bin > BINS / 5);
    if (!(chi2 < n_bin + 5 * sqrt(2.0 * n_bin)))
        fail_msg("%s: chi2 %.1f of %d bins", what, chi2, n_bin);
}

static double lobe_density(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    return rmap_lobe_shape(at, out) / at->total;
}

/* centre: the tangential part of the specular direction. */
static void check_draws(struct rmap_scattering at, double centre, int fine, const char *what)
{
    struct sample sample = {.out = malloc(DRAWS * sizeof *sample.out), .n = DRAWS, .fine = fine};
    at.total = rmap_lobe_total(&at);
    assert_non_null(sample.out);
    for (uint64_t i = 0; i < DRAWS; i++) {
        const struct rmap_draw draw = {.seed = 7, .ray = i, .step = 3};
        sample.out[i] = rmap_lobe_draw(&at, &draw);
        near_to(rmap_length(sample.out[i]), 1, 1e-14);
    }
    compare(&at, rmap_vec3(centre, 0, 0), &sample, DRAWS, what, lobe_density);
    free(sample.out);
}

static void check_lobe(const struct rmap_scatter *scatter, double degrees, bool passes)
{
    struct rmap_scattering at = meet(scatter, degrees);
    char what[80];
    at.passes = passes;
    at.n2 = passes ? 1.5 : 1.0;
    at.ahead = at.back = 1.0;
    const double scale = scatter->model == RMAP_SCATTER_RETRO ? -1 : passes ? 1 / 1.5 : 1;
    (void)snprintf(what, sizeof what, "%s at %g degrees%s", rmap_scatter_name[scatter->model].name,
                   degrees, passes ? ", passing" : "");
    check_draws(at, scale * at.in.x, 1, what);
}

static void test_lobe_draws(void **state)
{
    const struct rmap_scatter its[] = {
        lobe(RMAP_SCATTER_LAMBERT, 0, 0, 0, 0),
        lobe(RMAP_SCATTER_GAUSSIAN, 0.05, 0, 0, 0),
        lobe(RMAP_SCATTER_GAUSSIAN, 0.7, 0, 0, 0),
        lobe(RMAP_SCATTER_COSINE, 30, 0, 0, 0),
        lobe(RMAP_SCATTER_COSINE, 0.5, 0, 0, 0),
        lobe(RMAP_SCATTER_ABG, 1e-3, 1.8, 0, 0),
        lobe(RMAP_SCATTER_ABG, 1e-3, 2, 0, 0),
        lobe(RMAP_SCATTER_ABG, 1e-3, 2.6, 0, 0),
        lobe(RMAP_SCATTER_HARVEY, 0.01, -1.5, 0, 0),
        lobe(RMAP_SCATTER_HARVEY, 0.01, -2, 0, 0),
        lobe(RMAP_SCATTER_HARVEY, 0.05, -2.8, 0, 0),
        lobe(RMAP_SCATTER_K_CORRELATION, 0.02, 2.4, 0, 0),
        lobe(RMAP_SCATTER_RETRO, 0.03, 0, 0, 0),
        rough_diffuse(1, 1),
        rough_diffuse(0.6, 0.2),
    };
    (void)state;
    for (size_t i = 0; i < sizeof its / sizeof *its; i++) {
        check_lobe(&its[i], 0, false);
        check_lobe(&its[i], 40, false);
        check_lobe(&its[i], 85, false);
        if (its[i].model != RMAP_SCATTER_RETRO)
            check_lobe(&its[i], 60, true);
    }
}

/* The table over angles is good to 1e-5 of the total. */
static void test_table(void **state)
{
    static const double one = 1.0;
    struct rmap_scatter its = lobe(RMAP_SCATTER_HARVEY, 0.002, -1.8, 0, 0);
    struct rmap_error err;
    (void)state;
    assert_int_equal(rmap_scatter_tabulate(&its, 1, -1, -1, &one, &one, &err), RMAP_OK);
    assert_int_equal(its.n_totals, 1);
    for (double angle = 0.3; angle < 90; angle += 1.3) {
        const struct rmap_scattering at = meet(&its, angle);
        near_to(rmap_scatter_total(&at, 0, 0) / rmap_lobe_total(&at), 1, 1e-5);
    }
    rmap_scatter_fini(&its);
}

/* Measured tables, made of a law: about the normal, and about the specular direction, where lobes
 * of two incidences meet between them, and of two turns of the surface. */
static void test_table_draws(void **state)
{
    enum { RINGS_OF = 6, AROUND = 8, TABLES = 3 };
    static const size_t n_turn[TABLES] = {1, 1, 3};
    static const double ring[2][RINGS_OF + 1] = {{0, 10, 25, 40, 60, 80, 90},
                                                 {0, 2, 6, 15, 40, 90, 170}},
                                           theta[] = {0, 35, 70};
    size_t n_phi[RINGS_OF];
    (void)state;
    for (size_t r = 0; r < RINGS_OF; r++)
        n_phi[r] = r ? AROUND : 1;
    for (int k = 0; k < TABLES; k++) {
        const bool about = k > 0;
        struct rmap_scatter its = {.model = RMAP_SCATTER_TABLE, .amount = {1.0}};
        struct rmap_error err;
        double worst;
        assert_int_equal(
            rmap_scatter_table_create(&(struct rmap_scatter_table_shape){.n_ring = RINGS_OF,
                                                                         .ring_deg = ring[about],
                                                                         .n_phi = n_phi,
                                                                         .n_theta = 3,
                                                                         .theta_deg = theta,
                                                                         .n_turn = n_turn[k],
                                                                         .first_turn = 0.25,
                                                                         .n_band = 1,
                                                                         .side = {true, true},
                                                                         .about_specular = about},
                                      &its.table, &err),
            RMAP_OK);
        for (int side = 0; side < 2; side++)
            for (size_t i = 0; i < its.table->n_in * its.table->out.n; i++)
                its.table->block[side].value[i] =
                    0.3 / (1.0 + (double)(i % its.table->out.n)) * (1.0 + 0.1 * (double)(i % 5));
        assert_true(rmap_scatter_table_finish(its.table, false, &worst) < 1);
        check_lobe(&its, 0, false);
        check_lobe(&its, 20, false);
        check_lobe(&its, 60, false);
        check_lobe(&its, 80, false);
        rmap_scatter_fini(&its);
    }
}

/* A sphere of Bohren and Huffman (appendix A), a large one, and energy. */
static void test_mie(void **state)
{
    enum { ANGLES = 4001 };
    static double cosine[ANGLES], intensity[ANGLES];
    struct rmap_mie mie;
    struct rmap_error err;
    const double x = 2 * RMAP_PI * 0.525 / 0.6328, ends[2] = {1, -1};
    (void)state;
    assert_int_equal(rmap_mie_scatter(x, 1.55, 0, 2, ends, intensity, &mie, &err), RMAP_OK);
    near_to(mie.scattered, 3.10543, 5e-6);
    near_to(mie.extinct, 3.10543, 5e-6);
    near_to(4 * intensity[1] / (x * x), 2.92534, 5e-6);
    assert_int_equal(rmap_mie_scatter(6000, 1.53, 1e-3, 0, NULL, NULL, &mie, &err), RMAP_OK);
    near_to(mie.extinct, 2, 0.01); /* half of it diffraction */
    for (int i = 0; i < ANGLES; i++)
        cosine[i] = -1 + 2.0 * i / (ANGLES - 1);
    assert_int_equal(rmap_mie_scatter(20, 1.53, 1e-3, ANGLES, cosine, intensity, &mie, &err),
                     RMAP_OK);
    double sum = 0;
    for (int i = 0; i < ANGLES; i++)
        sum += (i % (ANGLES - 1) ? i % 2 ? 4 : 2 : 1) * intensity[i];
    near_to(sum * 2 / (ANGLES - 1) / 3 * 2 / 400, mie.scattered, 1e-6);
}

/* Cases of MIEV0 (Wiscombe 1979, NCAR/TN-140+STR), m = n - ik. */
static void test_efficiencies(void **state)
{
    static const double wiscombe[][6] = {
        {0.75, 0, 0.099, 7e-6, 7e-6, 0.001448},      {0.75, 0, 10, 2.232265, 2.232265, 0.896473},
        {1.33, 1e-5, 1, NAN, 0.093923, 0.184517},    {1.5, 1, 1, 2.336321, 0.6634538, 0.192136},
        {1.5, 1, 100, 2.097502, 1.283697, 0.850252}, {10, 10, 1, NAN, 2.049405, -0.110664}};
    struct rmap_mie mie;
    struct rmap_error err;
    (void)state;
    for (size_t i = 0; i < sizeof wiscombe / sizeof *wiscombe; i++) {
        const double *its = wiscombe[i];
        assert_int_equal(rmap_mie_scatter(its[2], its[0], its[1], 0, NULL, NULL, &mie, &err),
                         RMAP_OK);
        if (!isnan(its[3]))
            near_to(mie.extinct, its[3], 1e-6);
        near_to(mie.scattered, its[4], 1e-6);
        near_to(mie.cosine, its[5], 1e-6);
    }
}

/* Levels 400 and 600 cover 0.106 and 0.798 % where spheres are counted per square foot. */
static void test_dust(void **state)
{
    static const struct rmap_channels channels = {.n = 1, .wavelength_nm = {632.8}};
    static const double level[] = {400, 600}, want[] = {0.00106, 0.00798};
    (void)state;
    for (int i = 0; i < 2; i++) {
        const struct rmap_dust_kind kind = {level[i], 0.926, 0.09290304e12, {1.53}, {1e-3}};
        struct rmap_scatter its = {.model = RMAP_SCATTER_CONTAMINATION};
        struct rmap_error err;
        assert_int_equal(rmap_scatter_set_dust(&its, &kind, &channels, NULL, 0, &err), RMAP_OK);
        near_to(its.dust->coverage, want[i], 0.01 * want[i]);
        near_to(its.dust->below[its.dust->n_ring - 1], 1, 1e-12);
        near_to(its.shape[RMAP_SHAPE_EXTINCT][0] / its.dust->coverage, 2.05, 0.1);
        check_lobe(&its, 0, false);
        check_lobe(&its, 60, false);
        check_lobe(&its, 60, true);
        /* before glass; and beyond it, where light is sent back into the glass */
        struct rmap_scattering at = meet(&its, 50);
        at.n2 = 1.5;
        at.ahead = 0.04;
        at.back = 1.0;
        check_draws(at, at.in.x, 1, "particles before glass");
        at = meet(&its, 30);
        at.n1 = 1.5;
        at.beyond = true;
        at.ahead = at.back = 1.0;
        check_draws(at, -at.in.x, 4, "particles beyond, back into the glass");
        at.passes = true;
        check_draws(at, 1.5 * at.in.x, 1, "particles beyond glass");
        rmap_scatter_fini(&its);
    }
}

/* ---- facets ---- */

static void all_reflected(const void *self, double cosine, double share[2])
{
    (void)self;
    (void)cosine;
    share[0] = 1.0;
    share[1] = 0.0;
}

/* A made-up law: what counts is that both ways use it. */
static void some_reflected(const void *self, double cosine, double share[2])
{
    (void)self;
    share[0] = 0.04 + 0.9 * pow(1 - cosine, 5);
    share[1] = 1 - share[0];
}

static double facet_density(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    double cosine, share[2];
    const double f = rmap_facet_bsdf(at, out, &cosine);
    some_reflected(NULL, cosine, share);
    return f * share[at->passes];
}

static void check_facets(const struct rmap_scatter *scatter, double degrees, bool passes)
{
    struct rmap_scattering at = meet(scatter, degrees);
    struct sample sample = {.out = malloc(DRAWS * sizeof *sample.out), .fine = 1};
    double total[3], share[2];
    char what[80];
    at.passes = passes;
    at.n2 = scatter->refracts ? 1.5 : 1.0;
    at.total = scatter->model == RMAP_SCATTER_UNIFIED ? rmap_lobe_total(&at) : 0;
    assert_non_null(sample.out);
    for (uint64_t i = 0; i < DRAWS; i++) {
        const struct rmap_draw draw = {.seed = 5, .ray = i, .step = 2};
        const struct rmap_vec3 m = rmap_facet_draw(&at, &draw);
        struct rmap_vec3 out = rmap_facet_reflected(at.in, m);
        double u[4];
        const double cosine = -rmap_dot(at.in, m);
        assert_true(cosine > 0 && m.z >= 0);
        if ((passes && !rmap_facet_refracted(&at, m, &out)) || (out.z < 0) != passes)
            continue;
        rmap_rng(11, i, 1, RMAP_RNG_SURFACE, u);
        some_reflected(NULL, cosine, share);
        if (u[0] < share[passes] * rmap_facet_unhindered(&at, out))
            sample.out[sample.n++] = out;
    }
    rmap_facet_total(&at, some_reflected, NULL, total);
    const double part = total[passes], sigma = sqrt(part * (1 - part) / DRAWS);
    near_to((double)sample.n / DRAWS, part, 4 * sigma + 2e-4);
    (void)snprintf(what, sizeof what, "%s at %g degrees%s", rmap_scatter_name[scatter->model].name,
                   degrees, passes ? ", passing" : "");
    compare(&at, rmap_vec3(passes ? at.in.x / 1.5 : at.in.x, 0, 0), &sample, DRAWS, what,
            facet_density);
    free(sample.out);
}

static void test_facet_draws(void **state)
{
    struct rmap_scatter its[] = {
        lobe(RMAP_SCATTER_GGX, 0.1, 0.1, 0, 0),         lobe(RMAP_SCATTER_GGX, 0.5, 0.2, 0, 0),
        lobe(RMAP_SCATTER_BECKMANN, 0.1, 0.1, 0, 0),    lobe(RMAP_SCATTER_BECKMANN, 0.6, 0.3, 0, 0),
        lobe(RMAP_SCATTER_UNIFIED, 0.1, 0, 1, 0),       lobe(RMAP_SCATTER_UNIFIED, 0.3, 0, 1, 0),
        lobe(RMAP_SCATTER_SLOPE_ERROR, 0.5, 0.5, 1, 0),
    };
    (void)state;
    for (size_t i = 0; i < sizeof its / sizeof *its; i++)
        for (int refracts = 0; refracts < 2; refracts++) {
            its[i].refracts = refracts;
            check_facets(&its[i], 0, false);
            check_facets(&its[i], 50, false);
            check_facets(&its[i], 80, false);
            if (refracts)
                check_facets(&its[i], 50, true);
        }
}

/* Mean tilts of Geant4's facets, degrees. */
static void test_facet_tilts(void **state)
{
    static const double sigma[] = {1.3, 3.8, 6, 12}, want[] = {1.6292, 4.7591, 7.5061, 14.9299};
    (void)state;
    for (int k = 0; k < 4; k++) {
        const struct rmap_scatter its =
            lobe(RMAP_SCATTER_UNIFIED, sigma[k] * RMAP_PI / 180, 0, 1, 0);
        const struct rmap_scattering at = meet(&its, 0);
        double sum = 0, sum2 = 0;
        size_t n = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            const struct rmap_draw draw = {.seed = 9, .ray = i, .step = 1};
            const double tilt = acos(rmap_facet_draw(&at, &draw).z) * 180 / RMAP_PI;
            sum += tilt;
            sum2 += tilt * tilt;
            n++;
        }
        const double mean = sum / (double)n,
                     error = sqrt((sum2 / (double)n - mean * mean) / (double)n);
        near_to(mean, want[k], 4 * error + (sigma[k] > 10 ? 0.02 : 0)); /* few are turned down */
    }
}

/* Facets alone, all reflecting: what they send away is what is not lost to others, at most 1, and
 * GGX's own albedo at alpha 0.5, by quadrature of its BSDF. */
static void test_furnace(void **state)
{
    static const enum rmap_scatter_model model[] = {RMAP_SCATTER_GGX, RMAP_SCATTER_BECKMANN,
                                                    RMAP_SCATTER_SLOPE_ERROR};
    (void)state;
    for (int k = 0; k < 3; k++)
        for (double angle = 0; angle < 85; angle += 20) {
            const struct rmap_scatter its = lobe(model[k], 0.5, 0.5, 1, 0);
            const struct rmap_scattering at = meet(&its, angle);
            double total[3], sum = 0, cosine;
            enum { RADII = 400, AROUND = 400 };
            rmap_facet_total(&at, all_reflected, NULL, total);
            assert_true(total[0] < (k < 2 ? 1 : 1 + 1e-12) && total[0] > 0.6 && total[1] == 0);
            for (int i = 0; i < RADII; i++)
                for (int j = 0; j < AROUND; j++) {
                    const double v = (i + 0.5) / RADII, z = v * v;
                    const double turn = 2 * RMAP_PI * (j + 0.5) / AROUND;
                    const double s = sqrt(1 - z * z);
                    sum +=
                        2 * v * z *
                        rmap_facet_bsdf(&at, rmap_vec3(s * cos(turn), s * sin(turn), z), &cosine);
                }
            near_to(total[2], 1 - total[0], 1e-12);
            near_to(total[0], sum * 2 * RMAP_PI / RADII / AROUND, k < 2 ? 3e-4 : 3e-3); /* edge */
        }
}

/* f(a -> b) = f(b -> a). */
static void test_reciprocity(void **state)
{
    struct rmap_scatter its[] = {
        lobe(RMAP_SCATTER_GAUSSIAN, 0.3, 0, 0, 0),
        lobe(RMAP_SCATTER_COSINE, 3, 0, 0, 0),
        lobe(RMAP_SCATTER_ABG, 1e-3, 1.8, 0, 0),
        lobe(RMAP_SCATTER_HARVEY, 0.1, -1.5, 0, 0),
        lobe(RMAP_SCATTER_RETRO, 0.3, 0, 0, 0),
        lobe(RMAP_SCATTER_LAMBERT, 0, 0, 0, 0),
        lobe(RMAP_SCATTER_GGX, 0.5, 0.2, 0, 0),
        lobe(RMAP_SCATTER_BECKMANN, 0.3, 0.6, 0, 0),
        lobe(RMAP_SCATTER_SLOPE_ERROR, 0.6, 0.6, 1, 0),
        lobe(RMAP_SCATTER_K_CORRELATION, 0.1, 2.5, 0, 0),
        rough_diffuse(0.7, 0.9),
    };
    (void)state;
    for (size_t i = 0; i < sizeof its / sizeof *its; i++)
        for (uint64_t k = 0; k < 200; k++) {
            double u[4], z[2], cosine[2], f[2];
            rmap_rng(3, k, 0, RMAP_RNG_SURFACE, u);
            struct rmap_vec3 way[2];
            for (int j = 0; j < 2; j++) {
                z[j] = u[2 * j];
                const double s = sqrt(1 - z[j] * z[j]), turn = 2 * RMAP_PI * u[2 * j + 1];
                way[j] = rmap_vec3(s * cos(turn), s * sin(turn), z[j]);
            }
            for (int j = 0; j < 2; j++) {
                struct rmap_scattering at = meet(&its[i], 0);
                at.in = rmap_scale(way[j], -1);
                f[j] = rmap_scatter_is_facets(&its[i])
                           ? rmap_facet_bsdf(&at, way[1 - j], &cosine[j])
                           : rmap_lobe_shape(&at, way[1 - j]);
                if (its[i].model == RMAP_SCATTER_K_CORRELATION)
                    f[j] *= z[j]; /* its amount has the cosine of incidence */
            }
            near_to(f[0], f[1], 1e-12 * fmax(f[0], f[1]));
            if (rmap_scatter_is_facets(&its[i]))
                near_to(cosine[0], cosine[1], 1e-13);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_portable),     cmocka_unit_test(test_harvey_totals),
        cmocka_unit_test(test_abg_totals),   cmocka_unit_test(test_rough_shares),
        cmocka_unit_test(test_other_totals), cmocka_unit_test(test_rough_diffuse),
        cmocka_unit_test(test_lobe_draws),   cmocka_unit_test(test_mie),
        cmocka_unit_test(test_efficiencies), cmocka_unit_test(test_dust),
        cmocka_unit_test(test_table),        cmocka_unit_test(test_table_draws),
        cmocka_unit_test(test_facet_draws),  cmocka_unit_test(test_facet_tilts),
        cmocka_unit_test(test_furnace),      cmocka_unit_test(test_reciprocity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
