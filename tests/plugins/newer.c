/* SPDX-License-Identifier: MIT
 *
 * A plug-in of a version of the interface that does not exist yet.
 */
#include "gradient/raymap_field.h"

const struct raymap_field *raymap_field(void)
{
    static const struct raymap_field field = {.abi = RAYMAP_FIELD_ABI + 1};
    return &field;
}
