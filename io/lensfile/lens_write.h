/* SPDX-License-Identifier: MIT
 *
 * Numbers and remarks in the text of a scene.
 */
#ifndef RMAP_LENS_WRITE_H
#define RMAP_LENS_WRITE_H

#include <stdio.h>

#include "base/vec.h"
#include "io/lensfile/lens_layout.h"

/* The shortest text that reads as this number again. */
void rmap_lens_put_number(FILE *out, double value);

/* "radius: R, conic: k, asphere: {4: a}" and what else makes its shape, as far as there is such;
 * 1/R is the curvature to its last bit but one. */
void rmap_lens_put_shape(FILE *out, const struct rmap_lens_surface *surface);

/* "{rectangle: [w, h], at: [x, y]}" of an opening that is no circle about the vertex. */
void rmap_lens_put_outline(FILE *out, const struct rmap_lens_opening *opening);

/* ", at: [..], rotate: [..]" as far as they are not 0. */
void rmap_lens_put_place(FILE *out, const struct rmap_affine *to_world);

/* Text of the file behind "# " of the caller, without what a remark cannot hold. */
void rmap_lens_put_words(FILE *out, const char *text);

/* "media:" with air and what has no name in the catalogue. */
void rmap_lens_put_media(FILE *out, const struct rmap_lens_plan *plan);

/* "sources:", a beam for each field. */
void rmap_lens_put_sources(FILE *out, const struct rmap_lens_plan *plan);

#endif
