#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Light that species absorb and give back: a luminescent concentrator, escape cones, both ways of counting flux.

Concentrator of Fluro Red: Chatten et al. 2004 (doi:10.1134/1.1787111) and pvtrace, counted in photons, at 0.2505 at
the edges, 0.6381 from the faces with what they reflect, 0.1114 lost (3e5 photons, standard error 0.0009).
Cube: sqrt(1 - 1/n^2) of isotropic light leaves a pair of faces never; of a cube of index 1.5 0.236068 is trapped
(Weber & Lambe 1976, doi:10.1364/AO.15.002299). FLU-01, FLU-03 and FLU-04 of the corpus.
"""
import json
import math
import os

import h5py
import numpy

from raymap import Checks, columns, drop, many, rays, run, trace, write_scene

checks = Checks()
CHANNELS = 128
NM = numpy.linspace(400, 800, CHANNELS)


def table(x, y):
    return ("{wavelength: [" + ", ".join(f"{v:.6g}" for v in x) + "], value: ["
            + ", ".join(f"{v:.8g}" for v in y) + "]}")


def slab(size, medium, source, wavelengths, extra=""):
    return f"""raymap: 1
units: cm
spectrum: {{wavelengths: [{", ".join(f"{v:.17g}" for v in wavelengths)}]}}
limits: {{steps: 100000}}
media: {{air: {{index: 1}}, plate: {{{medium}}}}}
surfaces: {{clear: {{type: fresnel}}, black: {{type: absorber}}}}
geometries:
  face: {{type: rectangle, size: [{size[0]}, {size[1]}]}}
  side: {{type: rectangle, size: [{size[1]}, {size[2]}]}}
  long: {{type: rectangle, size: [{size[0]}, {size[2]}]}}
objects:
  - {{name: top, geometry: face, at: [0, 0, {size[2] / 2}], surface: clear, front: air, back: plate}}
  - {{name: bottom, geometry: face, at: [0, 0, {-size[2] / 2}], surface: clear, front: plate, back: air}}
  - {{name: edge.1, geometry: side, at: [{size[0] / 2}, 0, 0], rotate: [90, 0, 90], surface: clear, front: air, back: plate}}
  - {{name: edge.2, geometry: side, at: [{-size[0] / 2}, 0, 0], rotate: [90, 0, 90], surface: clear, front: plate, back: air}}
  - {{name: edge.3, geometry: long, at: [0, {size[1] / 2}, 0], rotate: [90, 0, 0], surface: clear, front: plate, back: air}}
  - {{name: edge.4, geometry: long, at: [0, {-size[1] / 2}, 0], rotate: [90, 0, 0], surface: clear, front: air, back: plate}}
{extra}sources:
  - {source}
"""


def concentrator():
    absorbed = sum(a * numpy.exp(-((b - NM) / c) ** 2) for a, b, c in
                   ((439.06754804627, 549.064388435621, 24.2986016398286), (85.1772928482844, 379.486457974686, 13.5139872790892),
                    (660.173129601724, 519.588589771315, 38.2633520076491), (511.11501615291, 490.056256085927, 52.2132944324645)))
    absorbed *= 11.387815 / absorbed.max()
    a, b, c, d = 1.14777632375847, 592.064788745488, 19.9810403181951, 12.7237040587866
    erf = numpy.vectorize(math.erf)
    emitted = (a * c * math.sqrt(2 * math.pi) / (2 * d) * numpy.exp((b - NM) / d + c * c / (2 * d * d))
               * (1 - erf((b - NM) / (math.sqrt(2) * c) + c / (math.sqrt(2) * d))))
    lamp = (0.530257 * numpy.exp(-((512.914 - NM) / 93.4918) ** 2) + 0.635790 * numpy.exp(-((577.631 - NM) / 66.0317) ** 2))
    scene = slab((4.8, 1.8, 0.25),
                 f"index: 1.5, absorption: 0.02, accounting: photons, species: {{fluro_red: {{absorption: {table(NM, absorbed)},"
                 f" emission: {table(NM, emitted)}, yield: 0.95, redshift: only, lifetime: [{{time: 2 ns, share: 1}}]}}}}",
                 "{name: lamp, type: collimated, shape: {rectangle: [4.8, 1.8]}, at: [0, 0, 1], direction: [0, 0, -1], flux: 1 W,"
                 f" medium: air, spectrum: {table(NM, lamp)}}}", NM)
    target = trace("fluro", scene, many(100_000))
    (edge, escape, lost), n = rays(target, "ended(left) and hit(edge.*, transmit_specular)", "ended(left) and not hit(edge.*, transmit_specular)", "ended(absorbed)")
    checks.true("Fluro Red: every photon", edge + escape + lost == n)
    for name, got, want in (("edges", edge, 0.2505), ("faces", escape, 0.6381), ("lost", lost, 0.1114)):
        checks.z(f"Fluro Red: {name}", got / n, want, math.hypot(math.sqrt(want * (1 - want) / n), 0.0009))
    drop(target)


def stokes():
    """450 nm absorbed, 600 nm given back with a yield of 0.8, by both ways of counting; the same rays."""
    ends = []
    for accounting in ("photons", "energy"):
        text = f"""raymap: 1
