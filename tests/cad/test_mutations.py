#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""STEP and IGES files of a stranger through `raymap import` and `update`: entities that refer to others, to themselves, or are not there;
numbers that are none; lines cut, doubled, taken away. Whatever OpenCASCADE makes of them, it ends soon, in a scene that can be read or in an
error that names the file, and leaves nothing behind; a folder that was there stays as it was. Seeds are fixed: MUTATIONS is how many per file."""
import os
import pathlib
import random
import re
import shutil
import subprocess
import time

from cad_tools import MAKER, SLOW, check, finish  # skips where there is no converter

N, SECONDS = int(os.environ.get("MUTATIONS", "12" if SLOW else "2")), 90
count = {"scene": 0, "refused": 0, "crashed": 0}
NUMBERS = ["0.", "-0.", "1.E308", "-1.E-308", "NAN", "1.E400", "3.14159265358979", "-7", "", "$", "*", "1.E12"]


def mutate_step(text, dice):
    head, data = text.split("DATA;\n", 1)
    lines = data.split("\n")
    numbered = [k for k, line in enumerate(lines) if line.startswith("#")]
    ids = [lines[k].split("=")[0].strip() for k in numbered]
    for _ in range(dice.choice([1, 1, 2, 5])):
        k = dice.choice(numbered)
        line, way = lines[k], dice.randrange(8)
        refers = list(re.finditer(r"#\d+", line.partition("=")[2]))
        values = list(re.finditer(r"-?\d+\.(?:E[+-]?\d+)?\d*", line))
        if way < 3 and refers:
            at = dice.choice(refers)
            other = dice.choice(ids) if way else line.split("=")[0].strip()
            start = line.index("=") + 1
            lines[k] = line[:start + at.start()] + other + line[start + at.end():]
        elif way < 5 and values:
            at = dice.choice(values)
            lines[k] = line[:at.start()] + dice.choice(NUMBERS) + line[at.end():]
        elif way == 5:
            lines[k] = ""
        elif way == 6:
            lines[k] = line + "\n" + lines[dice.choice(numbered)]
        else:
            lines[k] = line[:dice.randrange(len(line) + 1)]
    if dice.randrange(8) == 0:
        del lines[dice.randrange(len(lines)):]
    return head + "DATA;\n" + "\n".join(lines)


def mutate_iges(text, dice):
    lines = text.split("\n")
    for _ in range(dice.choice([1, 2, 4])):
        k = dice.randrange(4, len(lines))
        line = lines[k]
        values = list(re.finditer(r"-?\d+(?:\.\d*)?", line[:64]))
        if values and dice.randrange(4):
            at = dice.choice(values)
            lines[k] = line[:at.start()] + dice.choice(NUMBERS + [str(dice.randrange(400))])[:len(at.group())].rjust(len(at.group())) + line[at.end():]
        elif dice.randrange(2):
            lines[k] = lines[dice.randrange(4, len(lines))]
        else:
            del lines[k]
    return "\n".join(lines)


def files_of(folder):
    return {p.relative_to(folder): p.read_bytes() for p in pathlib.Path(folder).rglob("*") if p.is_file()}


def try_one(name, what):
    shutil.rmtree("scene", ignore_errors=True)
    for words, folder in ((["import", name, "-o", "scene", "--quiet"], None), (["update", "kept", name, "--force", "--quiet"], "kept")):
        before, start = files_of(folder) if folder else None, time.monotonic()
        try:
            done = subprocess.run([os.environ["RAYMAP"], *words], text=True, capture_output=True, check=False, timeout=SECONDS, errors="replace")
        except subprocess.TimeoutExpired:
            check(False, f"{what}: {words[0]} hangs")
            continue
        spent = time.monotonic() - start
        check(done.returncode in (0, 3) and spent < SECONDS, f"{what}: {words[0]}: {done.returncode} in {spent:.0f} s: {done.stderr}")
        if done.returncode == 0:
            count["scene"] += 1
            scene = subprocess.run([os.environ["RAYMAP"], "check", f"{words[3] if not folder else folder}/scene.yaml"], capture_output=True,
                                   check=False, timeout=SECONDS)
            check(scene.returncode in (0, 3), f"{what}: check: {scene.returncode}")
            if folder:
                shutil.rmtree(folder)
                shutil.copytree("kept0", folder)
            continue
        last = done.stderr.strip().split("\n")[-1]
        count["crashed" if "signal" in last else "refused"] += 1
        check(last.startswith("raymap: ") and name in last, f"{what}: {words[0]} says {done.stderr!r}")
        check(not folder or files_of(folder) == before, f"{what}: the folder is not as it was")
        check(folder or not os.path.exists("scene"), f"{what}: a folder is left")
        return  # the update would say the same


os.makedirs("cad", exist_ok=True)
subprocess.run([MAKER, "cad"], check=True)
for folder in ("kept", "kept0"):
    shutil.rmtree(folder, ignore_errors=True)
subprocess.run([os.environ["RAYMAP"], "import", "cad/luminaire.step", "-o", "kept0", "--quiet"], check=True)
shutil.copytree("kept0", "kept")
for source, mutate in (("cad/luminaire.step", mutate_step), ("cad/biconvex.step", mutate_step), ("cad/lens-brep.igs", mutate_iges)):
    whole = pathlib.Path(source).read_text(encoding="latin-1")
    for seed in range(N):
        name = "strange" + pathlib.Path(source).suffix
        pathlib.Path(name).write_text(mutate(whole, random.Random(f"{source} {seed}")), encoding="latin-1")
        try_one(name, f"{source} {seed}")
print(f"{3 * N} mutated files: {count}")
check(count["scene"] > N and count["refused"] > 0, f"mutations reach both ends: {count}")
finish()
