/* SPDX-License-Identifier: MIT
 *
 * The promise: a surface with directions is the same surface from our CSV and from a tabular BSDF
 * of Zemax of several sample rotations, and rotations that cannot be read are refused by name.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "io/scene/scene_tables.h"

static const struct rmap_channels channels = {.n = 1, .wavelength_nm = {550.0}};
static const double theta_i[] = {20.0, 45.0};
enum { THETAS = 2, CAP = 1 << 23 };

/* ---- the surface, in its own x and y ---- */

/* Along a slanted line about the specular direction, with more of it to one side: neither a mirror
 * nor a turn leaves it as it is. */
static double law(struct rmap_vec3 in, struct rmap_vec3 out)
{
    const double dx = out.x - in.x, dy = out.y - in.y, u = 0.8 * dx + 0.6 * dy,
                 v = 0.8 * dy - 0.6 * dx;
    return 0.05 + 0.2 * exp(-u * u / 0.5 - v * v / 0.1) * (1.0 + 0.5 * in.x + 0.3 * in.y + 0.4 * u);
}

static double degrees(double angle)
{
    return angle * RMAP_PI / 180.0;
}

static struct rmap_vec3 spherical(double theta, double phi)
{
    return rmap_vec3(sin(degrees(theta)) * cos(degrees(phi)),
                     sin(degrees(theta)) * sin(degrees(phi)), cos(degrees(theta)));
}

/* ---- files of it ---- */

struct text {
    char *at;
    size_t n;
};

static void put(struct text *text, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int n = vsnprintf(text->at + text->n, CAP - text->n, format, list);
    va_end(list);
    assert_true(n >= 0 && (size_t)n < CAP - text->n);
    text->n += (size_t)n;
}

/* Equal steps from 0 that are less than `end`. */
static void put_steps(struct text *text, const char *name, double step, double end)
{
    put(text, "%s %.0f\n", name, ceil(end / step));
    for (double angle = 0.0; angle < end; angle += step)
        put(text, "%g ", angle);
    put(text, "\n");
}

static void write_csv(struct text *text, double turn)
{
    for (int i = 0; i < THETAS; i++)
        for (double phi_i = 0.0; phi_i < 360.0; phi_i += turn)
            for (double theta = 0.0; theta <= 90.0; theta += 2.0)
                for (double phi = 0.0; phi < 360.0; phi += 6.0)
                    put(text, "0 %g %g %g %g %.6g\n", theta_i[i], phi_i, theta, phi,
                        law(rmap_scale(spherical(theta_i[i], phi_i), -1.0), spherical(theta, phi)));
}

/* As it is measured: light comes in the laboratory's plane y = 0 and travels towards x, the sample
 * is turned. Its x axis begins at the normal of that plane, travel x normal, which is -y. */
static void write_lobe(struct text *text, double rotation, double incidence)
{
    const struct rmap_vec3 x = spherical(90.0, rotation - 90.0), y = spherical(90.0, rotation);
    const struct rmap_vec3 specular = spherical(incidence, 0.0), travel = {specular.x, 0, 0};
    const struct rmap_vec3 up = {-specular.z, 0.0, specular.x};
    const struct rmap_vec3 left = rmap_cross(specular, up); /* for who looks against the light */
    put(text, "TIS 0\n");
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += 10.0)
        for (double radial = 0.0; radial <= 135.0; radial += 3.0) {
            const struct rmap_vec3 turned = spherical(radial, azimuth);
            const struct rmap_vec3 out =
                rmap_axpy(turned.z, specular, rmap_axpy(turned.x, up, rmap_scale(left, turned.y)));
            put(text, "%.6g ",
                law(rmap_vec3(rmap_dot(travel, x), rmap_dot(travel, y), 0.0),
                    rmap_vec3(rmap_dot(out, x), rmap_dot(out, y), 0.0)));
        }
    put(text, "\n");
}

/* `last`: 360 as well, of which the values are not looked at. */
static void write_zemax(struct text *text, double turn, bool last)
{
    put(text, "Source Measured\nSymmetry Asymmetrical4D\nSpectralContent Monochrome\n"
              "ScatterType BRDF\n");
    put_steps(text, "SampleRotation", turn, last ? 361.0 : 360.0);
    put(text, "AngleOfIncidence %d\n%g %g\n", THETAS, theta_i[0], theta_i[1]);
    put_steps(text, "ScatterAzimuth", 10.0, 360.0);
    put_steps(text, "ScatterRadial", 3.0, 136.0);
    put(text, "Monochrome\nDataBegin\n");
    for (double rotation = 0.0; rotation < (last ? 361.0 : 360.0); rotation += turn)
        for (int i = 0; i < THETAS; i++)
            write_lobe(text, rotation, theta_i[i]);
    put(text, "DataEnd\n");
}

typedef enum rmap_status reader(const char *text, size_t nbytes,
                                const struct rmap_bsdf_wanted *wanted,
                                struct rmap_scatter_table **table_ret, struct rmap_error *err);

