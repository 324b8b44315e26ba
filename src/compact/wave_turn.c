/* SPDX-License-Identifier: MIT
 *
 * The turns of step.h for a pack of rays.
 */
#include "base/wide.h"
#include "compact/wave_random.h"

/* sx, sy, sz: normals towards the light. */
RMAP_COPIED void reflect(const double sx[W], const double sy[W], const double sz[W],
                         struct rmap_wave_pack *p)
{
    EACH
    {
        set_lane(rmap_reflected(lane_of(p->dx, p->dy, p->dz, i), lane_of(sx, sy, sz, i)), i, p->dx,
                 p->dy, p->dz);
    }
}

RMAP_COPIED void refract(const double sx[W], const double sy[W], const double sz[W],
                         struct rmap_wave_pack *p)
{
    EACH
    {
        double total;
        set_lane(rmap_refracted(lane_of(p->dx, p->dy, p->dz, i), lane_of(sx, sy, sz, i), p->n1[i],
                                p->n2[i], &total),
                 i, p->dx, p->dy, p->dz);
        p->odd[i] = p->odd[i] + total;
    }
}

RMAP_COPIED void diffuse(const double sx[W], const double sy[W], const double sz[W], uint64_t seed,
                         struct rmap_wave_pack *p)
{
    double u[W], v[W];
    rmap_wave_draw(seed, p->random);
    uniform(p->random[2], u);
    uniform(p->random[3], v);
    EACH
    {
        double turn = p->through[i] > 0.0 ? -1.0 : 1.0;
        set_lane(rmap_diffused(rmap_scale(lane_of(sx, sy, sz, i), turn), u[i], v[i]), i, p->dx,
                 p->dy, p->dz);
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
