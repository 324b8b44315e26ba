/* SPDX-License-Identifier: MIT */
#include "base/grouped.h"

const char *rmap_grouped(uint64_t number, char buffer[RMAP_GROUPED_LEN])
{
    char *at = buffer + RMAP_GROUPED_LEN - 1;
    *at = 0;
    for (int digit = 0; number > 0 || digit == 0; digit++, number /= 10) {
        if (digit > 0 && digit % 3 == 0)
            *--at = ',';
        *--at = (char)('0' + number % 10);
    }
    return at;
}
