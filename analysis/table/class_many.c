/* SPDX-License-Identifier: MIT */
#include "analysis/table/class_many.h"

#include "analysis/table/class_sums.h"

static void raise_least(struct rmap_class_many *many, const struct rmap_class_entry *entry)
{
    size_t n = 0;
    many->least *= 2;
    for (size_t k = 0; k < many->n; k++) {
        const uint32_t its = many->class[k];
        many->class[n] = its;
        n += entry[its].rays >= many->least;
    }
    many->n = n;
}

void rmap_class_many_add(struct rmap_class_many *many, const struct rmap_class_entry *entry,
                         size_t class)
{
    while (many->n == RMAP_CLASS_MANY)
        raise_least(many, entry);
    if (entry[class].rays < many->least)
        return;
    many->class[many->n] = (uint32_t) class;
    many->n++;
}
