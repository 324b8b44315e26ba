/* SPDX-License-Identifier: MIT
 *
 * Requests as lines: from standard input, and of who connects to a Unix socket. Each client has a
 * thread that writes and one that reads.
 */
#include "mpi/serve/serve_lines.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/write_all.h"
#include "mpi/serve/serve_message.h"

enum { LOOK_MS = 200, READ_NBYTES = 1 << 16, BACKLOG = 64, SLOW_S = 60 };

struct rmap_serve_lines {
    struct rmap_serve_queue *queue;
    int in, out; /* of a socket: in alone, to listen at */
    char *path;  /* of a socket; NULL: descriptors */
    pthread_t thread;
    atomic_bool stops, done;
    _Atomic int n_connection; /* of a socket */
};

struct connection {
    struct rmap_serve_lines *lines;
    struct rmap_serve_client *client;
    int in, out;
    atomic_bool ended, broken, stops;
    char *text; /* a line so far */
    size_t n, cap;
    bool skips; /* it is too long */
};

static void take(struct connection *self, const char *bytes, size_t n)
{
    struct rmap_error ignored = {0};
    if (!self->skips && self->n + n <= RMAP_SERVE_LINE &&
        RMAP_RESERVE(self->text, self->cap, self->n + n + 1, &ignored) == RMAP_OK) {
        memcpy(self->text + self->n, bytes, n);
        self->n += n;
        return;
    }
    self->skips = true;
}

static void end_line(struct connection *self)
{
    if (self->skips) /* its beginning is no request, either */
        rmap_serve_client_ask(self->client, "a line of more than 16 MiB", 0);
    else if (self->n > 0 && (self->n > 1 || self->text[0] != '\r'))
        rmap_serve_client_ask(self->client, self->text, self->n);
    self->n = 0;
    self->skips = false;
}

static void feed(struct connection *self, const char *bytes, size_t n)
{
    while (n > 0) {
        const char *end = memchr(bytes, '\n', n);
        const size_t some = end ? (size_t)(end - bytes) : n;
        take(self, bytes, some);
        if (!end)
            return;
        end_line(self);
        bytes += some + 1;
        n -= some + 1;
    }
}

static void *read_lines(void *context)
{
    struct connection *self = context;
    char bytes[READ_NBYTES];
    while (!atomic_load(&self->stops)) {
        struct pollfd at = {.fd = self->in, .events = POLLIN};
        if (poll(&at, 1, LOOK_MS) <= 0)
            continue;
        const ssize_t n = read(self->in, bytes, sizeof bytes);
        if (n > 0) {
            feed(self, bytes, (size_t)n);
            continue;
        }
        if (n < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (self->n > 0 || self->skips)
            end_line(self);
        /* One that only has nothing more to say waits for its answers. */
        const bool gone = self->lines->path && (at.revents & (POLLHUP | POLLERR));
        atomic_store(&self->broken, gone || n < 0);
        atomic_store(&self->ended, true);
        break;
    }
    return NULL;
}

static bool write_line(const struct connection *self, char *text)
{
    const size_t n = strlen(text);
    text[n] = '\n'; /* in place of its zero */
    return rmap_write_all(self->out, text, n + 1);
}

/* After the end of the input an event more is no reason to stay. */
static void converse(struct connection *self)
{
    pthread_t reader;
    bool over = false;
    if (pthread_create(&reader, NULL, read_lines, self) != 0)
        return;
    while (!over && !atomic_load(&self->broken)) {
        char *text =
            rmap_serve_client_next(self->client, LOOK_MS, atomic_load(&self->ended), &over);
        if (text && !write_line(self, text))
            over = true;
        rmap_free(text);
    }
    atomic_store(&self->stops, true);
    (void)pthread_join(reader, NULL);
}

static void *run_descriptors(void *context)
{
    struct rmap_serve_lines *lines = context;
    struct connection self = {.lines = lines, .in = lines->in, .out = lines->out};
    self.client = rmap_serve_client_join(lines->queue, 0, false);
    if (self.client)
        converse(&self);
    rmap_serve_client_leave(self.client);
    rmap_free(self.text);
    atomic_store(&lines->done, true);
    return NULL;
}

static void *run_connection(void *context)
{
    struct connection *self = context;
    struct rmap_serve_lines *lines = self->lines;
    self->client = rmap_serve_client_join(lines->queue, 0, false);
    if (self->client)
        converse(self);
    rmap_serve_client_leave(self->client);
    (void)close(self->in);
    rmap_free(self->text);
    rmap_free(self);
    atomic_fetch_sub(&lines->n_connection, 1);
    return NULL;
}

static void accept_one(struct rmap_serve_lines *lines, int descriptor)
{
    const struct timeval slow = {.tv_sec = SLOW_S};
    struct connection *self = rmap_alloc(1, sizeof *self);
    pthread_t thread;
    (void)setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &slow, sizeof slow);
    if (self) {
        self->lines = lines;
        self->in = self->out = descriptor;
        atomic_fetch_add(&lines->n_connection, 1);
        if (pthread_create(&thread, NULL, run_connection, self) == 0) {
            (void)pthread_detach(thread);
            return;
        }
        atomic_fetch_sub(&lines->n_connection, 1);
    }
    (void)close(descriptor);
    rmap_free(self);
}

