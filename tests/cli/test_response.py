#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: what a detector registers counts by its response, as a weight or by chance, which agree; V(lambda) of 555 nm is 683 lm/W; detected(NAME) is
the same for any ranks and both encodings."""
import json
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]
TABLE = "response: {wavelength: [300, 600], value: [0.1, 0.3]}"
SCENE = """raymap: 1
units: mm
spectrum: {{mode: {mode}, wavelengths: [300, 450, 555, 600]}}
media: {{air: {{index: 1}}}}
sources:
  - {{name: lines, type: point, distribution: {{cone: 30}}, flux: 2 {unit}, medium: air, spectrum: {{lines: {{300: 1, 450: 1, 600: 2}}}}}}
  - {{name: green, type: point, distribution: {{cone: 30}}, flux: 1 {unit}, medium: air, {green}}}
detectors:
  - {{name: pmt, type: plane, at: [0, 0, 10], size: 20, cells: 2, {table}, detect: weight}}
  - {{name: plain, type: plane, at: [0, 0, 10.5], size: 20, cells: 2}}
  - {{name: counter, type: plane, at: [0, 0, 11], size: 20, cells: 2, {table}, detect: chance}}
  - {{name: eye, type: plane, at: [0, 0, 12], size: 20, cells: 2, response: V}}
  - {{name: grid, type: intensity, cells: [2, 1], response: {{angle: [0, 10, 40], value: [1, 1, 0]}}}}
  - {{name: both, type: plane, at: [0, 0, 13], size: 30, cells: 1,
     response: {{angle: [0, 90], wavelength: [300, 600], value: [[0.1, 0.3], [0.1, 0.3]]}}}}
"""
GREEN = "spectrum: {lines: {555: 1}}"
RECEIVERS = "detectors: [{name: late, type: plane, at: [0, 0, 10], size: 20, cells: 2, %s}]\n" % TABLE


def run(*arguments, status=0, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done


def write(name, text):
    with open(name, "w", encoding="utf-8") as out:
        out.write(text)


def scene(name, mode="spectral", unit="W", green=GREEN, table=TABLE):
    write(name, SCENE.format(mode=mode, unit=unit, green=green, table=table))


def ask(*arguments, ranks=1):
    return json.loads(run(*arguments, "--json", "--quiet", ranks=ranks).stdout)


def near(value, wanted, share=2e-5):
    assert abs(value - wanted) <= share * abs(wanted), (value, wanted)


scene("a.yaml")
run("trace", "a.yaml", "-o", "a.raymap", "-n", 40000, "--force", "--quiet")
run("trace", "a.yaml", "-o", "plain.raymap", "-n", 40000, "--force", "--quiet", "--encoding", "plain")
run("verify", "a.raymap", "--quiet")

# by weight: 300, 450 and 600 nm are a quarter, a quarter and a half of 2 W; 555 nm is 1 W
weight = ask("detector", "a.raymap", "pmt")
near(weight["flux"]["total"], 2 * (0.25 * 0.1 + 0.25 * 0.2 + 0.5 * 0.3) + 0.27)
assert weight["registrations"] == 40000
near(ask("detector", "a.raymap", "plain")["flux"]["total"], 3)
near(ask("detector", "a.raymap", "both")["flux"]["total"], weight["flux"]["total"])
cube = ask("detector", "a.raymap", "pmt", "--quantity", "spectral")
near(cube["flux"]["total"], weight["flux"]["total"])
for line, wanted in zip(cube["spectrum"], [0.05, 0.1, 0.27, 0.3]):
    near(line["flux"], wanted, 1e-4)
near(ask("stats", "a.raymap", "--of", "angle(pmt)")["flux"]["value"], weight["flux"]["total"])

# by chance: the same within its error, and the same for everybody
chance = ask("detector", "a.raymap", "counter")
z = (chance["flux"]["total"] - weight["flux"]["total"]) / chance["flux"]["standard_error"]
assert abs(z) <= 4, z
found = ask("query", "a.raymap", "--where", "detected(counter)")
near(found["flux"]["matched"], chance["flux"]["total"], 1e-9)
words = [found["rays"]]
for ranks in (2, 3, 4):
    words.append(ask("query", "a.raymap", "--where", "detected(counter)", ranks=ranks)["rays"])
words.append(ask("query", "plain.raymap", "--where", "detected(counter)")["rays"])
assert all(word == words[0] for word in words), words
part = ask("query", "a.raymap", "--where", "detected(counter where angle < 10)")
assert part["rays"] == ask("query", "a.raymap", "--where", "detected(counter) and angle(counter) < 10")["rays"]
assert ask("query", "a.raymap", "--where", "detected(counter) and not registered(counter)")["rays"]["matched"] == 0
near(ask("stats", "a.raymap", "--of", "angle(counter)")["flux"]["value"], chance["flux"]["total"], 1e-9)
assert "detects by chance" in run("query", "a.raymap", "--where", "detected(plain)", status=3).stderr

# a receiver of the same response over the finished map
write("late.yaml", RECEIVERS)
near(ask("detector", "a.raymap", "late", "--receivers", "late.yaml")["flux"]["total"], weight["flux"]["total"], 1e-9)

# lm by V(lambda): as --quantity illuminance has it; of 555 nm 683 lm/W
near(ask("detector", "a.raymap", "eye", "--where", "source(green)")["flux"]["total"], 683)
eye = ask("detector", "a.raymap", "eye")
assert eye["flux"]["unit"] == "lm" and eye["unit"] == "lx"
near(eye["flux"]["total"], ask("detector", "a.raymap", "plain", "--quantity", "illuminance")["flux"]["total"], 1e-6)

# sources in lm have V(lambda) already; of red, green and blue the luminance of what is left of a source's light
scene("lm.yaml", unit="lm")
run("trace", "lm.yaml", "-o", "lm.raymap", "-n", 4000, "--force", "--quiet")
near(ask("detector", "lm.raymap", "eye")["flux"]["total"], 3)
scene("rgb.yaml", unit="lm", mode="rgb", green="spectrum: {rgb: [0.2, 1, 0.1]}")
run("trace", "rgb.yaml", "-o", "rgb.raymap", "-n", 4000, "--force", "--quiet")
near(ask("detector", "rgb.raymap", "eye", "--where", "source(green)")["flux"]["total"], 1, 1e-4)

# what cannot be is refused, with the remedy
for text, arguments in (("give source 'green' a 'spectrum', or its flux in lm", {"green": "rays_share: 1"}),
                        ("give the flux of source 'lines' in lm", {"mode": "rgb"}),
                        ("lm are no chance", {"table": "response: V"}),
                        ("a chance is 1 at most", {"table": "response: 2"}),
                        ("'response' is V, xyz, a number, or a table", {"table": "response: v"}),
                        ("give 'response', too", {"table": "side: front"})):
    scene("bad.yaml", **arguments)
    told = run("check", "bad.yaml", status=3).stderr
    assert text in told, (text, told)
