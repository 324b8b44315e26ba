#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Criteria that nobody would write: each is answered or refused with a place, and in good time."""
import os
import pathlib
import resource
import subprocess
import sys
import time

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
PROCESSOR_SECONDS = 10  # on any machine: what is quadratic needs more
STACK = 4 << 20  # half of what there usually is
SECONDS = 60  # on a machine with other work; none takes more than a few on one without
failures = 0


def bound():
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS))
    if not os.environ.get("ASAN_OPTIONS"):
        resource.setrlimit(resource.RLIMIT_STACK, (STACK, STACK))


def ask(name, status, word, *arguments, file=None):
    """`word` must stand in what the program says."""
    global failures
    if file is not None:
        pathlib.Path("file.txt").write_bytes(file if isinstance(file, bytes) else file.encode())
        arguments += ("--criteria", "file.txt")
    begun = time.monotonic()
    try:
        done = subprocess.run([PROGRAM, "query", "map.raymap", *arguments], timeout=SECONDS, preexec_fn=bound,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        code, said = done.returncode, done.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired:
        code, said = None, f"no answer within {SECONDS} s"
    print(f"{name}: status {code}, {time.monotonic() - begun:.1f} s", flush=True)
    if code != status or word not in said:
        failures += 1
        print(f"FAIL {name}: expected {status} and '{word}'\n{said[:600]}", flush=True)


def let(text):
    return "let a = " + text


def main():
    scene = SOURCE / "examples/double-gauss/scene.yaml"
    subprocess.run([PROGRAM, "trace", scene, "-o", "map.raymap", "-n", "5000", "--quiet",
                    "--force"], check=True)
    ask("empty", 3, "the criterion is empty", "")
    ask("blank", 3, "the criterion is empty", " \n ")
    ask("no file", 3, "cannot open nowhere.txt", "all", "--criteria", "nowhere.txt")
    ask("a folder", 3, "is a directory", "all", "--criteria", "map.raymap")
    ask("empty file", 3, "is empty", file="")
    ask("comment alone", 3, "file.txt:2:1: error: expected 'let", file="# nothing\n")
    ask("binary file", 3, "is binary", file=bytes(range(256)) * 64)
    ask("no UTF-8", 3, "file.txt:1:9: error: this is not UTF-8", file=b"let a = \xff\xfe")
    ask("no UTF-8 argument", 3, "criterion:1:5: error: this is not UTF-8", b"hit(\xff)")
    ask("random bytes", 3, "error", file=b"let a = " + os.urandom(100000).replace(b"\0", b"."))
    ask("20 MiB", 3, "16 MiB at most", file=" " * (20 << 20))

    term = "hit(lens.3, reflect) and "
    ask("1 MB of tests", 0, "rays", file=let(term * (1000000 // len(term)) + "all"))
    ask("1 MB of one word", 3, "too long for a name", file=let("a" * 1000000))
    ask("1 MB of blanks", 0, "5,000 of 5,000", file=let(" " * 1000000 + "all"))
    ask("1 MB of numbers", 3, "too long", file=let("flux > " + "1" * 1000000))
    ask("1 MB of not", 0, "rays", file=let("!" * 1000000 + "all"))
    ask("1 MB of path", 3, "this path is too complex",
        file=let('path("' + "T@lens.1 " * 110000 + '")'))
    ask("10,000 terms", 0, "rays",
        file=let(" or ".join(f"hit(lens.{i % 9 + 1}, reflect) == {i}" for i in range(10000))))
    ask("10,000 definitions", 0, "rays", "@d9999",
        file="".join(f"let d{i} = segments > {i}\n" for i in range(10000)))
    ask("100,000 definitions", 0, "5,000 of 5,000", "@d99999",
        file="".join(f"let d{i} = all\n" for i in range(100000)))
    ask("10,000 paths", 0, "rays", file=let(" or ".join('path("R{3}T")' for _ in range(10000))))
    ask("1,000 parentheses", 0, "5,000 of 5,000", "(" * 1000 + "all" + ")" * 1000)
    ask("100,000 parentheses", 3, "more than 2000 nested", file=let("(" * 100000))
    ask("1,000 parentheses of a path", 0, "rays", 'path("' + "(" * 1000 + "T" + ")" * 1000 + '")')
    ask("100,000 parentheses of a path", 3, "more than 2000 nested",
        file=let('path("' + "(" * 100000 + '")'))
    ask("{1,100000}", 3, "this path is too complex", 'path(".{1,100000}")')
    ask("{1,10000}", 0, "5,000 of 5,000", 'path(".{1,10000}")')
    ask("{100}{100}{100}", 3, "this path is too complex", 'path("(((T{100}){100}){100})")')
    ask("states that double", 3, "more than 16384 states", 'path(".*R.{30}")')
    ask("paths of long work", 3, "more than 67108864 steps of work",
        file=let(" or ".join(f'path("(T?){{{1500 + i}}}A")' for i in range(200))))
    ask("many names", 3, "no object",
        file=let('path("' + "|".join(f"T@x{i}" for i in range(3000)) + '")'))
    ask("definitions that double", 3, "more than 100000 tests", "@d59",
        file="let d0 = all\n" + "".join(f"let d{i} = @d{i-1} and @d{i-1}\n" for i in range(1, 60)))
    ask("definitions in a row", 3, "more than 2000 deep", "@d4999",
        file="let d0 = all\n" + "".join(f"let d{i} = @d{i-1}\n" for i in range(1, 5000)))
    ask("a filter that doubles", 3, "too long", "--zemax", "^".join(["H1"] * 2000))
    sys.exit(1 if failures else 0)


main()
