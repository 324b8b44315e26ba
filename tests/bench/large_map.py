#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How long counting takes in a large map: large_map.py RAYMAP [RAYS [FOLDER]]

Traces the double Gauss (61 million rays: 450 million segments) into a compact map, unless the
folder has it already, and asks each question five times on two threads.
"""
import json
import pathlib
import statistics
import subprocess
import sys

QUESTIONS = (
    "source(star) and hit('lens.*', reflect_specular) >= 2 and bounces > 12",
    "not hit(cover.*)",
    "registered(sensor) and source(sun)",
    "path(\"T@lens.1 .* R@'lens.*' .* R@'lens.*' .* V@sensor .*\")",
    "registered(sensor, rect(-6.1, -4.1, 6.1, 4.1) where angle < 12 deg)",
)
REPEATS = 5


def main(program, n_ray="61e6", folder="large-map"):
    scene = pathlib.Path(__file__).resolve().parents[2] / "examples/double-gauss/scene.yaml"
    target = pathlib.Path(folder) / "large.raymap"
    target.parent.mkdir(exist_ok=True)
    if not target.exists():
        subprocess.run([program, "trace", scene, "-o", target, "-n", n_ray, "--encoding", "compact",
                        "--quiet"], check=True)
    for question in QUESTIONS:
        seconds = []
        for _ in range(REPEATS + 1):
            done = subprocess.run([program, "query", target, question, "--count", "--json",
                                   "--threads", "2"], check=True, capture_output=True)
            answer = json.loads(done.stdout)
            seconds.append(answer["seconds"])
        middle = statistics.median(seconds[1:])  # the first brings the map into the page cache
        n_segment = answer["segments"]["total"]
        print(f"{question}\n  {answer['rays']['matched']} rays; {n_segment} segments in "
              f"{middle:.3f} s ({min(seconds[1:]):.3f} to {max(seconds[1:]):.3f}), "
              f"{1e-6 * n_segment / middle:.0f} million segments/s, "
              f"{1e-6 * answer['bytes_read']:.1f} MB read")


if len(sys.argv) < 2:
    sys.exit(__doc__)
main(*sys.argv[1:4])
