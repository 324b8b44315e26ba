/* SPDX-License-Identifier: MIT
 *
 * What commands print, as a document in place of text on standard output.
 */
#include "mpi/serve/serve_capture.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"

enum rmap_status rmap_serve_capture_begin(int *capture_ret, int *out_ret, struct rmap_error *err)
{
    FILE *file = tmpfile(); /* without a name; commands that seek or fill it find nothing unusual */
    const int memory = file ? dup(fileno(file)) : -1;
    const int out = dup(STDOUT_FILENO);
    if (file)
        (void)fclose(file);
    if (memory < 0 || out < 0 || fflush(stdout) != 0 || dup2(memory, STDOUT_FILENO) < 0)
        return rmap_error_set(err, RMAP_SYSTEM, "standard output cannot be led elsewhere: %s",
                              strerror(errno));
    (void)fcntl(out, F_SETFD, FD_CLOEXEC);
    *capture_ret = memory;
    *out_ret = out;
    return RMAP_OK;
}

static char *read_all(int capture, size_t *n_ret)
{
    const off_t end = lseek(capture, 0, SEEK_END);
    char *text = end >= 0 ? rmap_alloc((size_t)end + 1, 1) : NULL;
    size_t n = 0;
    ssize_t got = 1;
    while (text && got > 0 && n < (size_t)end) {
        got = pread(capture, text + n, (size_t)end - n, (off_t)n);
        n += got > 0 ? (size_t)got : 0;
    }
    *n_ret = n;
    return text;
}

json_t *rmap_serve_capture_take(int capture)
{
    size_t n = 0;
    (void)fflush(stdout);
    clearerr(stdout);
    char *text = read_all(capture, &n);
    json_t *document = text ? json_loadb(text, n, 0, NULL) : NULL;
    if (ftruncate(capture, 0) != 0 || lseek(capture, 0, SEEK_SET) < 0)
        clearerr(stdout); /* the next answer says that there is none */
    rmap_free(text);
    return document ? document : json_null();
}
