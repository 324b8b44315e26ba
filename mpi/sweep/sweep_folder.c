/* SPDX-License-Identifier: MIT */
#include "mpi/sweep/sweep_folder.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/file_lock.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"
#include "io/file/text_file.h"
#include "io/file/whole_file.h"
#include "io/map/map_directory.h"
#include "io/mesh/bundle_pack.h"
#include "io/scene/scene_include.h"
#include "mpi/parallel/progress.h"
#include "portion/portion.h"
#include "trace/tracer_revision.h"

static const struct rmap_text_kind sweep_copy = {"the sweep that a folder holds", NULL, "",
                                                 (size_t)1 << 26};
static const double sync_s =
    5.0; /* what a crash of the machine loses; a killed program loses none */

/* What a state begins with, but not of earlier programs. */
#define FILES_MARK "--- files "
#define SCENE_MARK "--- scene"

static const char *behind_line(const char *text)
{
    text += strcspn(text, "\n");
    return text + (*text == '\n');
}

/* Bytes of a line about the first that differs, whole characters; a line between parts is none. */
static void cut_out(const char *line, size_t n, size_t differs, char text[80])
{
    size_t from = differs > 24 ? differs - 24 : 0, end = from + 64;
    n = strncmp(line, "--- ", 4) == 0 ? 0 : n;
    while (from > 0 && from < n && ((unsigned char)line[from] & 0xC0U) == 0x80U)
        from--;
    while (end > from && end < n && ((unsigned char)line[end] & 0xC0U) == 0x80U)
        end--;
    from = from < n ? from : n;
    end = end < n ? end : n;
    (void)snprintf(text, 80, "%s%.*s%s", from > 0 ? "..." : "", (int)(end - from), line + from,
                   end < n ? "..." : "");
}

/* The first line in which two texts differ, as a line of the file that it is of. */
static enum rmap_status check_lines(const struct rmap_sweep_run *run, const char *before,
                                    const char *now, struct rmap_error *err)
{
    const char *file = run->sweep->path;
    char was[80], is[80];
    size_t n_mark = strlen(RMAP_INCLUDE_MARK), differs = 0;
    int line = 0;
    for (; *before || *now; before = behind_line(before), now = behind_line(now)) {
        const size_t a = strcspn(before, "\n"), b = strcspn(now, "\n");
        const bool is_set = strncmp(before, "--set ", 6) == 0 || strncmp(now, "--set ", 6) == 0;
        line++;
        if (a != b || memcmp(before, now, a) != 0) {
            file = is_set ? "--set" : file;
            while (differs < a && before[differs] == now[differs])
                differs++;
            cut_out(before, is_set && before[0] != '-' ? 0 : a, differs, was);
            cut_out(now, is_set && now[0] != '-' ? 0 : b, differs, is);
            return rmap_error_set(err, RMAP_INPUT,
                                  "%s holds another sweep: line %d of %.*s was '%s' and is '%s'; "
                                  "give another -o, or bring the line back",
                                  run->folder, line, (int)strcspn(file, "\n"), file, was, is);
        }
        const bool is_scene = b == strlen(SCENE_MARK) && strncmp(now, SCENE_MARK, b) == 0;
        const bool is_include = strncmp(now, RMAP_INCLUDE_MARK, n_mark) == 0;
        file = is_scene ? run->scene_path : is_include ? now + n_mark : file;
        line = is_scene || is_include || is_set ? 0 : line;
    }
    return RMAP_OK;
}

static enum rmap_status check_same(const struct rmap_sweep_run *run, const char *before,
                                   const char *now, struct rmap_error *err)
{
    const size_t n_digest = strlen(FILES_MARK) + 32, n_head = (size_t)(behind_line(now) - now);
    const bool has_head = strncmp(before, FILES_MARK, strlen(FILES_MARK)) == 0;
    const enum rmap_status st =
        check_lines(run, has_head ? behind_line(before) : before, behind_line(now), err);
    if (st != RMAP_OK) /* a text that names other files says more than their digest */
        return st;
    if (has_head && strncmp(before, now, n_digest) != 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s holds another sweep: meshes or other files that the scene reads "
                              "have changed; give another -o, or bring them back",
                              run->folder);
    if (has_head && strncmp(before, now, n_head) != 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s holds rays of another revision of the tracer, which do not go "
                              "with those of this one: give another -o",
                              run->folder);
    return RMAP_OK;
}

/* The file that a value names, as scenes do; NULL: no memory. */
static char *file_named(const char *scene_path, const char *value)
{
    const char *slash = value[0] == '/' ? NULL : strrchr(scene_path, '/');
    return rmap_path_format("%.*s%s", slash ? (int)(slash + 1 - scene_path) : 0, scene_path, value);
}

