/* SPDX-License-Identifier: MIT
 *
 * What surfaces there are: one table, which drives the scene file, criteria, reports and pictures,
 * and the numbers that they have.
 * What happens at one of them is src/trace/interact.c.
 */
#ifndef RMAP_SURFACE_MODEL_H
#define RMAP_SURFACE_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "optics/spectrum.h"
#include "optics/thin_film.h"
#include "scatter/scatter.h"

/* How a surface looks where it is drawn. REFRACTING: it lets light through by Fresnel's laws, so
 * that its shares depend on the angle. */
enum rmap_look { RMAP_LOOK_REFRACTING, RMAP_LOOK_MIRROR, RMAP_LOOK_OTHER, RMAP_LOOK_COUNT };

/* Columns: symbol, `type` in a scene file, in sentences, keys beside `type`, look, and what light
 * may meet there beside absorption: letters of path("..."), the commonest first. */
#define RMAP_SURFACE_TABLE(X)                                                                      \
    X(FRESNEL, "fresnel", "a fresnel surface", "coat scatter contamination frame",                 \
      RMAP_LOOK_REFRACTING, "TRI")                                                                 \
    X(MIRROR, "mirror", "a mirror", "reflectance metal coat scatter contamination frame",          \
      RMAP_LOOK_MIRROR, "R")                                                                       \
    X(LAMBERT, "lambert", "a lambert surface", "reflectance", RMAP_LOOK_OTHER, "D")                \
    X(ABSORBER, "absorber", "an absorber", "", RMAP_LOOK_OTHER, "")                                \
    X(MIXTURE, "mixture", "a mixture",                                                             \
      "reflect_specular reflect_diffuse transmit_specular transmit_diffuse", RMAP_LOOK_OTHER,      \
      "RDTdI")                                                                                     \
    X(SCATTER, "scatter", "a scattering surface",                                                  \
      "reflectance specular reflect transmittance transmit_specular transmit contamination "       \
      "frame",                                                                                     \
      RMAP_LOOK_OTHER, "DRdTI")

enum rmap_surface_type {
#define RMAP_SURFACE_ENUM(symbol, name, phrase, keys, look, events) RMAP_SURFACE_##symbol,
    RMAP_SURFACE_TABLE(RMAP_SURFACE_ENUM)
#undef RMAP_SURFACE_ENUM
};

struct rmap_surface_model {
    const char *name, *phrase, *keys;
    enum rmap_look look;
    const char *events;
};

static const struct rmap_surface_model rmap_surface_model[] = {
#define RMAP_SURFACE_ROW(symbol, name, phrase, keys, look, events)                                 \
    {name, phrase, keys, look, events},
    RMAP_SURFACE_TABLE(RMAP_SURFACE_ROW)
#undef RMAP_SURFACE_ROW
};

enum rmap_coat { RMAP_COAT_NONE, RMAP_COAT_REFLECTANCE, RMAP_COAT_IDEAL, RMAP_COAT_FILM };

/* On which side of an object a film's last layer lies: on that whose medium is not the one around
 * the object, or as said. */
enum rmap_substrate { RMAP_SUBSTRATE_INSIDE, RMAP_SUBSTRATE_FRONT, RMAP_SUBSTRATE_BACK };

/* Thin films from the outside towards the substrate; or what they do, measured. */
struct rmap_thin_film {
    char *name;
    enum rmap_substrate substrate;
    size_t n_layer;
    struct rmap_thin_film_layer *layer; /* [channels][n_layer] */
    size_t n_angle;                     /* measured: 0, or so many */
    double *angle; /* [n_angle] of incidence from outside, radians, ascending */
    double *share; /* [channels][n_angle][2]: reflected, passed; linear between them */
};

/* Shares per channel; what is left over is absorbed. FRESNEL: reflect_specular is the coat's
 * reflectance. MIRROR: its reflectance, or metal n, k when is_metal, bare or under films. LAMBERT:
 * reflect_diffuse. Where a surface has a scatter model, that takes its part of what is reflected,
 * or let pass. */
struct rmap_surface {
    char *name;
    enum rmap_surface_type type;
    enum rmap_coat coat;
    bool is_metal;
    int32_t film;                              /* FILM: row of the scene's */
    int32_t scatter_reflect, scatter_transmit; /* 1 + row of the scene's models; 0: none */
    bool reflect_is_total, transmit_is_total;  /* SCATTER: the specular share is what its model
                                                  leaves of it */
    bool frame_uv; /* x of its models is where u grows, not the object's x axis */
    double reflect_specular[RMAP_CHANNEL_MAX];
    double reflect_diffuse[RMAP_CHANNEL_MAX];
    double transmit_specular[RMAP_CHANNEL_MAX];
    double transmit_diffuse[RMAP_CHANNEL_MAX];
    double metal_n[RMAP_CHANNEL_MAX];
    double metal_k[RMAP_CHANNEL_MAX];
};

static inline enum rmap_look rmap_surface_look(const struct rmap_surface *surface)
{
    return rmap_surface_model[surface->type].look;
}

#endif
