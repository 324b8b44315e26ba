/* SPDX-License-Identifier: MIT
 *
 * What is known of a sag over its whole aperture: that it has a value, between which heights it
 * lies, and a bound of its second derivatives, by which roots are isolated.
 *
 * Polynomials are bounded by their values at Chebyshev points: a polynomial of degree n is nowhere
 * on the interval greater than 1 / cos(n pi / (2 k)) times its greatest value at k > n of them, a
 * trigonometric one on the circle than 1 / cos(n pi / k) times that at k > 2 n even places (Ehlich
 * and Zeller 1964, doi 10.1007/BF01111276). Second derivatives are differences of first ones, whose
 * errors the factors below cover.
 */
#include <float.h>
#include <stddef.h>

#include "geometry/sag.h"

/* Points per degree, and the factor: 1 / cos(pi / 8), and 1 / cos(pi / 6) times that. */
enum { RADIAL = 4, AROUND = 6 };
static const double OF_ONE = 1.0825, OF_TWO = 1.2501;

/* Rooms for what starts a little beyond the rim, where another surface shares that. */
static const double BEYOND = 1 + 1e-8;

/* Under roots: as for aspheres. */
static const double LEAST_ROOT = 1e-14;

/* Half the step of differences, in units of the radius. */
static const double STEP = 1e-5;

/* Greatest values of a polynomial over a disc, or over a line through its middle. */
struct most {
    double z, slope, bend[3]; /* xx, xy, yy */
};

/* Nodes from `from` to `to` along n_angle directions of a half circle, the first along x or y. */
static struct most most_of(const struct rmap_sag *part, const double range[2], int degree,
                           int n_angle, bool along_y)
{
    const double factor = n_angle > 1 ? OF_TWO : OF_ONE, h = STEP * range[1];
    struct most most = {.z = 0};
    const int n = RADIAL * (degree + 1);
    for (int i = 0; i < n * n_angle; i++) {
        const double angle = RMAP_PI * (i / n) / n_angle + (along_y ? 0.5 * RMAP_PI : 0);
        const double t = 0.5 * (1 - cos(RMAP_PI * (i % n + 0.5) / n));
        const double r = range[0] + t * (range[1] - range[0]);
        const double x = r * cos(angle), y = r * sin(angle);
        const struct rmap_height at = rmap_sag_profile(part, x, y),
                                 left = rmap_sag_profile(part, x - h, y),
                                 right = rmap_sag_profile(part, x + h, y),
                                 below = rmap_sag_profile(part, x, y - h),
                                 above = rmap_sag_profile(part, x, y + h);
        const double xx = fabs(right.x - left.x), yy = fabs(above.y - below.y),
                     xy = rmap_max(fabs(right.y - left.y), fabs(above.x - below.x));
        most.z = rmap_max(most.z, factor * fabs(at.z));
        most.slope = rmap_max(most.slope, factor * (fabs(at.x) + fabs(at.y)));
        const double bend[3] = {xx, xy, yy};
        for (int k = 0; k < 3; k++)
            most.bend[k] = rmap_max(most.bend[k], factor * bend[k] / (2 * h));
    }
    return most;
}

/* The sums without the base, of which the named ones stay. */
enum { POWERS = 1, PLANAR = 2, QCON = 4, QBFS = 8 };
static void take(const struct rmap_sag *sag, int parts, struct rmap_sag *part)
{
    *part = *sag;
    part->base = RMAP_SAG_CONIC;
    part->fresnel = false;
    for (int k = 0; k < 2; k++)
        part->curvature[k] = part->conic[k] = 0;
    part->power[0] = 0;
    part->n_power = parts & POWERS ? sag->n_power : 0;
    part->n_xy = parts & PLANAR ? sag->n_xy : 0;
    part->n_zernike = parts & PLANAR ? sag->n_zernike : 0;
    part->n_qcon = parts & QCON ? sag->n_qcon : 0;
    part->n_qbfs = parts & QBFS ? sag->n_qbfs : 0;
}

