/* SPDX-License-Identifier: MIT
 *
 * A browser, started with an address.
 */
#include "mpi/serve/serve_browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

extern char **environ;

void rmap_serve_browser(const char *url)
{
    const char *asked = getenv("BROWSER");
    const char *program = asked && *asked ? asked : "xdg-open";
    char *const argument[] = {(char *)(uintptr_t)program, (char *)(uintptr_t)url, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child;
    if (posix_spawn_file_actions_init(&actions) != 0)
        return;
    /* What it says is no answer of ours, and it must not hold our pipes open. */
    (void)posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    (void)posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    (void)posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    if (posix_spawnp(&child, program, &actions, NULL, argument, environ) != 0)
        fprintf(stderr, "raymap: %s cannot be started; open %s\n", program, url);
    (void)posix_spawn_file_actions_destroy(&actions);
}
