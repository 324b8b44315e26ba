/* SPDX-License-Identifier: MIT
 *
 * What lens designers' files say, in one form: surfaces in the order in which light meets them.
 *
 * Readers fill it, first-order numbers (lens_first_order.h) and places (lens_layout.h) are made of
 * it, and lens_scene.h writes it as a scene. Nothing is lost without a word: what a reader does
 * not understand it says in `findings`, with the line of the file, and in the surface's remark.
 */
#ifndef RMAP_PRESCRIPTION_H
#define RMAP_PRESCRIPTION_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "geometry/shape.h"
#include "io/file/diagnostics.h"

enum {
    RMAP_PRESCRIPTION_SURFACES_MAX = 2000,
    RMAP_PRESCRIPTION_FIELDS_MAX = 64,
    RMAP_PRESCRIPTION_WAVELENGTHS_MAX = 64,
    RMAP_PRESCRIPTION_GLASSES_MAX = 5000,
    RMAP_AGF_COEFFICIENTS = 12,
    RMAP_AGF_ROWS = 32,
    RMAP_LENS_POWER_MAX = 32,
    RMAP_LENS_TERMS_MAX = 256,
    RMAP_LENS_GRADIENT_MAX = 8
};

enum rmap_opening {
    RMAP_OPENING_NONE,
    RMAP_OPENING_CIRCLE,
    RMAP_OPENING_RECTANGLE,
    RMAP_OPENING_ELLIPSE
};

/* A hole that light must go through, or a plate that it must miss. */
struct rmap_lens_opening {
    enum rmap_opening shape;
    double inner, half[2]; /* CIRCLE: half[0] is the radius, inner that of a plate in its middle */
    double centre[2];
};

enum rmap_lens_terms {
    RMAP_TERMS_NONE,
    RMAP_TERMS_FRINGE, /* Zernike, by their numbers */
    RMAP_TERMS_NOLL,
    RMAP_TERMS_XY,
    RMAP_TERMS_QCON, /* Forbes, from 0 */
    RMAP_TERMS_QBFS
};

struct rmap_lens_term {
    int i, j; /* its number and 0; powers of x and y */
    double value;
};

/* What a surface is besides a conic with its asphere. Zeroed: nothing. */
struct rmap_lens_figure {
    bool is_biconic, is_toroid, is_fresnel;
    double curvature_x, conic_x; /* of a biconic */
    double turn; /* of a toroid: about an axis parallel to y; infinite: a cylinder */
    enum rmap_lens_terms terms;
    double norm; /* radius; > 0 where there are terms */
    int n_term;
    struct rmap_lens_term term[RMAP_LENS_TERMS_MAX];
};

struct rmap_lens_surface {
    size_t line;       /* of the file, where it begins */
    size_t glass_line; /* that names its glass, where a configuration does; 0: as above */
    int number;        /* the file's; the object is 0 */
    char comment[80];  /* the file's words for it; UTF-8 */
    char type[24];     /* its word for the shape, "" where that is plain */
    char glass[64];    /* the material behind it; "": none, or that before a mirror */
    char remark[240];  /* what a reader of the scene must know: solves, what was not understood */
    bool is_break;     /* moves the axes and is no surface */
    bool is_mirror, is_stop;
    double curvature, conic, asphere[RMAP_LENS_POWER_MAX + 1]; /* coefficient of r^i */
    int n_asphere;                                             /* highest power, 0: a conic */
    struct rmap_lens_figure figure;
    int gradient; /* of the medium behind it: Zemax's number, 0: none */
    double gradient_value[RMAP_LENS_GRADIENT_MAX];
    double thickness; /* to the next along z, signed; infinite before a star */
    double semi;      /* clear semi-diameter; 0: not said */
    double nd, vd;    /* of a model glass, or what the file says of a named one; 0: nothing */
    bool is_model;    /* nd and vd are the glass */
    struct rmap_lens_opening aperture, obscuration;
    int n_arm; /* of a spider over it */
    double arm_width;
    struct rmap_affine before, after; /* of the axes: to the surface's, and on from there */
};