static struct rmap_scatter_table *table_of(reader *read, struct text *text)
{
    const struct rmap_bsdf_wanted wanted = {.channels = &channels};
    struct rmap_scatter_table *table = NULL;
    struct rmap_error err = {0};
    double theta;
    if (read(text->at, text->n, &wanted, &table, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    assert_true(rmap_scatter_table_finish(table, false, &theta) < 1.0);
    text->n = 0;
    return table;
}

/* ---- the same BSDF ---- */

/* Greatest difference of a table from the law, of light from some azimuths on; mirrored: from that
 * of the surface in a mirror. */
static double worst(struct rmap_scatter_table *table, double first, double step, bool mirrored)
{
    const struct rmap_scatter its = {.model = RMAP_SCATTER_TABLE, .amount = {1.0}, .table = table};
    const double sign = mirrored ? -1.0 : 1.0;
    double most = 0.0;
    for (int i = 0; i < THETAS; i++)
        for (double phi = first; phi < first + 360.0; phi += step)
            for (double theta = 1.0; theta < 80.0; theta += 7.3)
                for (double azimuth = 0.0; azimuth < 360.0; azimuth += 23.0) {
                    const struct rmap_vec3 in = rmap_scale(spherical(theta_i[i], phi), -1.0),
                                           out = spherical(theta, azimuth);
                    const struct rmap_scattering at = {
                        .scatter = &its, .front = true, .n1 = 1.0, .n2 = 1.0, .in = in};
                    const double want =
                        law(rmap_vec3(in.x, sign * in.y, 0), rmap_vec3(out.x, sign * out.y, 0));
                    most = fmax(most, fabs(rmap_table_shape(&at, out) - want));
                }
    return most;
}

/* Of a table from text, at the rotations that it has. Patches are constant, 3 degrees of angle and
 * 10 of azimuth, and the law changes by 0.03 within half of one; it is off by five times that from
 * what it is in a mirror. */
static void check(reader *read, struct text *text, size_t n_turn, double first)
{
    struct rmap_scatter_table *table = table_of(read, text);
    const double step = 360.0 / (double)n_turn, is = worst(table, first, step, false),
                 mirrored = worst(table, first, step, true);
    assert_int_equal(table->n_turn, n_turn);
    rmap_scatter_table_destroy(table);
    if (!(is < 0.035 && mirrored > 0.14))
        fail_msg("%zu turns: off by %.4f, from its mirror image by %.4f", n_turn, is, mirrored);
}

/* Five rotations: the plane of incidence at 0 is the sample's y axis, and none comes to its x axis.
 */
static void test_same_surface(void **state)
{
    struct text text = {.at = rmap_alloc(CAP, 1)};
    (void)state;
    assert_non_null(text.at);
    write_csv(&text, 45.0);
    check(rmap_bsdf_csv_read, &text, 8, 0.0);
    write_zemax(&text, 45.0, false);
    check(rmap_bsdf_zemax_read, &text, 8, 0.0);
    write_zemax(&text, 72.0, true);
    check(rmap_bsdf_zemax_read, &text, 5, 270.0);
    rmap_free(text.at);
}

/* ---- what cannot be read ---- */

static void test_mistakes(void **state)
{
    static const struct {
        const char *rotations, *complaint;
    } its[] = {{"2\n0 90", "SampleRotation 90, of 2, stands where 180 was due"},
               {"3\n0 90 180", "SampleRotation 90, of 3, stands where 120 was due"},
               {"4\n0 90 180 350", "SampleRotation 350, of 4, stands where 270 was due"},
               {"2\n5 185", "SampleRotation 5, of 2, stands where 0 was due"},
               {"5\n0 90 180 270 360", "TIS was due"},
               {"1000\n0", "a number from 0 to 360 was due"}};
    const struct rmap_bsdf_wanted wanted = {.channels = &channels};
    (void)state;
    for (size_t i = 0; i < sizeof its / sizeof *its; i++) {
        char text[400];
        struct rmap_scatter_table *table = NULL;
        struct rmap_error err = {0};
        const int n = snprintf(text, sizeof text,
                               "ScatterType BRDF\nSampleRotation %s\nAngleOfIncidence 1\n0\n"
                               "ScatterAzimuth 1\n0\nScatterRadial 2\n0 50\nMonochrome\nDataBegin\n"
                               "TIS 0\n0.1 0.2\nTIS 0\n0.1 0.2\nDataEnd\n",
                               its[i].rotations);
        assert_true(n > 0 && (size_t)n < sizeof text);
        assert_int_equal(rmap_bsdf_zemax_read(text, (size_t)n, &wanted, &table, &err), RMAP_INPUT);
        if (!strstr(err.text, its[i].complaint))
            fail_msg("'%s' expected: %s", its[i].complaint, err.text);
        assert_null(table);
    }
}

/* Angles that ask for more values than there can be take no memory. */
static void test_room(void **state)
{
    const struct rmap_bsdf_wanted wanted = {.channels = &channels};
    struct text text = {.at = rmap_alloc(CAP, 1)};
    struct rmap_scatter_table *table = NULL;
    struct rmap_error err = {0};
    (void)state;
    assert_non_null(text.at);
    put(&text, "ScatterType BRDF\n");
    put_steps(&text, "SampleRotation", 0.5, 360.0);
    put_steps(&text, "AngleOfIncidence", 0.5, 90.0);
    put_steps(&text, "ScatterAzimuth", 0.5, 360.0);
    put_steps(&text, "ScatterRadial", 0.5, 180.0);
    put(&text, "Monochrome DataBegin TIS 0 1 1 DataEnd");
    assert_int_equal(rmap_bsdf_zemax_read(text.at, text.n, &wanted, &table, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "values, and less stands behind DataBegin"));
    rmap_free(text.at);
}

static int none_live(void **state)
{
    (void)state;
    assert_int_equal(rmap_alloc_live(), 0);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_same_surface, none_live),
        cmocka_unit_test_teardown(test_mistakes, none_live),
        cmocka_unit_test_teardown(test_room, none_live),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
