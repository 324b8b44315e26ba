#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fluence rate and absorption in voxels (raymap voxels).

Ink of mu = 0.5/cm under a beam of 2 x 2 cm: the fluence rate of a layer is the mean of
E exp(-mu z), and absorbed power mu times that; without ink it is the irradiance. All absorption is
in the grid: its total is the energy report's. A slanted way has the exact length in every voxel
(numpy, by sorting the faces it meets). Tissue of mu_a 0.1, mu_s 100, g 0.9, n 1.37 under air
(case VOL-12; MCML manual, section 6.4): the fluence falls by 1.74069/cm in the depth, 2 %.
"""
import base64
import json
import xml.etree.ElementTree

import h5py
import numpy

from raymap import Checks, columns, count, drop, many, run, trace

checks = Checks()
MU = 0.5


def slab(ink):
    return f"""raymap: 1
units: cm
spectrum: {{mode: spectral, wavelengths: [550]}}
media: {{air: {{index: 1}}, ink: {{index: 1{ink}}}}}
surfaces: {{clear: {{type: fresnel}}, black: {{type: absorber}}}}
geometries: {{face: {{type: rectangle, size: [1000, 1000]}}}}
objects:
  - {{name: in, geometry: face, at: [0, 0, 0], surface: clear, front: ink, back: air}}
  - {{name: out, geometry: face, at: [0, 0, 4], surface: black, front: air, back: ink}}
sources:
  - {{name: beam, type: collimated, shape: {{rectangle: [2, 2]}}, at: [0, 0, -1], direction: [0, 0, 1],
     flux: 4 W, spectrum: {{lines: {{550: 1}}}}, medium: air}}
  - {{name: side, type: collimated, shape: {{rectangle: [2, 2]}}, at: [0, 0, -1], direction: [0, 0, 1],
     flux: 2 W, spectrum: {{lines: {{550: 1}}}}, medium: air}}
