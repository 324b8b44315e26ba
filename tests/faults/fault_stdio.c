/* SPDX-License-Identifier: MIT
 *
 * fopen and fdopen: the C library's streams make their system calls inside it, where no preloaded
 * function sees them. Streams to write to are therefore made anew over the calls that are seen.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "fault_plan.h"

static int fd_of(void *cookie)
{
    return (int)(intptr_t)cookie - 1;
}

/* As the C library does: until all is written or something fails. */
static ssize_t put(void *cookie, const char *data, size_t nbytes)
{
    size_t done = 0;
    while (done < nbytes) {
        ssize_t n = write(fd_of(cookie), data + done, nbytes - done);
        if (n < 0)
            break;
        done += (size_t)n;
    }
    return (ssize_t)done;
}

static int seek(void *cookie, off64_t *offset, int whence)
{
    *offset = lseek(fd_of(cookie), *offset, whence);
    return *offset < 0 ? -1 : 0;
}

static int end(void *cookie)
{
    return close(fd_of(cookie));
}

static FILE *stream_over(int fd, const char *mode)
{
    static const cookie_io_functions_t calls = {.write = put, .seek = seek, .close = end};
    return fopencookie((void *)(intptr_t)(fd + 1), mode, calls);
}

FILE *fopen(const char *path, const char *mode)
{
    static FILE *(*real)(const char *, const char *);
    if (!real) {
        void *found = dlsym(RTLD_NEXT, "fopen");
        memcpy(&real, &found, sizeof found);
    }
    if (!fault_watches(path) || mode[0] != 'w' || strchr(mode, '+'))
        return real(path, mode);
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    return fd < 0 ? NULL : stream_over(fd, mode);
}

FILE *fdopen(int fd, const char *mode)
{
    static FILE *(*real)(int, const char *);
    if (!real) {
        void *found = dlsym(RTLD_NEXT, "fdopen");
        memcpy(&real, &found, sizeof found);
    }
    char path[FAULT_PATH_CAP];
    return mode[0] == 'w' && fault_watches_file(fd, path) ? stream_over(fd, mode) : real(fd, mode);
}
