/* SPDX-License-Identifier: MIT
 *
 * Lines of a figure that readers tell apart.
 */
#include "analysis/table/line_mark.h"

struct rmap_line_mark rmap_line_mark(size_t k)
{
    static const char *const ink[RMAP_LINE_INKS] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                    "#e69f00", "#56b4e9", "#8a6d00"};
    static const char *const dash[] = {NULL, "7 5", "1 5", "9 5 1 5"};
    const size_t n_dash = sizeof dash / sizeof *dash;
    return (struct rmap_line_mark){ink[k % RMAP_LINE_INKS], dash[k / RMAP_LINE_INKS % n_dash]};
}
