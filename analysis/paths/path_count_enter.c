/* SPDX-License-Identifier: MIT
 *
 * Listed rays to a table of classes, where a ray's key alone says what it is added to.
 */
#include "analysis/paths/path_count_internal.h"
#include "base/wide.h"

enum rmap_status rmap_path_target_keep_steps(const struct rmap_path_target *to, size_t k,
                                             const struct rmap_path_added *added,
                                             struct rmap_error *err)
{
    const struct rmap_path_hasher *hasher = &to->counts->buffers->hasher;
    const struct rmap_path_place_of_ray place = rmap_path_place_at(&hasher->keyed, k);
    rmap_path_step *step;
    enum rmap_status st =
        rmap_path_tally_make_room(to->tally, to->portion, &place, added, &step, err);
    if (step)
        rmap_path_steps_end_class(&to->tally->steps, added->class,
                                  rmap_path_hasher_steps(hasher, &place, step));
    return st;
}

/* What rays bring to their classes; copies, of which registers know. */
struct bringing {
    const uint64_t *id;   /* of all rays of the portion, or NULL: */
    uint64_t first_id;    /* of the ray in row 0, from which on they ascend by 1 */
    const double *weight; /* NULL where weights are 1 */
    struct rmap_path_keyed keyed;
};

static inline uint64_t id_of(const struct bringing *from, size_t k)
{
    const uint32_t row = from->keyed.ray[k];
    return from->id ? from->id[row] : from->first_id + row;
}

static inline struct rmap_class_shape shape_of(const struct bringing *from, size_t k)
{
    return (struct rmap_class_shape){from->keyed.n_leg[k], from->keyed.n_hit[k]};
}

RMAP_COPIED struct rmap_class_more more_of(const struct bringing *from, size_t k)
{
    const double weight = from->weight ? from->weight[from->keyed.ray[k]] : 1.0;
    return (struct rmap_class_more){weight, weight * weight, from->keyed.n_leg[k],
                                    from->keyed.n_hit[k]};
}

/* Returns how many rays the class had. */
RMAP_COPIED uint64_t add_to(const struct rmap_class_sums *classes, bool is_wide, size_t class,
                            const struct bringing *from, size_t k)
{
    struct rmap_class_entry *entry = &classes->entry[class];
    const uint64_t before = entry->rays, id = id_of(from, k);
    entry->rays = before + 1;
    entry->first_ray = id < entry->first_ray ? id : entry->first_ray;
    rmap_class_many_note(classes->many, classes->entry, class, before, before + 1);
    if (is_wide) {
        struct rmap_class_more *to = &classes->more[class];
        const struct rmap_class_more more = more_of(from, k);
        to->weight += more.weight;
        to->weight_squared += more.weight_squared;
        to->segments += more.segments;
        to->registrations += more.registrations;
    }
    return before;
}

RMAP_COPIED void begin(const struct rmap_class_sums *classes, bool is_wide, size_t class,
                       const struct bringing *from, size_t k)
{
    struct rmap_class_entry *entry = &classes->entry[class];
    entry->rays = 1;
    entry->first_ray = id_of(from, k);
    if (is_wide)
        classes->more[class] = more_of(from, k);
    else
        classes->shape[class] = shape_of(from, k);
}

/* Rays of the list that are entered in one go; slots are asked for so many rays ahead: of many at
 * once memory forgets some. */
enum { TOGETHER = 256, AHEAD = RMAP_PATH_LIST_BEHIND };

/* Some of a list of rays. */
struct some {
    uint32_t at[TOGETHER];    /* [n] in the list */
    uint32_t maybe[TOGETHER]; /* [n] 1 + the class that it may be of; 0: not known */
    size_t n;
};

/* Where each of some keys is looked for, and what its slot has above the index; AHEAD more are only
 * asked for. */
struct places {
    uint32_t at[TOGETHER + AHEAD], bits[TOGETHER + AHEAD];
};

RMAP_COPIED void find_places(const struct rmap_key_slots *slots, const uint64_t *mixed, size_t n,
                             struct places *places)
{
    const struct rmap_key_slots its = *slots; /* of which registers know */
    for (size_t i = 0; i < n + AHEAD; i++) {
        places->at[i] = (uint32_t)rmap_key_slots_at(&its, mixed[i]);
        places->bits[i] = rmap_key_slots_bits(&its, mixed[i]);
    }
}

