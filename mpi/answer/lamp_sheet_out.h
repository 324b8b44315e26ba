/* SPDX-License-Identifier: MIT
 *
 * Data sheets of luminaires, on a command line and in a document: of a scene's lamps, and of what
 * an intensity grid registered.
 */
#ifndef RMAP_LAMP_SHEET_OUT_H
#define RMAP_LAMP_SHEET_OUT_H

#include "analysis/detector/detector_image.h"
#include "analysis/photometry/lamp_angles.h"
#include "mpi/command/command.h"

/* Entries of an option table; `with`: the options that they mean something with. */
#define RMAP_LAMP_SHEET_OPTIONS(with)                                                              \
    {"planes", 0, "LIST", "of it the planes C, in degrees (default 0,90,180,270)", with},          \
    {                                                                                              \
        "gammas", 0, "LIST", "and the gammas, as 0,5,10 (default: to 180)", with                   \
    }

struct rmap_lamp_sheet_ask {
    double *c_deg, *gamma_deg; /* [n_c], [n_gamma]; owned; none: the usual ones */
    size_t n_c, n_gamma;
};
/* RMAP_USAGE. rmap_lamp_sheet_ask_fini whatever happened. */
enum rmap_status rmap_lamp_sheet_ask(const struct rmap_arguments *given,
                                     struct rmap_lamp_sheet_ask *ask,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_lamp_sheet_ask_fini(struct rmap_lamp_sheet_ask *ask);

/* The lamp of that name in the scene of `path`. RMAP_INPUT with place and the nearest name. */
enum rmap_status rmap_find_lamp(const struct rmap_scene *scene, const char *path, const char *name,
                                const struct rmap_source **source_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
void rmap_lamp_sheet_of(const struct rmap_scene *scene, const struct rmap_source *source,
                        const struct rmap_lamp_sheet_ask *ask, struct rmap_lamp_sheet *sheet);

/* Its sheet and its table of glare, for people and as an object. */
enum rmap_status rmap_lamp_out_print(const struct rmap_scene *scene,
                                     const struct rmap_source *source,
                                     const struct rmap_lamp_sheet_ask *ask, FILE *out,
                                     struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_lamp_out_json(const struct rmap_scene *scene, const struct rmap_source *source,
                           const struct rmap_lamp_sheet_ask *ask);

/* Of an image in the cells of far_field.h: printed, or (document not NULL) added as "photometry".
 */
enum rmap_status rmap_photometry_out(const struct rmap_detector_image *image,
                                     const struct rmap_lamp_sheet_ask *ask, json_t *document,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
