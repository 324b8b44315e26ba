#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How long questions of a large map take: large_map.py RAYMAP [RAYS [FOLDER]]

Traces the double Gauss (61 million rays: 450 million segments), unless the folder has the map already, and asks each
question three times on two threads: processor time of the whole command, time by the clock, memory; medians.
"""
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import time

REGION = "registered(sensor, rect(-6.1, -4.1, 6.1, 4.1)"
QUESTIONS = (
    ("info",),
    ("query", "source(star) and hit('lens.*', reflect_specular) >= 2 and bounces > 12", "--count"),
    ("query", "not hit(cover.*)", "--count"),
    ("query", "path(\"T@lens.1 .* R@'lens.*' .* R@'lens.*' .* V@sensor .*\")", "--count"),
    ("query", f"{REGION})", "--count"),
    ("query", f"source(sun) and {REGION})", "--count"),
    ("query", f"{REGION} where angle < 12 deg)", "--count"),
    ("detector", "sensor", "--where", "source(star)", "--cells", "400x400"),
    ("query", "source(sun) and bounces > 14", "-o", "part.raymap", "--force"),
    ("stats", "--of", "path_length"),
)
REPEATS = 3


def asked(program, target, command, *words):
    """Processor time and time by the clock in seconds, MiB."""
    words = (command, target, *words, "--json", *(() if command == "info" else ("--threads", "2")))
    begin = time.perf_counter()
    child = subprocess.Popen([program, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=target.parent)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0, words
    return used.ru_utime + used.ru_stime, time.perf_counter() - begin, used.ru_maxrss / 1024


def main(program, n_ray="61e6", folder="large-map"):
    scene = pathlib.Path(__file__).resolve().parents[2] / "examples/double-gauss/scene.yaml"
    program, target = pathlib.Path(program).resolve(), pathlib.Path(folder).resolve() / "large.raymap"
    target.parent.mkdir(exist_ok=True)
    if not target.exists():
        subprocess.run([program, "trace", scene, "-o", target, "-n", n_ray, "--quiet"], check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"traced in {used.ru_utime + used.ru_stime:.0f} s of processor time")
    for question in QUESTIONS:
        asked(program, target, *question)  # brings the map into the page cache
        rounds = [asked(program, target, *question) for _ in range(REPEATS)]
        processor, clock, memory = (statistics.median(values) for values in zip(*rounds))
        print(f"{processor:8.2f} s {clock:8.2f} s {memory:6.0f} MiB  {' '.join(question)}", flush=True)


if len(sys.argv) < 2:
    sys.exit(__doc__)
main(*sys.argv[1:4])
