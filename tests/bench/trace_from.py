#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Processor time of `trace --from` over that of a whole trace of the new scene, in turns: trace_from.py RAYMAP [RAYS [ROUNDS]]."""
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
rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5


def traced(example, out, *more):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    told = subprocess.run([raymap, "trace", EXAMPLES / example / "scene.yaml", "-o", out, "--force", "--json", "--threads", "1", *more],
                          capture_output=True, text=True, check=True).stdout
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, json.loads(told)


with tempfile.TemporaryDirectory() as folder:
    for example in {example for example, _ in CHANGES}:
        traced(example, f"{folder}/{example}.raymap", "-n", rays)
    for example, change in CHANGES:
        ratios = []
        for _ in range(rounds):
            whole, all_anew = traced(example, f"{folder}/whole.raymap", "-n", rays, "--set", change)
            part, answer = traced(example, f"{folder}/new.raymap", "--set", change, "--from", f"{folder}/{example}.raymap")
            assert answer["digest"] == all_anew["digest"]
            ratios.append(part / whole)
        share = answer["from"]["traced"] / answer["rays"]
        middle = statistics.median(ratios)
        print(f"{example} {change}: {share:.3f} of the rays anew, time {middle:.2f} ({min(ratios):.2f} to {max(ratios):.2f}), share + {middle - share:.2f}", flush=True)
