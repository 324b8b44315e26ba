/* SPDX-License-Identifier: MIT
 *
 * Lines of a figure that readers tell apart.
 */
#ifndef RMAP_LINE_MARK_H
#define RMAP_LINE_MARK_H

#include <stddef.h>

struct rmap_line_mark {
    const char *ink;  /* "#rrggbb" */
    const char *dash; /* of an SVG stroke; NULL: solid */
};

/* Of the k-th line: the first RMAP_LINE_INKS have an ink of their own; those after them have the
 * inks again, in another dash each time; no two of the first 28 are alike. Inks that readers with
 * any colour vision tell apart: M. Okabe and K. Ito, "Color Universal Design", 2008,
 * https://jfly.uni-koeln.de/color/; yellow darkened to show on paper. */
enum { RMAP_LINE_INKS = 7 };
struct rmap_line_mark rmap_line_mark(size_t k);

#endif
