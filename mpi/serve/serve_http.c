/* SPDX-License-Identifier: MIT
 *
 * Requests by HTTP on the loopback address, for who has the token. A browser sends requests for any
 * page that it shows: those of other pages are told by Host (a name that was made to lead here),
 * Origin and the cookie's SameSite.
 */
#include "mpi/serve/serve_http.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>

#include "analysis/page/workbench.h"
#include "base/alloc.h"
#include "base/count.h"
#include "base/late_library.h"
#include "mpi/serve/serve_message.h"

enum {
    GROUP = 1,
    TOKEN_NBYTES = 16,
    TOKEN_LEN = 2 * TOKEN_NBYTES,
    CONNECTIONS_MAX = 256,
    IDLE_S = 120,
    STRANGER_S = 10, /* who has not shown the token: 256 of them would lock all others out */
    WAIT_MS = 500,
    CLOSING_MS = 300,
    HEARTBEAT_MS = 10000, /* shows whether a browser is still there */
};

#define HTTP(X)                                                                                    \
    X(MHD_add_response_header)                                                                     \
    X(MHD_create_response_from_buffer)                                                             \
    X(MHD_create_response_from_callback)                                                           \
    X(MHD_destroy_response)                                                                        \
    X(MHD_get_connection_info)                                                                     \
    X(MHD_get_daemon_info)                                                                         \
    X(MHD_lookup_connection_value)                                                                 \
    X(MHD_queue_response)                                                                          \
    X(MHD_set_connection_option)                                                                   \
    X(MHD_start_daemon)                                                                            \
    X(MHD_stop_daemon)

struct http {
    HTTP(RMAP_LATE_MEMBER)
};
static const char *const http_name[] = {HTTP(RMAP_LATE_NAME)};

struct rmap_serve_http {
    struct http by;
    struct rmap_serve_queue *queue;
    struct MHD_Daemon *daemon;
    char token[TOKEN_LEN + 1];
    pthread_mutex_t opening; /* held until all below is known: connections may come before */
    char host[2][32];        /* what Host may be */
    char address[48], cookie_name[32], cookie[160];
};

/* The body of a request, as it comes. */
struct body {
    char *text;
    size_t n, cap;
    bool too_long;
};

static enum MHD_Result respond_with(const struct rmap_serve_http *self,
                                    struct MHD_Connection *connection, unsigned status,
                                    struct MHD_Response *response)
{
    if (!response)
        return MHD_NO;
    (void)self->by.MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    (void)self->by.MHD_add_response_header(response, "Cache-Control", "no-store");
    (void)self->by.MHD_add_response_header(response, "Referrer-Policy", "no-referrer");
    const enum MHD_Result done = self->by.MHD_queue_response(connection, status, response);
    self->by.MHD_destroy_response(response);
    return done;
}

static enum MHD_Result refuse(const struct rmap_serve_http *self, struct MHD_Connection *connection,
                              unsigned status)
{
    return respond_with(self, connection, status,
                        self->by.MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT));
}

static const char *header(const struct rmap_serve_http *self, struct MHD_Connection *connection,
                          const char *name)
{
    return self->by.MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

static bool is_ours(const struct rmap_serve_http *self, const char *host)
{
    return host && (strcmp(host, self->host[0]) == 0 || strcmp(host, self->host[1]) == 0);
}

static bool is_from_here(const struct rmap_serve_http *self, struct MHD_Connection *connection)
{
    const char *origin = header(self, connection, MHD_HTTP_HEADER_ORIGIN);
    if (origin && (strncmp(origin, "http://", 7) != 0 || !is_ours(self, origin + 7)))
        return false;
    return is_ours(self, header(self, connection, MHD_HTTP_HEADER_HOST));
}

/* In a time that does not tell how much of it was right. */
static bool is_token(const struct rmap_serve_http *self, const char *text)
{
    unsigned char differs = 0;
    if (!text || strlen(text) != TOKEN_LEN)
        return false;
    for (int i = 0; i < TOKEN_LEN; i++)
        differs |= (unsigned char)(text[i] ^ self->token[i]);
    return differs == 0;
}

static bool is_asked_with_token(const struct rmap_serve_http *self,
                                struct MHD_Connection *connection)
{
    return is_token(
        self, self->by.MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "token"));
}

