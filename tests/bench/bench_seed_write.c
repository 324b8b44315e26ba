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
#include "mpi/parallel/progress.h"
#include "portion/portion.h"
#include "portion/portion_recorder.h"
#include "trace/tracer.h"

/* A growing array of one stream's bytes. */
struct stream {
    uint8_t *byte;
    size_t n, cap;
};

/* Records rays as the reference does. */
struct recorder {
    struct rmap_recorder base;
    int n_channel;
    int16_t source;
    uint32_t n_device, first_device;
    struct rmap_seed_segment next; /* begins at the point reached; its event is not known yet */
    struct stream stream[RMAP_SEED_STREAMS];
    enum rmap_status status;
    uint64_t n_segment;
};

static void *extend(struct recorder *self, enum rmap_seed_stream which, size_t nbytes)
{
    struct stream *stream = &self->stream[which];
    if (RMAP_RESERVE(stream->byte, stream->cap, stream->n + nbytes, NULL) != RMAP_OK) {
        self->status = RMAP_SYSTEM;
        return NULL;
    }
    stream->n += nbytes;
    return stream->byte + stream->n - nbytes;
}

static void set_place(struct rmap_seed_segment *record, struct rmap_vec3 point,
                      struct rmap_vec3 normal, int32_t object, int32_t triangle)
{
    record->point[0] = (float)point.x;
    record->point[1] = (float)point.y;
    record->point[2] = (float)point.z;
    record->normal[0] = (int16_t)lrint(normal.x * 32767.0);
    record->normal[1] = (int16_t)lrint(normal.y * 32767.0);
    record->normal[2] = (int16_t)lrint(normal.z * 32767.0);
    record->object = (int16_t)object;
    record->triangle = triangle;
}

static void append_record(struct recorder *self, uint32_t event, const double *colour)
{
    struct rmap_seed_segment *record = extend(self, RMAP_SEED_SEGMENT, sizeof *record);
    uint16_t *quantised = extend(self, RMAP_SEED_COLOUR, 2 * (size_t)self->n_channel);
    if (!record || !quantised)
        return;
    self->next.event = event;
    self->next.source = self->source;
    self->next.first_device = self->first_device;
    self->next.n_device = (uint16_t)(self->n_device - self->first_device);
    memcpy(record, &self->next, sizeof *record);
    self->first_device = self->n_device;
    if (colour)
        rmap_colour_quantise(colour, self->n_channel, quantised);
    else
        memset(quantised, 0, 2 * (size_t)self->n_channel);
}

static void record_emit(struct rmap_recorder *base, const struct rmap_emission *emission)
{
    struct recorder *self = (struct recorder *)base;
    self->source = (int16_t)emission->source;
    set_place(&self->next, emission->position, emission->normal, emission->object,
              emission->primitive);
}

/* A record tells a segment's start and what happened at its end. */
static void record_step(struct rmap_recorder *base, const struct rmap_step *step)
{
    struct recorder *self = (struct recorder *)base;
    self->n_segment++;
    append_record(self, step->events, step->colour);
    set_place(&self->next, step->position, step->normal, step->object, step->primitive);
}

static void record_registration(struct rmap_recorder *base,
                                const struct rmap_registration *registration)
{
    struct recorder *self = (struct recorder *)base;
    struct rmap_seed_device *device = extend(self, RMAP_SEED_DEVICE, sizeof *device);
    if (!device)
        return;
    self->n_device++;
    *device = (struct rmap_seed_device){
        .device = (int16_t)registration->detector,
        .cell = {(uint16_t)registration->cell[0], (uint16_t)registration->cell[1]},
        .cosine = (int16_t)lrint(registration->cosine * 32767.0),
        .relative = {(uint16_t)lrint(registration->relative[0] * 65535.0),
                     (uint16_t)lrint(registration->relative[1] * 65535.0)},
        .registered = registration->registered};
}

static void record_end(struct rmap_recorder *base, const struct rmap_ending *ending)
{
    struct recorder *self = (struct recorder *)base;
    if (ending->stop == RMAP_STOP_LEFT) { /* the extra record keeps the direction */
        self->next.normal[0] = (int16_t)lrint(ending->direction.x * 32767.0);
        self->next.normal[1] = (int16_t)lrint(ending->direction.y * 32767.0);
        self->next.normal[2] = (int16_t)lrint(ending->direction.z * 32767.0);
    }
    append_record(self, RMAP_SEED_END, NULL);
}

