/* SPDX-License-Identifier: MIT
 *
 * The columns of a ray map, once.
 */
#include "portion/columns.h"

/* clang-format off */
static const struct rmap_column_info info[RMAP_COLUMN_COUNT] = {
#define RAY(field, path, type, element, width, unit, text)                                         \
    [RMAP_RAY_##field] = {RMAP_TABLE_RAY, #field, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
    RMAP_RAY_COLUMNS(RAY)
#define SEGMENT(field, path, type, element, width, unit, text)                                     \
    [RMAP_SEGMENT_##field] = {RMAP_TABLE_SEGMENT, #field, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
    RMAP_SEGMENT_COLUMNS(SEGMENT)
#define REGISTRATION(field, path, type, element, width, unit, text)                                \
    [RMAP_REGISTRATION_##field] = {RMAP_TABLE_REGISTRATION, #field, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
    RMAP_REGISTRATION_COLUMNS(REGISTRATION)
    [RMAP_SEGMENT_colour] = {RMAP_TABLE_SEGMENT, "colour", "/segment/colour", RMAP_U16, 0, RMAP_UNIT_ONE,
                             "share of the ray's flux per channel on the leg's arrival x 65535; a row sums to 65535"},
#define CURVE(field, path, type, element, width, unit, text)                                       \
    [RMAP_CURVE_##field] = {RMAP_TABLE_CURVE, #field, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
    RMAP_CURVE_COLUMNS(CURVE)
    RMAP_RAY_TIME_COLUMNS(RAY)
    RMAP_REGISTRATION_TIME_COLUMNS(REGISTRATION)
};
/* clang-format on */

_Static_assert(RMAP_COLUMN_COUNT < 64, "a column set is one 64-bit word");

const struct rmap_column_info *rmap_column_info(enum rmap_column column)
{
    return &info[column];
}

size_t rmap_element_nbytes(enum rmap_element element)
{
    static const size_t nbytes[] = {[RMAP_U8] = 1,  [RMAP_U16] = 2, [RMAP_I16] = 2, [RMAP_U32] = 4,
                                    [RMAP_I32] = 4, [RMAP_U64] = 8, [RMAP_F32] = 4, [RMAP_F64] = 8};
    return nbytes[element];
}