units: mm
spectrum: {{wavelengths: [450, 600]}}
media: {{dye: {{index: 1, accounting: {accounting}, species: {{dye: {{absorption: {{wavelength: [450, 600], value: [1, 0]}},
  emission: {{lines: {{600: 1}}}}, yield: 0.8}}}}}}}}
surfaces: {{black: {{type: absorber}}}}
geometries: {{globe: {{type: sphere, radius: 1000}}}}
objects: [{{name: globe, geometry: globe, surface: black, front: dye, back: dye}}]
sources: [{{name: lamp, type: point, at: [0, 0, 0], flux: 1 W, spectrum: {{lines: {{450: 1}}}}, medium: dye}}]
detectors: [{{name: round, type: plane, on: globe, size: [3000, 3000], cells: [1, 1], at: [0, 0, 0], side: both}}]
"""
        target = trace(accounting, text, many(20_000), encoding="plain")
        ids, weight, wavelength = columns(target, "ray/id", "ray/weight", "ray/wavelength")
        ends.append(wavelength[numpy.argsort(ids)])
        given = wavelength == 600
        checks.true(f"{accounting}: weights", (weight[given] == (1 if accounting == "photons" else 0.75)).all()
                    and (weight[~given] == 1).all())
        checks.share(f"{accounting}: yield", given.sum(), len(given), 0.8)
        energy = json.loads(run("report", target, "--energy", "--json"))
        total = energy["total"]
        out = sum(row["flux"] for row in total["absorbed"]["objects"])
        kept = sum(row["flux"] for row in total["absorbed"]["media"])
        share = given.mean()
        checks.close(f"{accounting}: light", out, share * (1 if accounting == "photons" else 0.75), abs=1e-12)
        checks.close(f"{accounting}: not given back", kept, 1 - share, abs=1e-12)
        checks.true(f"{accounting}: adds up", total["exact"])
        if accounting == "energy":
            checks.close("heat of what was given back", total["heat"]["flux"], 0.25 * share, abs=1e-12)
        else:
            checks.true("photons: no heat of its own", "heat" not in total)
        image = json.loads(run("detector", target, "round", "--json"))
        checks.close(f"{accounting}: on the detector", image["flux"]["total"] if isinstance(image["flux"], dict) else image["flux"], out, abs=1e-12)
        run("verify", target)
        drop(target)
    checks.true("both ways: the same rays", (ends[0] == ends[1]).all())


def violet():
    """430 nm in lm, given back at 555 nm, where a photon is worth 67 times as many: squared weights are thousands."""
    text = """raymap: 1
units: mm
spectrum: {wavelengths: [430, 555]}
media: {dye: {index: 1, accounting: energy, species: {dye: {absorption: {wavelength: [430, 555], value: [1, 0]},
  emission: {lines: {555: 1}}, yield: 0.8}}}}