/* Over the digest of the scene's files those that variants have in their place, if any. */
static enum rmap_status digest_values(const struct rmap_sweep_run *run,
                                      const struct rmap_sweep_parameter *parameter, char digest[33],
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < parameter->n_value && st == RMAP_OK; i++) {
        struct stat info;
        uint8_t *bytes = NULL;
        size_t nbytes = 0;
        if (!isnan(parameter->value[i]))
            continue;
        char *path = file_named(run->scene_path, parameter->text[i]);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path");
        if (stat(path, &info) == 0 && S_ISREG(info.st_mode)) {
            st = rmap_input_file_read(path, SIZE_MAX / 2, &bytes, &nbytes, err);
            const XXH128_hash_t file = XXH3_128bits(bytes, nbytes),
                                all = XXH3_128bits_withSeed(digest, 32, file.low64 ^ file.high64);
            rmap_digest_text((struct rmap_digest){all.low64, all.high64}, digest);
        }
        rmap_free(bytes);
        rmap_free(path);
    }
    return st;
}

/* What must be the same for rows to be of one sweep: its file, the scene, and what that reads. */
static enum rmap_status make_state(const struct rmap_sweep_run *run, char **text_ret,
                                   struct rmap_error *err)
{
    const struct rmap_bundle *bundle = run->bundle;
    struct rmap_bundle files = *bundle;
    char digest[33];
    size_t n = strlen(run->sweep->text) + bundle->text_nbytes + 128;
    files.path = files.text = NULL;
    files.text_nbytes = 0;
    files.options = (struct rmap_scene_options){.set = NULL};
    enum rmap_status st = rmap_bundle_digest(&files, digest, err);
    for (size_t i = 0; i < run->sweep->n_parameter && st == RMAP_OK; i++)
        st = digest_values(run, &run->sweep->parameter[i], digest, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < bundle->options.n_set; i++)
        n += strlen(bundle->options.set[i]) + 8;
    char *text = rmap_alloc(n, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sweep");
    size_t used =
        (size_t)snprintf(text, n, FILES_MARK "%s tracer %d\n", digest, RMAP_TRACER_REVISION);
    for (size_t i = 0; i < bundle->options.n_set; i++)
        used += (size_t)snprintf(text + used, n - used, "--set %s\n", bundle->options.set[i]);
    (void)snprintf(text + used, n - used, "%s\n" SCENE_MARK "\n%s", run->sweep->text, bundle->text);
    *text_ret = text;
    return RMAP_OK;
}

struct cleared {
    const char *folder;
};

/* What a sweep wrote there, and nothing else; but sweep.txt, which says whose rows stand there
 * until they are gone. */
static enum rmap_status remove_result(void *context, int directory, const char *name,
                                      struct rmap_error *err)
{
    const char *folder = ((const struct cleared *)context)->folder;
    static const char *const file[] = {"table.csv", "table.h5", "plot.svg"};
    enum rmap_status st = RMAP_OK;
    bool goes = rmap_directory_number(name, "rows-", ".jsonl") >= 0;
    for (size_t i = 0; i < sizeof file / sizeof *file; i++)
        goes = goes || strcmp(name, file[i]) == 0;
    if (goes && unlinkat(directory, name, 0) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s/%s cannot be removed: %s", folder, name,
                              strerror(errno));
    const size_t len = strlen(name);
    if (strncmp(name, "variant-", 8) == 0 && len > 7 && strcmp(name + len - 7, ".raymap") == 0) {
        char *path = rmap_path_format("%s/%s", folder, name);
        st = path ? rmap_map_remove(path, err)
                  : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path");
        rmap_free(path);
    }
    return st;
}

static enum rmap_status clear(const char *folder, struct rmap_error *err)
{
    struct cleared cleared = {folder};
    return rmap_directory_visit(folder, remove_result, &cleared, err);
}

struct rows {
    const char *folder;
    bool any, grow;
};

/* Without them there is nothing to lose, as where the first variant had a mistake. */
static enum rmap_status look_for_rows(void *context, int directory, const char *name,
                                      struct rmap_error *err)
{
    struct rows *rows = context;
    struct stat info;
    if (rmap_directory_number(name, "rows-", ".jsonl") < 0)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", rows->folder, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path");
    rows->any |= fstatat(directory, name, &info, 0) == 0 && info.st_size > 0;
    rows->grow |= rmap_file_is_locked(path);
    rmap_free(path);
    return RMAP_OK;
}

/* Ranks that are being killed may outlive the one that had the folder's lock. */
static enum rmap_status await_rows(struct rows *rows, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 100000000};
    enum rmap_status st = rmap_directory_visit(rows->folder, look_for_rows, rows, err);
    for (int naps = 0; st == RMAP_OK && rows->grow && naps < 20; naps++) {
        (void)nanosleep(&nap, NULL);
        rows->grow = false;
        st = rmap_directory_visit(rows->folder, look_for_rows, rows, err);
    }
    if (st == RMAP_OK && rows->grow)
        st = rmap_error_set(err, RMAP_USAGE,
                            "%s is being written to by ranks of another raymap: stop them first, "
                            "or wait for their end",
                            rows->folder);
    return st;
}

