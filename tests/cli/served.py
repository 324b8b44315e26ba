# SPDX-License-Identifier: MIT
"""Many questions of one map from one server, where a start of the program for each would be most of
a test: what `raymap serve` answers is what the command line answers with --json, by the same code."""
import atexit
import os

from asking import keys_of
import raymap.serve  # asking knows where it is

OPERAND = {"query": "criterion", "detector": "name", "report": "ray"}
servers = {}


def ask(command, file, *words):
    """The words of the command line behind the map's name: an operand, then options. Of another server when the map has changed."""
    state = [os.stat(path.path).st_mtime_ns for folder, _, _ in os.walk(file) for path in os.scandir(folder)]
    if file in servers and servers[file][0] != state:
        servers.pop(file)[1].close()
    if file not in servers:
        servers[file] = state, raymap.serve.start(file)
        atexit.register(servers[file][1].close)
    operand = {OPERAND[command]: words[0]} if words and not str(words[0]).startswith("--") else {}
    return servers[file][1].ask(command, **operand, **keys_of(words[len(operand):]))
