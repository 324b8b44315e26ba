#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: paths of one text are one automaton for all criteria of a file, and all of a file are bounded together."""
import json
import os
import subprocess

PROGRAM = os.environ.get("RAYMAP_PROGRAM", os.environ["RAYMAP"])
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")


def query(definitions):
    """Status, answer, what is said, and the most memory in MB."""
    with open("paths.txt", "w", encoding="utf-8") as file:
        file.writelines(f"let a{i} = {text}\n" for i, text in enumerate(definitions))
    with open("out.json", "wb") as out, open("err.txt", "wb") as err:
        child = subprocess.Popen([PROGRAM, "query", "a.raymap", "--criteria", "paths.txt", "--json", "--threads", "1"], stdout=out,
                                 stderr=err)
        status, usage = os.wait4(child.pid, 0)[1:]
    with open("err.txt", encoding="utf-8") as err:
        return os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1024, err.read()


subprocess.run([PROGRAM, "trace", SCENE, "-o", "a.raymap", "-n", "100", "--force", "--quiet"], check=True)
HEAVY = 'path(".*R.{12}") and ray >= %d'
one = query([HEAVY % 0])
assert one[0] == 0, one
many = query([HEAVY % i for i in range(1000)])
assert many[0] == 0, many
with open("out.json", encoding="utf-8") as out:
    matched = [answer["rays"]["matched"] for answer in json.load(out)]
assert len(matched) == 1000 and matched[0] == max(matched) and matched[-1] == 0
print(f"one {one[1]:.0f} MB, a thousand of one path {many[1]:.0f} MB")
assert many[1] - one[1] < 60
other = query([f'path("T{{{i}}}.*R.{{12}}")' for i in range(1000)])
print(f"others {other[1]:.0f} MB")
assert other[0] == 3 and "of all criteria are too complex together" in other[2] and other[1] - one[1] < 200, other
assert query([f'path("T{{{i}}} .*")' for i in range(300)])[0] == 0
