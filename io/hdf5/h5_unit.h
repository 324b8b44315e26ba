/* SPDX-License-Identifier: MIT
 *
 * What a unit means that is written as text.
 */
#ifndef RMAP_H5_UNIT_H
#define RMAP_H5_UNIT_H

/* A physical unit: name, factor to SI, powers of L M T I theta N J (openPMD 1.1.0). */
struct rmap_h5_unit {
    const char *name;
    double si;
    double dimension[7];
};

/* Factor to SI and powers of the seven base quantities of "mm", "W/m2", "cd/m2", "W/(m2 sr)",
 * "cycles/mm", ... `name` is borrowed. Angles and solid angles have no dimension. An unknown word
 * counts as the number 1, and a unit with one as without dimension. */
struct rmap_h5_unit rmap_h5_unit_named(const char *name);

#endif
