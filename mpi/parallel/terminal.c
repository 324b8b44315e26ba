/* SPDX-License-Identifier: MIT
 *
 * Standard output and error as a terminal may be shown them: whatever the program prints goes
 * through base/visible_text.h, so that no name steers the terminal.
 */
#define _GNU_SOURCE /* fopencookie */
#include "mpi/parallel/terminal.h"

#include <stdbool.h>
#include <stdio.h>
#include <unistd.h>

#include "base/visible_text.h"

#if defined(__GLIBC__)
struct guarded {
    int fd;
    struct rmap_visible_text text;
};

static bool write_all(int fd, const char *bytes, size_t nbytes)
{
    while (nbytes > 0) {
        const ssize_t n = write(fd, bytes, nbytes);
        if (n < 0)
            return false;
        bytes += n;
        nbytes -= (size_t)n;
    }
    return true;
}

static ssize_t write_visible(void *cookie, const char *bytes, size_t nbytes)
{
    enum { STEP = 4096 };
    struct guarded *guarded = cookie;
    char out[RMAP_VISIBLE_NBYTES(STEP)];
    for (size_t at = 0; at < nbytes; at += STEP) {
        const size_t len = nbytes - at < STEP ? nbytes - at : STEP;
        if (!write_all(guarded->fd, out, rmap_visible_text(&guarded->text, bytes + at, len, out)))
            return (ssize_t)at;
    }
    return (ssize_t)nbytes;
}

static void guard(FILE **stream, struct guarded *guarded, int buffering)
{
    const cookie_io_functions_t calls = {.write = write_visible};
    FILE *shown = fopencookie(guarded, "w", calls);
    if (!shown)
        return;
    (void)setvbuf(shown, NULL, buffering, BUFSIZ);
    *stream = shown;
}

void rmap_terminal_guard(void)
{
    static struct guarded out = {.fd = STDOUT_FILENO}, err = {.fd = STDERR_FILENO};
    guard(&stdout, &out, isatty(STDOUT_FILENO) == 1 ? _IOLBF : _IOFBF);
    guard(&stderr, &err, _IONBF);
}
#else
void rmap_terminal_guard(void)
{
}
#endif
