/* SPDX-License-Identifier: MIT
 *
 * The turns of step.h for a pack of rays: the same operations in the same order.
 */
#include "compact/wave_random.h"

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

static inline void diffuse(const double sx[W], const double sy[W], const double sz[W],
                           uint64_t seed, struct rmap_wave_pack *p)
{
    double cosine[W], sine[W], u[W], v[W];
    rmap_wave_draw(seed, p->random);
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
