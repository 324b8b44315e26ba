#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Times of arrival: group index, refraction through a tilted plate, gradient media, encodings.

Fused silica by Malitson 1965 (doi:10.1364/JOSA.55.001205): over 1 m light of 300 nm arrives 0.3148 ns
after light of 600 nm (its phase 0.0993 ns). Through a tilted plate: Snell's law, then lengths by group
index. Along the axis of a gradient rod: quadrature of n - wavelength dn/dwavelength.
"""
import json

import numpy

from raymap import Checks, columns, drop, run, trace

checks = Checks()


def near(what, got, want, most):
    checks.true(f"{what}: {got!r}, not {want!r}", abs(got - want) <= most)


C = 299792458.0
B, POLE = (0.6961663, 0.4079426, 0.8974794), (0.0684043, 0.1162414, 9.896161)
NM = numpy.array([300.0, 600.0])
RAYS = 2000


def silica(nm):
    l2 = (nm * 1e-3) ** 2
    return numpy.sqrt(1 + sum(b * l2 / (l2 - p * p) for b, p in zip(B, POLE)))


def group(index, nm, h=1e-3):
    slope = (8 * (index(nm + h) - index(nm - h)) - (index(nm + 2 * h) - index(nm - 2 * h))) / (12 * h)
    return index(nm) - nm * slope


HEAD = f"""raymap: 1
units: m
spectrum: {{wavelengths: [300, 600]}}
media:
  air: {{index: 1}}
  silica: {{sellmeier: {{B: {list(B)}, C: {[p * p for p in POLE]}}}}}
  table: {{table: {{wavelength: {list(range(200, 1001, 50))}, n: {[float(silica(w)) for w in range(200, 1001, 50)]}}}}}
  rod: {{gradient: {{type: axial, coefficients: [1.5, 0.1, 0.02], dispersion: {{sellmeier: {{B: {list(B)}, C: {[p * p for p in POLE]}}},
        mode: multiplicative}}}}}}
surfaces: {{black: {{type: absorber}}, lens: {{type: fresnel, coat: ideal}}}}
geometries: {{sheet: {{type: rectangle, size: [4, 4]}}, tube: {{type: cylinder, radius: 0.5, length: 1, closed: true}}}}
sources:
  - {{name: s, type: collimated, shape: {{disc: 0.1}}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W, medium: air}}
detectors:
  - {{name: d, type: plane, on: end, side: both, cells: 1}}
  - {{name: free, type: plane, at: [0, 0, 2], direction: [0, 0, -1], size: [4, 4], cells: [1, 1]}}
simulations: [{{name: t, time: on}}, {{name: phase, time: off}}]
objects:
  - {{name: end, geometry: sheet, surface: black, at: [0, 0, 3], front: air, back: air}}
"""


def plate(tilt, medium):
    turned = f"rotate: [{tilt}, 0, 0], surface: lens"
    thick = f"at: [0, {-numpy.sin(numpy.radians(tilt)):.17g}, {numpy.cos(numpy.radians(tilt)):.17g}]"
    return HEAD + f"""  - {{name: a, geometry: sheet, at: [0, 0, 0], {turned}, front: {medium}, back: air}}
  - {{name: b, geometry: sheet, {thick}, {turned}, front: air, back: {medium}}}
"""


def arrivals(name, text, *options):
    """By wavelength: group path at the end, at the free plane, and optical path at the end, all alike."""
    target = trace(name, text, RAYS, options=("--simulation", "t", *options), encoding="plain")
    nm, of_ray, count = columns(target, "ray/wavelength", "ray/group_path", "ray/registration_count")
    path, phase, delay = columns(target, "registration/group_path", "registration/optical_path",
                                 "registration/delay")
    checks.true(f"{name}: two registrations of each, without delays", (count == 2).all() and not delay.any())
    found = []
    for wavelength in NM:
        at = numpy.flatnonzero(nm == wavelength)
        checks.true(f"{name}: about half of {wavelength}", abs(len(at) - RAYS / 2) < 4 * RAYS ** 0.5)
        values = (path[2 * at + 1], path[2 * at], phase[2 * at + 1])
        checks.true(f"{name}: all alike", all(numpy.ptp(v) < 1e-12 for v in values)
                    and (of_ray[at] == values[0]).all())
        found.append([v[0] for v in values])
    answer = json.loads(run("stats", target, "--of", "time(d)", "--unit", "ns", "--json"))
    near(f"{name}: mean time", answer["mean"]["value"], path[1::2].mean() / C * 1e9, 1e-9)
    checks.true(f"{name}: no word of the phase", "time" not in answer)
    digests = []
    for copy in (target, convert(target)):
        run("verify", copy)
        digests.append(json.loads(run("info", copy, "--json"))["digest"])
    checks.true(f"{name}: the same rays in both encodings", digests[0] == digests[1])
    drop(target)
    return numpy.array(found)


def convert(target):
    drop("again.raymap")
    run("convert", target, "-o", "again.raymap", "--encoding", "compact")
    return "again.raymap"


found = arrivals("silica", plate(0, "silica"))
near("1 m of silica, ns apart", (found[0, 0] - found[1, 0]) / C * 1e9, 0.3148, 5e-5)
near("phase, ns apart", (found[0, 2] - found[1, 2]) / C * 1e9, 0.0993, 5e-5)
for k, nm in enumerate(NM):
    near(f"group path at {nm}", found[k, 0], 3 + group(silica, nm), 1e-9)
    near(f"at the free plane, {nm}", found[k, 1], 2 + group(silica, nm), 1e-9)
found = arrivals("table", plate(0, "table"))
near("a table of 50 nm, at 300", found[0, 0], 3 + group(silica, 300.0), 2e-5)
near("a table of 50 nm, at 600", found[1, 0], 3 + group(silica, 600.0), 1e-5)

TILT = numpy.radians(30)
found = arrivals("tilted", plate(30, "silica"))
for k, nm in enumerate(NM):
    inside = numpy.arcsin(numpy.sin(TILT) / silica(nm))
    way = 1 / numpy.cos(inside)
    near(f"tilted plate at {nm}", found[k, 0], 4 - way * numpy.cos(TILT - inside) + way * group(silica, nm),
                1e-7)

ROD = HEAD + "  - {name: rod, geometry: tube, at: [0, 0, 0], surface: lens, inside: rod, outside: air}\n"
found = arrivals("rod", ROD)
node, weight = numpy.polynomial.legendre.leggauss(20)
z = 0.5 * (node + 1)
reference = silica(587.56)
for k, nm in enumerate(NM):
    field = 1.5 + 0.1 * z + 0.02 * z ** 2
    near(f"rod at {nm}", found[k, 0],
                3 + (0.5 * weight * field * group(lambda w: silica(w) / reference, nm)).sum(), 1e-7)
    near(f"rod's phase at {nm}", found[k, 2], 3 + (0.5 * weight * field * silica(nm) / reference).sum(), 1e-7)

# Without times: the phase, and it says so; group paths are refused with the remedy.
scene = plate(0, "silica")
target = trace("phase", scene, RAYS, options=("--simulation", "phase"))
answer = json.loads(run("stats", target, "--of", "time(d)", "--json"))
checks.true("phase", answer["time"] == "phase")
checks.finish()
