/* SPDX-License-Identifier: MIT
 *
 * For functions whose loops the compiler turns into vector instructions: vectors as wide as the
 * machine has them (PRODUCTS: with AVX-512, which has products of 64 bits).
 * Results are the same; nothing is contracted to multiply-adds.
 */
#ifndef RMAP_WIDE_H
#define RMAP_WIDE_H

#include <stdint.h> /* __GLIBC__, which chooses among the clones */

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    defined(__OPTIMIZE__)
#define RMAP_WIDE __attribute__((target_clones("avx2", "default")))
#if __GNUC__ >= 12 /* knows the level by its name */
#define RMAP_WIDE_PRODUCTS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define RMAP_WIDE_PRODUCTS RMAP_WIDE
#endif
#else
#define RMAP_WIDE
#define RMAP_WIDE_PRODUCTS
#endif

/* For a function with constants among its arguments: a copy for each of its callers, in which they
 * are known and its loops are laid out. */
#if defined(__GNUC__)
#define RMAP_COPIED static inline __attribute__((always_inline))
#define RMAP_UNROLL _Pragma("GCC unroll 16")
#else
#define RMAP_COPIED static inline
#define RMAP_UNROLL
#endif

#endif
