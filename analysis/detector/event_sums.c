/* SPDX-License-Identifier: MIT
 *
 * What each event left in each of some detectors.
 */
#include "analysis/detector/event_sums.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/registration_response.h"
#include "base/alloc.h"
#include "scene/events.h"

__extension__ typedef __int128 wide; /* 2^63 amounts times 2^63 times */

/* Parts of a ns, 0.06 fs: 2^63 of them are nine minutes. */
static const double TIME_PARTS = 16777216.0; /* 2^24 */
static const int64_t NEVER = INT64_MAX;

enum { RAYS, FIRST };                                       /* words of a row, */
enum { REGISTRATIONS, AMOUNT, TIME_LOW, TIME_HIGH, EARLY }; /* and of a detector in it */

double rmap_event_part(const struct rmap_map *map)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    double all = 0.0;
    int exponent = 0;
    for (size_t s = 0; s < scene->n_source; s++)
        all += scene->source[s].flux;
    (void)frexp(all > 0.0 ? all : 1.0, &exponent);
    return ldexp(1.0, exponent - 52);
}

static size_t words_of(const struct rmap_event_ask *ask)
{
    return FIRST + ask->n_detector * (EARLY + ask->n_early);
}

double rmap_event_sums_nbytes(const struct rmap_event_ask *ask)
{
    return (double)ask->n_event * (double)words_of(ask) * sizeof(uint64_t);
}

rmap_column_set rmap_event_columns(const struct rmap_event_ask *ask)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
        RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    for (size_t d = 0; d < ask->n_detector; d++)
        if (rmap_detector_weighs(&ask->scene->detector[ask->detector[d]]))
            columns |= RMAP_RESPONSE_COLUMNS;
    return columns | (ask->timed ? rmap_registration_number_columns(RMAP_REGISTRATION_ARRIVAL) : 0);
}

static void destroy(void *state)
{
    struct rmap_event_sums *self = state;
    for (size_t p = 0; self && self->page && p < self->n_page; p++)
        rmap_free(self->page[p]);
    if (self)
        rmap_free(self->page);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_event_ask *ask = context;
    struct rmap_event_sums *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->ask = ask;
        self->n_word = words_of(ask);
        self->n_page = (ask->n_event + RMAP_EVENT_PAGE - 1) / RMAP_EVENT_PAGE;
        self->page = rmap_alloc(self->n_page + 1, sizeof *self->page);
    }
    if (self && self->page) {
        *state_ret = self;
        return RMAP_OK;
    }
    destroy(self);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu events", ask->n_event);
}

static uint64_t *detector_words(const struct rmap_event_sums *self, uint64_t *row, size_t place)
{
    return row + FIRST + place * (EARLY + self->ask->n_early);
}

static enum rmap_status new_page(const struct rmap_event_sums *self, uint64_t **page_ret,
                                 struct rmap_error *err)
{
    *page_ret = rmap_alloc(RMAP_EVENT_PAGE * self->n_word, sizeof **page_ret);
    if (!*page_ret)
        return rmap_error_set(err, RMAP_SYSTEM,
                              "out of memory for what %zu events left: ask for some, by --where "
                              "'event in 0..999999'",
                              self->ask->n_event);
    for (size_t i = 0; i < RMAP_EVENT_PAGE; i++)
        for (size_t d = 0; d < self->ask->n_detector; d++)
            for (size_t k = 0; k < self->ask->n_early; k++)
                detector_words(self, *page_ret + i * self->n_word, d)[EARLY + k] = (uint64_t)NEVER;
    return RMAP_OK;
}

static wide wide_of(const uint64_t word[2])
{
    return (wide)word[1] << 64 | word[0];
}

static void add_wide(uint64_t word[2], wide more)
{
    const wide sum = wide_of(word) + more;
    word[0] = (uint64_t)sum;
    word[1] = (uint64_t)(sum >> 64);
}

/* Among the earliest, if it is one. */
static void keep_early(uint64_t *early, size_t n, int64_t time)
{
    size_t k = n;
    for (; k > 0 && (int64_t)early[k - 1] > time; k--)
        if (k < n)
            early[k] = early[k - 1];
    if (k < n)
        early[k] = (uint64_t)time;
}

static void merge_rows(const struct rmap_event_sums *self, uint64_t *into, const uint64_t *from)
{
    into[RAYS] += from[RAYS];
    for (size_t d = 0; d < self->ask->n_detector; d++) {
        uint64_t *own = detector_words(self, into, d);
        const uint64_t *other = from + (own - into);
        own[REGISTRATIONS] += other[REGISTRATIONS];
        own[AMOUNT] += other[AMOUNT];
        add_wide(own + TIME_LOW, wide_of(other + TIME_LOW));
        for (size_t k = 0; k < self->ask->n_early; k++)
            keep_early(own + EARLY, self->ask->n_early, (int64_t)other[EARLY + k]);
    }
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_event_sums *self = into, *other = from;
    (void)err;
    for (size_t p = 0; p < self->n_page; p++) {
        for (size_t i = 0; self->page[p] && other->page[p] && i < RMAP_EVENT_PAGE; i++)
            merge_rows(self, self->page[p] + i * self->n_word, other->page[p] + i * self->n_word);
        if (self->page[p])
            continue;
        self->page[p] = other->page[p];
        other->page[p] = NULL;
    }
    return RMAP_OK;
}

