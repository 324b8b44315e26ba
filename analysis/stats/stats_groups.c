/* SPDX-License-Identifier: MIT
 *
 * What statistics are told apart by.
 */
#include "analysis/stats/stats_groups.h"

#include <inttypes.h>
#include <stdio.h>

#include "base/alloc.h"
#include "portion/event.h"
#include "scene/events.h"

/* Orders from here on are one group. */
enum { HIGH_ORDER = 15, STOPS = 4, EVENTS_MAX = 1000 };

const char *rmap_stats_by_word(enum rmap_stats_by by)
{
    static const char *const word[RMAP_STATS_BY_COUNT] = {
        NULL,        "source",      "detector",      "object",
        "ended",     "ghost_order", "scatter_order", "event",
        "criterion", "path",        "path:object",   "path:group"};
    return word[by];
}

static bool is_order(enum rmap_stats_by by)
{
    return by == RMAP_STATS_BY_GHOST_ORDER || by == RMAP_STATS_BY_SCATTER_ORDER;
}

size_t rmap_stats_group_count(enum rmap_stats_by by, const struct rmap_quantities *quantities)
{
    const struct rmap_scene *scene = quantities ? quantities->scene : NULL;
    if (is_order(by))
        return HIGH_ORDER + 1;
    return by == RMAP_STATS_BY_SOURCE     ? scene->n_source
           : by == RMAP_STATS_BY_DETECTOR ? scene->n_detector
           : by == RMAP_STATS_BY_OBJECT   ? scene->n_object + 1
           : by == RMAP_STATS_BY_ENDED    ? STOPS
           : by == RMAP_STATS_BY_EVENT    ? quantities->n_event + 1
                                          : 1;
}

const char *rmap_stats_group_name(enum rmap_stats_by by, const struct rmap_quantities *quantities,
                                  size_t group)
{
    const struct rmap_scene *scene = quantities ? quantities->scene : NULL;
    static const char *const order[HIGH_ORDER + 1] = {"0",  "1",  "2",  "3",         "4",  "5",
                                                      "6",  "7",  "8",  "9",         "10", "11",
                                                      "12", "13", "14", "15 or more"};
    if (is_order(by))
        return order[group];
    if (by == RMAP_STATS_BY_EVENT)
        return group < quantities->n_event ? quantities->event_name[group] : "(none)";
    if (by == RMAP_STATS_BY_OBJECT)
        return group < scene->n_object ? scene->object[group].name : "(none)";
    return by == RMAP_STATS_BY_SOURCE     ? scene->source[group].name
           : by == RMAP_STATS_BY_DETECTOR ? scene->detector[group].name
           : by == RMAP_STATS_BY_ENDED    ? rmap_stop_word((int)group)
                                          : NULL;
}

bool rmap_stats_group_of_registration(enum rmap_stats_by by,
                                      const struct rmap_quantities *quantities)
{
    return quantities->of_registrations &&
           (by == RMAP_STATS_BY_DETECTOR || by == RMAP_STATS_BY_OBJECT || is_order(by));
}

static enum rmap_status list_events(struct rmap_quantities *quantities, struct rmap_error *err)
{
    const char *trouble = rmap_scene_events_trouble(quantities->scene);
    if (trouble)
        return rmap_error_set(err, RMAP_INPUT, "--by event: %s", trouble);
    enum rmap_status st =
        rmap_scene_events(quantities->scene, &quantities->event, &quantities->n_event, err);
    if (st != RMAP_OK)
        return st;
    if (quantities->n_event > EVENTS_MAX)
        return rmap_error_set(err, RMAP_INPUT,
                              "--by event tells %d events apart at most, and this map has %zu: "
                              "`raymap events` has a table of all",
                              EVENTS_MAX, quantities->n_event);
    quantities->event_name = rmap_alloc(quantities->n_event + 1, sizeof *quantities->event_name);
    if (!quantities->event_name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for events");
    for (size_t i = 0; i < quantities->n_event; i++)
        (void)snprintf(quantities->event_name[i], sizeof quantities->event_name[i], "%" PRIu64,
                       quantities->event[i]);
    quantities->columns |= RMAP_COLUMN_BIT(RMAP_RAY_id);
    return RMAP_OK;
}

enum rmap_status rmap_stats_group_prepare(enum rmap_stats_by by, struct rmap_quantities *quantities,
                                          struct rmap_error *err)
{
    const rmap_column_set rows =
        RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_SEGMENT_object);
    enum rmap_status st = RMAP_OK;
    if (is_order(by) && !quantities->order.makes_ghosts)
        st = rmap_path_order_init(&quantities->order, quantities->scene, err);
    if (by == RMAP_STATS_BY_EVENT)
        st = list_events(quantities, err);
    quantities->columns |= quantities->order.columns;
    if (by == RMAP_STATS_BY_OBJECT)
        quantities->columns |= rows;
    if (rmap_stats_group_of_registration(by, quantities))
        quantities->columns |= RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                               RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
                               RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    if (by == RMAP_STATS_BY_ENDED)
        quantities->columns |= RMAP_COLUMN_BIT(RMAP_RAY_stop);
    return st;
}

