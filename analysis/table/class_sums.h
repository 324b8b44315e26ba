/* SPDX-License-Identifier: MIT
 *
 * Sums by class of path. What most classes are is in an entry of 32 bytes: where all rays of a
 * class have as many legs and registrations, these stand beside it once; and where weights are 1,
 * their sums are numbers of rays. Otherwise a class has `more`. The table holds a stated number of
 * classes and never more, and says so when it is full: whether it is depends on the keys alone, not
 * on their order.
 */
#ifndef RMAP_CLASS_SUMS_H
#define RMAP_CLASS_SUMS_H

#include "analysis/table/class_many.h"
#include "analysis/table/key_slots.h"
#include "base/intrinsics.h"

struct rmap_class_entry {
    struct rmap_key key;
    uint64_t rays, first_ray; /* first_ray: the smallest id */
};
_Static_assert(sizeof(struct rmap_class_entry) == 32, "written as two halves");

/* Of any of its rays. */
struct rmap_class_shape {
    uint32_t n_leg, n_hit;
};

/* Of all of its rays. */
struct rmap_class_more {
    double weight, weight_squared;
    uint64_t segments, registrations;
};

/* What a class has, or what is added to it. */
struct rmap_class_sum {
    struct rmap_class_entry entry;
    struct rmap_class_more more;
};

struct rmap_class_sums {
    struct rmap_class_entry *entry; /* [n_entry]: a few, or room for most of them, whose pages come
                                       with use; in the order in which they came */
    struct rmap_class_shape *shape; /* [n_entry], or NULL: */
    struct rmap_class_more *more;   /* [n_entry] */
    struct rmap_class_many *many;   /* NULL without entries */
    struct rmap_key_slots slots;
    bool is_wide; /* `more` is there, or will be */
    size_t n_entry, n;
    size_t room; /* as many fit into what is there */
};

/* is_wide: rays of a class differ in legs or registrations. most: below RMAP_KEY_SLOTS_MOST. */
void rmap_class_sums_init(struct rmap_class_sums *sums, bool is_wide, size_t most);
void rmap_class_sums_fini(struct rmap_class_sums *sums);

/* From now on there is `more`. */
enum rmap_status rmap_class_sums_widen(struct rmap_class_sums *sums,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Index of the key's class, or RMAP_KEY_SLOTS_NONE. *slot_ret: for rmap_class_sums_put, where there
 * are slots. */
static inline size_t rmap_class_sums_look(const struct rmap_class_sums *sums, struct rmap_key key,
                                          uint64_t mixed, size_t *slot_ret)
{
    if (sums->slots.n_slot == 0)
        return RMAP_KEY_SLOTS_NONE;
    return rmap_key_slots_look(&sums->slots, sums->entry, sizeof *sums->entry, key, mixed,
                               slot_ret);
}

/* Room for so many more classes, as far as there can be: n + n_more <= room then. RMAP_SYSTEM. */
enum rmap_status rmap_class_sums_reserve(struct rmap_class_sums *sums, size_t n_more,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* A new class without rays, for which there is room (n < room); slot: as found by look. Returns its
 * index: what it has is the caller's to set. */
static inline size_t rmap_class_sums_put(struct rmap_class_sums *sums, struct rmap_key key,
                                         uint64_t mixed, size_t slot)
{
    const size_t index = sums->n++;
    rmap_key_slots_put(&sums->slots, slot, mixed, index);
    sums->entry[index].key = key;
    return index;
}

/* A new class of one ray of weight 1 below `room`, where there are shapes. Most are not met again
 * soon: where the machine can, they are written past the caches, into which no line is read for
 * them. Other threads may look behind the next end_away. */
RMAP_COPIED void rmap_class_sums_begin_away(const struct rmap_class_sums *sums, size_t index,
                                            struct rmap_key key, uint64_t id,
                                            struct rmap_class_shape shape)
{
#ifdef RMAP_INTRINSICS
    __m128i *entry = (__m128i *)(void *)&sums->entry[index];
    _mm_stream_si128(entry, _mm_set_epi64x((long long)key.high, (long long)key.low));
    _mm_stream_si128(entry + 1, _mm_set_epi64x((long long)id, 1));
    _mm_stream_si64((long long *)(void *)&sums->shape[index],
                    (long long)((uint64_t)shape.n_hit << 32 | shape.n_leg));
#else
    sums->entry[index] = (struct rmap_class_entry){key, 1, id};
    sums->shape[index] = shape;
#endif
}

static inline void rmap_class_sums_end_away(void)
{
#ifdef RMAP_INTRINSICS
    _mm_sfence();
#endif
}

/* More rays of weight 1, alike those that the class has; none of them is its first. */
static inline void rmap_class_sums_add_rays(struct rmap_class_sums *sums, size_t index, uint64_t n)
{
    struct rmap_class_entry *entry = &sums->entry[index];
    if (sums->is_wide) {
        struct rmap_class_more *more = &sums->more[index];
        more->weight += (double)n;
        more->weight_squared += (double)n;
        more->segments += more->segments / entry->rays * n;
        more->registrations += more->registrations / entry->rays * n;
    }
    entry->rays += n;
    rmap_class_many_note(sums->many, sums->entry, index, entry->rays - n, entry->rays);
}

/* Adds to a class what others of its rays have. *index_ret: the class, or NONE when the table is
 * full and has no such class; *before_ret: rays that it had. */
enum rmap_status rmap_class_sums_add(struct rmap_class_sums *sums,
                                     const struct rmap_class_sum *more, size_t *index_ret,
                                     uint64_t *before_ret, struct rmap_error *err) RMAP_MUST_USE;

struct rmap_class_sum rmap_class_sums_at(const struct rmap_class_sums *sums, size_t index);

#endif