/* Slots for rays [first, first + n) of the list whose classes are new, and for which there is room:
 * their numbers in the list, and how many. The others, whose classes may be known, are listed, and
 * their entries asked for, one by one: of many at once memory forgets some. Most are new, which
 * cannot be foreseen: there is no branch. */
RMAP_COPIED size_t take_slots(const struct rmap_class_sums *classes, bool wide_lanes,
                              const uint64_t *mixed, size_t first, size_t n, struct some *known,
                              uint32_t *fresh)
{
    const struct rmap_class_entry *entry = classes->entry;
    const uint32_t last_lane = 1u << (RMAP_KEY_SLOTS_TOGETHER - 1);
    const uint32_t number = classes->slots.number, next = (uint32_t)classes->n + 1;
    uint32_t *const slot = classes->slots.slot;
    struct places places;
    size_t n_known = 0;
    find_places(&classes->slots, mixed + first, n, &places);
    for (size_t i = 0; i < n; i++) {
        uint32_t *its = slot + places.at[i];
        const uint32_t bits = places.bits[i];
        const size_t n_new = i - n_known;
        __builtin_prefetch(slot + places.at[i + AHEAD], 1);
        const struct rmap_key_lanes lanes = rmap_key_lanes_of(its, number, bits, wide_lanes);
        const uint32_t is_alike = lanes.alike != 0, is_known = is_alike | (lanes.free == 0);
        const uint32_t maybe =
            its[rmap_key_lane(lanes.alike | last_lane)] & number & (0u - is_alike);
        __builtin_prefetch(entry + (maybe - is_alike), 0, 2);
        known->at[n_known] = (uint32_t)(first + i);
        known->maybe[n_known] = maybe;
        its[rmap_key_lane(lanes.free | last_lane)] |=
            (bits | (next + (uint32_t)n_new)) & (is_known - 1);
        fresh[n_new] = (uint32_t)(first + i);
        n_known += is_known;
    }
    known->n = n_known;
    return n - n_known;
}

RMAP_KEY_LANES_WIDE static size_t take_slots_wide(const struct rmap_class_sums *classes,
                                                  const uint64_t *mixed, size_t first, size_t n,
                                                  struct some *known, uint32_t *fresh)
{
    return take_slots(classes, true, mixed, first, n, known, fresh);
}

RMAP_COPIED void begin_all(struct rmap_class_sums *classes, bool is_wide,
                           const struct bringing *from, const uint32_t *left, const uint32_t *fresh,
                           size_t n_new)
{
    const struct rmap_class_sums to = *classes; /* of which registers know */
    for (size_t i = 0; i < n_new; i++) {
        const size_t k = left[fresh[i]];
        const struct rmap_key key = rmap_path_key_at(&from->keyed, k);
        if (is_wide) {
            to.entry[to.n + i].key = key;
            begin(&to, is_wide, to.n + i, from, k);
        } else {
            rmap_class_sums_begin_away(&to, to.n + i, key, id_of(from, k), shape_of(from, k));
        }
    }
    classes->n += n_new;
}

/* Enters those of rays [first, first + n) of the list whose classes are new, for which there is
 * room; lists the others. */
static void enter_new(struct rmap_class_sums *classes, const struct rmap_path_buffers *buffers,
                      const struct bringing *from, size_t first, size_t n, struct some *known)
{
    uint32_t fresh[TOGETHER];
    const uint64_t *mixed = buffers->mixed;
    const size_t n_new = rmap_key_lanes_are_wide()
                             ? take_slots_wide(classes, mixed, first, n, known, fresh)
                             : take_slots(classes, false, mixed, first, n, known, fresh);
    if (classes->is_wide)
        begin_all(classes, true, from, buffers->left, fresh, n_new);
    else
        begin_all(classes, false, from, buffers->left, fresh, n_new);
}

static void list_all(size_t first, size_t n, struct some *all)
{
    all->n = n;
    for (size_t i = 0; i < n; i++) {
        all->at[i] = (uint32_t)(first + i);
        all->maybe[i] = 0;
    }
}

/* The class of a ray that may be of that one; slot: as rmap_class_sums_look has it. */
static inline size_t look(const struct rmap_class_sums *classes, uint32_t maybe,
                          struct rmap_key key, uint64_t mixed, size_t *slot_ret)
{
    if (maybe > 0) {
        const struct rmap_key its = classes->entry[maybe - 1].key;
        if (its.low == key.low && its.high == key.high)
            return maybe - 1;
    }
    return rmap_class_sums_look(classes, key, mixed, slot_ret);
}

