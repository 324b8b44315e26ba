/* SPDX-License-Identifier: MIT
 *
 * Between those who bring requests, each in threads of its own, and the one thread that answers.
 * One lock for all: what is done under it is short.
 */
#include "mpi/serve/serve_queue.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/serve/serve_message.h"

enum {
    CLIENTS_MAX = 512,
    WAITING_MAX = 64, /* requests of one client */
    EVENTS_MAX = 256, /* lines that a client lets lie; of events the later ones are lost */
    ANSWERS_MAX = 64, /* and of answers, in MiB, where it has gone */
};

struct line {
    char *text;
    size_t nbytes;
    struct line *next;
};

struct rmap_serve_client {
    struct rmap_serve_queue *queue;
    int group;
    bool watches, gone;
    size_t n_waiting;                                /* not answered yet, the one in hand too */
    struct rmap_serve_request *first_asked, **asked; /* where the next goes */
    struct line *first_line, **line;
    size_t n_line, nbytes;
    struct rmap_serve_client *next;
};

struct rmap_serve_queue {
    pthread_mutex_t lock;
    pthread_cond_t work, talk;              /* for who answers; for who brings */
    struct rmap_serve_client *first, *turn; /* whose turn it is; NULL: the first's */
    size_t n_client;
    struct rmap_serve_request *in_hand;
    bool closed;
};

enum rmap_status rmap_serve_queue_create(struct rmap_serve_queue **queue_ret,
                                         struct rmap_error *err)
{
    struct rmap_serve_queue *queue = rmap_alloc(1, sizeof *queue);
    pthread_condattr_t clock;
    if (!queue)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    (void)pthread_mutex_init(&queue->lock, NULL);
    (void)pthread_condattr_init(&clock);
    (void)pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    (void)pthread_cond_init(&queue->work, &clock);
    (void)pthread_cond_init(&queue->talk, &clock);
    (void)pthread_condattr_destroy(&clock);
    *queue_ret = queue;
    return RMAP_OK;
}

void rmap_serve_queue_close(struct rmap_serve_queue *queue)
{
    if (!queue)
        return;
    (void)pthread_mutex_lock(&queue->lock);
    queue->closed = true;
    (void)pthread_cond_broadcast(&queue->work);
    (void)pthread_cond_broadcast(&queue->talk);
    (void)pthread_mutex_unlock(&queue->lock);
}

static void free_request(struct rmap_serve_request *request)
{
    json_decref(request->message);
    rmap_free(request);
}

static void free_client(struct rmap_serve_client *client)
{
    while (client->first_asked) {
        struct rmap_serve_request *request = client->first_asked;
        client->first_asked = request->next;
        free_request(request);
    }
    while (client->first_line) {
        struct line *line = client->first_line;
        client->first_line = line->next;
        rmap_free(line->text);
        rmap_free(line);
    }
    rmap_free(client);
}

void rmap_serve_queue_destroy(struct rmap_serve_queue *queue)
{
    if (!queue)
        return;
    while (queue->first) {
        struct rmap_serve_client *client = queue->first;
        queue->first = client->next;
        free_client(client);
    }
    (void)pthread_cond_destroy(&queue->work);
    (void)pthread_cond_destroy(&queue->talk);
    (void)pthread_mutex_destroy(&queue->lock);
    rmap_free(queue);
}

struct rmap_serve_client *rmap_serve_client_join(struct rmap_serve_queue *queue, int group,
                                                 bool watches)
{
    struct rmap_serve_client *client = rmap_alloc(1, sizeof *client);
    if (!client)
        return NULL;
    client->queue = queue;
    client->group = group;
    client->watches = watches;
    client->asked = &client->first_asked;
    client->line = &client->first_line;
    (void)pthread_mutex_lock(&queue->lock);
    const bool joins = !queue->closed && queue->n_client < CLIENTS_MAX;
    if (joins) {
        client->next = queue->first;
        queue->first = client;
        queue->n_client++;
    }
    (void)pthread_mutex_unlock(&queue->lock);
    if (!joins)
        rmap_free(client);
    return joins ? client : NULL;
}

/* Under the lock. A client that has gone, once nothing of it is in hand. */
static void remove_client(struct rmap_serve_queue *queue, struct rmap_serve_client *client)
{
    struct rmap_serve_client **at = &queue->first;
    while (*at != client)
        at = &(*at)->next;
    *at = client->next;
    if (queue->turn == client)
        queue->turn = client->next;
    queue->n_client--;
    free_client(client);
}

/* Under the lock. Requests with that id, or all where it is NULL; how many. */
static size_t cancel(struct rmap_serve_client *client, const json_t *id);

void rmap_serve_client_leave(struct rmap_serve_client *client)
{
    if (!client)
        return;
    struct rmap_serve_queue *queue = client->queue;
    (void)pthread_mutex_lock(&queue->lock);
    client->gone = true;
    client->watches = false;
    (void)cancel(client, NULL);
    if (client->n_waiting == 0)
        remove_client(queue, client);
    (void)pthread_mutex_unlock(&queue->lock);
}

