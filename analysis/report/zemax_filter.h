/* SPDX-License-Identifier: MIT
 *
 * Filter strings of Zemax ray databases in the criterion language. Flags as in the help of
 * OpticStudio, "The Filter String" (flags joined by & | ^ ! and parentheses): a letter and the
 * number of an object, here its place in the scene's list of objects, from 1.
 */
#ifndef RMAP_ZEMAX_FILTER_H
#define RMAP_ZEMAX_FILTER_H

#include "base/status.h"
#include "scene/scene.h"

/* *criterion_ret: the criterion's text, rmap_free. RMAP_INPUT, "zemax:1:6: error: ..." with a
 * caret, for a mistake and for a flag that has no meaning here, which is named with the reason. */
enum rmap_status rmap_zemax_translate(const char *filter, const struct rmap_scene *scene,
                                      char **criterion_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
