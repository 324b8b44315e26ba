/* SPDX-License-Identifier: MIT
 *
 * raymap serve: a scene or map stays in memory, and programs ask.
 */
#include <string.h>

#include "mpi/command/argument_numbers.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/serve_run.h"

static const struct rmap_option options[] = {
    {"stdin", 0, NULL, "requests from standard input, a line each (where no other way is given)"},
    {"socket", 0, "PATH", "requests of who connects to this Unix socket, which is made"},
    {"http", 0, NULL, "requests by HTTP on the loopback address, for who has the token"},
    {"port", 0, "N", "of --http (default: a free one)", .goes_with = "http"},
    RMAP_CACHE_OPTION,
    {NULL}};

static enum rmap_status run_serve(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_serve_ways ways = {.socket = rmap_argument(given, "socket"),
                                   .http = rmap_argument(given, "http") != NULL};
    uint64_t port = 0;
    enum rmap_status st = rmap_argument_count(given, "port", &port, err);
    if (st == RMAP_OK && port > UINT16_MAX)
        st = rmap_error_set(err, RMAP_USAGE, "--port is at most %d", UINT16_MAX);
    ways.port = (uint16_t)port;
    ways.lines = rmap_argument(given, "stdin") || (!ways.http && !ways.socket);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_serve_run(context, given->operand[0], &ways, err);
out:
    return st;
}

const struct rmap_command rmap_command_serve = {
    .name = "serve",
    .summary = "keep a scene or ray map in memory and answer other programs",
    .operands = "SCENE|MAP [--socket PATH] [--http [--port N]] [--stdin]",
    .help =
        "A request is one JSON object on a line, {\"id\": 1, \"command\": \"query\", "
        "\"criterion\": ...},\n"
        "its answer one, too: {\"id\": 1, \"ok\": true, \"result\": ...}. Commands: status scene "
        "names\n"
        "load edit undo redo save check trace query sample report detector stats paths ghosts\n"
        "draw model render cancel watch quit. A trace goes on while others ask; several clients\n"
        "are answered in turn. The first line on standard output tells the socket, the address\n"
        "and the token. docs/server.md describes all of it.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .stops_in_order = true,
    .run = run_serve,
};
