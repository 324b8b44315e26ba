/* SPDX-License-Identifier: MIT
 *
 * What surfaces there are: one table, which drives the scene file, criteria, reports and pictures.
 * What happens at one of them is src/trace/interact.c.
 */
#ifndef RMAP_SURFACE_MODEL_H
#define RMAP_SURFACE_MODEL_H

/* How a surface looks where it is drawn. REFRACTING: it lets light through by Fresnel's laws, so
 * that its shares depend on the angle. */
enum rmap_look { RMAP_LOOK_REFRACTING, RMAP_LOOK_MIRROR, RMAP_LOOK_OTHER, RMAP_LOOK_COUNT };

/* Columns: symbol, `type` in a scene file, in sentences, keys beside `type`, look, and what light
 * may meet there beside absorption: letters of path("..."), the commonest first. */
#define RMAP_SURFACE_TABLE(X)                                                                      \
    X(FRESNEL, "fresnel", "a fresnel surface", "coat", RMAP_LOOK_REFRACTING, "TRI")                \
    X(MIRROR, "mirror", "a mirror", "reflectance metal", RMAP_LOOK_MIRROR, "R")                    \
    X(LAMBERT, "lambert", "a lambert surface", "reflectance", RMAP_LOOK_OTHER, "D")                \
    X(ABSORBER, "absorber", "an absorber", "", RMAP_LOOK_OTHER, "")                                \
    X(MIXTURE, "mixture", "a mixture",                                                             \
      "reflect_specular reflect_diffuse transmit_specular transmit_diffuse", RMAP_LOOK_OTHER,      \
      "RDTdI")

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

#endif
