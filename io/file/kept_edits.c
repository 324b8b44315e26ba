/* SPDX-License-Identifier: MIT
 *
 * Texts that may be written again unless a person has changed them.
 */
#include "io/file/kept_edits.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"
#include "io/file/whole_file.h"

enum { NBYTES_MAX = 256 << 20, MARK = 128, COPIES_MAX = 1000 };

/* Whole lines end it, so that a line that is cut off is an edit, too. */
static int write_mark(char mark[MARK], const char *text, size_t nbytes)
{
    return snprintf(mark, MARK,
                    "# digest %016" PRIx64 " of the lines above, as they were written: while it "
                    "holds, nobody has edited them\n",
                    XXH3_64bits(text, nbytes));
}

static bool is_untouched(const char *text, size_t nbytes)
{
    char mark[MARK];
    const size_t n = (size_t)write_mark(mark, "", 0);
    return nbytes >= n && (write_mark(mark, text, nbytes - n), true) &&
           memcmp(text + nbytes - n, mark, n) == 0;
}

enum rmap_status rmap_edits_find(const char *path, enum rmap_edits *edits, struct rmap_error *err)
{
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    *edits = RMAP_EDITS_NO_FILE;
    if (access(path, F_OK) != 0 && errno == ENOENT)
        return RMAP_OK;
    const enum rmap_status st = rmap_input_file_read(path, NBYTES_MAX, &bytes, &nbytes, err);
    if (st == RMAP_OK)
        *edits = is_untouched((const char *)bytes, nbytes) ? RMAP_EDITS_NONE : RMAP_EDITS_MADE;
    else
        rmap_error_context(err, "%s", path);
    rmap_free(bytes);
    return st;
}

enum rmap_status rmap_edits_refuse(const char *path, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_USAGE,
                          "%s has edits, or is not of this program: --force keeps it as %s.bak and "
                          "writes a new one; -o names another folder",
                          path, path);
}

/* Gives the file another name that nothing has. */
static enum rmap_status set_aside(const char *path, char **kept_ret, struct rmap_error *err)
{
    for (int k = 1; k <= COPIES_MAX; k++) {
        char *name =
            k == 1 ? rmap_path_format("%s.bak", path) : rmap_path_format("%s.bak.%d", path, k);
        if (!name)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name");
        if (link(path, name) == 0) {
            *kept_ret = name; /* the old name is the new file's in a moment */
            return RMAP_OK;
        }
        const int why = errno;
        rmap_free(name);
        if (why != EEXIST)
            return rmap_error_set(err, RMAP_SYSTEM, "%s cannot be kept as %s.bak: %s", path, path,
                                  strerror(why));
    }
    return rmap_error_set(err, RMAP_USAGE, "%d copies of %s stand beside it: remove some",
                          COPIES_MAX, path);
}

enum rmap_status rmap_edits_put(const char *path, bool force,
                                enum rmap_status (*put)(const void *context, FILE *file,
                                                        struct rmap_error *err),
                                const void *context, char **kept_ret, struct rmap_error *err)
{
    enum rmap_edits edits = RMAP_EDITS_NO_FILE;
    char *text = NULL, mark[MARK];
    size_t nbytes = 0;
    struct rmap_whole_file whole = {0};
    *kept_ret = NULL;
    FILE *memory = open_memstream(&text, &nbytes);
    enum rmap_status st = memory ? put(context, memory, err)
                                 : rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", path);
    if (memory && fclose(memory) != 0 && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", path);
    if (st == RMAP_OK)
        st = rmap_edits_find(path, &edits, err);
    if (st == RMAP_OK && edits == RMAP_EDITS_MADE && !force)
        st = rmap_edits_refuse(path, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    const int n = write_mark(mark, text, nbytes);
    (void)fwrite(text, 1, nbytes, whole.file);
    (void)fwrite(mark, 1, (size_t)n, whole.file);
    if (edits == RMAP_EDITS_MADE)
        RMAP_TRY(set_aside(path, kept_ret, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    free(text);
    return st;
}
