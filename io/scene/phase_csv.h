/* SPDX-License-Identifier: MIT
 *
 * A measured phase function: rows of wavelength, angle, value.
 */
#ifndef RMAP_PHASE_CSV_H
#define RMAP_PHASE_CSV_H

#include "scene/scene.h"

/* Adds its tables to an empty phase function, which is the caller's to finish. text: [nbytes], with
 * a 0 behind it. RMAP_INPUT with the line; the text does not name the file. */
enum rmap_status rmap_phase_csv_read(const char *text, size_t nbytes,
                                     const struct rmap_channels *channels, struct rmap_phase *phase,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