static int greater(int a, int b)
{
    return a > b ? a : b;
}

/* Of what is alike along x and y. */
static void add_round_bend(struct rmap_sag *sag, double bend)
{
    sag->bend[0] += bend;
    sag->bend[2] += bend;
}

static void add_sums(struct rmap_sag *sag, double radius)
{
    const double disc[2] = {-radius, radius}, ray[2] = {0, radius};
    const int planar = greater(sag->n_xy, sag->n_zernike) - 1;
    struct rmap_sag part;
    if (planar > 0) {
        take(sag, PLANAR, &part);
        const struct most most = most_of(&part, disc, planar, AROUND * planar / 2 + 1, false);
        for (int k = 0; k < 3; k++)
            sag->bend[k] += most.bend[k];
    }
    if ((sag->n_power > 1 && sag->base != RMAP_SAG_TOROID) || sag->n_qcon > 0) {
        take(sag, QCON | (sag->base != RMAP_SAG_TOROID ? POWERS : 0), &part);
        const struct most most =
            most_of(&part, ray, greater(sag->n_power, 2 * sag->n_qcon + 2), 1, false);
        add_round_bend(sag, rmap_max(most.bend[0], most.bend[2]));
    }
    if (sag->n_qbfs > 0) { /* F W with W of rmap_sag_profile, and dW/dr = c^2 r W / (a b) */
        const double c2 = sag->curvature[0] * sag->curvature[0], r2 = radius * radius;
        const double of[2] = {sag->conic[0] * c2, (1 + sag->conic[0]) * c2};
        const double a = 1 - rmap_max(of[0], 0) * r2, b = 1 - rmap_max(of[1], 0) * r2;
        const double over = sqrt((1 - of[0] * r2) / (1 - of[1] * r2)), rate = c2 / (a * b);
        take(sag, QBFS, &part);
        const struct most most = most_of(&part, ray, 2 * sag->n_qbfs + 2, 1, false);
        add_round_bend(
            sag,
            over * (rmap_max(most.bend[0], most.bend[2]) + 2 * most.slope * radius * rate +
                    most.z * rate * (1 + r2 * (rate + 2 * fabs(of[0]) / a + 2 * fabs(of[1]) / b))));
    }
}

static double bend_of_biconic(const struct rmap_sag *sag, const double most[2])
{
    double a[2], least = 1, slope = 0, steep = 0, n = 0;
    const double *c = sag->curvature;
    for (int k = 0; k < 2; k++) {
        a[k] = (1 + sag->conic[k]) * c[k] * c[k];
        least -= rmap_max(a[k], 0) * most[k] * most[k];
        slope = hypot(slope, 2 * c[k] * most[k]);
        steep = hypot(steep, a[k] * most[k]);
        n += fabs(c[k]) * most[k] * most[k];
    }
    const double root = sqrt(least), over = 1 / (1 + root);
    const double turn = rmap_max(fabs(a[0]), fabs(a[1])) / root + steep * steep / (root * least);
    steep /= root;
    return over * (2 * rmap_max(fabs(c[0]), fabs(c[1])) +
                   over * (2 * slope * steep + n * turn + 2 * n * steep * steep * over));
}

/* zz of a conic of curvature c at this distance from its middle, and no further out; its slope. */
static double conic_bend(double c, double k, double r, double *slope)
{
    const double under = 1 - (1 + k) * c * c * r * r, root = sqrt(under);
    *slope = fabs(c) * r / root;
    return under < 1 ? fabs(c) / (root * under) : fabs(c);
}