enum rmap_status rmap_sweep_folder_prepare(struct rmap_sweep_run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *state = NULL, *before = NULL, *path = rmap_path_format("%s/sweep.txt", run->folder);
    size_t nbytes = 0;
    struct stat info;
    struct rows rows = {.folder = run->folder};
    if (!path)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sweep"));
    RMAP_TRY(make_state(run, &state, err));
    RMAP_TRY(rmap_folder_make(run->folder, err));
    RMAP_TRY(rmap_folder_lock_take(run->folder, "sweep", &run->lock, err));
    RMAP_TRY(await_rows(&rows, err));
    if (run->is_forced)
        RMAP_TRY(clear(run->folder, err));
    RMAP_TRY(rmap_path_look(path, &info, err));
    if (info.st_mode == 0 && !run->is_forced && rows.any)
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s holds rows of a sweep, and no sweep.txt that says of which: "
                                "--force begins anew, or give another -o",
                                run->folder));
    if (!run->is_resumed && !run->is_forced && rows.any)
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s holds a sweep already: --resume goes on with it, --force "
                                "begins anew, or give another -o",
                                run->folder));
    if (info.st_mode != 0 && run->is_resumed) {
        RMAP_TRY(rmap_text_file_read(path, &sweep_copy, &before, &nbytes, err));
        RMAP_TRY(check_same(run, before, state, err));
        goto out;
    }
    st = rmap_whole_file_put_bytes(path, state, strlen(state), err);
out:
    rmap_free(before);
    rmap_free(state);
    rmap_free(path);
    return st;
}

struct journals {
    struct rmap_sweep_run *run;
};

/* A line that was cut off, the last one, is no JSON and counts for nothing. */
static enum rmap_status read_journal(void *context, int directory, const char *name,
                                     struct rmap_error *err)
{
    struct journals *self = context;
    char *text = NULL, *path = NULL;
    size_t nbytes = 0;
    struct stat info;
    enum rmap_status st = RMAP_OK;
    if (rmap_directory_number(name, "rows-", ".jsonl") < 0 ||
        fstatat(directory, name, &info, 0) != 0 || info.st_size == 0)
        return RMAP_OK;
    path = rmap_path_format("%s/%s", self->run->folder, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a journal");
    RMAP_TRY(rmap_text_file_read(path, &sweep_copy, &text, &nbytes, err));
    for (const char *line = text; *line;) {
        const size_t n = strcspn(line, "\n");
        if (line[n] == '\n')
            rmap_sweep_row_take(&self->run->table, line, n);
        line += n + (line[n] == '\n');
    }
out:
    rmap_free(text);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_sweep_folder_rows(struct rmap_sweep_run *run, struct rmap_error *err)
{
    struct journals journals = {run};
    return rmap_directory_visit(run->folder, read_journal, &journals, err);
}

enum rmap_status rmap_sweep_journal_open(const struct rmap_sweep_run *run, int number,
                                         struct rmap_sweep_journal *journal, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *path = rmap_path_format("%s/rows-%05d.jsonl", run->folder, number);
    journal->file = path ? open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666) : -1;
    if (journal->file < 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s cannot be written to: %s", run->folder,
                            strerror(errno));
    else
        rmap_file_lock(journal->file);
    if (st == RMAP_OK && lseek(journal->file, 0, SEEK_END) > 0) /* behind a line that was cut off */
        (void)!write(journal->file, "\n", 1);
    rmap_free(path);
    return st;
}

/* A row is written in one go: what a killed program leaves is whole rows and at most a part of one.
 */
enum rmap_status rmap_sweep_journal_commit(const struct rmap_sweep_run *run,
                                           struct rmap_sweep_journal *journal, uint64_t variant,
                                           struct rmap_error *err)
{
    char *row = rmap_sweep_row_line(&run->table, variant);
    char *line = row ? rmap_path_format("%s\n", row) : NULL;
    enum rmap_status st = RMAP_OK;
    if (!line)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a row");
    else if (write(journal->file, line, strlen(line)) != (ssize_t)strlen(line))
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: a row cannot be written: %s", run->folder,
                            strerror(errno));
    if (st == RMAP_OK && rmap_clock_seconds() - journal->synced > sync_s) {
        (void)fdatasync(journal->file);
        journal->synced = rmap_clock_seconds();
    }
    rmap_free(line);
    rmap_free(row);
    return st;
}

enum rmap_status rmap_sweep_journal_close(const struct rmap_sweep_run *run,
                                          struct rmap_sweep_journal *journal,
                                          struct rmap_error *err)
{
    const int file = journal->file;
    journal->file = -1;
    return file >= 0 && (fdatasync(file) | close(file)) != 0
               ? rmap_error_set(err, RMAP_SYSTEM, "%s: rows cannot be written: %s", run->folder,
                                strerror(errno))
               : RMAP_OK;
}
