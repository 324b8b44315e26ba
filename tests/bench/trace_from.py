#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Processor time of `trace --from` over that of a whole trace of the new scene, in turns, a table: trace_from.py RAYMAP [RAYS [ROUNDS]]."""
import json
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
CHANGES = (("double-gauss", "objects.back_wall.at=[0,0,142.9]"), ("double-gauss", "objects.cover.at=[0,0,137.3]"),
           ("double-gauss", "geometries.gauss.surfaces.11.curvature=-0.0126"), ("room", "objects.ball_1.at=[-2.1,-1.8,0.331]"),
           ("room", "objects.bench_0.at=[-1.5,0.1,0.001]"))
raymap = sys.argv[1]
rays = sys.argv[2] if len(sys.argv) > 2 else "1000000"
rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 3


def traced(example, out, *more):
    """User and system time, and what it says."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = subprocess.run([raymap, "trace", EXAMPLES / example / "scene.yaml", "-o", out, "--force", "--json", "--threads", "1", *more],
                          capture_output=True, text=True, check=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, json.loads(told)


print(f"{'scene':13}{'change':49}{'anew':>7}{'whole':>8}{'from':>8}{'ratio':>7}  {'(least, most)':16}ratio - anew")
with tempfile.TemporaryDirectory() as folder:
    for example in dict(CHANGES):
        traced(example, f"{folder}/{example}.raymap", "-n", rays)
    for example, change in CHANGES:
        seconds = []
        for _ in range(rounds):
            whole, all_anew = traced(example, f"{folder}/whole.raymap", "-n", rays, "--set", change)
            part, answer = traced(example, f"{folder}/new.raymap", "--set", change, "--from", f"{folder}/{example}.raymap")
            assert answer["digest"] == all_anew["digest"]
            seconds.append((whole, part))
        share = answer["from"]["traced"] / answer["rays"]
        ratios = [part / whole for whole, part in seconds]
        whole, part = (statistics.median(those) for those in zip(*seconds))
        print(f"{example:13}{change:49}{share:7.3f}{whole:7.2f}s{part:7.2f}s{statistics.median(ratios):7.2f}  "
              f"({min(ratios):.2f}, {max(ratios):.2f})    {statistics.median(ratios) - share:6.2f}", flush=True)
