/* SPDX-License-Identifier: MIT
 *
 * Memory that processes of one host read without a copy each. Not of /dev/shm, which containers
 * often have 64 MiB of and where what a killed process made stays.
 */
#define _GNU_SOURCE /* memfd_create */
#include "io/file/shared_memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

int rmap_shared_memory_create(struct rmap_shared_place *place_ret)
{
    struct stat info = {0};
    const int fd = memfd_create("raymap", MFD_CLOEXEC);
    if (fd >= 0)
        (void)fstat(fd, &info);
    *place_ret = (struct rmap_shared_place){getpid(), fd, info.st_dev, info.st_ino};
    return fd;
}

int rmap_shared_memory_open(const struct rmap_shared_place *place)
{
    char path[64];
    struct stat info;
    (void)snprintf(path, sizeof path, "/proc/%lld/fd/%lld", (long long)place->pid,
                   (long long)place->fd);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0 && (fstat(fd, &info) != 0 || info.st_dev != place->device ||
                    info.st_ino != place->inode)) { /* that number is another process's here */
        (void)close(fd);
        return -1;
    }
    return fd;
}

enum rmap_status rmap_shared_memory_map(int fd, void **address_ret, size_t *nbytes_ret,
                                        struct rmap_error *err)
{
    struct stat info = {0};
    void *address = fstat(fd, &info) == 0 ? mmap(NULL, (size_t)info.st_size, PROT_READ | PROT_WRITE,
                                                 MAP_PRIVATE | MAP_NORESERVE, fd, 0)
                                          : MAP_FAILED;
    if (address == MAP_FAILED)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot share %zu bytes of memory: %s",
                              (size_t)info.st_size, strerror(errno));
    *address_ret = address;
    *nbytes_ret = (size_t)info.st_size;
    return RMAP_OK;
}
