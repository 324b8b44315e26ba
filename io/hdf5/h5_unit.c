/* SPDX-License-Identifier: MIT
 *
 * What a unit means that is written as text.
 */
#include "io/hdf5/h5_unit.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/unit.h"
#include "base/vec.h"

enum { BASES = 7 }; /* L M T I theta N J */

static const struct word {
    const char *name;
    double si;
    double dimension[BASES];
} word_table[] = {
    {"s", 1.0, {[2] = 1}},  {"W", 1.0, {2, 1, -3}},     {"lm", 1.0, {[6] = 1}},
    {"cd", 1.0, {[6] = 1}}, {"lx", 1.0, {-2, [6] = 1}}, {"deg", RMAP_PI / 180.0, {0}},
    {"rad", 1.0, {0}},      {"sr", 1.0, {0}},           {"cycles", 1.0, {0}},
};

/* The letters at *at and the digit behind them, to a power of that or, below a stroke, of one over
 * it. */
static bool multiply(struct rmap_h5_unit *unit, const char **at, bool below)
{
    const char *from = *at;
    while (isalpha((unsigned char)**at))
        ++*at;
    const size_t len = (size_t)(*at - from);
    double power = below ? -1.0 : 1.0;
    if (isdigit((unsigned char)**at))
        power *= *(*at)++ - '0';
    for (size_t i = 0; i < sizeof word_table / sizeof *word_table; i++) {
        const struct word *word = &word_table[i];
        if (strlen(word->name) != len || strncmp(word->name, from, len) != 0)
            continue;
        unit->si *= pow(word->si, power);
        for (int k = 0; k < BASES; k++)
            unit->dimension[k] += power * word->dimension[k];
        return true;
    }
    const struct rmap_written_unit *length = rmap_unit_named(from, len);
    if (!length || length->dimension != RMAP_DIMENSION_LENGTH)
        return false;
    unit->si *= pow(length->size, power);
    unit->dimension[0] += power;
    return true;
}

struct rmap_h5_unit rmap_h5_unit_named(const char *name)
{
    const struct rmap_h5_unit one = {name, 1.0, {0}};
    struct rmap_h5_unit unit = one;
    bool below = false;
    for (const char *at = name; *at;) {
        if (isalpha((unsigned char)*at)) {
            if (!multiply(&unit, &at, below))
                return one;
            continue;
        }
        below = below || *at == '/';
        at++;
    }
    return unit;
}
