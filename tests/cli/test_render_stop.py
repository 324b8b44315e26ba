#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap render` ends soon after SIGTERM, even where one tile takes long."""
import os
import signal
import subprocess
import time

PROGRAM = os.environ["RAYMAP"]

# Light on its way through milk: a tile takes seconds, and several lie ready.
SCENE = """
raymap: 1
units: mm
limits: {steps: 1000000}
spectrum: {mode: rgb}
media:
  air: {index: 1}
  milk: {index: 1.3, scattering: 300}
surfaces: {bare: {type: fresnel}}
geometries: {ball: {type: sphere, radius: 20}}
objects: [{name: ball, geometry: ball, surface: bare, inside: milk, outside: air}]
sources: [{name: lamp, type: point, at: [0, 0, 100], flux: 100 lm, medium: air}]
cameras:
  - {name: front, at: [0, -50, 10], look_at: [0, 0, 0], resolution: [128, 128]}
"""


def main():
    with open("scene.yaml", "w", encoding="utf-8") as file:
        file.write(SCENE)
    with subprocess.Popen([PROGRAM, "render", "scene.yaml", "-n", "1024", "--threads", "2", "-o",
                           "a.png", "--force", "--quiet"], stderr=subprocess.PIPE) as child:
        time.sleep(2)
        assert child.poll() is None
        begun = time.monotonic()
        child.send_signal(signal.SIGTERM)
        told = child.stderr.read().decode()
        assert child.wait() == 6, told
        seconds = time.monotonic() - begun
    assert "stopped by SIGTERM" in told, told
    assert seconds < 4, f"{seconds:.1f} s"  # 2 s, and what other programs take of the machine


if __name__ == "__main__":
    main()
