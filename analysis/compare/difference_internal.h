/* SPDX-License-Identifier: MIT */
#ifndef RMAP_DIFFERENCE_INTERNAL_H
#define RMAP_DIFFERENCE_INTERNAL_H

#include "analysis/compare/difference.h"

/* Variance of T_A - T_B of a source of two maps, per unit variance of q. */
double rmap_stratum_scale(const struct rmap_stratum *stratum);

#endif
