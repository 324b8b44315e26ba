/* SPDX-License-Identifier: MIT
 *
 * Whole numbers that people can read.
 */
#include "base/grouped.h"

#include <stdio.h>
#include <string.h>

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

struct rmap_counted rmap_counted(uint64_t number, const char *noun)
{
    struct rmap_counted counted;
    char digits[RMAP_GROUPED_LEN];
    size_t n = strlen(noun);
    const char *end = number == 1 ? "" : "s";
    if (number != 1 && n > 1 && noun[n - 1] == 'y' && !strchr("aeiou", noun[n - 2])) {
        n--;
        end = "ies";
    } else if (number != 1 && n > 1 &&
               (strchr("sx", noun[n - 1]) || (noun[n - 1] == 'h' && strchr("cs", noun[n - 2])))) {
        end = "es";
    }
    (void)snprintf(counted.text, sizeof counted.text, "%s %.*s%s", rmap_grouped(number, digits),
                   (int)n, noun, end);
    return counted;
}
