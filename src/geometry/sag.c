/* SPDX-License-Identifier: MIT
 *
 * Heights over a plane and their derivatives.
 */
#include "geometry/sag.h"

/* Of c s / (1 + sqrt(1 - (1 + k) c^2 s)): z, and dz/ds in x. */
static struct rmap_height conic(double c, double k, double s)
{
    const double root = sqrt(fmax(0, 1 - (1 + k) * c * c * s));
    return (struct rmap_height){.z = c * s / (1 + root), .x = 0.5 * c / root};
}

static struct rmap_height biconic(const struct rmap_sag *sag, double x, double y)
{
    const double *c = sag->curvature;
    const double ax = (1 + sag->conic[0]) * c[0] * c[0], ay = (1 + sag->conic[1]) * c[1] * c[1];
    const double root = sqrt(fmax(0, 1 - ax * x * x - ay * y * y)), over = 1 / (1 + root);
    const double z = (c[0] * x * x + c[1] * y * y) * over, turn = z * over / root;
    return (struct rmap_height){z, x * (2 * c[0] * over + turn * ax),
                                y * (2 * c[1] * over + turn * ay)};
}

/* sum a_i t^i, and its derivative in x. */
static struct rmap_height powers(const struct rmap_sag *sag, double t)
{
    struct rmap_height sum = {0, 0, 0};
    for (int i = sag->n_power; i-- > 0;) {
        sum.x = sum.x * t + (i + 1) * sag->power[i];
        sum.z = (sum.z + sag->power[i]) * t;
    }
    return sum;
}

static struct rmap_height toroid(const struct rmap_sag *sag, double x, double y)
{
    const double c = sag->curvature[0];
    const struct rmap_height base = conic(sag->curvature[1], sag->conic[1], y * y),
                             more = powers(sag, y);
    const double f = base.z + more.z, slope = 2 * y * base.x + more.x, q = 1 - c * f;
    const double root = sqrt(fmax(0, q * q - c * c * x * x));
    return (struct rmap_height){f + c * x * x / (q + root), c * x / root, slope * q / root};
}

static void add_xy(const struct rmap_sag *sag, double x, double y, struct rmap_height *sum)
{
    const double scale = 1 / sag->xy_norm, u = x * scale, v = y * scale;
    struct rmap_height z = {0, 0, 0};
    for (int j = sag->n_xy; j-- > 0;) {
        double row = 0, slope = 0;
        for (int i = sag->n_xy - j; i-- > 0;) {
            slope = slope * u + row;
            row = row * u + sag->xy[rmap_sag_term(i + j, j)];
        }
        z.y = z.y * v + z.z;
        z.x = z.x * v + slope;
        z.z = z.z * v + row;
    }
    sum->z += z.z;
    sum->x += z.x * scale;
    sum->y += z.y * scale;
}

/* Jacobi polynomials P_k^(0, m)(2 s - 1), one after the other, with derivatives by s: u^m P_k is
 * Zernike's R of degree m + 2 k. */
struct jacobi {
    double p, dp, q, dq; /* of k, and of k - 1 */
};

static struct jacobi jacobi_next(const struct jacobi *at, int m, int k, double s)
{
    const double x = 2 * s - 1;
    if (k == 1)
        return (struct jacobi){1 + 0.5 * (m + 2) * (x - 1), m + 2, at->p, at->dp};
    const double n = 2 * k + m, over = 1 / (2.0 * k * (k + m) * (n - 2));
    const double a = (n - 1) * n * (n - 2) * over, b = (n - 1) * m * m * over,
                 c = 2.0 * (k - 1) * (k + m - 1) * n * over;
    return (struct jacobi){(a * x - b) * at->p - c * at->q,
                           (a * x - b) * at->dp + 2 * a * at->p - c * at->dq, at->p, at->dp};
}

static const struct jacobi jacobi_first = {1, 0, 0, 0};

