#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests of physics with 25 times the rays, or poses, and with all cases of their matrices: Monte Carlo cases have at least the 10^7 rays
that the CIE cases ask for, and errors a fifth as large."""
import os
import pathlib
import subprocess
import sys

tests = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "physics"
failed = []
for name in ("fresnel", "lambert", "media", "radiometry", "scatter", "curved_poses", "lamps", "published", "model_surfaces", "render",
             "irradiance"):
    done = subprocess.run([sys.executable, "-B", tests / f"test_{name}.py"], check=False, env=dict(os.environ, RAYMAP_TEST_SCALE="25"))
    print(f"{name}: status {done.returncode}", flush=True)
    if done.returncode != 0:
        failed.append(name)
sys.exit(1 if failed else 0)