/* False: it turns through its axis. */
static bool add_toroid(struct rmap_sag *sag, const double most[2])
{
    struct rmap_sag part;
    double slope = 0, bend = conic_bend(sag->curvature[1], sag->conic[1], most[1], &slope), z;
    const double line[2] = {-most[1], most[1]}, c = fabs(sag->curvature[0]);
    take(sag, POWERS, &part);
    part.base = RMAP_SAG_TOROID;
    part.power[0] = sag->n_power > 0 ? sag->power[0] : 0;
    const struct most sums = most_of(&part, line, sag->n_power, 1, true);
    part.n_power = 0;
    part.curvature[1] = sag->curvature[1];
    part.conic[1] = sag->conic[1];
    z = fabs(rmap_sag_profile(&part, 0, most[1]).z) + sums.z;
    slope += sums.slope;
    bend += sums.bend[2];
    const double q = 1 + c * z, least = 1 - c * z,
                 square = least * least - c * c * most[0] * most[0];
    if (!(least > 0 && square > LEAST_ROOT))
        return false;
    const double root = sqrt(square), cube = root * square;
    sag->bend[0] += c * q * q / cube;
    sag->bend[1] += c * c * most[0] * q * slope / cube;
    sag->bend[2] += bend * q / root + c * c * c * slope * slope * most[0] * most[0] / cube;
    return true;
}

/* A Zernike polynomial of peak 1 has no more at u: Chebyshev's growth. */
static double growth(double u, int degree)
{
    double product = 1;
    for (int k = 0; u > 1 && k < degree; k++)
        product *= u + sqrt(u * u - 1);
    return product;
}

static double noise_of(const struct rmap_sag *sag, double radius)
{
    double sum = 0, power = 1;
    for (int i = 0; i < sag->n_power; i++)
        sum += fabs(sag->power[i]) * (power *= radius);
    power = 1;
    for (int n = 0; n < sag->n_xy; n++, power *= radius / sag->xy_norm)
        for (int k = 0; k <= n; k++)
            sum += fabs(sag->xy[rmap_sag_term(n, k)]) * power;
    for (int n = 0; n < sag->n_zernike; n++)
        for (int k = 0; k <= n; k++)
            sum += fabs(sag->zernike[rmap_sag_term(n, k)]) * growth(radius / sag->zernike_norm, n);
    for (int k = 0; k < sag->n_qcon; k++)
        sum += fabs(sag->qcon[k]) * growth(radius / sag->qcon_norm, 2 * k + 4);
    for (int k = 0; k < sag->n_qbfs; k++)
        sum += 4 * fabs(sag->qbfs_sum[k]) * growth(radius / sag->qbfs_norm, 2 * k + 4);
    return 16 * DBL_EPSILON * sum;
}

/* By values on a chart, each good for what lies around it; of a CONIC's base by its end. */
static void set_range(struct rmap_sag *sag, const struct rmap_aperture *aperture)
{
    enum { AROUND_RIM = 64, TO_MIDDLE = 32 };
    const double reach = 0.08 * rmap_max(aperture->half[0], aperture->half[1]);
    const double far = rmap_aperture_far(aperture) * BEYOND;
    struct rmap_aperture whole = *aperture;
    struct rmap_sag base = {
        .base = sag->base, .curvature = {sag->curvature[0]}, .conic = {sag->conic[0]}};
    const double bend = rmap_max(sag->bend[0], sag->bend[2]) + sag->bend[1];
    const bool apart = sag->base == RMAP_SAG_CONIC;
    const double end = apart ? rmap_sag_profile(&base, far, 0).z : 0;
    whole.inner = 0;
    sag->low = INFINITY;
    sag->high = -INFINITY;
    for (int i = 0; i < AROUND_RIM * (TO_MIDDLE + 1); i++) {
        const struct rmap_vec3 p = rmap_aperture_chart(
            &whole, (double)(i % AROUND_RIM) / AROUND_RIM, (double)(i / AROUND_RIM) / TO_MIDDLE);
        struct rmap_height at = rmap_sag_profile(sag, p.x, p.y);
        if (apart) {
            const struct rmap_height less = rmap_sag_profile(&base, p.x, p.y);
            at = (struct rmap_height){at.z - less.z, at.x - less.x, at.y - less.y};
        }
        const double more = reach * (hypot(at.x, at.y) + 0.5 * reach * bend +
                                     (sag->n_power > 0 ? 2 * fabs(sag->power[0]) : 0));
        sag->low = rmap_min(sag->low, at.z - more);
        sag->high = rmap_max(sag->high, at.z + more);
    }
    sag->low += rmap_min(end, 0) - sag->noise - 8 * DBL_EPSILON * fabs(end);
    sag->high += rmap_max(end, 0) + sag->noise + 8 * DBL_EPSILON * fabs(end);
    if (sag->fresnel)
        sag->low = sag->high = 0;
}

