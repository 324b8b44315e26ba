/* SPDX-License-Identifier: MIT
 *
 * Rays into packs and back: four numbers of four rays at a time change rows for columns.
 */
#include "compact/wave_lanes.h"

#include <string.h>

/* x, y, z and normal_xy of four rays. */
static inline void turn_ends(const struct rmap_wave_pack *p, size_t at, words row[4])
{
    words x, y, z, n;
    memcpy(&x, p->position[0] + at, sizeof x);
    memcpy(&y, p->position[1] + at, sizeof y);
    memcpy(&z, p->position[2] + at, sizeof z);
    memcpy(&n, p->normal_xy + at, sizeof n);
    words low0 = MIX4(x, y, 0, 4, 1, 5), high0 = MIX4(x, y, 2, 6, 3, 7);
    words low1 = MIX4(z, n, 0, 4, 1, 5), high1 = MIX4(z, n, 2, 6, 3, 7);
    row[0] = MIX4(low0, low1, 0, 1, 4, 5);
    row[1] = MIX4(low0, low1, 2, 3, 6, 7);
    row[2] = MIX4(high0, high1, 0, 1, 4, 5);
    row[3] = MIX4(high0, high1, 2, 3, 6, 7);
}

static inline void note(const struct rmap_wave_pack *p, const words end[W], const size_t row[W],
                        size_t n, float *position, int16_t *normal)
{
    for (size_t i = 0; position && i < n; i++)
        memcpy(position + 3 * row[i], &end[i], 3 * sizeof *position);
    for (size_t i = 0; normal && i < n; i++) {
        uint32_t xy = end[i][3];
        memcpy(normal + 3 * row[i], &xy, sizeof xy);
        normal[3 * row[i] + 2] = (int16_t)p->normal_z[i];
    }
}

void rmap_wave_note(const struct rmap_wave_pack *p, const size_t row[W], size_t n, float *position,
                    int16_t *normal)
{
    words end[W];
    for (size_t i = 0; i < W; i += 4)
        turn_ends(p, i, end + i);
    if (n == W) /* most: its loops have no branches */
        note(p, end, row, W, position, normal);
    else
        note(p, end, row, n, position, normal);
}

/* The store of a row reaches into the next one. */
void rmap_wave_note_on(const struct rmap_wave_pack *p, const size_t row[W], float *position,
                       int16_t *normal)
{
    words end[W];
    uint64_t three[W];
    for (size_t i = 0; i < W; i += 4) {
        words xy, z;
        turn_ends(p, i, end + i);
        memcpy(&xy, p->normal_xy + i, sizeof xy);
        memcpy(&z, p->normal_z + i, sizeof z);
        words low = MIX4(xy, z, 0, 4, 1, 5), high = MIX4(xy, z, 2, 6, 3, 7);
        memcpy(three + i, &low, sizeof low);
        memcpy(three + i + 2, &high, sizeof high);
    }
    for (size_t i = 0; position && i < W; i++)
        memcpy(position + 3 * row[i], &end[i], sizeof end[i]);
    for (size_t i = 0; normal && i < W; i++)
        memcpy(normal + 3 * row[i], &three[i], sizeof three[i]);
}

WIDE void rmap_wave_load(struct rmap_wave_pack *p)
{
    double unused[2][4];
    for (int i = 0; i < W; i += 4) {
        const double *a = p->ray[i]->state, *b = p->ray[i + 1]->state;
        const double *c = p->ray[i + 2]->state, *d = p->ray[i + 3]->state;
        across(a, b, c, d, p->px + i, p->py + i, p->pz + i, p->dx + i);
        across(a + 4, b + 4, c + 4, d + 4, p->dy + i, p->dz + i, unused[0], unused[1]);
    }
}

WIDE void rmap_wave_store(const struct rmap_wave_pack *p,
                          struct rmap_wave_ray *const to[RMAP_WAVE_WIDTH])
{
    EACH
    {
        const double state[6] = {p->px[i], p->py[i], p->pz[i], p->dx[i], p->dy[i], p->dz[i]};
        memcpy(to[i]->state, state, sizeof state);
        to[i]->leg->way.length = p->t[i];
        to[i]->leg->cosine = p->cosine[i];
    }
}
