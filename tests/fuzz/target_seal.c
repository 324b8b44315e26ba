/* SPDX-License-Identifier: MIT
 *
 * A foreign seal: checking ends in a status, whatever its footer claims. The input is a file; when
 * its first byte is odd the footer's own hash is made right, so that the ranges behind it are
 * looked at, and when bit 1 is set the ranges are the body's and the program writes the seal.
 */
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "io/file/seal.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 1500;

enum { OWN_HASH = 1, WRITE = 2, FOOTER = 32 };

/* A file of this process, gone when it ends. */
static const char *scratch(void)
{
    static char path[64];
    if (!path[0]) {
        (void)snprintf(path, sizeof path, "fuzz-seal-%ld", (long)getpid());
        FILE *out = fopen(path, "wb");
        rmap_fuzz_demand(out != NULL && fclose(out) == 0, "a scratch file");
    }
    return path;
}

static void remove_scratch(void)
{
    (void)unlink(scratch());
}

static void put_file(const uint8_t *data, size_t nbytes)
{
    static int begun;
    if (!begun++)
        (void)atexit(remove_scratch);
    int fd = open(scratch(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    rmap_fuzz_demand(fd >= 0 && (nbytes == 0 || write(fd, data, nbytes) == (ssize_t)nbytes),
                     "writing the scratch file");
    (void)close(fd);
}

/* The hash over ranges and footer, made anew where the footer's count allows. */
static void mend(uint8_t *data, size_t nbytes)
{
    uint64_t n;
    if (nbytes < FOOTER)
        return;
    memcpy(&n, data + nbytes - FOOTER, sizeof n);
    if (n > (nbytes - FOOTER) / sizeof(struct rmap_range))
        return;
    const uint8_t *from = data + nbytes - FOOTER - n * sizeof(struct rmap_range);
    uint64_t hash = XXH3_64bits(from, n * sizeof(struct rmap_range) + 16);
    memcpy(data + nbytes - 16, &hash, sizeof hash);
    memcpy(data + nbytes - 8, "rmapseal", 8);
}

/* Seals a body of our own with ranges inside it; it must hold, and not with a byte changed. */
static void seal_and_spoil(const uint8_t *data, size_t nbytes)
{
    struct rmap_range range[4];
    struct rmap_error err = {0};
    size_t n = nbytes / 64 < 4 ? nbytes / 64 : 4;
    if (nbytes == 0)
        return;
    for (size_t k = 0; k < n; k++)
        range[n - 1 - k] = (struct rmap_range){64 * k, data[k] % 64};
    put_file(data, nbytes);
    rmap_fuzz_demand(rmap_seal_write(scratch(), range, n, &err) == RMAP_OK, "a seal is written");
    rmap_fuzz_demand(rmap_seal_check(scratch(), &err) == RMAP_OK, "a seal holds");
    uint8_t last = (uint8_t)~data[nbytes - 1]; /* of the body, outside the ranges unless in one */
    bool covered = n == 0 || nbytes - 1 >= range[n - 1].offset + range[n - 1].nbytes;
    int fd = open(scratch(), O_WRONLY);
    rmap_fuzz_demand(fd >= 0 && pwrite(fd, &last, 1, (off_t)nbytes - 1) == 1, "a byte changes");
    (void)close(fd);
    rmap_fuzz_demand((rmap_seal_check(scratch(), &err) == RMAP_FORMAT) == covered,
                     "a changed byte breaks the seal");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_error err = {0};
    int64_t live = rmap_alloc_live();
    uint8_t flags = 0;
    rmap_fuzz_take(&data, &nbytes, &flags, 1);
    uint8_t *copy = rmap_alloc(nbytes, 1);
    rmap_fuzz_demand(copy != NULL, "memory");
    if (nbytes > 0)
        memcpy(copy, data, nbytes);
    if (flags & OWN_HASH)
        mend(copy, nbytes);
    if (flags & WRITE) {
        seal_and_spoil(copy, nbytes);
    } else {
        put_file(copy, nbytes);
        enum rmap_status st = rmap_seal_check(scratch(), &err);
        rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign seal");
    }
    rmap_free(copy);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* Sealed files with 0 to 4 ranges, with each flag. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    struct rmap_range range[4];
    struct rmap_error err = {0};
    uint8_t body[300];
    size_t n = k / 3;
    if (k >= 15 || cap < 1000)
        return 0;
    for (size_t i = 0; i < sizeof body; i++)
        body[i] = (uint8_t)(i * 37);
    for (size_t i = 0; i < n; i++)
        range[i] = (struct rmap_range){10 + 70 * i, 50};
    put_file(body, sizeof body);
    rmap_fuzz_demand(rmap_seal_write(scratch(), range, n, &err) == RMAP_OK, "a seal is written");
    to[0] = (uint8_t)(k % 3);
    int fd = open(scratch(), O_RDONLY);
    ssize_t got = fd < 0 ? -1 : read(fd, to + 1, cap - 1);
    (void)close(fd);
    rmap_fuzz_demand(got > 0, "a seed is read");
    return (size_t)got + 1;
}
