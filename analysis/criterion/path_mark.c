/* SPDX-License-Identifier: MIT
 *
 * Histories through an automaton. Rows become symbols by small tables, column by column; then a
 * step is one look-up. Several rays run at once, as each waits for its own look-up; a ray's end is
 * a symbol too, so that no branch depends on what the rays did.
 */
#include <string.h>

#include "analysis/criterion/path_mark.h"
#include "analysis/criterion/path_table.h"
#include "base/alloc.h"
#include "base/wide.h"

/* Symbols at a time: they stay in the first-level cache. A longer ray goes alone. */
enum { GROUP_SYMBOLS = 8192, LANES = 4 };

/* Consecutive rays and where their rows begin. */
struct group {
    size_t ray, n_ray;
    size_t segment, n_segment;
    size_t registration, n_registration;
};

struct run {
    const struct rmap_path_table *table;
    const struct rmap_portion *portion;
    uint16_t *step;   /* symbols of the group's rows of /segment */
    uint16_t *symbol; /* of all its rows, in order */
    size_t step_cap, symbol_cap;
    size_t lane_ray[LANES + 1], lane_symbol[LANES + 1];
    bool skips; /* rays without segments do not match: others that cannot are taken for such */
    uint8_t step_need; /* bits of needs that steps meet */
    bool hit_need;     /* a registration is needed */
};

static size_t index_within(int32_t index, size_t n)
{
    return (uint32_t)index < n ? (uint32_t)index : n;
}

/* What an event is worth as part of a base, for rows with and without an object. */
static size_t base_of(const struct rmap_path_table *table, uint32_t event, uint16_t kind)
{
    return (size_t)table->letter_of_event[event % RMAP_PATH_EVENT_CODES] * table->n_kind + kind;
}

/* Kinds of media stand in for those of rows without an object. */
static void mark_with_media(const struct rmap_path_table *table,
                            const struct rmap_segment_columns *from, size_t first, size_t n,
                            uint16_t *step)
{
    for (size_t i = first; i < first + n; i++) {
        uint16_t kind = from->object[i] < 0
                            ? table->kind_of_medium[index_within(from->medium[i], table->n_medium)]
                            : table->kind_of_object[index_within(from->object[i], table->n_object)];
        *step++ = table->symbol_of_base[base_of(table, from->event[i], kind)];
    }
}

void rmap_path_symbols(const struct rmap_path_table *table, const struct rmap_segment_columns *from,
                       size_t first, size_t n, uint16_t *step)
{
    const uint16_t *symbol = table->symbol_of_base, *kind = table->kind_of_object;
    const size_t n_object = table->n_object;
    if (table->of_medium)
        mark_with_media(table, from, first, n, step);
    else if (table->of_object)
        for (size_t i = 0; i < n; i++)
            step[i] = symbol[base_of(table, from->event[first + i],
                                     kind[index_within(from->object[first + i], n_object)])];
    else
        for (size_t i = 0; i < n; i++)
            step[i] = symbol[base_of(table, from->event[first + i], 0)];
}

uint16_t rmap_path_row_symbol(const struct rmap_path_table *table,
                              const struct rmap_segment_columns *segment, size_t row)
{
    uint16_t symbol = 0;
    rmap_path_symbols(table, segment, row, 1, &symbol);
    return symbol;
}

static inline uint16_t *copy_symbols(uint16_t *to, const uint16_t *from, size_t n)
{
    for (size_t i = 0; i < n; i += RMAP_PATH_COPY)
        memcpy(to + i, from + i, RMAP_PATH_COPY * sizeof *to);
    return to + n;
}

uint16_t rmap_path_hit_symbol(const struct rmap_path_table *table, int32_t detector)
{
    return table->symbol_of_hit[index_within(detector, table->n_detector)];
}

size_t rmap_path_place(const struct rmap_path_table *table,
                       const struct rmap_registration_columns *registration, size_t row)
{
    size_t detector = index_within(registration->detector[row], table->n_detector);
    return (size_t)registration->segment[row] + table->follows_object[detector];
}

