/* SPDX-License-Identifier: MIT
 *
 * Which classes have the most rays, noted as they come to have so many: a table's first rows are
 * mostly among them, and the others, of which there may be half a million, need not be looked at.
 */
#ifndef RMAP_CLASS_MANY_H
#define RMAP_CLASS_MANY_H

#include <stddef.h>
#include <stdint.h>

/* As many are noted: few beside the classes of a large table, many beside the rows of a printed
 * one. */
enum { RMAP_CLASS_MANY = 1 << 12, RMAP_CLASS_MANY_LEAST = 16 };

struct rmap_class_entry;

/* Exactly the classes of at least `least` rays, each once. */
struct rmap_class_many {
    uint64_t least;
    size_t n;
    uint32_t class[RMAP_CLASS_MANY];
};

static inline void rmap_class_many_init(struct rmap_class_many *many)
{
    many->least = RMAP_CLASS_MANY_LEAST;
    many->n = 0;
}

/* The class has come to have `least` rays. Where there is no room, there is for those that have
 * twice as many, and so on. */
void rmap_class_many_add(struct rmap_class_many *many, const struct rmap_class_entry *entry,
                         size_t class);

/* The class had `before` rays, and has more now. */
static inline void rmap_class_many_note(struct rmap_class_many *many,
                                        const struct rmap_class_entry *entry, size_t class,
                                        uint64_t before, uint64_t now)
{
    if (before < many->least && now >= many->least)
        rmap_class_many_add(many, entry, class);
}

#endif