/* Under the lock. Takes the document over. */
static void put_line(struct rmap_serve_client *client, json_t *document, bool is_event)
{
    char *text = client->gone ? NULL : rmap_serve_text(document);
    struct line *line = text ? rmap_alloc(1, sizeof *line) : NULL;
    json_decref(document);
    if (!line || (is_event && client->n_line >= EVENTS_MAX) ||
        client->nbytes >> 20 >= ANSWERS_MAX) {
        rmap_free(text);
        rmap_free(line);
        return;
    }
    line->text = text;
    line->nbytes = strlen(text);
    client->n_line++;
    client->nbytes += line->nbytes;
    *client->line = line;
    client->line = &line->next;
    (void)pthread_cond_broadcast(&client->queue->talk);
}

/* Under the lock. */
static void finish(struct rmap_serve_request *request, json_t *document)
{
    struct rmap_serve_client *client = request->client;
    put_line(client, document, false);
    client->n_waiting--;
    (void)pthread_cond_broadcast(&client->queue->talk);
    free_request(request);
    if (client->gone && client->n_waiting == 0)
        remove_client(client->queue, client);
}

static json_t *cancelled(const struct rmap_serve_request *request)
{
    return rmap_serve_error(request->message, RMAP_STOPPED, "cancelled");
}

static bool is_meant(const struct rmap_serve_request *request, const json_t *id)
{
    return !id || json_equal(json_object_get(request->message, "id"), id);
}

static size_t cancel(struct rmap_serve_client *client, const json_t *id)
{
    struct rmap_serve_request *in_hand = client->queue->in_hand;
    struct rmap_serve_request *waiting = client->first_asked;
    size_t n = 0;
    client->first_asked = NULL;
    client->asked = &client->first_asked;
    while (waiting) {
        struct rmap_serve_request *request = waiting;
        waiting = request->next;
        request->next = NULL;
        if (is_meant(request, id) && !request->state) {
            n++;
            put_line(client, cancelled(request), false);
            client->n_waiting--;
            free_request(request);
            continue;
        }
        if (is_meant(request, id)) { /* the server has something of it to release */
            n++;
            request->cancelled = true;
        }
        *client->asked = request;
        client->asked = &request->next;
    }
    if (in_hand && in_hand->client == client && is_meant(in_hand, id)) {
        n++;
        in_hand->cancelled = true;
        rmap_interrupt_stop_question();
    }
    return n;
}

/* Under the lock. Of this client, or of all of its group. */
static size_t cancel_of_group(struct rmap_serve_client *client, const json_t *id)
{
    size_t n = 0;
    if (client->group == 0)
        return cancel(client, id);
    for (struct rmap_serve_client *other = client->queue->first; other; other = other->next)
        if (other->group == client->group)
            n += cancel(other, id);
    return n;
}

/* Under the lock. */
static void answer_cancel(struct rmap_serve_client *client, const json_t *message)
{
    const json_t *of = json_object_get(message, "of");
    struct rmap_error why = {0};
    if (rmap_serve_check_keys(message, "of:x", &why) != RMAP_OK)
        put_line(client, rmap_serve_error(message, RMAP_USAGE, why.text), false);
    else if (!of)
        put_line(client,
                 rmap_serve_error(message, RMAP_USAGE, "cancel wants the id of a request in 'of'"),
                 false);
    else
        put_line(client,
                 rmap_serve_result(message, json_pack("{s:I}", "cancelled",
                                                      (json_int_t)cancel_of_group(client, of))),
                 false);
}

/* Under the lock. */
static void answer_watch(struct rmap_serve_client *client, const json_t *message)
{
    struct rmap_error why = {0};
    const bool right = rmap_serve_check_keys(message, "on:b", &why) == RMAP_OK;
    if (right)
        client->watches = !json_is_false(json_object_get(message, "on"));
    put_line(client,
             right ? rmap_serve_result(message, json_object())
                   : rmap_serve_error(message, RMAP_USAGE, why.text),
             false);
}

void rmap_serve_client_ask(struct rmap_serve_client *client, const char *line, size_t nbytes)
{
    struct rmap_serve_queue *queue = client->queue;
    json_t *refusal = NULL, *message = rmap_serve_parse(line, nbytes, &refusal);
    const char *command = message ? json_string_value(json_object_get(message, "command")) : NULL;
    struct rmap_serve_request *request = message ? rmap_alloc(1, sizeof *request) : NULL;
    (void)pthread_mutex_lock(&queue->lock);
    if (!message) {
        put_line(client, refusal, false);
    } else if (strcmp(command, "cancel") == 0) {
        answer_cancel(client, message);
    } else if (strcmp(command, "watch") == 0) {
        answer_watch(client, message);
    } else if (!request || client->n_waiting >= WAITING_MAX || queue->closed) {
        put_line(client, rmap_serve_error(message, RMAP_SYSTEM, "too many requests wait"), false);
    } else {
        *request = (struct rmap_serve_request){.client = client, .message = message};
        *client->asked = request;
        client->asked = &request->next;
        client->n_waiting++;
        request = NULL;
        message = NULL;
        (void)pthread_cond_signal(&queue->work);
    }
    (void)pthread_mutex_unlock(&queue->lock);
    json_decref(message);
    rmap_free(request);
}