/* Number of steps before registration i of a ray. */
static size_t place_of(const struct run *run, size_t i)
{
    return rmap_path_place(run->table, &run->portion->registration, i);
}

/* A ray's steps and, in their places, its registrations. */
static uint16_t *merge_ray(const struct run *run, const uint16_t *step, size_t n_step,
                           size_t registration, size_t n_registration, uint16_t *to)
{
    const struct rmap_path_table *table = run->table;
    const struct rmap_registration_columns *from = &run->portion->registration;
    size_t at = 0;
    for (size_t i = registration; i < registration + n_registration; i++) {
        if (!from->registered[i])
            continue;
        size_t place = place_of(run, i);
        place = place > n_step ? n_step : place;
        if (place > at) {
            to = copy_symbols(to, step + at, place - at);
            at = place;
        }
        *to++ = rmap_path_hit_symbol(table, from->detector[i]);
    }
    return copy_symbols(to, step + at, n_step - at);
}

/* True when its first symbol is that of its first step. */
static bool begins_with_step(const struct run *run, size_t registration, uint32_t n_registration)
{
    const uint8_t *registered = run->portion->registration.registered;
    for (size_t i = registration; i < registration + n_registration; i++)
        if (registered[i])
            return place_of(run, i) > 0;
    return true;
}

/* True when a ray need not be run: it does not begin as a match may, or lacks what all have. */
static bool cannot_match(const struct run *run, const uint16_t *step, uint32_t n_step,
                         size_t registration, uint32_t n_registration)
{
    const struct rmap_path_table *table = run->table;
    uint8_t met = 0;
    if (!run->skips)
        return false;
    if (run->hit_need && n_registration == 0)
        return true;
    if (n_step > 0 && table->first && !table->first[step[0]] &&
        begins_with_step(run, registration, n_registration))
        return true;
    for (uint32_t i = 0; run->step_need && i < n_step; i++)
        met |= table->needs_met[step[i]];
    return (met & run->step_need) != run->step_need;
}

/* All symbols of a group in order, each ray's last one marked. step: its first row's. */
static void merge_rows(struct run *run, const struct group *group, const uint16_t *step)
{
    const uint32_t *n_step = run->portion->ray.segment_count + group->ray;
    const uint32_t *n_registration =
        group->n_registration ? run->portion->ray.registration_count + group->ray : NULL;
    uint16_t n_symbol = (uint16_t)run->table->n_symbol;
    uint16_t *to = run->symbol;
    size_t registration = group->registration;
    for (size_t lane = 0; lane < LANES; lane++) {
        run->lane_ray[lane + 1] = group->n_ray * (lane + 1) / LANES;
        for (size_t ray = run->lane_ray[lane]; ray < run->lane_ray[lane + 1]; ray++) {
            const uint16_t *begin = to;
            uint32_t n_hit = n_registration ? n_registration[ray] : 0;
            if (cannot_match(run, step, n_step[ray], registration, n_hit))
                ;
            else if (n_hit > 0)
                to = merge_ray(run, step, n_step[ray], registration, n_hit, to);
            else
                to = copy_symbols(to, step, n_step[ray]);
            registration += n_hit;
            step += n_step[ray];
            if (to > begin)
                to[-1] = (uint16_t)(to[-1] + n_symbol);
            else
                *to++ = (uint16_t)(2 * n_symbol);
        }
        run->lane_symbol[lane + 1] = (size_t)(to - run->symbol);
    }
}

static void merge_group(struct run *run, const struct group *group, const uint16_t *step)
{
    if (!step)
        rmap_path_symbols(run->table, &run->portion->segment, group->segment, group->n_segment,
                          run->step);
    merge_rows(run, group, step ? step + group->segment : run->step);
}

/* One step of one lane: behind a ray's last symbol, the state says whether it matched. */
#define STEP(lane, i)                                                                              \
    do {                                                                                           \
        uint16_t symbol_ = at[lane][i];                                                            \
        state[lane] = next[state[lane] + symbol_];                                                 \
        *to[lane] = state[lane] == width;                                                          \
        to[lane] += symbol_ >= n_symbol;                                                           \
    } while (0)