static bool is_known(const struct rmap_serve_http *self, struct MHD_Connection *connection)
{
    const char *bearer = header(self, connection, MHD_HTTP_HEADER_AUTHORIZATION);
    if (bearer && strncmp(bearer, "Bearer ", 7) == 0 && is_token(self, bearer + 7))
        return true;
    return is_token(
        self, self->by.MHD_lookup_connection_value(connection, MHD_COOKIE_KIND, self->cookie_name));
}

/* Whether who asked has closed the connection; a request behind the first is none of it. */
static bool has_gone(const struct rmap_serve_http *self, struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        self->by.MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    char byte;
    return info && recv(info->connect_fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

static enum MHD_Result answer(const struct rmap_serve_http *self, struct MHD_Connection *connection,
                              const struct body *body)
{
    struct rmap_serve_client *client = rmap_serve_client_join(self->queue, GROUP, false);
    char *last = NULL;
    bool over = false;
    if (!client)
        return refuse(self, connection, MHD_HTTP_SERVICE_UNAVAILABLE);
    rmap_serve_client_ask(client, body->n ? body->text : "", body->n);
    while (!over && !has_gone(self, connection)) {
        char *text = rmap_serve_client_next(client, WAIT_MS, true, &over);
        if (text) {
            rmap_free(last);
            last = text;
        }
    }
    rmap_serve_client_leave(client);
    if (!last)
        return refuse(self, connection, MHD_HTTP_SERVICE_UNAVAILABLE);
    struct MHD_Response *response =
        self->by.MHD_create_response_from_buffer(strlen(last), last, MHD_RESPMEM_MUST_COPY);
    rmap_free(last);
    if (response)
        (void)self->by.MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE,
                                               "application/json");
    return respond_with(self, connection, MHD_HTTP_OK, response);
}

/* Events on their way to a browser. */
struct stream {
    struct rmap_serve_client *client;
    char *text; /* what is being sent */
    size_t n, at;
};

/* The next event as text/event-stream has it, or a comment, which nobody sees. */
static bool fetch(struct stream *self)
{
    static const char format[] = "data: %s\n\n", alive[] = ":\n\n";
    bool over = false;
    char *line = rmap_serve_client_next(self->client, HEARTBEAT_MS, false, &over);
    if (over)
        return false;
    const size_t cap = (line ? strlen(line) : 0) + sizeof format;
    self->text = rmap_alloc(cap, 1);
    if (self->text)
        self->n = (size_t)snprintf(self->text, cap, line ? format : alive, line);
    self->at = 0;
    rmap_free(line);
    return self->text != NULL;
}

static ssize_t read_stream(void *context, uint64_t position, char *buffer, size_t most)
{
    struct stream *self = context;
    (void)position;
    if (!self->text && !fetch(self))
        return MHD_CONTENT_READER_END_OF_STREAM;
    const size_t left = self->n - self->at, n = left < most ? left : most;
    memcpy(buffer, self->text + self->at, n);
    self->at += n;
    if (self->at == self->n) {
        rmap_free(self->text);
        self->text = NULL;
    }
    return (ssize_t)n;
}

static void free_stream(void *context)
{
    struct stream *self = context;
    rmap_serve_client_leave(self->client);
    rmap_free(self->text);
    rmap_free(self);
}

static enum MHD_Result stream_events(const struct rmap_serve_http *self,
                                     struct MHD_Connection *connection)
{
    struct stream *stream = rmap_alloc(1, sizeof *stream);
    if (stream)
        stream->client = rmap_serve_client_join(self->queue, GROUP, true);
    if (!stream || !stream->client) {
        rmap_free(stream);
        return refuse(self, connection, MHD_HTTP_SERVICE_UNAVAILABLE);
    }
    struct MHD_Response *response = self->by.MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, 1 << 16, read_stream, stream, free_stream);
    if (!response) {
        free_stream(stream);
        return MHD_NO;
    }
    (void)self->by.MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE,
                                           "text/event-stream");
    return respond_with(self, connection, MHD_HTTP_OK, response);
}

