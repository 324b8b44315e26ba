/* SPDX-License-Identifier: MIT
 *
 * Telling of ranks that do not answer: stopped, or on a host that died.
 */
#include "mpi/parallel/watchdog.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"

enum { TAG_BEAT = 81, LINES_MAX = 8 };
enum beat { BEAT_WORKING, BEAT_DONE, BEAT_BYE };

typedef char host_name[MPI_MAX_PROCESSOR_NAME];

/* Rank 0's: what it knows of a rank. */
struct ward {
    double heard, told; /* clock seconds; told: 0 unless it is silent */
    int beat;
};

struct rmap_watchdog {
    MPI_Comm comm; /* of the threads alone */
    int rank, size;
    double silence_s;
    pthread_t thread;
    bool runs;
    pthread_mutex_t lock;   /* of all below */
    pthread_cond_t changed; /* beat */
    int beat;               /* this rank's */
    double end_at;          /* clock seconds; 0: whenever it ends */
    struct ward *ward;      /* [size], on rank 0 */
    host_name *host;        /* likewise */
};

/* 1, unless a test is in a hurry. */
static double pace(void)
{
    const char *given = getenv("RAYMAP_TEST_PACE");
    double factor = given ? strtod(given, NULL) : 1.0;
    return factor > 0.0 && factor < 1.0 ? factor : 1.0;
}

double rmap_watchdog_silence_s(void)
{
    return 20.0 * pace();
}

double rmap_watchdog_grace_s(void)
{
    return 30.0 * pace();
}

/* With the lock. Until the time has passed, or this rank's beat is another. */
static void rest(struct rmap_watchdog *self, double seconds)
{
    struct timespec until;
    int before = self->beat, code = 0;
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    double at = (double)until.tv_nsec * 1e-9 + seconds;
    until.tv_sec += (time_t)at;
    until.tv_nsec = (long)((at - (double)(time_t)at) * 1e9);
    while (code == 0 && self->beat == before)
        code = pthread_cond_timedwait(&self->changed, &self->lock, &until);
}

/* ---- the other ranks ---- */

/* One message at a time is under way: a rank 0 that is stopped is not flooded. MPI's errors are met
 * by the main thread, too, and reported there. */
static void *say_alive(void *argument)
{
    struct rmap_watchdog *self = argument;
    MPI_Request request = MPI_REQUEST_NULL;
    int word = -1, sent = 0;
    double sent_at = 0.0;
    while (word != BEAT_BYE || !sent) {
        if (MPI_Test(&request, &sent, MPI_STATUS_IGNORE) != MPI_SUCCESS)
            break;
        (void)pthread_mutex_lock(&self->lock);
        if (!sent)
            rest(self, 0.02);
        else if (word != BEAT_BYE && self->beat == word)
            rest(self, sent_at + self->silence_s / 4 - rmap_clock_seconds());
        int next = self->beat;
        (void)pthread_mutex_unlock(&self->lock);
        if (!sent || word == BEAT_BYE)
            continue;
        word = next;
        sent = 0;
        sent_at = rmap_clock_seconds();
        if (MPI_Isend(&word, 1, MPI_INT, 0, TAG_BEAT, self->comm, &request) != MPI_SUCCESS)
            break;
    }
    return NULL;
}

/* ---- rank 0 ---- */

static void hear(struct rmap_watchdog *self, int from, int beat, double now)
{
    struct ward *ward = &self->ward[from];
    if (ward->told > 0.0)
        fprintf(stderr, "raymap: rank %d on %s answers again, after %.0f s\n", from,
                self->host[from], now - ward->heard);
    *ward = (struct ward){.heard = now, .beat = beat};
}

static bool receive(struct rmap_watchdog *self, double now)
{
    int waiting = 0, beat = 0;
    MPI_Status status;
    for (;;) {
        if (MPI_Iprobe(MPI_ANY_SOURCE, TAG_BEAT, self->comm, &waiting, &status) != MPI_SUCCESS)
            return false;
        if (!waiting)
            return true;
        if (MPI_Recv(&beat, 1, MPI_INT, status.MPI_SOURCE, TAG_BEAT, self->comm,
                     MPI_STATUS_IGNORE) != MPI_SUCCESS)
            return false;
        (void)pthread_mutex_lock(&self->lock);
        hear(self, status.MPI_SOURCE, beat, now);
        (void)pthread_mutex_unlock(&self->lock);
    }
}

/* With the lock. Again after three times the silence; of many ranks, as on a dead host, some. */
static void tell_silent(struct rmap_watchdog *self, double now)
{
    int n = 0;
    for (int r = 1; r < self->size; r++) {
        struct ward *ward = &self->ward[r];
        if (ward->beat == BEAT_BYE || now - ward->heard < self->silence_s ||
            (ward->told > 0.0 && now - ward->told < 3 * self->silence_s))
            continue;
        ward->told = now;
        if (n++ < LINES_MAX)
            fprintf(stderr, "raymap: rank %d on %s has not answered for %.0f s\n", r, self->host[r],
                    now - ward->heard);
    }
    if (n > LINES_MAX)
        fprintf(stderr, "raymap: nor have %d more ranks\n", n - LINES_MAX);
}

/* With the lock. Seconds in which rank 0 itself was stopped are nobody's silence. */
static void forgive(struct rmap_watchdog *self, double seconds)
{
    for (int r = 1; r < self->size; r++)
        self->ward[r].heard += seconds;
}

