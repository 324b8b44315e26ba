/* SPDX-License-Identifier: MIT
 *
 * Of reading lens files what does not depend on the format.
 */
#include "io/lensfile/prescription.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/lensfile/lens_plain.h"
#include "io/lensfile/lens_text.h"

bool rmap_lens_format_of(const char *path, enum rmap_lens_format *format)
{
    static const char *const suffix[] = {
        [RMAP_LENS_ZMX] = ".zmx", [RMAP_LENS_SEQ] = ".seq", [RMAP_LENS_OSLO] = ".len"};
    const char *dot = strrchr(path, '.');
    for (int i = 0; dot && i < 3; i++)
        if (strcasecmp(dot, suffix[i]) == 0) {
            *format = (enum rmap_lens_format)i;
            return true;
        }
    return false;
}

/* Each wavelength once. */
static void unite_wavelengths(struct rmap_prescription *lens)
{
    size_t n = 0;
    for (size_t i = 0; i < lens->n_wavelength; i++) {
        size_t k = 0;
        while (k < n && lens->wavelength_nm[k] != lens->wavelength_nm[i])
            k++;
        if (lens->primary == i)
            lens->primary = k;
        if (k < n || !(lens->wavelength_nm[i] > 0))
            continue;
        lens->wavelength_nm[n] = lens->wavelength_nm[i];
        lens->wavelength_weight[n++] = lens->wavelength_weight[i];
    }
    lens->n_wavelength = n;
}

/* What every lens has, in numbers that later steps can rely on. */
static enum rmap_status complete(struct rmap_prescription *lens, struct rmap_error *err)
{
    if (lens->n_surface < 3)
        return rmap_error_set(err, RMAP_INPUT,
                              "%zu surfaces are no lens: an object, a surface and an image are the "
                              "least",
                              lens->n_surface);
    unite_wavelengths(lens);
    if (lens->n_wavelength == 0) {
        lens->wavelength_nm[0] = 587.5618;
        lens->wavelength_weight[0] = 1;
        lens->n_wavelength = 1;
        rmap_lens_lost(lens, 0, NULL, "the file has no wavelength: 587.5618 nm is taken");
    }
    if (lens->primary >= lens->n_wavelength)
        lens->primary = 0;
    if (lens->n_field == 0) {
        lens->field[0] = (struct rmap_lens_field){.weight = 1};
        lens->n_field = 1;
    }
    bool stop = false;
    for (size_t i = 0; i < lens->n_surface; i++) {
        struct rmap_lens_surface *surface = &lens->surface[i];
        if (surface->curvature == 0 && surface->n_asphere == 0 && !isfinite(surface->figure.turn))
            surface->figure.is_toroid = false; /* a plane */
        stop = stop || (surface->is_stop && i > 0 && i + 1 < lens->n_surface);
        if (i > 0 && !isfinite(surface->thickness)) {
            rmap_lens_lost(lens, surface->line, surface, "an infinite thickness is taken as 0");
            surface->thickness = 0;
        }
    }
    rmap_lens_limit(lens);
    for (size_t i = 1; i + 1 < lens->n_surface && !stop; i++)
        if (!lens->surface[i].is_break) {
            lens->surface[i].is_stop = stop = true;
            rmap_lens_lost(lens, lens->surface[i].line, &lens->surface[i],
                           "the file names no stop: this surface is taken");
        }
    return RMAP_OK;
}

enum rmap_status rmap_prescription_read(const char *bytes, size_t nbytes,
                                        enum rmap_lens_format format, int configuration,
                                        struct rmap_diagnostics *findings,
                                        struct rmap_prescription *lens, struct rmap_error *err)
{
    char *text = NULL;
    *lens = (struct rmap_prescription){.unit = "mm",
                                       .findings = findings,
                                       .configuration = configuration,
                                       .n_configuration = 1,
                                       .stored = 1,
                                       .temperature_c = (double)NAN,
                                       .pressure_atm = (double)NAN};
    enum rmap_status st = rmap_lens_decode(bytes, nbytes, &text, err);
    if (st != RMAP_OK)
        return st;
    switch (format) {
    case RMAP_LENS_ZMX:
        st = rmap_lens_read_zmx(text, lens, err);
        break;
    case RMAP_LENS_SEQ:
        st = rmap_lens_read_seq(text, lens, err);
        break;
    case RMAP_LENS_OSLO:
        st = rmap_lens_read_oslo(text, lens, err);
        break;
    }
    rmap_free(text);
    return st == RMAP_OK ? complete(lens, err) : st;
}

void rmap_prescription_fini(struct rmap_prescription *lens)
{
    rmap_free(lens->notes);
    rmap_free(lens->surface);
    rmap_free(lens->glass);
    *lens = (struct rmap_prescription){.n_surface = 0};
}
