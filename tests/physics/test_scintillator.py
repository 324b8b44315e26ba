#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The example scintillator: no ray is lost, both ends see the same light, near ones more than far ones; and without the wrapping and
absorption each end takes the share of light that all four sides and the joint's index let it have."""
import json
import math
import os
import pathlib
import shutil

import numpy as np
from raymap import Checks, count, drop, rays, run

checks = Checks()
EXAMPLE = pathlib.Path(os.environ["SOURCE_DIR"]) / "examples" / "scintillator"
BAR, AIR, GREASE = 1.58, 1.0003, 1.465


def example():
    run("trace", EXAMPLE / "scene.yaml", "-o", "bar.raymap", "-n", 9000, "--quiet", "--force")
    (wrong, right, left, near, far), total = rays("bar.raymap", "ended(error)", "registered(right)", "registered(left)",
                                                  "registered(right) and start_z > 150", "registered(right) and start_z < -150")
    checks.true(f"{wrong} rays ended in an error", wrong == 0)
    checks.true(f"{right} to the right, {left} to the left of {total}", abs(right - left) < 4 * math.sqrt(right + left))
    checks.true(f"{near} from near, {far} from far", near > 1.2 * far)
    told = json.loads(run("info", "bar.raymap", "--json"))
    size = told["bytes"] / told["segments"]
    checks.true(f"{size:.2f} bytes per segment", size <= 4)
    run("verify", "bar.raymap")
    drop("bar.raymap")


def bare():
    """Light goes along the bar where all sides reflect it totally; of that which is not trapped for ever, half leaves at each end."""
    text = (EXAMPLE / "scene.yaml").read_text("utf-8")
    shutil.copy(EXAMPLE / "muons.csv", "muons.csv")
    for old, new in (("wrap: {type: scatter, reflectance: 0.97, reflect: {model: unified, sigma_alpha: 12, spike: 0, lobe: 0.1, back: 0}}",
                      "wrap: {type: absorber}"), ("absorption: 0.26 /m", "absorption: 0"), ("{steps: 2000}", "{steps: 300}"),
                     ("[scintillation, cherenkov]", "scintillation")):
        assert old in text
        text = text.replace(old, new)
    pathlib.Path("bare.yaml").write_text(text, "utf-8")
    n = 20000
    run("trace", "bare.yaml", "-o", "bare.raymap", "-n", n, "--quiet", "--force")
    answer = count("bare.raymap", "registered(right)", "registered(left)")
    u = (np.arange(2000) + 0.5) / 2000
    z, turn = np.meshgrid(u, u)
    x, y = np.sqrt(1 - z**2) * np.cos(np.pi / 2 * turn), np.sqrt(1 - z**2) * np.sin(np.pi / 2 * turn)
    most = math.sqrt(1 - (AIR / BAR) ** 2)
    share = 0.5 * ((x < most) & (y < most) & (z > math.sqrt(1 - (GREASE / BAR) ** 2))).mean()
    for part in answer:
        seen = part["rays"]["matched"]
        z_score = (seen - share * n) / math.sqrt(n * share * (1 - share))
        checks.true(f"{part['criterion']}: {seen} of {n}, expected {share:.5f}: z = {z_score:.2f}", abs(z_score) <= 4)
    drop("bare.raymap")


example()
bare()
checks.finish()
