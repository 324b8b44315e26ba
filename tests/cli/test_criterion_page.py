#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/criterion.md, executed: its scene is traced, each example must select the rays that stand
behind its '#', and what its consoles show must be what the program says."""
import json
import os
import pathlib
import re
import subprocess
import sys

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
N_RAY = 12
failures = 0


def fail(text):
    global failures
    failures += 1
    print("FAIL " + text, flush=True)


def blocks(page):
    """(kind, lines) of each fenced block."""
    kind, lines = None, []
    for line in page.splitlines():
        if line.startswith("```"):
            if kind is not None:
                yield kind, lines
            kind, lines = (line[3:], []) if kind is None else (None, [])
        elif kind is not None:
            lines.append(line)


def program(*arguments):
    return subprocess.run([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False)


def wanted(comment):
    if comment == "all rays":
        return list(range(N_RAY))
    return [] if comment == "no ray" else [int(word) for word in comment.split()[1:]]


def check_example(line, options, is_filter):
    text, _, comment = line.rpartition("#")
    text = text.strip()
    asked = ["--zemax", text] if is_filter else [text, *options]
    done = program("query", "page.raymap", *asked, "--limit", "100", "--json")
    if done.returncode != 0:
        return fail(f"{text}: status {done.returncode}\n{done.stderr}")
    rays = [ray["ray"] for ray in json.loads(done.stdout)]
    if rays != wanted(comment.strip()):
        fail(f"{text}: selects {rays}, the page says {comment}")
    return None


def check_console(lines):
    shown = "\n".join(lines)
    for command, expected in re.findall(r"^\$ raymap (.*)\n((?:(?!\$ ).*\n?)*)", shown, re.M):
        done = subprocess.run(f'"{PROGRAM}" {command}', shell=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        if done.stdout.strip() != expected.strip():
            fail(f"raymap {command}\nsays:\n{done.stdout}\nthe page says:\n{expected}")


def main():
    page = (SOURCE / "docs/criterion.md").read_text(encoding="utf-8")
    found = list(blocks(page))
    for kind, name in (("yaml", "page.yaml"), ("obj", "crate.obj"), ("criteria", "names.txt")):
        (text,) = ["\n".join(lines) + "\n" for its, lines in found if its == kind]
        pathlib.Path(name).write_text(text, encoding="utf-8")
    check = program("check", "page.yaml")
    if check.returncode != 0 or check.stderr:
        fail("the page's scene: " + check.stderr)
    trace = program("trace", "page.yaml", "-o", "page.raymap", "-n", str(N_RAY), "--quiet", "--force")
    if trace.returncode != 0:
        sys.exit(trace.stderr)
    n_example = 0
    for kind, lines in found:
        if kind in ("criterion", "zemax"):
            for line in lines:
                n_example += 1
                check_example(line, ["--criteria", "names.txt"], kind == "zemax")
        elif kind == "console":
            check_console(lines)
    print(f"{n_example} examples, {failures} failures")
    sys.exit(1 if failures or n_example < 130 else 0)


main()