/* The token goes from the address, where it would be seen, into a cookie. */
static enum MHD_Result let_in(const struct rmap_serve_http *self, struct MHD_Connection *connection)
{
    struct MHD_Response *response =
        self->by.MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT);
    if (response) {
        (void)self->by.MHD_add_response_header(response, MHD_HTTP_HEADER_SET_COOKIE, self->cookie);
        (void)self->by.MHD_add_response_header(response, MHD_HTTP_HEADER_LOCATION, "/");
    }
    return respond_with(self, connection, MHD_HTTP_FOUND, response);
}

static enum MHD_Result send_file(const struct rmap_serve_http *self,
                                 struct MHD_Connection *connection, const char *path)
{
    const struct rmap_workbench_file *file = rmap_workbench_file(path);
    if (!file)
        return refuse(self, connection, MHD_HTTP_NOT_FOUND);
    struct MHD_Response *response = self->by.MHD_create_response_from_buffer(
        strlen(file->text), (void *)(uintptr_t)file->text, MHD_RESPMEM_PERSISTENT);
    if (response) {
        (void)self->by.MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, file->type);
        (void)self->by.MHD_add_response_header(response, "Content-Security-Policy",
                                               rmap_workbench_policy);
        (void)self->by.MHD_add_response_header(response, "X-Frame-Options", "DENY");
    }
    return respond_with(self, connection, MHD_HTTP_OK, response);
}

static void collect(struct body *body, const char *data, size_t n)
{
    struct rmap_error ignored = {0};
    body->too_long = body->too_long || body->n + n > RMAP_SERVE_LINE ||
                     RMAP_RESERVE(body->text, body->cap, body->n + n + 1, &ignored) != RMAP_OK;
    if (body->too_long)
        return;
    memcpy(body->text + body->n, data, n);
    body->n += n;
}

static enum MHD_Result post(const struct rmap_serve_http *self, struct MHD_Connection *connection,
                            const char *path, const struct body *body)
{
    const char *type = header(self, connection, MHD_HTTP_HEADER_CONTENT_TYPE);
    if (strcmp(path, "/api") != 0)
        return refuse(self, connection, MHD_HTTP_NOT_FOUND);
    if (!type || strncmp(type, "application/json", 16) != 0)
        return refuse(self, connection, MHD_HTTP_UNSUPPORTED_MEDIA_TYPE);
    if (body->too_long)
        return refuse(self, connection, MHD_HTTP_CONTENT_TOO_LARGE);
    return answer(self, connection, body);
}

/* Nothing but the status is said to who is not let in. */
static enum MHD_Result respond(const struct rmap_serve_http *self,
                               struct MHD_Connection *connection, const char *path,
                               const char *method, const struct body *body)
{
    const bool gets = strcmp(method, MHD_HTTP_METHOD_GET) == 0;
    if (!is_from_here(self, connection))
        return refuse(self, connection, MHD_HTTP_FORBIDDEN);
    if (gets && strcmp(path, "/") == 0 && is_asked_with_token(self, connection))
        return let_in(self, connection);
    if (!is_known(self, connection) &&
        !(gets && strcmp(path, "/events") == 0 && is_asked_with_token(self, connection)))
        return refuse(self, connection, MHD_HTTP_UNAUTHORIZED);
    if (strcmp(method, MHD_HTTP_METHOD_POST) == 0)
        return post(self, connection, path, body);
    if (!gets)
        return refuse(self, connection, MHD_HTTP_METHOD_NOT_ALLOWED);
    return strcmp(path, "/events") == 0 ? stream_events(self, connection)
                                        : send_file(self, connection, path);
}

static enum MHD_Result handle(void *context, struct MHD_Connection *connection, const char *path,
                              const char *method, const char *version, const char *data,
                              size_t *n_data, void **state)
{
    struct rmap_serve_http *self = context;
    struct body *body = *state;
    (void)version;
    if (!body) {
        (void)pthread_mutex_lock(&self->opening);
        (void)pthread_mutex_unlock(&self->opening);
        if (is_known(self, connection) || is_asked_with_token(self, connection))
            (void)self->by.MHD_set_connection_option(connection, MHD_CONNECTION_OPTION_TIMEOUT,
                                                     (unsigned)IDLE_S);
        *state = rmap_alloc(1, sizeof *body);
        return *state ? MHD_YES : MHD_NO;
    }
    if (*n_data > 0) {
        collect(body, data, *n_data);
        *n_data = 0;
        return MHD_YES;
    }
    return respond(self, connection, path, method, body);
}

