/* SPDX-License-Identifier: MIT
 *
 * A scene once more, in light of wavelengths between its own: curves over wavelength need more of
 * them than rays do.
 */
#ifndef RMAP_SCENE_BETWEEN_H
#define RMAP_SCENE_BETWEEN_H

#include "io/mesh/bundle.h"

/* Not collective. bundle: complete, of which the scene was read, with so many warnings. surface:
 * the one that is asked for; others come without their scatter models. The wavelengths of the scene
 * are among the new ones; beside a single one, so many on either side as its data cover, within 30
 * %. The caller destroys what comes back; NULL: a scene in rgb, one with many wavelengths, or one
 * that cannot be read at others. */
struct rmap_scene *rmap_scene_between(const struct rmap_bundle *bundle,
                                      const struct rmap_scene *scene, const char *surface,
                                      size_t n_warning);

#endif
