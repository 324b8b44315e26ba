/* SPDX-License-Identifier: MIT */
#include "analysis/table/class_sums.h"

#include <string.h>

#include "base/alloc.h"

/* Entries grow to ENTRIES_MANY, which need no huge page, then there is room for all. */
enum { ENTRIES_FEW = 1 << 10, ENTRIES_MANY = 1 << 14, STRIDE = sizeof(struct rmap_class_entry) };

void rmap_class_sums_init(struct rmap_class_sums *sums, bool is_wide, size_t most)
{
    *sums = (struct rmap_class_sums){.is_wide = is_wide};
    rmap_key_slots_init(&sums->slots, most);
}

void rmap_class_sums_fini(struct rmap_class_sums *sums)
{
    rmap_free(sums->entry);
    rmap_free(sums->shape);
    rmap_free(sums->more);
    rmap_free(sums->many);
    rmap_key_slots_fini(&sums->slots);
    *sums = (struct rmap_class_sums){.is_wide = sums->is_wide, .slots = sums->slots};
}

static enum rmap_status out_of_memory(size_t n, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu classes of paths", n);
}

/* n elements, of which the first `used` are those of the block before. */
static enum rmap_status move(void **block, size_t n, size_t used, size_t size,
                             struct rmap_error *err)
{
    void *moved = rmap_alloc_unset(n, size);
    if (!moved)
        return out_of_memory(n, err);
    if (used > 0)
        memcpy(moved, *block, used * size);
    rmap_free(*block);
    *block = moved;
    return RMAP_OK;
}

static enum rmap_status make_entries(struct rmap_class_sums *sums, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t most = sums->slots.most;
    const size_t many = sums->n_entry == 0 ? ENTRIES_FEW : ENTRIES_MANY;
    const size_t n = sums->n_entry < many && many < most ? many : most;
    if (!sums->many) {
        sums->many = rmap_alloc_unset(1, sizeof *sums->many);
        if (!sums->many)
            return out_of_memory(n, err);
        rmap_class_many_init(sums->many);
    }
    void *entry = sums->entry, *shape = sums->shape, *more = sums->more;
    st = move(&entry, n, sums->n, sizeof *sums->entry, err);
    sums->entry = entry;
    RMAP_TRY(st);
    st = sums->is_wide ? move(&more, n, sums->n, sizeof *sums->more, err)
                       : move(&shape, n, sums->n, sizeof *sums->shape, err);
    sums->more = more;
    sums->shape = shape;
    RMAP_TRY(st);
    sums->n_entry = n;
out:
    return st;
}

static struct rmap_class_more more_of(const struct rmap_class_entry *entry,
                                      struct rmap_class_shape shape)
{
    return (struct rmap_class_more){(double)entry->rays, (double)entry->rays,
                                    entry->rays * shape.n_leg, entry->rays * shape.n_hit};
}

enum rmap_status rmap_class_sums_widen(struct rmap_class_sums *sums, struct rmap_error *err)
{
    if (sums->is_wide)
        return RMAP_OK;
    if (sums->n_entry > 0) {
        sums->more = rmap_alloc_unset(sums->n_entry, sizeof *sums->more);
        if (!sums->more)
            return out_of_memory(sums->n_entry, err);
    }
    for (size_t i = 0; i < sums->n; i++)
        sums->more[i] = more_of(&sums->entry[i], sums->shape[i]);
    rmap_free(sums->shape);
    sums->shape = NULL;
    sums->is_wide = true;
    return RMAP_OK;
}

enum rmap_status rmap_class_sums_reserve(struct rmap_class_sums *sums, size_t n_more,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t most = sums->slots.most,
                 wanted = n_more < most - sums->n ? sums->n + n_more : most;
    while (sums->n_entry < wanted)
        RMAP_TRY(make_entries(sums, err));
    while (sums->slots.room < wanted)
        RMAP_TRY(rmap_key_slots_grow(&sums->slots, sums->entry, STRIDE, sums->n, err));
    sums->room = sums->n_entry < sums->slots.room ? sums->n_entry : sums->slots.room;
out:
    return st;
}

/* What all rays have that came, if entry and shape can say it. */
static bool has_shape(const struct rmap_class_sum *sum, struct rmap_class_shape *shape)
{
    const struct rmap_class_more *more = &sum->more;
    const uint64_t rays = sum->entry.rays;
    const uint64_t n_leg = rays == 1 ? more->segments : more->segments / rays;
    const uint64_t n_hit = rays == 1 ? more->registrations : more->registrations / rays;
    *shape = (struct rmap_class_shape){(uint32_t)n_leg, (uint32_t)n_hit};
    return n_leg <= UINT32_MAX && n_hit <= UINT32_MAX && n_leg * rays == more->segments &&
           n_hit * rays == more->registrations && more->weight == (double)rays &&
           more->weight_squared == (double)rays;
}

static bool is_same(struct rmap_class_shape a, struct rmap_class_shape b)
{
    return a.n_leg == b.n_leg && a.n_hit == b.n_hit;
}

static void add_more(struct rmap_class_more *to, const struct rmap_class_more *more)
{
    to->weight += more->weight;
    to->weight_squared += more->weight_squared;
    to->segments += more->segments;
    to->registrations += more->registrations;
}

enum rmap_status rmap_class_sums_add(struct rmap_class_sums *sums,
                                     const struct rmap_class_sum *more, size_t *index_ret,
                                     uint64_t *before_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_key key = more->entry.key;
    const uint64_t mixed = rmap_key_mixed(key), first = more->entry.first_ray;
    struct rmap_class_shape shape = {0};
    size_t slot = 0, index = rmap_class_sums_look(sums, key, mixed, &slot);
    const bool is_new = index == RMAP_KEY_SLOTS_NONE;
    if (!sums->is_wide &&
        (!has_shape(more, &shape) || (!is_new && !is_same(shape, sums->shape[index]))))
        RMAP_TRY(rmap_class_sums_widen(sums, err));
    *before_ret = 0;
    *index_ret = RMAP_KEY_SLOTS_NONE;
    if (is_new && sums->n == sums->slots.most)
        goto out;
    if (is_new && sums->n >= sums->room) {
        RMAP_TRY(rmap_class_sums_reserve(sums, 1, err));
        (void)rmap_class_sums_look(sums, key, mixed, &slot);
    }
    if (is_new) {
        index = rmap_class_sums_put(sums, key, mixed, slot);
        sums->entry[index] = more->entry;
        if (sums->is_wide)
            sums->more[index] = more->more;
        else
            sums->shape[index] = shape;
    } else {
        struct rmap_class_entry *entry = &sums->entry[index];
        *before_ret = entry->rays;
        entry->rays += more->entry.rays;
        entry->first_ray = first < entry->first_ray ? first : entry->first_ray;
        if (sums->is_wide)
            add_more(&sums->more[index], &more->more);
    }
    rmap_class_many_note(sums->many, sums->entry, index, *before_ret, sums->entry[index].rays);
    *index_ret = index;
out:
    return st;
}

struct rmap_class_sum rmap_class_sums_at(const struct rmap_class_sums *sums, size_t index)
{
    const struct rmap_class_entry *entry = &sums->entry[index];
    return (struct rmap_class_sum){*entry, sums->is_wide ? sums->more[index]
                                                         : more_of(entry, sums->shape[index])};
}
