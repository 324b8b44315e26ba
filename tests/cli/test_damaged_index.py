#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""One bit of a compact map's history index that is not what it was costs nothing but time: its portion is read by
the piece, whose paths are others in another order, and one line says so with the remedy, or the command ends with
status 4."""
import os
import pathlib
import shutil
import subprocess
import sys

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
COMMANDS = (["paths", "m.raymap"], ["report", "m.raymap", "--html", "out.html"],
            ["draw", "m.raymap", "--where", "registered(sensor)", "-o", "out.html"])
REMEDY = "raymap index m.raymap --force --large"
INDEX = pathlib.Path("shard-00000/piece-00000.history.h5")
FLIPS = 10


def run(words):
    out = pathlib.Path("out.html")
    out.unlink(missing_ok=True)
    done = subprocess.run([PROGRAM, *words, "--quiet", "--threads", "1"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, check=False, timeout=60)
    answer = done.returncode, done.stdout, out.read_bytes() if out.exists() else b""
    return answer, done.stderr.decode().splitlines()


def main():
    for name in ("whole.raymap", "m.raymap"):
        shutil.rmtree(name, ignore_errors=True)
    subprocess.run([PROGRAM, "trace", SOURCE / "examples/double-gauss/scene.yaml", "-o", "whole.raymap", "-n", "20000",
                    "--quiet"], check=True)
    subprocess.run([PROGRAM, "index", "whole.raymap", "--large", "--quiet"], check=True)
    shutil.copytree("whole.raymap", "m.raymap")
    right = [run(words)[0] for words in COMMANDS]
    data, failures = bytearray(("whole.raymap" / INDEX).read_bytes()), 0
    for k in range(FLIPS):
        at, bit = len(data) * (2 * k + 1) // (2 * FLIPS), 1 << k % 8
        data[at] ^= bit
        ("m.raymap" / INDEX).write_bytes(data)
        data[at] ^= bit
        for words, want in zip(COMMANDS, right):
            got, said = run(words)
            if got != want and got[0] != 4:
                failures += 1
                print(f"FAIL byte {at}: {words[0]}: status {got[0]}, another answer")
            # 4: in the places of rays, which are looked at when they are asked for
            if got[0] == 0 and not (len(said) == 1 and f"m.raymap/{INDEX}" in said[0] and REMEDY in said[0]):
                failures += 1
                print(f"FAIL byte {at}: {words[0]}: said {said}")
    done = subprocess.run([PROGRAM, *REMEDY.split()[1:], "--quiet"], check=False)
    answer, said = run(COMMANDS[0])
    if done.returncode != 0 or answer != right[0] or said:
        failures += 1
        print(f"FAIL {REMEDY}: {said}")
    sys.exit(failures != 0)


main()
