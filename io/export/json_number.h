/* SPDX-License-Identifier: MIT
 *
 * Numbers of JSON documents.
 */
#ifndef RMAP_JSON_NUMBER_H
#define RMAP_JSON_NUMBER_H

#include <jansson.h>

/* null for what JSON cannot say: NaN and infinities. */
json_t *rmap_json_number(double value);

#endif
