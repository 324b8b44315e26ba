#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Indices of the user's own: as a formula and as a plug-in. A Luneburg lens written as a formula brings
every ray of a beam to the point opposite; the example plug-in is traced as the same index as a formula
is."""
import json
import math
import os
import shutil

from raymap import Checks, report, run

checks = Checks()
HEIGHTS, AZIMUTH = (0.1, 0.3, 0.5, 0.7, 0.9), 0.7
LENS = """raymap: 1
units: mm
media:
  air: {{index: 1}}
  m: {{gradient: {{type: formula, formula: 'sqrt(2 - r^2)', tolerance: 1.0e-9{slope}}}}}
surfaces:
  bare: {{type: fresnel, coat: ideal}}
geometries:
  ball: {{type: sphere, radius: 1}}
objects:
  - {{name: ball, geometry: ball, surface: bare, outside: air, inside: m}}
sources:
  - name: probes
    type: rays
    rays: [{rays}]
"""
EXAMPLE = os.path.join(os.environ["SOURCE_DIR"], "examples", "plugin", "scene.yaml")


def check_formula():
    """With differences for a gradient, and with its own."""
    beam = ", ".join(f"{{origin: [{h * math.cos(AZIMUTH)}, {h * math.sin(AZIMUTH)}, -2], "
                     "direction: [0, 0, 1], wavelength: 587.56}" for h in HEIGHTS)
    for slope, most in (("", 1e-7), (", slope: [-x/sqrt(2-r^2), -y/sqrt(2-r^2), -z/sqrt(2-r^2)]", 1e-8)):
        text = LENS.format(slope=slope, rays=beam)
        off = max(math.dist(report("formula", text, k)["steps"][1]["position"], (0, 0, 1))
                  for k in range(len(HEIGHTS)))
        checks.true(f"a formula{' with slopes' if slope else ''} ends {off:.1e} from the focus", off < most)


def check_plugin():
    os.environ["RAYMAP_ALLOW_PLUGINS"] = os.getcwd()
    shutil.copy(os.path.join(os.environ["PLUGIN_DIR"], "rod.so"), "rod.so")
    with open(EXAMPLE, encoding="utf-8") as file:
        plugin = file.read()
    formula = plugin.replace("type: plugin, file: rod.so, parameters: [1.6, 0.3, 20]",
                             "type: formula, formula: '1.6*sqrt(1-0.09/(1+z/20)*rho^2)'")
    checks.true("the example names its plug-in as expected", formula != plugin)
    for ray in range(4):
        ends = [report(name, text, ray)["steps"][1]["position"]
                for name, text in (("plugin", plugin), ("formula", formula))]
        checks.true(f"ray {ray}: {ends[0]} as {ends[1]}", math.dist(*ends) < 1e-6 and ends[0][2] > 39.9)
    shutil.rmtree("plugin.raymap", ignore_errors=True)
    balance = json.loads(run("trace", "plugin.yaml", "-o", "plugin.raymap", "-n", 2000, "--json", "--quiet"))
    found = json.loads(run("query", "plugin.raymap", "ended(error) or ended(limit)", "--count", "--json"))
    checks.true(f"no ray of the example ends badly: {balance}", found["rays"]["matched"] == 0)
    shutil.rmtree("plugin.raymap")


check_formula()
check_plugin()
checks.finish()
