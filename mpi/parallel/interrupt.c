/* SPDX-License-Identifier: MIT
 *
 * Being asked to stop: SIGTERM, SIGINT or SIGUSR1 (what a batch system or mpirun sends).
 */
#include "mpi/parallel/interrupt.h"

#include <signal.h>
#include <stddef.h>

static const int watched[] = {SIGTERM, SIGINT, SIGUSR1};

/* A signal handler can tell nobody but a static: with the flag of
 * io/export/json_memory.c the one piece of global state in the program. */
static _Atomic sig_atomic_t caught; /* negative: of a question */

static void remember(int number)
{
    caught = number;
}

void rmap_interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = remember};
    (void)sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART | (int)SA_RESETHAND;
    for (size_t i = 0; i < sizeof watched / sizeof watched[0]; i++)
        (void)sigaction(watched[i], &action, NULL);
}

int rmap_interrupt_caught(void)
{
    return caught > 0 ? caught : 0;
}

static void remember_question(int number)
{
    caught = -number;
}

void rmap_interrupt_watch_questions(void)
{
    struct sigaction action = {.sa_handler = remember_question};
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
}

bool rmap_interrupt_stops_question(void)
{
    return caught < 0;
}

void rmap_interrupt_forget(void)
{
    if (caught < 0)
        caught = 0;
}

void rmap_interrupt_stop_question(void)
{
    if (caught == 0)
        caught = -SIGINT;
}

enum rmap_status rmap_interrupt_stopped(struct rmap_error *err)
{
    const int number = rmap_interrupt_caught();
    return number ? rmap_error_set(err, RMAP_STOPPED, "stopped by %s", rmap_interrupt_name(number))
                  : RMAP_OK;
}

const char *rmap_interrupt_name(int number)
{
    switch (number) {
    case SIGTERM:
        return "SIGTERM";
    case SIGINT:
        return "SIGINT";
    case SIGUSR1:
        return "SIGUSR1";
    default:
        return "a signal";
    }
}
