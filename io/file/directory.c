/* SPDX-License-Identifier: MIT
 *
 * Walking through a directory whose files have numbered names.
 */
#include "io/file/directory.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"

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

enum rmap_status rmap_path_look(const char *path, struct stat *info, struct rmap_error *err)
{
    if (stat(path, info) == 0)
        return RMAP_OK;
    *info = (struct stat){0};
    return errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "%s: %s", path, strerror(errno));
}

static enum rmap_status visit_open(DIR *directory, const char *path, rmap_directory_visitor *visit,
                                   void *context, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct dirent *entry;
    while (st == RMAP_OK && (errno = 0, entry = readdir(directory)))
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            st = visit(context, dirfd(directory), entry->d_name, err);
    if (st == RMAP_OK && errno != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: reading the directory: %s", path,
                            strerror(errno));
    (void)closedir(directory);
    return st;
}

static enum rmap_status cannot_list(const char *path, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot list the directory: %s", path,
                          strerror(errno));
}

enum rmap_status rmap_directory_visit(const char *path, rmap_directory_visitor *visit,
                                      void *context, struct rmap_error *err)
{
    DIR *directory = opendir(path);
    return directory ? visit_open(directory, path, visit, context, err) : cannot_list(path, err);
}

enum rmap_status rmap_shard_visit(int map, const char *path, rmap_directory_visitor *visit,
                                  void *context, struct rmap_error *err)
{
    int fd = -1;
    enum rmap_status st = rmap_shard_open(map, path, &fd, err);
    if (st != RMAP_OK)
        return st;
    DIR *directory = fdopendir(fd);
    if (directory)
        return visit_open(directory, path, visit, context, err);
    st = cannot_list(path, err);
    (void)close(fd);
    return st;
}

static const char *last_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

enum rmap_status rmap_shard_open(int map, const char *path, int *fd_ret, struct rmap_error *err)
{
    *fd_ret = openat(map, map == AT_FDCWD ? path : last_of(path),
                     O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (*fd_ret >= 0)
        return RMAP_OK;
    if (errno == ELOOP || errno == ENOTDIR)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s is a link or a file, not a folder of this map: nothing is "
                              "written or removed through it; put the folder itself there, or "
                              "take the link away",
                              path);
    return cannot_list(path, err);
}

int rmap_shard_unlink(const char *path)
{
    const char *name = last_of(path);
    char *shard = rmap_path_format("%.*s", (int)(name - path - 1), path);
    int folder = shard ? open(shard, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1;
    int reason = shard ? errno : ENOMEM;
    int failed = folder < 0 ? -1 : unlinkat(folder, name, 0);
    reason = folder < 0 ? reason : errno;
    if (folder >= 0)
        (void)close(folder);
    rmap_free(shard);
    errno = reason;
    return failed;
}

enum rmap_status rmap_folder_make(const char *folder, struct rmap_error *err)
{
    const mode_t all = 0777;
    struct stat info;
    if (mkdir(folder, all) == 0)
        return RMAP_OK;
    const int why = errno;
    if (why == EEXIST && stat(folder, &info) == 0 && S_ISDIR(info.st_mode))
        return RMAP_OK;
    return rmap_error_set(err, why == EEXIST ? RMAP_USAGE : RMAP_SYSTEM,
                          "folder %s cannot be made: %s", folder, strerror(why));
}

enum rmap_status rmap_folder_make_all(const char *folder, size_t *had, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *name = rmap_strdup(folder);
    *had = 0;
    if (!name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a folder's name");
    for (size_t n = 1; name[0] && st == RMAP_OK; n++) {
        const char cut = name[n];
        if (cut && (cut != '/' || name[n - 1] == '/'))
            continue;
        name[n] = 0;
        struct stat info;
        if (stat(name, &info) == 0 && S_ISDIR(info.st_mode))
            *had = n;
        else
            st = rmap_folder_make(name, err);
        name[n] = cut;
        if (!cut)
            break;
    }
    if (st != RMAP_OK)
        rmap_folder_unmake(folder, *had);
    rmap_free(name);
    return st;
}

void rmap_folder_unmake(const char *folder, size_t had)
{
    char *name = rmap_strdup(folder);
    for (size_t n = name ? strlen(name) : 0; n > had; n--)
        if (!name[n] || name[n] == '/') {
            name[n] = 0;
            (void)rmdir(name);
        }
    rmap_free(name);
}
