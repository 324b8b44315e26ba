#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A pipe without a writer, or a device without an end, in the place of any file of a map is named as damage; no
command waits for it, and repair leaves a map without findings."""
import os
import pathlib
import shutil
import subprocess
import sys

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
SCENE = SOURCE / "examples/double-gauss/scene.yaml"
failures = 0


def run(what, *words, status):
    global failures
    try:
        done = subprocess.run([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=60, check=False)
        code, said = done.returncode, done.stdout.decode()
    except subprocess.TimeoutExpired:
        code, said = "waits", ""
    if code not in status:
        failures += 1
        print(f"FAIL {what}: {words[0]}: {code}, not of {status}\n{said[-600:]}")


def make(path, *options, **environment):
    shutil.rmtree(path, ignore_errors=True)
    subprocess.run([PROGRAM, "trace", SCENE, "-o", path, "-n", "80000", "--flush-portions", "1", "--quiet", *options],
                   env={**os.environ, **environment}, check=not environment)
    return sorted(file.relative_to(path) for file in pathlib.Path(path).rglob("*")
                  if file.is_file() and "writer" not in file.name)


def put(base, name, kind):
    shutil.rmtree("m.raymap", ignore_errors=True)
    shutil.copytree(base, "m.raymap")
    path = pathlib.Path("m.raymap") / name
    path.unlink()
    os.mkfifo(path) if kind == "pipe" else path.symlink_to("/dev/zero")


def main():
    # Killed before its second commit: rays stand in the journal, and perhaps in the unfinished piece.
    files = [("open.raymap", name) for name in
             make("open.raymap", LD_PRELOAD=os.environ["FAULTS"], FAULTS_DIR=os.getcwd(), FAULTS_CALLS="fdatasync",
                  FAULTS_PATH="*.journal", FAULTS_AT="2", FAULTS_ACTION="kill")]
    files += [("whole.raymap", name) for name in make("whole.raymap", "--encoding", "plain")]
    if [name.suffix for _, name in files].count(".part") != 1 or len(files) < 7:
        sys.exit(f"FAIL: the maps have other files than this test knows: {files}")
    for base, name in files:
        for kind in ("pipe", "device") if name.suffix in (".part", ".journal") else ("pipe",):
            what = f"a {kind} as {base}/{name}"
            put(base, name, kind)
            for command, status in (("info", (0, 4)), ("verify", (4,)), ("repair", (0,)), ("verify", (0,))):
                run(what, command, "m.raymap", status=status)
            put(base, name, kind)
            run(what, "trace", SCENE, "-o", "m.raymap", "--resume", "--quiet", status=(0, 4))
    sys.exit(failures != 0)


main()
