/* SPDX-License-Identifier: MIT
 *
 * raymap open: a scene or map in the browser.
 */
#include "mpi/command/argument_numbers.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/serve_run.h"

static const struct rmap_option options[] = {
    {"no-browser", 0, NULL, "print the address, and start no browser"}, RMAP_CACHE_OPTION, {NULL}};

static enum rmap_status run_open(const struct rmap_context *context,
                                 const struct rmap_arguments *given, struct rmap_error *err)
{
    const struct rmap_serve_ways ways = {.http = true,
                                         .browser = rmap_argument(given, "no-browser") == NULL};
    return rmap_serve_run(context, given->operand[0], &ways, err);
}

const struct rmap_command rmap_command_open = {
    .name = "open",
    .summary = "look at a scene or ray map in the browser, ask it and change it",
    .operands = "SCENE|MAP [--no-browser]",
    .help = "Starts the server of `raymap serve --http` and a browser ($BROWSER, or xdg-open) with "
            "its\n"
            "page, the workbench. Nobody but who has the address can talk to it. Ends with Ctrl-C.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .stops_in_order = true,
    .run = run_open,
};
