/* SPDX-License-Identifier: MIT
 *
 * A refractive index of your own for Raymap: a shared object with one function,
 *
 *     const struct raymap_field *raymap_field(void);
 *
 * named in a scene file as
 *
 *     media:
 *       mine: {gradient: {type: plugin, file: mine.so, parameters: [1.5, 0.02]}}
 *
 * Build it with: cc -std=c17 -O2 -fPIC -shared -o mine.so mine.c -lm (see examples/plugin).
 *
 * Lengths are in the scene's unit, places in the frame of the medium, wavelengths in nm. The
 * functions are called from several threads at once and on several ranks: they must depend on
 * their arguments alone, give the same answer every time, and never exit.
 */
#ifndef RAYMAP_FIELD_H
#define RAYMAP_FIELD_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define RAYMAP_FIELD_ABI 1

#define RAYMAP_FIELD_DISPERSIVE  1u /* the index depends on the channel */
#define RAYMAP_FIELD_NO_GRADIENT 2u /* `at` leaves the gradient to differences */

/* What the scene says. Borrowed: copy what you keep. */
struct raymap_field_setup {
    size_t n_parameter;
    const double *parameter;
    size_t n_channel;
    const double *wavelength_nm; /* [n_channel] */
    double size;                 /* of what the medium fills, about */
};

struct raymap_field {
    uint32_t abi;    /* RAYMAP_FIELD_ABI */
    uint32_t nbytes; /* sizeof(struct raymap_field) */
    uint32_t flags;
    const char *name; /* for reports */

    /* State of one medium: anything, or NULL. Returns 0, or other than 0 with a text (terminated)
     * that says what is wrong with the setup. NULL: no state. */
    int (*create)(const struct raymap_field_setup *setup, void **state_ret, char *text,
                  size_t text_nbytes);

    /* Index and gradient (per length unit) at p on a channel. Returns 0, or other than 0 where
     * there is no index: light ends there with `error`, as it does where the index is not finite
     * or not above 0. */
    int (*at)(const void *state, size_t channel, const double p[3], double *n, double gradient[3]);

    /* Length over which the index may be taken for a polynomial; NULL: `size`. */
    double (*best_step)(const void *state, const double p[3], const double direction[3]);

    void (*destroy)(void *state); /* NULL: nothing to do */
};

const struct raymap_field *raymap_field(void);

#ifdef __cplusplus
}
#endif

#endif