void rmap_stats_marks_fini(struct rmap_stats_marks *marks)
{
    rmap_free(marks->group);
    rmap_free(marks->other);
    *marks = (struct rmap_stats_marks){0};
}

/* Of the segments [first, end): the object of the last one that met any, else `none`. */
static uint32_t last_object(const struct rmap_portion *portion, size_t first, size_t end,
                            uint32_t none)
{
    const int32_t *object = portion->segment.object;
    while (end > first && (uint32_t)object[end - 1] >= none)
        end--;
    return end > first ? (uint32_t)object[end - 1] : none;
}

static void mark_objects(const struct rmap_portion *portion, bool its, uint32_t none,
                         uint32_t *group)
{
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0, first = 0, row = 0; i < n_ray; i++) {
        const size_t n = portion->ray.segment_count[i];
        if (!its)
            group[i] = last_object(portion, first, first + n, none);
        for (size_t end = its ? row + portion->ray.registration_count[i] : row; row < end; row++) {
            const size_t before = portion->registration.segment[row];
            group[row] = last_object(portion, first, first + (before < n ? before : n), none);
        }
        first += n;
    }
}

static void mark_orders(enum rmap_stats_by by, const struct rmap_quantities *quantities, bool its,
                        const struct rmap_portion *portion, size_t n,
                        struct rmap_stats_marks *marks)
{
    const bool scatter = by == RMAP_STATS_BY_SCATTER_ORDER;
    uint32_t *ghosts = scatter ? marks->other : marks->group;
    uint32_t *scatters = scatter ? marks->group : marks->other;
    if (its)
        rmap_path_orders_of_registrations(&quantities->order, portion, ghosts, scatters);
    else
        rmap_path_orders_of_rays(&quantities->order, portion, ghosts, scatters);
    for (size_t k = 0; k < n; k++)
        if (marks->group[k] > HIGH_ORDER)
            marks->group[k] = HIGH_ORDER;
}

static void mark_events(const struct rmap_quantities *quantities,
                        const struct rmap_portion *portion, uint32_t *group)
{
    const size_t n = quantities->n_event;
    size_t index = n; /* rays of an event mostly come one after the other */
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        uint64_t event = 0;
        group[i] = (uint32_t)n;
        if (!rmap_scene_event(quantities->scene, portion->ray.id[i], &event))
            continue;
        if (index == n || quantities->event[index] != event)
            index = rmap_event_index(quantities->event, n, event);
        group[i] = (uint32_t)index;
    }
}

enum rmap_status rmap_stats_group_mark(enum rmap_stats_by by,
                                       const struct rmap_quantities *quantities,
                                       const struct rmap_portion *portion,
                                       struct rmap_stats_marks *marks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool its = rmap_stats_group_of_registration(by, quantities);
    const size_t n = portion->n_row[its ? RMAP_TABLE_REGISTRATION : RMAP_TABLE_RAY];
    RMAP_TRY(RMAP_RESERVE(marks->group, marks->group_cap, n + 1, err));
    if (is_order(by)) {
        RMAP_TRY(RMAP_RESERVE(marks->other, marks->other_cap, n + 1, err));
        mark_orders(by, quantities, its, portion, n, marks);
    } else if (by == RMAP_STATS_BY_EVENT) {
        mark_events(quantities, portion, marks->group);
    } else if (by == RMAP_STATS_BY_OBJECT) {
        mark_objects(portion, its, (uint32_t)quantities->scene->n_object, marks->group);
    } else {
        for (size_t k = 0; k < n; k++)
            marks->group[k] = by == RMAP_STATS_BY_DETECTOR
                                  ? (uint32_t)portion->registration.detector[k]
                              : by == RMAP_STATS_BY_ENDED ? portion->ray.stop[k]
                                                          : (uint32_t)portion->ray.source[k];
    }
out:
    return st;
}