static void run_lanes(const struct run *run, uint8_t *restrict match)
{
    const uint32_t *next = run->table->next;
    uint32_t width = run->table->width, n_symbol = run->table->n_symbol;
    uint32_t state[LANES] = {0};
    const uint16_t *at[LANES];
    uint8_t *to[LANES];
    size_t n[LANES], shared = SIZE_MAX;
    for (int lane = 0; lane < LANES; lane++) {
        at[lane] = run->symbol + run->lane_symbol[lane];
        to[lane] = match + run->lane_ray[lane];
        n[lane] = run->lane_symbol[lane + 1] - run->lane_symbol[lane];
        shared = n[lane] < shared ? n[lane] : shared;
    }
    for (size_t i = 0; i < shared; i++)
        for (int lane = 0; lane < LANES; lane++)
            STEP(lane, i);
    for (int lane = 0; lane < LANES; lane++)
        for (size_t i = shared; i < n[lane]; i++)
            STEP(lane, i);
}

/* The rays from group->ray on that fit together. False: the rows do not add up. */
static bool next_group(const struct run *run, struct group *group)
{
    const struct rmap_portion *portion = run->portion;
    size_t n_segment = portion->n_row[RMAP_TABLE_SEGMENT] - group->segment;
    size_t n_registration = portion->n_row[RMAP_TABLE_REGISTRATION] - group->registration;
    size_t n_symbol = 0;
    group->n_ray = group->n_segment = group->n_registration = 0;
    for (size_t ray = group->ray; ray < portion->n_row[RMAP_TABLE_RAY]; ray++) {
        uint32_t steps = portion->ray.segment_count[ray];
        uint32_t hits =
            portion->n_row[RMAP_TABLE_REGISTRATION] > 0 ? portion->ray.registration_count[ray] : 0;
        n_symbol += (size_t)steps + hits + 1;
        if (n_symbol > GROUP_SYMBOLS && group->n_ray > 0)
            break;
        group->n_ray++;
        group->n_segment += steps;
        group->n_registration += hits;
    }
    return group->n_segment <= n_segment && group->n_registration <= n_registration;
}

static enum rmap_status reserve(struct run *run, const struct group *group, bool has_steps,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_symbol = group->n_segment + group->n_registration + group->n_ray;
    if (n_symbol < GROUP_SYMBOLS)
        n_symbol = GROUP_SYMBOLS;
    if (!has_steps)
        RMAP_TRY(RMAP_RESERVE(run->step, run->step_cap, n_symbol + RMAP_PATH_COPY, err));
    RMAP_TRY(RMAP_RESERVE(run->symbol, run->symbol_cap, n_symbol + RMAP_PATH_COPY, err));
out:
    return st;
}

static struct run begin_run(const struct rmap_path_table *table, const struct rmap_portion *portion)
{
    struct run run = {.table = table, .portion = portion};
    run.skips = table->next[2 * (size_t)table->n_symbol] == 0;
    for (int k = 0; k < table->n_need; k++) {
        run.hit_need |= table->need[k].is_hit;
        run.step_need |= (uint8_t)(!table->need[k].is_hit << k);
    }
    return run;
}

enum rmap_status rmap_path_mark(const struct rmap_criterion_node *node,
                                const struct rmap_portion *portion, const uint16_t *step,
                                uint8_t *match, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    struct run run = begin_run(node->path.table, portion);
    struct group group = {0};
    while (group.ray < n_ray) {
        if (!next_group(&run, &group)) {
            st =
                rmap_error_set(err, RMAP_FORMAT,
                               "the rays from id %llu on do not add up to the rows of their tables",
                               (unsigned long long)portion->first_ray);
            goto out;
        }
        RMAP_TRY(reserve(&run, &group, step != NULL, err));
        merge_group(&run, &group, step);
        run_lanes(&run, match + group.ray);
        group.ray += group.n_ray;
        group.segment += group.n_segment;
        group.registration += group.n_registration;
    }
out:
    rmap_free(run.symbol);
    rmap_free(run.step);
    return st;
}
