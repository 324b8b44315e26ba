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


def parse(line):
    """The criterion of an example and the rays that it says."""
    text, _, comment = line.rpartition("#")
    return text.strip(), wanted(comment.strip())


def select(*asked):
    done = program("query", "page.raymap", *asked, "--limit", "100", "--json")
    if done.returncode != 0:
        return done.stderr
    return [ray["ray"] for ray in json.loads(done.stdout)]


def check_examples(examples):
    """All in one call: how many rays match, as the line stands there, and how many of those that
    should."""
    asked = []
    for line, text, rays in examples:
        asked += [line, f"({text}) and ({' or '.join(f'ray == {k}' for k in rays) or 'ray < 0'})"]
    done = program("query", "page.raymap", *asked, "--criteria", "names.txt", "--count", "--json")
    if done.returncode != 0:
        return fail(done.stderr)
    count = [answer["rays"]["matched"] for answer in json.loads(done.stdout)]
    for i, (_, text, rays) in enumerate(examples):
        if count[2 * i] != len(rays) or count[2 * i + 1] != len(rays):
            fail(f"{text}: selects {select(text, '--criteria', 'names.txt')}, the page says {rays}")
    return None


HINTS = [("registered(sensor, rect(50, 0, 60, 5))", "'sensor' reaches from -18 to 18 and from -12 to 12"),
         ("hit(lens) and registered(sensor, ellipse(0, 30, 5, 5))", "'sensor' reaches from -18 to 18"),
         ("registered(sensor, polygon(19, 0, 20, 0, 20, 1))", "lies outside"),
         ("registered(sensor, rect(1.1, 0, 1.2, 1, rel))", "'sensor' reaches from 0 to 1"),
         ("registered(far, rect(190 deg, 0 deg, 200 deg, 9 deg))", "'far' reaches from 0 to 180"),
         ("registered(sensor, cells(36, 0))", "'sensor' has cells 0..35, 0..23"),
         ('path("T@lens.2 A")', 'wherever in it: path(".* T@lens.2 A .*")'),
         ('path("T@lens.2 A .*") and hit(lens)', 'wherever in it: path(".* T@lens.2 A .*")'),
         ('registered(sensor where path("T@lens.2 V"))', 'its registration; wherever in it: path(".* T@lens.2 V")'),
         ("registered(sensor where time > 1)", "a time without a unit is in seconds"),
         ("time(sensor) > 0.2", "a time without a unit is in seconds"),
         ("time(sensor) > 0.2 ns", None), ("registered(sensor, rect(17, 11, 18, 12))", None),
         ('path(".* E .*")', None), ("not registered(sensor, rect(50, 0, 60, 5)) and ended(error)", None),
         ("registered(sensor, rect(50, 0, 60, 5)) == 0 and ended(error)", None), ("all", None)]


def check_hints():
    """An answer of 0 comes with a hint on stderr where one can be given, and JSON as ever."""
    for text, words in HINTS:
        plain, quiet = (program("query", "page.raymap", text, "--count", "--json", *more) for more in ((), ("-q",)))
        if ("no ray matches" in plain.stderr) != (words is not None) or (words or "") not in plain.stderr:
            fail(f"{text}: the hint is {plain.stderr!r}, not {words!r}")
        answers = [json.loads(done.stdout) for done in (plain, quiet)]
        for answer in answers:
            del answer["seconds"]
        if answers[0] != answers[1] or quiet.stderr or (answers[0]["rays"]["matched"] == 0) != (text != "all"):
            fail(f"{text}: {answers} {quiet.stderr}")
    missed, words = HINTS[0]
    for more in (("detector", "sensor"), ("stats", "--of", "bounces"), ("stats", "--of", "x(sensor)"), ("paths",),
                 ("paths", "--detector", "sensor")):
        for quiet in ((), ("-q",)):
            said = program(more[0], "page.raymap", *more[1:], "--where", missed, *quiet).stderr
            if (words in said) != (not quiet):
                fail(f"{more}: the hint is {said!r}, not {words!r}")
    talk = subprocess.run([PROGRAM, "session", "page.raymap"], input='path("T@lens.2 A")\n', capture_output=True,
                          text=True, check=False)
    if "wherever in it" not in talk.stderr:
        fail(f"a session hints {talk.stderr!r}")


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
    if check.returncode != 0 or "error" in check.stderr:  # a source there hits nothing, as it should
        fail("the page's scene: " + check.stderr)
    trace = program("trace", "page.yaml", "-o", "page.raymap", "-n", str(N_RAY), "--quiet", "--force")
    if trace.returncode != 0:
        sys.exit(trace.stderr)
    examples = [(line, *parse(line)) for kind, lines in found if kind == "criterion" for line in lines]
    check_examples(examples)
    check_hints()
    for kind, lines in found:
        if kind == "console":
            check_console(lines)
        for text, rays in map(parse, lines) if kind == "zemax" else ():
            if select("--zemax", text) != rays:
                fail(f"{text}: selects {select('--zemax', text)}, the page says {rays}")
    print(f"{len(examples)} examples, {failures} failures")
    sys.exit(1 if failures or len(examples) < 125 else 0)


main()
