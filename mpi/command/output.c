/* SPDX-License-Identifier: MIT
 *
 * Where and how a command may write its result.
 */
#include "mpi/command/output.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "io/file/publish.h"

bool rmap_output_is(const char *path, const char *suffix)
{
    size_t len = strlen(path), n = strlen(suffix);
    return len > n && strcasecmp(path + len - n, suffix) == 0;
}

enum rmap_status rmap_output_free(const char *path, bool force, struct rmap_error *err)
{
    struct stat status;
    if (lstat(path, &status) != 0) /* a link that leads nowhere stands there all the same */
        return rmap_path_check_folder(path, err);
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        return rmap_error_set(err, RMAP_USAGE, "'%s' is a directory; give the name of a file",
                              path);
    return force ? RMAP_OK
                 : rmap_error_set(err, RMAP_USAGE,
                                  "'%s' exists; give another name, or --force to replace it", path);
}

enum rmap_status rmap_output_check(const char *path, const char *const *suffix, bool force,
                                   struct rmap_error *err)
{
    char list[128] = "";
    bool known = false;
    for (size_t i = 0; suffix[i]; i++) {
        size_t at = strlen(list);
        known = known || rmap_output_is(path, suffix[i]);
        const char *between = i == 0 ? "" : suffix[i + 1] ? ", " : " or ";
        (void)snprintf(list + at, sizeof list - at, "%s%s", between, suffix[i]);
    }
    if (!known)
        return rmap_error_set(err, RMAP_USAGE,
                              "cannot write '%s': the output takes a name that ends in %s", path,
                              list);
    return rmap_output_free(path, force, err);
}

enum rmap_status rmap_output_encoding(const char *word, enum rmap_encoding *encoding,
                                      struct rmap_error *err)
{
    *encoding = RMAP_ENCODING_COUNT;
    if (!word)
        return RMAP_OK;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++)
        if (strcmp(word, rmap_encoding_name((enum rmap_encoding)e)) == 0)
            *encoding = (enum rmap_encoding)e;
    if (*encoding == RMAP_ENCODING_COUNT || !rmap_layout_of(*encoding, RMAP_COLOUR_SPECTRAL))
        return rmap_error_set(err, RMAP_USAGE, "--encoding is 'plain' or 'compact', not '%s'",
                              word);
    return RMAP_OK;
}

bool rmap_same_place(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}
