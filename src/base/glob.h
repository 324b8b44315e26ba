/* SPDX-License-Identifier: MIT
 *
 * Patterns of * and ?.
 */
#ifndef RMAP_GLOB_H
#define RMAP_GLOB_H

#include <stdbool.h>

/* True when the text matches a pattern of * and ?, which stands for one character of UTF-8. */
bool rmap_glob(const char *pattern, const char *text);

#endif
