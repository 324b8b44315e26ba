/* SPDX-License-Identifier: MIT
 *
 * The call that starts threads, whoever makes it.
 */
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>

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
