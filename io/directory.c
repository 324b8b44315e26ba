/* SPDX-License-Identifier: MIT */
#include "io/directory.h"

#include <dirent.h>
#include <errno.h>
#include <string.h>

enum { DIGITS = 5 };

int rmap_directory_number(const char *name, const char *prefix, const char *suffix)
{
    size_t n = strlen(prefix);
    int number = 0;
    if (strlen(name) != n + DIGITS + strlen(suffix) || strncmp(name, prefix, n) != 0 ||
        strcmp(name + n + DIGITS, suffix) != 0)
        return -1;
    for (int k = 0; k < DIGITS; k++) {
        char c = name[n + (size_t)k];
        if (c < '0' || c > '9')
            return -1;
        number = 10 * number + (c - '0');
    }
    return number;
}

enum rmap_status rmap_directory_visit(const char *path,
                                      enum rmap_status (*visit)(void *context, const char *name,
                                                                struct rmap_error *err),
                                      void *context, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    DIR *directory = opendir(path);
    if (!directory)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot list the directory: %s", path,
                              strerror(errno));
    struct dirent *entry;
    while (st == RMAP_OK && (errno = 0, entry = readdir(directory)))
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            st = visit(context, entry->d_name, err);
    if (st == RMAP_OK && errno != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: reading the directory: %s", path,
                            strerror(errno));
    (void)closedir(directory);
    return st;
}