/* With the lock. */
static bool all_gone(const struct rmap_watchdog *self)
{
    bool gone = self->beat == BEAT_BYE;
    for (int r = 1; gone && r < self->size; r++)
        gone = self->ward[r].beat == BEAT_BYE;
    return gone;
}

static void *listen_to_all(void *argument)
{
    struct rmap_watchdog *self = argument;
    double last = rmap_clock_seconds();
    bool gone = false;
    while (!gone) {
        double now = rmap_clock_seconds();
        if (!receive(self, now))
            break;
        (void)pthread_mutex_lock(&self->lock);
        if (now - last > self->silence_s / 4)
            forgive(self, now - last);
        last = now;
        tell_silent(self, now);
        if (self->end_at > 0.0 && now > self->end_at)
            (void)MPI_Abort(self->comm, RMAP_STOPPED);
        gone = all_gone(self);
        if (!gone)
            rest(self, self->beat == BEAT_BYE ? 0.001 : self->silence_s / 20);
        (void)pthread_mutex_unlock(&self->lock);
    }
    return NULL;
}

/* ---- both ---- */

static void destroy(struct rmap_watchdog *self)
{
    if (self->comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&self->comm);
    (void)pthread_cond_destroy(&self->changed);
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self->host);
    rmap_free(self->ward);
    rmap_free(self);
}

static struct rmap_watchdog *create(const struct rmap_context *context)
{
    struct rmap_watchdog *self = rmap_alloc(1, sizeof *self);
    pthread_condattr_t steady;
    if (!self)
        return NULL;
    *self = (struct rmap_watchdog){.comm = MPI_COMM_NULL,
                                   .rank = context->rank,
                                   .size = context->size,
                                   .silence_s = rmap_watchdog_silence_s()};
    (void)pthread_mutex_init(&self->lock, NULL);
    (void)pthread_condattr_init(&steady);
    (void)pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    (void)pthread_cond_init(&self->changed, &steady);
    (void)pthread_condattr_destroy(&steady);
    size_t n = context->rank == 0 ? (size_t)context->size : 1;
    self->ward = rmap_alloc(n, sizeof *self->ward);
    self->host = rmap_alloc(n, sizeof *self->host);
    if (self->ward && self->host)
        return self;
    destroy(self);
    return NULL;
}

static void *(*work_of(const struct rmap_watchdog *self))(void *)
{
    return self->rank == 0 ? listen_to_all : say_alive;
}

static void set_beat(struct rmap_watchdog *self, int beat)
{
    (void)pthread_mutex_lock(&self->lock);
    self->beat = beat;
    (void)pthread_cond_signal(&self->changed);
    (void)pthread_mutex_unlock(&self->lock);
}

void rmap_watchdog_end(struct rmap_watchdog *self)
{
    if (!self)
        return;
    set_beat(self, BEAT_BYE);
    if (self->runs)
        (void)pthread_join(self->thread, NULL);
    else
        (void)work_of(self)(self); /* takes leave of the others all the same */
    destroy(self);
}

enum rmap_status rmap_watchdog_start(const struct rmap_context *context,
                                     struct rmap_watchdog **watchdog_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    host_name mine = {0};
    int len = 0;
    struct rmap_watchdog *self = create(context);
    if (!self)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Get_processor_name(mine, &len)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_dup(context->comm, &self->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Gather(mine, sizeof mine, MPI_CHAR, self->host, sizeof mine, MPI_CHAR, 0, self->comm)));
    if (context->rank == 0)
        forgive(self, rmap_clock_seconds());
    self->runs = pthread_create(&self->thread, NULL, work_of(self), self) == 0;
    if (!self->runs)
        st = rmap_error_set(err, RMAP_SYSTEM, "rank %d: no thread can be started", self->rank);
    st = rmap_agree(context, st, err);
    if (st != RMAP_OK)
        rmap_watchdog_end(self);
    else
        *watchdog_ret = self;
    return st;
out:
    if (self)
        destroy(self);
    return st;
}

void rmap_watchdog_set_done(struct rmap_watchdog *self, bool done)
{
    if (self)
        set_beat(self, done ? BEAT_DONE : BEAT_WORKING);
}

int rmap_watchdog_missing(struct rmap_watchdog *self, const char **host_ret)
{
    int missing = -1;
    if (!self)
        return missing;
    (void)pthread_mutex_lock(&self->lock);
    bool rest_done = true;
    for (int r = self->size - 1; r > 0; r--) {
        if (self->ward[r].told > 0.0)
            missing = r;
        else
            rest_done = rest_done && self->ward[r].beat == BEAT_DONE;
    }
    (void)pthread_mutex_unlock(&self->lock);
    if (missing >= 0)
        *host_ret = self->host[missing];
    return rest_done ? missing : -1;
}

bool rmap_watchdog_is_silent(struct rmap_watchdog *self, int rank)
{
    (void)pthread_mutex_lock(&self->lock);
    bool silent = self->ward[rank].told > 0.0;
    (void)pthread_mutex_unlock(&self->lock);
    return silent;
}

void rmap_watchdog_end_in(struct rmap_watchdog *self, double seconds)
{
    (void)pthread_mutex_lock(&self->lock);
    self->end_at = rmap_clock_seconds() + seconds;
    (void)pthread_mutex_unlock(&self->lock);
}
