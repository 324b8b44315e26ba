/* SPDX-License-Identifier: MIT
 *
 * What a TM-25 file begins with (ANSI/IES TM-25-13, section 4.7).
 */
#ifndef RMAP_TM25_H
#define RMAP_TM25_H

#include <stdint.h>

/* 4.7.1; little-endian. A number that is not known is NaN. */
struct rmap_tm25_head {
    char magic[4];    /* "TM25" */
    int32_t version;  /* 2013 */
    int32_t creation; /* 0 simulated, 1 measured */
    float lumens, watts;
    uint64_t n_ray __attribute__((packed));
    char date[28];    /* 2026-11-29T07:00:00+00:00 */
    int32_t starts;   /* what the starts lie on; 0: not known */
    int32_t spectrum; /* 0 none, 1 one wavelength, 2 one of each ray, 3 a table, 4 one of tables */
    float nm, least_nm, greatest_nm;
    int32_t n_table, n_more, text_nbytes;
    char reserved[168];
};
_Static_assert(sizeof(struct rmap_tm25_head) == 256, "as in the file");

/* 4.7.2 */
enum {
    RMAP_TM25_POSITION,
    RMAP_TM25_DIRECTION,
    RMAP_TM25_RADIANT,
    RMAP_TM25_WAVELENGTH,
    RMAP_TM25_LUMINOUS,
    RMAP_TM25_STOKES,
    RMAP_TM25_TRISTIMULUS,
    RMAP_TM25_INDEX,
    RMAP_TM25_FLAGS
};

enum { RMAP_TM25_TEXTS = 9, RMAP_TM25_LETTERS = 1000, RMAP_TM25_NAME_NBYTES = 512 };

#endif
