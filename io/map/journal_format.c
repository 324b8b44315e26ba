/* SPDX-License-Identifier: MIT
 *
 * Rows of tables as a journal carries them: the fields of map_format.h one after the other.
 */
#include "io/map/journal_format.h"

#include <string.h>

static size_t field_nbytes(const struct rmap_h5_field *field)
{
    return field->width * rmap_element_nbytes(field->element);
}

size_t rmap_journal_row_nbytes(struct rmap_field_table table)
{
    size_t nbytes = 0;
    for (size_t i = 0; i < table.n; i++)
        nbytes += field_nbytes(&table.field[i]);
    return nbytes;
}

void rmap_journal_row_pack(struct rmap_field_table table, const void *row, uint8_t *packed)
{
    for (size_t i = 0; i < table.n; i++) {
        memcpy(packed, (const uint8_t *)row + table.field[i].offset, field_nbytes(&table.field[i]));
        packed += field_nbytes(&table.field[i]);
    }
}

void rmap_journal_row_unpack(struct rmap_field_table table, const uint8_t *packed, void *row)
{
    for (size_t i = 0; i < table.n; i++) {
        memcpy((uint8_t *)row + table.field[i].offset, packed, field_nbytes(&table.field[i]));
        packed += field_nbytes(&table.field[i]);
    }
}
