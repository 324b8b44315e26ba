/* SPDX-License-Identifier: MIT
 *
 * The turns of step.h for a pack of rays: the same operations in the same order.
 */
#include "compact/wave_lanes.h"

/* sx, sy, sz: normals towards the light. */
static inline void reflect(const double sx[W], const double sy[W], const double sz[W],
                           struct rmap_wave_pack *p)
{
    EACH
    {
        double cosine = p->dx[i] * sx[i] + p->dy[i] * sy[i] + p->dz[i] * sz[i];
        p->dx[i] = p->dx[i] + -2.0 * cosine * sx[i];
        p->dy[i] = p->dy[i] + -2.0 * cosine * sy[i];
        p->dz[i] = p->dz[i] + -2.0 * cosine * sz[i];
    }
    normalise(p->dx, p->dy, p->dz);
}

static inline void refract(const double sx[W], const double sy[W], const double sz[W],
                           struct rmap_wave_pack *p)
{
    EACH
    {
        double dx = p->dx[i], dy = p->dy[i], dz = p->dz[i], ratio = p->n1[i] / p->n2[i];
        double cosine = dx * sx[i] + dy * sy[i] + dz * sz[i];
        double tx = (dx + -cosine * sx[i]) * ratio, ty = (dy + -cosine * sy[i]) * ratio;
        double tz = (dz + -cosine * sz[i]) * ratio;
        double cos2_t = 1.0 - (tx * tx + ty * ty + tz * tz), root = -sqrt(cos2_t);
        double same = p->n1[i] == p->n2[i] ? 1.0 : 0.0;
        p->odd[i] = p->odd[i] + (cos2_t > 0.0 ? 0.0 : 1.0 - same);
        p->dx[i] = same > 0.0 ? dx : tx + root * sx[i];
        p->dy[i] = same > 0.0 ? dy : ty + root * sy[i];
        p->dz[i] = same > 0.0 ? dz : tz + root * sz[i];
    }
}

/* As rmap_azimuth. */
static inline void azimuth(const double turns[W], double cosine[W], double sine[W])
{
    EACH
    {
        int quarter = (int)(4.0 * turns[i] + 0.5);
        double x = 2.0 * RMAP_PI * (turns[i] - 0.25 * (double)quarter), y = x * x, y2 = y * y,
               y4 = y2 * y2;
        double s = ((1.0 - y * (1.0 / 6.0)) + y2 * (1.0 / 120.0 - y * (1.0 / 5040.0))) +
                   y4 * ((1.0 / 362880.0 - y * (1.0 / 39916800.0)) +
                         y2 * (1.0 / 6227020800.0 - y * (1.0 / 1307674368000.0)));
        double c = ((1.0 - y * (1.0 / 2.0)) + y2 * (1.0 / 24.0 - y * (1.0 / 720.0))) +
                   y4 * ((1.0 / 40320.0 - y * (1.0 / 3628800.0)) +
                         y2 * ((1.0 / 479001600.0 - y * (1.0 / 87178291200.0)) +
                               y2 * (1.0 / 20922789888000.0)));
        s *= x;
        double along = quarter & 1 ? -s : c, across = quarter & 1 ? c : s;
        cosine[i] = quarter & 2 ? -along : along;
        sine[i] = quarter & 2 ? -across : across;
    }
}

/* Philox4x32-10 of base/rng.h (Salmon et al. 2011, doi:10.1145/2063384.2063405). */
static inline void draw(uint64_t seed, uint32_t c[4][W])
{
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    for (int round = 0; round < 10; round++) {
        EACH
        {
            uint64_t p0 = (uint64_t)c[0][i] * 0xD2511F53u, p1 = (uint64_t)c[2][i] * 0xCD9E8D57u;
            uint32_t c0 = (uint32_t)(p1 >> 32) ^ c[1][i] ^ key0;
            uint32_t c2 = (uint32_t)(p0 >> 32) ^ c[3][i] ^ key1;
            c[0][i] = c0;
            c[1][i] = (uint32_t)p1;
            c[2][i] = c2;
            c[3][i] = (uint32_t)p0;
        }
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

static inline void uniform(const uint32_t bits[W], double out[W])
{
    EACH
    {
        out[i] = ((double)bits[i] + 0.5) * 0x1p-32;
    }
}

static inline void diffuse(const double sx[W], const double sy[W], const double sz[W],
                           uint64_t seed, struct rmap_wave_pack *p)
{
    double cosine[W], sine[W], u[W], v[W];
    draw(seed, p->random);
    uniform(p->random[2], u);
    uniform(p->random[3], v);
    azimuth(v, cosine, sine);
    EACH
    {
        double turn = p->through[i] > 0.0 ? -1.0 : 1.0;
        double nx = sx[i] * turn, ny = sy[i] * turn, nz = sz[i] * turn;
        double sign = copysign(1.0, nz), a = -1.0 / (sign + nz), b = nx * ny * a;
        double r = sqrt(u[i]), x = r * cosine[i], y = r * sine[i];
        double up = sqrt(1.0 - u[i]);
        p->dx[i] = ((b * y) + x * (1.0 + sign * nx * nx * a)) + up * nx;
        p->dy[i] = (((sign + ny * ny * a) * y) + x * (sign * b)) + up * ny;
        p->dz[i] = ((-ny * y) + x * (-sign * nx)) + up * nz;
    }
}

WIDE void rmap_wave_turn(enum rmap_turn turn, uint64_t seed, struct rmap_wave_pack *pack)
{
    double sx[W], sy[W], sz[W];
    EACH
    {
        double side = pack->cosine[i] < 0.0 ? 1.0 : -1.0;
        sx[i] = pack->nx[i] * side;
        sy[i] = pack->ny[i] * side;
        sz[i] = pack->nz[i] * side;
    }
    if (turn == RMAP_TURN_REFLECT)
        reflect(sx, sy, sz, pack);
    else if (turn == RMAP_TURN_REFRACT)
        refract(sx, sy, sz, pack);
    else
        diffuse(sx, sy, sz, seed, pack);
}
