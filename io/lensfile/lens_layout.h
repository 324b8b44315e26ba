/* SPDX-License-Identifier: MIT
 *
 * Where the surfaces of a prescription stand, how large they are, and which of them make a lens.
 *
 * The world's frame is that of surface 1. Light meets surfaces in their order, but things stand in
 * space: what light meets twice is there once, and what is no surface at all is not there.
 */
#ifndef RMAP_LENS_LAYOUT_H
#define RMAP_LENS_LAYOUT_H

#include "geometry/sag.h"
#include "io/lensfile/lens_media.h"

/* First-order numbers at the primary wavelength, along the axis, tilts not looked at. Infinite
 * where the lens is afocal. Lengths in the file's unit. */
struct rmap_first_order {
    double focal_length, back_focus;    /* the latter from the last surface with power */
    double entrance, entrance_diameter; /* pupil, from surface 1 */
    double f_number;                    /* focal length by the pupil's diameter */
    double across[2]; /* focal length and back focus in x, where they are others than those in y, of
                         which all else is; else NaN */
    double object;    /* of the object before surface 1, > 0; infinite: a star */
    double magnification; /* of a near object */
    size_t last;          /* index of the last surface that is not the image or a break */
};

enum rmap_lens_role {
    RMAP_ROLE_NOTHING, /* a break, the object, or a surface that does nothing */
    RMAP_ROLE_REFRACTS,
    RMAP_ROLE_MIRROR,
    RMAP_ROLE_HOLE,  /* a stop or an aperture in one medium */
    RMAP_ROLE_AGAIN, /* of `again` */
    RMAP_ROLE_IMAGE
};

struct rmap_lens_place {
    struct rmap_affine to_world;
    struct rmap_shape shape; /* its aperture is not that of the surface */
    struct rmap_sag *sag;    /* of a shape that is no conic; NULL: none, or the shape stands in */
    double vertex[2];        /* curvature along x and y */
    enum rmap_lens_role role;
    bool backwards; /* light comes along its -z */
    size_t again;
    double semi;   /* of what stands there; > 0 unless nothing does */
    bool computed; /* by rays, as the file does not say it */
    double hole;   /* of a mirror, for light that comes back through it; 0: none */
    bool spot;     /* a mirror that is laid on a refracting surface: it stands before it */
};

enum rmap_lens_element_kind {
    RMAP_ELEMENT_LENS,
    RMAP_ELEMENT_SURFACE,
    RMAP_ELEMENT_PLATE,       /* with a hole, the aperture */
    RMAP_ELEMENT_OBSCURATION, /* before a surface, with its shape */
    RMAP_ELEMENT_SPIDER,
    RMAP_ELEMENT_EDGE, /* between the rims of two rows that stand alone */
    RMAP_ELEMENT_BORE  /* between their holes */
};

/* Rows of a lens in the order of their z, or a surface that stands alone. */
struct rmap_element_row {
    size_t surface; /* index */
    double z;       /* in the frame of the element */
    size_t medium;  /* behind it along z */
};

struct rmap_lens_element {
    enum rmap_lens_element_kind kind;
    char name[48];
    size_t first, n; /* rows; EDGE and BORE go from the first to the last */
    double gap;      /* of EDGE and BORE, between the vertices */
    struct rmap_affine to_world;
    size_t before; /* medium before its first row, of SURFACE and LENS */
};

struct rmap_lens_plan {
    struct rmap_prescription *lens; /* borrowed */
    struct rmap_lens_media media;
    struct rmap_first_order order;
    struct rmap_lens_place *place; /* [lens->n_surface] */
    struct rmap_element_row *row;
    size_t n_row;
    struct rmap_lens_element *element;
    size_t n_element;
    double aim[RMAP_PRESCRIPTION_FIELDS_MAX + 1][2]; /* each field's and the axis's centre in the
                                                        entrance pupil, beside its own where the
                                                        lens is decentred */
    double image_half;                               /* of the detector's side */
    struct {
        size_t surface; /* the first in the file's order; 0: none */
        double by;
    } crossing;    /* rows of a lens that cross wherever they are cut */
    double widest; /* semi-diameter that the file gives or its pupil has */
};

/* RMAP_INPUT: nothing would stand there; RMAP_SYSTEM. *plan is the caller's to finish in any
 * case. */
enum rmap_status rmap_lens_plan_make(struct rmap_prescription *lens, struct rmap_lens_plan *plan,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_lens_plan_fini(struct rmap_lens_plan *plan);

/* An opening that is no circle about the vertex. */
bool rmap_lens_is_outline(const struct rmap_lens_opening *opening);

/* Steps of it. */
void rmap_lens_first_order(struct rmap_lens_plan *plan);
void rmap_lens_footprints(struct rmap_lens_plan *plan);
void rmap_lens_elements(struct rmap_lens_plan *plan);

/* The ray that a field's beam is about: the object's angles (of a star) as tangents, or its place
 * beside the axis (of a near object), x and y. */
void rmap_lens_field_at(const struct rmap_lens_plan *plan, const struct rmap_lens_field *field,
                        double xy[2]);

/* Fills shapes and curvatures of all places. RMAP_SYSTEM. */
enum rmap_status rmap_lens_shapes(struct rmap_lens_plan *plan,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* It looks alike from all sides. */
bool rmap_lens_is_revolved(const struct rmap_lens_surface *surface);

/* A surface's conic with its even powers, as wide as that. */
struct rmap_shape rmap_lens_shape(const struct rmap_lens_surface *surface, double semi);

/* The widest that a conic has a surface for. */
double rmap_lens_reach(const struct rmap_lens_surface *surface);

#endif
