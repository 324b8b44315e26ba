/* SPDX-License-Identifier: MIT
 *
 * Measured BSDFs from files (docs/scene.md): our own CSV, Zemax's tabular BSDF and WINDOW's XML of
 * Klems matrices.
 */
#ifndef RMAP_SCENE_TABLES_H
#define RMAP_SCENE_TABLES_H

#include "optics/spectrum.h"
#include "scatter/table.h"

/* Which part of a file is asked for. */
struct rmap_bsdf_wanted {
    const struct rmap_channels *channels;
    bool passes; /* BTDF */
    bool solar;  /* Klems: of the Solar band, not the Visible one */
};

/* text: [nbytes], with a 0 behind it. RMAP_INPUT with the line, what is wrong there and the remedy;
 * the text does not name the file. */
enum rmap_status rmap_bsdf_csv_read(const char *text, size_t nbytes,
                                    const struct rmap_bsdf_wanted *wanted,
                                    struct rmap_scatter_table **table_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bsdf_zemax_read(const char *text, size_t nbytes,
                                      const struct rmap_bsdf_wanted *wanted,
                                      struct rmap_scatter_table **table_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bsdf_klems_read(const char *text, size_t nbytes,
                                      const struct rmap_bsdf_wanted *wanted,
                                      struct rmap_scatter_table **table_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
