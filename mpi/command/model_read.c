/* SPDX-License-Identifier: MIT
 *
 * A model of a CAD program, read.
 */
#include "mpi/command/model_read.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/file_lock.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"
#include "mpi/command/output.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/nap.h"

extern char **environ;

enum { PATH = 4096, SAID_NBYTES = 65536 };

static const char *const through_step[] = {".step", ".stp", ".iges", ".igs"};
static const char *const meshes[] = {".gltf", ".glb", ".obj", ".stl", ".ply"};

static bool is_one_of(const char *path, const char *const *suffix, size_t n)
{
    bool is = false;
    for (size_t i = 0; i < n; i++)
        is |= rmap_output_is(path, suffix[i]);
    return is;
}

static bool is_step(const char *path)
{
    return is_one_of(path, through_step, sizeof through_step / sizeof *through_step);
}

bool rmap_model_is_one(const char *path)
{
    return is_step(path) || is_one_of(path, meshes, sizeof meshes / sizeof *meshes);
}

/* ---- raymap-step ---- */

/* Beside this program, or where programs that are not for people stand. */
static bool find_converter(char program[PATH])
{
    static const char *const place[] = {"/raymap-step", "/../libexec/raymap/raymap-step"};
    char own[PATH - 64];
    const ssize_t n = readlink("/proc/self/exe", own, sizeof own - 1);
    char *slash = n > 0 ? (own[n] = 0, strrchr(own, '/')) : NULL;
    for (size_t i = 0; slash && i < sizeof place / sizeof *place; i++) {
        (void)snprintf(program, PATH, "%.*s%s", (int)(slash - own), own, place[i]);
        if (access(program, X_OK) == 0)
            return true;
    }
    return false;
}

/* Until it ends, or is ended, as we are asked to. */
static enum rmap_status wait_for(pid_t child, int *wait_status, struct rmap_error *err)
{
    bool asked = false;
    for (;;) {
        const pid_t ended = waitpid(child, wait_status, WNOHANG);
        if (ended == child)
            return asked ? rmap_interrupt_stopped(err) : RMAP_OK;
        if (ended < 0 && errno != EINTR)
            return rmap_error_set(err, RMAP_SYSTEM, "raymap-step cannot be waited for: %s",
                                  strerror(errno));
        if (!asked && rmap_interrupt_caught()) {
            asked = true;
            (void)kill(child, SIGKILL); /* what it wrote goes with its folder */
        }
        rmap_nap();
    }
}

/* The child reads nothing and prints nothing; what it complains of goes to a file. */
static enum rmap_status start(const char *program, char *const *argv, const char *said,
                              int *wait_status, struct rmap_error *err)
{
    posix_spawn_file_actions_t actions;
    pid_t child = 0;
    int why = posix_spawn_file_actions_init(&actions);
    if (why != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "raymap-step cannot be started: %s", strerror(why));
    const int mode = S_IRUSR | S_IWUSR;
    why = posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (why == 0)
        why = posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (why == 0)
        why = posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, said,
                                               O_WRONLY | O_CREAT | O_EXCL, (mode_t)mode);
    if (why == 0)
        why = posix_spawn(&child, program, &actions, NULL, argv, environ);
    (void)posix_spawn_file_actions_destroy(&actions);
    if (why != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "raymap-step cannot be started: %s", strerror(why));
    return wait_for(child, wait_status, err);
}

/* Its last line is the reason, and names the file. */
static enum rmap_status complain(const char *path, const char *said, int wait_status,
                                 struct rmap_error *err)
{
    uint8_t *text = NULL;
    size_t nbytes = 0;
    struct rmap_error unheard = {0};
    const int code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 0;
    const enum rmap_status st = code == RMAP_USAGE    ? RMAP_USAGE
                                : code == RMAP_SYSTEM ? RMAP_SYSTEM
                                                      : RMAP_INPUT;
    if (rmap_input_file_read(said, SAID_NBYTES, &text, &nbytes, &unheard) != RMAP_OK)
        text = NULL;
    while (text && nbytes > 0 && text[nbytes - 1] <= ' ')
        text[--nbytes] = 0;
    const char *line = text ? strrchr((const char *)text, '\n') : NULL;
    line = line ? line + 1 : (const char *)text;
    if (WIFSIGNALED(wait_status))
        (void)rmap_error_set(
            err, RMAP_INPUT,
            "%s: raymap-step ended by signal %d: the file is damaged, or more than "
            "OpenCASCADE can read",
            path, WTERMSIG(wait_status));
    else if (line && line[0])
        (void)rmap_error_set(err, st, "%.900s", line);
    else
        (void)rmap_error_set(err, st, "%s: raymap-step ended with status %d", path, code);
    rmap_free(text);
    return WIFSIGNALED(wait_status) ? RMAP_INPUT : st;
}