/* Adds rays, from the i-th on. Returns their number; or at which it stopped: its class may want
 * steps, or (added->class NONE) it is not added: there is no room for its class. */
RMAP_COPIED size_t enter_rays(const struct rmap_path_target *to, bool is_wide,
                              const struct bringing *from, const struct some *rays, size_t i,
                              struct rmap_path_added *added)
{
    const struct rmap_path_buffers *buffers = to->counts->buffers;
    const struct rmap_path_steps *steps = &to->tally->steps;
    const uint64_t fewest = steps->is_full ? 2 : steps->is_closed;
    struct rmap_class_sums classes = to->tally->classes; /* of which registers know */
    for (; i < rays->n; i++) {
        const size_t k = buffers->left[rays->at[i]];
        const uint64_t mixed = buffers->mixed[rays->at[i]];
        const struct rmap_key key = rmap_path_key_at(&from->keyed, k);
        size_t slot = 0, class = look(&classes, rays->maybe[i], key, mixed, &slot);
        uint64_t before = 0;
        if (class != RMAP_KEY_SLOTS_NONE) {
            before = add_to(&classes, is_wide, class, from, k);
            if (to->cache)
                rmap_class_cache_meet(to->cache, key, mixed, class, &classes);
        } else if (classes.n < classes.room) {
            class = rmap_class_sums_put(&classes, key, mixed, slot);
            begin(&classes, is_wide, class, from, k);
        } else {
            added->class = class;
            break;
        }
        if (before >= fewest && before < 2) {
            *added = (struct rmap_path_added){class, before, before + 1};
            break;
        }
    }
    to->tally->classes.n = classes.n;
    return i;
}

static size_t enter_some(const struct rmap_path_target *to, const struct bringing *from,
                         const struct some *rays, size_t i, struct rmap_path_added *added)
{
    return to->tally->classes.is_wide ? enter_rays(to, true, from, rays, i, added)
                                      : enter_rays(to, false, from, rays, i, added);
}

static struct bringing bringing_of(const struct rmap_path_target *to)
{
    const struct rmap_path_buffers *buffers = to->counts->buffers;
    const struct rmap_portion *portion = to->portion;
    return (struct bringing){.id = buffers->told.ids_run ? NULL : portion->ray.id,
                             .first_id = portion->first_ray,
                             .weight = buffers->told.weigh_one ? NULL : portion->ray.weight,
                             .keyed = buffers->hasher.keyed};
}

/* Adds these rays: *n_ret, unless there are more classes than may be. */
static enum rmap_status add_some(const struct rmap_path_target *to, const struct bringing *from,
                                 const struct some *rays, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_added added;
    size_t i = 0;
    while ((i = enter_some(to, from, rays, i, &added)) < rays->n) {
        if (added.class == RMAP_KEY_SLOTS_NONE)
            break;
        const size_t k = to->counts->buffers->left[rays->at[i++]];
        if (rmap_path_tally_wants_steps(to->tally, &added))
            RMAP_TRY(rmap_path_target_keep_steps(to, k, &added, err));
    }
out:
    *n_ret = i;
    return st;
}

enum rmap_status rmap_path_target_add(const struct rmap_path_target *to, size_t *n_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_class_sums *classes = &to->tally->classes;
    const struct rmap_path_buffers *buffers = to->counts->buffers;
    const struct bringing from = bringing_of(to);
    struct some some[2], *now = some, *before = some + 1;
    size_t i = 0, n_added = 0;
    before->n = 0;
    rmap_key_slots_expect(&classes->slots, buffers->mixed, AHEAD);
    while (i < buffers->n_left) {
        const size_t left = buffers->n_left - i, n = left < TOGETHER ? left : TOGETHER;
        RMAP_TRY(rmap_class_sums_reserve(classes, 2 * TOGETHER, err));
        const bool at_once =
            to->tally->steps.is_closed && classes->n + 2 * TOGETHER <= classes->room;
        if (at_once)
            enter_new(classes, buffers, &from, i, n, now);
        else
            list_all(i, n, now);
        RMAP_TRY(add_some(to, &from, before, &n_added, err));
        before->n = 0;
        if (!at_once) {
            RMAP_TRY(add_some(to, &from, now, &n_added, err));
            if (n_added < now->n) {
                i += n_added;
                goto out;
            }
            now->n = 0;
        }
        i += n;
        before = now;
        now = before == some ? some + 1 : some;
    }
    st = add_some(to, &from, before, &n_added, err);
out:
    rmap_class_sums_end_away();
    *n_ret = i;
    return st;
}