surfaces: {black: {type: absorber}}
geometries: {globe: {type: sphere, radius: 1000}}
objects: [{name: globe, geometry: globe, surface: black, front: dye, back: dye}]
sources: [{name: lamp, type: point, at: [0, 0, 0], flux: 1 lm, spectrum: {lines: {430: 1}}, medium: dye}]
detectors: [{name: round, type: plane, on: globe, size: [3000, 3000], cells: [2, 1], at: [0, 0, 0], side: both}]
"""
    for nm, warned in ((400, True), (430, False)):
        told = json.loads(run("check", write_scene("heavy", text.replace("430", str(nm))), "--json"))["diagnostics"]
        checks.true(f"{nm} nm: warned {told}", any("times as many lumens" in one["text"] for one in told) == warned)
    target, n = trace("violet", text, 20_000, encoding="plain"), 20_000
    (weight, wavelength) = columns(target, "ray/weight", "ray/wavelength")
    checks.true("violet: weights", weight[wavelength == 555].min() == weight.max() > 60)
    index = os.path.join(target, "map.h5")
    with h5py.File(index) as file:
        image, squared = (file["detector/round"][k][:].sum() for k in ("image", "image_squared"))
        rests = file["detector/round/image_squared_rest"][:]
    rest = rests.sum()
    again = trace("violet-again", text, n, options=("--threads", "1"))
    with h5py.File(os.path.join(again, "map.h5")) as file:
        checks.true("violet: on one thread", numpy.array_equal(rests, file["detector/round/image_squared_rest"][:]))
    drop(again)
    given = weight[wavelength == 555]
    checks.close("violet: sum of weights", image, given.sum(), rel=1e-12)
    checks.close("violet: sum of squares", squared + rest, (given ** 2).sum(), rel=1.2e-7)  # parts of 2^-12
    error = math.sqrt(n / (n - 1) * ((given ** 2).sum() - given.sum() ** 2 / n)) / n
    for words in ((), ("--tally",)):
        told = json.loads(run("detector", target, "round", "--json", *words))
        checks.close(f"violet {words}: error", told["flux"]["standard_error"], error, rel=1e-6)
    run("verify", target)
    drop(target)


def cube(n):
    """Isotropic light of a species that absorbs all at 450 nm and nothing at 600 nm; trapped light ends at the limit."""
    want = 3 * math.sqrt(1 - 1 / n ** 2) - 2
    source = ("{name: lamp, type: rays, flux: 1 W, medium: plate, rays: ["
              + ", ".join(f"{{origin: [{x:.4f}, {y:.4f}, {z:.4f}], direction: [0, 0, 1], wavelength: 450}}"
                          for x, y, z in numpy.random.default_rng(1).uniform(-0.49, 0.49, (400, 3))) + "]}")
    scene = slab((1, 1, 1), f"index: {n}, accounting: photons, species: {{dye: {{absorption: {{wavelength: [450, 600], value: [1e4, 0]}},"
                 " emission: {lines: {600: 1}}}}", source, (450, 600)).replace("steps: 100000", "steps: 300")
    target = trace("cube", scene, many(40_000))
    (trapped,), total = rays(target, "ended(limit)")
    checks.share(f"cube of {n}: trapped", trapped, total, want)
    drop(target)


def phosphor():
    """A phosphor: species that scatter. What is absorbed and given back, and what is scattered, all leaves."""
    scene = slab((4, 4, 0.1), "index: 1.5, scattering: {mie: {diameter: 5 um, n: 1.82, share: 0.02}}, accounting: photons,"
                 " species: {YAG: {absorption: {wavelength: [450, 480, 500], value: [40, 30, 0]}, emission: {led: {peak: 560, width: 100}}}}",
                 "{name: led, type: collimated, shape: {disc: 0.2}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W, medium: air,"
                 " spectrum: {lines: {450: 1}}}", [450, *range(500, 701, 20)])
    target = trace("phosphor", scene, many(4000))
    (left, yellow, both), total = rays(target, "ended(left)", "ended(left) and wavelength > 490",
                                       "event(fluoresce) and event(scatter_volume)")
    checks.true("phosphor: no photon is lost", left == total)
    checks.true("phosphor: blue and yellow, scattered", 0.2 * total < yellow < total and both > 0.1 * total)
    drop(target)


concentrator()
stokes()
violet()
cube(1.5)
cube(1.58)
phosphor()
checks.finish()
