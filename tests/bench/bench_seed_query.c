/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "bench_seed.h"
#include "bench_seed_record.h"
#include "io/codec/zlib_stream.h"
#include "mpi/parallel/progress.h"
#include "portion/event.h"

struct reader {
    const struct rmap_seed_question *question; /* NULL: inflate only, by the fastest */
    pthread_mutex_t mutex;                     /* of the file */
    FILE *file;
    _Atomic uint64_t n_match;
    _Atomic bool failed;
};

/* A portion's three streams: read as stored, then inflated. */
struct portion {
    struct rmap_seed_header header;
    uint8_t *stored[RMAP_SEED_STREAMS], *raw[RMAP_SEED_STREAMS];
    size_t stored_cap[RMAP_SEED_STREAMS], raw_cap[RMAP_SEED_STREAMS];
    struct rmap_inflater *quick; /* NULL: zlib */
};

static enum rmap_status make_room(struct portion *portion)
{
    for (int i = 0; i < RMAP_SEED_STREAMS; i++) {
        enum rmap_status st = RMAP_RESERVE(portion->stored[i], portion->stored_cap[i],
                                           portion->header.stored[i] + RMAP_INFLATE_SLACK, NULL);
        if (st == RMAP_OK)
            st = RMAP_RESERVE(portion->raw[i], portion->raw_cap[i], portion->header.raw[i] + 1,
                              NULL);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

/* Reads the next portion under the lock; false at the end of the file or on failure. */
static bool read_portion(struct reader *reader, struct portion *portion)
{
    (void)pthread_mutex_lock(&reader->mutex);
    bool good = fread(&portion->header, sizeof portion->header, 1, reader->file) == 1;
    if (good && make_room(portion) != RMAP_OK) {
        atomic_store(&reader->failed, true);
        good = false;
    }
    for (int i = 0; i < RMAP_SEED_STREAMS && good; i++)
        good = fread(portion->stored[i], 1, portion->header.stored[i], reader->file) ==
               portion->header.stored[i];
    (void)pthread_mutex_unlock(&reader->mutex);
    return good;
}

static bool inflate_portion(struct portion *portion)
{
    for (int i = 0; i < RMAP_SEED_STREAMS; i++) {
        uLongf n = (uLongf)portion->header.raw[i];
        if (portion->quick) {
            if (!rmap_inflate(portion->quick, portion->stored[i], portion->header.stored[i],
                              portion->raw[i], n))
                return false;
        } else if (uncompress(portion->raw[i], &n, portion->stored[i],
                              (uLong)portion->header.stored[i]) != Z_OK)
            return false;
    }
    return true;
}

/* A ray's records: n segments and the end. */
struct history {
    const struct rmap_seed_segment *record;
    const struct rmap_seed_device *device; /* of the portion */
    size_t n;
};

static bool is_in(const struct rmap_seed_question *question, const bool *in_set, int16_t object)
{
    return object >= 0 && (size_t)object < question->n_object && in_set[object];
}

static bool registered(const struct rmap_seed_question *question, const struct history *ray)
{
    uint32_t first = ray->record[0].first_device;
    uint32_t last = ray->record[ray->n].first_device + ray->record[ray->n].n_device;
    for (uint32_t d = first; d < last; d++) {
        const struct rmap_seed_device *device = &ray->device[d];
        double u = device->relative[0] / 65535.0, v = device->relative[1] / 65535.0;
        if (device->device == question->detector && device->registered && u >= question->from[0] &&
            u <= question->to[0] && v >= question->from[1] && v <= question->to[1] &&
            device->cosine / 32767.0 > question->least_cosine)
            return true;
    }
    return false;
}

/* A record's event took place on the object of the next record. */
static bool met_often(const struct rmap_seed_question *question, const struct history *ray)
{
    int met = 0;
    for (size_t i = 0; i < ray->n; i++)
        met += (ray->record[i].event & question->events) &&
               is_in(question, question->in_set, ray->record[i + 1].object);
    return met >= question->at_least && met <= question->at_most;
}

static bool went_far(const struct rmap_seed_question *question, const struct history *ray)
{
    double length = 0.0;
    for (size_t i = 0; i < ray->n; i++) {
        const float *a = ray->record[i].point, *b = ray->record[i + 1].point;
        if (!(ray->record[i].event & RMAP_EVENT_LEFT))
            length += sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) +
                           (b[2] - a[2]) * (b[2] - a[2]));
    }
    return length >= question->longest;
}