struct writer {
    const struct rmap_scene *scene;
    const struct rmap_accel *accel;
    uint64_t n_ray;
    _Atomic uint64_t next_block;
    _Atomic uint64_t n_segment;
    _Atomic bool failed;
    pthread_mutex_t mutex; /* of the file */
    FILE *file;
};

/* Compresses outside the lock, writes under it. */
static enum rmap_status write_portion(struct writer *writer, struct recorder *recorder)
{
    struct rmap_seed_header header;
    uint8_t *packed[RMAP_SEED_STREAMS] = {NULL};
    enum rmap_status st = recorder->status;
    for (int i = 0; i < RMAP_SEED_STREAMS && st == RMAP_OK; i++) {
        const struct stream *stream = &recorder->stream[i];
        uLongf n = compressBound((uLong)stream->n);
        packed[i] = rmap_alloc(n, 1);
        if (!packed[i] || compress2(packed[i], &n, stream->n ? stream->byte : packed[i],
                                    (uLong)stream->n, 1) != Z_OK)
            st = RMAP_SYSTEM;
        header.stored[i] = n;
        header.raw[i] = stream->n;
    }
    if (st == RMAP_OK) {
        (void)pthread_mutex_lock(&writer->mutex);
        bool written = fwrite(&header, sizeof header, 1, writer->file) == 1;
        for (int i = 0; i < RMAP_SEED_STREAMS; i++)
            written =
                written && fwrite(packed[i], 1, header.stored[i], writer->file) == header.stored[i];
        (void)pthread_mutex_unlock(&writer->mutex);
        st = written ? RMAP_OK : RMAP_SYSTEM;
    }
    for (int i = 0; i < RMAP_SEED_STREAMS; i++)
        rmap_free(packed[i]);
    return st;
}

static void work(void *context, int thread)
{
    struct writer *writer = context;
    struct rmap_tracer tracer = {.scene = writer->scene, .accel = writer->accel, .seed = 1};
    struct recorder recorder = {.base = {.emit = record_emit,
                                         .step = record_step,
                                         .registration = record_registration,
                                         .end = record_end},
                                .n_channel = writer->scene->channels.n};
    uint64_t n_block = (writer->n_ray + RMAP_BLOCK_RAYS - 1) / RMAP_BLOCK_RAYS, block;
    (void)thread;
    while (!atomic_load(&writer->failed) &&
           (block = atomic_fetch_add(&writer->next_block, 1)) < n_block) {
        uint64_t first = block * RMAP_BLOCK_RAYS, last = first + RMAP_BLOCK_RAYS;
        for (int i = 0; i < RMAP_SEED_STREAMS; i++)
            recorder.stream[i].n = 0;
        recorder.n_device = recorder.first_device = 0;
        for (uint64_t ray = first; ray < last && ray < writer->n_ray; ray++)
            rmap_trace_ray(&tracer, ray, &recorder.base);
        if (write_portion(writer, &recorder) != RMAP_OK)
            atomic_store(&writer->failed, true);
    }
    atomic_fetch_add(&writer->n_segment, recorder.n_segment);
    for (int i = 0; i < RMAP_SEED_STREAMS; i++)
        rmap_free(recorder.stream[i].byte);
}

enum rmap_status rmap_seed_record(const struct rmap_scene *scene, const struct rmap_accel *accel,
                                  uint64_t n_ray, int n_thread, const char *path,
                                  struct rmap_seed_result *result, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    struct writer writer = {.scene = scene, .accel = accel, .n_ray = n_ray};
    double begun = rmap_clock_seconds();
    writer.file = fopen(path, "wb");
    if (!writer.file)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", path, strerror(errno));
    (void)pthread_mutex_init(&writer.mutex, NULL);
    RMAP_TRY(rmap_workers_start(n_thread, work, &writer, &workers, err));
    rmap_workers_join(workers);
    if (atomic_load(&writer.failed))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s'", path));
    result->n_segment = atomic_load(&writer.n_segment);
    result->nbytes = (uint64_t)ftell(writer.file);
out:
    (void)pthread_mutex_destroy(&writer.mutex);
    if (fclose(writer.file) != 0 && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", path, strerror(errno));
    result->seconds = rmap_clock_seconds() - begun;
    return st;
}
