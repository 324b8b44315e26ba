/* SPDX-License-Identifier: MIT
 *
 * What the program is made of.
 */
#ifndef RMAP_VERSION_TEXT_H
#define RMAP_VERSION_TEXT_H

#include <stdio.h>

void rmap_version_print(FILE *out);

#endif