static void complete(void *context, struct MHD_Connection *connection, void **state,
                     enum MHD_RequestTerminationCode code)
{
    struct body *body = *state;
    (void)context;
    (void)connection;
    (void)code;
    if (body)
        rmap_free(body->text);
    rmap_free(body);
    *state = NULL;
}

static enum rmap_status make_token(struct rmap_serve_http *self, struct rmap_error *err)
{
    unsigned char random[TOKEN_NBYTES];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return rmap_error_set(err, RMAP_SYSTEM, "no random numbers can be had for a token: %s",
                              strerror(errno));
    for (int i = 0; i < TOKEN_NBYTES; i++)
        (void)snprintf(self->token + 2 * i, 3, "%02x", random[i]);
    return RMAP_OK;
}

static void set_names(struct rmap_serve_http *self, unsigned port)
{
    (void)snprintf(self->host[0], sizeof self->host[0], "127.0.0.1:%u", port);
    (void)snprintf(self->host[1], sizeof self->host[1], "localhost:%u", port);
    (void)snprintf(self->address, sizeof self->address, "http://127.0.0.1:%u", port);
    (void)snprintf(self->cookie_name, sizeof self->cookie_name, "raymap-%u", port);
    (void)snprintf(self->cookie, sizeof self->cookie, "%s=%s; Path=/; HttpOnly; SameSite=Strict",
                   self->cookie_name, self->token);
}

enum rmap_status rmap_serve_http_start(struct rmap_serve_queue *queue, uint16_t port,
                                       struct rmap_serve_http **http_ret, struct rmap_error *err)
{
    const struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct rmap_serve_http *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    enum rmap_status st = rmap_late_library(RMAP_LIBMICROHTTPD, "--http needs libmicrohttpd",
                                            http_name, RMAP_COUNT(http_name), &self->by, err);
    if (st == RMAP_OK)
        st = make_token(self, err);
    self->queue = queue;
    (void)pthread_mutex_init(&self->opening, NULL);
    (void)pthread_mutex_lock(&self->opening);
    if (st == RMAP_OK)
        self->daemon = self->by.MHD_start_daemon(
            MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL, port,
            NULL, NULL, handle, self, MHD_OPTION_SOCK_ADDR, (const struct sockaddr *)&address,
            MHD_OPTION_NOTIFY_COMPLETED, complete, NULL, MHD_OPTION_CONNECTION_LIMIT,
            (unsigned)CONNECTIONS_MAX, MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)STRANGER_S,
            MHD_OPTION_END);
    const union MHD_DaemonInfo *info =
        self->daemon ? self->by.MHD_get_daemon_info(self->daemon, MHD_DAEMON_INFO_BIND_PORT) : NULL;
    if (st == RMAP_OK && !info)
        st = rmap_error_set(err, RMAP_SYSTEM, "--http: nothing can listen at 127.0.0.1:%u: %s",
                            port, strerror(errno));
    if (st == RMAP_OK)
        set_names(self, info->port);
    (void)pthread_mutex_unlock(&self->opening);
    if (st == RMAP_OK)
        *http_ret = self;
    else
        rmap_serve_http_stop(self);
    return st;
}

const char *rmap_serve_http_address(const struct rmap_serve_http *http)
{
    return http->address;
}

const char *rmap_serve_http_token(const struct rmap_serve_http *http)
{
    return http->token;
}

void rmap_serve_http_stop(struct rmap_serve_http *http)
{
    /* What was answered last is still on its way. */
    for (int i = 0; http && http->daemon && i < CLOSING_MS; i++) {
        const union MHD_DaemonInfo *info =
            http->by.MHD_get_daemon_info(http->daemon, MHD_DAEMON_INFO_CURRENT_CONNECTIONS);
        if (!info || info->num_connections == 0)
            break;
        (void)poll(NULL, 0, 1);
    }
    if (http && http->daemon)
        http->by.MHD_stop_daemon(http->daemon);
    if (http)
        (void)pthread_mutex_destroy(&http->opening);
    rmap_free(http);
}
