#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: numbers from a part of the rays, or from a trace that lost rays to errors, are never given without a word."""
import json
import os
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from sealed_map import edit  # noqa: E402

PROGRAM, SOURCE = os.environ["RAYMAP"], os.environ["SOURCE_DIR"]
GAUSS = os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml")


def call(*arguments, status=0, ranks=1, text=None):
    command = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*command, PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False,
                          input=text)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done


def check_every_answer(file, complete, asked, traced):
    """Each JSON about the map says it, and stderr does where it is not complete, quiet or not."""
    for arguments in (["query", file, "all"], ["query", file, "all", "hit(*)"], ["query", file, "all", "--explain"],
                      ["detector", file, "sensor"], ["stats", file, "--of", "bounces"], ["paths", file, "--top", 3],
                      ["report", file, "--energy"], ["compare", file, file], ["info", file],
                      ["query", file, "ray < 9", "-o", "some.csv", "--force"],
                      ["query", file, "ray < 9", "-o", "picked.raymap", "--force"], ["report", file, 0],
                      ["report", file, "--html", "-o", "some.html", "--force"], ["index", file], ["verify", file],
                      ["convert", file, "-o", "other.raymap", "--encoding", "plain", "--force"],
                      ["draw", file, "-o", "some.svg", "--limit", 9, "--force"], ["session", file]):
        done = call(*arguments, "--json", "--quiet",
                    text="list 1 all\nall\nstatus\nnames\n" if arguments[0] == "session" else None)
        documents = [json.loads(line) for line in done.stdout.splitlines()] if arguments[0] == "session" else json.loads(done.stdout)
        parts = documents if isinstance(documents, list) else documents.get("samples", [documents])
        for part in parts:
            said = part["complete"], part["rays_asked"], part["rays_traced"]
            assert said == (complete, asked, traced), (arguments, said)
        lines = [line for line in done.stderr.splitlines() if "is not complete" in line]
        opened = 0 if complete or arguments[0] in ("info", "verify") else 2 if arguments[0] == "compare" else 1
        assert len(lines) == opened, (arguments, done.stderr)
        assert all(f"holds {traced:,} rays of {asked:,}" in line for line in lines), lines


call("trace", GAUSS, "-o", "whole.raymap", "-n", 3000, "--force", "--quiet")
check_every_answer("whole.raymap", True, 3000, 3000)
for limit in ("0.2s", "1s", "5s"):  # a busy machine may not get to any ray in the first
    told = json.loads(call("trace", GAUSS, "-o", "part.raymap", "-n", 10**9, "--time-limit", limit, "--force", "--json", status=6).stdout)
    held = json.loads(call("info", "part.raymap", "--json").stdout)["rays"]
    if held >= 100:
        break
check_every_answer("part.raymap", False, 10**9, held)
assert (told["complete"], told["rays_asked"], told["rays_traced"]) == (False, 10**9, held), told
call("trace", GAUSS, "-o", "next.raymap", "-n", 1000, "--first-ray", 10**9, "--force", "--quiet")
merged = json.loads(call("merge", "part.raymap", "next.raymap", "-o", "both.raymap", "--force", "--json").stdout)
assert (merged["complete"], merged["rays_asked"], merged["rays_traced"]) == (False, 10**9 + 1000, held + 1000), merged
assert "asked for: 1,000,000,000 rays" in call("info", "part.raymap").stdout
edit("whole.raymap/map.h5", lambda file: file.attrs.__setitem__("complete", np.int32(0)))  # as before a trace's end
assert "holds 3,000 rays of 3,000, and its trace has not ended" in call("query", "whole.raymap", "all").stderr
call("query", "part.raymap", "ray < 100", "-o", "picked.raymap", "--force", "--quiet")
picked = json.loads(call("query", "picked.raymap", "all", "--json").stdout)
assert (picked["complete"], picked["rays_asked"], picked["rays_traced"]) == (False, None, 100), picked
assert "warnings that they are not of all rays" in " ".join(call("query", "--help").stdout.split())

# Rays that end in an error: 7 from 0.1 % on, of the whole map, also where nothing is left to trace.
SCENE = """raymap: 1
units: mm
media: {air: {index: 1}, glass: {index: 1.5}}
geometries: {wall: {type: rectangle, size: [10, 10]}}
objects: [{name: screen, geometry: wall, at: [0, 0, 50], surface: absorber, front: glass, back: glass}]
sources:
  - {name: bad, type: collimated, at: [0, 0, 0], direction: [0, 0, 1], shape: {disc: 1}, flux: 1 W, rays_share: %d, medium: air}
  - {name: good, type: collimated, at: [0, 0, 60], direction: [0, 0, 1], shape: {disc: 1}, flux: 1 W, rays_share: %d, medium: air}
"""
for bad, good, status in ((1, 999, 0), (2, 998, 7)):
    with open("errors.yaml", "w", encoding="utf-8") as scene:
        scene.write(SCENE % (bad, good))
    told = call("trace", "errors.yaml", "-o", "errors.raymap", "-n", 10000, "--force", status=status, ranks=2).stderr
    assert ("0.2 % of the rays ended in an error" in told) == (status == 7), told
    call("verify", "errors.raymap")
    assert json.loads(call("info", "errors.raymap", "--json").stdout)["complete"]
    call("trace", "errors.yaml", "-o", "errors.raymap", "--resume", status=status)
assert call("trace", "errors.yaml", "-o", "errors.raymap", "-n", 10**9, "--time-limit", "0.2s", "--force", status=6)