/* Forbes 2010, equations (B.1) to (B.10): sum a_m Q_m as a sum over P_m. */
static void set_qbfs(struct rmap_sag *sag)
{
    double f[RMAP_SAG_Q], g[RMAP_SAG_Q], h[RMAP_SAG_Q];
    f[0] = 2;
    f[1] = sqrt(19) / 2;
    g[0] = -0.5;
    for (int m = 2; m < RMAP_SAG_Q; m++) {
        h[m - 2] = -m * (m - 1) / (2 * f[m - 2]);
        g[m - 1] = -(1 + g[m - 2] * h[m - 2]) / f[m - 1];
        f[m] = sqrt(m * (m + 1) + 3 - g[m - 1] * g[m - 1] - h[m - 2] * h[m - 2]);
    }
    for (int m = sag->n_qbfs; m-- > 0;) {
        double rest = sag->qbfs[m];
        if (m + 1 < sag->n_qbfs)
            rest -= g[m] * sag->qbfs_sum[m + 1];
        if (m + 2 < sag->n_qbfs)
            rest -= h[m] * sag->qbfs_sum[m + 2];
        sag->qbfs_sum[m] = rest / f[m];
    }
}

static bool all_finite(const double *value, int n)
{
    bool finite = true;
    for (int i = 0; i < n; i++)
        finite &= isfinite(value[i]) != 0;
    return finite;
}

static const char *check_numbers(const struct rmap_sag *sag)
{
    if (!all_finite(sag->curvature, 2))
        return "curvature must be finite (radius must not be tiny)";
    if (!all_finite(sag->conic, 2))
        return "conic must be finite";
    if (!all_finite(sag->power, RMAP_SAG_POWERS) || !all_finite(sag->xy, RMAP_SAG_TERMS) ||
        !all_finite(sag->zernike, RMAP_SAG_TERMS) || !all_finite(sag->qcon, RMAP_SAG_Q) ||
        !all_finite(sag->qbfs, RMAP_SAG_Q))
        return "coefficients must be finite";
    const double norm[] = {sag->n_xy ? sag->xy_norm : 1, sag->n_zernike ? sag->zernike_norm : 1,
                           sag->n_qcon ? sag->qcon_norm : 1, sag->n_qbfs ? sag->qbfs_norm : 1};
    for (int k = 0; k < 4; k++)
        if (!(norm[k] > 0 && isfinite(norm[k])))
            return "norm must be > 0 and finite";
    if (sag->n_qbfs > 0 && sag->base != RMAP_SAG_CONIC)
        return "qbfs stands on one radius, no biconic or toroid";
    return NULL;
}

/* Has the base a value, and a slope, up to the rim? */
static const char *check_base(const struct rmap_sag *sag, double far, const double most[2])
{
    const double *c = sag->curvature, *k = sag->conic;
    const double x = (1 + k[0]) * c[0] * c[0] * most[0] * most[0],
                 y = (1 + k[1]) * c[1] * c[1] * most[1] * most[1];
    switch (sag->base) {
    case RMAP_SAG_CONIC:
        if (1 - (1 + k[0]) * c[0] * c[0] * far * far < LEAST_ROOT)
            return "aperture reaches to the end of the conic: (1 + conic) (aperture / radius)^2 "
                   "must be below 1";
        break;
    case RMAP_SAG_BICONIC:
        if (1 - rmap_max(x, 0) - rmap_max(y, 0) < LEAST_ROOT)
            return "aperture reaches to the end of the biconic: the sum of (1 + conic) (x or y / "
                   "radius)^2 must be below 1 within its box";
        break;
    case RMAP_SAG_TOROID:
        if (1 - y < LEAST_ROOT)
            return "aperture reaches to the end of the profile: (1 + conic) (y / radius)^2 must be "
                   "below 1";
        break;
    }
    if (sag->n_qbfs > 0 && 1 - k[0] * c[0] * c[0] * far * far < LEAST_ROOT)
        return "qbfs ends where conic (aperture / radius)^2 is 1";
    return NULL;
}