static void add_zernike(const struct rmap_sag *sag, double x, double y, struct rmap_height *sum)
{
    const double scale = 1 / sag->zernike_norm, u = x * scale, v = y * scale, s = u * u + v * v;
    double c = 1, d = 0, c_before = 0, d_before = 0; /* (u + i v)^m and ^(m - 1) */
    struct rmap_height z = {0, 0, 0};
    for (int m = 0; m < sag->n_zernike; m++) {
        struct jacobi at = jacobi_first;
        double cosine = 0, sine = 0, cosine_rate = 0, sine_rate = 0;
        for (int k = 0, n = m; n < sag->n_zernike; k++, n += 2) {
            at = k > 0 ? jacobi_next(&at, m, k, s) : at;
            const double a = sag->zernike[rmap_sag_term(n, (n + m) / 2)],
                         b = m > 0 ? sag->zernike[rmap_sag_term(n, (n - m) / 2)] : 0;
            cosine += a * at.p;
            sine += b * at.p;
            cosine_rate += a * at.dp;
            sine_rate += b * at.dp;
        }
        const double rate = 2 * (c * cosine_rate + d * sine_rate);
        z.z += c * cosine + d * sine;
        z.x += u * rate + m * (c_before * cosine + d_before * sine);
        z.y += v * rate + m * (c_before * sine - d_before * cosine);
        c_before = c;
        d_before = d;
        c = u * c_before - v * d_before;
        d = v * c_before + u * d_before;
    }
    sum->z += z.z;
    sum->x += z.x * scale;
    sum->y += z.y * scale;
}

/* z, and dz/ds in x, s = u^2 */
static struct rmap_height qcon(const struct rmap_sag *sag, double s)
{
    struct jacobi at = jacobi_first;
    double sum = 0, rate = 0;
    for (int k = 0; k < sag->n_qcon; k++) {
        at = k > 0 ? jacobi_next(&at, 4, k, s) : at;
        sum += sag->qcon[k] * at.p;
        rate += sag->qcon[k] * at.dp;
    }
    return (struct rmap_height){.z = s * s * sum, .x = 2 * s * sum + s * s * rate};
}

/* s (1 - s) sum a_m Q_m(s), by Clenshaw's recurrence over P_m = (2 - 4 s) P_(m-1) - P_(m-2). */
static struct rmap_height qbfs(const struct rmap_sag *sag, double s)
{
    const double x = 2 - 4 * s;
    double a = 0, b = 0, da = 0, db = 0; /* of m + 1 and m + 2 */
    for (int m = sag->n_qbfs; m-- > 0;) {
        const double next = sag->qbfs_sum[m] + x * a - b, rate = x * da - db - 4 * a;
        b = a;
        db = da;
        a = next;
        da = rate;
    }
    const double sum = 2 * (a + b), rate = 2 * (da + db); /* P_0 = 2, P_1 - (2 - 4 s) P_0 = 2 */
    return (struct rmap_height){.z = s * (1 - s) * sum,
                                .x = (1 - 2 * s) * sum + s * (1 - s) * rate};
}

/* A sum over s = (r / norm)^2, times 1 over the cosine of a conic's slope, which is
 * sqrt((1 - k c^2 r^2) / (1 - (1 + k) c^2 r^2)); of a sphere 1 / sqrt(1 - c^2 r^2). */
static void add_round(struct rmap_height part, double norm, double c, double k, double x, double y,
                      struct rmap_height *sum)
{
    const double c2 = c * c, r2 = x * x + y * y;
    const double a = 1 - k * c2 * r2, b = 1 - (1 + k) * c2 * r2,
                 over = sqrt(fmax(0, a) / fmax(0, b));
    const double rate = 2 * over * part.x / (norm * norm) + part.z * c2 * over / (a * b);
    sum->z += part.z * over;
    sum->x += rate * x;
    sum->y += rate * y;
}