static enum rmap_status convert(const struct rmap_model_request *request, const char *made,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char program[PATH], *said = rmap_path_format("%s/said", made),
                        *model = rmap_path_format("%s/" RMAP_MODEL_MADE, made);
    const char *argv[10] = {"raymap-step", "--quiet"};
    int n = 2, wait_status = 0;
    if (!said || !model)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
    if (!find_converter(program))
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM,
                           "raymap-step, which reads STEP and IGES, is not here: it is built "
                           "and installed beside raymap where OpenCASCADE is "
                           "(jobs/install-packages.sh cad); glTF, OBJ, STL and PLY need it not"));
    if (request->is_update)
        argv[n++] = "--no-touching";
    if (request->chord) {
        argv[n++] = "--chord";
        argv[n++] = request->chord;
    }
    if (request->angle) {
        argv[n++] = "--angle";
        argv[n++] = request->angle;
    }
    argv[n++] = request->path;
    argv[n++] = model;
    RMAP_TRY(start(program, (char *const *)(void *)argv, said, &wait_status, err));
    if (!WIFEXITED(wait_status) || WEXITSTATUS(wait_status) != 0)
        st = complain(request->path, said, wait_status, err);
out:
    rmap_free(said);
    rmap_free(model);
    return st;
}

/* ---- the folder of what it makes ---- */

#define MADE      ".raymap-"
#define MADE_LOCK "lock"

static enum rmap_status remove_one(void *context, int directory, const char *name,
                                   struct rmap_error *err)
{
    (void)context, (void)err;
    (void)unlinkat(directory, name, 0);
    return RMAP_OK;
}

static void remove_folder(const char *folder)
{
    struct rmap_error unheard = {0};
    if (rmap_directory_visit(folder, remove_one, NULL, &unheard) == RMAP_OK)
        (void)rmdir(folder);
}

static bool is_folder(const char *path)
{
    struct stat info;
    return lstat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static void remove_made(const char *folder)
{
    char *model = rmap_path_format("%s/" RMAP_MODEL_MADE, folder);
    if (model && is_folder(model))
        remove_folder(model);
    remove_folder(folder);
    rmap_free(model);
}

/* One whose import was killed, as its lock shows. */
static enum rmap_status remove_left(void *context, int directory, const char *name,
                                    struct rmap_error *err)
{
    char *folder = strncmp(name, MADE, strlen(MADE)) == 0
                       ? rmap_path_format("%s/%s", *(const char *const *)context, name)
                       : NULL,
         *lock = folder ? rmap_path_format("%s/" MADE_LOCK, folder) : NULL;
    (void)directory, (void)err;
    if (lock && is_folder(folder) && rmap_file_is_left(lock))
        remove_made(folder);
    rmap_free(folder);
    rmap_free(lock);
    return RMAP_OK;
}

/* The lock has its name once it is held, so that nobody finds it free before. raymap-step has it,
 * too, and may outlive us. */
static enum rmap_status make_folder(const char *above, struct rmap_model_made *made,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const mode_t mode = S_IRUSR | S_IWUSR;
    char *folder = rmap_path_format("%s/" MADE "XXXXXX", above), *lock = NULL, *new = NULL;
    if (!folder)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
    if (!mkdtemp(folder))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no folder can be made in %s: %s", above,
                                strerror(errno)));
    *made = (struct rmap_model_made){folder, -1};
    folder = NULL;
    lock = rmap_path_format("%s/" MADE_LOCK, made->folder);
    new = rmap_path_format("%s/" MADE_LOCK ".new", made->folder);
    if (!lock || !new)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
    made->lock = open(new, O_RDWR | O_CREAT | O_EXCL, mode);
    if (made->lock >= 0)
        rmap_file_lock(made->lock);
    if (made->lock < 0 || rename(new, lock) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s cannot be made: %s", lock, strerror(errno));
out:
    rmap_free(folder);
    rmap_free(lock);
    rmap_free(new);
    return st;
}

void rmap_model_clean(struct rmap_model_made *made)
{
    if (!made->folder)
        return;
    remove_made(made->folder);
    if (made->lock >= 0)
        (void)close(made->lock);
    rmap_free(made->folder);
}

/* ---- the whole ---- */

static enum rmap_status read_step(const struct rmap_model_request *request,
                                  struct rmap_assembly *assembly, struct rmap_model_made *made,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *text = NULL;
    size_t nbytes = 0;
    char *json = NULL;
    const char *trouble = rmap_input_file_trouble(request->path);
    if (trouble)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "%s: %s", request->path, trouble));
    RMAP_TRY(make_folder(request->folder, made, err));
    RMAP_TRY(convert(request, made->folder, err));
    json = rmap_path_format("%s/" RMAP_MODEL_MADE "/assembly.json", made->folder);
    if (!json)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
    st = rmap_input_file_read(json, RMAP_ASSEMBLY_NBYTES_MAX, &text, &nbytes, err);
    if (st == RMAP_OK)
        st = rmap_assembly_read_json((const char *)text, nbytes, assembly, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s: what raymap-step wrote", request->path);
out:
    rmap_free(text);
    rmap_free(json);
    return st;
}

enum rmap_status rmap_model_read(const struct rmap_model_request *request,
                                 struct rmap_assembly *assembly, struct rmap_model_made *made,
                                 struct rmap_error *err)
{
    struct rmap_error unheard = {0};
    const char *folder = request->folder;
    rmap_diagnostics_init(&assembly->findings, request->path);
    (void)!rmap_directory_visit(request->folder, remove_left, &folder, &unheard);
    return is_step(request->path) ? read_step(request, assembly, made, err)
                                  : rmap_assembly_read_mesh(request->path, request->scale,
                                                            request->unit, assembly, err);
}
