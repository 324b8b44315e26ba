# SPDX-License-Identifier: MIT
"""Runs the program on scenes given as text, in the working directory, and judges what it says.

Every physics test is a script on top of this module: it states the law, where the numbers come
from and how far off an answer may be, and ends with `checks.finish()`.
"""
import glob
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.environ["RAYMAP"]
SCALE = int(os.environ.get("RAYMAP_TEST_SCALE", "1"))
if os.path.samefile(os.getcwd(), os.path.dirname(os.path.abspath(__file__))):
    os.chdir(tempfile.mkdtemp(prefix="raymap-physics-"))  # by hand: scenes stay out of the sources


def many(n):
    """A number of rays; tests/slow multiplies it."""
    return n * SCALE


def some(cases, *quick):
    """Of a matrix all cases for tests/slow; in a quick run those at these places."""
    cases = list(cases)
    return cases if SCALE > 1 else [cases[k] for k in quick]


def run(*arguments):
    """stdout of `raymap ARGUMENTS`; the test ends with its stderr when it fails."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"raymap {' '.join(map(str, arguments))}: status {done.returncode}\n{done.stderr}")
    return done.stdout


def write_scene(name, text):
    path = name + ".yaml"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def report(name, text, ray=0):
    """The history of one ray in double precision, traced again from the scene."""
    return json.loads(run("report", write_scene(name, text), "--ray", ray, "--json"))


def reports(name, text, n):
    """Those of the first n rays, two at least, of one start of the program."""
    return json.loads(run("report", write_scene(name, text), "--rays", f"0..{n - 1}", "--json"))


def trace(name, text, rays, seed=1, options=(), encoding="compact"):
    """Traces a scene into a new map, plain for who reads its columns, and returns its path."""
    target = name + ".raymap"
    shutil.rmtree(target, ignore_errors=True)
    run("trace", write_scene(name, text), "-o", target, "-n", rays, "--seed", seed, "--quiet",
        "--encoding", encoding, *options)
    return target


def drop(target):
    shutil.rmtree(target, ignore_errors=True)


def count(target, *criteria):
    """The JSON of `query --count`, one object per criterion, in one scan."""
    answer = json.loads(run("query", target, *criteria, "--count", "--json"))
    return answer if len(criteria) > 1 else [answer]


def rays(target, *criteria):
    """How many rays match each criterion, and how many there are: ([matched], total)."""
    answers = count(target, *criteria)
    return [a["rays"]["matched"] for a in answers], answers[0]["rays"]["total"]


def columns(target, *names):
    """Whole columns of a plain map, pieces in their order, read by h5py alone."""
    import h5py
    import numpy
    pieces = sorted(glob.glob(os.path.join(target, "shard-*", "piece-*.h5")))
    found = []
    for name in names:
        parts = []
        for piece in pieces:
            with h5py.File(piece, "r") as file:
                parts.append(file[name][:])
        found.append(numpy.concatenate(parts))
    return found


class Checks:
    """Collects comparisons; the worst of each kind is printed, every failure in full."""

    def __init__(self):
        self.n = 0
        self.failures = []
        self.z_scores = []

    def _judge(self, good, line):
        self.n += 1
        if not good:
            self.failures.append(line)
            print("FAIL " + line)

    def close(self, what, got, want, rel=0.0, abs=0.0):
        """|got - want| <= abs + rel |want|, element by element."""
        if isinstance(want, (list, tuple)):
            self._judge(len(got) == len(want), f"{what}: {len(got)} values, not {len(want)}")
            for k, (g, w) in enumerate(zip(got, want)):
                self.close(f"{what}[{k}]", g, w, rel, abs)
            return
        error = math.fabs(float(got) - float(want))
        self._judge(error <= abs + rel * math.fabs(float(want)),
                    f"{what}: got {float(got):.17g}, want {float(want):.17g}, off by {error:.3g}")

    def true(self, what, good):
        self._judge(bool(good), what)

    def z(self, what, got, want, sigma, limit=4.0):
        """A Monte Carlo estimate with standard error sigma."""
        score = (got - want) / sigma
        self.z_scores.append(score)
        self._judge(abs(score) <= limit, f"{what}: got {got:.8g}, want {want:.8g}, z = {score:.2f}")
        return score

    def share(self, what, matched, total, want):
        """`matched` of `total` rays, each with probability `want`: binomial, |z| <= 4."""
        return self.z(what, matched / total, want, math.sqrt(want * (1 - want) / total))

    def finish(self):
        worst = max((abs(z) for z in self.z_scores), default=0.0)
        tail = f", {len(self.z_scores)} z-scores, worst {worst:.2f}" if self.z_scores else ""
        print(f"{self.n} comparisons, {len(self.failures)} failed{tail}")
        sys.exit(1 if self.failures or self.n == 0 else 0)