static struct timespec later(int milliseconds)
{
    struct timespec at;
    (void)clock_gettime(CLOCK_MONOTONIC, &at);
    at.tv_sec += milliseconds / 1000;
    at.tv_nsec += (long)(milliseconds % 1000) * 1000000;
    if (at.tv_nsec >= 1000000000) {
        at.tv_nsec -= 1000000000;
        at.tv_sec++;
    }
    return at;
}

char *rmap_serve_client_next(struct rmap_serve_client *client, int milliseconds, bool finished,
                             bool *over_ret)
{
    struct rmap_serve_queue *queue = client->queue;
    const struct timespec until = later(milliseconds);
    char *text = NULL;
    int waited = 0;
    (void)pthread_mutex_lock(&queue->lock);
    while (!client->first_line && !queue->closed && !(finished && client->n_waiting == 0) &&
           waited != ETIMEDOUT)
        waited = pthread_cond_timedwait(&queue->talk, &queue->lock, &until);
    struct line *line = client->first_line;
    if (line) {
        text = line->text;
        client->first_line = line->next;
        if (!client->first_line)
            client->line = &client->first_line;
        client->n_line--;
        client->nbytes -= line->nbytes;
    }
    *over_ret = !line && (queue->closed || (finished && client->n_waiting == 0));
    (void)pthread_mutex_unlock(&queue->lock);
    rmap_free(line);
    return text;
}

/* Under the lock. Of the client whose turn it is, or the next that has one. */
static struct rmap_serve_request *take(struct rmap_serve_queue *queue)
{
    struct rmap_serve_client *client = queue->turn ? queue->turn : queue->first;
    for (size_t i = 0; i < queue->n_client; i++, client = client->next) {
        if (!client)
            client = queue->first;
        struct rmap_serve_request *request = client->first_asked;
        if (!request)
            continue;
        client->first_asked = request->next;
        if (!client->first_asked)
            client->asked = &client->first_asked;
        request->next = NULL;
        queue->turn = client->next;
        return request;
    }
    return NULL;
}

struct rmap_serve_request *rmap_serve_queue_next(struct rmap_serve_queue *queue, int milliseconds)
{
    const struct timespec until = later(milliseconds);
    struct rmap_serve_request *request = NULL;
    int waited = 0;
    (void)pthread_mutex_lock(&queue->lock);
    while (!(request = take(queue)) && !queue->closed && waited != ETIMEDOUT && milliseconds > 0)
        waited = pthread_cond_timedwait(&queue->work, &queue->lock, &until);
    queue->in_hand = request;
    rmap_interrupt_forget(); /* of the one before */
    (void)pthread_mutex_unlock(&queue->lock);
    return request;
}

void rmap_serve_tell(struct rmap_serve_request *request, json_t *document)
{
    struct rmap_serve_queue *queue = request->client->queue;
    const int group = request->client->group;
    (void)pthread_mutex_lock(&queue->lock);
    if (group == 0)
        put_line(request->client, json_incref(document), true);
    for (struct rmap_serve_client *other = queue->first; other && group; other = other->next)
        if (other->group == group && other->watches)
            put_line(other, json_incref(document), true);
    (void)pthread_mutex_unlock(&queue->lock);
    json_decref(document);
}

void rmap_serve_answer(struct rmap_serve_request *request, json_t *document)
{
    struct rmap_serve_queue *queue = request->client->queue;
    (void)pthread_mutex_lock(&queue->lock);
    queue->in_hand = NULL;
    finish(request, document);
    (void)pthread_mutex_unlock(&queue->lock);
}

void rmap_serve_again(struct rmap_serve_request *request)
{
    struct rmap_serve_client *client = request->client;
    (void)pthread_mutex_lock(&client->queue->lock);
    client->queue->in_hand = NULL;
    request->next = client->first_asked;
    client->first_asked = request;
    if (!request->next)
        client->asked = &request->next;
    (void)pthread_mutex_unlock(&client->queue->lock);
}

void rmap_serve_event(struct rmap_serve_queue *queue, json_t *document)
{
    (void)pthread_mutex_lock(&queue->lock);
    for (struct rmap_serve_client *client = queue->first; client; client = client->next)
        if (client->watches)
            put_line(client, json_incref(document), true);
    (void)pthread_mutex_unlock(&queue->lock);
    json_decref(document);
}
