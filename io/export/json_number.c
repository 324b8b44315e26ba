/* SPDX-License-Identifier: MIT
 *
 * Numbers of JSON documents.
 */
#include "io/export/json_number.h"

#include <math.h>

json_t *rmap_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}
