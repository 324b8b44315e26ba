/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <libdeflate.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/bench_seed.h"
#include "mpi/bench_seed_record.h"
#include "mpi/progress.h"

struct reader {
    const struct rmap_seed_question *question; /* NULL: inflate only, by libdeflate */
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
    struct libdeflate_decompressor *quick; /* NULL: zlib */
};

static enum rmap_status make_room(struct portion *portion)
{
    for (int i = 0; i < RMAP_SEED_STREAMS; i++) {
        void *stored = portion->stored[i], *raw = portion->raw[i];
        enum rmap_status st =
            rmap_reserve(&stored, &portion->stored_cap[i], portion->header.stored[i] + 1, 1, NULL);
        portion->stored[i] = stored;
        if (st == RMAP_OK)
            st = rmap_reserve(&raw, &portion->raw_cap[i], portion->header.raw[i] + 1, 1, NULL);
        portion->raw[i] = raw;
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
            if (libdeflate_zlib_decompress(portion->quick, portion->stored[i],
                                           portion->header.stored[i], portion->raw[i], n,
                                           NULL) != LIBDEFLATE_SUCCESS)
                return false;
        } else if (uncompress(portion->raw[i], &n, portion->stored[i],
                              (uLong)portion->header.stored[i]) != Z_OK)
            return false;
    }
    return true;
}

static bool registered(const struct rmap_seed_question *question,
                       const struct rmap_seed_segment *record,
                       const struct rmap_seed_device *device)
{
    for (uint32_t d = record->first_device; d < record->first_device + record->n_device; d++) {
        double u = device[d].relative[0] / 65535.0, v = device[d].relative[1] / 65535.0;
        if (device[d].device == question->detector && device[d].registered &&
            u >= question->from[0] && u <= question->to[0] && v >= question->from[1] &&
            v <= question->to[1])
            return true;
    }
    return false;
}

/* Rays of a portion that match. A record's event took place on the object of the next record. */
static uint64_t count_matches(const struct rmap_seed_question *question,
                              const struct portion *portion)
{
    const struct rmap_seed_segment *record = (const void *)portion->raw[RMAP_SEED_SEGMENT];
    const struct rmap_seed_device *device = (const void *)portion->raw[RMAP_SEED_DEVICE];
    size_t n = portion->header.raw[RMAP_SEED_SEGMENT] / sizeof *record;
    uint64_t matches = 0;
    int met = 0;
    bool seen = false;
    for (size_t i = 0; i < n; i++) {
        seen = seen || registered(question, &record[i], device);
        if (record[i].event != RMAP_SEED_END) {
            int16_t object = i + 1 < n ? record[i + 1].object : -1;
            met += object >= 0 && (size_t)object < question->n_object && question->in_set[object] &&
                   (record[i].event & question->events);
            continue;
        }
        matches += record[i].source == question->source && seen && met >= question->at_least;
        met = 0;
        seen = false;
    }
    return matches;
}

static void work(void *context, int thread)
{
    struct reader *reader = context;
    struct portion portion = {0};
    (void)thread;
    if (!reader->question && !(portion.quick = libdeflate_alloc_decompressor()))
        atomic_store(&reader->failed, true);
    while (!atomic_load(&reader->failed) && read_portion(reader, &portion)) {
        if (!inflate_portion(&portion))
            atomic_store(&reader->failed, true);
        else if (reader->question)
            atomic_fetch_add(&reader->n_match, count_matches(reader->question, &portion));
    }
    libdeflate_free_decompressor(portion.quick);
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
