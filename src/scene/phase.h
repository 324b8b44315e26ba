/* SPDX-License-Identifier: MIT
 *
 * Phase functions of scattering media: the density of the angle by which light is turned, 1/sr, of
 * unit integral over the sphere.
 */
#ifndef RMAP_PHASE_H
#define RMAP_PHASE_H

#include "optics/suspension.h"
#include "scene/profile.h"

/* Columns: symbol, word. HENYEY is that of a medium's scattering_g (Henyey & Greenstein 1941,
 * doi:10.1086/144246), RAYLEIGH 3 (1 + cos^2) / (16 pi) (Rayleigh 1871,
 * doi:10.1080/14786447108640452), of unpolarised light. */
#define RMAP_PHASE_TABLE_OF_KINDS(X)                                                               \
    X(HENYEY, "henyey_greenstein")                                                                 \
    X(RAYLEIGH, "rayleigh")                                                                        \
    X(TABLE, "table")                                                                              \
    X(MIE, "mie")

enum rmap_phase_kind {
#define RMAP_PHASE_ENUM(symbol, word) RMAP_PHASE_##symbol,
    RMAP_PHASE_TABLE_OF_KINDS(RMAP_PHASE_ENUM)
#undef RMAP_PHASE_ENUM
};
static const char *const rmap_phase_word[] = {
#define RMAP_PHASE_WORD(symbol, word) word,
    RMAP_PHASE_TABLE_OF_KINDS(RMAP_PHASE_WORD)
#undef RMAP_PHASE_WORD
};

struct rmap_phase {
    enum rmap_phase_kind kind;
    size_t n_profile;                 /* 1: the same on all channels, or as many as these */
    struct rmap_profile *profile;     /* [n_profile], TABLE and MIE; owned */
    struct rmap_suspended *suspended; /* [n_profile], MIE, for reports; owned */
};

void rmap_phase_fini(struct rmap_phase *phase);

/* Room for n tables, which are then added one by one. RMAP_SYSTEM. */
enum rmap_status rmap_phase_make_room(struct rmap_phase *phase, size_t n,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* TABLE. Of any unit, value[n] >= 0 at angle_deg[n], increasing from 0 to 180; linear in the angle
 * between them (within knots half a degree apart). RMAP_INPUT: it scatters nothing. */
enum rmap_status rmap_phase_add_table(const double *angle_deg, const double *value, size_t n,
                                      struct rmap_phase *phase,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* MIE. As rmap_suspension_scatter. */
enum rmap_status rmap_phase_add_mie(const struct rmap_suspension *spheres, double wavelength,
                                    double n, double k, struct rmap_phase *phase,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* The table of a channel. */
static inline const struct rmap_profile *rmap_phase_profile(const struct rmap_phase *phase,
                                                            int channel)
{
    return &phase->profile[phase->n_profile > 1 ? channel : 0];
}

/* Mean cosine of a table's angles. */
double rmap_phase_mean_cosine(const struct rmap_profile *profile);

#endif
