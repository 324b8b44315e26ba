/* SPDX-License-Identifier: MIT */
#include "fault_plan.h"

#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <limits.h>
#include <link.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

enum action {
    ACTION_NONE,
    ACTION_ERROR,
    ACTION_KILL,
    ACTION_TEAR,
    ACTION_EXIT,
    ACTION_SHORT,
    ACTION_SIGNAL
};

/* Set once by the constructor, before any other thread is there; only the counter moves. */
static struct {
    bool ready, sticky;
    enum action action;
    int error; /* of the call, or the signal */
    unsigned long at;
    const char *directory, *path;
    size_t directory_len;
    char *calls; /* patterns, each ended by 0, one more 0 at the end */
    int log;
    uintptr_t program_begin, program_end;
    _Atomic unsigned long count;
} plan;

static const struct {
    const char *name;
    enum action action;
    int error;
} actions[] = {
    {"ENOSPC", ACTION_ERROR, ENOSPC},
    {"EAGAIN", ACTION_ERROR, EAGAIN},
    {"EIO", ACTION_ERROR, EIO},
    {"EDQUOT", ACTION_ERROR, EDQUOT},
    {"ENOMEM", ACTION_ERROR, ENOMEM},
    {"EINTR", ACTION_ERROR, EINTR},
    {"EACCES", ACTION_ERROR, EACCES},
    {"EMFILE", ACTION_ERROR, EMFILE},
    {"ENOLCK", ACTION_ERROR, ENOLCK},
    {"kill", ACTION_KILL, 0},
    {"tear", ACTION_TEAR, 0},
    {"exit", ACTION_EXIT, 0},
    {"short", ACTION_SHORT, 0},
    {"stop", ACTION_SIGNAL, SIGSTOP},
    {"SIGUSR1", ACTION_SIGNAL, SIGUSR1},
};

static _Noreturn void misuse(const char *variable, const char *value)
{
    (void)dprintf(STDERR_FILENO, "%s=%s means nothing\n", variable, value ? value : "");
    _exit(125);
}

static void read_action(const char *name)
{
    for (size_t i = 0; i < sizeof actions / sizeof actions[0]; i++) {
        if (strcmp(name, actions[i].name) == 0) {
            plan.action = actions[i].action;
            plan.error = actions[i].error;
            return;
        }
    }
    misuse("FAULTS_ACTION", name);
}

static char *split_patterns(const char *list)
{
    size_t n = strlen(list);
    char *patterns = calloc(n + 2, 1);
    if (!patterns)
        misuse("FAULTS_CALLS", list);
    memcpy(patterns, list, n);
    for (char *comma = patterns; (comma = strchr(comma, ',')) != NULL;)
        *comma++ = '\0';
    return patterns;
}

/* The program is the first object that is told of. */
static int take_program(struct dl_phdr_info *info, size_t size, void *context)
{
    (void)size;
    (void)context;
    plan.program_begin = UINTPTR_MAX;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        if (info->dlpi_phdr[i].p_type != PT_LOAD)
            continue;
        uintptr_t begin = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
        uintptr_t end = begin + info->dlpi_phdr[i].p_memsz;
        plan.program_begin = begin < plan.program_begin ? begin : plan.program_begin;
        plan.program_end = end > plan.program_end ? end : plan.program_end;
    }
    return 1;
}

static const char *rank_of_process(void)
{
    const char *rank = getenv("OMPI_COMM_WORLD_RANK");
    return rank ? rank : "0";
}

int fault_open_output(const char *variable)
{
    const char *name = getenv(variable);
    char path[PATH_MAX];
    if (!name || !getenv("FAULTS_DIR"))
        return -1;
    (void)snprintf(path, sizeof path, "%s.%s", name, rank_of_process());
    int fd =
        (int)syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (fd < 0)
        misuse(variable, path);
    return fd;
}

