/* SPDX-License-Identifier: MIT
 *
 * Instructions of x86-64 by name, where the compiler has functions for them and makes good use of
 * them. RMAP_INTRINSICS is defined there; elsewhere the portable loop beside each use does the
 * work, with the same results. Whether a machine has an instruction is asked at run time.
 */
#ifndef RMAP_INTRINSICS_H
#define RMAP_INTRINSICS_H

#if defined(__GNUC__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#include <immintrin.h>
#define RMAP_INTRINSICS 1
#endif

#endif
