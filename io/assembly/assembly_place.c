/* SPDX-License-Identifier: MIT
 *
 * Places as people write them.
 */
#include "io/assembly/assembly_place.h"

#include <math.h>
#include <string.h>

#define DEGREES (180 / RMAP_PI)

/* As a person would have written it, where that is within what CAD programs leave of units and
 * products of sines: 40.0000000000058. */
static double settled(double value, double tolerance)
{
    const double whole = round(value * 1e6) / 1e6;
    return fabs(value - whole) <= tolerance ? whole + 0.0 : value;
}

/* The lengths of the columns; false: they are not square to each other, or mirrored. */
static bool split(const struct rmap_affine *a, double scale[3], struct rmap_affine *turn)
{
    double off = 0;
    *turn = *a;
    for (int j = 0; j < 3; j++) {
        scale[j] =
            sqrt(a->m[0][j] * a->m[0][j] + a->m[1][j] * a->m[1][j] + a->m[2][j] * a->m[2][j]);
        if (!(scale[j] > 0))
            return false;
        for (int i = 0; i < 3; i++)
            turn->m[i][j] /= scale[j];
    }
    for (int j = 0; j < 3; j++) {
        const int k = (j + 1) % 3;
        off = fmax(off, fabs(turn->m[0][j] * turn->m[0][k] + turn->m[1][j] * turn->m[1][k] +
                             turn->m[2][j] * turn->m[2][k]));
    }
    return off < 1e-11 && rmap_affine_determinant(turn) > 0;
}

/* About the parent's x, then y, then z. Where y is a quarter turn, x and z turn about one axis. */
static void angles(const struct rmap_affine *a, double tolerance, double rotate[3])
{
    const double across = hypot(a->m[2][1], a->m[2][2]);
    const bool locked = across < 1e-9;
    rotate[0] = locked ? 0 : DEGREES * atan2(a->m[2][1], a->m[2][2]);
    rotate[1] = locked ? (a->m[2][0] < 0 ? 90 : -90) : DEGREES * atan2(-a->m[2][0], across);
    rotate[2] = DEGREES * (locked ? atan2(-a->m[0][1], a->m[1][1]) : atan2(a->m[1][0], a->m[0][0]));
    for (int k = 0; k < 3; k++)
        rotate[k] = settled(rotate[k], fmax(DEGREES * tolerance, 2e-12));
}

static bool is_like(const struct rmap_affine *a, const struct rmap_affine *b, double tolerance)
{
    double most = 0, apart = 0;
    for (int i = 0; i < 9; i++) {
        most = fmax(most, fabs(a->m[i / 3][i % 3]));
        apart = fmax(apart, fabs(a->m[i / 3][i % 3] - b->m[i / 3][i % 3]));
    }
    return apart <= (3e-14 + 4 * tolerance) * most;
}

static void put_numbers(FILE *out, const char *before, const char *key, const double *value,
                        size_t n)
{
    (void)fprintf(out, "%s%s: [", before, key);
    for (size_t i = 0; i < n; i++)
        (void)fprintf(out, "%s%.15g", i ? ", " : "", value[i] + 0.0);
    (void)fputc(']', out);
}

void rmap_assembly_put_place(FILE *out, const char *before, const struct rmap_affine *place,
                             double reach)
{
    const double most = 1e-10, relative = 1e-12; /* mm: faces of neighbours still meet to 1e-9 */
    struct rmap_affine turn;
    double scale[3], rotate[3], at[3] = {place->t.x, place->t.y, place->t.z};
    const double far = fmax(fabs(at[0]), fmax(fabs(at[1]), fabs(at[2]))), size = fmax(far, reach),
                 tolerance = fmin(relative, most / fmax(size, 1e-30));
    for (int k = 0; k < 3; k++)
        at[k] = settled(at[k], fmin(relative * size, most));
    bool plain = split(place, scale, &turn);
    if (plain) {
        angles(&turn, tolerance, rotate);
        for (int k = 0; k < 3; k++)
            scale[k] = settled(scale[k], fmax(tolerance, 4e-15));
        const struct rmap_affine again =
            rmap_affine_placement(rmap_vec3(scale[0], scale[1], scale[2]),
                                  rmap_vec3(rotate[0], rotate[1], rotate[2]), place->t);
        plain = is_like(place, &again, tolerance);
    }
    if (!plain) {
        double m[12];
        for (int i = 0; i < 12; i++)
            m[i] = i % 4 < 3 ? settled(place->m[i / 4][i % 4], tolerance) : at[i / 4];
        put_numbers(out, before, "matrix", m, 12);
        return;
    }
    if (at[0] != 0 || at[1] != 0 || at[2] != 0)
        put_numbers(out, before, "at", at, 3);
    if (rotate[0] != 0 || rotate[1] != 0 || rotate[2] != 0)
        put_numbers(out, before, "rotate", rotate, 3);
    if (scale[0] != scale[1] || scale[1] != scale[2])
        put_numbers(out, before, "scale", scale, 3);
    else if (scale[0] != 1)
        (void)fprintf(out, "%sscale: %.15g", before, scale[0]);
}
