/* SPDX-License-Identifier: MIT
 *
 * What those who write and who read a bundle's bytes agree on.
 */
#ifndef RMAP_BUNDLE_FORMAT_H
#define RMAP_BUNDLE_FORMAT_H

/* It begins with these letters and a digit: how much of this there is. */
#define RMAP_BUNDLE_MAGIC "RMAPBND"
enum rmap_bundle_level {
    RMAP_BUNDLE_PLAIN = 1,
    RMAP_BUNDLE_FIELDS,   /* what fields of gradient media are made of */
    RMAP_BUNDLE_FILES,    /* texts of tables */
    RMAP_BUNDLE_TANGENTS, /* of meshes */
    RMAP_BUNDLE_RAYS,     /* of files */
    RMAP_BUNDLE_SURFACES, /* that faces of meshes lie on */
    RMAP_BUNDLE_UV        /* texture coordinates of meshes */
};

/* Which columns there are, as bits. */
enum {
    RMAP_BUNDLE_RAYS_WIDE = 1,
    RMAP_BUNDLE_RAYS_POWER = 2,
    RMAP_BUNDLE_RAYS_NM = 4,
    RMAP_BUNDLE_RAYS_DELAY = 8,
    RMAP_BUNDLE_RAYS_EVENT = 16,
    RMAP_BUNDLE_RAYS_LM = 32,
    RMAP_BUNDLE_RAYS_STEP = 64,
    RMAP_BUNDLE_RAYS_UNIT = 128 /* from here up the unit of flux; LM has a bit of its own */
};

/* Of a surface that faces lie on. */
enum { RMAP_BUNDLE_SURFACE_NUMBERS = 8 };

#endif
