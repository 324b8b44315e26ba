/* SPDX-License-Identifier: MIT
 *
 * Lamp makers' files: IES LM-63 and EULUMDAT. What they say of the intensity, and of the luminous
 * opening, in one form.
 *
 * The lamp's frame: gamma 0 is +z (down, of a hanging lamp), C 0 is +x, C 90 is -y.
 */
#ifndef RMAP_LAMP_FILE_H
#define RMAP_LAMP_FILE_H

#include <stddef.h>
#include <stdio.h>

#include "base/status.h"
#include "scene/lamp.h"

/* Of lamps in a EULUMDAT file; of gamma, and planes C, in one that is written. */
enum { RMAP_LAMP_SETS_MAX = 20, RMAP_LAMP_STEPS_MAX = 720 };

/* What the user chooses of a file. */
struct rmap_lamp_choice {
    size_t set;      /* of lamps, from 1; 0: the first */
    double tilt_deg; /* of the luminaire, 0 as it was measured; IES may say how its lamps take it */
};

enum rmap_lamp_format { RMAP_LAMP_IES, RMAP_LAMP_EULUMDAT };

/* Intensity on a grid of angles about an axis: linear in both angles between them, periodic around,
 * none beyond the first and the last polar angle. Symmetries of the file are written out. */
struct rmap_lamp_file {
    size_t n_around, n_polar;
    double *around_deg; /* [n_around] ascending, 0 <= a < 360; one: the same all around */
    double *polar_deg;  /* [n_polar] ascending, 0 <= p <= 180, two at least */
    double *candela;    /* [n_around][n_polar], of the whole lamp, all factors applied, >= 0 */
    /* Unit vectors of the lamp's frame: around 0 and polar 90; around 90 and polar 90; polar 0.
     * Type C: (1, 0, 0), (0, -1, 0), (0, 0, 1). */
    double axis[3][3];
    enum rmap_lamp_body body;
    int along;        /* 0 to 2: axis of a cylinder */
    double size_m[3]; /* of the body along x (C 0), y and z; 0: flat, or a line */
    double side_m[2]; /* of a box: heights of what looks along x, and along y */
    char title[128];  /* maker and luminaire, for people; may be "" */
};

/* Numbers are read in the calling thread's locale, which has a point. RMAP_INPUT with the line and
 * what is wrong there; *file is the caller's to finish in any case. The text ends with a NUL behind
 * nbytes. */
enum rmap_status rmap_lamp_file_read(const char *text, size_t nbytes, enum rmap_lamp_format format,
                                     const struct rmap_lamp_choice *choice,
                                     struct rmap_lamp_file *file,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_lamp_file_fini(struct rmap_lamp_file *file);

/* What a file says besides. */
struct rmap_lamp_words {
    const char *title;      /* UTF-8; what is not ASCII becomes '?' */
    double lumens, down_lm; /* of the luminaire, and below the horizon */
};

/* Absolute photometry of type C, of a point, without a symmetry but that of one plane: angles
 * around and their candelas are written as they stand, axis and body are not looked at. Errors of
 * `out` are its owner's to find. */
void rmap_lamp_file_write(const struct rmap_lamp_file *file, enum rmap_lamp_format format,
                          const struct rmap_lamp_words *words, FILE *out);

#endif
