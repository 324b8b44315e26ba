/* SPDX-License-Identifier: MIT
 *
 * The call that starts threads, whoever makes it, and the one in which Open MPI's own waits, which
 * that thread can come to late.
 */
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <unistd.h>

#include "fault_plan.h"

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *argument)
{
    int (*next)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    *(void **)&next = dlsym(RTLD_NEXT, "pthread_create");
    if (fault_decide("thread:pthread_create", "") != FAULT_NONE)
        return errno;
    return next(thread, attributes, run, argument);
}

struct event_base;
int event_base_loop(struct event_base *base, int flags);

int event_base_loop(struct event_base *base, int flags)
{
    int (*next)(struct event_base *, int);
    *(void **)&next = dlsym(RTLD_NEXT, "event_base_loop");
    if (gettid() != getpid() && fault_decide("thread:event_base_loop", "") != FAULT_NONE)
        (void)sleep(1);
    return next(base, flags);
}
