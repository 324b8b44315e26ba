/* SPDX-License-Identifier: MIT */
#define _XOPEN_SOURCE 700 /* realpath */
#include "io/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

const char *rmap_input_file_trouble(const char *path)
{
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return strerror(errno);
    const char *trouble = fstat(fd, &info) != 0   ? strerror(errno)
                          : S_ISREG(info.st_mode) ? NULL
                                                  : "it is no regular file";
    (void)close(fd);
    return trouble;
}

/* Whether a file is `entry`, or lies below it. */
static bool holds(const char *entry, const char *file)
{
    char *real = realpath(entry, NULL);
    const size_t n = real ? strlen(real) : 0;
    const bool below = real && strncmp(file, real, n) == 0 && (file[n] == '/' || file[n] == '\0');
    free(real);
    return below;
}

bool rmap_plugin_is_allowed(const char *path)
{
    const char *allowed = getenv("RAYMAP_ALLOW_PLUGINS");
    char *list = allowed ? rmap_strdup(allowed) : NULL;
    char *file = list ? realpath(path, NULL) : NULL;
    bool found = false;
    char *rest = list;
    for (char *entry; file && !found && rest && (entry = strtok_r(rest, ":", &rest));)
        found = holds(entry, file);
    free(file);
    rmap_free(list);
    return found;
}
