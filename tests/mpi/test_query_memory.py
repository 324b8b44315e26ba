#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The promise: a query takes at most 512 MiB beside its answer, whatever it asks and however many
threads it is told to use; and no more threads change the answer."""
import json
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "room", "scene.yaml")
MAP = "memory.raymap"
BOUND_KIB = 512 << 10
THREADS = (1, 48)


def run(*arguments):
    """Standard output, and the most memory that the process had, in KiB."""
    with subprocess.Popen([PROGRAM, *arguments, "--quiet"], stdout=subprocess.PIPE) as process:
        out = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, arguments
    return out, usage.ru_maxrss


def measure(name, *arguments):
    most, answers = [], set()
    for threads in THREADS:
        out, kib = run("query", MAP, *arguments, "--threads", str(threads))
        most.append(kib)
        answers.add(json.dumps(json.loads(out)["rays"]) if out else "")
    print(f"{name}: {[kib >> 10 for kib in most]} MiB with {THREADS} threads")
    assert max(most) <= BOUND_KIB, (name, most)
    assert len(answers) == 1, (name, answers)


def measure_all():
    """Every kind of question."""
    measure("count", "hit('*_wall')", "--count", "--json")
    measure("numbers", "path_length < 8 m and angle(floor_map) < 30 deg", "--count", "--json")
    measure("rays", "hit(*)", "-o", "rays.vtp", "--force")
    measure("sample", "hit(*)", "--sample", "20000", "-o", "some.csv", "--force")
    measure("map", "hit(*)", "-o", "rays.raymap", "--force")


for encoding in ("plain", "compact"):
    run("trace", SCENE, "-o", MAP, "-n", "70000", "--encoding", encoding, "--force")
    measure_all()
