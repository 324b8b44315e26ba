/* SPDX-License-Identifier: MIT
 *
 * Complex numbers of two parts. glibc 2.36 has CMPLX for GCC alone, and the presets tsan and fuzz
 * are clang's.
 */
#ifndef RMAP_COMPLEX_NUMBER_H
#define RMAP_COMPLEX_NUMBER_H

#include <complex.h>

#ifndef CMPLX
#define CMPLX(x, y) __builtin_complex((double)(x), (double)(y))
#endif

#endif
