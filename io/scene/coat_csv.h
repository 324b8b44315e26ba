/* SPDX-License-Identifier: MIT
 *
 * Measured reflectance and transmittance of a coat, from a CSV file (docs/scene.md).
 */
#ifndef RMAP_COAT_CSV_H
#define RMAP_COAT_CSV_H

#include "scene/scene.h"

/* Sets what is measured of a film, rmap_free. text: [nbytes], with a 0 behind it. RMAP_INPUT with
 * the line; the text does not name the file. */
enum rmap_status rmap_coat_csv_read(const char *text, size_t nbytes,
                                    const struct rmap_channels *channels,
                                    struct rmap_thin_film *film,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
