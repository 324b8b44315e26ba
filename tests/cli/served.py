# SPDX-License-Identifier: MIT
"""Many questions of one map from one server, where a start of the program for each would be most of
a test: what `raymap serve` answers is what the command line answers with --json, by the same code."""
import atexit
import json
import os
import subprocess

from asking import keys_of

OPERAND = {"query": "criterion", "detector": "name", "report": "ray"}
servers = {}


def ask(command, file, *words):
    """The answer of the server that the map has: another one when the map has changed."""
    state = [os.stat(path.path).st_mtime_ns for folder, _, _ in os.walk(file) for path in os.scandir(folder)]
    if file in servers and servers[file][0] != state:
        servers.pop(file)[1].close()
    if file not in servers:
        servers[file] = state, Served(file)
    return servers[file][1].ask(command, *words)


class Served:
    def __init__(self, file):
        self.process = subprocess.Popen([os.environ["RAYMAP"], "serve", file, "--threads", "1"], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        atexit.register(self.close)

    def ask(self, command, *words):
        """The words of the command line behind the map's name: an operand, then options."""
        words, request = [str(word) for word in words], {"id": 1, "command": command}
        if words and not words[0].startswith("--"):
            request[OPERAND[command]] = words.pop(0)
        request.update(keys_of(words))
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        while True:
            answer = json.loads(self.process.stdout.readline())
            if "ok" in answer:
                assert answer["ok"], (request, answer)
                return answer["result"]

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()
