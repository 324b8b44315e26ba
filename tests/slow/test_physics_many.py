#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests with 25 times the rays, or poses, and with all cases of their matrices: Monte Carlo cases have at least the 10^7 rays that the CIE
cases ask for, and errors a fifth as large."""
import os
import pathlib
import subprocess
import sys

tests = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests"
failed = []
for name in ("physics/fresnel", "physics/lambert", "physics/media", "physics/radiometry", "physics/scatter", "physics/curved_poses",
             "physics/lamps", "physics/published", "physics/model_surfaces", "physics/render", "physics/irradiance",
             "cad/converter", "cad/mutations", "cli/tutorials", "cli/install", "cli/build"):
    label, name = name.split("/")
    script, = (tests / label).glob(f"test_{name}.*")
    how = ["bash"] if script.suffix == ".sh" else [sys.executable, "-B"]
    done = subprocess.run([*how, script], check=False, env=dict(os.environ, RAYMAP_TEST_SCALE="25"))
    print(f"{label}/{name}: status {done.returncode}", flush=True)
    if done.returncode != 0:
        failed.append(name)
sys.exit(1 if failed else 0)
