#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Where memory does not suffice for Embree or for one of its threads, the program says so and ends with status 5; it
neither spins for ever nor is ended by a library. A thread of Open MPI's that is late holds nothing up."""
import os
import pathlib
import resource
import subprocess
import sys

PROGRAM = os.environ["RAYMAP"]
SCENE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {sheet: {type: mesh, file: sheet.obj}}
objects: [{name: sheet, geometry: sheet, surface: black, inside: air, outside: air}]
sources: [{name: lamp, type: point, at: [0, 0, -30], direction: [0, 0, 1], distribution: {cone: 15},
           flux: 1 W, medium: air}]
simulations: [{name: short, rays: 10}]
"""
SIDE = 120  # points: so many that Embree builds with several threads
MIB = 1 << 20
failures = 0


def check(limit=None, **environment):
    """Status, or "waits", and what is said, of a check within so many bytes."""
    def bound():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if limit:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        done = subprocess.run([PROGRAM, "check", "scene.yaml", "--threads", "2"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, timeout=20, check=False, preexec_fn=bound,
                              env={**os.environ, **environment})
        return done.returncode, done.stderr.decode(errors="replace")
    except subprocess.TimeoutExpired:
        return "waits", ""


def expect(what, got, status, *words):
    global failures
    if got[0] != status or not any(word in got[1] for word in words):
        failures += 1
        print(f"FAIL {what}: {got[0]}, not {status}\n{got[1][-600:]}")


pathlib.Path("scene.yaml").write_text(SCENE)
pathlib.Path("sheet.obj").write_text(
    "".join(f"v {i} {j} {i * j % 3}\n" for i in range(SIDE) for j in range(SIDE)) +
    "".join(f"f {a} {a + 1} {a + SIDE + 1} {a + SIDE}\n" for a in range(1, SIDE * (SIDE - 1)) if a % SIDE))
FAULT = {"LD_PRELOAD": os.environ["FAULTS"], "FAULTS_DIR": os.getcwd(), "FAULTS_AT": "1", "FAULTS_ACTION": "EAGAIN"}
if len(os.sched_getaffinity(0)) > 1:
    expect("no thread", check(FAULTS_CALLS="thread:pthread_create", FAULTS_STICKY="1", **FAULT), 5, "cannot start 1 thread to help")
expect("a late thread", check(FAULTS_CALLS="thread:event_base_loop", **FAULT), 0, "")

if check(2048 * MIB)[0] != 0:
    print("limits of memory end this program: it is built with a sanitiser")
    sys.exit(failures != 0)
# The least memory that suffices, to 2 MiB; what is a little less suffices for all but Embree.
least, enough = 16, 2048
while enough - least > 2:
    middle = (least + enough) // 2
    if check(middle * MIB)[0] == 0:
        enough = middle
    else:
        least = middle
told = 0
for less in range(6, 46, 4):
    got = check((enough - less) * MIB)
    expect(f"{enough} - {less} MiB", got, 5, "memory", "thread", "Embree")
    told += "Embree" in got[1]
if not told:
    failures += 1
    print("FAIL: memory never ended in Embree: the limits are wrong")
sys.exit(failures != 0)
