/* SPDX-License-Identifier: MIT
 *
 * Light from infinitely far away, as a source: radiance over direction, and where it comes into the
 * scene. Every ray carries the same flux: directions are drawn by radiance times the area that is
 * seen from there.
 *
 * The frame of its source: z is the pole of the grid (the zenith of a sky, the middle of the sun);
 * azimuths go from x to y. Its origin is the centre of a sphere about all that is to be lit,
 * shape_size[0] the sphere's radius. In a world whose up is +Z and whose north is +Y, x of a sky is
 * south and y is east.
 */
#ifndef RMAP_SKY_H
#define RMAP_SKY_H

#include <stddef.h>

#include "base/status.h"
#include "base/vec.h"
#include "optics/spectrum.h"

struct rmap_source;

/* A flat opening that light is wanted through, from either side. */
struct rmap_sky_portal {
    struct rmap_vec3 centre, side[2]; /* whole edges */
};

struct rmap_sky {
    size_t n_row, n_around; /* cells, each with the same radiance all over */
    double *edge;           /* [n_row + 1] 1 - cos of the angle to the pole, ascending */
    double *radiance;       /* [n_row][n_around] flux unit / (m2 sr) */
    float *band;            /* [n_row][n_around][3] shares of it that are red, green and blue; NULL:
                               all of it has the source's colour */
    double mix[3][RMAP_CHANNEL_MAX]; /* of a band's light, per channel: up to this channel */
    double *below; /* [n_row][n_around] share of the flux that comes from all cells up to each */
    struct rmap_sky_portal *portal;
    size_t n_portal; /* 0: the whole sphere is lit, by discs across the light */
    char title[80];  /* for people */
};

/* Room for a grid; edges and radiance are the caller's to fill. */
enum rmap_status rmap_sky_init(struct rmap_sky *sky, size_t n_row, size_t n_around, bool coloured,
                               struct rmap_error *err) RMAP_MUST_USE;
void rmap_sky_fini(struct rmap_sky *sky);

/* Edges first..last at even steps of the polar angle, in degrees. */
void rmap_sky_even_rows(struct rmap_sky *sky, size_t first, double from_deg, size_t last,
                        double to_deg);

/* Irradiance of a plane that faces the pole. */
double rmap_sky_irradiance(const struct rmap_sky *sky);

/* Once frame, sphere and portals stand, or are changed: fills `below`. The flux that comes in, of
 * lengths in the unit of the scene: to be multiplied by the square of that in metres. 0: none. */
double rmap_sky_gather(const struct rmap_source *source);

/* A ray of it by numbers in (0, 1): its direction, its start outside of the sphere, and the channel
 * of its light, -1: the source's colour. Light through several portals belongs to the first that it
 * meets; drawn through a later one it starts behind everything, and is lost. */
struct rmap_vec3 rmap_sky_draw(const struct rmap_source *source, const double place[4],
                               const double way[4], struct rmap_vec3 *position, int *channel);

/* Radiance that is seen in a direction, and its colour: [n_channel] shares. */
double rmap_sky_seen(const struct rmap_source *source, struct rmap_vec3 towards, int n_channel,
                     double *colour);

/* What a point sees by two numbers: a direction, and the irradiance of what faces it (per density).
 * Through a portal, where there are any, by four numbers; irradiance 0: nothing. */
struct rmap_sky_look {
    struct rmap_vec3 towards;
    double distance; /* to where rays start */
    double irradiance;
};
void rmap_sky_look(const struct rmap_source *source, struct rmap_vec3 from, const double u[4],
                   int n_channel, double *colour, struct rmap_sky_look *look);

#endif