/* A page's number, then its words. */
static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_event_sums *self = state;
    const size_t n_word = RMAP_EVENT_PAGE * self->n_word;
    uint64_t number = 0;
    size_t n = 0;
    for (size_t p = 0; p < self->n_page; p++)
        n += self->page[p] != NULL;
    *nbytes_ret = n * (n_word + 1) * sizeof number;
    uint8_t *bytes = *bytes_ret = rmap_alloc_unset(*nbytes_ret + 1, 1);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for what events left");
    for (; number < self->n_page; number++) {
        if (!self->page[number])
            continue;
        memcpy(bytes, &number, sizeof number);
        memcpy(bytes + sizeof number, self->page[number], n_word * sizeof number);
        bytes += (n_word + 1) * sizeof number;
    }
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = create(context, state_ret, err);
    struct rmap_event_sums *self = *state_ret;
    const size_t each = (RMAP_EVENT_PAGE * words_of(context) + 1) * sizeof(uint64_t);
    if (st == RMAP_OK && nbytes % each != 0)
        st = rmap_error_set(err, RMAP_INTERNAL, "sums of events of another size");
    for (size_t at = 0; st == RMAP_OK && at < nbytes; at += each) {
        uint64_t number;
        memcpy(&number, bytes + at, sizeof number);
        if (number >= self->n_page || self->page[number])
            return rmap_error_set(err, RMAP_INTERNAL, "sums of events of other ones");
        st = new_page(self, &self->page[number], err);
        if (st == RMAP_OK)
            memcpy(self->page[number], bytes + at + sizeof number, each - sizeof number);
    }
    return st;
}

/* Rows of /registration [first, end) of a ray whose segments begin at at->first_segment. */
static void add_registrations(struct rmap_event_sums *self, const struct rmap_matched *rays,
                              struct rmap_registration_place *at, size_t end, uint64_t *row)
{
    const struct rmap_event_ask *ask = self->ask;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counted = rmap_registrations_counted(rays);
    const struct rmap_scene *own = rmap_map_scene_of(ask->map, rays->space);
    const double flux = portion->ray.weight[at->ray] *
                        rmap_map_flux_per_weight(ask->map)[portion->ray.source[at->ray]];
    for (; at->row < end; at->row++) {
        const size_t d = (size_t)portion->registration.detector[at->row];
        if (!counted[at->row] || d >= ask->scene->n_detector || ask->place[d] < 0)
            continue;
        const struct rmap_scene *scene = d < own->n_detector ? own : ask->scene;
        double amount = flux, ns = 0.0;
        if (ask->timed)
            ns = 1e9 * rmap_registration_number(scene, portion, at->row, RMAP_REGISTRATION_ARRIVAL);
        if (!(ns <= rmap_reading_until(&scene->detector[d].reading)))
            continue;
        if (rmap_detector_weighs(&scene->detector[d]))
            amount *= rmap_registration_response(scene, portion, at);
        uint64_t *words = detector_words(self, row, (size_t)ask->place[d]);
        const uint64_t parts = (uint64_t)llround(amount / ask->part);
        const int64_t time = llround(ns * TIME_PARTS);
        words[REGISTRATIONS]++;
        words[AMOUNT] += parts;
        add_wide(words + TIME_LOW, (wide)parts * time);
        keep_early(words + EARLY, ask->n_early, time);
    }
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_event_sums *self = state;
    const struct rmap_event_ask *ask = self->ask;
    const struct rmap_portion *portion = rays->portion;
    const struct rmap_scene *own = rmap_map_scene_of(ask->map, rays->space);
    struct rmap_registration_place at = {0, 0, 0};
    size_t index = ask->n_event;
    for (size_t i = 0, row = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        uint64_t event = 0;
        at.row = row;
        at.ray = i;
        row += portion->ray.registration_count[i];
        if ((!rays->match || rays->match[i]) && rmap_scene_event(own, portion->ray.id[i], &event)) {
            if (index == ask->n_event || ask->event[index] != event)
                index = rmap_event_index(ask->event, ask->n_event, event);
            uint64_t **page = &self->page[index / RMAP_EVENT_PAGE];
            if (!*page)
                RMAP_TRY(new_page(self, page, err));
            uint64_t *words = *page + index % RMAP_EVENT_PAGE * self->n_word;
            words[RAYS]++;
            add_registrations(self, rays, &at, row, words);
        }
        at.first_segment += portion->ray.segment_count ? portion->ray.segment_count[i] : 0;
    }
out:
    return st;
}

const struct rmap_fold_kind rmap_event_kind = {.create = create,
                                               .destroy = destroy,
                                               .add = add,
                                               .merge = merge,
                                               .pack = pack,
                                               .unpack = unpack};

static uint64_t *row_of(const struct rmap_event_sums *sums, size_t index)
{
    uint64_t *page = sums->page[index / RMAP_EVENT_PAGE];
    return page ? page + index % RMAP_EVENT_PAGE * sums->n_word : NULL;
}

uint64_t rmap_event_sums_rays(const struct rmap_event_sums *sums, size_t index)
{
    const uint64_t *row = row_of(sums, index);
    return row ? row[RAYS] : 0;
}

void rmap_event_sums_read(const struct rmap_event_sums *sums, size_t index, size_t place,
                          struct rmap_event_reading *reading)
{
    const uint64_t *words = detector_words(sums, row_of(sums, index), place);
    reading->registrations = words[REGISTRATIONS];
    reading->sum = (double)words[AMOUNT] * sums->ask->part;
    reading->mean_ns = sums->ask->timed && words[AMOUNT] > 0
                           ? (double)wide_of(words + TIME_LOW) / (double)words[AMOUNT] / TIME_PARTS
                           : (double)NAN;
    for (size_t k = 0; k < sums->ask->n_early; k++) {
        const int64_t time = (int64_t)words[EARLY + k];
        reading->early_ns[k] = time == NEVER ? (double)INFINITY : (double)time / TIME_PARTS;
    }
}
