/* SPDX-License-Identifier: MIT
 *
 * Listed rays to a table of classes, where a ray's key alone says what it is added to.
 */
#include "analysis/path_count_internal.h"
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
        classes->shape[class] =
            (struct rmap_class_shape){from->keyed.n_leg[k], from->keyed.n_hit[k]};
}

/* Slots are asked for so many rays ahead, and half as many their entries. Of many at once memory
 * forgets some. */
enum { AHEAD = RMAP_PATH_LIST_BEHIND };

RMAP_COPIED void look_ahead(const struct rmap_class_sums *classes, const uint64_t *mixed)
{
    rmap_key_slots_expect(&classes->slots, mixed + AHEAD, 1);
    rmap_key_slots_expect_entries(&classes->slots, classes->entry, sizeof *classes->entry,
                                  mixed + AHEAD / 2, 1);
}

/* Adds listed rays from the i-th on. Returns their number; or at which it stopped: its class may
 * want steps, or (added->class NONE) it is not added: there is no room for its class. */
RMAP_COPIED size_t enter_rays(const struct rmap_path_target *to, bool is_wide,
                              const struct bringing *from, size_t i, struct rmap_path_added *added)
{
    const struct rmap_path_buffers *buffers = to->counts->buffers;
    const struct rmap_path_steps *steps = &to->tally->steps;
    const uint64_t fewest = steps->is_full ? 2 : steps->is_closed;
    const uint64_t *mixed = buffers->mixed;
    const uint32_t *left = buffers->left;
    const size_t n = buffers->n_left;
    struct rmap_class_sums classes = to->tally->classes; /* of which registers know */
    for (; i < n; i++) {
        const size_t k = left[i];
        size_t slot = rmap_key_slots_at(&classes.slots, mixed[i]), class = RMAP_KEY_SLOTS_NONE;
        uint64_t before = 0;
        look_ahead(&classes, mixed + i);
        if (classes.slots.slot[slot] != 0)
            class =
                rmap_class_sums_look(&classes, rmap_path_key_at(&from->keyed, k), mixed[i], &slot);
        if (class != RMAP_KEY_SLOTS_NONE) {
            before = add_to(&classes, is_wide, class, from, k);
            if (to->cache)
                rmap_class_cache_meet(to->cache, rmap_path_key_at(&from->keyed, k), mixed[i], class,
                                      &classes);
        } else if (classes.n < classes.room) {
            class =
                rmap_class_sums_put(&classes, rmap_path_key_at(&from->keyed, k), mixed[i], slot);
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

static size_t enter_some(const struct rmap_path_target *to, const struct bringing *from, size_t i,
                         struct rmap_path_added *added)
{
    return to->tally->classes.is_wide ? enter_rays(to, true, from, i, added)
                                      : enter_rays(to, false, from, i, added);
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

enum rmap_status rmap_path_target_add(const struct rmap_path_target *to, size_t *n_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_class_sums *classes = &to->tally->classes;
    const struct rmap_path_buffers *buffers = to->counts->buffers;
    const struct bringing from = bringing_of(to);
    struct rmap_path_added added;
    size_t i = 0;
    if (classes->slots.n_slot == 0)
        RMAP_TRY(rmap_class_sums_reserve(classes, 1, err));
    rmap_key_slots_expect(&classes->slots, buffers->mixed, AHEAD);
    while (classes->room > 0 && (i = enter_some(to, &from, i, &added)) < buffers->n_left) {
        if (added.class == RMAP_KEY_SLOTS_NONE) {
            if (classes->n == classes->slots.most)
                break;
            RMAP_TRY(rmap_class_sums_reserve(classes, 1, err));
            continue;
        }
        const size_t k = buffers->left[i++];
        if (rmap_path_tally_wants_steps(to->tally, &added))
            RMAP_TRY(rmap_path_target_keep_steps(to, k, &added, err));
    }
out:
    *n_ret = i;
    return st;
}