struct rmap_height rmap_sag_profile(const struct rmap_sag *sag, double x, double y)
{
    const double s = x * x + y * y;
    struct rmap_height z = {0, 0, 0};
    switch (sag->base) {
    case RMAP_SAG_CONIC:
        z = conic(sag->curvature[0], sag->conic[0], s);
        z = (struct rmap_height){z.z, 2 * x * z.x, 2 * y * z.x};
        break;
    case RMAP_SAG_BICONIC:
        z = biconic(sag, x, y);
        break;
    case RMAP_SAG_TOROID:
        z = toroid(sag, x, y);
        break;
    }
    if (sag->n_power > 0 && sag->base != RMAP_SAG_TOROID) {
        const double r = sqrt(s);
        const struct rmap_height more = powers(sag, r);
        z.z += more.z;
        z.x += r > 0 ? more.x * x / r : 0; /* the tip of a cone has the axis for its normal */
        z.y += r > 0 ? more.x * y / r : 0;
    }
    if (sag->n_xy > 0)
        add_xy(sag, x, y, &z);
    if (sag->n_zernike > 0)
        add_zernike(sag, x, y, &z);
    if (sag->n_qcon > 0)
        add_round(qcon(sag, s / (sag->qcon_norm * sag->qcon_norm)), sag->qcon_norm, 0, 0, x, y, &z);
    if (sag->n_qbfs > 0)
        add_round(qbfs(sag, s / (sag->qbfs_norm * sag->qbfs_norm)), sag->qbfs_norm,
                  sag->curvature[0], sag->conic[0], x, y, &z);
    return z;
}

struct rmap_height rmap_sag_height(const struct rmap_sag *sag, double x, double y)
{
    return sag->fresnel ? (struct rmap_height){0, 0, 0} : rmap_sag_profile(sag, x, y);
}

bool rmap_sag_is_revolved(const struct rmap_sag *sag)
{
    bool revolved = sag->base == RMAP_SAG_CONIC;
    for (int n = 0; n < sag->n_xy; n++)
        for (int k = 0; k <= n; k++)
            revolved &= n == 0 || sag->xy[rmap_sag_term(n, k)] == 0;
    for (int n = 0; n < sag->n_zernike; n++)
        for (int k = 0; k <= n; k++)
            revolved &= 2 * k == n || sag->zernike[rmap_sag_term(n, k)] == 0;
    return revolved;
}

bool rmap_sag_is_plane(const struct rmap_sag *sag)
{
    return sag->curvature[0] == 0 && sag->curvature[1] == 0 && sag->n_power == 0 &&
           sag->n_xy == 0 && sag->n_zernike == 0 && sag->n_qcon == 0 && sag->n_qbfs == 0;
}

static int noll_degree(int number, int *place)
{
    int n = 0;
    while (number > (n + 1) * (n + 2) / 2)
        n++;
    *place = number - n * (n + 1) / 2;
    return n;
}

bool rmap_zernike_term(enum rmap_zernike_order order, int number, int *n, int *m, double *norm)
{
    int place = 0, root = 1;
    *n = *m = 0;
    switch (order) {
    case RMAP_ZERNIKE_FRINGE: /* squares are spherical; before them go pairs, of falling m */
        if (number < 1 || number > 37)
            return false;
        while (root * root < number)
            root++;
        *m = (root * root - number + 1) / 2;
        *n = 2 * (root - 1) - *m;
        *m = (root * root - number) % 2 ? -*m : *m;
        if (number == 37) {
            *n = 12;
            *m = 0;
        }
        *norm = 1;
        return true;
    case RMAP_ZERNIKE_NOLL:
        if (number < 1 || number > RMAP_SAG_TERMS)
            return false;
        *n = noll_degree(number, &place);
        *m = *n % 2 ? 2 * ((place - 1) / 2) + 1 : 2 * (place / 2);
        *m = number % 2 ? -*m : *m;
        break;
    case RMAP_ZERNIKE_STANDARD:
        if (number < 0 || number >= RMAP_SAG_TERMS)
            return false;
        *n = noll_degree(number + 1, &place);
        *m = 2 * (place - 1) - *n;
        break;
    }
    *norm = sqrt((*m == 0 ? 1 : 2) * (*n + 1.0));
    return true;
}