static void *run_socket(void *context)
{
    struct rmap_serve_lines *lines = context;
    while (!atomic_load(&lines->stops)) {
        struct pollfd at = {.fd = lines->in, .events = POLLIN};
        if (poll(&at, 1, LOOK_MS) <= 0)
            continue;
        const int descriptor = accept(lines->in, NULL, NULL);
        if (descriptor >= 0)
            accept_one(lines, descriptor);
    }
    return NULL;
}

static enum rmap_status start(struct rmap_serve_lines *self, void *(*run)(void *),
                              struct rmap_serve_lines **lines_ret, struct rmap_error *err)
{
    const int code = pthread_create(&self->thread, NULL, run, self);
    if (code != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "no thread can be started: %s", strerror(code));
    *lines_ret = self;
    return RMAP_OK;
}

enum rmap_status rmap_serve_lines_start(struct rmap_serve_queue *queue, int in, int out,
                                        struct rmap_serve_lines **lines_ret, struct rmap_error *err)
{
    struct rmap_serve_lines *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    self->queue = queue;
    self->in = in;
    self->out = out;
    const enum rmap_status st = start(self, run_descriptors, lines_ret, err);
    if (st != RMAP_OK)
        rmap_free(self);
    return st;
}

/* Takes away a socket that nobody listens at. */
static enum rmap_status clear(const char *path, const struct sockaddr_un *address,
                              struct rmap_error *err)
{
    struct stat info;
    if (lstat(path, &info) != 0)
        return RMAP_OK;
    if (!S_ISSOCK(info.st_mode))
        return rmap_error_set(err, RMAP_USAGE, "--socket %s: a file stands there", path);
    const int probe = socket(AF_UNIX, SOCK_STREAM, 0);
    const bool alive =
        probe >= 0 && connect(probe, (const struct sockaddr *)address, sizeof *address) == 0;
    if (probe >= 0)
        (void)close(probe);
    if (alive)
        return rmap_error_set(err, RMAP_USAGE, "--socket %s: a server listens there already", path);
    (void)unlink(path);
    return RMAP_OK;
}

static enum rmap_status listen_at(const char *path, int *descriptor_ret, struct rmap_error *err)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path)
        return rmap_error_set(err, RMAP_USAGE, "--socket %s: a socket's path has at most %zu bytes",
                              path, sizeof address.sun_path - 1);
    memcpy(address.sun_path, path, strlen(path) + 1);
    const enum rmap_status st = clear(path, &address, err);
    if (st != RMAP_OK)
        return st;
    const int descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
    const mode_t mask = umask(0177);
    const bool bound = descriptor >= 0 &&
                       bind(descriptor, (const struct sockaddr *)&address, sizeof address) == 0 &&
                       listen(descriptor, BACKLOG) == 0;
    const int code = errno;
    (void)umask(mask);
    if (!bound && descriptor >= 0)
        (void)close(descriptor);
    if (!bound)
        return rmap_error_set(err, RMAP_SYSTEM, "--socket %s: %s", path, strerror(code));
    *descriptor_ret = descriptor;
    return RMAP_OK;
}

enum rmap_status rmap_serve_socket_start(struct rmap_serve_queue *queue, const char *path,
                                         struct rmap_serve_lines **lines_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_serve_lines *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    self->queue = queue;
    self->in = -1;
    self->path = rmap_strdup(path);
    if (!self->path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    RMAP_TRY(st);
    RMAP_TRY(listen_at(path, &self->in, err));
    RMAP_TRY(start(self, run_socket, lines_ret, err));
    return st;
out:
    if (self->in >= 0)
        (void)close(self->in);
    rmap_free(self->path);
    rmap_free(self);
    return st;
}

bool rmap_serve_lines_done(const struct rmap_serve_lines *lines)
{
    return atomic_load(&lines->done);
}

void rmap_serve_lines_stop(struct rmap_serve_lines *lines)
{
    if (!lines)
        return;
    atomic_store(&lines->stops, true);
    (void)pthread_join(lines->thread, NULL);
    while (atomic_load(&lines->n_connection) > 0)
        (void)poll(NULL, 0, 1);
    if (lines->path) {
        (void)close(lines->in);
        (void)unlink(lines->path);
    }
    rmap_free(lines->path);
    rmap_free(lines);
}
