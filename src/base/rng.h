/* SPDX-License-Identifier: MIT
 *
 * Random numbers that are a pure function of (seed, ray id, step, slot): Philox4x32-10
 * (Salmon et al. 2011, doi:10.1145/2063384.2063405), key = seed, counter = (ray id 64 bits,
 * step 32, slot 32). Never of a rank, a thread or the clock.
 */
#ifndef RMAP_RNG_H
#define RMAP_RNG_H

#include <stdint.h>

/* One slot per purpose; the enum makes streams distinct by construction. */
#define RMAP_RNG_SLOT_TABLE(X)                                                                     \
    X(EMIT_POINT)     /* where on the source; which triangle */                                    \
    X(EMIT_DIRECTION) /* direction of emission */                                                  \
    X(SURFACE)        /* outcome at a surface; wavelength; two for the direction */                \
    X(MEDIUM)  /* channel and free path in a turbid medium; which of both; wavelength of a segment \
                */                                                                                 \
    X(SCATTER) /* direction after scattering inside a medium */                                    \
    X(CAMERA)  /* place in the pixel and on the lens */                                            \
    X(LIGHT)   /* which light, and where on it */                                                  \
    X(NOISE)   /* permutations of noise fields; the key is the field's own seed */                 \
    X(ANYWHERE)      /* which paths of pictures take any direction, and which */                   \
    X(SPECIES)       /* what absorbed inside a medium, if it gives back, channel, delay */         \
    X(WAVELENGTH)    /* of a ray that has one from its beginning */                                \
    X(PHOTON_NUMBER) /* of a step; the key is the source's own seed */                             \
    X(PARAMETER) /* of a sweep; in the place of the ray stands the sample, of the step the try */

enum rmap_rng_slot {
#define RMAP_RNG_ENUM(symbol) RMAP_RNG_##symbol,
    RMAP_RNG_SLOT_TABLE(RMAP_RNG_ENUM)
#undef RMAP_RNG_ENUM
        RMAP_RNG_SLOT_COUNT,
    RMAP_RNG_LOBE = 1024,       /* and those above: tries at a direction of a scatter model */
    RMAP_RNG_VOLUME = 65536,    /* and those above: tries at a place in a body */
    RMAP_RNG_READING = 1 << 29, /* and those above, eight per detector: what its reading makes of an
                                   event; in the place of the ray stands the event */
    RMAP_RNG_DETECT = 1 << 30 /* and those above, one per detector: whether light that it registers
                                 is detected; the step is the segment's */
};

/* Whose random numbers: of step `step` of ray `ray`. */
struct rmap_draw {
    uint64_t seed, ray;
    uint32_t step;
};

/* Four numbers in (0, 1), multiples of 2^-32 shifted by half of it: neither 0 nor 1 occurs. */
void rmap_rng(uint64_t seed, uint64_t ray, uint32_t step, enum rmap_rng_slot slot,
              double uniform[4]);

#endif
