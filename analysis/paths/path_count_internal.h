/* SPDX-License-Identifier: MIT
 *
 * What path_count.c, path_count_cells.c, path_count_enter.c, path_count_list.c,
 * path_count_rays.c, path_count_view.c and path_count_merge.c share.
 */
#ifndef RMAP_PATH_COUNT_INTERNAL_H
#define RMAP_PATH_COUNT_INTERNAL_H

#include <pthread.h>

#include "analysis/paths/path_count.h"
#include "analysis/paths/path_dictionary.h"
#include "analysis/paths/path_judge.h"
#include "analysis/table/class_cache.h"

/* As many rays ahead as memory takes to answer; as many keys as are expected together; so many keys
 * stand behind a list, which are asked for and not used. */
enum { RMAP_PATH_AHEAD = 12, RMAP_PATH_TOGETHER = 16, RMAP_PATH_LIST_BEHIND = 32 };

struct rmap_path_buffers {
    struct rmap_path_hasher hasher;
    struct rmap_path_dictionary dictionary;
    struct rmap_path_judge judge;
    struct rmap_fold_told told; /* of the portion in hand */
    /* Rays of it, by their numbers among those that are keyed, that the cache did not count; and
     * their keys, mixed. */
    uint32_t *left;
    uint64_t *mixed;
    size_t n_left, left_cap;
    struct rmap_key_slots ahead; /* as they were of late: where slots are asked for, no more */
    uint8_t *all;                /* [all_cap] ones */
    size_t all_cap;
};

/* Keys the rays that the hasher found, and lists those that the cache, if there is one, does not
 * count. at_once: they are entered next, so that memory is to look for their slots. RMAP_SYSTEM. */
enum rmap_status rmap_path_buffers_list(struct rmap_path_buffers *buffers,
                                        struct rmap_class_cache *cache, bool at_once,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* What became of a class. */
struct rmap_path_added {
    size_t class;    /* RMAP_KEY_SLOTS_NONE: it is not counted */
    uint64_t before; /* its rays */
    uint64_t after;
};

/* Adds what another entry, or one ray, brings to its class. */
enum rmap_status rmap_path_counts_add_class(struct rmap_path_counts *counts,
                                            const struct rmap_class_sum *more,
                                            struct rmap_path_added *added,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Whether its steps are to be kept. */
static inline bool rmap_path_tally_wants_steps(const struct rmap_path_tally *tally,
                                               const struct rmap_path_added *added)
{
    return added->class != RMAP_KEY_SLOTS_NONE &&
           rmap_path_steps_want(&tally->steps, added->class, added->before, added->after);
}

/* More classes, or cells, than may be. */
enum rmap_status rmap_path_counts_spill(struct rmap_path_counts *counts,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_counts_drop_cells(struct rmap_path_counts *counts);

/* Whether a class is one of those that count. */
bool rmap_path_counts_has(const struct rmap_path_counting *context, struct rmap_key key);

/* Room for the steps of a row of the portion, whose class wants them; NULL: there is none. */
enum rmap_status rmap_path_tally_make_room(struct rmap_path_tally *tally,
                                           const struct rmap_portion *portion,
                                           const struct rmap_path_place_of_ray *place,
                                           const struct rmap_path_added *added, rmap_path_step **to,
                                           struct rmap_error *err) RMAP_MUST_USE;

void rmap_path_tally_init(struct rmap_path_tally *tally, const struct rmap_path_counting *context);
void rmap_path_tally_fini(struct rmap_path_tally *tally);

struct rmap_path_pool {
    pthread_mutex_t mutex; /* of what follows */
    struct rmap_path_tally tally;
    bool is_full; /* more classes than may be: without entries then */
};

/* Whether a ray's key alone says what it is added to. */
static inline bool rmap_path_counts_are_plain(const struct rmap_path_counts *counts)
{
    const struct rmap_path_counting *context = counts->context;
    return !counts->is_full && !context->chosen && !context->sketch && context->detector < 0;
}

/* Registrations of the k-th ray that is keyed: how many count, and each in its cell. */
enum rmap_status rmap_path_counts_add_hits(struct rmap_path_counts *counts,
                                           const struct rmap_portion *portion, size_t k,
                                           uint64_t *n_hit, struct rmap_error *err) RMAP_MUST_USE;

/* Where rays of the portion in hand go. */
struct rmap_path_target {
    const struct rmap_path_counts *counts;
    const struct rmap_portion *portion;
    struct rmap_path_tally *tally;
    struct rmap_class_cache *cache; /* of its classes; NULL: none */
};

/* Adds listed rays; *n_ret: how many: all, unless there are more classes than may be. */
enum rmap_status rmap_path_target_add(const struct rmap_path_target *to, size_t *n_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Keeps the steps of the class by that ray, where there is room. */
enum rmap_status rmap_path_target_keep_steps(const struct rmap_path_target *to, size_t k,
                                             const struct rmap_path_added *added,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Adds the rays that are keyed to their classes: all; or where their keys alone say what they are
 * added to, those that are listed. is_wide: weights are not all 1. */
enum rmap_status rmap_path_counts_add_keyed(struct rmap_path_counts *counts,
                                            const struct rmap_matched *rays,
                                            struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_path_counts_add_listed(struct rmap_path_counts *counts,
                                             const struct rmap_matched *rays, bool is_wide,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Notes the classes' rays in the sketch, which is made where there is none. */
enum rmap_status rmap_path_counts_outline(struct rmap_path_counts *counts,
                                          const struct rmap_class_sums *classes,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Rays that a state counted in its cache, of classes of the pool that this state has by now. */
void rmap_path_counts_take_cache(struct rmap_path_counts *counts,
                                 const struct rmap_class_cache *cache);
void rmap_path_counts_drop_cache(struct rmap_path_counts *counts);

/* The cache is ready for rays of ids [first, end) that ascend. */
enum rmap_status rmap_path_counts_ready_cache(struct rmap_path_counts *counts, uint64_t first,
                                              uint64_t end, struct rmap_error *err) RMAP_MUST_USE;

/* Adds a portion by its columns. */
enum rmap_status rmap_path_counts_add_rays(struct rmap_path_counts *counts,
                                           const struct rmap_matched *rays,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* By its paths; rays with paths of their own by columns. */
enum rmap_status rmap_path_counts_add_told(struct rmap_path_counts *counts,
                                           const struct rmap_matched *rays,
                                           const struct rmap_told_paths *told,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Functions of the kind. */
enum rmap_status rmap_path_counts_add_view(struct rmap_path_counts *counts,
                                           const struct rmap_matched *rays,
                                           struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_path_counts_merge(void *into, void *from, struct rmap_error *err);
enum rmap_status rmap_path_counts_settle(void *counts, struct rmap_error *err);

#endif
