/* SPDX-License-Identifier: MIT
 *
 * First-order properties of a lens: a group of refracting surfaces on one axis, its own or those of
 * groups in it, from their lower to their upper vertex along it; where they are not round, in the
 * two planes of symmetry that they share.
 *
 * y-nu trace as matrices: W. T. Welford, Aberrations of Optical Systems (1986), sections 3.3 to 3.6
 * and 3.11: refraction n'u' = n u - y c (n' - n), transfer y' = y + d u; f' = -n'/C of the system
 * matrix ((A, B), (C, D)) that acts on (y, n u).
 */
#ifndef RMAP_PARAXIAL_H
#define RMAP_PARAXIAL_H

#include "scene/scene.h"

/* Lengths in the scene's unit, along the axis in which light goes to the upper vertex. Infinite
 * where a lens is afocal, or telecentric. */
struct rmap_paraxial {
    size_t n_surface;
    double index[2];     /* before and after */
    double focal_length; /* EFL, rear */
    double back_focus;   /* BFL: rear focal point from the last vertex */
    double front_focus;  /* front focal point from the first vertex */
    int32_t stop;        /* object: the stop, or the surface whose rim limits the axial beam */
    double entrance, entrance_diameter; /* pupil, from the first vertex */
    double exit, exit_diameter;         /* from the last vertex */
    double f_number;                    /* EFL / entrance_diameter */
    double field_deg; /* half: the steepest chief ray that goes through all apertures */
};

/* On a channel of the scene, in the plane of the axis and x of the first surface's frame, and in
 * that of y: 1 where both are the same, 2; 0: the group is no such lens (surfaces that are inclined
 * on the axis, or bent between these planes, are none), or has a gradient medium, or too many
 * surfaces. */
int rmap_paraxial_of(const struct rmap_scene *scene, int32_t group, int channel,
                     struct rmap_paraxial paraxial[2]);

#endif
