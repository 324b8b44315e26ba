/* SPDX-License-Identifier: MIT
 *
 * The seal behind the last byte that HDF5 knows of: a hash of everything in the file but stored
 * chunks, which have checksums of their own.
 */
#include "io/file/seal.h"

#define XXH_INLINE_ALL
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"

static const char magic[8] = {'r', 'm', 'a', 'p', 's', 'e', 'a', 'l'};

struct footer {
    uint64_t n, rest_hash, own_hash;
    char magic[8];
};
_Static_assert(sizeof(struct footer) == 32, "the footer is its bytes in the file");

#define BUFFER_NBYTES 65536

static enum rmap_status failed(const char *path, const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s: %s: %s", path, what, strerror(errno));
}

/* Like pread and pwrite, but all of it. A file that ends before was cut off meanwhile: EIO. */
static int read_all(int fd, void *to, size_t nbytes, uint64_t offset)
{
    size_t done = 0;
    while (done < nbytes) {
        ssize_t got = pread(fd, (char *)to + done, nbytes - done, (off_t)(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got == 0)
            errno = EIO;
        if (got <= 0)
            return -1;
        done += (size_t)got;
    }
    return 0;
}

static int write_all(int fd, const void *from, size_t nbytes, uint64_t offset)
{
    size_t done = 0;
    while (done < nbytes) {
        ssize_t put = pwrite(fd, (const char *)from + done, nbytes - done, (off_t)(offset + done));
        if (put < 0 && errno == EINTR)
            continue;
        if (put < 0)
            return -1;
        done += (size_t)put;
    }
    return 0;
}

static int hash_span(int fd, uint64_t from, uint64_t to, XXH3_state_t *state)
{
    char buffer[BUFFER_NBYTES];
    while (from < to) {
        size_t n = to - from < sizeof buffer ? (size_t)(to - from) : sizeof buffer;
        if (read_all(fd, buffer, n, from) != 0)
            return -1;
        XXH3_64bits_update(state, buffer, n);
        from += n;
    }
    return 0;
}

/* Hash of [0, end) without the ranges, which lie in it in order. */
static int hash_rest(int fd, uint64_t end, const struct rmap_range *range, size_t n, uint64_t *hash)
{
    XXH3_state_t state;
    uint64_t at = 0;
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    for (size_t i = 0; i < n; i++) {
        if (hash_span(fd, at, range[i].offset, &state) != 0)
            return -1;
        at = range[i].offset + range[i].nbytes;
    }
    if (hash_span(fd, at, end, &state) != 0)
        return -1;
    *hash = XXH3_64bits_digest(&state);
    return 0;
}

static uint64_t hash_own(const struct rmap_range *range, const struct footer *footer)
{
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    if (footer->n > 0)
        XXH3_64bits_update(&state, range, footer->n * sizeof *range);
    XXH3_64bits_update(&state, footer, offsetof(struct footer, own_hash));
    return XXH3_64bits_digest(&state);
}

static int by_offset(const void *a, const void *b)
{
    const struct rmap_range *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

enum rmap_status rmap_seal_append(int fd, const char *path, struct rmap_range *range, size_t n,
                                  struct rmap_error *err)
{
    struct stat info;
    struct footer footer = {.n = n};
    memcpy(footer.magic, magic, sizeof magic);
    if (n > 0)
        qsort(range, n, sizeof *range, by_offset);
    if (fstat(fd, &info) != 0 ||
        hash_rest(fd, (uint64_t)info.st_size, range, n, &footer.rest_hash) != 0)
        return failed(path, "cannot be read for its seal", err);
    footer.own_hash = hash_own(range, &footer);
    uint64_t end = (uint64_t)info.st_size, ranges_nbytes = n * sizeof *range;
    if ((n > 0 && write_all(fd, range, ranges_nbytes, end) != 0) ||
        write_all(fd, &footer, sizeof footer, end + ranges_nbytes) != 0)
        return failed(path, "writing its seal", err);
    return RMAP_OK;
}

enum rmap_status rmap_seal_write(const char *path, struct rmap_range *range, size_t n,
                                 struct rmap_error *err)
{
    int fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        return failed(path, "cannot be opened for its seal", err);
    enum rmap_status st = rmap_seal_append(fd, path, range, n, err);
    if (close(fd) != 0 && st == RMAP_OK)
        st = failed(path, "closing", err);
    return st;
}

static enum rmap_status no_seal(const char *path, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: no seal at its end: it is no file of a ray map, or it was cut off",
                          path);
}

static enum rmap_status broken(const char *path, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: its seal does not hold: the file was damaged or changed after it "
                          "was written",
                          path);
}

/* Ranges in order inside [0, end), so that hashing around them stays inside the file. */
static bool in_order(const struct rmap_range *range, uint64_t n, uint64_t end)
{
    uint64_t at = 0;
    for (uint64_t i = 0; i < n; i++) {
        if (range[i].offset < at || range[i].offset > end ||
            range[i].nbytes > end - range[i].offset)
            return false;
        at = range[i].offset + range[i].nbytes;
    }
    return true;
}

static enum rmap_status check(int fd, const char *path, uint64_t nbytes, struct rmap_range **range,
                              struct rmap_error *err)
{
    struct footer footer;
    uint64_t hash = 0;
    if (nbytes < sizeof footer)
        return no_seal(path, err);
    uint64_t end = nbytes - sizeof footer;
    if (read_all(fd, &footer, sizeof footer, end) != 0)
        return failed(path, "cannot be read", err);
    if (memcmp(footer.magic, magic, sizeof magic) != 0)
        return no_seal(path, err);
    if (footer.n > end / sizeof **range)
        return broken(path, err);
    end -= footer.n * sizeof **range;
    *range = rmap_alloc((size_t)footer.n, sizeof **range);
    if (!*range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the seal of %s", path);
    size_t ranges_nbytes = (size_t)footer.n * sizeof **range;
    if (read_all(fd, *range, ranges_nbytes, end) != 0)
        return failed(path, "cannot be read", err);
    if (footer.own_hash != hash_own(*range, &footer) || !in_order(*range, footer.n, end))
        return broken(path, err);
    if (hash_rest(fd, end, *range, (size_t)footer.n, &hash) != 0)
        return failed(path, "cannot be read", err);
    return hash == footer.rest_hash ? RMAP_OK : broken(path, err);
}

enum rmap_status rmap_seal_check(const char *path, struct rmap_error *err)
{
    struct stat info;
    struct rmap_range *range = NULL;
    /* A pipe would wait for its other end. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return failed(path, "cannot be opened", err);
    enum rmap_status st = RMAP_OK;
    if (fstat(fd, &info) != 0)
        st = failed(path, "cannot be read", err);
    else if (!S_ISREG(info.st_mode))
        st = rmap_error_set(err, RMAP_FORMAT, "%s is not a regular file", path);
    else
        st = check(fd, path, (uint64_t)info.st_size, &range, err);
    (void)close(fd);
    rmap_free(range);
    return st;
}
