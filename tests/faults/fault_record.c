/* SPDX-License-Identifier: MIT */
#include "fault_record.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include "fault_plan.h"

static pthread_mutex_t order = PTHREAD_MUTEX_INITIALIZER;
static int output = -1;

__attribute__((constructor)) static void open_record(void)
{
    output = fault_open_output("FAULTS_RECORD");
}

void fault_record_begin(void)
{
    if (output >= 0)
        (void)pthread_mutex_lock(&order);
}

void fault_record_end(void)
{
    if (output >= 0)
        (void)pthread_mutex_unlock(&order);
}

static struct iovec bytes(const void *data, size_t nbytes)
{
    struct iovec part = {.iov_len = nbytes};
    memcpy(&part.iov_base, &data, sizeof data); /* writev takes no const */
    return part;
}

static void put(struct fault_record_head head, const char *path, const char *other,
                const void *data)
{
    struct timespec now;
    int error = errno;
    if (output < 0)
        return;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    head.time_ns = (uint64_t)now.tv_sec * 1000000000U + (uint64_t)now.tv_nsec;
    head.path_nbytes = (uint32_t)strlen(path);
    head.other_nbytes = (uint32_t)strlen(other);
    const struct iovec part[] = {bytes(&head, sizeof head), bytes(path, head.path_nbytes),
                                 bytes(other, head.other_nbytes), bytes(data, head.data_nbytes)};
    ssize_t all = (ssize_t)(sizeof head + head.path_nbytes + head.other_nbytes + head.data_nbytes);
    if (syscall(SYS_writev, output, part, 4) != all)
        fault_die(); /* a record with a hole would lie */
    errno = error;
}

void fault_record_path(enum fault_operation operation, const char *path, const char *other,
                       uint64_t offset)
{
    put((struct fault_record_head){.operation = operation, .offset = offset}, path, other, NULL);
}

void fault_record_write(const char *path, off_t offset, const void *data, size_t nbytes)
{
    put((struct fault_record_head){.operation = FAULT_OPERATION_WRITE,
                                   .offset = (uint64_t)offset,
                                   .data_nbytes = (uint32_t)nbytes},
        path, "", data);
}