"""


def grids(target, region, cells, *options):
    run("voxels", target, f"--region={region}", "--cells", cells, "-o", "grid.h5", "-o", "grid.vti", "--force",
        *options)
    with h5py.File("grid.h5") as file:
        return {name: file[name][()] for name in file}


def vti(path):
    """The arrays of a .vti, read by what VTK says of its files alone."""
    root = xml.etree.ElementTree.parse(path).getroot()
    assert (root.get("byte_order"), root.get("header_type")) == ("LittleEndian", "UInt64")
    image = root.find("ImageData")
    n = [int(x) for x in image.get("WholeExtent").split()][1::2]
    found = {"n": n, "origin": image.get("Origin").split(), "spacing": image.get("Spacing").split()}
    for array in image.find("Piece/CellData"):
        raw = base64.b64decode(array.text)
        size = int.from_bytes(raw[:8], "little")
        found[array.get("Name")] = numpy.frombuffer(raw[8:8 + size], "<f8").reshape(n[::-1])
    return found


# ---- a slab of ink, plain and compact ----
target = trace("slab", slab(f", absorption: {MU}"), many(400_000), encoding="plain")
got = grids(target, "-1,-1,-1,1,1,4", "1x1x10")
edge = numpy.linspace(-1, 4, 11)
faded = numpy.exp(-MU * numpy.maximum(edge, 0)) / -MU + numpy.minimum(edge, 0)
want = 15000 * numpy.diff(faded) / 0.5  # W/m2: 6 W on 4 cm2
passing, error = got["fluence_rate"][:, 0, 0], got["fluence_rate_error"][:, 0, 0]
for k in range(2):
    checks.close(f"irradiance before the ink, layer {k}", passing[k], 15000, 1e-6)
for k in range(2, 10):
    checks.z(f"fluence rate of layer {k}", passing[k], want[k], error[k])
    checks.z(f"absorbed in layer {k}", got["absorbed"][k, 0, 0], MU * 100 * want[k], got["absorbed_error"][k, 0, 0])
checks.true("none absorbed in air", not got["absorbed"][:2].any())
answer = json.loads(run("voxels", target, "--region=-10,-10,-10,10,10,100 mm", "--cells", "7x3x11", "--json"))
absorbed = count(target, "ended(absorbed, ink)", "ended(absorbed, out)")
for name, this in zip(("absorbed", "absorbed_on_surfaces"), absorbed):
    checks.close(f"{name}: as query counts", answer[name]["total"]["value"], this["flux"]["matched"], 1e-12)
    checks.close(f"{name}: its error", answer[name]["total"]["standard_error"], this["flux"]["standard_error"], 1e-9)

# of one source alone, and .vti as .h5
some = grids(target, "-1,-1,-1,1,1,4", "2x2x10", "--where", "source(side)")
checks.close("one source of two", some["fluence_rate"][0].mean(), 5000, 1e-6)
other = vti("grid.vti")
for name in ("fluence_rate", "fluence_rate_error", "absorbed", "absorbed_on_surfaces_error"):
    checks.true(f".vti and .h5: {name}", numpy.array_equal(other[name], some[name]))
checks.true(".vti: where", other["n"] == [2, 2, 10] and [float(x) for x in other["spacing"]] == [1, 1, 0.5]
            and [float(x) for x in other["origin"]] == [-1, -1, -1])
run("convert", target, "-o", "compact.raymap", "--encoding", "compact", "--quiet")
again = grids("compact.raymap", "-1,-1,-1,1,1,4", "2x2x10", "--where", "source(side)")
checks.true("compact and plain: the same bits", all(numpy.array_equal(again[k], some[k]) for k in some))
drop(target)
drop("compact.raymap")

# ---- every way by itself: a slanted scatter of light through a skew grid of voxels ----
target = trace("fan", slab(", scattering: 2, scattering_g: 0.3"), 300, encoding="plain")
low, high, n = numpy.array([-1.5, -0.7, -0.5]), numpy.array([1.1, 2.2, 3.7]), (5, 4, 7)
got = grids(target, ",".join(str(float(x)) for x in (*low, *high)), "x".join(str(x) for x in n))
start, segments, source, out = columns(target, "ray/start", "ray/segment_count", "ray/source", "ray/end_direction")
position, event = columns(target, "segment/position", "segment/event")
step = (high - low) / n
length = numpy.zeros((2, *n))
row = 0
for ray in range(len(segments)):
    at = start[ray].astype(float)
    for segment in range(row, row + segments[ray]):
        to = position[segment].astype(float)
        if event[segment] & 1 << 10:
            to = at + 100 * out[ray].astype(float)
        way = to - at
        with numpy.errstate(divide="ignore", invalid="ignore"):
            t = numpy.concatenate([(low[k] + step[k] * numpy.arange(n[k] + 1) - at[k]) / way[k] for k in range(3)])
        t = numpy.unique(numpy.concatenate([[0, 1], t[(t > 0) & (t < 1)]]))
        for a, b in zip(t[:-1], t[1:]):
            cell = numpy.floor((at + (a + b) / 2 * way - low) / step).astype(int)
            if (cell >= 0).all() and (cell < n).all():
                length[(source[ray], *cell)] += (b - a) * numpy.linalg.norm(way)
        at = to
    row += segments[ray]
emitted = numpy.bincount(source, minlength=2)
want = sum(flux * length[s] / emitted[s] for s, flux in enumerate((4, 2))) / step.prod() * 1e4
worst = abs(got["fluence_rate"].transpose(2, 1, 0) - want).max() / want.max()
checks.true(f"every voxel, by sorted faces: off by {worst:.1e}", worst < 1e-6)
drop(target)

# ---- tissue ----
TISSUE = """raymap: 1
units: cm
spectrum: {mode: spectral, wavelengths: [550]}
limits: {steps: 100000}
media: {air: {index: 1}, tissue: {index: 1.37, absorption: 0.1, scattering: 100, scattering_g: 0.9}}
surfaces: {clear: {type: fresnel}}
geometries: {face: {type: rectangle, size: [400, 400]}}
objects:
  - {name: top, geometry: face, at: [0, 0, 0], surface: clear, front: tissue, back: air}
sources:
  - {name: beam, type: collimated, shape: {disc: 1}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W,
     spectrum: {lines: {550: 1}}, medium: air}
"""
target = trace("tissue", TISSUE, many(12_000))
got = grids(target, "-50,-50,0,50,50,3", "1x1x30")
depth, value = got["z"], got["fluence_rate"][:, 0, 0]
absorbed = got["absorbed"][:, 0, 0]
deep = (depth > 0.5) & (depth < 2.5)
weight = value / got["fluence_rate_error"][:, 0, 0]
slope = -numpy.polyfit(depth[deep], numpy.log(value[deep]), 1, w=weight[deep])[0]
checks.close("decay of the fluence in the depth, 1/cm", slope, 1.74068951855292, 0.02)
checks.true("more fluence below the surface than comes in", value[0] > 1.0)  # 1 W, the layer is 1 m2
ratio = absorbed.sum() / value.sum()
checks.close("absorbed = mu_a times fluence rate", ratio, 10, 0.02)
drop(target)
checks.finish()
