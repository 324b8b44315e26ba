/* SPDX-License-Identifier: MIT
 *
 * The picture of a sweep, a row for each answer: its curve over a parameter with bands of errors,
 * or, where values are drawn, which share of the variants lies below a value; and how much each
 * parameter has to do with it.
 */
#ifndef RMAP_SWEEP_FIGURE_H
#define RMAP_SWEEP_FIGURE_H

#include "analysis/sweep/sweep_table.h"
#include "io/export/svg.h"

enum rmap_status rmap_figure_sweep(const struct rmap_sweep_table *table, struct rmap_svg **svg_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
