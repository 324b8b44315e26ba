#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap check --schema` describes scene files, so that all examples agree with it, and wrong keys, words and
numbers do not."""
import copy
import json
import os
import pathlib
import subprocess
import sys

try:
    import jsonschema
    import yaml
except ImportError as error:
    print(f"{error}: jobs/install-packages.sh tests installs it")
    sys.exit(77)

EXAMPLES = pathlib.Path(os.environ["SOURCE_DIR"]) / "examples"
schema = json.loads(subprocess.run([os.environ["RAYMAP"], "check", "--schema"], capture_output=True, text=True, check=True).stdout)
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)


def value(node):
    """YAML 1.2 as Raymap reads it: PyYAML's own words would make `on` a truth."""
    if isinstance(node, dict):
        return {key: value(one) for key, one in node.items()}
    if isinstance(node, list):
        return [value(one) for one in node]
    if node in ("true", "false"):
        return node == "true"
    try:
        return float(node)
    except ValueError:
        return node


failures = []
scenes = sorted(EXAMPLES.glob("*/scene.yaml"))
assert len(scenes) >= 5, scenes
for path in scenes:
    scene = value(yaml.load(path.read_text(), Loader=yaml.BaseLoader))
    for error in validator.iter_errors(scene):
        failures.append(f"{path}: {'/'.join(map(str, error.absolute_path))}: {error.message[:300]}")

scene = value(yaml.load((EXAMPLES / "double-gauss" / "scene.yaml").read_text(), Loader=yaml.BaseLoader))
for what, change in {
    "a key of no section": lambda s: s.update(surface={}),
    "a key of no surface": lambda s: s["surfaces"]["black"].update(reflectivity=1),
    "a type that is none": lambda s: s["surfaces"]["black"].update(type="lambertian"),
    "a key of another type": lambda s: s["detectors"][0].update(axis=[0, 0, 1]),
    "a word that is none": lambda s: s["detectors"][0].update(side="left"),
    "a number out of range": lambda s: s.update(limits={"flux": 2.0}),
    "a number that must be above 0": lambda s: s["sources"][0].update(rays_share=0),
}.items():
    wrong = copy.deepcopy(scene)
    change(wrong)
    if validator.is_valid(wrong):
        failures.append(f"{what} is not refused")
print("\n".join(failures) or f"{len(scenes)} scenes agree with the schema")
sys.exit(bool(failures))
