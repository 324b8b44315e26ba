#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""No name of a stranger's scene, map, folder or argument steers the terminal: it is shown escaped.
JSON gives it as it is, by JSON's own escapes."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import sealed_map

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
NAME = "\x9b31m\u202ed"  # red by a C1 control, right to left; a scene's names have no C0
EVIL = "\x1b]0;x\x07" + NAME  # and a title
SHOWN = "\\u202ed"
STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
                    "\udc80-\udcff]")
failures = 0


def run(*arguments, status=0, shown=True):
    """What it printed, on either stream; `shown`: the name stands there."""
    global failures
    done = subprocess.run([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False, timeout=120)
    said = done.stdout.decode(errors="surrogateescape")
    steers = STEERS.search(said)
    if done.returncode != status or steers or shown != (SHOWN in said):
        failures += 1
        print(f"FAIL {arguments}: status {done.returncode}, steered at {steers}\n{said!r}")
    return said


def strings(value):
    if isinstance(value, dict):
        value = [*value, *value.values()]
    return [value] if isinstance(value, str) else [
        text for item in value for text in strings(item)] if isinstance(value, list) else []


def forge(file):
    attributes = file.attrs
    for name in [n for n in attributes if isinstance(attributes[n], (str, bytes))]:
        if "version" in name or "revision" in name:
            attributes.modify(name, EVIL.encode())


def main():
    text = (SOURCE / "examples/double-gauss/scene.yaml").read_text()
    name = json.dumps(NAME)  # YAML reads it, too
    pathlib.Path("scene.yaml").write_text(text.replace("{name: sun,", "{name: " + name + ","))
    folder = EVIL + ".raymap"
    shutil.rmtree(folder, ignore_errors=True)

    run("check", "scene.yaml")
    run("trace", "scene.yaml", "-o", folder, "-n", "3000")
    run("trace", "scene.yaml", "-o", folder, "-n", "3000", status=2)
    run("info", folder)
    run("query", folder, f"source(@{NAME})", status=3)
    run("report", folder, "--energy")
    run("report", "scene.yaml", "--ray", "2999")
    run("query", folder, "source(*)", "--limit", "9", "--json")
    run(EVIL, status=2)
    run("info", EVIL, status=3)
    if NAME not in strings(json.loads(run("info", folder, "--json"))):
        sys.exit("FAIL: JSON has another name")
    sealed_map.edit(pathlib.Path(folder) / "map.h5", forge)
    if run("info", folder).count("\\u001b]0;x") < 4:  # in as many bytes as the versions had
        sys.exit("FAIL: the forged version is not shown")
    sys.exit(failures != 0)


main()
