/* SPDX-License-Identifier: MIT
 *
 * Whole numbers that people can read.
 */
#ifndef RMAP_GROUPED_H
#define RMAP_GROUPED_H

#include <stdint.h>

/* "1,234,567", into a buffer of at least 28 characters; the text begins somewhere in it. */
#define RMAP_GROUPED_LEN 28
const char *rmap_grouped(uint64_t number, char buffer[RMAP_GROUPED_LEN]);

/* "1 ray", "1,234 rays"; "2 geometries", "2 classes". As rmap_counted(n, "ray").text it lives to
 * the end of its statement. The noun has at most 32 characters. */
struct rmap_counted {
    char text[64];
};
struct rmap_counted rmap_counted(uint64_t number, const char *noun);

#endif