enum rmap_lens_pupil {
    RMAP_PUPIL_STOP, /* as large as the stop's semi-diameter says */
    RMAP_PUPIL_DIAMETER,
    RMAP_PUPIL_F_NUMBER,         /* focal length by diameter */
    RMAP_PUPIL_WORKING_F_NUMBER, /* of the light that comes to the image */
    RMAP_PUPIL_OBJECT_NA,
    RMAP_PUPIL_IMAGE_NA
};

enum rmap_lens_field_kind {
    RMAP_FIELD_ANGLE,         /* degrees, by tangents in x and y */
    RMAP_FIELD_OBJECT_HEIGHT, /* in the file's unit */
    RMAP_FIELD_IMAGE_HEIGHT,
    RMAP_FIELD_REAL_HEIGHT
};

struct rmap_lens_field {
    double x, y, weight;
    double vx[2], vy[2]; /* shares of the pupil that are cut, at its lower and upper end */
};

/* A glass of a catalogue file. */
struct rmap_agf_glass {
    char name[48], remark[80];
    size_t line;
    int formula; /* 1 to 13, lens_formula.c */
    double coefficient[RMAP_AGF_COEFFICIENTS];
    double nd, vd, from_um, to_um;
    size_t n_row; /* of a table in the place of a formula, formula 0 */
    double row_um[RMAP_AGF_ROWS], row_index[RMAP_AGF_ROWS];
};

struct rmap_prescription {
    const char *format; /* "Zemax", "CODE V", "OSLO" */
    char title[120], version[80], catalogues[200];
    char *notes; /* the file's remarks, lines of UTF-8; NULL: none */
    size_t notes_nbytes, cap_notes;
    const char *unit; /* "mm", "cm", "m", "in" */
    enum rmap_lens_pupil pupil;
    double pupil_value;
    bool
        aims_at_stop; /* rays are aimed at the stop, wherever it is, not at the pupil on the axis */
    enum rmap_lens_field_kind field_kind;
    struct rmap_lens_field field[RMAP_PRESCRIPTION_FIELDS_MAX];
    size_t n_field;
    double wavelength_nm[RMAP_PRESCRIPTION_WAVELENGTHS_MAX];
    double wavelength_weight[RMAP_PRESCRIPTION_WAVELENGTHS_MAX];
    size_t n_wavelength, primary; /* index of the wavelength that stands for all */
    struct rmap_lens_surface
        *surface; /* [n_surface]; the first is the object, the last the image */
    size_t n_surface, cap_surface;
    struct rmap_agf_glass *glass; /* [n_glass] of catalogue files */
    size_t n_glass, cap_glass;
    int configuration; /* the one that was asked for, from 1; 0: the one that is stored */
    int n_configuration;
    int stored; /* from 1 */
    char configuration_name[60];
    double temperature_c, pressure_atm; /* NaN: not said */
    struct rmap_diagnostics *findings;  /* the caller's */
};

enum rmap_lens_format { RMAP_LENS_ZMX, RMAP_LENS_SEQ, RMAP_LENS_OSLO };

/* The format of a name such as "a.ZMX"; false: none is known by it. */
bool rmap_lens_format_of(const char *path, enum rmap_lens_format *format);

/* Reads the text of a lens file, UTF-8, UTF-16 or Latin-1. Numbers are read in the calling thread's
 * locale, which has a point. configuration: from 1; 0: the one that is stored. RMAP_INPUT: it is no
 * such file, or has too many surfaces; *lens is the caller's to finish in any case. */
enum rmap_status rmap_prescription_read(const char *bytes, size_t nbytes,
                                        enum rmap_lens_format format, int configuration,
                                        struct rmap_diagnostics *findings,
                                        struct rmap_prescription *lens,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_prescription_fini(struct rmap_prescription *lens);

/* Adds the glasses of a catalogue file; of two of one name the later counts. RMAP_INPUT with the
 * line, RMAP_SYSTEM. */
enum rmap_status rmap_prescription_read_agf(const char *bytes, size_t nbytes,
                                            struct rmap_prescription *lens,
                                            struct rmap_error *err) RMAP_MUST_USE;

#endif
