#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The random numbers behind the answers: z-scores over seeds are standard normal, reported errors
are the ones that seeds show, errors fall as 1 / sqrt(N), and a seed's rays are the same whoever
traces them.
"""
import json
import math
import shutil

import numpy

from raymap import Checks, columns, count, drop, run, trace, write_scene

checks = Checks()

ROOM = """raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {wall: {type: lambert, reflectance: 0.5}, black: {type: absorber}}
geometries:
  square: {type: rectangle, size: [4, 4]}
objects:
  - {name: floor, geometry: square, at: [0, 0, -2], surface: wall, front: air, back: air}
  - {name: ceiling, geometry: square, rotate: [180, 0, 0], at: [0, 0, 2], surface: wall, front: air, back: air}
  - {name: west, geometry: square, rotate: [0, 90, 0], at: [-2, 0, 0], surface: wall, front: air, back: air}
  - {name: east, geometry: square, rotate: [0, -90, 0], at: [2, 0, 0], surface: wall, front: air, back: air}
  - {name: south, geometry: square, rotate: [-90, 0, 0], at: [0, -2, 0], surface: wall, front: air, back: air}
  - {name: north, geometry: square, rotate: [90, 0, 0], at: [0, 2, 0], surface: wall, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, 0], distribution: isotropic, flux: 10000 lm, spectrum: {rgb: [1, 1, 1]}, medium: air}
"""

# The plate of FRES-05: T and R of n = 1.5168 at normal incidence.
PLATE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}, glass: {index: 1.5168}}
surfaces: {bare: {type: fresnel}}
geometries: {face: {type: disc, radius: 5}}
objects:
  - {name: entry, geometry: face, surface: bare, front: glass, back: air}
  - {name: exit, geometry: face, at: [0, 0, 1], surface: bare, front: air, back: glass}
sources:
  - {name: beam, type: collimated, shape: {disc: 1}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W, spectrum: {lines: {587.56: 1}}, medium: air}
"""
REFLECTED = 0.080917283331097
WALLS = ("floor", "ceiling", "west", "east", "south", "north")


def check_z_scores():
    """Sixty z-scores (six walls, ten seeds): mean within 4 / sqrt(K) of 0, mean |z| within
    4 x 0.603 / sqrt(K) of 0.798, at most one beyond 3. By symmetry each wall absorbs 1/6."""
    n, scores = 10_000, []
    for seed in range(1, 11):
        target = trace("walls", ROOM, n, seed)
        answers = count(target, *[f"ended(absorbed, {w})" for w in WALLS])
        for wall, answer in zip(WALLS, answers):
            p = 1 / 6
            scores.append(checks.share(f"seed {seed}, {wall}", answer["rays"]["matched"], n, p))
        drop(target)
    k = len(scores)
    mean = sum(scores) / k
    spread = sum(abs(z) for z in scores) / k
    checks.true(f"mean z {mean:.3f}", abs(mean) <= 4 / math.sqrt(k))
    checks.true(f"mean |z| {spread:.3f}", abs(spread - 0.798) <= 4 * 0.603 / math.sqrt(k))
    beyond = sum(abs(z) > 3 for z in scores)
    checks.true(f"{beyond} of {k} beyond 3", beyond <= 1)


def check_histograms():
    """Chi-square of where an isotropic source's hundred thousand rays first arrive: uniform in cos(theta) and
    phi; p between 1e-4 and 1 - 1e-4 (Wilson-Hilferty)."""
    text = ROOM.split("objects:")[0] + "sources:" + ROOM.split("sources:")[1]
    target = trace("isotropic", text, 100_000, encoding="plain")
    (end,) = columns(target, "ray/end_direction")
    drop(target)
    bins = (25, 40)
    counts, _, _ = numpy.histogram2d(end[:, 2], numpy.arctan2(end[:, 1], end[:, 0]), bins=bins,
                                     range=((-1, 1), (-math.pi, math.pi)))
    expected = len(end) / counts.size
    k = counts.size - 1
    value = ((counts - expected) ** 2 / expected).sum()
    z = ((value / k) ** (1 / 3) - (1 - 2 / (9 * k))) / math.sqrt(2 / (9 * k))
    checks.z(f"isotropic: chi^2 = {value:.1f} of {k}", z, 0, 1, limit=3.72)


def check_reported_error():
    """Twenty seeds: the variance of the estimates agrees with the one reported, F in [0.4, 2.3]."""
    estimates, reported = [], []
    behind = "detectors: [{name: behind, type: plane, at: [0, 0, 2], direction: [0, 0, -1], size: 10, cells: 1}]\n"
    for seed in range(20):
        traced = json.loads(run("trace", write_scene("plate", PLATE + behind), "--no-record", "-n", 20_000, "--seed", seed, "--json", "--quiet"))
        flux = traced["detectors"][0]["flux"]
        estimates.append(flux["total"])
        reported.append(flux["standard_error"] ** 2)
    ratio = numpy.var(estimates, ddof=1) / numpy.mean(reported)
    checks.true(f"variance of 20 seeds / reported variance = {ratio:.3f}", 0.4 <= ratio <= 2.3)
    checks.true("seeds differ", len(set(estimates)) > 1)


def check_convergence():
    """log2 RMSE against log2 N: slope -0.50 +- 0.08 over N = 5e2 ... 2e4. A ray depends on its id
    alone, so runs of N rays are slices of one long run: a quarter of a million rays give 512 runs of 5e2 ..."""
    total = 262_144
    target = trace("plate", PLATE, total, seed=7, encoding="plain")
    (count_of_legs,) = columns(target, "ray/segment_count")
    (ids,) = columns(target, "ray/id")
    drop(target)
    # An odd number of events before it left: it came back.
    back = (count_of_legs % 2 == 0).astype(float)[numpy.argsort(ids)]
    sizes, errors = [], []
    for power in range(9, 15):
        n = 2 ** power
        means = back[: total // n * n].reshape(-1, n).mean(axis=1)
        sizes.append(power)
        errors.append(0.5 * math.log2(((means - REFLECTED) ** 2).mean()))
    slope = numpy.polyfit(sizes, errors, 1, w=numpy.sqrt([total / 2.0 ** p for p in sizes]))[0]
    checks.true(f"slope {slope:.3f}", abs(slope + 0.5) <= 0.08)


def check_reproducible():
    """Same seed, any threads: the same digest and the same sums. Another seed: another digest."""
    def digest(seed, threads):
        target = "again.raymap"
        shutil.rmtree(target, ignore_errors=True)
        run("trace", write_scene("again", ROOM), "-o", target, "-n", 10_000, "--seed", seed,
            "--threads", threads, "--quiet")
        answer = count(target, "ended(absorbed, floor)")[0]
        info = json.loads(run("info", target, "--json"))
        drop(target)
        return info["digest"], answer["rays"], answer["segments"], answer["flux"]

    first = digest(3, 1)
    checks.true("same seed, same thread", digest(3, 1) == first)
    checks.true("same seed, two threads", digest(3, 2) == first)
    checks.true("another seed", digest(4, 2)[0] != first[0])


check_z_scores()
check_histograms()
check_reported_error()
check_convergence()
check_reproducible()
checks.finish()