__attribute__((constructor)) static void read_environment(void)
{
    const char *rank = getenv("FAULTS_RANK"), *at = getenv("FAULTS_AT");
    const char *action = getenv("FAULTS_ACTION"), *calls = getenv("FAULTS_CALLS");
    const char *path = getenv("FAULTS_PATH"), *sticky = getenv("FAULTS_STICKY");
    plan.directory = getenv("FAULTS_DIR");
    if (!plan.directory)
        return;
    if (plan.directory[0] != '/')
        misuse("FAULTS_DIR", plan.directory);
    plan.directory_len = strlen(plan.directory);
    plan.at = at ? strtoul(at, NULL, 10) : 0;
    if (action)
        read_action(action);
    else if (plan.at)
        misuse("FAULTS_ACTION", action);
    if (rank && strcmp(rank, rank_of_process()) != 0)
        plan.at = 0;
    plan.calls = split_patterns(calls ? calls : "*");
    plan.path = path ? path : "*";
    plan.sticky = sticky && strcmp(sticky, "1") == 0;
    plan.log = fault_open_output("FAULTS_LOG");
    (void)dl_iterate_phdr(take_program, NULL);
    plan.ready = true;
}

bool fault_in_program(const void *address)
{
    return (uintptr_t)address >= plan.program_begin && (uintptr_t)address < plan.program_end;
}

bool fault_watches(const char *path)
{
    char joined[2 * FAULT_PATH_CAP];
    if (!plan.ready || !path)
        return false;
    if (path[0] != '/') {
        char here[FAULT_PATH_CAP];
        if (!getcwd(here, sizeof here))
            return false;
        (void)snprintf(joined, sizeof joined, "%s/%s", here, path);
        path = joined;
    }
    return strncmp(path, plan.directory, plan.directory_len) == 0 &&
           (path[plan.directory_len] == '/' || path[plan.directory_len] == '\0');
}

bool fault_watches_file(int fd, char *path)
{
    char link[64];
    int error = errno;
    if (!plan.ready)
        return false;
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    long n = syscall(SYS_readlink, link, path, (size_t)FAULT_PATH_CAP - 1);
    path[n < 0 ? 0 : n] = '\0';
    errno = error;
    return path[0] == '/' && fault_watches(path); /* sockets and pipes have names of their own */
}

/* Patterns without a colon are of calls that change files: "*" takes no reads and no memory, and
 * HDF5's functions only by name. */
static bool counts(const char *call, const char *path)
{
    bool special = strchr(call, ':') || strncmp(call, "H5", 2) == 0;
    for (const char *pattern = plan.calls; *pattern; pattern += strlen(pattern) + 1)
        if (fnmatch(pattern, call, 0) == 0 && !(special && pattern[0] == '*'))
            return fnmatch(plan.path, path, 0) == 0;
    return false;
}

static void write_log(unsigned long number, const char *call, const char *path)
{
    char line[FAULT_PATH_CAP + 100];
    int n = snprintf(line, sizeof line, "%lu %s %s\n", number, call, path);
    if (n > 0)
        (void)syscall(SYS_write, plan.log, line, (size_t)n);
}

_Noreturn void fault_die(void)
{
    (void)kill(getpid(), SIGKILL);
    for (;;)
        (void)pause();
}

static bool moves_bytes(const char *call)
{
    static const char *const calls[] = {"write", "pwrite", "read:read", "read:pread"};
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++)
        if (strcmp(call, calls[i]) == 0)
            return true;
    return false;
}

enum fault_outcome fault_decide(const char *call, const char *path)
{
    int error = errno;
    if (!plan.ready || !counts(call, path))
        return FAULT_NONE;
    unsigned long number = atomic_fetch_add(&plan.count, 1) + 1;
    if (plan.log >= 0)
        write_log(number, call, path);
    errno = error;
    if (plan.at == 0 || number < plan.at || (number > plan.at && !plan.sticky))
        return FAULT_NONE;
    switch (plan.action) {
    case ACTION_KILL:
        fault_die();
    case ACTION_EXIT:
        _exit(99);
    case ACTION_SIGNAL:
        (void)kill(getpid(), plan.error);
        break;
    case ACTION_TEAR:
        if (!moves_bytes(call))
            fault_die();
        return FAULT_TEAR;
    case ACTION_SHORT:
        return moves_bytes(call) ? FAULT_SHORT : FAULT_NONE;
    case ACTION_ERROR:
        errno = plan.error;
        return FAULT_ERROR;
    case ACTION_NONE:
        break;
    }
    return FAULT_NONE;
}