/* A record's devices were met before its event: on the way, or on the surface that it starts from.
 */
static bool in_order(const struct rmap_seed_question *question, const struct history *ray)
{
    int done = 0;
    for (size_t i = 0; i <= ray->n && done < question->n_element; i++) {
        const struct rmap_seed_segment *record = &ray->record[i];
        for (uint32_t d = 0; d < record->n_device && done < question->n_element; d++) {
            const struct rmap_seed_device *device = &ray->device[record->first_device + d];
            const struct rmap_seed_element *next = &question->element[done];
            done += !next->events && device->device == next->detector && device->registered;
        }
        if (done == question->n_element || i == ray->n)
            break;
        const struct rmap_seed_element *next = &question->element[done];
        if ((record->event & next->events) && is_in(question, next->in_set, record[1].object))
            done++;
        else if (done == 0)
            return false;
    }
    return done == question->n_element;
}

static bool matches(const struct rmap_seed_question *question, const struct history *ray)
{
    return (question->source < 0 || ray->record[0].source == question->source) &&
           met_often(question, ray) && (question->detector < 0 || registered(question, ray)) &&
           (isinf(question->longest) || !went_far(question, ray)) && in_order(question, ray);
}

/* Rays of a portion that match. */
static uint64_t count_matches(const struct rmap_seed_question *question,
                              const struct portion *portion)
{
    const struct rmap_seed_segment *record = (const void *)portion->raw[RMAP_SEED_SEGMENT];
    size_t n = portion->header.raw[RMAP_SEED_SEGMENT] / sizeof *record, first = 0;
    uint64_t n_match = 0;
    for (size_t i = 0; i < n; i++) {
        if (record[i].event != RMAP_SEED_END)
            continue;
        n_match += matches(question,
                           &(struct history){.record = record + first,
                                             .device = (const void *)portion->raw[RMAP_SEED_DEVICE],
                                             .n = i - first});
        first = i + 1;
    }
    return n_match;
}

static void work(void *context, int thread)
{
    struct reader *reader = context;
    struct portion portion = {0};
    (void)thread;
    if (!reader->question && rmap_inflater_create(&portion.quick, NULL) != RMAP_OK)
        atomic_store(&reader->failed, true);
    while (!atomic_load(&reader->failed) && read_portion(reader, &portion)) {
        if (!inflate_portion(&portion))
            atomic_store(&reader->failed, true);
        else if (reader->question)
            atomic_fetch_add(&reader->n_match, count_matches(reader->question, &portion));
    }
    rmap_inflater_destroy(portion.quick);
    for (int i = 0; i < RMAP_SEED_STREAMS; i++) {
        rmap_free(portion.stored[i]);
        rmap_free(portion.raw[i]);
    }
}

/* Every portion of the file, by whoever of the threads is free. */
static enum rmap_status read_all(const char *path, struct reader *reader, int n_thread,
                                 double *seconds_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    double begun = rmap_clock_seconds();
    reader->file = fopen(path, "rb");
    if (!reader->file)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot read '%s': %s", path, strerror(errno));
    (void)pthread_mutex_init(&reader->mutex, NULL);
    RMAP_TRY(rmap_workers_start(n_thread, work, reader, &workers, err));
    rmap_workers_join(workers);
    if (atomic_load(&reader->failed))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "cannot read '%s' back", path));
    *seconds_ret = rmap_clock_seconds() - begun;
out:
    (void)pthread_mutex_destroy(&reader->mutex);
    (void)fclose(reader->file);
    return st;
}

enum rmap_status rmap_seed_query(const char *path, const struct rmap_seed_question *question,
                                 int n_thread, uint64_t *n_ray_ret, double *seconds_ret,
                                 struct rmap_error *err)
{
    struct reader reader = {.question = question};
    enum rmap_status st = read_all(path, &reader, n_thread, seconds_ret, err);
    *n_ray_ret = atomic_load(&reader.n_match);
    return st;
}

enum rmap_status rmap_seed_inflate(const char *path, int n_thread, double *seconds_ret,
                                   struct rmap_error *err)
{
    struct reader reader = {.question = NULL};
    return read_all(path, &reader, n_thread, seconds_ret, err);
}
