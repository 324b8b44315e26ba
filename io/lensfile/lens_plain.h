/* SPDX-License-Identifier: MIT
 *
 * What no scene can have, made plainer, so that all the rest of a lens stands there: each change is
 * told with the line of the file.
 */
#ifndef RMAP_LENS_PLAIN_H
#define RMAP_LENS_PLAIN_H

#include "io/lensfile/lens_layout.h"

/* Numbers that leave the room of a scene. */
void rmap_lens_limit(struct rmap_prescription *lens);

/* Wavelengths at which a medium of the lens has no index are left out. False: all were right. */
bool rmap_lens_limit_light(struct rmap_prescription *lens, const struct rmap_lens_media *media);

/* `why`: what the reader of scenes says of the surface. It stands there without its asphere; then
 * as a plane; then the surface before it does. False: nothing is left to be taken away. */
bool rmap_lens_make_plainer(struct rmap_prescription *lens, size_t surface, const char *why);

/* The field's light, which a scene cannot send, comes from far away; then there is none. False: it
 * is the last one. */
bool rmap_lens_move_source(struct rmap_prescription *lens, size_t field, const char *why);

/* Planning leaves remarks, findings and openings: what is planned again begins without them. */
struct rmap_lens_kept {
    struct rmap_prescription lens;
    struct rmap_lens_surface *surface;
    size_t n_finding;
};
/* As it is now, in place of what was kept before. RMAP_SYSTEM. */
enum rmap_status rmap_lens_keep(const struct rmap_prescription *lens, struct rmap_lens_kept *kept,
                                struct rmap_error *err) RMAP_MUST_USE;
void rmap_lens_put_back(struct rmap_prescription *lens, const struct rmap_lens_kept *kept);
void rmap_lens_kept_fini(struct rmap_lens_kept *kept);

#endif