const char *rmap_sag_finish(struct rmap_sag *sag, const struct rmap_aperture *aperture)
{
    const double far = rmap_aperture_far(aperture) * BEYOND;
    const double most[2] = {(fabs(aperture->at[0]) + aperture->half[0]) * BEYOND,
                            (fabs(aperture->at[1]) + aperture->half[1]) * BEYOND};
    const char *wrong = check_numbers(sag);
    if (!wrong)
        wrong = check_base(sag, far, most);
    if (wrong)
        return wrong;
    set_qbfs(sag);
    sag->far = far;
    sag->noise = noise_of(sag, far);
    sag->flat = sag->fresnel || rmap_sag_is_plane(sag);
    for (int k = 0; k < 3; k++)
        sag->bend[k] = 0;
    add_sums(sag, far);
    if (sag->base == RMAP_SAG_BICONIC)
        add_round_bend(sag, bend_of_biconic(sag, most));
    if (sag->base == RMAP_SAG_TOROID && !add_toroid(sag, most))
        return "aperture reaches to where the toroid turns back: |x| must be less than the "
               "toroid's "
               "radius less its profile";
    set_range(sag, aperture);
    return all_finite(sag->bend, 3) && isfinite(sag->low) && isfinite(sag->high)
               ? NULL
               : "the sag is not finite";
}

/* Slopes along x (or y) over that of a step that way: of what is odd in it, so that terms as x^2 in
 * the slope fall out; and terms in |x| fall out of the difference of two steps. */
static void second_derivatives(const struct rmap_sag *sag, double step, bool y, double of[2])
{
    const double x = y ? 0 : step, other = y ? step : 0;
    const struct rmap_height ahead = rmap_sag_profile(sag, x, other),
                             behind = rmap_sag_profile(sag, -x, -other);
    of[0] = (ahead.x - behind.x) / (2 * step);
    of[1] = (ahead.y - behind.y) / (2 * step);
}

bool rmap_sag_vertex(const struct rmap_sag *sag, double curvature[3])
{
    const double r = STEP * sag->far, level = 1e-12;
    const struct rmap_height vertex = rmap_sag_profile(sag, 0, 0);
    double far[2][2], near[2][2];
    for (int k = 0; k < 2; k++) {
        second_derivatives(sag, r, k == 1, far[k]);
        second_derivatives(sag, 0.5 * r, k == 1, near[k]);
    }
    for (int k = 0; k < 3; k++)
        curvature[k] = 2 * near[k > 1][k > 0] - far[k > 1][k > 0];
    return fabs(vertex.x) <= level && fabs(vertex.y) <= level &&
           !(sag->n_power > 0 && sag->power[0] != 0);
}

double rmap_sag_bend(const struct rmap_sag *sag, struct rmap_vec3 d, double least, double near,
                     double far)
{
    double bend = sag->bend[0] * d.x * d.x + 2 * sag->bend[1] * fabs(d.x * d.y) +
                  sag->bend[2] * d.y * d.y,
           round = 0;
    if (sag->base == RMAP_SAG_CONIC && sag->curvature[0] != 0) {
        const double c = sag->curvature[0], a = (1 + sag->conic[0]) * c * c;
        const double under = 1 - a * (a > 0 ? far : near), root = sqrt(under);
        if (!(under > 0))
            return INFINITY;
        round = a > 0 ? fabs(c) / (root * under) : fabs(c) / root;
    }
    if (sag->n_power > 0 && sag->power[0] != 0 && sag->base != RMAP_SAG_TOROID && least > 0)
        round += fabs(sag->power[0]) * least / (near * sqrt(near));
    return bend + round * (d.x * d.x + d.y * d.y);
}
