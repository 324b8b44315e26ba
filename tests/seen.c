// SPDX-License-Identifier: MIT
/* The program as most tests know it. What it prints with --json is kept in $JSON_SEEN too, with its
 * arguments, for cli.test_schemas to validate. Not under mpirun, which ends the others with the
 * first that leaves. As a script it would take a tenth of what the program takes to start, and a
 * third with --json. */
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* The exit status as a shell tells it, with standard output in the file fd. */
static int run(char *const argv[], int fd)
{
    posix_spawn_file_actions_t actions;
    int status = 0;
    pid_t pid = 0;
    if (posix_spawn_file_actions_init(&actions) != 0 ||
        posix_spawn_file_actions_adddup2(&actions, fd, STDOUT_FILENO) != 0 ||
        posix_spawn(&pid, argv[0], &actions, NULL, argv, environ) != 0 ||
        waitpid(pid, &status, 0) != pid)
        return 127;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static bool pass_on(int fd)
{
    char bytes[1 << 16];
    ssize_t n = 0;
    if (lseek(fd, 0, SEEK_SET) != 0)
        return false;
    while ((n = read(fd, bytes, sizeof bytes)) > 0)
        for (ssize_t at = 0, more = 0; at < n; at += more)
            if ((more = write(STDOUT_FILENO, bytes + at, (size_t)(n - at))) < 0)
                return false;
    return n == 0;
}

int main(int argc, char **argv)
{
    const char *folder = getenv("JSON_SEEN");
    char name[4096], words[sizeof name + 6];
    bool json = false;
    for (int i = 1; i < argc; i++)
        json = json || strcmp(argv[i], "--json") == 0;
    argv[0] = getenv("RAYMAP_PROGRAM");
    if (!argv[0] || !folder)
        return 127;
    if (!json || strcmp(argv[1], "session") == 0 || getenv("OMPI_COMM_WORLD_RANK")) {
        (void)execv(argv[0], argv);
        return 127;
    }
    (void)mkdir(folder, 0777);
    (void)snprintf(name, sizeof name, "%s/XXXXXX", folder);
    int fd = mkstemp(name);
    if (fd < 0)
        return 127;
    int status = run(argv, fd);
    if (!pass_on(fd))
        status = status ? status : 127;
    (void)snprintf(words, sizeof words, "%s.words", name);
    FILE *file = status == 0 ? fopen(words, "w") : NULL;
    if (!file)
        return unlink(name), status;
    for (int i = 1; i < argc; i++)
        fprintf(file, "%s\n", argv[i]);
    return fclose(file) == 0 ? status : 127;
}
